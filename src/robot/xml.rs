//! Elements of XML files, each with its place, and the numbers in their attributes.

use super::tolerance::ANGLE;
use crate::files::include::{SIZE_LIMIT, may_include};
use crate::files::regular;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::f64::consts::TAU;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Largest number of elements that stand in each other: trees of this depth are walked by functions that call themselves.
pub(super) const DEPTH: usize = 256;

/// Text of a file.
#[derive(Debug)]
struct XmlText {
    path: PathBuf,
    text: String,
    /// Offsets of the first bytes of its lines.
    lines: Vec<usize>,
}

impl XmlText {
    fn new(path: &Path, text: String) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(newline, _)| newline + 1)).collect();
        Self { path: path.to_path_buf(), text, lines }
    }

    /// Returns a message about the byte at this offset; its column counts bytes.
    fn error(&self, at: usize, message: impl Display) -> String {
        let line = self.lines.partition_point(|start| *start <= at);
        format!("{}:{line}:{}: {message}", self.path.display(), at - self.lines[line - 1] + 1)
    }
}

#[derive(Debug, Clone)]
struct Attribute {
    name: String,
    value: String,
    /// Offset of its first byte in the text of its file.
    at: usize,
}

/// Element with its attributes and the elements in it.
#[derive(Debug, Clone)]
pub(super) struct XmlElement {
    pub tag: String,
    pub children: Vec<XmlElement>,
    attributes: Vec<Attribute>,
    text: Rc<XmlText>,
    /// Offset of its first byte in the text.
    at: usize,
}

impl XmlElement {
    fn new(tag: &BytesStart, at: usize, text: &Rc<XmlText>) -> Result<Self, String> {
        let unreadable = |e: &dyn Display| text.error(at, format!("is no readable XML: {e}"));
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

    /// Returns a message about the element, with its place.
    pub fn error(&self, message: impl Display) -> String {
        let name = self.text("name").map_or(String::new(), |name| format!(" name={name:?}"));
        self.text.error(self.at, format!("<{}{name}> {message}", self.tag))
    }

    /// Returns the folder of its file.
    pub fn folder(&self) -> &Path {
        self.text.path.parent().unwrap_or(Path::new(""))
    }

    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Returns the text of an attribute; None if it has none of this name.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.as_str())
    }

    /// Returns the text of an attribute.
    ///
    /// # Errors
    /// Fails if it has none of this name.
    pub fn needed(&self, name: &str) -> Result<&str, String> {
        self.text(name).ok_or_else(|| self.error(format_args!("has no {name}=\"...\"")))
    }

    /// Returns the first child of this tag.
    pub fn child(&self, tag: &str) -> Option<&XmlElement> {
        self.each(tag).next()
    }

    /// Iterates over the children of this tag.
    pub fn each(&self, tag: &str) -> impl Iterator<Item = &XmlElement> {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// Returns the finite numbers of an attribute; None if it has none of this name.
    ///
    /// # Errors
    /// Fails if a word of it is no such number.
    pub fn list(&self, name: &str) -> Result<Option<Vec<f64>>, String> {
        let Some(attribute) = self.attribute(name) else { return Ok(None) };
        let number = |word: &str| {
            let parsed = word.parse().ok().filter(|v: &f64| v.is_finite());
            parsed.ok_or_else(|| self.misspelt(attribute, format_args!("{word:?} is no number")))
        };
        attribute.value.split_whitespace().map(number).collect::<Result<_, _>>().map(Some)
    }

    /// Returns this many finite numbers of an attribute; None if it has none of this name.
    ///
    /// # Errors
    /// Fails if they are fewer or more, or no such numbers.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, String> {
        let (Some(list), Some(attribute)) = (self.list(name)?, self.attribute(name)) else { return Ok(None) };
        let count = list.len();
        let wrong = |_| self.misspelt(attribute, format_args!("{count} numbers; {N} needed"));
        list.try_into().map(Some).map_err(wrong)
    }

    /// Returns the finite number of an attribute; None if it has none of this name.
    ///
    /// # Errors
    /// Fails if it is no such number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, String> {
        Ok(self.numbers::<1>(name)?.map(|[v]| v))
    }

    /// Says whether angles of an attribute, rad, are such: more than a turn is taken for degrees.
    ///
    /// # Errors
    /// Fails if one is more than a turn.
    pub fn radians(&self, name: &str, angles: &[f64]) -> Result<(), String> {
        match (angles.iter().find(|angle| angle.abs() > TAU + ANGLE), self.attribute(name)) {
            (Some(angle), Some(attribute)) => {
                let right = angle.to_radians();
                let advice = format_args!("angles are in radians here, {angle} degrees are {right:.7}");
                Err(self.misspelt(attribute, format_args!("{angle} is more than a turn: {advice}")))
            }
            _ => Ok(()),
        }
    }

    fn misspelt(&self, attribute: &Attribute, message: impl Display) -> String {
        let (tag, name, value) = (&self.tag, &attribute.name, &attribute.value);
        self.text.error(attribute.at, format_args!("<{tag} {name}={value:?}>: {message}"))
    }

    /// Returns the element, without its children, with those attributes of `base` that it lacks and for which `may` is true.
    pub fn over(&self, base: &XmlElement, may: impl Fn(&str) -> bool) -> XmlElement {
        let lacks = |attribute: &&Attribute| self.text(&attribute.name).is_none() && may(&attribute.name);
        let inherited = base.attributes.iter().filter(lacks);
        XmlElement {
            attributes: self.attributes.iter().chain(inherited).cloned().collect(),
            children: Vec::new(),
            ..self.clone()
        }
    }
}

/// Reader of a file and of those that it includes, within bounds.
#[derive(Default)]
pub(super) struct XmlReader {
    /// Canonical paths of the files being read, outermost first.
    chain: Vec<PathBuf>,
    files: usize,
    bytes: u64,
}

impl XmlReader {
    /// Reads the file at `path` with `inside`, which may read the files that it names; `by` is the element that names it.
    ///
    /// # Errors
    /// Fails if there is no regular file, it is too large, no XML, too deep, or included in a circle, and if `inside` fails.
    pub fn file<T>(
        &mut self,
        path: &Path,
        by: Option<&XmlElement>,
        inside: impl FnOnce(XmlElement, &mut Self) -> Result<T, String>,
    ) -> Result<T, String> {
        let at = |message: String| by.map_or(message.clone(), |element| element.error(message));
        may_include(path, &self.chain, self.files).map_err(at)?;
        let bytes = regular::read(path, SIZE_LIMIT - self.bytes).map_err(|e| at(plain(&e)))?;
        self.bytes += bytes.len() as u64;
        self.files += 1;
        let text = String::from_utf8(bytes).map_err(|e| {
            let read = &e.as_bytes()[..e.utf8_error().valid_up_to()];
            let line = 1 + read.iter().filter(|byte| **byte == b'\n').count();
            format!("{}:{line}: is no UTF-8 text; save it as UTF-8", path.display())
        })?;
        let root = parse(XmlText::new(path, text))?;
        self.chain.push(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()));
        let read = inside(root, self)?;
        self.chain.pop();
        Ok(read)
    }
}

/// Returns the message of an error without its first word.
pub(super) fn plain(error: &crate::error::Error) -> String {
    let message = error.to_string();
    message.strip_prefix("error: ").map(str::to_string).unwrap_or(message)
}

/// Returns the outermost element of a text.
fn parse(text: XmlText) -> Result<XmlElement, String> {
    let text = Rc::new(text);
    let mut reader = Reader::from_str(&text.text);
    let (mut open, mut root): (Vec<XmlElement>, Option<XmlElement>) = (Vec::new(), None);
    loop {
        let at = reader.buffer_position() as usize;
        let event = reader
            .read_event()
            .map_err(|e| text.error(reader.error_position() as usize, format_args!("is no readable XML: {e}")))?;
        let done = match event {
            Event::Start(tag) | Event::Empty(tag) if open.len() == DEPTH => {
                let tag = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
                return Err(text.error(at, format_args!("<{tag}> stands in more than {DEPTH} elements")));
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
            None if root.is_some() => return Err(done.error("stands outside of the first element")),
            None => root = Some(done),
        }
    }
    match (open.pop(), root) {
        (Some(element), _) => Err(element.error("is not closed")),
        (None, Some(root)) => Ok(root),
        (None, None) => Err(text.error(0, "is no readable XML: it has no element")),
    }
}
