//! Rigid sphere on a thick, wide block: Hertz's law in the normal direction, corrected for the finite thickness of the
//! block, Mindlin's initial tangential stiffness, and Coulomb's law in full sliding.

use crate::common::{OFFSET, Press, Setup, elements};
use glam::DVec3;
use std::sync::Arc;
use tactus::geometry::mesh::grid;
use tactus::geometry::pad::{Resolution, box_pad};
use tactus::geometry::shape::sphere::Sphere;
use tactus::mech::body::Body;
use tactus::mech::material::{Linear, Material, NeoHookean};
use tactus::mech::newton::NewtonTolerance;

const YOUNG: f64 = 0.3e6;
const RADIUS: f64 = 20e-3;
const THICKNESS: f64 = 20e-3;

/// Block of 80 x 80 x 20 mm, bonded at its base, with cells of 0.8 mm under the sphere.
fn block(poisson: f64) -> Arc<Body> {
    let half = [0.8, 1.6, 2.4, 4.5, 11.0, 40.0].map(|v| v * 1e-3);
    let across: Vec<f64> = half.iter().rev().map(|v| -v).chain([0.0]).chain(half).collect();
    let depth: Vec<f64> = [20.0, 7.0, 2.8, 1.4, 0.6, 0.0].map(|v| -v * 1e-3).to_vec();
    let mesh = grid::structured([&across, &across, &depth]).expect("grid");
    let (rest, elements) = elements(&mesh, true);
    let fixed = rest.iter().map(|p| p.z < -THICKNESS + 1e-9).collect();
    let law: Arc<dyn Material> = Arc::new(Linear::new(YOUNG, poisson));
    Arc::new(Body::new(rest, elements, fixed, law, true))
}

fn ball_on(body: Arc<Body>, radius: f64, friction: f64) -> Press {
    Press::new(Setup { body, object: Arc::new(Sphere { radius }), start: DVec3::Z * radius, friction })
}

/// Ratio of the force of a rigid sphere on a bonded layer to that on a half-space (Dimitriadis, Horkay, Maresca, Kachar
/// & Chadwick 2002, Biophysical Journal 82, equation 11), `chi = sqrt(R d) / h`.
fn thickness_factor(chi: f64, nu: f64) -> f64 {
    let a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
    let b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1.0 - nu);
    let pi = std::f64::consts::PI;
    1.0 - 2.0 * a / pi * chi + 4.0 * a * a / (pi * pi) * chi.powi(2)
        - 8.0 / pi.powi(3) * (a.powi(3) + 4.0 * pi * pi / 15.0 * b) * chi.powi(3)
        + 16.0 * a / pi.powi(4) * (a.powi(3) + 3.0 * pi * pi / 5.0 * b) * chi.powi(4)
}

#[test]
fn a_ball_on_a_block_follows_hertz() {
    let poisson = 0.45;
    let mut press = ball_on(block(poisson), RADIUS, 0.0);
    // Contact begins at the offset of the contact law, which enlarges the sphere.
    let radius = RADIUS + OFFSET;
    let mut curve = Vec::new();
    for depth in [0.1e-3, 0.16e-3, 0.26e-3] {
        let force = press.to(depth, 1) / thickness_factor((radius * depth).sqrt() / THICKNESS, poisson);
        let hertz = 4.0 / 3.0 * YOUNG / (1.0 - poisson * poisson) * radius.sqrt() * depth.powf(1.5);
        println!("{:.2} mm: {force:.5} N, Hertz {hertz:.5} N, {:+.2} %", depth * 1e3, 100.0 * (force / hertz - 1.0));
        curve.push((depth.ln(), force.ln(), force / hertz));
    }
    let n = curve.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64, f64)) -> f64| curve.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|c| c.0), mean(&|c| c.1));
    let exponent = mean(&|c| (c.0 - x) * (c.1 - y)) / mean(&|c| (c.0 - x).powi(2));
    println!("exponent {exponent:.4}");
    assert!((exponent - 1.5).abs() < 0.05, "exponent {exponent}");
    for (_, _, stiffness) in &curve {
        assert!((stiffness - 1.0).abs() < 0.03, "stiffness over Hertz {stiffness}");
    }
}

/// Moves the object sideways by `step` (m) and solves; returns the normal and tangential force on the pad, N.
fn shear(press: &mut Press, step: f64) -> (f64, f64) {
    let mut start = press.path.state.clone();
    start.position.x += step;
    let tolerance = NewtonTolerance { length: 1e-6, iterations: 80, ..NewtonTolerance::new(OFFSET) };
    let (state, _) = press.path.newton.solve(&press.path.state, start, &tolerance).expect("converges");
    press.path.newton.commit(&state);
    press.path.state = state;
    let force: DVec3 = press.edges().iter().map(|edge| edge.force).sum();
    (-force.z, force.x)
}

/// Mindlin 1949: the tangential stiffness of a sticking contact is 2 (1 - nu) / (2 - nu) times the normal stiffness at
/// the same contact area, to 10 %.
#[test]
#[ignore = "thorough: a fine mesh"]
fn a_sticking_contact_is_as_stiff_in_shear_as_mindlin_says() {
    let (poisson, depth) = (0.45, 0.2e-3);
    let mut press = ball_on(block(poisson), RADIUS, 1.0);
    press.to(depth, 2);
    let step = 2e-6;
    let (_, tangential) = shear(&mut press, step);
    let (_, more) = shear(&mut press, step);
    let shear_modulus = YOUNG / (2.0 * (1.0 + poisson));
    let a = (RADIUS * depth).sqrt();
    let mindlin = 8.0 * a * shear_modulus / (2.0 - poisson);
    let stiffness = (more - tangential) / step;
    println!(
        "{stiffness:.1} N/m, Mindlin on a half-space {mindlin:.1} N/m, {:+.2} %",
        100.0 * (stiffness / mindlin - 1.0)
    );
    // At a contact radius of a tenth of the thickness the bonded base adds some percent, half as much as to the normal
    // stiffness.
    assert!((stiffness / mindlin - 1.0).abs() < 0.1, "{stiffness} N/m against {mindlin} N/m");
}

/// A sphere pressed 1.0 mm into a pad, then moved sideways, first sticks and finally slides with a friction force of mu
/// times the normal force, to 1 % of the pressure integral and 10 % of the resultant.
#[test]
fn a_ball_dragged_sideways_slides_with_mu_times_the_normal_force() {
    let friction = 0.3;
    let pad =
        box_pad(25e-3, 20e-3, 4.5e-3, &Resolution::cells([8, 6, 2]).with_grading(1.3).with_focus(2.0)).expect("pad");
    let body = crate::common::pad_body(&pad, true, Arc::new(NeoHookean::new(YOUNG, 0.45)));
    let mut press = ball_on(body, RADIUS, friction);
    press.to(1e-3, 4);
    let mut curve = vec![0.0];
    for k in 1..=8 {
        let (normal, tangential) = shear(&mut press, 0.2e-3);
        let edges = press.edges();
        let area = |i: usize| press.surface.area[i];
        let points = || edges.iter().filter(|e| e.state.pressure > 0.0).map(|e| (e.state, area(e.number)));
        let pressure: f64 = points().map(|(e, a)| e.pressure * a).sum();
        // Sum of magnitudes: tractions on the inclined sides of the indentation point in different directions.
        let traction: f64 = points().map(|(e, a)| e.traction.length() * a).sum();
        // The friction limit may be lagged where Newton iterations oscillate; bound the total excess traction.
        let excess: f64 = points().map(|(e, a)| (e.traction.length() - friction * e.pressure).max(0.0) * a).sum();
        let sticking = points().filter(|(e, _)| !e.slips).count();
        println!(
            "{:.1} mm: {normal:.4} N, {tangential:.4} N, ratio {:.4}; friction over pressure {:.4}, {:.1e} beyond the limit, \
             {sticking} points stick",
            0.2 * k as f64,
            tangential / normal,
            traction / pressure,
            excess / normal
        );
        assert!(excess < 2e-3 * normal, "{excess} N beyond Coulomb's limit");
        curve.push(traction / pressure);
        if k == 8 {
            assert!((tangential / normal / friction - 1.0).abs() < 0.1, "drags with {tangential} N at {normal} N");
            assert!(sticking <= points().count() / 50, "all of the contact slides but {sticking} points");
        }
    }
    for w in curve[..6].windows(3) {
        assert!(w[2] - w[1] <= w[1] - w[0], "until it slides, the contact only softens: {curve:?}");
    }
    // The ratio of resultants exceeds mu because the gel bulges in front of the sphere, which inclines the pressure.
    let last = curve[curve.len() - 1];
    assert!((last / friction - 1.0).abs() < 0.01, "slides with {last} times the pressure, mu is {friction}");
}
