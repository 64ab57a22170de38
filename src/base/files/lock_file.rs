//! Lock files, for file systems without locks, e.g. some NFS and Lustre mounts.
//!
//! Instead of locking the file BASE, a process creates a file `BASE.KIND.HOST.PROCESS`, where KIND is `alone`
//! (exclusive) or `beside` (shared). It creates its own file before it looks for others: of two processes that start at
//! once, at least one finds the other and gives way.

use super::atomic::cannot_write;
use crate::error::{Error, Result};
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Lock file of this process, removed when dropped. A file left by a killed process is removed by the next process on
/// the same machine.
#[derive(Debug)]
pub struct LockFile {
    path: PathBuf,
}

impl LockFile {
    /// Acquires the lock `base` for `command`, e.g. "tactus train"; exclusive if `alone`, otherwise shared.
    ///
    /// # Errors
    /// Fails if another process holds the lock, or may hold it on another machine (the message states the file to
    /// delete otherwise), and if the folder cannot be written.
    pub fn acquire(base: &Path, command: &str, alone: bool) -> Result<Self> {
        let own = Holder { alone, host: host(), process: std::process::id() };
        let (path, dir) = (own.path(base), folder(base));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            // Failure is harmless: messages then lack the command.
            Ok(mut file) => drop(file.write_all(format!("`{command}`").as_bytes())),
            Err(e) if e.kind() == ErrorKind::AlreadyExists => return Err(own.refusal(base)),
            Err(e) => return Err(cannot_write(&path, &e)),
        }
        let taken = Self { path };
        let names = std::fs::read_dir(dir).map_err(|e| cannot_write(dir, &e))?.flatten().map(|entry| entry.file_name());
        for other in names.filter_map(|name| Holder::of(base, name.to_str()?)).filter(|other| *other != own) {
            if other.host == own.host && !is_running(other.process) {
                // Ignored, because another process may have removed it already.
                let _ = std::fs::remove_file(other.path(base));
            } else if alone || other.alone {
                return Err(other.refusal(base));
            }
        }
        Ok(taken)
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for LockFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Process that holds a lock, parsed from the name of its lock file.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Holder {
    alone: bool,
    host: String,
    process: u32,
}

impl Holder {
    /// Parses the name of a lock file of `base`; None for any other file.
    fn of(base: &Path, name: &str) -> Option<Self> {
        let (kind, rest) = name.strip_prefix(base.file_name()?.to_str()?)?.strip_prefix('.')?.split_once('.')?;
        let (host, process) = rest.rsplit_once('.')?;
        Some(Self { alone: kind == "alone", host: host.into(), process: process.parse().ok()? })
    }

    fn path(&self, base: &Path) -> PathBuf {
        let kind = if self.alone { "alone" } else { "beside" };
        let mut name = base.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{kind}.{}.{}", self.host, self.process));
        base.with_file_name(name)
    }

    fn refusal(&self, base: &Path) -> Error {
        let path = self.path(base);
        let command = std::fs::read_to_string(&path).ok().filter(|text| !text.is_empty());
        let message = format!(
            "{} (process {} on {}) is writing here; wait for it, end it, or choose another folder; if that process no \
             longer exists, delete {}",
            command.as_deref().unwrap_or("another command"),
            self.process,
            self.host,
            path.display()
        );
        Error::file(folder(base), message)
    }
}

/// Returns the folder of a file, `.` for a bare file name.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the name of this machine.
#[cfg(unix)]
fn host() -> String {
    rustix::system::uname().nodename().to_string_lossy().replace('/', "-")
}

/// Returns the name of this machine.
#[cfg(not(unix))]
fn host() -> String {
    std::env::var("COMPUTERNAME").unwrap_or_else(|_| "localhost".into())
}

/// Returns true if a process of this machine is running or may be running.
#[cfg(unix)]
fn is_running(process: u32) -> bool {
    let number = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    // A permission error also means that the process is running.
    number.is_some_and(|number| rustix::process::test_kill_process(number) != Err(rustix::io::Errno::SRCH))
}

/// Returns true, because the system offers no test for a running process.
#[cfg(not(unix))]
fn is_running(_: u32) -> bool {
    true
}
