//! Content of a legacy VTK file, whether in text or in bytes.

use crate::mesh::io::text;
use base::error::{Error, Result};

/// Integer of a file, with its line and column, both 1-based, if the file is text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Index {
    pub value: u64,
    pub place: Option<(usize, usize)>,
}

/// Content of a file, word by word and array by array.
pub(super) trait VtkContent<'a> {
    /// Returns an error at the position that was read last.
    fn fail(&self, message: String) -> Error;

    /// Returns the next word of a line of text; None at the end of the file.
    fn word(&mut self) -> Result<Option<&'a str>>;

    /// Returns the type of the offsets if the cells are in the form of version 5, with separate offsets and
    /// connectivity.
    fn offsets(&mut self) -> Result<Option<&'a str>>;

    /// Reads `n` real numbers of the type `kind`, all finite.
    fn reals(&mut self, n: usize, kind: &str) -> Result<Vec<f64>>;

    /// Reads `n` non-negative integers of the type `kind`.
    fn integers(&mut self, n: usize, kind: &str) -> Result<Vec<Index>>;

    /// Skips an unused section, whose keyword was read last.
    fn skip(&mut self, keyword: &str) -> Result<()>;

    /// Returns the next word; `expected` names it.
    fn next(&mut self, expected: &str) -> Result<&'a str> {
        match self.word()? {
            Some(word) => Ok(word),
            None => Err(self.fail(format!(
                "the file ends where {expected} should follow; it is truncated: write or copy it again"
            ))),
        }
    }

    /// Reads a declared count, which is rejected above `most`.
    fn count(&mut self, what: &str, most: usize) -> Result<usize> {
        let word = self.next(what)?;
        match word.parse::<u64>() {
            Err(_) => Err(self.fail(format!("{what} {} is not a whole number >= 0", text::quote(word)))),
            Ok(n) if n > most as u64 => {
                Err(self.fail(format!("{what} {n} is above the {most} allowed; use a coarser mesh")))
            }
            Ok(n) => Ok(n as usize),
        }
    }
}
