use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;
use tactus::contact::{Contact, ContactSurface, law::Law};
use tactus::element::EDGES;
use tactus::fem::{body::*, newton::*, state::*, term::*};
use tactus::material::*;
use tactus::shape::{Closest, SignedDistance};

#[derive(Debug)]
struct Sphere(f64);
impl SignedDistance for Sphere {
    fn distance(&self, q: DVec3) -> f64 { q.length() - self.0 }
    fn closest(&self, q: DVec3, max: f64) -> Option<Closest> {
        let r = q.length();
        let n = q / r;
        let nn = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        (r - self.0 < max).then_some(Closest { distance: r - self.0, normal: n, curvature: (DMat3::IDENTITY - nn) * (1.0 / r) })
    }
}

pub fn grid(n: [usize; 3], size: [f64; 3]) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let id = |i: usize, j: usize, k: usize| ((k * (n[1] + 1) + j) * (n[0] + 1) + i) as u32;
    let mut nodes = vec![];
    for k in 0..=n[2] { for j in 0..=n[1] { for i in 0..=n[0] {
        let var = |n: &str, d: f64| std::env::var(n).map(|v| v.parse().unwrap()).unwrap_or(d);
        let (beta, gz): (f64, f64) = (var("BETA", 1.0), var("GZ", 1.0));
        let map = |s: f64| { let t = 2.0 * s - 1.0; 0.5 * (beta * t + (1.0 - beta) * t * t * t) };
        let t = 1.0 - k as f64 / n[2] as f64;
        let z = 1.0 - (gz * t + (1.0 - gz) * t * t);
        nodes.push(DVec3::new(map(i as f64 / n[0] as f64) * size[0], map(j as f64 / n[1] as f64) * size[1], z * size[2]));
    }}}
    let mut tets = vec![];
    for k in 0..n[2] { for j in 0..n[1] { for i in 0..n[0] {
        let mx = i >= n[0] / 2; let my = j >= n[1] / 2;
        let c = |a: usize, b: usize, d: usize| {
            let a = if mx { 1 - a } else { a }; let b = if my { 1 - b } else { b };
            id(i + a, j + b, k + d)
        };
        for p in [[0,1,2],[0,2,1],[1,0,2],[1,2,0],[2,0,1],[2,1,0]] {
            let mut v = [0usize; 3];
            let mut t = [c(0,0,0); 4];
            for s in 0..3 { v[p[s]] = 1; t[s + 1] = c(v[0], v[1], v[2]); }
            let x = t.map(|i| nodes[i as usize]);
            if (x[1]-x[0]).cross(x[2]-x[0]).dot(x[3]-x[0]) < 0.0 { t.swap(2, 3); }
            tets.push(t);
        }
    }}}
    (nodes, tets)
}

pub fn promote(nodes: &mut Vec<DVec3>, tets: &[[u32; 4]]) -> Vec<[u32; 10]> {
    let mut map = std::collections::BTreeMap::new();
    tets.iter().map(|t| {
        let mut e = [0u32; 10];
        e[..4].copy_from_slice(t);
        for (k, [i, j]) in EDGES.into_iter().enumerate() {
            let key = (t[i].min(t[j]), t[i].max(t[j]));
            e[4 + k] = *map.entry(key).or_insert_with(|| { nodes.push((nodes[key.0 as usize] + nodes[key.1 as usize]) * 0.5); nodes.len() as u32 - 1 });
        }
        e
    }).collect()
}

fn press(n: [usize; 3], quad: bool, nu: f64, depths: &[f64], kscale: f64, offset: f64, e: f64) {
    let size = [20e-3, 25e-3, 4.5e-3];
    let (mut nodes, tets) = grid(n, size);
    if std::env::var("PAD1K").is_ok() && !quad {
        let read = |f: &str| std::fs::read_to_string(format!("../shared/reference/pad_1k.{f}.txt")).unwrap().lines().skip(1).map(|l| l.split_whitespace().map(|v| v.parse::<f64>().unwrap()).collect::<Vec<_>>()).collect::<Vec<_>>();
        nodes = read("nodes").iter().map(|v| DVec3::new(v[0], v[1], v[2]) * 1e-3).collect();
        let tets = read("tets").iter().map(|v| [v[0] as u32, v[1] as u32, v[2] as u32, v[3] as u32]).collect::<Vec<_>>();
        return press_with(nodes, Elements::Linear(tets), nu, depths, kscale, offset, e);
    }
    let elements = if quad { let q = promote(&mut nodes, &tets); Elements::Quadratic(q) } else { Elements::Linear(tets) };
    press_with(nodes, elements, nu, depths, kscale, offset, e)
}
fn press_with(nodes: Vec<DVec3>, elements: Elements, nu: f64, depths: &[f64], kscale: f64, offset: f64, e: f64) {
    let fixed: Vec<bool> = nodes.iter().map(|x| x.z < 1e-9).collect();
    let count = nodes.len();
    let clock = std::time::Instant::now();
    let body = Arc::new(Body::new(nodes.clone(), elements, fixed, Arc::new(NeoHookean::new(e, nu)), std::env::var("MD0").is_err()).unwrap());
    let surface = Arc::new(ContactSurface::new(&body));
    let k = kscale * e / surface.spacing;
    println!("nodes {count} elements {} free {} L entries {} points {} spacing {:.2e} k {k:.2e} setup {:?}", body.element_count(), body.pattern.free, body.symbolic.entries(), surface.points.len(), surface.spacing, clock.elapsed());
    let law = Law { stiffness: k, offset, friction: 0.0, tangential: k };
    let contact = Contact::new(law, surface, Arc::new(Sphere(6e-3)));
    let terms: Vec<Vec<Box<dyn BodyTerm>>> = vec![vec![Box::new(Elastic), Box::new(contact)]];
    let border = Border::new(vec![DVec3::Z], false, false, 6e-3);
    let mut newton = Newton::new(vec![body.clone()], terms, border);
    let mut state = State { x: vec![nodes], travel: vec![0.0], position: DVec3::new(0.0, 0.0, 10.5e-3 + offset), rotation: DQuat::IDENTITY };
    let tol = Tolerance { force: 1e-6, length: 1e-6, iterations: 100, motion: 1e-3 };
    let mut total = 0;
    for &d in depths {
        let clock = std::time::Instant::now();
        let delta = d - state.travel[0];
        let mut next = state.clone();
        next.travel[0] += delta;
        match newton.solve(&mut next, &tol) {
            Ok(c) => {
                newton.commit(&next);
                state = next;
                let contact = newton.terms[0][1].as_any().downcast_ref::<Contact>().unwrap();
                let f = (0..contact.edges.len()).fold(DVec3::ZERO, |s, i| s + contact.force(i));
                let active = contact.edges.iter().filter(|e| e.pressure > 0.0).count();
                let stress = body.stress(&state.x[0]);
                println!("depth {:.3} mm F {:.5} N  it {} res {:.1e} gap {:.2e} active {active} vm {:.4} J {:.3} {:?}", d * 1e3, -f.z, c.iterations, c.residual, contact.min_gap(), stress.node.iter().cloned().fold(0.0, f64::max) * 1e-6, stress.min_det_f, clock.elapsed());
                total += c.iterations;
            }
            Err(e) => { println!("depth {d} failed {e:?}"); newton.rollback(); return; }
        }
    }
    println!("total {total} {:?}", newton.profile);
}

#[test]
fn press_sphere() {
    let depths = [0.25e-3, 0.5e-3, 1.0e-3];
    let e = 0.3e6;
    let ks: f64 = std::env::var("KS").map(|v| v.parse().unwrap()).unwrap_or(50.0);
    if std::env::var("PAD1K").is_ok() { press([12, 16, 4], false, 0.45, &depths, ks, 1e-6, e); return; }
    let off: f64 = std::env::var("OFF").map(|v| v.parse().unwrap()).unwrap_or(1e-5);
    let nu: f64 = std::env::var("NU").map(|v| v.parse().unwrap()).unwrap_or(0.45);
    if let Ok(g) = std::env::var("GRID") { let g: Vec<usize> = g.split(',').map(|v| v.parse().unwrap()).collect(); press([g[0], g[1], g[2]], true, nu, &depths, ks, off, e); return; }
    press([8, 10, 2], true, 0.45, &depths, ks, 1e-6, e);
    press([12, 14, 3], true, 0.45, &depths, ks, 1e-6, e);
    if std::env::var("FINE").is_ok() { press([18, 22, 4], true, 0.45, &depths, ks, 1e-6, e); }
}
