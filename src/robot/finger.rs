//! Fingers of a gripper: where their pads stand in the hand, how they slide, and what makes two of them a parallel gripper.

use super::Mount;
use super::tolerance::{ANGLE, Deviation, PLACE};
use super::tree::{JointRange, LinkTree, Mobility};
use glam::{DAffine3, DMat3, DVec3};

/// Advice on hands that are no parallel gripper.
const SPELL_OUT: &str =
    "such a hand is no parallel gripper; give opening, stroke and placement of the pads in place of robot";

/// Centre of a sensing face in the axes of the hand.
pub(super) struct Finger {
    /// Position with the joint at zero, m.
    position: DVec3,
    /// Rotation from the axes of its link to those of the hand.
    pub rotation: DMat3,
    /// Unit vector in which its joint slides.
    direction: DVec3,
    drive: JointRange,
}

impl Finger {
    /// Follows the links from `pad` up to `base`; the centre of the face is at `face` in the axes of `pad`, m. The message of an error is about
    /// the pad.
    pub fn of(tree: &LinkTree, base: usize, (pad, face): (usize, DVec3)) -> Result<Self, String> {
        let hand = &tree.links[base].name;
        let (mut at, mut pose, mut slides) = (pad, DAffine3::from_translation(face), None);
        // A description whose links carry each other in a circle ends, too.
        for _ in 0..=tree.links.len() {
            if at == base {
                let (direction, joint) = slides.ok_or_else(|| format!("does not slide on {hand:?}; {SPELL_OUT}"))?;
                let drive = tree.drive(joint).map_err(|reason| format!("slides without limits: {reason}"))?;
                return Ok(Self { position: pose.translation, rotation: pose.matrix3, direction, drive });
            }
            let link = &tree.links[at];
            match (&link.mobility, slides) {
                (Mobility::Fixed, _) => {}
                (Mobility::Slides { axis, joint }, None) => slides = Some((*axis, *joint)),
                (Mobility::Slides { .. }, Some(_)) => {
                    return Err(format!("slides on more than one joint on {hand:?}; {SPELL_OUT}"));
                }
                (Mobility::Other(joint), _) => {
                    return Err(format!("moves by a joint that does not slide on {hand:?}: {joint}; {SPELL_OUT}"));
                }
            }
            pose = link.pose * pose;
            slides = slides.map(|(direction, joint)| (link.pose.transform_vector3(direction).normalize(), joint));
            let Some(parent) = link.parent else { break };
            at = parent;
        }
        Err(format!("is not carried by {hand:?}"))
    }

    /// Returns its position in the middle of its range, m.
    fn amid(&self) -> DVec3 {
        let [a, b] = self.drive.range;
        self.position + self.direction * (0.5 * (a + b))
    }

    /// Returns the range of its joint as ways along `closing`, m, ascending, in whole picometres: what is less stems from rotations, and would
    /// hide that two descriptions are the same.
    fn along(&self, closing: DVec3) -> [f64; 2] {
        let [a, b] = self.drive.range.map(|way| whole((self.position + self.direction * way).dot(closing)));
        [a.min(b), a.max(b)]
    }

    /// Returns the way along `closing` for one of what drives it.
    fn gear(&self, closing: DVec3) -> f64 {
        self.drive.gear * self.direction.dot(closing)
    }
}

/// Rounds a length to whole picometres, m.
fn whole(length: f64) -> f64 {
    (length * 1e12).round() / 1e12
}

/// Returns the direction in which the left one of two fingers closes, hand frame, squared within `deviation`.
///
/// # Errors
/// Fails if the fingers do not slide parallel to each other and perpendicular to the approach.
pub(super) fn closing(
    [left, right]: &[Finger; 2],
    approach: DVec3,
    deviation: &mut Deviation,
) -> Result<DVec3, String> {
    if left.direction.cross(right.direction).length() > ANGLE {
        let [a, b] = [left.direction, right.direction];
        return Err(format!("the fingers slide along {a} and {b}; they must be parallel within {ANGLE} rad"));
    }
    // With the joints at zero the pads may stand behind each other.
    let apart = right.amid() - left.amid();
    let along = left.direction * if apart.dot(left.direction) < 0.0 { -1.0 } else { 1.0 };
    let closing = deviation.squared(along);
    if closing.dot(approach) != 0.0 {
        return Err(format!(
            "the fingers close along {along}; the approach {approach} must be perpendicular to that within {ANGLE} rad"
        ));
    }
    deviation.add_angle(right.direction, closing);
    Ok(closing)
}

/// Returns the pads of two fingers, the left one first, and what there is to say about fingers that one joint drives by unequal ways; what is
/// not quite a parallel gripper adds to `deviation`.
pub(super) fn gripper(
    fingers: &[Finger; 2],
    approach: DVec3,
    deviation: &mut Deviation,
) -> Result<(Mount, Option<String>), String> {
    let (closing, [left, right]) = (closing(fingers, approach, deviation)?, fingers);
    let geared = left.drive.leader == right.drive.leader;
    if geared && left.gear(closing) * right.gear(closing) >= 0.0 {
        return Err("one joint drives both fingers to the same side; the multiplier of one must change its sign".into());
    }
    let [own, other] = [left.along(closing), right.along(closing)];
    let [stroke, others] = [own, other].map(|[a, b]| whole(b - a));
    let unequal = whole(stroke - others).abs() > PLACE;
    let opening = whole(other[1] - own[0]);
    // Middle between the faces in the hand, with the fingers open and closed.
    let [open, closed] = [own[0] + other[1], own[1] + other[0]].map(|sum| whole(0.5 * sum));
    let across = approach.cross(closing);
    let of = |axis: DVec3| [left.position.dot(axis), right.position.dot(axis)].map(whole);
    let ([y, other_y], [z, other_z]) = (of(across), of(approach));
    if unequal && !geared {
        return Err(format!(
            "the fingers slide by {stroke} m and {others} m (opening {opening} m); both must slide by as much within {PLACE} m, or follow one \
             joint: {SPELL_OUT}"
        ));
    }
    // The middle of fingers that close by unequal ways moves; somewhere it is that of the hand.
    let aside = if unequal && open * closed < 0.0 {
        0.0
    } else if unequal && closed.abs() < open.abs() {
        closed
    } else {
        open
    };
    let off = [y - other_y, z - other_z, aside].map(whole);
    if off.iter().any(|length| length.abs() > PLACE) {
        return Err(format!(
            "the pads do not face each other within {PLACE} m: in the hand they stand at y {y}, z {z} and y {other_y}, z {other_z} m, \
             and {aside} m beside its middle along the closing direction; {SPELL_OUT}"
        ));
    }
    deviation.add_places(&off);
    let [y, z] = [0.5 * (y + other_y), 0.5 * (z + other_z)].map(whole);
    if !unequal {
        deviation.add_places(&[whole(stroke - others)]);
        return Ok((Mount { opening, stroke: stroke.min(others), y, z }, None));
    }
    let mean = whole(0.5 * (stroke + others));
    let notice = format!(
        "one joint closes the fingers by {stroke} m and {others} m: they are taken as two that close by {mean} m each about their common \
         middle, to which they bring a free object; in the hand that middle moves from {open} m to {closed} m along the closing direction"
    );
    Ok((Mount { opening, stroke: mean, y, z }, Some(notice)))
}
