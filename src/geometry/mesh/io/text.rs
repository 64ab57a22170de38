//! Text files as lines of words with their positions, so that every error message can state line and column.

use std::path::Path;

use glam::DVec3;

use crate::mesh::MAX_COUNT;
use base::error::{Error, Result};
use base::number::format_count;

/// Longest accepted line, bytes: all its words are held in memory at once.
const MAX_LINE: usize = 4 << 20;

/// Word of a text file with its position.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Word<'a> {
    /// Line number, 1-based.
    pub line: usize,
    /// Column of its first character, 1-based.
    pub column: usize,
    /// Text of the word.
    pub text: &'a str,
}

/// Non-blank line without its comment.
#[derive(Debug)]
pub(crate) struct Line<'a> {
    /// Line number, 1-based.
    pub number: usize,
    /// Words, at least one.
    pub words: Vec<Word<'a>>,
}

impl<'a> Line<'a> {
    /// Returns the first word.
    pub fn first(&self) -> Word<'a> {
        self.words.first().copied().unwrap_or(Word { line: self.number, column: 1, text: "" })
    }

    /// Returns the last word, whose position is reported when a word is missing.
    pub fn last(&self) -> Word<'a> {
        self.words.last().copied().unwrap_or(self.first())
    }
}

/// Returns the non-blank lines of `text`, truncated at `comment`.
pub(crate) fn lines(text: &str, comment: Option<char>) -> impl Iterator<Item = Line<'_>> {
    text.lines().enumerate().filter_map(move |(i, raw)| {
        let number = i + 1;
        let body = match comment.and_then(|c| raw.find(c)) {
            Some(cut) => &raw[..cut],
            None => raw,
        };
        let words = split(body, number);
        (!words.is_empty()).then_some(Line { number, words })
    })
}

/// Returns the words of one line with their columns.
fn split(body: &str, line: usize) -> Vec<Word<'_>> {
    let mut words = Vec::new();
    // Byte and column of the word that is being read.
    let mut start = None;
    for (column, (at, c)) in body.char_indices().chain(std::iter::once((body.len(), ' '))).enumerate() {
        match (start, c.is_whitespace()) {
            (None, false) => start = Some((at, column + 1)),
            (Some((from, column)), true) => {
                words.push(Word { line, column, text: &body[from..at] });
                start = None;
            }
            _ => {}
        }
    }
    words
}

/// Decodes the bytes of a file as text; a byte order mark is dropped, bytes that are not UTF-8 (old comments) are
/// replaced.
///
/// # Errors
/// Fails for a zero byte, which text does not contain, and for a line of more than [`MAX_LINE`] bytes.
pub(crate) fn decode(path: &Path, bytes: Vec<u8>) -> Result<String> {
    if let Some(at) = bytes.iter().position(|b| *b == 0) {
        let message = format!("binary content (a zero byte at offset {at}); a text file is needed");
        return Err(Error::file(path, message));
    }
    if let Some((i, line)) = bytes.split(|b| *b == b'\n').enumerate().find(|(_, line)| line.len() > MAX_LINE) {
        let (number, length) = (i + 1, line.len());
        let message = format!("line {number} has {length} bytes; at most {MAX_LINE} are allowed: break it into lines");
        return Err(Error::file(path, message));
    }
    let text = String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
    Ok(match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// Returns an error at a word of the file.
pub(crate) fn word_error(path: &Path, word: Word<'_>, message: impl std::fmt::Display) -> Error {
    Error::file(path, format!("line {}, column {}: {message}", word.line, word.column))
}

/// Returns an error about the end of the file.
pub(crate) fn end_error(path: &Path, expected: &str) -> Error {
    Error::file(path, format!("the file ends where {expected} should follow; it is truncated: write or copy it again"))
}

/// Returns at most 40 characters of a word, for quoting.
pub(crate) fn quote(text: &str) -> String {
    let mut short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        short.push_str("...");
    }
    format!("`{short}`")
}

/// Parses the word as a finite number; `what` names it.
pub(crate) fn number(path: &Path, word: Word<'_>, what: &str) -> Result<f64> {
    let value: f64 = word
        .text
        .parse()
        .map_err(|_| word_error(path, word, format!("{what} {} is not a number", quote(word.text))))?;
    if !value.is_finite() {
        return Err(word_error(path, word, format!("{what} is {value}; only finite numbers are allowed")));
    }
    Ok(value)
}

/// Parses the word as an unsigned integer; `what` names it.
pub(crate) fn integer(path: &Path, word: Word<'_>, what: &str) -> Result<u64> {
    word.text
        .parse()
        .map_err(|_| word_error(path, word, format!("{what} {} is not a whole number >= 0", quote(word.text))))
}

/// Parses the word as a declared count, rejected above [`MAX_COUNT`].
pub(crate) fn count(path: &Path, word: Word<'_>, what: &str) -> Result<usize> {
    let value = integer(path, word, what)?;
    if value > MAX_COUNT as u64 {
        return Err(word_error(
            path,
            word,
            format!("{what} {value} is above the {MAX_COUNT} allowed; use a coarser mesh"),
        ));
    }
    Ok(value as usize)
}

/// Parses three words as a position, m.
pub(crate) fn position(path: &Path, words: &[Word<'_>]) -> Result<DVec3> {
    let mut p = [0.0; 3];
    for ((value, word), name) in p.iter_mut().zip(words).zip(["x", "y", "z"]) {
        *value = number(path, *word, name)?;
    }
    Ok(DVec3::from_array(p))
}

/// Rejects a line with more or fewer words than allowed.
pub(crate) fn columns(path: &Path, line: &Line<'_>, allowed: &[usize], what: &str) -> Result<()> {
    if allowed.contains(&line.words.len()) {
        return Ok(());
    }
    let list: Vec<String> = allowed.iter().map(usize::to_string).collect();
    let message = format!("{what} has {}; allowed: {}", format_count(line.words.len(), "column"), list.join(" or "));
    Err(word_error(path, line.last(), message))
}

/// Node index with its position in the file, checked once all nodes are known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VertexReference {
    /// Index as a 0-based number.
    pub index: u64,
    /// Line number, 1-based.
    pub line: usize,
    /// Column number, 1-based.
    pub column: usize,
}

/// Checks four references of element `element` against `count` nodes; `base` (0 or 1) is the file's first index.
pub(crate) fn resolve(
    path: &Path,
    refs: [VertexReference; 4],
    element: usize,
    count: usize,
    base: u64,
) -> Result<[u32; 4]> {
    for r in refs {
        if r.index >= count as u64 {
            return Err(word_error(
                path,
                Word { line: r.line, column: r.column, text: "" },
                format!(
                    "tetrahedron {element} refers to node {}, but the file has {count} nodes; allowed: {base}..={}",
                    r.index.saturating_add(base),
                    (count as u64).saturating_add(base).saturating_sub(1)
                ),
            ));
        }
    }
    Ok(refs.map(|r| r.index as u32))
}
