//! Binary form: keywords in lines of text, arrays in big-endian bytes.

use std::path::Path;

use super::content::{Index, VtkContent};
use crate::mesh::io::text;
use base::error::{Error, Result};

/// Bytes of the file with the reading position.
pub(super) struct Bytes<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// Returns the bytes after the three header lines.
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let mut file = Self { path, bytes, at: 0 };
        (0..3).for_each(|_| file.skip_line());
        file
    }

    /// Continues after the end of the line.
    fn skip_line(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| *b == b'\n').map_or(rest.len(), |end| end + 1);
    }

    /// Returns the rest of the line without blanks around it, and continues after it.
    fn line(&mut self) -> &'a [u8] {
        let start = self.at;
        self.skip_line();
        self.bytes[start..self.at].trim_ascii()
    }

    /// Returns `n` numbers of `N` bytes each, which begin after the end of the current line.
    fn numbers<const N: usize>(&mut self, n: usize) -> Result<&'a [[u8; N]]> {
        let begin = self.at;
        let rest = self.line();
        if !rest.is_empty() {
            self.at = begin;
            return Err(self.fail("expected the end of the line, after which the bytes of an array begin".into()));
        }
        let end = self.at.saturating_add(N * n);
        let Some(taken) = self.bytes.get(self.at..end) else {
            return Err(self.fail(format!(
                "the file ends within an array of {n} numbers; it is truncated: write or copy it again"
            )));
        };
        self.at = end;
        Ok(taken.as_chunks().0)
    }
}

/// Returns the size of a number of this type, bytes. (`vtkIdType` is written with 32 bits.)
fn size(kind: &str) -> Option<usize> {
    match kind {
        "char" | "unsigned_char" | "signed_char" => Some(1),
        "short" | "unsigned_short" => Some(2),
        "int" | "unsigned_int" | "vtkIdType" | "vtkidtype" | "float" => Some(4),
        "long" | "unsigned_long" | "vtktypeint64" | "vtktypeuint64" | "double" => Some(8),
        _ => None,
    }
}

impl<'a> VtkContent<'a> for Bytes<'a> {
    fn fail(&self, message: String) -> Error {
        Error::file(self.path, format!("byte {}: {message}", self.at))
    }

    fn word(&mut self) -> Result<Option<&'a str>> {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        match std::str::from_utf8(&rest[..length]) {
            Ok("") => Ok(None),
            Ok(word) => {
                self.at += length;
                Ok(Some(word))
            }
            Err(_) => {
                Err(self
                    .fail("expected a word of text: the counts before it do not match the contents of the file".into()))
            }
        }
    }

    fn offsets(&mut self) -> Result<Option<&'a str>> {
        let begin = self.at;
        let word = self.word();
        if !matches!(word, Ok(Some("OFFSETS"))) {
            // The cells are in the old form, and these are bytes of their array.
            self.at = begin;
            return Ok(None);
        }
        self.next("the type of the offsets").map(Some)
    }

    fn reals(&mut self, n: usize, kind: &str) -> Result<Vec<f64>> {
        let values: Vec<f64> = match kind {
            "double" => self.numbers(n)?.iter().map(|b| f64::from_be_bytes(*b)).collect(),
            "float" => self.numbers(n)?.iter().map(|b| f64::from(f32::from_be_bytes(*b))).collect(),
            _ => return Err(self.fail(format!("points of type {}; allowed: double, float", text::quote(kind)))),
        };
        match values.iter().position(|v| !v.is_finite()) {
            Some(i) => {
                Err(self.fail(format!("{} is {}; only finite numbers are allowed", ["x", "y", "z"][i % 3], values[i])))
            }
            None => Ok(values),
        }
    }

    fn integers(&mut self, n: usize, kind: &str) -> Result<Vec<Index>> {
        let values: Vec<i64> = match size(kind) {
            Some(4) => self.numbers(n)?.iter().map(|b| i64::from(i32::from_be_bytes(*b))).collect(),
            Some(8) => self.numbers(n)?.iter().map(|b| i64::from_be_bytes(*b)).collect(),
            _ => {
                return Err(self.fail(format!("cells of type {}; allowed: int, long, vtktypeint64", text::quote(kind))));
            }
        };
        let index = |v: i64| u64::try_from(v).map(|value| Index { value, place: None });
        let checked: std::result::Result<Vec<_>, _> = values.into_iter().map(index).collect();
        checked.map_err(|_| self.fail("a negative number in the cells: the file is damaged, or not big-endian".into()))
    }

    fn skip(&mut self, keyword: &str) -> Result<()> {
        match keyword {
            "METADATA" => {
                self.skip_line();
                while self.at < self.bytes.len() && !self.line().is_empty() {}
            }
            "FIELD" => {
                self.next("the name of a field")?;
                for _ in 0..self.count("the number of arrays", 1 << 16)? {
                    self.next("the name of an array")?;
                    let components = self.count("the number of components", 1 << 16)?;
                    let tuples = self.count("the number of values", 1 << 31)?;
                    let kind = self.next("the type of an array")?;
                    let Some(size) = size(kind) else {
                        return Err(self.fail(format!("an array of type {} cannot be skipped", text::quote(kind))));
                    };
                    self.numbers::<1>(components * tuples * size)?;
                }
            }
            // A line of text.
            _ => self.skip_line(),
        }
        Ok(())
    }
}
