//! Folders that one process writes at a time: two processes that fill one folder would replace each other's results.

use super::atomic::{cannot_write, create_dir, remove_left_over};
use crate::error::{Error, Result};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// Name of the file that is locked.
pub const LOCK: &str = ".lock";

/// Folder held by this process until dropped; a process that ends, in whatever way, releases it.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    alone: bool,
    // Its lock goes with it, after its name.
    _file: File,
}

impl FolderLock {
    /// Creates `dir` if necessary and takes it for `command` alone, like "tactus train". Files that killed processes left half-written in
    /// it are removed.
    ///
    /// # Errors
    /// Fails if another process holds the folder (with its number), or the folder cannot be written.
    pub fn alone(dir: &Path, command: &str) -> Result<Self> {
        let lock = Self::take(dir, command, true)?;
        remove_left_over(dir);
        Ok(lock)
    }

    /// Takes `dir` beside others that take it in this way and write other files.
    ///
    /// # Errors
    /// Fails in the cases of [`Self::alone`].
    pub fn beside(dir: &Path, command: &str) -> Result<Self> {
        Self::take(dir, command, false)
    }

    fn take(dir: &Path, command: &str, alone: bool) -> Result<Self> {
        create_dir(dir)?;
        let path = dir.join(LOCK);
        let fail = |e: &std::io::Error| cannot_write(&path, e);
        loop {
            // Not cut: it may hold the number of another process.
            let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(|e| fail(&e))?;
            match if alone { file.try_lock() } else { file.try_lock_shared() } {
                Ok(()) if !is_at(&file, &path) => continue,
                Ok(()) => {
                    let number = if alone { format!(" (process {})", std::process::id()) } else { String::new() };
                    // Without the name a message says less.
                    let _ = file.set_len(0).and_then(|()| file.write_all(format!("`{command}`{number}").as_bytes()));
                }
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    let _ = file.read_to_string(&mut holder);
                    let holder = if holder.is_empty() { "another process" } else { holder.as_str() };
                    let message = format!("{holder} is writing here; wait for it, end it, or choose another folder");
                    return Err(Error::file(dir, message));
                }
                // A file system without locks: what one process writes alone is right there, too.
                Err(TryLockError::Error(e)) if e.kind() == std::io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(e)) => return Err(fail(&e)),
            }
            return Ok(Self { path, alone, _file: file });
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Before the lock is given up: who takes it then looks whether its file still has the name. Others beside have the same
        // file, and Windows keeps a name until the last handle is closed.
        if self.alone && cfg!(unix) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Returns true if `path` still leads to `file`: its last holder may have removed the name after it was opened.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |m: std::fs::Metadata| (m.dev(), m.ino());
    let (Ok(own), Ok(named)) = (file.metadata(), std::fs::metadata(path)) else { return false };
    place(own) == place(named)
}

/// Returns true, because names are not removed on this system.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}
