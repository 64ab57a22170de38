//! Exclusive access to folders: two processes that write to one folder would overwrite each other's results.
//!
//! A file lock of the operating system is released when the process ends. On file systems without locks a [`LockFile`]
//! replaces it.

use super::atomic::{cannot_write, create_dir, remove_temporary_files};
use super::lock_file::LockFile;
use crate::error::{Error, Result};
use crate::interrupt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the lock file in a folder.
pub const LOCK_NAME: &str = ".lock";

/// Lock on a folder, held until dropped; it is released however the process ends.
#[derive(Debug)]
pub struct FolderLock {
    holding: LockKind,
}

/// Implementation of the lock.
#[derive(Debug)]
enum LockKind {
    /// File lock of the operating system on `path`.
    System { path: PathBuf, alone: bool, _file: File },
    /// Lock file used instead.
    File { file: LockFile, reason: String },
}

impl FolderLock {
    /// Creates `dir` if necessary and locks it exclusively for `command`, e.g. "tactus train". Removes incomplete files
    /// of killed processes.
    ///
    /// # Errors
    /// Fails if another process holds the lock (the message states its id), or if the folder cannot be written.
    pub fn exclusive(dir: &Path, command: &str) -> Result<Self> {
        let lock = Self::take(dir, command, true)?;
        remove_temporary_files(dir);
        Ok(lock)
    }

    /// Locks `dir` in shared mode, for processes that write different files.
    ///
    /// # Errors
    /// Fails in the cases of [`Self::exclusive`].
    pub fn shared(dir: &Path, command: &str) -> Result<Self> {
        Self::take(dir, command, false)
    }

    fn take(dir: &Path, command: &str, alone: bool) -> Result<Self> {
        create_dir(dir)?;
        Ok(Self { holding: LockKind::take(dir, command, alone)? })
    }

    /// Returns a notice for the user if the lock is not one of the operating system.
    pub fn notice(&self) -> Option<String> {
        let LockKind::File { file, reason } = &self.holding else { return None };
        Some(format!(
            "{}: the file system does not support locks ({reason}); this file replaces the lock while the command \
             runs, and must be deleted manually if the command is killed and the next one runs on another machine",
            file.path().display()
        ))
    }
}

impl LockKind {
    fn take(dir: &Path, command: &str, alone: bool) -> Result<Self> {
        let path = dir.join(LOCK_NAME);
        let fail = |e: &std::io::Error| cannot_write(&path, e);
        loop {
            // Not truncated, because it may contain the command of the current holder.
            let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(|e| fail(&e))?;
            match if alone { file.try_lock() } else { file.try_lock_shared() } {
                Ok(()) if !is_at(&file, &path) => continue,
                Ok(()) => {
                    let number = if alone { format!(" (process {})", std::process::id()) } else { String::new() };
                    // Failure is harmless: messages then lack the name of the holder.
                    let _ = file.set_len(0).and_then(|()| file.write_all(format!("`{command}`{number}").as_bytes()));
                }
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    let _ = file.read_to_string(&mut holder);
                    let holder = if holder.is_empty() { "another process" } else { holder.as_str() };
                    let message = format!("{holder} is writing here; wait for it, end it, or choose another folder");
                    return Err(Error::file(dir, message));
                }
                Err(TryLockError::Error(e)) if has_no_locks(&e) => {
                    // A non-empty file belongs to a process that could lock it.
                    if file.metadata().is_ok_and(|meta| meta.len() == 0) {
                        let _ = std::fs::remove_file(&path);
                    }
                    return Ok(Self::File { file: LockFile::acquire(&path, command, alone)?, reason: e.to_string() });
                }
                Err(TryLockError::Error(e)) => return Err(fail(&e)),
            }
            return Ok(Self::System { path, alone, _file: file });
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Removed before the lock is released; a process that acquires it afterwards checks that its file still has
        // this name. Shared locks keep the file for the other holders, and Windows keeps a name until the last handle
        // is closed.
        if let LockKind::System { path, alone: true, .. } = &self.holding
            && cfg!(unix)
        {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Exclusive lock of a thread on a file of a folder that several threads and processes write to; released when dropped.
#[derive(Debug)]
pub enum WriteLock {
    /// File lock of the operating system.
    System(File),
    /// Lock file used instead.
    File(LockFile),
}

/// Maximum waiting time for locks that the operating system does not release with their process.
const LOCK_TIMEOUT: Duration = Duration::from_secs(600);

impl WriteLock {
    /// Waits for the lock of `command` on the file `path`, which is created and not removed.
    ///
    /// # Errors
    /// Fails if the file cannot be written, on an interruption, or if another process holds a [`LockFile`] for ten
    /// minutes.
    pub fn acquire(path: &Path, command: &str) -> Result<Self> {
        let file = File::create(path).map_err(|e| cannot_write(path, &e))?;
        match file.lock() {
            Ok(()) => return Ok(Self::System(file)),
            Err(e) if has_no_locks(&e) => {}
            Err(e) => return Err(cannot_write(path, &e)),
        }
        let until = Instant::now() + LOCK_TIMEOUT;
        loop {
            match LockFile::acquire(path, command, true) {
                Ok(file) => return Ok(Self::File(file)),
                Err(error) if Instant::now() >= until => return Err(error),
                Err(_) => interrupt::check()?,
            }
            // The delay depends on the process, so that two processes that gave way to each other retry at different
            // times.
            std::thread::sleep(Duration::from_millis(20 + u64::from(std::process::id() % 32)));
        }
    }
}

/// Returns true if this error means that the file system does not support locks.
fn has_no_locks(error: &std::io::Error) -> bool {
    // ENOLCK has no `ErrorKind`; NFS without its lock service and Lustre without `-o flock` return it.
    #[cfg(unix)]
    let none = rustix::io::Errno::from_io_error(error) == Some(rustix::io::Errno::NOLCK);
    #[cfg(not(unix))]
    let none = false;
    none || error.kind() == std::io::ErrorKind::Unsupported
}

/// Returns true if a process holds a lock on `dir`, or was killed while holding it.
pub fn is_held(dir: &Path) -> bool {
    let names = std::fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.into_iter().any(|name| name.to_str().is_some_and(|name| name.starts_with(LOCK_NAME)))
}

/// Returns true if `path` still refers to `file`: its last holder may have removed the name after it was opened.
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
