//! Fields of different meshes at common points: shape functions interpolate nodal values.

use crate::{Frame, PadTopology};
use glam::{DVec2, DVec3, Vec3Swizzles};
use mech::element::{EDGES, RestTet, TET10, tet10_values};
use std::iter::Sum;
use std::ops::Mul;

/// Quadrature points of an undeformed pad, pad frame, each representing a part of the volume.
#[derive(Debug, Clone)]
pub struct Points {
    /// Positions, m.
    pub position: Vec<DVec3>,
    /// Volumes, m3.
    pub volume: Vec<f64>,
}

impl Points {
    /// Places four quadrature points in each tetrahedron (Keast 1986): sums weighted by the volumes are integrals,
    /// exact for quadratic fields.
    pub fn of(pad: &PadTopology) -> Self {
        let mut points = Self { position: Vec::new(), volume: Vec::new() };
        for nodes in pad.elements.nodes().chunks_exact(pad.elements.width()) {
            let corners = [0, 1, 2, 3].map(|k| pad.rest[nodes[k] as usize]);
            let part = RestTet::new(corners).volume / TET10.points.len() as f64;
            for weights in TET10.points {
                points.position.push((0..4).map(|k| corners[k] * weights[k]).sum());
                points.volume.push(part);
            }
        }
        points
    }
}

/// Fields of a frame at the points of all pads, one pad after the other.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    /// Displacement, m, hand axes, relative to the pad carried by its finger.
    pub displacement: Vec<DVec3>,
    /// Von Mises stress, Pa; empty if not recorded.
    pub stress: Vec<f64>,
    /// Contact force on each pad, N, hand axes.
    pub force: Vec<DVec3>,
    /// Travel of each finger since first contact, m.
    pub travel: Vec<f64>,
}

/// Interpolation of nodal values at some points: nodes of a mesh with the values of their shape functions.
#[derive(Debug)]
pub struct Stencils(Vec<Vec<(u32, f64)>>);

impl Stencils {
    /// Locates `points` in the elements of a pad. A point slightly outside (at the rim of a coarser mesh) gets the
    /// values of the nearest point of the element that it is least outside of.
    pub fn new(points: &[DVec3], pad: &PadTopology) -> Self {
        let tets = Tets::of(pad);
        Self(points.iter().map(|p| tets.stencil(*p)).collect())
    }

    /// Returns the map from nodal values to an estimate of the error of their interpolation: quadratic minus linear
    /// interpolation on elements of half the size, which have the same nodes. It is zero at the nodes, and on elements
    /// without nodes on their edges, where no field of higher order is known.
    pub fn error_estimate(&self) -> Self {
        let row = |stencil: &Vec<(u32, f64)>| {
            let Ok(quadratic) = <[f64; 10]>::try_from(stencil.iter().map(|(_, w)| *w).collect::<Vec<_>>()) else {
                return Vec::new();
            };
            let linear = linear_on_halves(quadratic);
            stencil.iter().zip(linear).map(|((node, w), linear)| (*node, w - linear)).collect()
        };
        Self(self.0.iter().map(row).collect())
    }

    /// Returns the nodes and the values of their shape functions, for each point.
    pub fn rows(&self) -> &[Vec<(u32, f64)>] {
        &self.0
    }

    /// Returns the values at the points of a field with `nodal` values.
    pub fn of<T: Copy + Mul<f64, Output = T> + Sum>(&self, nodal: &[T]) -> Vec<T> {
        self.0.iter().map(|stencil| stencil.iter().map(|(n, w)| nodal[*n as usize] * *w).sum()).collect()
    }
}

/// Interpolation of the fields of a frame at points.
#[derive(Debug)]
pub struct FieldInterpolation(Stencils);

impl FieldInterpolation {
    /// Locates the points in the elements of a pad.
    pub fn new(points: &Points, pad: &PadTopology) -> Self {
        Self(Stencils::new(&points.position, pad))
    }

    /// Returns the fields of a frame, with nodal stress if it is recorded.
    pub fn fields(&self, frame: &Frame) -> Fields {
        let mut fields = Fields { travel: frame.travel.clone(), ..Fields::default() };
        for pad in &frame.pads {
            fields.displacement.extend(self.0.of(&pad.displacement));
            if !pad.von_mises_node.is_empty() {
                fields.stress.extend(self.0.of(&pad.von_mises_node));
            }
            fields.force.push(pad.wrench.force);
        }
        fields
    }
}

/// Element with its nodes, first corner, bounding box and gradients of the shape functions.
struct Tet<'a> {
    nodes: &'a [u32],
    first: DVec3,
    bounds: [DVec3; 2],
    rest: RestTet,
}

/// Elements of a pad in a grid of columns over x and y, each with the elements that overlap it.
struct Tets<'a> {
    all: Vec<Tet<'a>>,
    /// Lower corner and width of the columns, along x and y, m.
    grid: [DVec2; 2],
    columns: Vec<Vec<u32>>,
}

/// Number of columns along x and along y.
const COLUMNS: usize = 32;
/// Distance outside the bounding box of an element up to which a point may count as inside, m.
const MARGIN: f64 = 1e-9;

impl<'a> Tets<'a> {
    fn of(pad: &'a PadTopology) -> Self {
        let tet = |nodes: &'a [u32]| {
            let x = [0, 1, 2, 3].map(|k| pad.rest[nodes[k] as usize]);
            let bounds = [x.into_iter().reduce(DVec3::min), x.into_iter().reduce(DVec3::max)];
            Tet { nodes, first: x[0], bounds: bounds.map(Option::unwrap_or_default), rest: RestTet::new(x) }
        };
        let all: Vec<Tet> = pad.elements.nodes().chunks_exact(pad.elements.width()).map(tet).collect();
        let low = all.iter().map(|t| t.bounds[0].xy()).fold(DVec2::INFINITY, DVec2::min);
        let high = all.iter().map(|t| t.bounds[1].xy()).fold(DVec2::NEG_INFINITY, DVec2::max);
        let width = ((high - low) / COLUMNS as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut tets = Self { all, grid: [low, width], columns: vec![Vec::new(); COLUMNS * COLUMNS] };
        for (index, tet) in tets.all.iter().enumerate() {
            let [from, to] = [tet.bounds[0] - MARGIN, tet.bounds[1] + MARGIN].map(|x| tets.column(x));
            for y in from[1]..=to[1] {
                (from[0]..=to[0]).for_each(|x| tets.columns[y * COLUMNS + x].push(index as u32));
            }
        }
        tets
    }

    fn column(&self, x: DVec3) -> [usize; 2] {
        let at = (x.xy() - self.grid[0]) / self.grid[1];
        [at.x, at.y].map(|c| (c.max(0.0) as usize).min(COLUMNS - 1))
    }

    /// Returns nodes and values of their shape functions for a point.
    fn stencil(&self, p: DVec3) -> Vec<(u32, f64)> {
        let [x, y] = self.column(p);
        let near = self.columns[y * COLUMNS + x].iter().map(|t| &self.all[*t as usize]).filter(|t| {
            let [low, high] = t.bounds;
            p.cmpge(low - MARGIN).all() && p.cmple(high + MARGIN).all()
        });
        let best = best(near, p).or_else(|| best(self.all.iter(), p));
        best.map_or_else(Vec::new, |(weights, nodes)| shape_functions(weights, nodes))
    }
}

/// Returns the barycentric coordinates of `p` in the tetrahedron for which the smallest of them is largest, and its
/// nodes.
fn best<'a>(tets: impl Iterator<Item = &'a Tet<'a>>, p: DVec3) -> Option<([f64; 4], &'a [u32])> {
    let mut best = (f64::NEG_INFINITY, None);
    for tet in tets {
        let [a, b, c, d] = tet.rest.gradient.map(|g| g.dot(p - tet.first));
        let weights = [1.0 + a, b, c, d];
        let inside = weights.into_iter().fold(f64::INFINITY, f64::min);
        if inside > best.0 {
            best = (inside, Some((weights, tet.nodes)));
        }
    }
    best.1
}

/// Returns nodes with the values of their shape functions at barycentric coordinates `l`, which are moved into the
/// element if they are outside.
fn shape_functions(l: [f64; 4], nodes: &[u32]) -> Vec<(u32, f64)> {
    let l = l.map(|v| v.max(0.0));
    let sum: f64 = l.iter().sum();
    let l = l.map(|v| v / sum);
    let quadratic = tet10_values(l);
    let values: &[f64] = if nodes.len() == quadratic.len() { &quadratic } else { &l };
    nodes.iter().copied().zip(values.iter().copied()).collect()
}

/// Returns the weights of linear interpolation on the eight halves of a tetrahedron, from the values of its quadratic
/// shape functions: four corners and, around the line from the middle of edge 0-1 to that of 2-3, four inner parts.
fn linear_on_halves(quadratic: [f64; 10]) -> [f64; 10] {
    // Barycentric coordinates: linear fields are quadratic ones.
    let mut l: [f64; 4] = std::array::from_fn(|i| quadratic[i]);
    for ([i, j], value) in EDGES.into_iter().zip(&quadratic[4..]) {
        l[i] += 0.5 * value;
        l[j] += 0.5 * value;
    }
    let mut linear = [0.0; 10];
    let corner = (0..4).find(|i| l[*i] > 0.5);
    for (e, [i, j]) in EDGES.into_iter().enumerate() {
        // An inner part has the middles of two opposite edges, and of one of each other pair.
        let inner = l[i] + l[j] - 0.5;
        linear[4 + e] = match corner {
            Some(k) if k == i => 2.0 * l[j],
            Some(k) if k == j => 2.0 * l[i],
            Some(_) => 0.0,
            None => 2.0 * inner.max(0.0),
        };
    }
    match corner {
        Some(k) => linear[k] = 2.0 * l[k] - 1.0,
        None => {
            let opposite = [EDGES.iter().position(|e| *e == [0, 1]), EDGES.iter().position(|e| *e == [2, 3])];
            let rest = 0.5 * (1.0 - linear.iter().sum::<f64>());
            opposite.into_iter().flatten().for_each(|e| linear[4 + e] += rest);
        }
    }
    linear
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ElementNodes, PadFrame};
    use geometry::mesh::{grid, quadratic};

    #[test]
    fn the_estimated_error_vanishes_at_nodes_and_is_that_of_linear_interpolation() {
        // The edge of a quarter of a unit from node to node: a square has the error `x (h - x)` between them.
        let line: Vec<f64> = (0..=2).map(|i| i as f64 / 2.0).collect();
        let grid = quadratic::to_quadratic(&grid::structured([&line, &line, &line]).unwrap());
        let nodes = grid.nodes.clone();
        let pad =
            PadTopology { rest: grid.nodes, elements: ElementNodes::Quadratic(grid.tets), ..PadTopology::default() };
        let square: Vec<f64> = nodes.iter().map(|x| x.x * x.x).collect();
        let at_nodes = Stencils::new(&nodes, &pad).error_estimate().of(&square);
        assert!(at_nodes.iter().all(|error| error.abs() < 1e-14));
        let between: Vec<DVec3> = (0..40).map(|i| DVec3::new(f64::from(i) / 40.0, 0.0, 0.0)).collect();
        let estimated = Stencils::new(&between, &pad).error_estimate().of(&square);
        for (x, error) in between.iter().zip(estimated) {
            let from_node = x.x % 0.25;
            assert!((error + from_node * (0.25 - from_node)).abs() < 1e-14, "{error} at {x}");
        }
        let inside = Stencils::new(&[DVec3::new(0.3, 0.2, 0.22), DVec3::new(0.21, 0.47, 0.6)], &pad).error_estimate();
        let linear: Vec<f64> = nodes.iter().map(|x| 1.0 + x.x - 2.0 * x.y + 3.0 * x.z).collect();
        assert!(inside.of(&linear).iter().all(|error| error.abs() < 1e-14), "linear fields have no error");
    }

    #[test]
    fn quadratic_fields_are_reproduced_and_volumes_add_up() {
        let line = |n: usize| (0..=n).map(|i| i as f64 / n as f64).collect::<Vec<_>>();
        let coarse = grid::structured([&line(2), &line(2), &line(1)]).unwrap();
        let fine = quadratic::to_quadratic(&grid::structured([&line(3), &line(5), &line(4)]).unwrap());
        let coarse =
            PadTopology { rest: coarse.nodes, elements: ElementNodes::Linear(coarse.tets), ..PadTopology::default() };
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
        let pad =
            PadTopology { rest: fine.nodes, elements: ElementNodes::Quadratic(fine.tets), ..PadTopology::default() };
        let fields = FieldInterpolation::new(&points, &pad).fields(&frame);
        for (k, x) in points.position.iter().enumerate() {
            assert!((fields.stress[k] - field(*x)).abs() < 1e-12);
            assert!((fields.displacement[k] - DVec3::new(field(*x), x.y, 0.0)).length() < 1e-12);
        }
        let outside = Points { position: vec![DVec3::new(1.1, 0.5, 0.5)], volume: vec![1.0] };
        let at_the_rim = FieldInterpolation::new(&outside, &pad).fields(&frame).displacement[0];
        assert!((at_the_rim.y - 0.5).abs() < 0.2, "a point outside takes the nearest values: {at_the_rim}");
    }
}
