//! Parallel grippers of robots: where the pads of a description in URDF or MJCF stand, and how far its fingers slide.

mod fem;
mod mjcf;
mod soft;
mod urdf;

pub use soft::SoftPad;

use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use std::path::Path;

/// Largest length, m, and sine by which two fingers of one gripper may differ: descriptions are written by hand.
const SLACK: f64 = 1e-6;

/// Coordinate system of a link, of a body or of a site.
#[derive(Debug, Clone)]
struct Link {
    name: String,
    /// Number of the link that carries it; None for a root.
    parent: Option<usize>,
    /// Rotation and translation from it to its parent, with its joint at zero.
    rotation: DQuat,
    position: DVec3,
    joint: Joint,
}

/// Joint by which a link hangs on its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Joint {
    Fixed,
    /// Slides along a unit vector of the link, m.
    Slides {
        axis: DVec3,
        range: [f64; 2],
    },
    /// Moves in any other way.
    Other,
}

/// Pads of a parallel gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Largest distance between the two sensing faces, m.
    pub opening: f64,
    /// Travel of each finger, m.
    pub stroke: f64,
    /// Centre of the sensing faces along the finger width, m, hand frame.
    pub y: f64,
    /// Centre of the sensing faces along the approach, m, hand frame.
    pub z: f64,
}

/// Reads the description at `path`, URDF (`.urdf`) or MJCF (`.xml`), and finds the pads whose sensing faces are centred at the links `pads`,
/// left first, on the hand whose base is the link `hand`; `approach` is the direction of the approach in its axes.
///
/// Links of a URDF that have a `<fem>` are soft pads: then the sensing faces are where their meshes say, and the pads are returned, too.
///
/// # Errors
/// Fails if the file cannot be read, lacks a link, its fingers are no parallel gripper, or a soft pad cannot be read or bonded; the message
/// says why.
pub fn mount(
    path: &Path,
    hand: &str,
    pads: [&str; 2],
    approach: DVec3,
) -> Result<(Mount, Option<[SoftPad; 2]>), String> {
    let (links, collisions, soft) = match path.extension().and_then(|e| e.to_str()) {
        Some("urdf") => {
            let (links, collisions) = urdf::read(path)?;
            (links, collisions, fem::read(path)?)
        }
        Some("xml") => (mjcf::read(path)?, Vec::new(), BTreeMap::new()),
        _ => return Err("is no description of a robot; allowed: URDF (.urdf), MJCF (.xml)".into()),
    };
    let find = |name: &str| {
        let none = || {
            let names: Vec<&str> =
                links.iter().map(|link| link.name.as_str()).filter(|name| !name.is_empty()).collect();
            format!("has no link {name:?}; it has: {}", names.join(", "))
        };
        links.iter().position(|link| link.name == name).ok_or_else(none)
    };
    let base = find(hand)?;
    let ends = [find(pads[0])?, find(pads[1])?];
    let finger = |side: usize, face: DVec3| {
        Finger::of(&links, base, (ends[side], face)).map_err(|m| format!("{:?} {m} {hand:?}", pads[side]))
    };
    let tags = match pads.map(|name| soft.get(name)) {
        [Some(left), Some(right)] => [left, right],
        [None, None] => return Ok((gripper([finger(0, DVec3::ZERO)?, finger(1, DVec3::ZERO)?], approach)?, None)),
        _ => return Err(format!("has a <fem> for one of the links {:?} and {:?}, not for both", pads[0], pads[1])),
    };
    let fingers = [finger(0, tags[0].position)?, finger(1, tags[1].position)?];
    let closing = closing(&fingers);
    let place = |side: usize, closing: DVec3| {
        let to_link = fingers[side].rotation.inverse();
        soft::place(path, (&links, &collisions), ends[side], tags[side], [to_link * closing, to_link * approach])
    };
    let ((left, left_face), (right, right_face)) = (place(0, closing)?, place(1, -closing)?);
    Ok((gripper([finger(0, left_face)?, finger(1, right_face)?], approach)?, Some([left, right])))
}

/// Centre of a sensing face in the axes of the hand.
struct Finger {
    /// Position with the joint at zero, m.
    position: DVec3,
    /// Rotation from the axes of its link to those of the hand.
    rotation: DQuat,
    /// Direction in which its joint slides.
    direction: DVec3,
    range: [f64; 2],
}

impl Finger {
    /// Follows the links from `pad` up to `base`; the centre of the face is at `face` in the axes of `pad`, m. The message of an error is about the pad, and ends before the name of the hand.
    fn of(links: &[Link], base: usize, (pad, face): (usize, DVec3)) -> Result<Self, &'static str> {
        let (mut at, mut position, mut rotation, mut slides) = (pad, face, DQuat::IDENTITY, None);
        // A description whose links carry each other in a circle ends, too.
        for _ in 0..=links.len() {
            if at == base {
                let (direction, range) = slides.ok_or("does not slide on")?;
                return Ok(Self { position, rotation, direction, range });
            }
            let link = &links[at];
            match (link.joint, slides) {
                (Joint::Fixed, _) => {}
                (Joint::Slides { axis, range }, None) => slides = Some((axis, range)),
                (Joint::Slides { .. }, Some(_)) => return Err("slides on more than one joint on"),
                (Joint::Other, _) => return Err("moves by a joint that does not slide on"),
            }
            position = link.rotation * position + link.position;
            rotation = link.rotation * rotation;
            slides = slides.map(|(direction, range)| (link.rotation * direction, range));
            at = link.parent.ok_or("is not carried by")?;
        }
        Err("is not carried by")
    }

    /// Returns its position in the middle of its range, m.
    fn amid(&self) -> DVec3 {
        self.position + self.direction * (0.5 * (self.range[0] + self.range[1]))
    }

    /// Returns the range of its joint as ways along `closing`, m, ascending.
    fn along(&self, closing: DVec3) -> [f64; 2] {
        let [a, b] = self.range.map(|way| (self.position + self.direction * way).dot(closing));
        [a.min(b), a.max(b)]
    }
}

/// Returns the direction in which the left one of two fingers closes, hand frame.
fn closing([left, right]: &[Finger; 2]) -> DVec3 {
    // With the joints at zero the pads may stand behind each other.
    let apart = right.amid() - left.amid();
    left.direction * if apart.dot(left.direction) < 0.0 { -1.0 } else { 1.0 }
}

/// Returns the pads of two fingers, the left one first.
fn gripper(fingers: [Finger; 2], approach: DVec3) -> Result<Mount, String> {
    let (closing, [left, right]) = (closing(&fingers), fingers);
    if left.direction.cross(right.direction).length() > SLACK {
        return Err(format!(
            "the fingers slide along {} and {}; they must be parallel",
            left.direction, right.direction
        ));
    }
    if closing.dot(approach).abs() > SLACK {
        return Err(format!(
            "the fingers close along {closing}; the approach {approach} must be perpendicular to that"
        ));
    }
    let [own, other] = [left.along(closing), right.along(closing)];
    let (stroke, others) = (own[1] - own[0], other[1] - other[0]);
    if (stroke - others).abs() > SLACK {
        return Err(format!("the fingers slide by {stroke} m and {others} m; both must slide by as much"));
    }
    let across = approach.cross(closing);
    let of = |axis: DVec3| [left.position.dot(axis), right.position.dot(axis)];
    let ([y, other_y], [z, other_z]) = (of(across), of(approach));
    let aside = 0.5 * (own[0] + other[1]);
    if (y - other_y).abs() > SLACK || (z - other_z).abs() > SLACK || aside.abs() > SLACK {
        return Err(format!(
            "the pads do not face each other: in the hand they stand at y {y}, z {z} and y {other_y}, z {other_z} m, \
             and {aside} m beside its middle along the closing direction"
        ));
    }
    // Whole picometres: what is less stems from the rotations, and would hide that two descriptions are the same.
    let [opening, stroke, y, z] = [other[1] - own[0], stroke, y, z].map(|v| (v * 1e12).round() / 1e12);
    Ok(Mount { opening, stroke, y, z })
}
