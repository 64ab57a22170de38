//! ParaView collection (`.pvd`): the `.vtu` files of each applied force or time.

use base::error::Result;
use base::files::atomic::write_atomic;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Collection whose file is complete after every entry, so that an interrupted run opens in ParaView.
#[derive(Debug)]
pub struct Collection {
    path: PathBuf,
    entries: String,
}

impl Collection {
    /// Returns an empty collection at `path`; nothing is written yet.
    pub fn new(path: PathBuf) -> Self {
        Collection { path, entries: String::new() }
    }

    /// Adds `files` (relative to the collection's directory) as the parts of one step and rewrites the collection.
    ///
    /// The "time" that ParaView shows is `at`: the applied force, N, or the time of a dynamic scene, s.
    ///
    /// # Errors
    /// Fails if the collection cannot be written.
    pub fn push(&mut self, at: f64, files: &[&str]) -> Result<()> {
        for (part, file) in files.iter().enumerate() {
            // Writing to a String cannot fail; the file names need no XML escapes.
            let _ = writeln!(self.entries, "<DataSet timestep=\"{at}\" group=\"\" part=\"{part}\" file=\"{file}\"/>");
        }
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
             <Collection>\n{}</Collection>\n</VTKFile>\n",
            self.entries
        );
        write_atomic(&self.path, text.as_bytes())
    }

    /// Returns the path of the collection.
    pub fn path(&self) -> &Path {
        &self.path
    }
}
