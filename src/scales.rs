//! Scales of length and force for numerical methods of mechanics and contact, in the scales of the scene: a scene ten times as large has
//! the same answer, ten times as large.
//!
//! ```text
//! pad thickness t, m             ->  contact offset d = t / 400    ->  every other length, in offsets
//! Young's modulus E, Pa          ->  E t^2, the force of a patch as wide as the pad is thick
//! spacing h of the pad's points  ->  contact stiffness 80 E / h
//! ```
//!
//! Each constant states its bounds. Mere ratios (the growth of a step, the contraction of an iteration) are defined
//! beside the method that uses them.

/// Contact offset over the thickness of the pads: the gap at which surfaces meet. Above the rounding of 1e-12 t, below the 1/50 of a
/// thickness that shows in a force. `tests/mechanics/scales.rs`.
pub const OFFSET_OF_PAD: f64 = 1.0 / 400.0;
/// Contact offset over the bounding radius of an object without pads.
pub const OFFSET_OF_OBJECT: f64 = 1.0 / 2500.0;
/// Returns the gap at which surfaces meet, m, for pads of this `thickness` (m), or none, and an object of bounding
/// `radius` (m).
pub fn contact_offset(thickness: Option<f64>, radius: f64) -> f64 {
    thickness.map_or(OFFSET_OF_OBJECT * radius, |t| OFFSET_OF_PAD * t)
}

/// Contact stiffness over `E / h`, the stiffness of a layer as thick as the points of the pad are apart. Above 10: contact must not be
/// softer than the gel behind it; below 1e3: an iterate must not jump from no pressure to all of it. `tests/mechanics/verification_hertz.rs`.
pub const CONTACT_STIFFNESS: f64 = 80.0;
/// Force that makes contact over `E t^2`, which is the size of patches over the thickness, whatever the gel. Between 1e-3, where a tip
/// touches with single points, and 0.1, where the path of the object becomes visible. `tests/mechanics/path.rs`.
pub const CONTACT_FORCE: f64 = 0.02;
/// Friction limit that counts as none, over the pressure that closes a whole offset. Above rounding, below any force that is reported.
pub const NO_FRICTION: f64 = 4e-6;

// Newton's method and paths; in contact offsets.

/// Largest motion of an unknown in the last iteration. At most 1: a contact must not open unseen. `tests/mechanics/press.rs`.
pub const DISPLACEMENT_TOLERANCE: f64 = 0.5;
/// Motion in an iteration up to which the Hessian has all second derivatives: at most 1, the reach of a contact.
pub const SHARP_MOTION: f64 = 0.5;
/// Largest motion of a point in one iteration: less than half of the thinnest object, a quarter of the pad. `tests/scenes/torture.rs`.
pub const LARGEST_MOTION: f64 = 100.0;
/// Motion of the rigid unknowns that the first pseudo-time step allows under the full load: below [`LARGEST_MOTION`].
pub const PSEUDO_TIME_BEGINS: f64 = 20.0;
/// Motion of the rigid unknowns at which a pseudo-time step is long enough: [`LARGEST_MOTION`].
pub const PSEUDO_TIME_REACH: f64 = 100.0;
/// Travel of a finger without any contact after which the object counts as gone: more than one step of one pseudo-transient continuation.
pub const GONE: f64 = 100.0;
/// Motion at which a released object counts as dropped: more than a thickness. `scenes/torture/heavy_object.ron`.
pub const DROPPED: f64 = 1000.0;
/// Motion of an object between pads in a time step that cannot jump over one: an eighth of the thickness.
pub const SAFE_MOTION: f64 = 50.0;
/// Distance by which the rated force pushes into the end of the stroke.
pub const STROKE_YIELD: f64 = 1.0;

// Condensed pads; in contact offsets.

/// Depth of an object in the pads when contact is made.
pub const FIRST_DEPTH: f64 = 15.0;
/// Distance beyond the reach of contact up to which nodes belong to a patch: more than fingers travel between two frames, less than would
/// make the patch large.
pub const PATCH_MARGIN: f64 = 6.0;
/// Patch margin of a small patch: few nodes cost nothing, and a tip that sinks in soon needs more.
pub const SMALL_PATCH_MARGIN: f64 = 200.0;

// Samples of the object; in contact offsets. All say how deep a pad may come in between two points that feel it, below 1.

/// Depth between two points of a pad, on a ball, pin or capsule, above which these are sampled too.
pub const ROD_CUT: f64 = 1.0;
/// Depth between two samples of a rod or of a ring.
pub const SAMPLE_CUT: f64 = 0.5;
/// Depth over the corner between two segments of a profile.
pub const CORNER_CUT: f64 = 0.6;
/// Depth over an edge between two facets: an eighth of the length that a pad may miss, times the angle.
pub const EDGE_CUT: f64 = 0.2;
/// Depth of another place of its edge at which a feature moves there: without pressure on the feature, and with pressure on it.
pub const FEATURE_MOVES: [f64; 2] = [0.4, 0.5];
/// Depth of the object in the middle between vertices of the pad that are not in contact.
pub const MIDDLE_CUT: f64 = 0.2;

// Closest points; in contact offsets. They save work and change nothing, but for the second.

/// Distance within which the exact gap is computed: farther points are skipped until they may have come this close.
pub const LOOK_AHEAD: f64 = 50.0;
/// Distance up to which points are listed: as far as pad and object may move against each other before they are listed anew.
pub const POINTS_LISTED: f64 = 30.0;
/// Difference of distances up to which a feature keeps the face that it pressed on, below the offset of features that are felt late.
pub const FACE_KEPT: f64 = 0.2;
/// Motion of a pad after which distances are computed anew: a fraction of the distance of most features.
pub const DISTANCES_STALE: f64 = 20.0;
/// Distance from a pad up to which features are listed: several times the motion of pads between two lists.
pub const FEATURES_LISTED: f64 = 150.0;
/// Depth that no state near equilibrium has.
pub const DEEPEST: f64 = 10.0;
/// Length to which the deepest place of an edge is determined.
pub const DEEPEST_LENGTH: f64 = 2.0;
/// Distance by which curved faces of two pads come beyond their nodes.
pub const FACE_BULGE: f64 = 10.0;
/// Distance from a face that is mere rounding, over an edge of the face.
pub const ROUNDING: f64 = 1e-6;
