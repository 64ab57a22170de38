//! Reads a scene file with its includes: `path -> Scene`, or one error that shows the line and says what is allowed.

use super::check;
use super::diagnose::{Diagnosis, explain};
use super::grasps::Grasps;
use super::lint::lint;
use super::object::{Object, Shape};
use super::objects::{Name, NamedScene, Split};
use super::outline::Outline;
use super::pad::Pads;
use super::schema::{Part, Scene};
use super::source;
use super::stepper::Stepper;
use crate::error::{Error, Result};
use ron::extensions::Extensions;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Longest chain of includes.
pub const INCLUDE_DEPTH: usize = 16;
/// Most files one scene may read: includes that include each other's includes multiply.
pub const INCLUDE_FILES: usize = 256;

/// A scene and where it came from.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The complete scene; paths in it work from the current directory.
    pub scene: Scene,
    /// The scene file.
    pub path: PathBuf,
    /// Its folder.
    pub dir: PathBuf,
    /// All files read, the scene file first, then its includes.
    pub sources: Vec<PathBuf>,
}

/// All scenes of a file: one per object.
#[derive(Debug, Clone)]
pub struct LoadedSet {
    /// The scenes, in the order of the file; at least one. Paths in them work from the current directory.
    pub scenes: Vec<NamedScene>,
    /// How the poses are shared out between training and test.
    pub split: Split,
    /// The scene file.
    pub path: PathBuf,
    /// All files read, the scene file first, then its includes.
    pub sources: Vec<PathBuf>,
}

/// Loads a scene file of one object. The error is an [`Error::Scene`] ready to print.
pub fn load(path: impl AsRef<Path>) -> Result<Loaded> {
    load_object(path, None)
}

/// Loads one object's scene out of a scene file; None is the only one that there is.
pub fn load_object(path: impl AsRef<Path>, object: Option<&str>) -> Result<Loaded> {
    let mut set = load_set(path)?;
    let names = || set.scenes.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
    let refuse = |message: String| Err(Error::Scene(format!("error: {}: {message}", set.path.display())));
    let index = match object {
        None if set.scenes.len() == 1 => 0,
        None => return refuse(format!("has several objects; choose one with --object: {}", names())),
        Some(name) => match set.scenes.iter().position(|s| s.name.as_str() == name) {
            Some(index) => index,
            None => return refuse(format!("has no object {name:?}; it has: {}", names())),
        },
    };
    let scene = set.scenes.swap_remove(index).scene;
    Ok(Loaded { scene, dir: folder(&set.path), path: set.path, sources: set.sources })
}

/// Loads all scenes of a file, one per object. The error is an [`Error::Scene`] ready to print.
pub fn load_set(path: impl AsRef<Path>) -> Result<LoadedSet> {
    let path = path.as_ref();
    let mut loader = Loader::default();
    let (part, origins) = loader.tree(path, &mut Vec::new(), None)?;
    let at = |problem: check::Problem| {
        let field = problem.path.split(['.', '[']).next().unwrap_or("");
        let source = &loader.sources[origins.get(field).copied().unwrap_or(0)];
        source.error_at(&problem.path, &problem.message)
    };
    check::objects(&part).map_err(at)?;
    let own_grasps: Option<Vec<bool>> =
        part.objects.as_ref().map(|objects| objects.iter().map(|e| e.grasps.is_some()).collect());
    let split = part.split.unwrap_or_default();
    let name = Name::near(&path.file_stem().unwrap_or_default().to_string_lossy());
    let main = &loader.sources[0];
    let scenes = part.complete(&name).map_err(|field| {
        let end = main.text.trim_end().len();
        let message = format!("missing field `{field}`\nevery scene has at least `object` and `loading`");
        main.error(&Diagnosis::new(&message, end.saturating_sub(1)..end))
    })?;
    for (i, named) in scenes.iter().enumerate() {
        check::check(&named.scene).map_err(|mut problem| {
            // where the file says it: the object and its grasps may stand in the list of objects
            let listed = own_grasps.as_ref().is_some_and(|own| {
                problem.path.starts_with("object.") || (own[i] && problem.path.starts_with("grasps"))
            });
            if listed {
                problem.path = format!("objects[{i}].{}", problem.path);
            }
            at(problem)
        })?;
    }
    let sources = loader.sources.into_iter().map(|s| s.path).collect();
    Ok(LoadedSet { scenes, split, path: path.to_path_buf(), sources })
}

/// Reads the text of one scene file.
fn parse(text: &str) -> std::result::Result<Part, ron::error::SpannedError> {
    options().from_str(text)
}

/// The RON dialect of scene files, for reading and writing: `Some` is implied, `Sphere(radius: 1)` needs no double
/// parentheses.
pub fn options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// The scene as a RON text that loads as the same scene, all defaults written out.
pub fn to_ron(scene: &Scene) -> Result<String> {
    let pretty = ron::ser::PrettyConfig::new().indentor("    ").compact_arrays(true);
    options()
        .to_string_pretty(scene, pretty)
        .map(|text| format!("{text}\n"))
        .map_err(|e| Error::Scene(format!("error: the scene cannot be written as RON: {e}")))
}

/// The scene that [`to_ron`] wrote; paths in it are taken as they stand.
///
/// # Errors
/// A text that is no complete scene.
pub fn from_ron(text: &str) -> Result<Scene> {
    complete(parse(text).map_err(|e| Error::Scene(format!("error: no scene: {e}")))?)
}

/// The scene of a `run.json`; paths in it are taken as they stand.
///
/// # Errors
/// A value that is no complete scene.
pub fn from_json(value: &serde_json::Value) -> Result<Scene> {
    complete(Part::deserialize(value).map_err(|e| Error::Scene(format!("error: no scene: {e}")))?)
}

fn complete(part: Part) -> Result<Scene> {
    let mut scenes = part
        .complete(&Name::near("scene"))
        .map_err(|field| Error::Scene(format!("error: no complete scene: missing field `{field}`")))?;
    let problem = |p: check::Problem| Error::Scene(format!("error: {}: {}", p.path, p.message));
    scenes.iter().try_for_each(|named| check::check(&named.scene)).map_err(problem)?;
    Ok(scenes.swap_remove(0).scene)
}

struct Source {
    path: PathBuf,
    text: String,
}

impl Source {
    fn error(&self, diagnosis: &Diagnosis) -> Error {
        Error::Scene(diagnosis.render(&self.path, &self.text))
    }

    /// An error at a field of this file, named in the message.
    fn error_at(&self, field: &str, message: &str) -> Error {
        let span = Outline::of(&self.text).find(field).map_or(0..0, |e| e.value.clone());
        self.error(&Diagnosis::new(&format!("{field}: {message}"), span))
    }
}

/// The file that gave each field, as an index into the sources.
type Origins = BTreeMap<&'static str, usize>;

#[derive(Default)]
struct Loader {
    sources: Vec<Source>,
}

impl Loader {
    /// The file with all that it includes. `chain` holds the files being read, outermost first.
    fn tree(&mut self, path: &Path, chain: &mut Vec<PathBuf>, from: Option<(usize, usize)>) -> Result<(Part, Origins)> {
        let text = match (source::read(path), from) {
            (Ok(text), _) => text,
            (Err(e), None) => return Err(e),
            (Err(e), Some((parent, place))) => {
                let message = e.to_string().trim_start_matches("error: ").to_string();
                return Err(self.sources[parent].error_at(&format!("include[{place}]"), &message));
            }
        };
        let index = self.sources.len();
        self.sources.push(Source { path: path.to_path_buf(), text });
        let source = &self.sources[index];
        let mut own = read_part(source)?;
        let dir = folder(path);
        resolve_paths(&mut own, &dir).map_err(|(field, message)| source.error_at(&field, &message))?;

        chain.push(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()));
        let (mut whole, mut origins) = (Part::default(), Origins::new());
        for (i, name) in std::mem::take(&mut own.include).iter().enumerate() {
            let included = dir.join(name);
            self.may_include(&included, chain)
                .map_err(|m| self.sources[index].error_at(&format!("include[{i}]"), &m))?;
            let (part, theirs) = self.tree(&included, chain, Some((index, i)))?;
            whole.take_over(part);
            origins.extend(theirs);
        }
        chain.pop();
        origins.extend(own.given().into_iter().map(|field| (field, index)));
        whole.take_over(own);
        Ok((whole, origins))
    }

    fn may_include(&self, path: &Path, chain: &[PathBuf]) -> std::result::Result<(), String> {
        let show = |chain: &[PathBuf]| {
            let names: Vec<_> = chain.iter().map(|p| p.file_name().unwrap_or_default().to_string_lossy()).collect();
            names.join(" -> ")
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if let Ok(canonical) = path.canonicalize()
            && let Some(first) = chain.iter().position(|p| *p == canonical)
        {
            return Err(format!("the files include each other in a circle: {} -> {name}", show(&chain[first..])));
        }
        if chain.len() > INCLUDE_DEPTH {
            return Err(format!("includes are nested more than {INCLUDE_DEPTH} deep: {} -> {name}", show(chain)));
        }
        if self.sources.len() >= INCLUDE_FILES {
            return Err(format!("the scene includes more than {INCLUDE_FILES} files"));
        }
        Ok(())
    }
}

/// Reads one file, not its includes.
fn read_part(source: &Source) -> Result<Part> {
    let outline = Outline::of(&source.text);
    if outline.is_empty() {
        let message = "the scene is empty\na smallest scene: (object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 15))";
        return Err(source.error(&Diagnosis::new(message, 0..0)));
    }
    let part = parse(&source.text).map_err(|e| source.error(&explain(&e, &source.text, &outline)))?;
    lint(&source.text, &outline).map_err(|d| source.error(&d))?;
    Ok(part)
}

/// Makes paths start at the file that names them, and refuses those that lead nowhere.
fn resolve_paths(part: &mut Part, dir: &Path) -> std::result::Result<(), (String, String)> {
    let file = |path: &mut PathBuf, field: String| {
        *path = dir.join(&*path);
        match path.metadata() {
            Ok(meta) if meta.is_dir() => Err((field, format!("{} is a directory, not a file", path.display()))),
            Ok(_) => Ok(()),
            Err(_) => {
                Err((field, format!("no file at {}\npaths start at the folder of the scene file", path.display())))
            }
        }
    };
    let object = |object: &mut Object, field: &str| match &mut object.shape {
        Shape::Mesh(path) => file(path, format!("{field}.shape")),
        _ => Ok(()),
    };
    let grasps = |grasps: &mut Grasps, field: &str| match grasps {
        Grasps::File(grasps) => file(&mut grasps.path, format!("{field}.path")),
        _ => Ok(()),
    };
    part.object.as_mut().map_or(Ok(()), |o| object(o, "object"))?;
    part.grasps.as_mut().map_or(Ok(()), |g| grasps(g, "grasps"))?;
    for (i, entry) in part.objects.iter_mut().flatten().enumerate() {
        object(&mut entry.object, &format!("objects[{i}].object"))?;
        entry.grasps.as_mut().map_or(Ok(()), |g| grasps(g, &format!("objects[{i}].grasps")))?;
    }
    if let Some(gripper) = &mut part.gripper
        && let Pads::File(pad) = &mut gripper.pads
    {
        file(&mut pad.path, "gripper.pads.path".into())?;
    }
    if let Some(Stepper::Gnn(gnn)) = &mut part.stepper {
        // whether there is a model is for the engine to say
        if crate::gnn::shipped::named(&gnn.model).is_none() {
            gnn.model = dir.join(&gnn.model);
        }
    }
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    path.parent().map(Path::to_path_buf).unwrap_or_default()
}
