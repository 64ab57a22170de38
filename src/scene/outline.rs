//! Where things are in a scene's text: a scanner that knows just enough RON to give every field a path and a place.
//!
//! serde forgets positions once a value is read, but checks across fields come after that, and messages should name the
//! field they are about. On broken text the outline simply ends early.

use std::ops::Range;

/// A field or list element and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Entry {
    /// Like `gripper.pads.spacing` or `grasps[2].rotation`; enum names do not count, the whole file is "".
    pub path: String,
    /// Byte range of the key, or of the value where there is no key.
    pub key: Range<usize>,
    /// Byte range of the value.
    pub value: Range<usize>,
    /// Name before the value's parenthesis, or the value itself if it is a bare name.
    pub name: Option<Range<usize>>,
}

/// All entries of a text, in order of their end.
#[derive(Debug, Default)]
pub(super) struct Outline {
    entries: Vec<Entry>,
}

/// Deeper than any scene, shallower than any stack.
const DEPTH_LIMIT: usize = 64;

impl Outline {
    /// Scans the text; never fails.
    pub fn of(text: &str) -> Self {
        let mut scan = Scan { text, at: 0, entries: Vec::new() };
        scan.blank();
        scan.attributes();
        if scan.at < text.len() {
            scan.value(String::new(), None, 0);
        }
        Self { entries: scan.entries }
    }

    /// True if the text holds nothing but blanks and comments.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// All entries.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The entry of this path, or of the nearest parent that is written out.
    pub fn find(&self, path: &str) -> Option<&Entry> {
        let mut path = path;
        loop {
            // of several values of one path (`Mesh("a.obj")` and `"a.obj"`) the innermost ends first
            if let Some(entry) = self.entries.iter().find(|e| e.path == path) {
                return Some(entry);
            }
            path = match path.rfind(['.', '[']) {
                Some(cut) => &path[..cut],
                None if !path.is_empty() => "",
                None => return None,
            };
        }
    }

    /// Path of the innermost entry that covers this byte; "" at the top.
    pub fn path_at(&self, at: usize) -> &str {
        self.innermost(at).map_or("", |e| &e.path)
    }

    /// Value of the innermost entry that covers this byte.
    pub fn value_at(&self, at: usize) -> Option<Range<usize>> {
        self.innermost(at).map(|e| e.value.clone())
    }

    fn innermost(&self, at: usize) -> Option<&Entry> {
        let covering = |e: &&Entry| e.key.start <= at && at < e.value.end.max(e.key.end);
        self.entries.iter().filter(covering).min_by_key(|e| e.value.end - e.key.start)
    }
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
    entries: Vec<Entry>,
}

impl Scan<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn skip_while(&mut self, keep: impl Fn(char) -> bool) {
        let rest = self.rest();
        self.at += rest.find(|c| !keep(c)).unwrap_or(rest.len());
    }

    /// Skips blanks and comments.
    fn blank(&mut self) {
        loop {
            self.skip_while(char::is_whitespace);
            if self.rest().starts_with("//") {
                self.skip_while(|c| c != '\n');
            } else if self.rest().starts_with("/*") {
                self.block_comment();
            } else {
                return;
            }
        }
    }

    fn block_comment(&mut self) {
        let mut level = 0;
        while self.at < self.text.len() {
            if self.rest().starts_with("/*") {
                level += 1;
                self.at += 2;
            } else if self.rest().starts_with("*/") {
                level -= 1;
                self.at += 2;
                if level == 0 {
                    return;
                }
            } else {
                self.at += self.peek().map_or(1, char::len_utf8);
            }
        }
    }

    /// Skips `#![enable(...)]` lines.
    fn attributes(&mut self) {
        while self.rest().starts_with('#') {
            self.skip_while(|c| c != ']');
            self.at = (self.at + 1).min(self.text.len());
            self.blank();
        }
    }

    fn identifier(&mut self) -> Option<Range<usize>> {
        let start = self.at;
        if self.peek().is_some_and(|c| c.is_alphabetic() || c == '_') {
            self.skip_while(|c| c.is_alphanumeric() || c == '_');
        }
        (self.at > start).then_some(start..self.at)
    }

    /// Reads one value and enters it under `path`.
    fn value(&mut self, path: String, key: Option<Range<usize>>, depth: usize) {
        let start = self.at;
        let raw_string = self.rest().starts_with("r\"") || self.rest().starts_with("r#");
        let name = if raw_string { None } else { self.identifier() };
        let after_name = self.at;
        if name.is_some() {
            self.blank();
        }
        match self.peek() {
            Some('(' | '[' | '{') => self.group(&path, name.is_some(), depth),
            Some('"') if name.is_none() => self.string(),
            _ if raw_string => self.raw_string(),
            _ if name.is_some() => self.at = after_name,
            _ => self.skip_while(|c| !c.is_whitespace() && !matches!(c, ',' | ')' | ']' | '}' | '(' | '[' | '{' | '"')),
        }
        let value = start..self.at;
        self.entries.push(Entry { path, key: key.unwrap_or(value.clone()), value, name });
    }

    /// Reads what stands between brackets. The only positional value after a name (`Sphere(0.1)`, `List([...])`) is the
    /// named value itself and takes no index.
    fn group(&mut self, path: &str, named: bool, depth: usize) {
        if depth >= DEPTH_LIMIT {
            self.at = self.text.len();
            return;
        }
        self.at += 1;
        let mut index = 0;
        loop {
            self.blank();
            match self.peek() {
                None => return,
                Some(')' | ']' | '}') => break,
                Some(',') => {
                    self.at += 1;
                    continue;
                }
                _ => {}
            }
            let start = self.at;
            if let Some(key) = self.key() {
                let dot = if path.is_empty() { "" } else { "." };
                let inner = format!("{path}{dot}{}", &self.text[key.clone()]);
                self.value(inner, Some(key), depth + 1);
            } else {
                let inner = if named && index == 0 { path.to_string() } else { format!("{path}[{index}]") };
                index += 1;
                self.value(inner, None, depth + 1);
            }
            if self.at == start {
                // nothing that RON knows: step over it
                self.at += self.peek().map_or(0, char::len_utf8);
            }
        }
        self.at += 1;
    }

    /// A field name with its colon, or nothing and no move.
    fn key(&mut self) -> Option<Range<usize>> {
        let start = self.at;
        let key = self.identifier();
        self.blank();
        if key.is_some() && self.peek() == Some(':') {
            self.at += 1;
            self.blank();
            return key;
        }
        self.at = start;
        None
    }

    fn string(&mut self) {
        let mut escaped = false;
        let end = self.rest().char_indices().skip(1).find(|&(_, c)| {
            let closes = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            closes
        });
        self.at = end.map_or(self.text.len(), |(i, _)| self.at + i + 1);
    }

    fn raw_string(&mut self) {
        self.at += 1;
        let hashes = self.rest().len() - self.rest().trim_start_matches('#').len();
        let close = format!("\"{}", "#".repeat(hashes));
        let body = (self.at + hashes + 1).min(self.text.len());
        // a lone `r#` of a raw identifier has no quote to find
        self.at =
            self.text.get(body..).and_then(|b| b.find(&close)).map_or(self.text.len(), |i| body + i + close.len());
    }
}
