//! Reads a scene file with its includes; each field is taken from the last file that gives it.

use super::diagnose::{Diagnosis, explain};
use super::dialect::options;
use super::field_positions::{Origins, SceneText};
use super::lint::lint;
use super::outline::{MAX_VALUES, Outline};
use super::paths;
use super::schema::ScenePart;
use super::source::{self, MAX_TOTAL_SIZE};
use base::error::{Error, Result};
use base::files::include::check_include;
use std::path::{Path, PathBuf};

/// Reader of a scene file and of all that it includes.
#[derive(Default)]
pub(super) struct Loader {
    /// Files read so far.
    pub(super) sources: Vec<SceneText>,
}

impl Loader {
    /// Reads the scene file `path` with all its includes. Returns its fields, and for each given field the index of its
    /// file in `sources`. `chain` holds the files being read, outermost first, to detect cycles. `from` is the index of
    /// the including file and the position of `path` in its list of includes; None for the outermost file.
    ///
    /// # Errors
    /// Fails for a file that cannot be read, is invalid, includes itself, or exceeds the limits of a scene; the message
    /// states file, line and column where they are known.
    pub(super) fn read_tree(
        &mut self,
        path: &Path,
        chain: &mut Vec<PathBuf>,
        from: Option<(usize, usize)>,
    ) -> Result<(ScenePart, Origins)> {
        let text = match (source::read(path, from.is_none()), from) {
            (Ok(text), _) => text,
            (Err(e), None) => return Err(e),
            (Err(e), Some((parent, place))) => {
                let message = e.to_string().trim_start_matches("error: ").to_string();
                return Err(self.sources[parent].error_at(&format!("include[{place}]"), &message));
            }
        };
        let index = self.sources.len();
        if self.sources.iter().map(|s| s.text.len()).sum::<usize>() + text.len() > MAX_TOTAL_SIZE as usize {
            let message = format!(
                "{} and the files before it are together larger than {} MiB",
                path.display(),
                MAX_TOTAL_SIZE >> 20
            );
            return Err(Error::Scene(format!("error: {message}, the limit for a scene")));
        }
        self.sources.push(SceneText { path: source::display_path(path).to_path_buf(), text });
        let source = &self.sources[index];
        let mut own = read_part(source)?;
        let dir = folder(path);
        paths::resolve(&mut own, &dir, &source.text).map_err(|(field, message)| source.error_at(&field, &message))?;

        chain.push(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()));
        let (mut whole, mut origins) = (ScenePart::default(), Origins::new());
        for (i, name) in std::mem::take(&mut own.include).iter().enumerate() {
            let included = dir.join(name);
            check_include(&included, chain, self.sources.len())
                .map_err(|m| self.sources[index].error_at(&format!("include[{i}]"), &m))?;
            let (part, theirs) = self.read_tree(&included, chain, Some((index, i)))?;
            whole.merge(part);
            origins.extend(theirs);
        }
        chain.pop();
        origins.extend(own.given_fields().into_iter().map(|field| (field, index)));
        whole.merge(own);
        Ok((whole, origins))
    }
}

/// Reads one file without its includes.
fn read_part(source: &SceneText) -> Result<ScenePart> {
    let outline = Outline::of(&source.text);
    if outline.is_empty() {
        let message =
            "the scene is empty\na minimal scene: (object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 15))";
        return Err(source.error(&Diagnosis::new(message, 0..0)));
    }
    if outline.is_full() {
        let message = format!(
            "the scene contains more than {MAX_VALUES} values, the limit for a scene file\nput long lists of grasps \
             into a file: grasps: File(\"x_grasps.h5\")"
        );
        return Err(source.error(&Diagnosis::new(&message, 0..0)));
    }
    let part = options().from_str(&source.text).map_err(|e| source.error(&explain(&e, &source.text, &outline)))?;
    lint(&source.text, &outline).map_err(|d| source.error(&d))?;
    Ok(part)
}

/// Returns the folder that relative paths in the scene file `path` refer to: the folder of the file, or the working
/// directory (an empty path) for standard input.
pub(super) fn folder(path: &Path) -> PathBuf {
    path.parent().filter(|_| !source::is_stream(path)).map(Path::to_path_buf).unwrap_or_default()
}
