//! Frictionless press of a rigid sphere of radius 6 mm into a pad of 20 x 25 x 4.5 mm, against CalculiX.

use crate::common::{Press, Setup, elements, errors, pad_body, reference_mesh, rows};
use glam::{DVec2, DVec3};
use std::sync::Arc;
use tactus::geometry::pad::{Resolution, box_pad};
use tactus::geometry::shape::sphere::Sphere;
use tactus::mech::body::Body;
use tactus::mech::contact::ContactSurface;
use tactus::mech::contact::law::ContactLaw;
use tactus::mech::material::NeoHookean;

const RADIUS: f64 = 6e-3;
const YOUNG: f64 = 0.3e6;
const DEPTHS: [f64; 3] = [0.25e-3, 0.5e-3, 1.0e-3];

/// Frictionless setup with a sphere of `radius` whose centre starts at a height of `RADIUS`.
fn setup(body: Arc<Body>, radius: f64) -> Setup {
    Setup { body, object: Arc::new(Sphere { radius }), start: DVec3::Z * RADIUS, friction: 0.0 }
}

/// Pad of 10-node tetrahedra with mean dilatation, refined towards the contact: 5887 nodes with [14, 14, 3] cells.
fn quadratic_pad(cells: [usize; 3], poisson: f64) -> Arc<Body> {
    let resolution = Resolution::cells(cells).with_grading(1.2).with_focus(5.0);
    let pad = box_pad(20e-3, 25e-3, 4.5e-3, &resolution).expect("pad");
    pad_body(&pad, true, Arc::new(NeoHookean::new(YOUNG, poisson)))
}

/// Returns the displacement of the front face at points of the undeformed face, m.
fn on_face(press: &Press, points: &[DVec2]) -> Vec<DVec3> {
    let (body, u) = (press.body(), press.displacement());
    let faces = &press.surface.faces;
    let front: Vec<_> = faces.iter().filter(|f| f.corners.iter().all(|&n| body.rest[n as usize].z > -1e-9)).collect();
    let value = |p: &DVec2| {
        let inside = front.iter().find_map(|face| {
            let [a, b, c] = face.corners.map(|n| body.rest[n as usize].truncate());
            let area = (b - a).perp_dot(c - a);
            let l = [(b - *p).perp_dot(c - *p), (c - *p).perp_dot(a - *p), (a - *p).perp_dot(b - *p)].map(|s| s / area);
            l.iter().all(|l| *l > -1e-4).then(|| face.stencil(l).position(&u))
        });
        inside.unwrap_or_else(|| panic!("{p} is on the front face"))
    };
    points.iter().map(value).collect()
}

/// Returns the relative L2 error of the front-face displacement against the profile `file` at `depth` (m).
fn profile_error(press: &Press, file: &str, depth: f64) -> f64 {
    let rows: Vec<_> = rows(file).into_iter().filter(|r| (r[0] * 1e-3 - depth).abs() < 1e-9).collect();
    assert!(rows.len() > 20, "{file} has depth {depth}");
    let points: Vec<DVec2> = rows.iter().map(|r| DVec2::new(r[1], r[2]) * 1e-3).collect();
    let truth: Vec<DVec3> = rows.iter().map(|r| DVec3::new(r[3], r[4], r[5]) * 1e-3).collect();
    errors(&on_face(press, &points), &truth).0
}

/// Forces agree with the converged 0.216, 0.710, 2.548 N (known to 1.5, 1 and 0.5 %) to 3, 2 and 1.5 %, the front face
/// with a fine solution (known to 1 %) to 4, 3 and 2.5 %. The face error is concentrated at the contact boundary, where
/// the slope has a kink inside an element.
#[test]
fn quadratic_tetrahedra_with_mean_dilatation_give_the_true_force_and_face() {
    let body = quadratic_pad([14, 14, 3], 0.45);
    assert!(body.rest.len() <= 6000, "{} nodes", body.rest.len());
    let mut press = Press::new(setup(body.clone(), RADIUS));
    let truths = [(0.216, 0.03, 0.04), (0.710, 0.02, 0.03), (2.548, 0.015, 0.025)];
    for (depth, (truth, force_allowed, face_allowed)) in DEPTHS.into_iter().zip(truths) {
        let force = press.to(depth, 1);
        let off = force / truth - 1.0;
        println!("{} nodes, {:.2} mm: {force:.4} N, {:+.2} %", body.rest.len(), depth * 1e3, 100.0 * off);
        assert!(off.abs() < force_allowed, "force {force} against {truth} N at {depth} m");
        assert!(press.min_gap() > 0.0, "no contact point is inside the sphere");
        let error = profile_error(&press, "sphere_q20_06_top_profile.csv", depth);
        println!("   front face: {:.2} % of the displacement (relative L2)", 100.0 * error);
        assert!(error < face_allowed, "front face off by {error:.4} at {depth} m");
    }
    let peak = body.stress(&press.path.state.x[0]).node.iter().copied().fold(0.0, f64::max);
    println!("   largest nodal von Mises stress {:.4} MPa", peak * 1e-6);
    assert!((peak / 0.092e6 - 1.0).abs() < 0.05, "von Mises stress {peak} against 0.092e6 Pa, known to 2 %");
}

/// At the gel's nu = 0.49 mesh refinement changes the force by less than 3 %; linear tetrahedra lock: more than 1.5
/// times the force.
#[test]
fn nearly_incompressible_pads_do_not_lock() {
    let force = |cells| Press::new(setup(quadratic_pad(cells, 0.49), RADIUS)).to(1e-3, 2);
    let (coarse, fine) = (force([8, 10, 3]), force([14, 14, 3]));
    println!("nu = 0.49, 1 mm: {coarse:.4} {fine:.4} N");
    assert!((coarse / fine - 1.0).abs() < 0.03, "{coarse} N against {fine} N on the finer mesh");
    let locked = Press::new(setup(linear_pad(0.49), RADIUS)).to(1e-3, 2);
    println!("linear tetrahedra: {locked:.4} N");
    assert!(locked > 1.5 * fine, "linear tetrahedra give {locked} N: the notice about locking would be wrong");
}

/// Mesh pad_1k with linear tetrahedra, shifted so that the front face is z = 0, m.
fn linear_pad(poisson: f64) -> Arc<Body> {
    let mut mesh = reference_mesh("pad_1k");
    for p in &mut mesh.nodes {
        *p = (*p - DVec3::Z * 4.5) * 1e-3;
    }
    let (nodes, elements) = elements(&mesh, false);
    let fixed = nodes.iter().map(|p| p.z < -4.4999e-3).collect();
    Arc::new(Body::new(nodes, elements, fixed, Arc::new(NeoHookean::new(YOUNG, poisson)), true))
}

/// Forces of CalculiX with linear tetrahedra on pad_1k, N.
const LINEAR: [f64; 3] = [0.4512256, 1.347288, 3.8087396];

/// Presses linear tetrahedra to the three depths and checks forces and front faces against CalculiX.
fn check_linear(press: &mut Press, steps: u32, force_allowed: f64, face_allowed: f64) {
    for (depth, truth) in DEPTHS.into_iter().zip(LINEAR) {
        let force = press.to(depth, steps);
        let error = profile_error(press, "sphere_c3d4_pad_1k_q_top_profile.csv", depth);
        let off = force / truth - 1.0;
        println!(
            "{:.2} mm: {force:.4} N, {:+.2} %; face {:.2} %; gap {:.1} um",
            depth * 1e3,
            100.0 * off,
            100.0 * error,
            press.min_gap() * 1e6
        );
        assert!(off.abs() < force_allowed, "force {force} against {truth} N at {depth} m");
        assert!(error < face_allowed, "front face off by {error:.4} at {depth} m");
    }
}

/// The same discrete problem as the reference, whose contact law is a penalty of 200 MPa/mm, integrated finely over
/// each face: forces agree to 0.5 %, faces to 1 %. The sphere penetrates by up to 12 um along the ridges between the
/// flat faces of linear tetrahedra.
#[test]
fn linear_tetrahedra_with_the_contact_law_of_calculix_give_its_force_and_face() {
    let body = linear_pad(0.45);
    let surface = Arc::new(ContactSurface::with_subdivision(&body, 16));
    // Contact starts at `RADIUS` because the sphere is smaller by the offset; the law stays on its first branch.
    let law = ContactLaw { stiffness: 200e9, offset: 40e-6, friction: 0.0, tangential: 200e9 };
    let setup = Setup { start: DVec3::Z * (RADIUS - law.offset), ..setup(body, RADIUS - law.offset) };
    let mut press = Press::with_law(setup, law, surface);
    check_linear(&mut press, 1, 0.005, 0.01);
    let sunk = law.offset - press.min_gap();
    assert!(sunk < 15e-6, "the penalty gives way by {sunk} m");
}

/// The default contact law is more compliant by some micrometres at first contact: the force is 2.5 % below the
/// reference at 0.25 mm and within 0.6 % from 0.5 mm on.
#[test]
fn linear_tetrahedra_are_near_calculix() {
    check_linear(&mut Press::new(setup(linear_pad(0.45), RADIUS)), 1, 0.03, 0.04);
}
