//! A rigid sphere of radius 6 mm pressed into a pad of 20 x 25 x 4.5 mm, without friction, against CalculiX.

mod common;

use common::{Press, Setup, elements, errors, pad_body, reference_mesh, rows};
use glam::{DVec2, DVec3};
use std::sync::Arc;
use tactus::contact::{ContactSurface, law::Law};
use tactus::fem::body::Body;
use tactus::fem::newton::Tolerance;
use tactus::material::NeoHookean;
use tactus::pad::{Resolution, box_pad};
use tactus::shape::sphere::Sphere;

const RADIUS: f64 = 6e-3;
const YOUNG: f64 = 0.3e6;
const DEPTHS: [f64; 3] = [0.25e-3, 0.5e-3, 1.0e-3];

/// Start of the sphere and no friction.
fn setup(body: Arc<Body>, radius: f64) -> Setup {
    Setup { body, object: Arc::new(Sphere { radius }), start: DVec3::Z * RADIUS, friction: 0.0 }
}

/// The pad with 10-node tetrahedra and mean dilatation, finer towards the contact: 4725 nodes with [10, 12, 4] cells.
fn quadratic_pad_(cells: [usize; 3], poisson: f64, g: f64, f: f64) -> Arc<Body> {
    let resolution = Resolution::cells(cells).with_grading(g).with_focus(f);
    let pad = box_pad(20e-3, 25e-3, 4.5e-3, &resolution).expect("pad");
    pad_body(&pad, true, Arc::new(NeoHookean::new(YOUNG, poisson)))
}

/// Front-face displacement of the press at points of the rest face, m.
fn on_face(press: &Press, points: &[DVec2]) -> Vec<DVec3> {
    let (body, u) = (press.newton.body(0), press.displacement());
    let faces = &press.contact().surface().faces;
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

/// Relative L2 error of the front-face displacement against a profile file at a depth.
fn profile_error(press: &Press, file: &str, depth: f64) -> Option<f64> {
    let rows: Vec<_> = rows(file)?.into_iter().filter(|r| (r[0] * 1e-3 - depth).abs() < 1e-9).collect();
    assert!(rows.len() > 20, "{file} has depth {depth}");
    let points: Vec<DVec2> = rows.iter().map(|r| DVec2::new(r[1], r[2]) * 1e-3).collect();
    let truth: Vec<DVec3> = rows.iter().map(|r| DVec3::new(r[3], r[4], r[5]) * 1e-3).collect();
    Some(errors(&on_face(press, &points), &truth).0)
}


#[test]
fn probe() {
    for (cells, g, f) in [([14, 14, 3], 1.4, 4.0), ([14, 14, 3], 1.4, 6.0), ([14, 14, 3], 1.2, 5.0), ([14,14,3],1.0,4.0)] {
    let clock = std::time::Instant::now();
    let body = quadratic_pad_(cells, 0.45, g, f);
    let mut press = Press::new(setup(body.clone(), RADIUS));
    let s: Vec<String> = DEPTHS.into_iter().zip([0.216, 0.710, 2.548]).map(|(depth, truth)| {
        let force = press.to(depth, 1);
        let error = profile_error(&press, "sphere_q20_06_top_profile.csv", depth).unwrap();
        format!("{:+.2} % face {:.2} %", 100.0 * (force / truth - 1.0), error * 100.0)
    }).collect();
    let rows: Vec<_> = rows("sphere_q20_06_top_profile.csv").unwrap().into_iter().filter(|r| r[0] == 1.0).collect();
    let points: Vec<DVec2> = rows.iter().map(|r| DVec2::new(r[1], r[2]) * 1e-3).collect();
    let u = on_face(&press, &points);
    let mut part = [[0.0; 2]; 5];
    for (r, u) in rows.iter().zip(&u) {
        let t = DVec3::new(r[3], r[4], r[5]) * 1e-3;
        let k = ((r[1].hypot(r[2]) / 2.5) as usize).min(4);
        part[k][0] += (*u - t).length_squared();
        part[k][1] += t.length_squared();
    }
    let total: f64 = part.iter().map(|p| p[1]).sum();
    println!("{cells:?} {g} {f} nodes {} {s:?} {:.1?} rings of 2.5 mm: share of error {:?} %", body.rest.len(), clock.elapsed(), part.map(|p| ((p[0] / total).sqrt() * 1000.0).round() / 10.0));
    }
}
