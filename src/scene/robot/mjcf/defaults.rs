//! Element `<default>`: classes of default attributes.

use super::orientation::ORIENTATIONS;
use crate::robot::xml::XmlElement;
use std::collections::HashMap;

/// Name of the root class.
pub(super) const MAIN: &str = "main";

/// Default attributes by class and element tag.
#[derive(Default)]
pub(super) struct Defaults {
    classes: HashMap<String, HashMap<String, XmlElement>>,
}

impl Defaults {
    /// Adds the class `of` with parent class `parent`, and its nested classes.
    pub fn add(&mut self, of: &XmlElement, parent: &str) {
        let name = of.text("class").unwrap_or(parent).to_string();
        let inherited = self.classes.get(&name).or_else(|| self.classes.get(parent));
        let mut tags = inherited.cloned().unwrap_or_default();
        for own in of.children.iter().filter(|child| child.tag != "default") {
            let merged = tags.get(&own.tag).map_or_else(|| own.clone(), |base| inherit(own, base));
            tags.insert(own.tag.clone(), merged);
        }
        self.classes.insert(name.clone(), tags);
        of.children_with_tag("default").for_each(|inner| self.add(inner, &name));
    }

    /// Returns an element with the default attributes of its own class, or of `class` if it names none.
    ///
    /// # Errors
    /// Fails if the class does not exist.
    pub fn apply(&self, element: &XmlElement, class: &str) -> Result<XmlElement, String> {
        let class = element.text("class").unwrap_or(class);
        match self.classes.get(class) {
            Some(tags) => Ok(tags.get(&element.tag).map_or_else(|| element.clone(), |base| inherit(element, base))),
            None if class == MAIN => Ok(element.clone()),
            None => Err(element.error(format_args!("is of the class {class:?}, which does not exist"))),
        }
    }
}

fn inherit(own: &XmlElement, base: &XmlElement) -> XmlElement {
    // An own orientation overrides an inherited one in any form.
    let turned = ORIENTATIONS.iter().any(|form| own.text(form).is_some());
    own.with_defaults(base, |name| name != "name" && name != "class" && !(turned && ORIENTATIONS.contains(&name)))
}
