//! Graph of a pad: message passing runs on the nodes of the sensing face; all other nodes are interpolated from them.
//!
//! ```text
//! face nodes o--o--o   edges of the sensing triangles, both directions
//!            :  :  :   depth channels: values at fixed parts of the way down from a face node
//! node deep  x         interpolated: its face triangle x its two nearest channels
//! ```

use super::compliance::Compliance;
use super::compliance_cache::{ComplianceCache, ComplianceKey};
use super::edges::Edges;
use super::mortar::MortarBasis;
use crate::matrix::Sparse;
use base::error::{Error, Result};
use geometry::face_lookup::FaceLookup;
use geometry::mesh::surface;
use glam::{DVec2, DVec3, Vec3Swizzles};
use model::part::FingerModel;
use rayon::prelude::*;
use record::PadTopology;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Nodes between which a network passes messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Nodes of the sensing faces, with this many depth channels below them.
    Face {
        /// Number of depth channels from the face to the bonded side.
        depths: usize,
    },
    /// All nodes of the pads and nodes of the object: [`crate::features::volume`].
    Volume,
}

/// Constant data of a pad, input of the network. Lengths in m, pad frame.
#[derive(Debug, Clone)]
pub struct PadGraph {
    /// Layout that the graph was made for.
    pub layout: Layout,
    /// Thickness of the pad, the length unit of the network, m.
    pub thickness: f64,
    /// Number of nodes of the pad.
    pub node_count: usize,
    /// Nodes of the sensing face, ascending.
    pub face: Vec<u32>,
    /// Reference positions of these nodes.
    pub rest: Vec<DVec3>,
    /// Triangles of the face, as indices of these nodes.
    pub triangles: Vec<[u32; 3]>,
    /// Area of the face that belongs to each node, m2.
    pub area: Vec<f64>,
    /// Distance of each node from the rim of the face, m, and the vector to the rim along x and y, averaged over the
    /// parts of the rim at nearly that distance.
    pub to_rim: Vec<(f64, DVec2)>,
    /// Gradient along x and y at each face node: weights of the nodes around it, 1/m.
    pub gradient: Vec<Vec<(u32, DVec2)>>,
    /// Bounds of the face along x and y, m.
    pub bounds: [DVec2; 2],
    /// Edges between face nodes.
    pub edges: Edges,
    /// Rows (face node, depth channel) -> nodes of the pad.
    pub interpolate: Arc<Sparse>,
    /// Interpolation without entries for bonded nodes: its result is exactly zero there.
    pub interpolate_free: Arc<Sparse>,
    /// Linear response of the pad.
    pub compliance: Arc<Compliance>,
    /// Basis functions of the force on its face.
    pub basis: MortarBasis,
    /// BLAKE3 of the pad's mesh.
    pub hash: String,
    /// Poisson's ratio of its gel.
    poisson: f64,
}

impl PadGraph {
    /// Creates the graph of the pad of `finger` for a network of this layout.
    ///
    /// # Errors
    /// Fails for a pad without a sensing face, or whose stiffness in the reference state is not positive definite.
    pub fn new(finger: &FingerModel, layout: Layout) -> Result<Self> {
        Self::with_cache(finger, layout, None)
    }

    /// Creates the graph, with a linear response that is read from `cache` or computed and written there.
    ///
    /// # Errors
    /// Fails for a pad without a sensing face, or whose stiffness in the reference state is not positive definite.
    pub fn with_cache(finger: &FingerModel, layout: Layout, cache: Option<&ComplianceCache>) -> Result<Self> {
        let pad = &finger.topology;
        let face = pad.sensing_nodes();
        let thickness = pad.thickness();
        if face.is_empty() || thickness <= 0.0 {
            return Err(Error::Mesh("the pad has no sensing face above its bonded side".into()));
        }
        let own: BTreeMap<u32, u32> = face.iter().enumerate().map(|(i, n)| (*n, i as u32)).collect();
        let triangles: Vec<[u32; 3]> = pad.sensing.iter().map(|t| t.map(|n| own[&n])).collect();
        let rest: Vec<DVec3> = face.iter().map(|n| pad.rest[*n as usize]).collect();
        let mut area = vec![0.0; face.len()];
        let mut edges = Vec::new();
        for t in &triangles {
            let [a, b, c] = t.map(|i| rest[i as usize]);
            let third = (b - a).cross(c - a).length() / 6.0;
            for k in 0..3 {
                let (i, j) = (t[k], t[(k + 1) % 3]);
                area[i as usize] += third;
                edges.push((i, j));
            }
        }
        let (n, hash) = (face.len(), mesh_hash(pad));
        let depths = match layout {
            Layout::Face { depths } => depths,
            Layout::Volume => 1,
        };
        let rows = interpolation_rows(&pad.rest, &rest, &triangles, thickness, depths);
        let free: Vec<_> =
            rows.iter().zip(&pad.bonded).map(|(row, bonded)| if *bonded { Vec::new() } else { row.clone() }).collect();
        let compliance = Arc::new(response(finger, &face, thickness, &hash, cache)?);
        Ok(Self {
            basis: MortarBasis::new(pad, &face, &rest, &area, &compliance),
            compliance,
            layout,
            thickness,
            node_count: pad.rest.len(),
            interpolate: Sparse::new(&rows, n * depths),
            interpolate_free: Sparse::new(&free, n * depths),
            gradient: gradient(&rest, &triangles),
            to_rim: to_rim(&rest, &triangles, thickness),
            bounds: [
                rest.iter().map(|x| x.xy()).fold(DVec2::INFINITY, DVec2::min),
                rest.iter().map(|x| x.xy()).fold(DVec2::NEG_INFINITY, DVec2::max),
            ],
            triangles,
            face,
            rest,
            area,
            edges: Edges::new(edges, n, 6.0),
            hash,
            poisson: finger.body.material.moduli().poisson,
        })
    }

    /// Returns true if the bounding box of the face contains a point.
    pub fn bounds_contain(&self, at: DVec2) -> bool {
        at.cmpge(self.bounds[0]).all() && at.cmple(self.bounds[1]).all()
    }

    /// Returns true if this is the graph of a pad with this mesh hash and Poisson's ratio.
    pub fn matches(&self, hash: &str, poisson: f64) -> bool {
        self.poisson == poisson && self.hash == hash
    }
}

/// Returns the linear response of a pad with this mesh hash, read from `cache` or computed and written there.
fn response(
    finger: &FingerModel,
    face: &[u32],
    thickness: f64,
    hash: &str,
    cache: Option<&ComplianceCache>,
) -> Result<Compliance> {
    let Some(cache) = cache else { return Compliance::new(finger, face, thickness) };
    let key = ComplianceKey::of(finger, face, hash);
    if let Some(known) = cache.read(&key) {
        return Ok(known);
    }
    let found = Compliance::new(finger, face, thickness)?;
    cache.write(&key, &found);
    Ok(found)
}

/// Returns the BLAKE3 hash of a pad's mesh, by which a network identifies the pad.
pub fn mesh_hash(pad: &PadTopology) -> String {
    let mut bytes: Vec<u8> = pad.rest.iter().flat_map(|x| x.to_array()).flat_map(f64::to_le_bytes).collect();
    bytes.extend(pad.elements.nodes().iter().flat_map(|node| node.to_le_bytes()));
    blake3::hash(&bytes).to_hex().to_string()
}

/// Computes the gradients at the face nodes: means over the triangles around each, weighted by area.
fn gradient(rest: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec<(u32, DVec2)>> {
    let mut rows: Vec<BTreeMap<u32, DVec2>> = vec![BTreeMap::new(); rest.len()];
    let mut whole = vec![0.0; rest.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| rest[i as usize].xy());
        let double = (b - a).perp_dot(c - a).abs();
        let turn = (b - a).perp_dot(c - a).signum();
        for i in t {
            whole[*i as usize] += double;
            for (k, opposite) in [c - b, a - c, b - a].into_iter().enumerate() {
                // The gradient of a hat function is perpendicular to the opposite side and inverse to the height.
                *rows[*i as usize].entry(t[k]).or_default() += opposite.perp() * turn;
            }
        }
    }
    let row = |(row, whole): (BTreeMap<u32, DVec2>, f64)| row.into_iter().map(|(i, g)| (i, g / whole)).collect();
    rows.into_iter().zip(whole).map(row).collect()
}

/// Excess of a distance to the rim, over the thickness, at which its weight in the mean falls to 1/e.
const RIM_DECAY: f64 = 0.1;

/// Computes the distance of each face node from the rim (the edges of one triangle only), and the vector to it.
fn to_rim(rest: &[DVec3], triangles: &[[u32; 3]], thickness: f64) -> Vec<(f64, DVec2)> {
    let rim: Vec<[DVec2; 2]> =
        surface::rim(triangles).into_iter().map(|edge| edge.map(|i| rest[i as usize].xy())).collect();
    let way = |x: &DVec3| {
        let to = rim.iter().map(|[a, b]| {
            let along = *b - *a;
            let part = ((x.xy() - *a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            *a + along * part - x.xy()
        });
        let ways: Vec<DVec2> = to.collect();
        let least = ways.iter().map(|way| way.length()).fold(f64::INFINITY, f64::min);
        let weight = |way: &DVec2| (-(way.length() - least) / (RIM_DECAY * thickness)).exp();
        let (sum, whole) =
            ways.iter().fold((DVec2::ZERO, 0.0), |(sum, whole), way| (sum + *way * weight(way), whole + weight(way)));
        if whole > 0.0 { (least, sum / whole) } else { (0.0, DVec2::ZERO) }
    };
    rest.par_iter().map(way).collect()
}

/// Computes the interpolation of every node of the pad: (face node * depths + channel, weight), non-negative and
/// summing to one.
fn interpolation_rows(
    nodes: &[DVec3],
    face: &[DVec3],
    triangles: &[[u32; 3]],
    thickness: f64,
    depths: usize,
) -> Vec<Vec<(u32, f32)>> {
    let lookup = FaceLookup::new(face, triangles);
    let row = |x: &DVec3| {
        let corners = lookup.interpolation_at(*x);
        let top: f64 = corners.iter().map(|(i, w)| w * face[*i as usize].z).sum();
        let part = ((top - x.z) / (top + thickness)).clamp(0.0, 1.0) * (depths - 1) as f64;
        let upper = (part.floor() as usize).min(depths.saturating_sub(2));
        let lower = part - upper as f64;
        let channels = [(upper, 1.0 - lower), ((upper + 1).min(depths - 1), lower)];
        let mut row = Vec::new();
        for (i, w) in corners {
            let entries = channels.map(|(k, v)| (i * depths as u32 + k as u32, (w * v) as f32));
            row.extend(entries.into_iter().filter(|(_, w)| *w > 1e-7));
        }
        row
    };
    nodes.par_iter().map(row).collect()
}
