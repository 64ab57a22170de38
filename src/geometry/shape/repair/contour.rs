//! Surface between the inside and the outside nodes of a grid, by dual contouring (Ju et al. 2002) with a vertex for
//! each sheet of the surface in a cell (Nielson 2004, "Dual marching cubes"): closed, and a manifold.

use super::field::OccupancyGrid;
use crate::Aabb;
use crate::mesh::TriMesh;
use crate::shape::facet::Facet;
use crate::shape::outer;
use crate::shape::winding::Winding;
use glam::{DMat3, DVec3, USizeVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Weight of the mean crossing of a sheet relative to the tangent planes of the surface: a regularisation where the
/// planes do not determine a vertex.
const REGULARISATION: f64 = 1e-3;
/// Smallest distance of a vertex from the sides of its cell, over the size of the cell.
const MARGIN: f64 = 0.02;

/// Crossing of an edge of the grid with the surface, m, and the normal there.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    point: DVec3,
    normal: DVec3,
}

/// Returns the surface; with sharp corners and edges if `sharp`, otherwise with each vertex at the mean of its
/// crossings.
pub(crate) fn surface(field: &OccupancyGrid, winding: &Winding, sharp: bool) -> TriMesh {
    let crossings = crossings(field, winding);
    let mut mesh = TriMesh::default();
    let mut vertices: HashMap<USizeVec3, [u32; 12]> = HashMap::new();
    for cell in field.cells() {
        let corners: Vec<bool> = (0..8).map(|i| field.inside(cell + corner(i))).collect();
        if corners.iter().all(|c| *c == corners[0]) {
            continue;
        }
        let mut vertex = [u32::MAX; 12];
        for sheet in sheets(&corners) {
            let met: Vec<Crossing> = sheet.iter().map(|e| crossings[&(cell + edge_start(*e), e / 4)]).collect();
            sheet.iter().for_each(|e| vertex[*e] = mesh.vertices.len() as u32);
            mesh.vertices.push(sheet_vertex(field, cell, &met, sharp));
        }
        vertices.insert(cell, vertex);
    }
    for cell in field.cells() {
        for k in 0..3 {
            let inside = field.inside(cell);
            if inside == field.inside(cell + USizeVec3::AXES[k]) {
                continue;
            }
            // The four cells around the edge, counter-clockwise seen from its end; all exist, because nodes at the
            // border of the grid are outside.
            let (u, v) = (USizeVec3::AXES[(k + 1) % 3], USizeVec3::AXES[(k + 2) % 3]);
            let around = [(cell - u - v, 3), (cell - v, 2), (cell, 0), (cell - u, 1)];
            let mut quad = around.map(|(c, edge)| vertices[&c][4 * k + edge]);
            if !inside {
                quad.reverse();
            }
            let p = quad.map(|v| mesh.vertices[v as usize]);
            let [a, b, c, d] = quad;
            let pair = if p[0].distance(p[2]) <= p[1].distance(p[3]) {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            mesh.triangles.extend(pair);
        }
    }
    mesh
}

/// Returns corner `i` of a cell.
fn corner(i: usize) -> USizeVec3 {
    USizeVec3::new(i & 1, i >> 1 & 1, i >> 2 & 1)
}

/// Returns the corner from which edge `4 k + i` of a cell runs along axis `k`.
fn edge_start(edge: usize) -> USizeVec3 {
    let (k, i) = (edge / 4, edge % 4);
    USizeVec3::AXES[(k + 1) % 3] * (i & 1) + USizeVec3::AXES[(k + 2) % 3] * (i >> 1)
}

/// Returns the crossed edges of a cell, grouped by the sheet of the surface that connects them across the faces of the
/// cell. Each face has two crossed edges or none.
fn sheets(inside: &[bool]) -> Vec<Vec<usize>> {
    let at = |n: USizeVec3| inside[n.x | n.y << 1 | n.z << 2];
    let crossed: Vec<usize> =
        (0..12).filter(|e| at(edge_start(*e)) != at(edge_start(*e) + USizeVec3::AXES[e / 4])).collect();
    let mut group: Vec<usize> = (0..12).collect();
    for axis in 0..3 {
        for side in 0..2 {
            // The edges of this face run along the other axes.
            let on = |e: &usize| e / 4 != axis && edge_start(*e)[axis] == side;
            let face: Vec<usize> = crossed.iter().copied().filter(on).collect();
            if let [a, b] = face[..] {
                let (from, to) = (group[a].max(group[b]), group[a].min(group[b]));
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    let mut sheets: Vec<Vec<usize>> = vec![Vec::new(); 12];
    crossed.into_iter().for_each(|e| sheets[group[e]].push(e));
    sheets.into_iter().filter(|s| !s.is_empty()).collect()
}

/// Returns the vertex of a sheet, m: the least-squares point of the tangent planes at its crossings, clamped to the
/// cell.
fn sheet_vertex(field: &OccupancyGrid, cell: USizeVec3, met: &[Crossing], sharp: bool) -> DVec3 {
    let middle = met.iter().map(|c| c.point).sum::<DVec3>() / met.len() as f64;
    if !sharp {
        return middle;
    }
    let (mut a, mut b) = (REGULARISATION * DMat3::IDENTITY, DVec3::ZERO);
    for c in met {
        a += outer(c.normal);
        b += c.normal * c.normal.dot(c.point - middle);
    }
    let low = field.position(cell) + MARGIN * field.step;
    (middle + a.inverse() * b).clamp(low, low + (1.0 - 2.0 * MARGIN) * field.step)
}

/// Returns the crossings of the surface with the edges of the grid, by the node from which an edge runs and its axis.
fn crossings(field: &OccupancyGrid, winding: &Winding) -> HashMap<(USizeVec3, usize), Crossing> {
    let edges = field.cells().flat_map(|n| (0..3).map(move |k| (n, k)));
    let crossed: Vec<_> = edges.filter(|(n, k)| field.inside(*n) != field.inside(*n + USizeVec3::AXES[*k])).collect();
    let found = |&(node, k): &(USizeVec3, usize)| {
        let ends = [node, node + USizeVec3::AXES[k]].map(|n| field.position(n));
        let [a, b] = if field.inside(node) { ends } else { [ends[1], ends[0]] };
        ((node, k), crossing(winding, a, b, field.step))
    };
    crossed.par_iter().map(found).collect::<Vec<_>>().into_iter().collect()
}

/// Returns the crossing on the segment from `a` (inside) to `b` (outside): the point where it leaves the inside through
/// a triangle, or else the point where the winding number becomes one half.
fn crossing(winding: &Winding, a: DVec3, b: DVec3, step: f64) -> Crossing {
    let mut passed: Vec<(f64, DVec3)> = Vec::new();
    winding.bvh.overlapping(&Aabb::from_points([a, b]), |i| {
        let facet = &winding.bvh.facets[i as usize];
        passed.extend(segment_crossing(facet, a, b).map(|t| (t, facet.n)));
    });
    passed.sort_by(|x, y| x.0.total_cmp(&y.0));
    let within = |t: f64| winding.at(a.lerp(b, t)) > 0.5;
    let leaves = |i: &usize| {
        let (before, after) = (i.checked_sub(1).map_or(0.0, |j| passed[j].0), passed.get(i + 1).map_or(1.0, |p| p.0));
        passed.len() == 1 || (within(0.5 * (before + passed[*i].0)) && !within(0.5 * (after + passed[*i].0)))
    };
    if let Some(i) = (0..passed.len()).find(leaves) {
        return Crossing { point: a.lerp(b, passed[i].0), normal: passed[i].1 };
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..16 {
        let t = 0.5 * (low + high);
        *(if within(t) { &mut low } else { &mut high }) = t;
    }
    let point = a.lerp(b, 0.5 * (low + high));
    let slope = DVec3::AXES.map(|e| winding.at(point - 0.5 * step * e) - winding.at(point + 0.5 * step * e));
    Crossing { point, normal: DVec3::from_array(slope).normalize_or((b - a).normalize()) }
}

/// Returns the parameter in 0..=1 at which the segment from `a` to `b` crosses the facet.
fn segment_crossing(facet: &Facet, a: DVec3, b: DVec3) -> Option<f64> {
    let [from, to] = [a, b].map(|p| facet.n.dot(p - facet.origin));
    let t = from / (from - to);
    let met = from * to <= 0.0 && t.is_finite() && facet.edge_distance(a.lerp(b, t)) >= -1e-9 * a.distance(b);
    met.then_some(t)
}
