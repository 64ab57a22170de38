//! Tree of the links of a robot, the joints that they hang on, and which joints follow others.

use glam::{DAffine3, DVec3};

/// Largest number of names that a message lists.
const LISTED: usize = 20;

/// Largest number of links: models that are attached to models multiply.
pub(super) const LINKS: usize = 1 << 20;

/// Coordinate system of a link, of a body or of a site.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub name: String,
    /// Flag: a site of MJCF, which may have the name of a body.
    pub site: bool,
    /// Number of the link that carries it; None for a root.
    pub parent: Option<usize>,
    /// Map from its axes to those of its parent, m, with its joint at zero.
    pub pose: DAffine3,
    pub mobility: Mobility,
}

/// Mobility of a link on its parent.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mobility {
    Fixed,
    /// Translation along a unit vector of the link, by the position of the joint of this number, m.
    Slides {
        axis: DVec3,
        joint: usize,
    },
    /// Any other way, in words, with the place of its joint.
    Other(String),
}

/// Joint with one position, m or rad.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    pub name: String,
    /// Lowest and highest position, or the reason why it has none, with its place.
    pub range: Result<[f64; 2], String>,
    pub mimic: Option<Mimic>,
}

/// Rule by which the position of a joint follows that of another one: `gear * leader + offset`.
#[derive(Debug, Clone)]
pub(super) struct Mimic {
    /// Number of the joint that it follows.
    pub leader: usize,
    pub gear: f64,
    pub offset: f64,
}

/// Range of a joint, and what moves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct JointRange {
    /// Lowest and highest position.
    pub range: [f64; 2],
    /// Number of the joint that it follows, its own if it follows none.
    pub leader: usize,
    /// Ratio of its speed to that of the leader.
    pub gear: f64,
}

/// Links of a robot, with their joints.
#[derive(Debug, Clone, Default)]
pub(super) struct LinkTree {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
}

impl LinkTree {
    /// Returns the number of the link of this name; `site:NAME` and `body:NAME` ask for one of two that share it.
    ///
    /// # Errors
    /// Fails if there is none, or more than one.
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
            _ => Err(format!("has {} links named {name:?}; a name may stand for one", found.len())),
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

    /// Returns the range of a joint: its own, or what follows from that of the joint that it follows, whatever its own limits.
    ///
    /// # Errors
    /// Fails if the leader has no limits, or joints follow each other in a circle.
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
        Err(format!("joint {:?} follows joints that follow each other in a circle", self.joints[joint].name))
    }
}
