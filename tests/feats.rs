//! The real sensor: a rigid sphere of radius 7.5 mm pressed on the apex of a GelSight Mini gel, measured by FEATS.
//!
//! FEATS identified C10 = 0.0725 MPa with a CalculiX model of its own: the domed gel of its CAD, back face fixed, 10-node
//! tetrahedra, compressibility left at CalculiX's default (nu = 0.475), the indenter *tied* to the gel where they meet.

mod common;

use common::{Press, Setup, pad_body};
use glam::DVec3;
use std::sync::Arc;
use tactus::material::NeoHookean;
use tactus::pad::{GelShape, Resolution, gelsight_mini};
use tactus::shape::sphere::Sphere;

const C10: f64 = 0.0725e6;
const RADIUS: f64 = 7.5e-3;
/// Depth, m, and measured force, N.
const HARDWARE: [(f64, f64); 4] = [(0.5e-3, 1.6503), (1.0e-3, 5.9641), (1.5e-3, 13.5257), (2.0e-3, 23.2532)];

/// Forces, N, at the depths of [`HARDWARE`].
fn curve(shape: GelShape, cells: [usize; 3], poisson: f64, friction: f64) -> Vec<f64> {
    let resolution = Resolution::cells(cells).with_grading(1.3).with_focus(4.0);
    let pad = gelsight_mini(shape, &resolution).expect("pad");
    let body = pad_body(&pad, true, Arc::new(NeoHookean::from_c10(C10, poisson)));
    let object = Arc::new(Sphere { radius: RADIUS });
    let mut press = Press::new(Setup { body, object, start: DVec3::Z * RADIUS, friction });
    HARDWARE.iter().map(|(depth, _)| press.to(*depth, 2)).collect()
}

/// Prints a curve with its deviations from the hardware; the largest deviation.
fn report(what: &str, forces: &[f64]) -> f64 {
    let off: Vec<f64> = forces.iter().zip(HARDWARE).map(|(f, (_, real))| f / real - 1.0).collect();
    let text: Vec<String> = forces.iter().zip(&off).map(|(f, o)| format!("{f:.3} N ({:+.1} %)", 100.0 * o)).collect();
    println!("{what}: {}", text.join(", "));
    off.iter().fold(0.0, |a: f64, o| a.max(o.abs()))
}

#[test]
fn probe_all() {
    let d = GelShape::Domed;
    for (nu, mu, steps) in [(0.475, 1.0, 4), (0.475, 10.0, 4), (0.49, 1.0, 4), (0.49,0.5,4)] { let clock = std::time::Instant::now();
    let resolution = Resolution::cells([8, 6, 3]).with_grading(1.3).with_focus(4.0);
    let pad = gelsight_mini(d, &resolution).expect("pad");
    let body = pad_body(&pad, true, Arc::new(NeoHookean::from_c10(C10, nu)));
    let object = Arc::new(Sphere { radius: RADIUS });
    let mut press = Press::new(Setup { body, object, start: DVec3::Z * RADIUS, friction: mu }); press.tolerance = tactus::fem::newton::Tolerance { force: 2e-3, length: 1e-5, iterations: 200, motion: 1e-3 };
    let r = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| { let f: Vec<f64> = HARDWARE.iter().map(|(depth, _)| { let f = press.to(*depth, steps); println!("   {f} its {}", press.newton.profile.iterations); f }).collect(); report("x", &f); }));
    println!("nu {nu} {:.1?} mu {mu} steps {steps} {}", clock.elapsed(), r.is_ok());
    }
}
