//! Bounds of files that include other files: scenes, and descriptions of robots.

use std::path::{Path, PathBuf};

/// Largest size of all files that belong together, bytes: far above any scene or robot, far below any harm.
pub const SIZE_LIMIT: u64 = 16 * 1024 * 1024;
/// Longest chain of includes.
const DEPTH: usize = 16;
/// Largest number of files that belong together: includes that include each other's includes multiply.
const FILES: usize = 256;

/// Says whether the file at `path` may be included after `read` others; `chain` holds the files being read, outermost first, with canonical
/// paths.
///
/// # Errors
/// Fails, with the names of the files, if they include each other in a circle, the chain is too long or the files are too many.
pub fn may_include(path: &Path, chain: &[PathBuf], read: usize) -> Result<(), String> {
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let show = |chain: &[PathBuf]| chain.iter().map(|p| name(p)).collect::<Vec<_>>().join(" -> ");
    if let Ok(canonical) = path.canonicalize()
        && let Some(first) = chain.iter().position(|p| *p == canonical)
    {
        return Err(format!("the files include each other in a circle: {} -> {}", show(&chain[first..]), name(path)));
    }
    if chain.len() > DEPTH {
        return Err(format!("includes are nested more than {DEPTH} deep: {} -> {}", show(chain), name(path)));
    }
    if read >= FILES {
        return Err(format!("more than {FILES} files are included"));
    }
    Ok(())
}
