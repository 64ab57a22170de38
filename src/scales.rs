//! The lengths and forces that numerical methods of mechanics and contact go by, in the scales of the scene: a scene ten times as large
//! has the same answer, ten times as large.
//!
//! ```text
//! pad thickness t, m             ->  contact offset d = t / 400    ->  every other length, in offsets
//! Young's modulus E, Pa          ->  E t^2, the force of a patch as wide as the pad is thick
//! spacing h of the pad's points  ->  contact stiffness 80 E / h
//! ```
//!
//! Each constant says between what it has to lie. What is a mere ratio (the growth of a step, the contraction of an
//! iteration) stands beside the method that goes by it.

/// Contact offset over the thickness of the pads: the gap at which surfaces meet. Above the rounding of 1e-12 t, below the 1/50 of a
/// thickness that shows in a force. `tests/mechanics/scales.rs`.
pub const OFFSET_OF_PAD: f64 = 1.0 / 400.0;
/// The same over the bounding radius of an object without pads.
pub const OFFSET_OF_OBJECT: f64 = 1.0 / 2500.0;
/// The gap at which surfaces meet, m, for pads of this `thickness` (m), or none, and an object of bounding `radius` (m).
pub fn contact_offset(thickness: Option<f64>, radius: f64) -> f64 {
    thickness.map_or(OFFSET_OF_OBJECT * radius, |t| OFFSET_OF_PAD * t)
}

/// Contact stiffness over `E / h`, the stiffness of a layer as thick as the points of the pad are apart. Above 10: contact must not be
/// softer than the gel behind it; below 1e3: an iterate must not jump from no pressure to all of it. `tests/mechanics/verification_hertz.rs`.
pub const CONTACT_STIFFNESS: f64 = 80.0;
/// Force that makes contact over `E t^2`: of this size are the patches over the thickness, whatever the gel. From 1e-3, where a tip
/// touches with single points, to 0.1, where the path of the object shows. `tests/mechanics/path.rs`.
pub const CONTACT_FORCE: f64 = 0.02;
/// Friction limit that counts as none, over the pressure that closes a whole offset. Above rounding, below any force that is reported.
pub const NO_FRICTION: f64 = 4e-6;

// Newton's method and paths; in contact offsets.

/// Largest motion of an unknown in the last iteration. At most 1: a contact must not open unseen. `tests/mechanics/press.rs`.
pub const DISPLACEMENT_TOLERANCE: f64 = 0.5;
/// Motion in an iteration up to which the Hessian has all second derivatives: up to 1, the reach of a contact.
pub const SHARP_MOTION: f64 = 0.5;
/// Largest motion of a point in one iteration: less than half of the thinnest object, a quarter of the pad. `tests/scenes/torture.rs`.
pub const LARGEST_MOTION: f64 = 100.0;
/// Motion of the rigid unknowns that the first pseudo-time step allows under the full load: below [`LARGEST_MOTION`].
pub const PSEUDO_TIME_BEGINS: f64 = 20.0;
/// Motion of the rigid unknowns in one pseudo-time step that is far enough: [`LARGEST_MOTION`].
pub const PSEUDO_TIME_REACH: f64 = 100.0;
/// Way of a finger without any contact after which the object counts as gone: more than one step of one pseudo-transient continuation.
pub const GONE: f64 = 100.0;
/// Motion at which an object that is let go counts as dropped: more than a thickness. `scenes/torture/heavy_object.ron`.
pub const DROPPED: f64 = 1000.0;
/// Motion of an object between pads in a time step that cannot jump over one: an eighth of the thickness.
pub const SAFE_MOTION: f64 = 50.0;
/// How far the rated force pushes into the end of the stroke.
pub const STROKE_YIELD: f64 = 1.0;

// Condensed pads; in contact offsets.

/// How deep an object comes into the pads as contact is made.
pub const FIRST_DEPTH: f64 = 30.0;
/// How far beyond the reach of contact the nodes of a patch may be: more than fingers travel between two frames, less than would make
/// the patch large.
pub const PATCH_MARGIN: f64 = 15.0;
/// The same for a patch that is small: few nodes cost nothing, and a tip that sinks in soon needs more.
pub const SMALL_PATCH_MARGIN: f64 = 200.0;
/// Motion of an object in its grasp after which pads are condensed anew: half a thickness.
pub const CONDENSED_MOTION: f64 = 200.0;

// Samples of the object; in contact offsets. All say how deep a pad may come in between two points that feel it, below 1.

/// Between two of its own points, on a ball, pin or capsule: more than that, and these are sampled too.
pub const ROD_CUT: f64 = 1.0;
/// Between two samples of a rod or of a ring.
pub const SAMPLE_CUT: f64 = 0.5;
/// Over the corner between two segments of a profile.
pub const CORNER_CUT: f64 = 0.6;
/// Over an edge between two facets; an eighth of the length that a pad may miss times the angle.
pub const EDGE_CUT: f64 = 0.2;
/// Depth of another place of its edge from which a feature goes there, where nothing presses on it, and where something does.
pub const FEATURE_MOVES: [f64; 2] = [0.4, 0.5];
/// Depth of the object in the middle between vertices of the pad that are not in contact.
pub const MIDDLE_CUT: f64 = 0.2;

// Closest points; in contact offsets. They save work and change nothing, but for the second.

/// Distance within which the exact gap is looked up: farther points are skipped until they may have come this close.
pub const LOOK_AHEAD: f64 = 50.0;
/// Difference of distances up to which the face that a feature pressed on is kept, below the offset of features that are felt late.
pub const FACE_KEPT: f64 = 0.2;
/// Motion of a pad after which distances are taken anew: a fraction of what most features are away.
pub const DISTANCES_STALE: f64 = 20.0;
/// Distance from a pad up to which features are listed: several times as far as pads move between two lists.
pub const FEATURES_LISTED: f64 = 150.0;
/// Depth that no state has which is nearly in equilibrium.
pub const DEEPEST: f64 = 10.0;
/// Length to which the deepest place of an edge is found.
pub const DEEPEST_LENGTH: f64 = 2.0;
/// How far curved faces of two pads come beyond their nodes.
pub const FACE_BULGE: f64 = 10.0;
/// Distance from a face that is rounding, over an edge of the face.
pub const ROUNDING: f64 = 1e-6;
