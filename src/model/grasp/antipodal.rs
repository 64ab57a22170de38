//! Antipodal grasps: two contacts whose connecting line lies in both friction cones (Nguyen 1988), sampled as in
//! DefGraspSim: a surface point, a closing axis near its normal, an approach direction about that axis.
//!
//! One trial: a surface point, uniform by area; a closing axis, uniform in the cone about the inward normal, which must
//! leave the object within the cone of the opposite normal; an approach direction, uniform about the axis. The pads are
//! centred on the midpoint of the two contacts, or offset from it; the hand must be free of collisions with the object
//! when open and at first contact.

use crate::gripper::Hand;
use crate::gripper::hand::HandPart;
use base::error::{Error, Result};
use base::number::format_count;
use base::random::Random;
use geometry::Pose;
use geometry::mesh::TriMesh;
use geometry::shape::Shape;
use glam::{DMat3, DQuat, DVec3};
use scene::Antipodal;
use std::f64::consts::TAU;

/// Largest number of trials per requested grasp before the sampler fails.
const MAX_TRIALS: usize = 2000;
/// Number of rays along each side of a pad that search for its first contact.
const RAYS: usize = 7;

/// Reason for the rejection of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rejection {
    /// The normal at the opposite contact is outside the friction cone.
    OutsideCone,
    /// Another part of the object is in front of the surface point: no pad can reach it.
    Hidden,
    /// The object does not fit between the open pads.
    TooWide,
    /// The fingers reach the end of their stroke before both pads touch.
    TooThin,
    /// The palm collides with the object.
    Palm,
    /// A finger collides with the object, when open or when the pads touch.
    Finger,
}

impl Rejection {
    /// All reasons.
    pub const ALL: [Rejection; 6] =
        [Self::OutsideCone, Self::Hidden, Self::TooWide, Self::TooThin, Self::Palm, Self::Finger];

    /// Returns the reason in words.
    pub fn reason(self) -> &'static str {
        match self {
            Self::OutsideCone => "opposite normal outside the friction cone",
            Self::Hidden => "occluded by another part of the object",
            Self::TooWide => "too wide for the opening",
            Self::TooThin => "out of the fingers' stroke",
            Self::Palm => "palm collides",
            Self::Finger => "finger collides",
        }
    }
}

/// Grasps found, and counts of the rejected trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// Grasps, in the order in which they were found.
    pub poses: Vec<Pose>,
    /// Number of trials.
    pub tries: usize,
    /// Number of rejected trials by reason, in the order of [`Rejection::ALL`].
    pub rejected: [usize; 6],
}

impl Sampled {
    /// Returns one sentence with the counts.
    pub fn report(&self) -> String {
        let counts = Rejection::ALL.iter().zip(self.rejected).filter(|(_, n)| *n > 0);
        let counts: Vec<_> = counts.map(|(r, n)| format!("{n} {}", r.reason())).collect();
        let rejected =
            if counts.is_empty() { "none rejected".into() } else { format!("rejected: {}", counts.join(", ")) };
        format!(
            "{} from {}; {rejected}",
            format_count(self.poses.len(), "antipodal grasp"),
            format_count(self.tries, "try")
        )
    }
}

/// Samples grasps of `object` with friction coefficient `friction` for `hand`, whose fingers travel up to `stroke` (m).
///
/// # Errors
/// Fails if 2,000 trials per requested grasp find too few; the message gives the reasons.
pub fn sample(wanted: &Antipodal, object: &Shape, hand: &Hand, friction: f64, stroke: f64) -> Result<Sampled> {
    let surface = Surface::new(&object.surface);
    let cone = friction.atan().min(wanted.tilt_deg.get().to_radians());
    let mut found = Sampled { poses: Vec::new(), tries: 0, rejected: [0; 6] };
    let mut random = Random::new(wanted.seed);
    while found.poses.len() < wanted.count.get() {
        if found.tries == MAX_TRIALS * wanted.count.get() {
            return Err(Error::Start(format!(
                "grasps: the {} has too few antipodal grasps for this hand: {}; change its size, the opening or the friction",
                object.name,
                found.report()
            )));
        }
        found.tries += 1;
        match attempt(object, &surface, hand, (cone, wanted.offset.get()), stroke, &mut random) {
            Ok(pose) => found.poses.push(pose),
            Err(rejection) => found.rejected[rejection as usize] += 1,
        }
    }
    Ok(found)
}

/// Makes one trial with closing axes within the angle `cone` (rad) and pads off the contacts by at most `offset` (over
/// half of their length and width).
fn attempt(
    object: &Shape,
    surface: &Surface,
    hand: &Hand,
    (cone, offset): (f64, f64),
    stroke: f64,
    random: &mut Random,
) -> std::result::Result<Pose, Rejection> {
    // Every trial draws the same number of random numbers, whether it is rejected or not.
    let [at, u, v, tilt, about, turn] = std::array::from_fn(|_| random.uniform());
    let size = hand.pad.size();
    let mut along = |size: f64| if offset > 0.0 { (random.uniform() - 0.5) * offset * size } else { 0.0 };
    let beside = DVec3::new(0.0, along(size.y), along(size.x));
    let point = surface.point(object, at, u, v);
    let normal = object.distance.closest(point, f64::INFINITY).map_or(DVec3::Z, |c| c.normal);
    // Uniform over the solid angle of the cone.
    let cos = 1.0 - tilt * (1.0 - cone.cos());
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (e1, e2) = (-normal).any_orthonormal_pair();
    let closing = (-normal * cos + (e1 * (TAU * about).cos() + e2 * (TAU * about).sin()) * sin).normalize();

    let far = 4.0 * object.bounding_radius;
    let left = object.ray(point - closing * far, closing).ok_or(Rejection::Hidden)?;
    let first = point + closing * (left.t - far);
    if (first - point).length() > 1e-3 * object.bounding_radius {
        return Err(Rejection::Hidden);
    }
    let right = object.ray(point + closing * far, -closing).ok_or(Rejection::Hidden)?;
    let last = point + closing * (far - right.t);
    if right.normal.dot(closing) < cone.cos() - 1e-9 {
        return Err(Rejection::OutsideCone);
    }
    if (last - first).dot(closing) > hand.opening {
        return Err(Rejection::TooWide);
    }

    let (e1, e2) = closing.any_orthonormal_pair();
    let approach = e1 * (TAU * turn).cos() + e2 * (TAU * turn).sin();
    let rotation = DMat3::from_cols(closing, approach.cross(closing), approach);
    let rotation = DQuat::from_mat3(&rotation).normalize();
    let pose = Pose { position: 0.5 * (first + last) - rotation * (hand.center + beside), rotation };
    check_reachable(object, hand, &pose, stroke)?;
    Ok(pose)
}

/// Checks that the hand reaches the pose and closes without collision.
fn check_reachable(object: &Shape, hand: &Hand, pose: &Pose, stroke: f64) -> std::result::Result<(), Rejection> {
    let blocked = |part| match part {
        HandPart::Palm => Rejection::Palm,
        HandPart::Finger => Rejection::Finger,
        HandPart::Pad => Rejection::TooWide,
    };
    let distance = object.distance.as_ref();
    hand.first_collision(distance, pose, 0.0, 0.0).map_or(Ok(()), |part| Err(blocked(part)))?;
    let [left, right] = [DVec3::X, DVec3::NEG_X].map(|closing| first_contact(object, hand, pose, closing));
    // The object is pushed to the centre of the hand, so that each finger travels the mean distance.
    let (travel, shift) = (0.5 * (left + right), 0.5 * (right - left));
    if travel.is_nan() || travel > stroke {
        return Err(Rejection::TooThin);
    }
    // Pads may touch the object here, palm and fingers may not.
    match hand.first_collision(distance, pose, travel, shift) {
        Some(part @ (HandPart::Palm | HandPart::Finger)) => Err(blocked(part)),
        _ => Ok(()),
    }
}

/// Returns the travel of a pad to first contact, by rays from its face; infinite if none hits.
fn first_contact(object: &Shape, hand: &Hand, pose: &Pose, closing: DVec3) -> f64 {
    let travel = |start| object.ray(pose.transform(start), pose.rotation * closing).map(|hit| hit.t);
    hand.face(closing, RAYS).filter_map(travel).fold(f64::INFINITY, f64::min)
}

/// Sampler of points of a surface, uniform by area.
struct Surface<'a> {
    mesh: &'a TriMesh,
    /// Cumulative area up to and including each triangle, m2.
    area: Vec<f64>,
}

impl<'a> Surface<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let mut sum = 0.0;
        let area = (0..mesh.triangles.len()).map(|t| {
            let [a, b, c] = mesh.corners(t);
            sum += 0.5 * (b - a).cross(c - a).length();
            sum
        });
        Self { mesh, area: area.collect() }
    }

    /// Returns the point for three numbers in 0..1, projected onto the exact surface.
    fn point(&self, object: &Shape, at: f64, u: f64, v: f64) -> DVec3 {
        let whole = self.area.last().copied().unwrap_or(0.0);
        let t = self.area.partition_point(|sum| *sum <= at * whole).min(self.area.len() - 1);
        let [a, b, c] = self.mesh.corners(t);
        // Uniform sampling of a triangle (Osada et al. 2002, eq. 1).
        let root = u.sqrt();
        let p = (1.0 - root) * a + root * (1.0 - v) * b + root * v * c;
        object.distance.closest(p, f64::INFINITY).map_or(p, |near| p - near.normal * near.distance)
    }
}
