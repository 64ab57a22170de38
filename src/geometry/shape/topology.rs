//! Edges of a closed triangle mesh and its pseudo-normals.

use crate::mesh::topology::{check_edges, half_edges};
use crate::mesh::{MAX_COORDINATE, TriMesh, format_point, is_out_of_range};
use base::error::{Error, Result};
use glam::DVec3;

/// Edge between two triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Edge {
    /// End vertices; the left triangle traverses the edge from `ends[0]` to `ends[1]`.
    pub ends: [u32; 2],
    /// Indices of the left and the right triangle.
    pub triangles: [u32; 2],
}

/// Adjacency and normals of a closed, oriented mesh.
#[derive(Debug, Clone)]
pub(crate) struct Topology {
    pub edges: Vec<Edge>,
    /// Edges of each triangle; edge `i` runs from its corner `i` to its corner `i + 1`.
    pub triangle_edges: Vec<[u32; 3]>,
    /// Unit outward normal of each triangle.
    pub normals: Vec<DVec3>,
    /// Unit pseudo-normal of each edge: the mean of its two triangles' normals.
    pub edge_normals: Vec<DVec3>,
    /// Unit angle-weighted pseudo-normal of each vertex (Baerentzen and Aanaes 2005, "Signed distance computation using
    /// the angle weighted pseudonormal", eq. 1). Zero for a vertex that no triangle uses.
    pub vertex_normals: Vec<DVec3>,
}

impl Topology {
    /// Builds the adjacency and the normals of a mesh.
    ///
    /// # Errors
    /// Fails if the mesh does not bound a solid, with the location of the first fault.
    pub fn new(mesh: &TriMesh) -> Result<Self> {
        check_indices(mesh)?;
        let normals = (0..mesh.triangles.len()).map(|t| normal(mesh, t)).collect::<Result<Vec<_>>>()?;
        let (edges, triangle_edges) = pair_edges(mesh)?;
        let edge_normals = edges
            .iter()
            .map(|e| {
                let [a, b] = e.triangles.map(|t| normals[t as usize]);
                (a + b).try_normalize().unwrap_or(a)
            })
            .collect();
        let mut vertex_normals = vec![DVec3::ZERO; mesh.vertices.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let p = corners.map(|v| mesh.vertices[v as usize]);
            for i in 0..3 {
                let (a, b) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
                let angle = a.cross(b).length().atan2(a.dot(b));
                vertex_normals[corners[i] as usize] += angle * normals[t];
            }
        }
        vertex_normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        Ok(Self { edges, triangle_edges, normals, edge_normals, vertex_normals })
    }
}

fn check_indices(mesh: &TriMesh) -> Result<()> {
    if mesh.triangles.is_empty() {
        return Err(Error::Mesh("the object's mesh has no triangles; it must be a closed surface".into()));
    }
    if mesh.triangles.len() > (1 << 24) {
        let message = format!(
            "the object's mesh has {} triangles; at most 16777216 are handled: simplify it",
            mesh.triangles.len()
        );
        return Err(Error::Mesh(message));
    }
    if let Some(v) = mesh.vertices.iter().position(|p| is_out_of_range(*p)) {
        let p = mesh.vertices[v];
        let message = format!(
            "vertex {v} of the object's mesh is at {p}; coordinates must be finite and within {MAX_COORDINATE:e}"
        );
        return Err(Error::Mesh(message));
    }
    for (t, corners) in mesh.triangles.iter().enumerate() {
        if let Some(v) = corners.iter().find(|&&v| v as usize >= mesh.vertices.len()) {
            let message = format!(
                "triangle {t} of the object's mesh uses vertex {v}, but there are only {}",
                mesh.vertices.len()
            );
            return Err(Error::Mesh(message));
        }
    }
    Ok(())
}

fn normal(mesh: &TriMesh, t: usize) -> Result<DVec3> {
    let p = mesh.triangles[t].map(|v| mesh.vertices[v as usize]);
    match crate::shape::facet::Facet::new(p, 0) {
        Some(f) => Ok(f.n),
        None => Err(Error::Mesh(format!(
            "triangle {t} of the object's mesh, near {}, has no area; remove it or weld its vertices",
            format_point(p[0])
        ))),
    }
}

fn pair_edges(mesh: &TriMesh) -> Result<(Vec<Edge>, Vec<[u32; 3]>)> {
    let sides = half_edges(mesh);
    let mut edges = Vec::with_capacity(sides.len() / 2);
    let mut triangle_edges = vec![[0; 3]; mesh.triangles.len()];
    for group in sides.chunk_by(|x, y| x.ends == y.ends) {
        match group {
            [left, right] if left.reversed != right.reversed => {
                for side in group {
                    triangle_edges[side.triangle as usize][usize::from(side.corner)] = edges.len() as u32;
                }
                edges.push(Edge { ends: left.ends, triangles: [left.triangle, right.triangle] });
            }
            _ => return Err(Error::Mesh(check_edges(mesh).defect_message().unwrap_or_default())),
        }
    }
    Ok((edges, triangle_edges))
}
