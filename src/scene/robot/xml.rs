//! XML elements with their file positions, and numbers in their attributes.

use super::tolerance::ANGLE_TOLERANCE;
use base::files::include::{MAX_TOTAL_SIZE, check_include};
use base::files::regular;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::f64::consts::TAU;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Maximum nesting depth of elements, because trees are traversed recursively.
pub(super) const MAX_DEPTH: usize = 256;

/// Text of an XML file.
#[derive(Debug)]
struct XmlText {
    path: PathBuf,
    text: String,
    /// Byte offsets of the line starts.
    lines: Vec<usize>,
}

impl XmlText {
    fn new(path: &Path, text: String) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(newline, _)| newline + 1)).collect();
        Self { path: path.to_path_buf(), text, lines }
    }

    /// Returns a message with file, line and column of the byte offset `at`; the column counts bytes.
    fn error(&self, at: usize, message: impl Display) -> String {
        let line = self.lines.partition_point(|start| *start <= at);
        format!("{}:{line}:{}: {message}", self.path.display(), at - self.lines[line - 1] + 1)
    }
}

#[derive(Debug, Clone)]
struct Attribute {
    name: String,
    value: String,
    /// Byte offset in the text of its file.
    at: usize,
}

/// Element with its attributes and children.
#[derive(Debug, Clone)]
pub(super) struct XmlElement {
    pub tag: String,
    pub children: Vec<XmlElement>,
    attributes: Vec<Attribute>,
    text: Rc<XmlText>,
    /// Byte offset in the text.
    at: usize,
}

impl XmlElement {
    fn new(tag: &BytesStart, at: usize, text: &Rc<XmlText>) -> Result<Self, String> {
        let unreadable = |e: &dyn Display| text.error(at, format!("is not valid XML: {e}"));
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|e| unreadable(&e))?;
            let name = attribute.key.as_ref();
            attributes.push(Attribute {
                value: attribute.unescape_value().map_err(|e| unreadable(&e))?.into_owned(),
                at: (name.as_ptr() as usize).saturating_sub(text.text.as_ptr() as usize),
                name: String::from_utf8_lossy(name).into_owned(),
            });
        }
        let tag = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
        Ok(Self { tag, children: Vec::new(), attributes, text: Rc::clone(text), at })
    }

    /// Returns a message about the element with its file position.
    pub fn error(&self, message: impl Display) -> String {
        let name = self.text("name").map_or(String::new(), |name| format!(" name={name:?}"));
        self.text.error(self.at, format!("<{}{name}> {message}", self.tag))
    }

    /// Returns the folder of the file that contains the element.
    pub fn folder(&self) -> &Path {
        self.text.path.parent().unwrap_or(Path::new(""))
    }

    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Returns the text of an attribute; None if it is missing.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.as_str())
    }

    /// Returns the text of a required attribute.
    ///
    /// # Errors
    /// Fails if it is missing.
    pub fn required_text(&self, name: &str) -> Result<&str, String> {
        self.text(name).ok_or_else(|| self.error(format_args!("has no {name}=\"...\"")))
    }

    /// Returns the first child with this tag.
    pub fn child(&self, tag: &str) -> Option<&XmlElement> {
        self.children_with_tag(tag).next()
    }

    /// Iterates over the children with this tag.
    pub fn children_with_tag(&self, tag: &str) -> impl Iterator<Item = &XmlElement> {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// Returns the numbers of an attribute; None if it is missing.
    ///
    /// # Errors
    /// Fails if a word is not a finite number.
    pub fn list(&self, name: &str) -> Result<Option<Vec<f64>>, String> {
        let Some(attribute) = self.attribute(name) else { return Ok(None) };
        let number = |word: &str| {
            let parsed = word.parse().ok().filter(|v: &f64| v.is_finite());
            parsed.ok_or_else(|| self.misspelt(attribute, format_args!("{word:?} is not a number")))
        };
        attribute.value.split_whitespace().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Returns the `N` numbers of an attribute; None if it is missing.
    ///
    /// # Errors
    /// Fails if there are fewer or more, or if they are not finite numbers.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, String> {
        let (Some(list), Some(attribute)) = (self.list(name)?, self.attribute(name)) else { return Ok(None) };
        let count = list.len();
        let wrong = |_| self.misspelt(attribute, format_args!("{count} numbers; {N} needed"));
        list.try_into().map(Some).map_err(wrong)
    }

    /// Returns the number of an attribute; None if it is missing.
    ///
    /// # Errors
    /// Fails if it is not one finite number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, String> {
        Ok(self.numbers::<1>(name)?.map(|[v]| v))
    }

    /// Checks that angles of an attribute are in radians: larger ones than a full turn are assumed to be in degrees.
    ///
    /// # Errors
    /// Fails if an angle exceeds a full turn.
    pub fn check_radians(&self, name: &str, angles: &[f64]) -> Result<(), String> {
        match (angles.iter().find(|angle| angle.abs() > TAU + ANGLE_TOLERANCE), self.attribute(name)) {
            (Some(angle), Some(attribute)) => {
                let right = angle.to_radians();
                let advice = format_args!("angles are in radians here, {angle} degrees are {right:.7}");
                Err(self.misspelt(attribute, format_args!("{angle} is more than a full turn: {advice}")))
            }
            _ => Ok(()),
        }
    }

    fn misspelt(&self, attribute: &Attribute, message: impl Display) -> String {
        let (tag, name, value) = (&self.tag, &attribute.name, &attribute.value);
        self.text.error(attribute.at, format_args!("<{tag} {name}={value:?}>: {message}"))
    }

    /// Returns the element without its children, plus those attributes of `base` that it lacks and for which `may` is
    /// true.
    pub fn with_defaults(&self, base: &XmlElement, may: impl Fn(&str) -> bool) -> XmlElement {
        let lacks = |attribute: &&Attribute| self.text(&attribute.name).is_none() && may(&attribute.name);
        let inherited = base.attributes.iter().filter(lacks);
        XmlElement {
            attributes: self.attributes.iter().chain(inherited).cloned().collect(),
            children: Vec::new(),
            ..self.clone()
        }
    }
}

/// Reader of a file and its includes, with limits on their number and total size.
#[derive(Default)]
pub(super) struct XmlReader {
    /// Canonical paths of the files being read, outermost first.
    chain: Vec<PathBuf>,
    files: usize,
    bytes: u64,
}

impl XmlReader {
    /// Parses the file at `path` and calls `inside`, which may read further files; `by` is the element that refers to
    /// the file.
    ///
    /// # Errors
    /// Fails if the file is missing, not regular, too large, not XML, too deeply nested or included recursively, and if
    /// `inside` fails.
    pub fn file<T>(
        &mut self,
        path: &Path,
        by: Option<&XmlElement>,
        inside: impl FnOnce(XmlElement, &mut Self) -> Result<T, String>,
    ) -> Result<T, String> {
        let at = |message: String| by.map_or(message.clone(), |element| element.error(message));
        check_include(path, &self.chain, self.files).map_err(at)?;
        let bytes = regular::read(path, MAX_TOTAL_SIZE - self.bytes).map_err(|e| at(without_prefix(&e)))?;
        self.bytes += bytes.len() as u64;
        self.files += 1;
        let text = String::from_utf8(bytes).map_err(|e| {
            let read = &e.as_bytes()[..e.utf8_error().valid_up_to()];
            let line = 1 + read.iter().filter(|byte| **byte == b'\n').count();
            format!("{}:{line}: is not UTF-8 text; save it as UTF-8", path.display())
        })?;
        let root = parse(XmlText::new(path, text))?;
        self.chain.push(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()));
        let read = inside(root, self)?;
        self.chain.pop();
        Ok(read)
    }
}

/// Returns the message of an error without the prefix `error: `.
pub(super) fn without_prefix(error: &base::error::Error) -> String {
    let message = error.to_string();
    message.strip_prefix("error: ").map(str::to_string).unwrap_or(message)
}

/// Parses a text; returns its root element.
fn parse(text: XmlText) -> Result<XmlElement, String> {
    let text = Rc::new(text);
    let mut reader = Reader::from_str(&text.text);
    let (mut open, mut root): (Vec<XmlElement>, Option<XmlElement>) = (Vec::new(), None);
    loop {
        let at = reader.buffer_position() as usize;
        let event = reader
            .read_event()
            .map_err(|e| text.error(reader.error_position() as usize, format_args!("is not valid XML: {e}")))?;
        let done = match event {
            Event::Start(tag) | Event::Empty(tag) if open.len() == MAX_DEPTH => {
                let tag = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
                return Err(text.error(at, format_args!("<{tag}> is nested in more than {MAX_DEPTH} elements")));
            }
            Event::Start(tag) => {
                open.push(XmlElement::new(&tag, at, &text)?);
                None
            }
            Event::Empty(tag) => Some(XmlElement::new(&tag, at, &text)?),
            Event::End(_) => open.pop(),
            Event::Eof => break,
            _ => None,
        };
        let Some(done) = done else { continue };
        match open.last_mut() {
            Some(parent) => parent.children.push(done),
            None if root.is_some() => return Err(done.error("is outside of the root element")),
            None => root = Some(done),
        }
    }
    match (open.pop(), root) {
        (Some(element), _) => Err(element.error("is not closed")),
        (None, Some(root)) => Ok(root),
        (None, None) => Err(text.error(0, "is not valid XML: it has no element")),
    }
}
