//! Choice of the pad mesh from `accuracy`, an alternative to a spacing.
//!
//! Most of the discretisation error of the displacement arises at the edge of the contact and decreases with the square
//! of the cell width there. Relative to the displacement of the whole pad, it is about `ERROR_COEFFICIENT h^2 / (l t)`
//! with the cell width `h`, the pad thickness `t` and the size `l` of the contact patch: twice its area over its
//! perimeter, which is the radius of a circular patch. The deformation due to an edge decays over about a thickness, so
//! that `l` is limited to `MAX_PATCH_RATIO` thicknesses. The patch is that of a Winkler foundation (Winkler 1867) with
//! the stiffness of the pad, pressed onto the object's profile by the final force, or to the final depth. The number of
//! layers follows from the spacing: its influence is small. docs/verification.md compares the formula with mesh
//! refinement sequences.

use crate::grasp::{grasp_poses, resolve_object};
use crate::gripper::Hand;
use crate::part::{object, pad};
use base::error::Result;
use base::number::{format_number, round_significant};
use geometry::Aabb;
use geometry::Pose;
use geometry::pad::{Resolution, dome};
use geometry::shape::Shape;
use glam::{DVec2, DVec3};
use record::pad_name;
use scene::leaf::{Length, Ratio};
use scene::pad::GelShape;
use scene::{Fingers, Loading, Pads, Scene, motion};

/// Relative error of the displacement over `h^2 / (l t)`, fitted to the mesh refinement sequences of
/// `scenes/references.ron`.
const ERROR_COEFFICIENT: f64 = 0.3;
/// Largest patch size with an influence on the error, in pad thicknesses.
const MAX_PATCH_RATIO: f64 = 1.4;
/// Stiffness of the foundation over `E / ((1 - nu^2) t)`, from the travel under spheres and cylinders.
const FOUNDATION_STIFFNESS: f64 = 2.1;
/// Number of sample points of the profile along each side of a pad.
const POINTS: usize = 64;
/// Largest number of grasps that are evaluated, spread over those of the scene.
const GRASPS: usize = 16;
/// Ratio of the cell widths at the rim and at the centre, for patches near the centre.
const FOCUS: f64 = 2.0;
/// Smallest number of cells across the shorter side of a pad.
const MIN_CELLS: f64 = 4.0;

/// Chosen mesh, with the reason.
#[derive(Debug, Clone)]
pub struct MeshChoice {
    /// Pads with spacing and focus.
    pub pads: Pads,
    /// Reason for the choice, one sentence.
    pub reason: String,
}

/// Returns the scene with the mesh chosen for its accuracy; unchanged if it has no accuracy.
///
/// # Errors
/// Fails if the object cannot be built or the grasps cannot be found.
pub fn with_chosen_mesh(scene: &Scene) -> Result<Scene> {
    let mut scene = scene.clone();
    if scene.gripper.pads.accuracy().is_some() {
        let object = resolve_object(&scene, &mut Vec::new())?;
        let object = object::build(&object, &mut Vec::new()).map_err(|e| e.with_field("object.shape"))?;
        if let Some(choice) = choose_mesh(&scene, &object)? {
            scene.gripper.pads = choice.pads;
        }
    }
    Ok(scene)
}

/// Chooses the mesh for the accuracy of the scene; None if it has no accuracy.
///
/// # Errors
/// Fails if the grasps cannot be found.
pub fn choose_mesh(scene: &Scene, object: &Shape) -> Result<Option<MeshChoice>> {
    let pads = &scene.gripper.pads;
    let (Some(accuracy), Some(size)) = (pads.accuracy(), pad::extent(pads)) else { return Ok(None) };
    let bed = WinklerFoundation::from_scene(scene, size);
    let poses = grasp_poses(scene)?;
    let step = poses.len().div_ceil(GRASPS).max(1);
    let looked_at = poses.iter().enumerate().step_by(step);
    let patches = looked_at.flat_map(|(grasp, pose)| bed.patches(scene, object, grasp, pose));
    let Some(all) = patches.reduce(Patch::smaller) else {
        let why = format!(
            "accuracy {}: none of the checked grasps touches the object, so the mesh is that without `accuracy`",
            format_number(accuracy)
        );
        return Ok(Some(MeshChoice { pads: pads.with_mesh(None, None), reason: why }));
    };
    let [x, y, thickness] = size;
    let length = all.size.min(MAX_PATCH_RATIO * thickness);
    let wanted = (length * thickness * accuracy / ERROR_COEFFICIENT).sqrt();
    let at_edge = wanted.min(x.min(y) / MIN_CELLS);
    let focus = match pads.focus() {
        given if given > 1.0 => given,
        _ if Resolution::width_ratio(FOCUS, all.reach) < 1.0 + (FOCUS - 1.0) / 3.0 => FOCUS,
        _ => 1.0,
    };
    let spacing = at_edge / Resolution::width_ratio(focus, all.reach);
    let three = |v: f64| format_number(round_significant(v, 3));
    let why = format!(
        "accuracy {}: the smallest contact patch, of grasp {} on the {} pad, has a size of {} mm (twice its area over \
         its perimeter) and extends to {} of the half width of the pad; spacing {} mm with focus {} gives cells of {} \
         mm at its edge",
        format_number(accuracy),
        all.grasp,
        pad_name(all.side),
        three(all.size * 1e3),
        three(all.reach),
        three(spacing * 1e3),
        format_number(focus),
        three(at_edge * 1e3),
    );
    let (spacing, focus) = (Length::new(spacing).ok(), Ratio::new(focus).ok());
    Ok(Some(MeshChoice { pads: pads.with_mesh(spacing, focus), reason: why }))
}

/// Returns the indentation of the pad of finger `side` at `pose` under the largest load, by the Winkler foundation, m;
/// None for a pad without contact, or which starts inside the object. `size` is the size of the pad along x, y and z,
/// m. The gel stiffens under compression, so that beyond a few tenths of the thickness the result is an upper bound.
pub fn indentation(scene: &Scene, object: &Shape, side: usize, size: [f64; 3], pose: &Pose) -> Option<f64> {
    let own = Scene { gripper: scene.gripper.with_equal_fingers(side), ..scene.clone() };
    let bed = WinklerFoundation::from_scene(&own, size);
    let gaps = bed.gaps(object, pose, *closing(scene).get(side)?)?;
    let first = gaps.iter().copied().reduce(f64::min).filter(|first| first.is_finite())?;
    Some(bed.depth(&gaps, first, 4.0 * bed.half.x * bed.half.y / (POINTS * POINTS) as f64))
}

/// Returns the closing directions of the fingers, hand frame.
fn closing(scene: &Scene) -> &'static [DVec3] {
    match scene.gripper.fingers {
        Fingers::Both => &[DVec3::X, DVec3::NEG_X],
        Fingers::One => &[DVec3::X],
        Fingers::None => &[],
    }
}

/// Contact patch of a pad.
#[derive(Debug, Clone, Copy)]
struct Patch {
    grasp: usize,
    side: usize,
    /// Size: twice the area over the perimeter, m.
    size: f64,
    /// Largest distance of a point from the centre of the pad along x or y, in half widths.
    reach: f64,
}

impl Patch {
    /// Returns the smaller patch, with the larger of the two reaches.
    fn smaller(self, other: Self) -> Self {
        let smaller = if other.size < self.size { other } else { self };
        Self { reach: self.reach.max(other.reach), ..smaller }
    }
}

/// Pad as a Winkler foundation.
struct WinklerFoundation {
    hand: Hand,
    half: DVec2,
    /// Depth of each sample of the face below its highest point, m; infinite outside the pad.
    sunk: Vec<f64>,
    load: Load,
}

/// Load on a pad.
enum Load {
    /// Force over the stiffness per unit area, m3.
    Volume(f64),
    /// Depth after first contact, m.
    Depth(f64),
}

impl WinklerFoundation {
    fn from_scene(scene: &Scene, [x, y, thickness]: [f64; 3]) -> Self {
        let half = 0.5 * DVec2::new(x, y);
        let bounds = Aabb { min: (-half).extend(-thickness), max: half.extend(0.0) };
        let hand = Hand::new(bounds, &scene.gripper);
        let spec = scene.gripper.material.spec();
        let stiffness = FOUNDATION_STIFFNESS * spec.young / (1.0 - spec.poisson * spec.poisson) / thickness;
        let share = if scene.gripper.fingers == Fingers::Both { 0.5 } else { 1.0 };
        let load = match &scene.loading {
            Loading::Squeeze(squeeze) => Load::Volume(share * squeeze.force.get() / stiffness),
            Loading::Press(press) => Load::Depth(press.levels().into_iter().fold(0.0, f64::max)),
            Loading::Dynamic(dynamic) => {
                let most = motion::squeezes(&dynamic.motions).iter().fold(0.0, |m: f64, (_, force)| m.max(*force));
                Load::Volume(share * most / stiffness)
            }
        };
        let sunk = hand.face(DVec3::X, POINTS).map(|p| {
            // Pad x lies along the hand's z, pad y along its y.
            let at = DVec2::new(p.z - hand.center.z, p.y - hand.center.y);
            match &scene.gripper.pads {
                Pads::GelSightMini(g) if g.shape == GelShape::Domed => dome::depth(at.x, at.y),
                Pads::Disc(_) if at.length() > half.x => f64::INFINITY,
                _ => 0.0,
            }
        });
        Self { sunk: sunk.collect(), half, hand, load }
    }

    /// Returns the patches of a grasp; none for a pad without contact, or which starts inside the object.
    fn patches(&self, scene: &Scene, object: &Shape, grasp: usize, pose: &Pose) -> Vec<Patch> {
        let of = |(side, closing): (usize, &DVec3)| {
            let (size, reach) = self.patch(&self.gaps(object, pose, *closing)?)?;
            Some(Patch { grasp, side, size, reach })
        };
        closing(scene).iter().enumerate().filter_map(of).collect()
    }

    /// Returns the distances of the samples of the open pad from the object along `closing`, m, infinite if the ray
    /// misses; None for a pad that starts inside the object.
    fn gaps(&self, object: &Shape, pose: &Pose, closing: DVec3) -> Option<Vec<f64>> {
        let gap = |(start, sunk): (DVec3, &f64)| {
            let start = pose.transform(start);
            if object.distance.distance(start) < 0.0 {
                return None;
            }
            let hit = object.ray(start, pose.rotation * closing).filter(|hit| hit.t <= self.hand.opening);
            Some(hit.map_or(f64::INFINITY, |hit| hit.t + sunk))
        };
        self.hand.face(closing, POINTS).zip(&self.sunk).map(gap).collect()
    }

    /// Returns size and reach of the patch of a profile, given by its distances from the open pad, m.
    fn patch(&self, gaps: &[f64]) -> Option<(f64, f64)> {
        let first = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        if !first.is_finite() {
            return None;
        }
        let cell = 2.0 * self.half / POINTS as f64;
        let touched = first + self.depth(gaps, first, cell.x * cell.y);
        let inside = |x: usize, y: usize| gaps[x * POINTS + y] <= touched;
        let (mut count, mut crossed, mut reach) = (0, DVec2::ZERO, 0.0_f64);
        for x in 0..POINTS {
            for y in 0..POINTS {
                if inside(x, y) {
                    count += 1;
                    let out = |k: usize| (2 * k + 1).abs_diff(POINTS) as f64 / POINTS as f64;
                    reach = reach.max(out(x)).max(out(y));
                    // Number of sides of this sample on the boundary of the patch, including the rim of the pad.
                    let edges = |along: &dyn Fn(usize) -> bool, k: usize| {
                        f64::from(u8::from(k == 0 || !along(k - 1)) + u8::from(k + 1 == POINTS || !along(k + 1)))
                    };
                    crossed.y += edges(&|k| inside(k, y), x);
                    crossed.x += edges(&|k| inside(x, k), y);
                }
            }
        }
        // Length of a curve from its number of intersections with lines along two axes (Crofton 1868).
        let perimeter = std::f64::consts::FRAC_PI_4 * crossed.dot(cell);
        Some((2.0 * f64::from(count) * cell.x * cell.y / perimeter, reach))
    }

    /// Returns the travel of the pad after first contact, m.
    fn depth(&self, gaps: &[f64], first: f64, cell: f64) -> f64 {
        let volume = match self.load {
            Load::Depth(depth) => return depth,
            Load::Volume(volume) => volume,
        };
        let mut heights: Vec<f64> = gaps.iter().map(|g| g - first).filter(|g| g.is_finite()).collect();
        heights.sort_by(f64::total_cmp);
        // With the n lowest samples in contact, the springs are compressed by n depth - sum in total.
        let (mut sum, mut depth) = (0.0, 0.0);
        for (n, height) in heights.iter().enumerate() {
            sum += height;
            depth = (volume / cell + sum) / (n + 1) as f64;
            if heights.get(n + 1).is_none_or(|next| depth <= *next) {
                break;
            }
        }
        depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bed(load: Load) -> WinklerFoundation {
        let hand = Hand::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, &scene::Gripper::default());
        WinklerFoundation { hand, half: DVec2::new(12e-3, 10e-3), sunk: Vec::new(), load }
    }

    /// Distances of a surface from the pad, given as heights over the face.
    fn profile(height: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let at = |k: usize, half: f64| half * (2.0 * k as f64 + 1.0 - POINTS as f64) / POINTS as f64;
        (0..POINTS * POINTS).map(|k| 0.03 + height(at(k / POINTS, 12e-3), at(k % POINTS, 10e-3))).collect()
    }

    #[test]
    fn a_ball_has_a_round_patch_of_its_radius() {
        let ball = profile(|x, y| (x * x + y * y) / (2.0 * 0.025));
        let (size, reach) = bed(Load::Depth(0.5e-3)).patch(&ball).unwrap();
        // a^2 = 2 R d
        assert!((size - 5e-3).abs() < 0.1e-3, "{size} m");
        assert!((reach - 0.5).abs() < 0.03, "{reach}");
    }

    #[test]
    fn the_springs_carry_the_load() {
        let ball = profile(|x, y| (x * x + y * y) / (2.0 * 0.025));
        // Volume of a paraboloid cap of height d and radius of curvature R: pi R d^2.
        let volume = std::f64::consts::PI * 0.025 * 0.4e-3_f64.powi(2);
        let bed = bed(Load::Volume(volume));
        let first = ball.iter().copied().fold(f64::INFINITY, f64::min);
        let depth = bed.depth(&ball, first, 24e-3 * 20e-3 / (POINTS * POINTS) as f64);
        assert!((depth - 0.4e-3).abs() < 0.01e-3, "{depth} m");
    }
}
