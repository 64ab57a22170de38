//! Fingers of a gripper: poses of their pads in the hand, their sliding joints, and the conditions for a parallel
//! gripper.

use super::mounting::Mount;
use super::tolerance::{ANGLE_TOLERANCE, Deviation, POSITION_TOLERANCE};
use super::tree::{JointRange, LinkTree, Mobility};
use glam::{DAffine3, DMat3, DVec3};

/// Advice for hands that are not parallel grippers.
const ADVICE: &str =
    "such a hand is not a parallel gripper; give opening, stroke and placement of the pads instead of robot";

/// Finger: centre of its sensing face and its sliding joint, in hand axes.
pub(super) struct Finger {
    /// Centre of the sensing face with the joint at zero, m.
    position: DVec3,
    /// Rotation from link axes to hand axes.
    pub rotation: DMat3,
    /// Unit sliding direction of its joint.
    direction: DVec3,
    drive: JointRange,
}

impl Finger {
    /// Composes the transforms from link `pad` up to `base`; `face` is the centre of the sensing face in the axes of
    /// `pad`, m. Error messages refer to the pad.
    pub fn of(tree: &LinkTree, base: usize, (pad, face): (usize, DVec3)) -> Result<Self, String> {
        let hand = &tree.links[base].name;
        let (mut at, mut pose, mut slides) = (pad, DAffine3::from_translation(face), None);
        // The bound terminates the loop if the links form a cycle.
        for _ in 0..=tree.links.len() {
            if at == base {
                let (direction, joint) =
                    slides.ok_or_else(|| format!("does not slide relative to {hand:?}; {ADVICE}"))?;
                let drive = tree.drive(joint).map_err(|reason| format!("slides without limits: {reason}"))?;
                return Ok(Self { position: pose.translation, rotation: pose.matrix3, direction, drive });
            }
            let link = &tree.links[at];
            match (&link.mobility, slides) {
                (Mobility::Fixed, _) => {}
                (Mobility::Slides { axis, joint }, None) => slides = Some((*axis, *joint)),
                (Mobility::Slides { .. }, Some(_)) => {
                    return Err(format!("slides by more than one joint relative to {hand:?}; {ADVICE}"));
                }
                (Mobility::Other(joint), _) => {
                    return Err(format!("is connected to {hand:?} by a joint that does not slide: {joint}; {ADVICE}"));
                }
            }
            pose = link.pose * pose;
            slides = slides.map(|(direction, joint)| (link.pose.transform_vector3(direction).normalize(), joint));
            let Some(parent) = link.parent else { break };
            at = parent;
        }
        Err(format!("is not a descendant of {hand:?}"))
    }

    /// Returns the centre of the sensing face with the joint in the middle of its range, m.
    fn midpoint(&self) -> DVec3 {
        let [a, b] = self.drive.range;
        self.position + self.direction * (0.5 * (a + b))
    }

    /// Returns the range of the face position along `closing`, m, ascending, rounded to picometres: smaller differences
    /// are rounding errors of rotations, which would make equal descriptions differ.
    fn range_along(&self, closing: DVec3) -> [f64; 2] {
        let [a, b] =
            self.drive.range.map(|way| round_to_picometres((self.position + self.direction * way).dot(closing)));
        [a.min(b), a.max(b)]
    }

    /// Returns the displacement along `closing` per unit of the driving joint.
    fn gear(&self, closing: DVec3) -> f64 {
        self.drive.gear * self.direction.dot(closing)
    }
}

/// Rounds a length in m to a whole number of picometres.
fn round_to_picometres(length: f64) -> f64 {
    (length * 1e12).round() / 1e12
}

/// Returns the closing direction of the left finger, hand frame, snapped to the hand axes within `deviation`.
///
/// # Errors
/// Fails if the fingers do not slide parallel to each other and perpendicular to the approach.
pub(super) fn closing(
    [left, right]: &[Finger; 2],
    approach: DVec3,
    deviation: &mut Deviation,
) -> Result<DVec3, String> {
    if left.direction.cross(right.direction).length() > ANGLE_TOLERANCE {
        let [a, b] = [left.direction, right.direction];
        return Err(format!("the fingers slide along {a} and {b}; they must be parallel within {ANGLE_TOLERANCE} rad"));
    }
    // The pads are compared at mid-range, because with the joints at zero they may have passed each other.
    let apart = right.midpoint() - left.midpoint();
    let along = left.direction * if apart.dot(left.direction) < 0.0 { -1.0 } else { 1.0 };
    let closing = deviation.snap_vector(along);
    if closing.dot(approach) != 0.0 {
        return Err(format!(
            "the fingers close along {along}; the approach {approach} must be perpendicular to that within {ANGLE_TOLERANCE} rad"
        ));
    }
    deviation.add_angle(right.direction, closing);
    Ok(closing)
}

/// Returns the mount of two fingers, left first, and a notice if one joint drives them by unequal travels. Residuals
/// from an exact parallel gripper are added to `deviation`.
pub(super) fn gripper(
    fingers: &[Finger; 2],
    approach: DVec3,
    deviation: &mut Deviation,
) -> Result<(Mount, Option<String>), String> {
    let (closing, [left, right]) = (closing(fingers, approach, deviation)?, fingers);
    let geared = left.drive.leader == right.drive.leader;
    if geared && left.gear(closing) * right.gear(closing) >= 0.0 {
        return Err(
            "one joint moves both fingers in the same direction; the multiplier of one must have the opposite sign"
                .into(),
        );
    }
    let [own, other] = [left.range_along(closing), right.range_along(closing)];
    let [stroke, others] = [own, other].map(|[a, b]| round_to_picometres(b - a));
    let unequal = round_to_picometres(stroke - others).abs() > POSITION_TOLERANCE;
    let opening = round_to_picometres(other[1] - own[0]);
    // Midpoint between the faces along the closing direction, with the fingers open and closed.
    let [open, closed] = [own[0] + other[1], own[1] + other[0]].map(|sum| round_to_picometres(0.5 * sum));
    let across = approach.cross(closing);
    let of = |axis: DVec3| [left.position.dot(axis), right.position.dot(axis)].map(round_to_picometres);
    let ([y, other_y], [z, other_z]) = (of(across), of(approach));
    if unequal && !geared {
        return Err(format!(
            "the fingers slide by {stroke} m and {others} m (opening {opening} m); both must slide by the same \
             distance within {POSITION_TOLERANCE} m, or follow one joint: {ADVICE}"
        ));
    }
    // With unequal travels the midpoint moves; if its range contains the middle of the hand, it is not offset.
    let aside = if unequal && open * closed < 0.0 {
        0.0
    } else if unequal && closed.abs() < open.abs() {
        closed
    } else {
        open
    };
    let off = [y - other_y, z - other_z, aside].map(round_to_picometres);
    if off.iter().any(|length| length.abs() > POSITION_TOLERANCE) {
        return Err(format!(
            "the pads do not face each other within {POSITION_TOLERANCE} m: in the hand frame they are at y {y}, z {z} and y \
             {other_y}, z {other_z} m, and {aside} m off its middle along the closing direction; {ADVICE}"
        ));
    }
    deviation.add_places(&off);
    let [y, z] = [0.5 * (y + other_y), 0.5 * (z + other_z)].map(round_to_picometres);
    if !unequal {
        deviation.add_places(&[round_to_picometres(stroke - others)]);
        return Ok((Mount { opening, stroke: stroke.min(others), y, z }, None));
    }
    let mean = round_to_picometres(0.5 * (stroke + others));
    let notice = format!(
        "one joint closes the fingers by {stroke} m and {others} m: they are treated as two fingers that close by \
         {mean} m each towards their midpoint, to which they move a free object; in the hand frame this midpoint moves \
         from {open} m to {closed} m along the closing direction"
    );
    Ok((Mount { opening, stroke: mean, y, z }, Some(notice)))
}
