//! Measurement on the real sensor by FEATS: a rigid sphere of radius 7.5 mm pressed on the apex of a GelSight Mini gel.
//!
//! The model is the gel preset: domed gel of the CAD with a fixed back, C10 = 0.0725 MPa, nu = 0.49, friction 0.8 as of
//! gel on plastic. Nothing is fitted here. FEATS fitted C10 to these four forces (least squares in newtons, dominated
//! by the last two) with another model: CalculiX, nu = 0.475 (its default), surfaces tied by springs of unstated
//! stiffness. The zero of the measured depth and the compliance of the rig are unknown.
//!
//! Deviations in percent at 0.5 / 1.0 / 1.5 / 2.0 mm with 3213 nodes and 5 to 20 increments per half millimetre (5 give
//! up to 2 % less force than 20):
//!
//! | friction | nu 0.49 | nu 0.475 |
//! |---|---|---|
//! | none | -15 / -10 / -9 / -2 | -19 / -15 / -14 / -7 |
//! | 0.1 | | -18 / -12 / -9 / +1 |
//! | 0.3 | -14 / -3 / +7 / +25 | -19 / -10 / -2 / +14 |
//! | 0.8 | -14 / -3 / +7 / +29 | -18 / -9 / -1 / +17 |
//! | 20 (tied) | -14 / -3 / +7 / +29 | -20 / -11 / -3 / +15 |
//!
//! With friction, deviations are within 12 % at 1.0 and 1.5 mm only. At 0.5 mm all forces are low by the equivalent of
//! 0.04 mm of depth. At 2 mm, half the thickness, friction increases the force by a third, and the measured force is
//! near the frictionless one.

use crate::common::{Press, Setup, pad_body};
use glam::DVec3;
use std::sync::{Arc, LazyLock};
use tactus::geometry::pad::{GelProfile, Resolution, gelsight_mini};
use tactus::geometry::shape::sphere::Sphere;
use tactus::mech::material::NeoHookean;
use tactus::mech::newton::NewtonTolerance;

const C10: f64 = 0.0725e6;
const RADIUS: f64 = 7.5e-3;
const FRICTION: f64 = 0.8;
/// Depths, m, and measured forces, N.
const HARDWARE: [(f64, f64); 4] = [(0.5e-3, 1.6503), (1.0e-3, 5.9641), (1.5e-3, 13.5257), (2.0e-3, 23.2532)];
/// Cells of the pad: 2499 nodes, with forces within 2.5 % of those of 6525 nodes and twice as many increments.
const CELLS: [usize; 3] = [10, 8, 3];

/// Computes the forces, N, at the depths of [`HARDWARE`], each reached in `steps` increments.
fn curve(shape: GelProfile, cells: [usize; 3], poisson: f64, friction: f64, steps: u32) -> [f64; 4] {
    let resolution = Resolution::cells(cells).with_grading(1.3).with_focus(4.0);
    let pad = gelsight_mini(shape, &resolution).expect("pad");
    let body = pad_body(&pad, true, Arc::new(NeoHookean::from_c10(C10, poisson)));
    let object = Arc::new(Sphere { radius: RADIUS });
    let mut press = Press::new(Setup { body, object, start: DVec3::Z * RADIUS, friction });
    press.path.tolerance = NewtonTolerance { iterations: 60, ..press.path.tolerance };
    let forces = HARDWARE.map(|(depth, _)| press.to(depth, steps));
    let off = |k: usize| 100.0 * (forces[k] / HARDWARE[k].1 - 1.0);
    let text: Vec<String> = (0..4).map(|k| format!("{:.3} N ({:+.1} %)", forces[k], off(k))).collect();
    println!("{shape:?} {cells:?} nu {poisson} friction {friction}: {}", text.join(", "));
    forces
}

/// Frictionless forces with [`CELLS`], shared by tests.
static SLIPPERY: LazyLock<[f64; 4]> = LazyLock::new(|| curve(GelProfile::Domed, CELLS, 0.49, 0.0, 2));

/// Returns the depth, m, at which a curve reaches `force`, by a power law between the samples.
fn depth_at(curve: &[f64; 4], force: f64) -> f64 {
    let k = curve[1..3].iter().filter(|f| **f < force).count();
    let (d, f) = ([HARDWARE[k].0, HARDWARE[k + 1].0], [curve[k], curve[k + 1]]);
    let exponent = (d[1] / d[0]).ln() / (f[1] / f[0]).ln();
    d[0] * (force / f[0]).powf(exponent)
}

/// Asserts relative deviations from the measured forces and prints the equivalent changes of depth.
fn check(ours: &[f64; 4], allowed: [f64; 4]) {
    for ((depth, real), (force, allowed)) in HARDWARE.into_iter().zip(ours.iter().zip(allowed)) {
        let shift = depth_at(ours, real) - depth;
        println!("{:.1} mm: the measured force is reached {:+.3} mm deeper", depth * 1e3, shift * 1e3);
        assert!((force / real - 1.0).abs() < allowed, "{force} against {real} N at {depth} m");
    }
}

#[test]
fn the_domed_gel_carries_what_the_real_sensor_measured() {
    let sticky = curve(GelProfile::Domed, CELLS, 0.49, FRICTION, 10);
    check(&sticky, [0.17, 0.12, 0.12, 0.31]);
    let slippery = *SLIPPERY;
    check(&slippery, [0.17, 0.12, 0.12, 0.12]);
    for k in 2..4 {
        let real = HARDWARE[k].1;
        assert!(slippery[k] < real && real < sticky[k], "{real} N between no friction and friction");
    }
    for (k, (depth, real)) in HARDWARE.into_iter().enumerate().take(3) {
        let shift = depth_at(&sticky, real) - depth;
        assert!(shift.abs() < 0.06e-3, "sample {k}: the measured force is reached {shift} m off");
    }
}

/// Frictionless forces change by less than 4 % (at 0.5 mm) and 1.5 % with the mesh, increase with nu by less than 10 %
/// from 0.475 to 0.495, and are larger for a flat face.
#[test]
#[ignore = "thorough: a refinement study"]
fn mesh_compressibility_and_dome_shift_the_curve_as_they_should() {
    let cells = [8, 6, 3];
    let base = curve(GelProfile::Domed, cells, 0.49, 0.0, 2);
    let finer = *SLIPPERY;
    // At 0.5 mm the contact spans only a few cells.
    for (k, allowed) in [0.04, 0.015, 0.015, 0.015].into_iter().enumerate() {
        assert!((base[k] / finer[k] - 1.0).abs() < allowed, "mesh: {} against {} N", base[k], finer[k]);
    }
    let soft = curve(GelProfile::Domed, cells, 0.475, 0.0, 2);
    let stiff = curve(GelProfile::Domed, cells, 0.495, 0.0, 2);
    let flat = curve(GelProfile::Flat, cells, 0.49, 0.0, 2);
    for k in 0..4 {
        assert!(soft[k] < base[k] && base[k] < stiff[k], "a less compressible gel is stiffer");
        assert!((stiff[k] / soft[k] - 1.0) < 0.1, "nu from 0.475 to 0.495 changes the force by less than 10 %");
        assert!(flat[k] > base[k], "a flat face meets the sphere sooner than a dome");
    }
}
