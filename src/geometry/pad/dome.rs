//! Domed sensing face of the GelSight Mini gel, in closed form.
//!
//! It is derived from the CAD of FEATS (`gelsight_mini.step`) through the 5137 surface nodes of its CalculiX mesh. On
//! the two symmetry axes the profile is, to the precision of the CAD file, an arc from the apex to a depth of 0.25 mm,
//! continued by a second arc, tangent to the first, to the rim 1.25 mm below the apex; the side walls are upright. Off
//! the axes the CAD surface is a spline patch. The blend of the two profiles approximates it to 1.2 um rms and 5.3 um
//! at most, except at the four corners where both fillets meet (there the true outline is rounded with a radius of
//! 1.5 mm, the pad has a sharp corner, and the depth differs by up to 0.16 mm; the volume of the whole gel agrees to
//! 0.1 %).

/// Half length and half width of the gel, m: along x (long) and y (short).
pub const HALF_SIZE: [f64; 2] = [12.625e-3, 10.375e-3];
/// Distance from the apex to the bonded face, m.
pub const THICKNESS: f64 = 4.0e-3;
/// Depth of the rim below the apex, m.
pub const RIM_DEPTH: f64 = 1.25e-3;
/// Depth below the apex where dome and edge fillet meet, on the axes, m.
pub const FILLET_DEPTH: f64 = 0.25e-3;
/// Distance from the centre at which dome and edge fillet meet, m: along x and y.
pub const FILLET_START: [f64; 2] = [9.7165e-3, 7.5354e-3];
/// Coupling of the two profiles, 1/m; fitted.
const COUPLING: f64 = 2.81e3;
/// Decay of the coupling over the fillet; fitted.
const DECAY: f64 = 1.6;

/// Returns the radius of the dome's arc along an axis (0 = x, 1 = y), m: 188.9 mm along the long side, 113.7 mm along
/// the short one.
pub fn dome_radius(axis: usize) -> f64 {
    (FILLET_START[axis].powi(2) + FILLET_DEPTH.powi(2)) / (2.0 * FILLET_DEPTH)
}

/// Returns the depth below the apex on an axis at distance `at` from the centre, m.
fn profile(axis: usize, at: f64) -> f64 {
    let radius = dome_radius(axis);
    if at <= FILLET_START[axis] {
        return at * at / (radius + (radius * radius - at * at).sqrt());
    }
    let slope = (FILLET_START[axis] / radius).asin();
    let (run, drop) = (HALF_SIZE[axis] - FILLET_START[axis], RIM_DEPTH - FILLET_DEPTH);
    let fillet = run.hypot(drop) / (2.0 * (drop.atan2(run) - slope).sin());
    let along = at.min(HALF_SIZE[axis]) - FILLET_START[axis] + fillet * slope.sin();
    FILLET_DEPTH + fillet * slope.cos() - (fillet * fillet - along * along).max(0.0).sqrt()
}

/// Returns the fraction by which the depth along the other axis is reduced at the distance `at` from the centre: 0 at
/// the centre, 1 at the rim.
fn suppression(axis: usize, at: f64) -> f64 {
    if at <= FILLET_START[axis] {
        COUPLING * profile(axis, at)
    } else {
        let left = ((HALF_SIZE[axis] - at) / (HALF_SIZE[axis] - FILLET_START[axis])).max(0.0);
        1.0 - (1.0 - COUPLING * FILLET_DEPTH) * left.powf(DECAY)
    }
}

/// Returns the depth of the sensing face below its apex at (x, y) of the pad frame (x along the long side), m, in [0,
/// RIM].
pub fn depth(x: f64, y: f64) -> f64 {
    let (x, y) = (x.abs(), y.abs());
    let blended = profile(0, x) + profile(1, y) - suppression(0, x) * suppression(1, y) / COUPLING;
    blended.clamp(0.0, RIM_DEPTH)
}
