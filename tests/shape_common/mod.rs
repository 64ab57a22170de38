//! What the shape tests share: real meshes, random points, and slow independent answers to compare with.
#![allow(dead_code)]

use glam::DVec3;
use std::collections::HashMap;
use std::path::PathBuf;
use tactus::mesh::TriMesh;
use tactus::shape::{Shape, ShapeKind, SignedDistance};

/// Every STL of a real object with its name; none (and a notice) where the shared data is absent.
pub fn real_meshes() -> Vec<(String, TriMesh)> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/objects/dgn"));
    let Ok(folders) = std::fs::read_dir(&root) else {
        eprintln!("skipped: the checks on real objects, for {} is absent", root.display());
        return Vec::new();
    };
    let mut names: Vec<String> = folders.flatten().filter_map(|f| f.file_name().into_string().ok()).collect();
    names.sort();
    let file = |n: &String| root.join(n).join(format!("{n}_processed.stl"));
    names.into_iter().filter(|n| file(n).exists()).map(|n| (n.clone(), read(&file(&n)))).collect()
}

fn read(path: &PathBuf) -> TriMesh {
    let stl = stl_io::read_stl(&mut std::fs::File::open(path).unwrap()).unwrap();
    let mut known = HashMap::new();
    let mut mesh = TriMesh::default();
    for face in &stl.faces {
        mesh.triangles.push(face.vertices.map(|v| {
            let p: [f32; 3] = stl.vertices[v].into();
            let bits = p.map(|x| (x + 0.0).to_bits());
            *known.entry(bits).or_insert_with(|| {
                mesh.vertices.push(DVec3::from_array(p.map(f64::from)));
                mesh.vertices.len() as u32 - 1
            })
        }));
    }
    mesh
}

/// One object of every family, about as large as a fruit.
pub fn families(segments: u32) -> Vec<Shape> {
    use glam::DVec2;
    let profile = [(0.0, -0.02), (0.015, -0.02), (0.025, 0.0), (0.01, 0.005), (0.012, 0.02), (0.0, 0.03)];
    let helix = |i: u32| {
        let a = 0.1 * f64::from(i);
        DVec3::new(0.03 * a.cos(), 0.03 * a.sin(), 0.004 * a)
    };
    [
        ShapeKind::Sphere { radius: 0.02 },
        ShapeKind::Ellipsoid { semi_axes: DVec3::new(0.03, 0.02, 0.012) },
        ShapeKind::Cuboid { size: DVec3::new(0.04, 0.03, 0.05), edge_radius: 0.0 },
        ShapeKind::Cuboid { size: DVec3::new(0.04, 0.03, 0.05), edge_radius: 0.006 },
        ShapeKind::Cylinder { radius: 0.02, height: 0.05 },
        ShapeKind::Capsule { radius: 0.015, length: 0.06 },
        ShapeKind::Prism { sides: 6, radius: 0.02, height: 0.05 },
        ShapeKind::Annulus { outer_radius: 0.03, inner_radius: 0.02, height: 0.02 },
        ShapeKind::Cup { radius: 0.03, height: 0.06, wall: 0.003 },
        ShapeKind::Lemon { length: 0.08, diameter: 0.055 },
        ShapeKind::Strawberry { length: 0.04, diameter: 0.035 },
        ShapeKind::Pear { length: 0.09, diameter: 0.06 },
        ShapeKind::Banana { length: 0.15, diameter: 0.035, bend: 1.2 },
        ShapeKind::Potato { semi_axes: DVec3::new(0.04, 0.03, 0.025), roughness: 0.08, seed: 3 },
        ShapeKind::Revolve { profile: profile.map(DVec2::from).to_vec(), closed: false },
        ShapeKind::Sweep { path: (0..30).map(helix).collect(), radii: vec![0.008; 30] },
    ]
    .iter()
    .map(|k| k.build(segments).unwrap())
    .collect()
}

/// Reproducible numbers in 0..1 (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn vector(&mut self) -> DVec3 {
        2.0 * DVec3::new(self.unit(), self.unit(), self.unit()) - 1.0
    }

    /// A point in the box of the mesh, grown by half its size.
    pub fn around(&mut self, mesh: &TriMesh) -> DVec3 {
        let (low, high) = bounds(mesh);
        0.5 * (low + high) + self.vector() * (high - low)
    }

    /// A point at most `reach` from a random place of a triangle: a corner, an edge or its inside.
    pub fn near_surface(&mut self, mesh: &TriMesh, reach: f64) -> DVec3 {
        let t = mesh.triangles[(self.unit() * mesh.triangles.len() as f64) as usize];
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        let (mut u, mut v) = (self.unit(), self.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        match (self.unit() * 3.0) as u32 {
            0 => (u, v) = (0.0, 0.0),
            1 => v = 0.0,
            _ => {}
        }
        a + u * (b - a) + v * (c - a) + reach * self.vector()
    }
}

pub fn bounds(mesh: &TriMesh) -> (DVec3, DVec3) {
    let all = mesh.vertices.iter();
    all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |b, &p| (b.0.min(p), b.1.max(p)))
}

/// Distance to the nearest triangle, by projection on its plane and on its three sides; no tree.
pub fn brute_force(mesh: &TriMesh, q: DVec3) -> f64 {
    let mut best = f64::INFINITY;
    for t in &mesh.triangles {
        let p = t.map(|v| mesh.vertices[v as usize]);
        let n = (p[1] - p[0]).cross(p[2] - p[0]);
        if (0..3).all(|i| (p[(i + 1) % 3] - p[i]).cross(q - p[i]).dot(n) >= 0.0) {
            best = best.min((q - p[0]).dot(n).abs() / n.length());
        }
        for i in 0..3 {
            let e = p[(i + 1) % 3] - p[i];
            let s = ((q - p[i]).dot(e) / e.length_squared()).clamp(0.0, 1.0);
            best = best.min((p[i] + s * e).distance(q));
        }
    }
    best
}

/// How often the mesh winds around `q` (van Oosterom and Strackee 1983): 1 inside, 0 outside.
pub fn winding(mesh: &TriMesh, q: DVec3) -> f64 {
    let solid_angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize] - q);
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    mesh.triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Largest difference of the gradient from central differences of the distance, step `h`.
pub fn gradient_error(d: &dyn SignedDistance, q: DVec3, h: f64) -> f64 {
    let n = d.closest(q, f64::INFINITY).unwrap().normal;
    let slope = |a: DVec3| (d.distance(q + h * a) - d.distance(q - h * a)) / (2.0 * h);
    (n - DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))).abs().max_element()
}
