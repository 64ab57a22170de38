//! Messages for parser errors, with position and remedy.

use super::excerpt::{floor, truncate, truncate_name};
use super::outline::{Outline, OutlineEntry};
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use ron::error::{Error as Ron, Position, SpannedError};
use std::ops::Range;
use std::path::Path;

/// One error in a scene file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Diagnosis {
    /// Error message.
    pub message: String,
    /// Position of the error in the text, byte range.
    pub span: Range<usize>,
    /// Help: the allowed values or the remedy.
    pub help: Option<String>,
}

/// Fields of former versions, and their replacements.
const RENAMED_FIELDS: [(&str, &str); 1] = [(
    "attach_distance",
    "a field of version 0.1, replaced by the rule `bonded`: write `bonded: Plane(within: ...)` with the same distance",
)];

/// Longest message, bytes: a message may quote a word of the scene, which may be as long as the file.
const MESSAGE: usize = 1000;

impl Diagnosis {
    /// Creates a diagnosis from a message; its lines after the first are the help.
    pub fn new(message: &str, span: Range<usize>) -> Self {
        let (message, help) = match message.split_once('\n') {
            Some((message, help)) => (message.to_string(), Some(help.to_string())),
            None => (message.to_string(), None),
        };
        Self { message: truncate(&message, MESSAGE).into_owned(), span, help }
    }

    /// Renders the printed form: `error: ...`, ` --> file:line:column`, the line with a caret, `help: ...`.
    pub fn render(&self, path: &Path, text: &str) -> String {
        let start = floor(text, self.span.start);
        let end = floor(text, self.span.end.max(start));
        // only one line is shown: an error on a group points at its first line
        let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
        let end = end.min(line_end).max(start);
        let path = path.display().to_string();
        let snippet = Snippet::source(text).path(path).annotation(AnnotationKind::Primary.span(start..end));
        let mut group = Level::ERROR.primary_title(self.message.as_str()).element(snippet);
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        Renderer::plain().render(&[group]).to_string()
    }
}

/// Translates a RON error into a message in terms of the scene file.
pub(super) fn explain(error: &SpannedError, text: &str, outline: &Outline) -> Diagnosis {
    let start = byte_of(text, error.span.start);
    let end = byte_of(text, error.span.end);
    // the parser's span extends from its last step to its present position: a refused value is the span, a missing
    // token is at the end of it
    let refused = start..end;
    let here = end..end + token(text, end).len();
    let found = || match token(text, end) {
        "" => "the end of the file".to_string(),
        token => format!("`{token}`"),
    };
    let of = |outer: &Option<String>| outer.as_ref().map_or(String::new(), |outer| format!(" in {outer}"));
    let (message, span) = match &error.code {
        Ron::Message(message) => (with_field_path(message, start, text, outline), full_span(text, refused, outline)),
        Ron::InvalidValueForType { expected, found } => (
            with_field_path(
                &format!("expected {}, found {}", strip_expected_type(expected), strip_found_type(found)),
                start,
                text,
                outline,
            ),
            full_span(text, refused, outline),
        ),
        Ron::ExpectedDifferentLength { expected, found } => {
            let message = format!("expected {expected}, found only {found} of them");
            (with_field_path(&message, end, text, outline), full_span(text, here, outline))
        }
        Ron::NoSuchStructField { expected, found, outer } => {
            let former = RENAMED_FIELDS.iter().find(|(name, _)| name == found).map(|(_, now)| now.to_string());
            let help = former.unwrap_or_else(|| allowed(found, expected));
            (format!("unknown field `{}`{}\n{help}", truncate_name(found), of(outer)), refused)
        }
        Ron::NoSuchEnumVariant { expected, found, outer } => {
            let what = outer.as_deref().unwrap_or("name");
            (format!("unknown {what} `{}`\n{}", truncate_name(found), allowed(found, expected)), refused)
        }
        Ron::MissingStructField { field, outer } => (format!("missing field `{field}`{}", of(outer)), here),
        Ron::DuplicateStructField { field, outer } => (format!("field `{field}` is given twice{}", of(outer)), refused),
        Ron::Eof => ("the file ends too early\na closing `)` or `]` is missing".to_string(), here),
        Ron::ExpectedStructLikeEnd | Ron::ExpectedString | Ron::ExpectedArray
            if let Some(message) = field_of_value(text, end, outline) =>
        {
            (message, here)
        }
        Ron::ExpectedStructLikeEnd => (format!("expected `,` or `)`, found {}", found()), here),
        Ron::ExpectedArrayEnd => (format!("expected `,` or `]`, found {}", found()), here),
        Ron::ExpectedComma => {
            let after_digit = text[..end].trim_end_matches(' ').ends_with(|c: char| c.is_ascii_digit());
            let unit = after_digit && token(text, end).starts_with(char::is_alphabetic);
            let help = if unit { "\nnumbers have no unit: all are in SI (m, N, Pa, kg, s)" } else { "" };
            (format!("expected `,` before {}{help}", found()), here)
        }
        Ron::ExpectedFloat => {
            (with_field_path(&format!("expected a number, found {}", found()), end, text, outline), here)
        }
        Ron::ExpectedInteger => {
            (with_field_path(&format!("expected a whole number, found {}", found()), end, text, outline), here)
        }
        Ron::ExpectedBoolean => {
            (with_field_path(&format!("expected `true` or `false`, found {}", found()), end, text, outline), here)
        }
        Ron::ExpectedString => (
            with_field_path(&format!("expected a string in double quotes, found {}", found()), end, text, outline),
            here,
        ),
        Ron::ExpectedArray => {
            (with_field_path(&format!("expected a list `[...]`, found {}", found()), end, text, outline), here)
        }
        Ron::ExpectedIdentifier => {
            (with_field_path(&format!("expected a name, found {}", found()), end, text, outline), here)
        }
        Ron::ExpectedStructLike => match last_name(text, end) {
            Some(name) => (
                with_field_path(
                    &format!("`{}` needs its fields: {0}(...)", &text[name.clone()]),
                    name.start,
                    text,
                    outline,
                ),
                name,
            ),
            None => (with_field_path(&format!("expected `(`, found {}", found()), end, text, outline), here),
        },
        Ron::ExpectedNamedStructLike(name) => (
            with_field_path(&format!("expected the fields of {name}, `(...)`, found {}", found()), end, text, outline),
            here,
        ),
        Ron::ExpectedDifferentStructName { expected, found } => {
            (format!("expected `{expected}(...)`, found `{found}`"), refused)
        }
        Ron::ExceededRecursionLimit => ("brackets are nested too deeply".to_string(), here),
        Ron::TrailingCharacters => ("unexpected text after the end of the scene".to_string(), here),
        other => (with_field_path(&lowercase_first(&other.to_string()), end, text, outline), here),
    };
    Diagnosis::new(&message, span)
}

/// Returns `message` preceded by the path of the field at byte `at`.
fn with_field_path(message: &str, at: usize, text: &str, outline: &Outline) -> String {
    let at = if token(text, at).is_empty() { at.saturating_sub(1) } else { at };
    match outline.path_at(at).as_str() {
        "" => message.to_string(),
        path if path.starts_with('[') => message.to_string(),
        path => format!("{path}: {message}"),
    }
}

/// Returns the message for a field at this byte inside parentheses that take a single value, such as
/// `Mesh("a.obj", scale: 2)`; None if there is no field.
fn field_of_value(text: &str, at: usize, outline: &Outline) -> Option<String> {
    let field = token(text, at);
    let is_field = !field.is_empty()
        && text[at + field.len()..].trim_start().starts_with(':')
        && text[..at].trim_end().ends_with(['(', ',']);
    let holds = |e: &&OutlineEntry| e.name.as_ref().is_some_and(|name| name.end < at) && e.value.contains(&at);
    // Entries are in order of their end: the first that contains the byte is the innermost.
    let around = outline.entries().iter().find(|e| is_field && holds(e))?;
    let name = &text[around.name.clone()?];
    let path = outline.path(around);
    let (owner, key) = path.rsplit_once('.').unwrap_or(("the scene", &path));
    Some(format!(
        "{path}: `{name}(...)` takes one value and has no field `{}`\nfields of {owner} are written next to `{key}`: \
         `{key}: {name}(...), {0}: ...`",
        truncate_name(field)
    ))
}

/// Returns the full range of a refused value. A sign and a quote are separate steps of the parser and are included; a
/// group begins at its opening bracket, although the parser is at the closing one.
fn full_span(text: &str, span: Range<usize>, outline: &Outline) -> Range<usize> {
    if text[..span.start].ends_with(['-', '+', '"']) {
        return span.start - 1..span.end;
    }
    if text[span.start..].starts_with([')', ']'])
        && let Some(value) = outline.value_at(span.start)
    {
        return value;
    }
    span
}

/// Returns the name that ends right before this byte.
fn last_name(text: &str, at: usize) -> Option<Range<usize>> {
    let before = text[..at].trim_end();
    let name = before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next().filter(|name| !name.is_empty())?;
    Some(before.len() - name.len()..before.len())
}

/// Strips the parser's type names from a found value.
fn strip_found_type(found: &str) -> &str {
    ["the unsigned integer ", "the signed integer ", "the floating point number "]
        .iter()
        .find_map(|prefix| found.strip_prefix(prefix))
        .unwrap_or(found)
}

/// Strips the parser's type names from an expected value: they only distinguish a number with the suffix of another
/// type (`1.0f32`).
fn strip_expected_type(expected: &str) -> &str {
    if expected == "a 64-bit floating point number" { "a number without suffix" } else { expected }
}

fn lowercase_first(message: &str) -> String {
    let mut chars = message.chars();
    chars.next().map_or(String::new(), |c| c.to_lowercase().chain(chars).collect())
}

/// Returns the help with all allowed names, and with `did you mean ...` if one of them is close.
fn allowed(found: &str, expected: &[&str]) -> String {
    let close = expected.iter().map(|name| (distance(found, name), name)).min();
    let hint = match close {
        Some((steps, name)) if steps <= 2.max(name.len() / 3) => format!("did you mean `{name}`? "),
        _ => String::new(),
    };
    format!("{hint}allowed: {}", expected.join(", "))
}

/// Returns the Levenshtein distance of two names, case ignored.
fn distance(a: &str, b: &str) -> usize {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    // longer names are not typing errors, and the limit keeps the table small
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// Returns the word, number or sign that starts at this byte, cut to 60 bytes.
fn token(text: &str, at: usize) -> &str {
    let rest = &text[at.min(text.len())..];
    let word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '+');
    let length = match rest.chars().next() {
        None => 0,
        Some('"') => rest[1..].find(['"', '\n']).map_or(1, |i| i + 2),
        Some(c) if word(c) => rest.find(|c| !word(c)).unwrap_or(rest.len()),
        Some(c) => c.len_utf8(),
    };
    &rest[..floor(rest, length.min(60))]
}

/// Returns the byte offset of a position (line and column, from 1).
fn byte_of(text: &str, position: Position) -> usize {
    let mut start = 0;
    for _ in 1..position.line {
        match text[start..].find('\n') {
            Some(i) => start += i + 1,
            None => return text.len(),
        }
    }
    text[start..].char_indices().nth(position.col.saturating_sub(1)).map_or(text.len(), |(i, _)| start + i)
}
