//! scratch
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;
use tactus::contact::{Contact, ContactSurface, Feature, FeatureContact, law::Law};
use tactus::fem::{body::*, increment::*, newton::*, state::*, term::*};
use tactus::gripper::{Approach, Placement, approach};
use tactus::material::*;
use tactus::pad::{GelShape, Resolution, gelsight_mini};
use tactus::shape::*;

fn var(n: &str, d: f64) -> f64 {
    std::env::var(n).map(|v| v.parse().unwrap()).unwrap_or(d)
}

fn squeeze(shape: &Shape, pose: (DVec3, DQuat), free: bool, mu: f64, verbose: bool) -> Result<(u32, Profile), String> {
    let pad = gelsight_mini(
        GelShape::Flat,
        &Resolution::cells([var("NX", 10.) as usize, var("NY", 8.) as usize, var("NZ", 2.) as usize]),
    )
    .unwrap();
    let quad = tactus::mesh::quadratic::promote(&pad.mesh);
    let (position, rotation) = pose;
    let mut bodies = vec![];
    let mut terms: Vec<Vec<Box<dyn BodyTerm>>> = vec![];
    let mut x = vec![];
    let mut travel = vec![];
    let mut closing = vec![];
    let e = 4.321e5;
    let material: Arc<dyn Material> = Arc::new(NeoHookean::new(e, 0.49));
    let mut features: Vec<Feature> =
        shape.features.sample(0.3e-3).iter().map(|f| Feature { position: f.position, sharp: f.sharp }).collect();
    if std::env::var("NOFEAT").is_ok() {
        features.clear();
    }
    let features: Arc<[Feature]> = features.into();
    for side in 0..2 {
        let p = Placement::new(side, 0.08, 0.1);
        let rest: Vec<DVec3> = quad.nodes.iter().map(|v| p.place(*v)).collect();
        let fixed: Vec<bool> = quad.nodes.iter().map(|v| v.z < -0.004 + 1e-9).collect();
        let body = Arc::new(
            Body::new(rest.clone(), Elements::Quadratic(quad.tets.clone()), fixed, material.clone(), true).unwrap(),
        );
        let surface = Arc::new(ContactSurface::new(&body));
        let a = approach(
            &surface,
            &rest,
            p.closing,
            shape.distance.as_ref(),
            &features,
            position,
            DMat3::from_quat(rotation),
            0.04,
            31.6 * var("OFF", 1e-5),
        );
        let Approach::Contact(t) = a else { return Err(format!("{a:?}")) };
        travel.push(t);
        let k = var("KS", 50.0) * e / surface.spacing;
        if side == 0 && verbose {
            println!("features {}", features.len());
            println!(
                "nodes {} el {} free {} points {} k {k:.2e} L {}",
                rest.len(),
                body.element_count(),
                body.pattern.free,
                surface.points.len(),
                body.symbolic.entries()
            );
        }
        let law = Law { stiffness: k, offset: var("OFF", 1e-5), friction: mu, tangential: var("KT", 0.3) * k };
        terms.push(vec![
            Box::new(Elastic),
            Box::new(Contact::new(law, surface.clone(), shape.distance.clone())),
            Box::new(FeatureContact::new(law, surface, features.clone())),
        ]);
        bodies.push(body);
        x.push(rest);
        closing.push(p.closing);
    }
    let border = Border::new(closing, true, free, shape.bounding_radius);
    let newton = Newton::new(bodies.clone(), terms, border);
    let state = State { x, travel: travel.clone(), position, rotation };
    let tol = Tolerance {
        relative: var("RTOL", 2e-4),
        force: var("FTOL", 1e-7),
        length: var("LTOL", 1e-6),
        iterations: 60,
        motion: 1e-3,
    };
    let mut path = Path::new(newton, state, tol);
    let frames = 50;
    let mut total = 0;
    let clock = std::time::Instant::now();
    match path.establish(7.5 / frames as f64, var("OFF", 1e-5)) {
        Ok(a) => {
            total += a.iterations;
            if verbose {
                println!("establish {a:?}")
            }
        }
        Err(e) => return Err(format!("establish {e:?}")),
    }
    for f in 1..=frames {
        let target = 7.5 * f as f64 / frames as f64;
        match path.advance(Load::Force, target) {
            Ok(a) => {
                total += a.iterations;
                let s = &path.state;
                if verbose && (f <= 5 || f % 10 == 0) {
                    let mut fs = vec![];
                    let mut gap = 1.0f64;
                    let mut active = 0;
                    let mut slips = 0;
                    for i in 0..2 {
                        let c = path.newton.terms[i][1].as_any().downcast_ref::<Contact>().unwrap();
                        fs.push((0..c.edges.len()).fold(DVec3::ZERO, |s, i| s + c.force(i)));
                        gap = gap.min(c.min_gap());
                        active += c.edges.iter().filter(|e| e.pressure > 0.0).count();
                        slips += c.edges.iter().filter(|e| e.slips).count();
                        let c = path.newton.terms[i][2].as_any().downcast_ref::<FeatureContact>().unwrap();
                        for k in 0..c.edges.len() {
                            fs[i] += c.force(k).0;
                        }
                        gap = gap.min(c.min_gap());
                        active += 10000 * c.edges.iter().filter(|e| e.pressure > 0.0).count();
                    }
                    println!(
                        "f {f} F {target:.3} inc {} it {} res {:.1e} travel {:.4} {:.4} mm pos {:.4?} rot {:.4?} sum {:.1e} gap {gap:.1e} active {active} slip {slips}",
                        a.increments,
                        a.iterations,
                        a.residual,
                        (s.travel[0] - travel[0]) * 1e3,
                        (s.travel[1] - travel[1]) * 1e3,
                        (s.position - position) * 1e3,
                        (s.rotation * rotation.inverse()).to_scaled_axis() * 57.3,
                        (fs[0] + fs[1]).length()
                    );
                }
            }
            Err(e) => return Err(format!("frame {f} {e:?} level {}", path.level)),
        }
    }
    let st = bodies[0].stress(&path.state.x[0]);
    if verbose {
        println!("total {total} in {:?} minJ {} {:?}", clock.elapsed(), st.min_det_f, path.newton.profile);
    }
    Ok((total, path.newton.profile))
}

fn pose_of(row: &[f64]) -> (DVec3, DQuat) {
    let q = DQuat::from_xyzw(row[4], row[5], row[6], row[3]).normalize();
    let inv = q.inverse();
    (-(inv * DVec3::new(row[0], row[1], row[2])), inv)
}

#[test]
fn grasps() {
    let name = std::env::var("OBJ").unwrap_or("lemon01".into());
    let dir = format!("../shared/data/objects/dgn/{name}");
    let (mesh, _) =
        tactus::mesh::io::read_tri_mesh(std::path::Path::new(&format!("{dir}/{name}_processed.stl"))).unwrap();
    let shape = Shape::from_mesh(mesh).unwrap();
    let rows: Vec<Vec<f64>> = std::fs::read_to_string(format!("/tmp/{name}.txt"))
        .unwrap()
        .lines()
        .map(|l| l.split_whitespace().map(|v| v.parse().unwrap()).collect())
        .collect();
    let (from, to) = (var("FROM", 0.) as usize, var("TO", 1.) as usize);
    let mu = var("MU", 0.8);
    let free = var("FREE", 1.) > 0.0;
    let mut ok = 0;
    for g in from..to.min(rows.len()) {
        let clock = std::time::Instant::now();
        match squeeze(&shape, pose_of(&rows[g]), free, mu, to - from == 1) {
            Ok((n, p)) => {
                ok += 1;
                println!(
                    "grasp {g} ok its {n} time {:.2?} proj {} fac {:.2} ass {:.2} solve {:.2} ls {:.2}",
                    clock.elapsed(),
                    p.projections,
                    p.factorization,
                    p.assembly,
                    p.solve,
                    p.line_search
                )
            }
            Err(e) => println!("grasp {g} FAIL {e} {:.2?}", clock.elapsed()),
        }
    }
    println!("{name}: {ok} ok");
}
