//! ASCII form, word by word.

use std::path::Path;

use super::content::{Index, VtkContent};
use crate::mesh::io::text::{self, Line, Word};
use base::error::{Error, Result};

/// Words of the file after its header.
pub(super) struct Words<'a> {
    path: &'a Path,
    words: std::iter::Peekable<Box<dyn Iterator<Item = Word<'a>> + 'a>>,
    last: Option<Word<'a>>,
}

impl<'a> Words<'a> {
    /// Returns the words after the three header lines.
    pub fn new(path: &'a Path, source: &'a str) -> Self {
        let words = text::lines(source, None).filter(|line: &Line| line.number > 3).flat_map(|line| line.words);
        let words: Box<dyn Iterator<Item = Word<'a>> + 'a> = Box::new(words);
        Self { path, words: words.peekable(), last: None }
    }

    /// Returns the next word of an array.
    fn number(&mut self) -> Result<Word<'a>> {
        self.last = self.words.next();
        self.last.ok_or_else(|| text::end_error(self.path, "a number"))
    }
}

impl<'a> VtkContent<'a> for Words<'a> {
    fn fail(&self, message: String) -> Error {
        match self.last {
            Some(word) => text::word_error(self.path, word, message),
            None => Error::file(self.path, message),
        }
    }

    fn word(&mut self) -> Result<Option<&'a str>> {
        self.last = self.words.next();
        Ok(self.last.map(|word| word.text))
    }

    fn offsets(&mut self) -> Result<Option<&'a str>> {
        if self.words.next_if(|word| word.text == "OFFSETS").is_none() {
            return Ok(None);
        }
        self.next("the type of the offsets").map(Some)
    }

    fn reals(&mut self, n: usize, _: &str) -> Result<Vec<f64>> {
        (0..n).map(|i| text::number(self.path, self.number()?, ["x", "y", "z"][i % 3])).collect()
    }

    fn integers(&mut self, n: usize, _: &str) -> Result<Vec<Index>> {
        let index = |_| {
            let word = self.number()?;
            let value = text::integer(self.path, word, "a number of a cell")?;
            Ok(Index { value, place: Some((word.line, word.column)) })
        };
        (0..n).map(index).collect()
    }

    fn skip(&mut self, _: &str) -> Result<()> {
        Ok(())
    }
}
