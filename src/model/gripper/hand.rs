//! Collision geometry of the hand: palm, finger bodies and pads, as axis-aligned boxes in the hand frame (x is the
//! closing direction, y the finger width, z the approach).

use geometry::Aabb;
use geometry::Pose;
use geometry::shape::SignedDistance;
use glam::DVec3;
use scene::Gripper;

/// Half sizes of the palm along x and y, and its extent along the approach, m: the body of a Franka hand (204 x 63 mm,
/// 65.9 mm tall up to the fingers; Franka Hand product manual, dimensions).
const PALM: DVec3 = DVec3::new(0.102, 0.0315, 0.0659);
/// Thickness of a finger behind its pad, m.
const FINGER: f64 = 0.015;
/// Tolerance of the collision check, m: a box of the hand is bisected until its half sizes are below this length; a
/// part that small counts as colliding if the object may intersect it.
pub const COLLISION_TOLERANCE: f64 = 5e-4;

/// Rigid hand with two undeformed pads, for collision checks between hand and object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Bounding box of a pad in the pad frame, m: x along the approach, y along the finger width, z out of the sensing
    /// face.
    pub pad: Aabb,
    /// Distance between the sensing faces of the open hand, m.
    pub opening: f64,
    /// Point midway between the origins of the two pad frames, hand frame, m; its x component is zero.
    pub center: DVec3,
}

/// Part of the hand that may collide with the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandPart {
    /// Palm: the body to which the fingers are attached.
    Palm,
    /// Rigid body of a finger, behind its pad and between pad and palm.
    Finger,
    /// Soft pad on a finger.
    Pad,
}

impl HandPart {
    /// Returns the name of the part for messages: `palm`, `finger` or `pad`.
    pub fn name(self) -> &'static str {
        match self {
            HandPart::Palm => "palm",
            HandPart::Finger => "finger",
            HandPart::Pad => "pad",
        }
    }
}

impl Hand {
    /// Creates the hand of `gripper`, with its opening and pad placement, for pads with the bounding box `pad` (pad
    /// frame, m).
    pub fn new(pad: Aabb, gripper: &Gripper) -> Self {
        Self { pad, opening: gripper.opening.get(), center: gripper.placement.center() }
    }

    /// Returns `n` x `n` points on the sensing face of a pad of the open hand, hand frame, m: the centres of equal
    /// rectangles. `closing` is the closing direction of its finger, a unit vector: +x for the left finger, -x for the
    /// right one.
    pub fn face(&self, closing: DVec3, n: usize) -> impl Iterator<Item = DVec3> {
        let (hand, low, high) = (*self, self.pad.min, self.pad.max);
        let at = move |k: usize, low: f64, high: f64| low + (high - low) * (k as f64 + 0.5) / n as f64;
        (0..n * n).map(move |k| {
            let on_face = DVec3::new(0.0, at(k % n, low.y, high.y), at(k / n, low.x, high.x));
            hand.center + on_face - closing * 0.5 * hand.opening
        })
    }

    /// Returns the first part that collides with `object`, in the order palm, fingers, pads; None without a collision.
    /// `object` is the signed distance function of the object, in the object frame; `pose` is the pose of the hand in
    /// the object frame; `travel` is the travel of each finger from the open hand, m; `shift` is an additional
    /// displacement of the object along hand x, m.
    pub fn first_collision(
        &self,
        object: &dyn SignedDistance,
        pose: &Pose,
        travel: f64,
        shift: f64,
    ) -> Option<HandPart> {
        let meets =
            |b: Aabb| overlaps(object, pose, Aabb { min: b.min - DVec3::X * shift, max: b.max - DVec3::X * shift });
        let (fingers, pads) = (self.fingers(travel), self.pads(travel));
        match () {
            () if meets(palm()) => Some(HandPart::Palm),
            () if fingers.into_iter().any(meets) => Some(HandPart::Finger),
            () if pads.into_iter().any(meets) => Some(HandPart::Pad),
            () => None,
        }
    }

    /// Returns the bounding boxes of the undeformed pads, left first, hand frame, m, after each finger has travelled by
    /// `travel` (m) from the open hand.
    pub fn pads(&self, travel: f64) -> [Aabb; 2] {
        let (near, far) = (0.5 * self.opening - travel - self.pad.max.z, 0.5 * self.opening - travel - self.pad.min.z);
        self.both(near, far, self.center.z + self.pad.min.x)
    }

    /// Returns the boxes of the fingers, from the palm to the end of the pads, left first, hand frame, m.
    fn fingers(&self, travel: f64) -> [Aabb; 2] {
        let back = 0.5 * self.opening - travel - self.pad.min.z;
        self.both(back, back + FINGER, PALM.z.min(self.center.z + self.pad.min.x))
    }

    /// Returns boxes on both sides, at distances `near` to `far` from the centre plane, as wide as the pads, from `low`
    /// to the end of the pads along hand z.
    fn both(&self, near: f64, far: f64, low: f64) -> [Aabb; 2] {
        // Pad x lies along the approach, pad y along the finger width.
        let half = self.pad.max.y.abs().max(self.pad.min.y.abs());
        let (y0, y1, z1) = (self.center.y - half, self.center.y + half, self.center.z + self.pad.max.x);
        [
            Aabb { min: DVec3::new(-far, y0, low), max: DVec3::new(-near, y1, z1) },
            Aabb { min: DVec3::new(near, y0, low), max: DVec3::new(far, y1, z1) },
        ]
    }
}

fn palm() -> Aabb {
    Aabb { min: DVec3::new(-PALM.x, -PALM.y, 0.0), max: PALM }
}

/// Returns true if a box of the hand collides with the object, to within [`COLLISION_TOLERANCE`]. The distance function
/// is 1-Lipschitz: there is no collision if the distance at the centre exceeds the half diagonal, and a collision if
/// the centre is inside; otherwise the box is bisected.
fn overlaps(object: &dyn SignedDistance, pose: &Pose, hand: Aabb) -> bool {
    let (center, half) = (hand.center(), 0.5 * hand.size());
    let distance = object.distance(pose.transform(center));
    if distance > half.length() {
        return false;
    }
    if distance <= 0.0 || half.max_element() < COLLISION_TOLERANCE {
        return true;
    }
    let axis = if half.x >= half.y.max(half.z) {
        DVec3::X
    } else if half.y >= half.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let cut = axis * half.dot(axis);
    overlaps(object, pose, Aabb { min: hand.min, max: hand.max - cut })
        || overlaps(object, pose, Aabb { min: hand.min + cut, max: hand.max })
}
