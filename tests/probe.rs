mod common;
use common::*;
use glam::DVec3;
use std::sync::Arc;
use tactus::material::*;
use tactus::contact::{ContactSurface, law::Law};
use tactus::fem::body::*;
use tactus::fem::newton::Tolerance;
use tactus::shape::sphere::Sphere;
#[test]
fn probe() {
    let mut mesh = reference_mesh("pad_1k").unwrap();
    for p in &mut mesh.nodes { *p = *p * 1e-3 - DVec3::Z * 4.5e-3; }
    let (nodes, el) = elements(&mesh, false);
    let fixed = nodes.iter().map(|p| p.z < -4.4999e-3).collect();
    let body = Arc::new(Body::new(nodes, el, fixed, Arc::new(NeoHookean::new(0.3e6, 0.45)), true).unwrap());
    for (hard, m, k, offset) in [(true, 4, 0.0, 1e-6),(true, 4, 0.0, 1e-7), (false,4,2e11,20e-6),(false,8,2e11,20e-6),(false,16,2e11,20e-6),(false,32,2e11,20e-6)] {
        let surface = Arc::new(ContactSurface::with_subdivision(&body, m));
        let k = if hard { 50.0 * 0.3e6 / surface.spacing } else { k };
        let law = Law { stiffness: k, offset, friction: 0.0, tangential: k };
        let radius = if hard { 6e-3 } else { 6e-3 - offset };
        let mut p = Press::with_law(Setup { body: body.clone(), object: Arc::new(Sphere { radius }), start: DVec3::Z * 6e-3, friction: 0.0 }, law, surface);
        let clock = std::time::Instant::now();
        let mut out = vec![];
        for (d, t) in [(0.25e-3, 0.4512256), (0.5e-3, 1.347288), (1e-3, 3.8087396)] {
            let f = if hard { p.to(d, 4) } else {
                let tolerance = Tolerance { force: 1e-6, length: 1e-6, iterations: 100, motion: 1e-3 };
                let from = p.state.travel[0];
                for s in 1..=4 { p.state.travel[0] = from + (d - from) * s as f64 / 4.0; if let Err(e) = p.newton.solve(&mut p.state, &tolerance) { println!("{e:?}"); } }
                let c = p.contact();
                -(0..c.edges.len()).map(|i| c.force(i).z).sum::<f64>() };
            let u0 = p.displacement().iter().zip(&body.rest).find(|(_, r)| r.length() < 1e-9).unwrap().0.z;
            out.push(format!("{f:.4} ({:+.2} %) gap {:.2e} u0 {:.4}", (f / t - 1.0) * 100.0, p.contact().min_gap() - if hard {0.0} else {offset}, u0*1e3));
        }
        println!("hard {hard} m {m} offset {offset}: {out:?} {:.1?}", clock.elapsed());
    }
}
