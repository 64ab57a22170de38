//! Link tree of a robot with its joints and joint couplings.

use glam::{DAffine3, DVec3};

/// Maximum number of names listed in a message.
const LISTED: usize = 20;

/// Maximum number of links; bounds the growth through nested attachments of models.
pub(super) const MAX_LINKS: usize = 1 << 20;

/// Coordinate frame of a link, body or site.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub name: String,
    /// Flag: MJCF site, which may have the same name as a body.
    pub site: bool,
    /// Index of the parent link; None for a root.
    pub parent: Option<usize>,
    /// Transform from its axes to those of its parent with the joint at zero, m.
    pub pose: DAffine3,
    pub mobility: Mobility,
}

/// Mobility of a link relative to its parent.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mobility {
    Fixed,
    /// Translation along a unit vector in link axes by the position of this joint (index), m.
    Slides {
        axis: DVec3,
        joint: usize,
    },
    /// Other mobility; a message with the file position of the joint.
    Other(String),
}

/// Joint with one degree of freedom, m or rad.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    pub name: String,
    /// Lower and upper limit, or a message with the reason why there are none.
    pub range: Result<[f64; 2], String>,
    pub mimic: Option<Mimic>,
}

/// Linear coupling of a joint to another one: position = `gear * leader + offset`.
#[derive(Debug, Clone)]
pub(super) struct Mimic {
    /// Index of the leading joint.
    pub leader: usize,
    pub gear: f64,
    pub offset: f64,
}

/// Range of a joint and its driving joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct JointRange {
    /// Lower and upper limit of the position.
    pub range: [f64; 2],
    /// Index of the driving joint; its own if it is not coupled.
    pub leader: usize,
    /// Ratio of its velocity to that of the driving joint.
    pub gear: f64,
}

/// Links and joints of a robot.
#[derive(Debug, Clone, Default)]
pub(super) struct LinkTree {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
}

impl LinkTree {
    /// Returns the index of the link of this name; the prefixes `site:` and `body:` distinguish a site and a body of
    /// the same name.
    ///
    /// # Errors
    /// Fails if there is no such link, or more than one.
    pub fn find(&self, name: &str) -> Result<usize, String> {
        let of = |name: &str, kind: Option<bool>| -> Vec<usize> {
            let fits = |link: &Link| link.name == name && kind.is_none_or(|site| link.site == site);
            self.links.iter().enumerate().filter(|(_, link)| fits(link)).map(|(i, _)| i).collect()
        };
        let prefixed = [("site:", true), ("body:", false)];
        let kind = prefixed.iter().find_map(|(prefix, site)| Some((name.strip_prefix(prefix)?, *site)));
        let found = match (of(name, None), kind) {
            (found, Some((rest, site))) if found.is_empty() => of(rest, Some(site)),
            (found, _) => found,
        };
        match found[..] {
            [one] => Ok(one),
            [] => Err(format!("has no link {name:?}; it has: {}", self.names())),
            [a, b] if self.links[a].site != self.links[b].site => {
                Err(format!("has a body and a site named {name:?}; write \"site:{name}\" or \"body:{name}\""))
            }
            _ => Err(format!("has {} links named {name:?}; names must be unique", found.len())),
        }
    }

    fn names(&self) -> String {
        let named = self.links.iter().map(|link| link.name.as_str()).filter(|name| !name.is_empty());
        let mut names: Vec<&str> = named.take(LISTED + 1).collect();
        if names.len() > LISTED {
            names[LISTED] = "...";
        }
        names.join(", ")
    }

    /// Returns the range of a joint: its own, or for a coupled joint the range implied by its leader, regardless of its
    /// own limits.
    ///
    /// # Errors
    /// Fails if the driving joint has no limits, or if couplings form a cycle.
    pub fn drive(&self, joint: usize) -> Result<JointRange, String> {
        let (mut leader, mut gear, mut offset) = (joint, 1.0, 0.0);
        for _ in 0..=self.joints.len() {
            let Joint { range, mimic, name } = &self.joints[leader];
            let Some(mimic) = mimic else {
                let follows = |reason: String| match leader == joint {
                    true => reason,
                    false => format!("{reason} (joint {:?} follows {name:?})", self.joints[joint].name),
                };
                let [a, b] = range.clone().map_err(follows)?.map(|position| gear * position + offset);
                return Ok(JointRange { range: [a.min(b), a.max(b)], leader, gear });
            };
            offset += gear * mimic.offset;
            gear *= mimic.gear;
            leader = mimic.leader;
        }
        Err(format!("joint {:?} follows joints that form a cycle", self.joints[joint].name))
    }
}
