//! Sequential reader of the bytes of a binary gmsh file, in the byte order that the file indicates.

use std::path::Path;

use glam::DVec3;

use super::version::Version;
use crate::mesh::MAX_COUNT;
use crate::mesh::io::text::quote;
use base::error::{Error, Result};

/// Longest line of text between the blocks of bytes.
const LINE: usize = 4096;

/// Bytes of the file with the reading position.
pub(crate) struct Cursor<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Size of a `size_t`, bytes.
    pub wide: usize,
    /// Version of the format; known once the section `$MeshFormat` is read.
    pub version: Option<Version>,
}

impl<'a> Cursor<'a> {
    /// Returns a cursor at the first byte.
    pub fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self { path, bytes, at: 0, big_endian: false, wide: 8, version: None }
    }

    /// Returns an error at the current byte.
    pub fn fail(&self, message: &str) -> Error {
        Error::file(self.path, format!("byte {}: {message}", self.at))
    }

    /// Returns the next `n` bytes; `what` names them.
    ///
    /// # Errors
    /// Fails if the file ends before.
    pub fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8]> {
        let Some(taken) = self.bytes.get(self.at..self.at.saturating_add(n)) else {
            return Err(Error::file(
                self.path,
                format!("the file ends where {what} should follow; it is truncated: write or copy it again"),
            ));
        };
        self.at += n;
        Ok(taken)
    }

    /// Returns the rest of a line of text.
    fn line(&mut self) -> Result<&'a str> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().take(LINE).position(|b| *b == b'\n').unwrap_or(rest.len().min(LINE));
        let text = std::str::from_utf8(&rest[..length]).map_err(|_| self.fail("expected a line of text"))?;
        self.at = (self.at + length + 1).min(self.bytes.len());
        Ok(text.trim())
    }

    /// Returns the next line that is not blank, which starts or ends a section; None at the end of the file.
    ///
    /// # Errors
    /// Fails if the line does not start with `$`.
    pub fn section(&mut self) -> Result<Option<&'a str>> {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let start = self.at;
        let name = self.line().ok().filter(|name| name.starts_with('$'));
        match name {
            Some(name) => Ok(Some(name)),
            None => {
                self.at = start;
                Err(self.fail(
                    "expected a section such as `$Nodes`, or the end of one: its counts do not match its contents",
                ))
            }
        }
    }

    /// Returns the rest of a line of text; None at the end of the file.
    ///
    /// # Errors
    /// Fails if it is not text.
    pub fn rest_of_line(&mut self) -> Result<Option<&'a str>> {
        if self.at == self.bytes.len() { Ok(None) } else { self.line().map(Some) }
    }

    /// Continues after the next `end` and returns a cursor over the bytes before it.
    ///
    /// # Errors
    /// Fails if the file has no further `end`.
    pub fn skip_to(&mut self, end: &str) -> Result<Self> {
        let Some(found) = find(&self.bytes[self.at..], end.as_bytes()) else {
            return Err(Error::file(
                self.path,
                format!("the file ends where `{end}` should follow; it is truncated: write or copy it again"),
            ));
        };
        let before = Self { bytes: &self.bytes[..self.at + found], ..*self };
        self.at += found + end.len();
        Ok(before)
    }

    /// Reads the section `$MeshFormat`: `version 1 size`, and a 1 that indicates the byte order.
    ///
    /// # Errors
    /// Fails for an unknown version, data size or byte order, and if the file is cut short.
    pub fn format(&mut self) -> Result<()> {
        let line = self.line()?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let [version, "1", size] = words[..] else {
            return Err(self.fail(&format!("expected `version 1 data-size`, found {}", quote(line))));
        };
        self.version = Some(Version::of(version).map_err(|message| self.fail(&message))?);
        self.wide = match size {
            "4" => 4,
            "8" => 8,
            other => return Err(self.fail(&format!("data size {}; allowed: 4 or 8", quote(other)))),
        };
        self.big_endian = match self.take(4, "the 1 that indicates the byte order")? {
            [1, 0, 0, 0] => false,
            [0, 0, 0, 1] => true,
            other => {
                return Err(self.fail(&format!("the byte order must be indicated by a 1, found the bytes {other:?}")));
            }
        };
        Ok(())
    }

    /// Reads `n` bytes in the byte order of the file; returns them as eight bytes in little-endian order.
    fn number(&mut self, n: usize, what: &str) -> Result<[u8; 8]> {
        let mut lowest_first = [0; 8];
        let taken = self.take(n, what)?;
        lowest_first[..n].copy_from_slice(taken);
        if self.big_endian {
            lowest_first[..n].reverse();
        }
        Ok(lowest_first)
    }

    /// Reads an `int`.
    ///
    /// # Errors
    /// Fails if the file is cut short.
    pub fn any_int(&mut self, what: &str) -> Result<i32> {
        let [a, b, c, d, ..] = self.number(4, what)?;
        Ok(i32::from_le_bytes([a, b, c, d]))
    }

    /// Reads an `int` that is not negative.
    ///
    /// # Errors
    /// Fails if the number is negative or the file is cut short.
    pub fn int(&mut self, what: &str) -> Result<u64> {
        let value = self.any_int(what)?;
        u64::try_from(value).map_err(|_| self.fail(&format!("{what} is {value}; a number >= 0 is needed")))
    }

    /// Reads a `size_t`.
    ///
    /// # Errors
    /// Fails if the file is cut short.
    pub fn size(&mut self, what: &str) -> Result<u64> {
        self.number(self.wide, what).map(u64::from_le_bytes)
    }

    /// Reads a declared count.
    ///
    /// # Errors
    /// Fails if the count is above [`MAX_COUNT`] or the file is cut short.
    pub fn count(&mut self, what: &str) -> Result<usize> {
        let value = self.size(what)?;
        self.capped(value, what)
    }

    /// Reads a declared count on a line of text.
    ///
    /// # Errors
    /// Fails if the line is not a whole number or the count is above [`MAX_COUNT`].
    pub fn text_count(&mut self, what: &str) -> Result<usize> {
        let line = self.line()?;
        let value =
            line.parse().map_err(|_| self.fail(&format!("{what} {} is not a whole number >= 0", quote(line))))?;
        self.capped(value, what)
    }

    fn capped(&self, value: u64, what: &str) -> Result<usize> {
        if value > MAX_COUNT as u64 {
            return Err(self.fail(&format!("{what} {value} is above the {MAX_COUNT} allowed; use a coarser mesh")));
        }
        Ok(value as usize)
    }

    /// Reads a position, m, followed by `extra` numbers, which are ignored.
    ///
    /// # Errors
    /// Fails if a coordinate is not finite or the file is cut short.
    pub fn position(&mut self, extra: usize) -> Result<DVec3> {
        let mut p = [0.0; 3];
        for (value, name) in p.iter_mut().zip(["x", "y", "z"]) {
            *value = f64::from_le_bytes(self.number(8, name)?);
            if !value.is_finite() {
                return Err(self.fail(&format!("{name} is {value}; only finite numbers are allowed")));
            }
        }
        self.take(8 * extra, "the parameters of a node")?;
        Ok(DVec3::from_array(p))
    }
}

/// Returns the first position of `wanted`.
pub(super) fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|w| w == wanted)
}
