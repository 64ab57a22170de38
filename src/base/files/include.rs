//! Limits for files that include other files: scenes and robot descriptions.

use std::path::{Path, PathBuf};

/// Maximum total size of a file and its includes, bytes: far above any scene or robot, small enough to be harmless.
pub const MAX_TOTAL_SIZE: u64 = 16 * 1024 * 1024;
/// Maximum nesting depth of includes.
const MAX_DEPTH: usize = 16;
/// Maximum number of files, because nested includes can multiply.
const MAX_FILES: usize = 256;

/// Checks that the file at `path` may be included after `read` others; `chain` holds the canonical paths of the files
/// being read, outermost first.
///
/// # Errors
/// Fails if files include each other recursively (the message lists them), if includes are nested too deeply, or if
/// there are too many files.
pub fn check_include(path: &Path, chain: &[PathBuf], read: usize) -> Result<(), String> {
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let show = |chain: &[PathBuf]| chain.iter().map(|p| name(p)).collect::<Vec<_>>().join(" -> ");
    if let Ok(canonical) = path.canonicalize()
        && let Some(first) = chain.iter().position(|p| *p == canonical)
    {
        return Err(format!("the files include each other in a cycle: {} -> {}", show(&chain[first..]), name(path)));
    }
    if chain.len() > MAX_DEPTH {
        return Err(format!("includes are nested more than {MAX_DEPTH} deep: {} -> {}", show(chain), name(path)));
    }
    if read >= MAX_FILES {
        return Err(format!("more than {MAX_FILES} files are included"));
    }
    Ok(())
}
