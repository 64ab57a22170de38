//! Test whether a point is inside a closed triangle surface, by signed crossings of a ray.

use geometry::mesh::TriMesh;
use glam::{DMat3, DVec2, DVec3};

/// Triangle surface in a uniform grid of columns along a generic direction, so that a ray is tested against only a few
/// triangles.
#[derive(Debug)]
pub struct Columns {
    /// Rotation into axes in which rays are parallel to +z; no facet of a generated object is parallel to them.
    turn: DMat3,
    triangles: Vec<[DVec3; 3]>,
    min: DVec2,
    cell: DVec2,
    count: usize,
    /// First entry of each cell in `entries`.
    first: Vec<u32>,
    entries: Vec<u32>,
}

/// Largest number of cells along a side.
const MAX_CELLS: usize = 256;

impl Columns {
    /// Creates the columns of a closed surface with outward orientation.
    pub fn new(mesh: &TriMesh) -> Self {
        let turn = DMat3::from_rotation_x(0.737) * DMat3::from_rotation_y(0.419) * DMat3::from_rotation_z(1.131);
        let triangles: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t).map(|p| turn * p)).collect();
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in triangles.iter().flatten() {
            (min, max) = (min.min(p.truncate()), max.max(p.truncate()));
        }
        let count = ((triangles.len() as f64).sqrt().ceil() as usize).clamp(1, MAX_CELLS);
        let cell = ((max - min) / count as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut columns = Self { turn, triangles, min, cell, count, first: Vec::new(), entries: Vec::new() };
        columns.sort();
        columns
    }

    fn sort(&mut self) {
        let mut cells = vec![Vec::new(); self.count * self.count];
        for (t, corners) in self.triangles.iter().enumerate() {
            let flat = corners.map(DVec3::truncate);
            let low = self.column_of(flat[0].min(flat[1]).min(flat[2]));
            let high = self.column_of(flat[0].max(flat[1]).max(flat[2]));
            for i in low.0..=high.0 {
                for j in low.1..=high.1 {
                    cells[i * self.count + j].push(t as u32);
                }
            }
        }
        self.first.push(0);
        for cell in cells {
            self.entries.extend(cell);
            self.first.push(self.entries.len() as u32);
        }
    }

    fn column_of(&self, p: DVec2) -> (usize, usize) {
        let at = (p - self.min) / self.cell;
        let index = |v: f64| (v.max(0.0) as usize).min(self.count - 1);
        (index(at.x), index(at.y))
    }

    /// Returns true if `q` is inside: the ray from it exits the surface more often than it enters.
    pub fn inside(&self, q: DVec3) -> bool {
        let q = self.turn * q;
        let (i, j) = self.column_of(q.truncate());
        let cell = i * self.count + j;
        let mut winding = 0;
        for &t in &self.entries[self.first[cell] as usize..self.first[cell + 1] as usize] {
            let [a, b, c] = self.triangles[t as usize];
            if !triangle_contains([a, b, c].map(DVec3::truncate), q.truncate()) {
                continue;
            }
            let normal = (b - a).cross(c - a);
            if (a - q).dot(normal) * normal.z > 0.0 {
                winding += if normal.z > 0.0 { 1 } else { -1 };
            }
        }
        winding > 0
    }

    /// Returns the depth of `q` inside, m; zero outside.
    pub fn depth(&self, q: DVec3) -> f64 {
        if self.inside(q) { self.distance(q) } else { 0.0 }
    }

    /// Returns the distance of `q` to the surface, m.
    pub fn distance(&self, q: DVec3) -> f64 {
        super::triangle::distance(&self.triangles, self.turn * q)
    }
}

/// Returns true if a triangle of the plane contains `p`. Edges are half-open and evaluated from their lower end, so
/// that of all triangles at an edge or a corner, only those on one side count: the projections tile the plane without
/// gaps or overlaps.
fn triangle_contains(corners: [DVec2; 3], p: DVec2) -> bool {
    let mut inside = false;
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        if (a.y > p.y) != (b.y > p.y) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            let x = low.x + (p.y - low.y) * (high.x - low.x) / (high.y - low.y);
            inside ^= p.x < x;
        }
    }
    inside
}
