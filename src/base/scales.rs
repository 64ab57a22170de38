//! Scales of length and force for the numerical methods of mechanics and contact, derived from the scene: a scene ten
//! times as large has the same solution, ten times as large.
//!
//! ```text
//! pad thickness t, m             ->  contact offset d = t / 400    ->  every other length, in offsets
//! Young's modulus E, Pa          ->  E t^2, the force of a patch as wide as the pad is thick
//! spacing h of the pad's points  ->  contact stiffness 80 E / h
//! ```
//!
//! Each constant states its bounds. Pure ratios (growth of a step, contraction of an iteration) are defined next to the
//! method that uses them.

/// Contact offset over the pad thickness: the gap at which surfaces come into contact. Above the rounding error of
/// 1e-12 t, below the t / 50 at which it affects a force. `tests/mechanics/scales.rs`.
pub const OFFSET_OF_PAD: f64 = 1.0 / 400.0;
/// Contact offset over the bounding radius of an object, for a scene without pads.
pub const OFFSET_OF_OBJECT: f64 = 1.0 / 2500.0;
/// Returns the contact offset, m, for pads of this `thickness` (m) or, without pads, for an object of bounding `radius`
/// (m).
pub fn contact_offset(thickness: Option<f64>, radius: f64) -> f64 {
    thickness.map_or(OFFSET_OF_OBJECT * radius, |t| OFFSET_OF_PAD * t)
}

/// Default radius of the edges of a scanned object over the pad thickness. It follows from the pad, not from its mesh:
/// otherwise two meshes of one pad would touch two objects. At least twice the spacing of the points of a mesh with
/// eight points along the thickness, so that three adjacent points resolve an edge; below 1/2, where a pad would not
/// feel the edges of its object. `tests/scenes/object_surface.rs`.
pub const EDGE_RADIUS_OF_PAD: f64 = 0.25;
/// Returns the default radius of the edges of a scanned object, m, for pads of this `thickness` (m).
pub fn edge_radius(thickness: f64) -> f64 {
    EDGE_RADIUS_OF_PAD * thickness
}

/// Contact stiffness over `E / h`, the stiffness of a gel layer as thick as the spacing of the pad's points. Above 10:
/// contact must not be softer than the gel behind it; below 1e3: an iterate must not jump from zero to full pressure.
/// `tests/mechanics/verification_hertz.rs`.
pub const CONTACT_STIFFNESS: f64 = 80.0;
/// Force at which contact is established, over `E t^2`; this ratio fixes patch size over thickness for any gel. Above
/// 1e-3, where a tip touches with single points, and below 0.1, where the path of the object is visibly affected.
/// `tests/mechanics/path.rs`.
pub const CONTACT_FORCE: f64 = 0.02;
/// Friction limit that counts as zero, over the pressure that closes the whole offset. Above rounding, below any
/// reported force.
pub const NEGLIGIBLE_FRICTION: f64 = 4e-6;

// Newton's method and paths; in contact offsets.

/// Largest motion of an unknown in the last iteration. At most 1: no contact may open undetected.
/// `tests/mechanics/press.rs`.
pub const DISPLACEMENT_TOLERANCE: f64 = 0.5;
/// Largest motion in an iteration after which the complete Hessian (with the curvature of pad faces) is used; at most
/// 1, the contact offset.
pub const COMPLETE_HESSIAN_MOTION: f64 = 0.5;
/// Largest motion of a point in one iteration: less than half of the thinnest object, a quarter of the pad.
/// `tests/scenes/torture.rs`.
pub const LARGEST_MOTION: f64 = 100.0;
/// Motion of the rigid unknowns that the first proximal springs allow under the full load: below [`LARGEST_MOTION`].
pub const FIRST_PSEUDO_STEP: f64 = 20.0;
/// Motion of the rigid unknowns in a pseudo-time step above which the springs become stiffer: [`LARGEST_MOTION`].
pub const LARGEST_PSEUDO_STEP: f64 = 100.0;
/// Motion while a finger has no contact after which the object counts as having left the grasp: more than one step of a
/// pseudo-transient continuation.
pub const LOST_CONTACT_MOTION: f64 = 100.0;
/// Motion at which a released object counts as dropped: more than the pad thickness. `scenes/torture/heavy_object.ron`.
pub const DROP_DISTANCE: f64 = 1000.0;
/// Largest predicted motion in a time step that needs no conservative advancement: an eighth of the pad thickness, so
/// that a pad cannot pass through an object.
pub const LARGEST_PREDICTED_MOTION: f64 = 50.0;
/// Penetration into the stop at the end of the stroke under the rated force.
pub const STOP_PENETRATION: f64 = 1.0;

// Condensed pads; in contact offsets.

/// Depth of the object in the pads for which the patches at first contact are chosen.
pub const FIRST_PATCH_PENETRATION: f64 = 15.0;
/// Distance beyond the range of contact up to which nodes belong to a patch: more than the fingers travel between two
/// frames, less than would make the patch large.
pub const PATCH_MARGIN: f64 = 6.0;
/// Same distance for a small patch: few nodes cost little, and a tip that sinks in soon needs more.
pub const SMALL_PATCH_MARGIN: f64 = 200.0;

// Samples of the object; in contact offsets. Each bounds the depth to which a pad may penetrate between two samples, at
// most 1.

/// Penetration between samples above which balls, pins and capsules get samples of their own.
pub const ROD_CUT: f64 = 1.0;
/// Penetration between two samples of a rod or ring.
pub const SAMPLE_CUT: f64 = 0.5;
/// Penetration at the corner between two segments of a profile above which the corner gets samples.
pub const CORNER_CUT: f64 = 0.6;
/// Penetration at an edge between two facets above which the edge gets samples: an eighth of the length between pad
/// samples, times the angle between the facets.
pub const EDGE_CUT: f64 = 0.2;
/// Penetration at another point of its edge above which a contact vertex moves there: without and with pressure on the
/// vertex.
pub const VERTEX_MOVE_PENETRATION: [f64; 2] = [0.4, 0.5];
/// Penetration of the object at a sub-face sample of the pad above which the sample becomes active.
pub const SUB_FACE_PENETRATION: f64 = 0.2;

// Closest points; in contact offsets. Search radii; only the tolerances `FACE_HYSTERESIS` and
// `DEEPEST_POINT_TOLERANCE` affect results.

/// Distance within which the exact gap is computed: farther points are skipped until they may have come this close.
pub const EXACT_GAP_RADIUS: f64 = 50.0;
/// Distance up to which points are listed: pad and object may move this far relative to each other before the list is
/// rebuilt.
pub const POINT_LIST_RADIUS: f64 = 30.0;
/// Difference of distances up to which a contact vertex keeps the face that it pressed on; below the reduced contact
/// offset.
pub const FACE_HYSTERESIS: f64 = 0.2;
/// Motion of a pad after which distances are recomputed: a fraction of the distance of most contact vertices.
pub const DISTANCE_UPDATE_MOTION: f64 = 20.0;
/// Distance from a pad up to which contact vertices are listed: several times the motion of pads between two lists.
pub const VERTEX_LIST_RADIUS: f64 = 150.0;
/// Upper bound of the penetration in states near equilibrium.
pub const LARGEST_PENETRATION: f64 = 10.0;
/// Length to which the deepest point of an edge is located.
pub const DEEPEST_POINT_TOLERANCE: f64 = 2.0;
/// Distance by which the curved faces of two pads may protrude beyond their nodes.
pub const FACE_BULGE: f64 = 10.0;
/// Distance from a face that counts as rounding, over the length of an edge of the face.
pub const ROUNDING: f64 = 1e-6;
