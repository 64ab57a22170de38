//! Positions of values in the text of a scene: a scanner of a subset of RON that assigns a path and a position to every
//! field.
//!
//! serde discards positions after a value is read, but the messages of later checks across fields show the position of
//! the field. On invalid text the outline ends early.

use super::excerpt::truncate_name;
use std::ops::Range;

/// Field or list element with its position in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OutlineEntry {
    /// Node in the tree of the text.
    node: usize,
    /// Byte range of the key, or of the value if there is no key.
    pub key: Range<usize>,
    /// Byte range of the value.
    pub value: Range<usize>,
    /// Name before the parenthesis of the value, or the value itself if it is a bare name.
    pub name: Option<Range<usize>>,
}

/// Step of a path from a parent.
#[derive(Debug, Clone)]
enum Step {
    /// Whole file.
    Root,
    /// Field, with the byte range of its key.
    Key(Range<usize>),
    /// Element of a list.
    Index(usize),
}

/// Node of the tree of fields. Paths are built only on request, because the paths of a text with a long key and a long
/// list are together much larger than the text.
#[derive(Debug)]
struct Node {
    parent: usize,
    step: Step,
}

/// All entries of a text, in order of their end.
#[derive(Debug)]
pub(super) struct Outline<'a> {
    text: &'a str,
    nodes: Vec<Node>,
    entries: Vec<OutlineEntry>,
}

/// Largest number of values of a scene file, far above that of any real scene.
pub(super) const MAX_VALUES: usize = 2_000_000;

/// Largest depth of nesting: above that of any real scene, small enough for the call stack.
const MAX_DEPTH: usize = 64;

impl<'a> Outline<'a> {
    /// Scans the text; never fails.
    pub fn of(text: &'a str) -> Self {
        let nodes = vec![Node { parent: ROOT, step: Step::Root }];
        let mut scan = Scan { text, at: 0, nodes, entries: Vec::new() };
        scan.blank();
        scan.attributes();
        if scan.at < text.len() {
            scan.value(ROOT, None, 0);
        }
        Self { text, nodes: scan.nodes, entries: scan.entries }
    }

    /// Returns true if the text has more values than [`MAX_VALUES`], at which the outline ends.
    pub fn is_full(&self) -> bool {
        self.nodes.len() >= MAX_VALUES
    }

    /// Returns true if the text contains only blanks and comments.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns all entries.
    pub fn entries(&self) -> &[OutlineEntry] {
        &self.entries
    }

    /// Returns the entry of this path, or of its nearest parent in the text.
    pub fn find(&self, path: &str) -> Option<&OutlineEntry> {
        let mut path = path;
        loop {
            // of several values with the same path (`Mesh("a.obj")` and `"a.obj"`), the innermost comes first
            if let Some(entry) = self.entries.iter().find(|e| self.leads(e.node, path)) {
                return Some(entry);
            }
            path = match path.rfind(['.', '[']) {
                Some(cut) => &path[..cut],
                None if !path.is_empty() => "",
                None => return None,
            };
        }
    }

    /// Returns the path of an entry, like `gripper.pads.spacing` or `grasps[2].rotation`; enum names are not part of
    /// it, and the path of the whole file is "".
    pub fn path(&self, entry: &OutlineEntry) -> String {
        let (mut steps, mut node) = (Vec::new(), &self.nodes[entry.node]);
        while !matches!(node.step, Step::Root) {
            steps.push(&node.step);
            node = &self.nodes[node.parent];
        }
        let mut path = String::new();
        for step in steps.into_iter().rev() {
            match step {
                Step::Root => {}
                Step::Key(key) => {
                    path.push_str(if path.is_empty() { "" } else { "." });
                    path.push_str(&truncate_name(&self.text[key.clone()]));
                }
                Step::Index(index) => path.push_str(&format!("[{index}]")),
            }
        }
        path
    }

    /// Returns the last field of an entry's path; None for elements of lists and for the whole file.
    pub fn field(&self, entry: &OutlineEntry) -> Option<&'a str> {
        match &self.nodes[entry.node].step {
            Step::Key(key) => Some(&self.text[key.clone()]),
            _ => None,
        }
    }

    /// Returns true if `path` is the path of this node.
    fn leads(&self, node: usize, path: &str) -> bool {
        let (mut node, mut path) = (&self.nodes[node], path);
        loop {
            let rest = match &node.step {
                Step::Root => return path.is_empty(),
                Step::Key(key) => {
                    path.strip_suffix(&self.text[key.clone()]).map(|rest| rest.strip_suffix('.').unwrap_or(rest))
                }
                Step::Index(index) => {
                    path.strip_suffix(']').and_then(|p| p.rsplit_once('[')).and_then(|(rest, own)| {
                        let own: usize = own.parse().ok()?;
                        (own == *index).then_some(rest)
                    })
                }
            };
            let Some(rest) = rest else { return false };
            (node, path) = (&self.nodes[node.parent], rest);
        }
    }

    /// Returns the path of the innermost entry that contains this byte; "" at the top level.
    pub fn path_at(&self, at: usize) -> String {
        self.innermost(at).map_or(String::new(), |e| self.path(e))
    }

    /// Returns the value of the innermost entry that contains this byte.
    pub fn value_at(&self, at: usize) -> Option<Range<usize>> {
        self.innermost(at).map(|e| e.value.clone())
    }

    fn innermost(&self, at: usize) -> Option<&OutlineEntry> {
        let covering = |e: &&OutlineEntry| e.key.start <= at && at < e.value.end.max(e.key.end);
        self.entries.iter().filter(covering).min_by_key(|e| e.value.end - e.key.start)
    }
}

/// Index of the node of the whole file.
const ROOT: usize = 0;

struct Scan<'a> {
    text: &'a str,
    at: usize,
    nodes: Vec<Node>,
    entries: Vec<OutlineEntry>,
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

    /// Adds the node of a step from `parent`, and returns its index.
    fn node(&mut self, parent: usize, step: Step) -> usize {
        self.nodes.push(Node { parent, step });
        self.nodes.len() - 1
    }

    /// Scans one value and adds it as an entry of `node`.
    fn value(&mut self, node: usize, key: Option<Range<usize>>, depth: usize) {
        let start = self.at;
        let raw_string = self.rest().starts_with("r\"") || self.rest().starts_with("r#");
        let name = if raw_string { None } else { self.identifier() };
        let after_name = self.at;
        if name.is_some() {
            self.blank();
        }
        match self.peek() {
            Some('(' | '[' | '{') => self.group(node, name.is_some(), depth),
            Some('"') if name.is_none() => self.string(),
            _ if raw_string => self.raw_string(),
            _ if name.is_some() => self.at = after_name,
            _ => self.skip_while(|c| !c.is_whitespace() && !matches!(c, ',' | ')' | ']' | '}' | '(' | '[' | '{' | '"')),
        }
        let value = start..self.at;
        self.entries.push(OutlineEntry { node, key: key.unwrap_or(value.clone()), value, name });
    }

    /// Scans the text between brackets. The single positional value after a name (`Sphere(0.1)`, `List([...])`) is the
    /// named value itself and gets no index.
    fn group(&mut self, node: usize, named: bool, depth: usize) {
        if depth >= MAX_DEPTH || self.nodes.len() >= MAX_VALUES {
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
            if self.nodes.len() >= MAX_VALUES {
                self.at = self.text.len();
                return;
            }
            if let Some(key) = self.key() {
                let inner = self.node(node, Step::Key(key.clone()));
                self.value(inner, Some(key), depth + 1);
            } else {
                let inner = if named && index == 0 { node } else { self.node(node, Step::Index(index)) };
                index += 1;
                self.value(inner, None, depth + 1);
            }
            if self.at == start {
                // not RON: skip it
                self.at += self.peek().map_or(0, char::len_utf8);
            }
        }
        self.at += 1;
    }

    /// Scans a field name with its colon; otherwise returns None and keeps the position.
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
        // a raw identifier `r#` has no quote
        self.at =
            self.text.get(body..).and_then(|b| b.find(&close)).map_or(self.text.len(), |i| body + i + close.len());
    }
}
