//! Fields of different meshes at common points: shape functions interpolate nodal values.

use crate::element::{EDGES, RestTet, TET10};
use crate::mesh::TetMesh;
use crate::record::{Frame, PadTopology};
use glam::DVec3;

/// Points of a pad at rest, pad frame, each standing for a part of the volume.
#[derive(Debug, Clone)]
pub struct Points {
    /// m.
    pub position: Vec<DVec3>,
    /// m3.
    pub volume: Vec<f64>,
}

impl Points {
    /// Four points in each tetrahedron (Keast 1986): sums over them are integrals, exact for quadratic fields.
    pub fn of(mesh: &TetMesh) -> Self {
        let mut points = Self { position: Vec::new(), volume: Vec::new() };
        for t in 0..mesh.tets.len() {
            let corners = mesh.corners(t);
            let part = RestTet::new(corners).volume / TET10.points.len() as f64;
            for weights in TET10.points {
                points.position.push((0..4).map(|k| corners[k] * weights[k]).sum());
                points.volume.push(part);
            }
        }
        points
    }
}

/// What a frame says at the points of all pads, one pad after the other.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    /// m, hand axes, relative to the pad carried by its finger.
    pub displacement: Vec<DVec3>,
    /// Von Mises, Pa.
    pub stress: Vec<f64>,
    /// Contact force on each pad, N, hand axes.
    pub force: Vec<DVec3>,
    /// Travel of each finger since first contact, m.
    pub travel: Vec<f64>,
}

/// Where the points lie in a mesh.
#[derive(Debug)]
pub struct Probe {
    /// Per point: nodes and their shape functions.
    stencils: Vec<Vec<(u32, f64)>>,
}

impl Probe {
    /// Looks for the points in the pad's elements. A point just outside (the rim of a coarser mesh) takes the values of the
    /// nearest place in its best element.
    pub fn new(points: &Points, pad: &PadTopology) -> Self {
        let width = pad.elements.width();
        let tets: Vec<(&[u32], [DVec3; 2], RestTet)> = pad
            .elements
            .nodes()
            .chunks_exact(width)
            .map(|nodes| {
                let x = [0, 1, 2, 3].map(|k| pad.rest[nodes[k] as usize]);
                let bounds = [x.into_iter().reduce(DVec3::min), x.into_iter().reduce(DVec3::max)];
                (nodes, bounds.map(Option::unwrap_or_default), RestTet::new(x))
            })
            .collect();
        let stencil = |p: &DVec3| {
            let mut best = (f64::NEG_INFINITY, [0.25; 4], &[][..]);
            for near in [true, false] {
                for (nodes, [low, high], rest) in &tets {
                    let margin = DVec3::splat(1e-9);
                    if near && (p.cmplt(*low - margin).any() || p.cmpgt(*high + margin).any()) {
                        continue;
                    }
                    let weights = barycentric(rest, pad.rest[nodes[0] as usize], *p);
                    let inside = weights.into_iter().fold(f64::INFINITY, f64::min);
                    if inside > best.0 {
                        best = (inside, weights, *nodes);
                    }
                }
                if best.0 > f64::NEG_INFINITY {
                    break;
                }
            }
            shape_functions(best.1, best.2)
        };
        Self { stencils: points.position.iter().map(stencil).collect() }
    }

    /// The fields of a frame; nodal values must be recorded.
    pub fn fields(&self, frame: &Frame) -> Fields {
        let mut fields = Fields { travel: frame.travel.clone(), ..Fields::default() };
        for pad in &frame.pads {
            for stencil in &self.stencils {
                fields.displacement.push(stencil.iter().map(|(n, w)| pad.displacement[*n as usize] * *w).sum());
                fields.stress.push(stencil.iter().map(|(n, w)| pad.von_mises_node[*n as usize] * w).sum());
            }
            fields.force.push(pad.wrench.force);
        }
        fields
    }
}

fn barycentric(rest: &RestTet, first: DVec3, p: DVec3) -> [f64; 4] {
    let [a, b, c, d] = rest.gradient.map(|g| g.dot(p - first));
    [1.0 + a, b, c, d]
}

/// Nodes with the values of their shape functions at barycentric coordinates `l`, drawn into the element if outside.
fn shape_functions(l: [f64; 4], nodes: &[u32]) -> Vec<(u32, f64)> {
    let l = l.map(|v| v.max(0.0));
    let sum: f64 = l.iter().sum();
    let l = l.map(|v| v / sum);
    let value = |a: usize| match (nodes.len(), a) {
        (10, 0..4) => l[a] * (2.0 * l[a] - 1.0),
        (10, _) => {
            let [i, j] = EDGES[a - 4];
            4.0 * l[i] * l[j]
        }
        _ => l[a],
    };
    nodes.iter().enumerate().map(|(a, n)| (*n, value(a))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{grid, quadratic};
    use crate::record::{Elements, PadFrame};

    #[test]
    fn quadratic_fields_are_reproduced_and_volumes_add_up() {
        let line = |n: usize| (0..=n).map(|i| i as f64 / n as f64).collect::<Vec<_>>();
        let coarse = grid::structured([&line(2), &line(2), &line(1)]).unwrap();
        let fine = quadratic::promote(&grid::structured([&line(3), &line(5), &line(4)]).unwrap());
        let points = Points::of(&coarse);
        assert!((points.volume.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let field = |x: DVec3| 1.0 + x.x * x.y - 0.5 * x.z * x.z + 2.0 * x.y;
        let frame = Frame {
            pads: vec![PadFrame {
                displacement: fine.nodes.iter().map(|x| DVec3::new(field(*x), x.y, 0.0)).collect(),
                von_mises_node: fine.nodes.iter().map(|x| field(*x)).collect(),
                ..PadFrame::default()
            }],
            ..Frame::default()
        };
        let pad = PadTopology { rest: fine.nodes, elements: Elements::Quadratic(fine.tets), ..PadTopology::default() };
        let fields = Probe::new(&points, &pad).fields(&frame);
        for (k, x) in points.position.iter().enumerate() {
            assert!((fields.stress[k] - field(*x)).abs() < 1e-12);
            assert!((fields.displacement[k] - DVec3::new(field(*x), x.y, 0.0)).length() < 1e-12);
        }
        let outside = Points { position: vec![DVec3::new(1.1, 0.5, 0.5)], volume: vec![1.0] };
        let at_the_rim = Probe::new(&outside, &pad).fields(&frame).displacement[0];
        assert!((at_the_rim.y - 0.5).abs() < 0.2, "a point outside takes the nearest values: {at_the_rim}");
    }
}
