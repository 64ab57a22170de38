//! Vertices and edges of an object that are tested against the faces of a pad whose mesh is too coarse to resolve them.

use crate::mesh::TriMesh;
pub use crate::shape::feature_point::FeaturePoint;
use crate::shape::polygon::Profile;
use crate::shape::ring::Ring;
use crate::shape::rod::Rod;
use crate::shape::topology::Topology;
use base::scales::EDGE_CUT;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Angle between the normals of two faces above which their edge is sharp, rad (20 degrees).
pub const SHARP_ANGLE: f64 = 20.0 / 180.0 * std::f64::consts::PI;

/// Convex edge; sharp if the normals of its faces differ by more than [`SHARP_ANGLE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexEdge {
    /// Start of the edge, m.
    pub a: DVec3,
    /// End of the edge, m.
    pub b: DVec3,
    /// Unit mean of the two faces' normals at `a`.
    pub normal: DVec3,
    /// Angle between the two faces' normals, rad.
    pub angle: f64,
    /// True if the edge is an arc about the z axis (the rim of a round object) and not a straight line.
    pub round: bool,
}

impl ConvexEdge {
    /// Returns the length, m; for an arc, that of the chord.
    pub fn length(&self) -> f64 {
        self.a.distance(self.b)
    }

    /// Returns the point at the parameter `t` in 0..=1; for an arc it lies on the arc, not on the chord.
    pub fn point(&self, t: f64) -> FeaturePoint {
        let mut position = self.a.lerp(self.b, t);
        let mut normal = self.normal;
        if self.round {
            let flat = DVec2::new(self.a.x, self.a.y);
            let chord = DVec2::new(position.x, position.y).normalize_or(DVec2::X);
            let tilt = normal.dot(DVec3::new(flat.x, flat.y, 0.0).normalize_or(DVec3::X));
            position = (chord * flat.length()).extend(position.z);
            normal = (chord * tilt).extend(normal.z).normalize_or(normal);
        }
        FeaturePoint { position, normal, sharp: self.angle > SHARP_ANGLE }
    }

    /// Returns points strictly between the ends, at most `spacing` m apart.
    fn sample(&self, spacing: f64) -> impl Iterator<Item = FeaturePoint> {
        let (edge, count) = (*self, division_count(self.length(), spacing));
        (1..count).map(move |i| edge.point(f64::from(i) / f64::from(count)))
    }

    /// Divides the edge into sections, each at most `length` m long.
    fn sections(&self, length: f64) -> impl Iterator<Item = EdgeSection> {
        let (edge, count) = (*self, division_count(self.length(), length));
        let at = move |i: u32| f64::from(i) / f64::from(count);
        (0..count).map(move |i| EdgeSection { edge, from: at(i), to: at(i + 1) })
    }
}

/// Section of an edge on which the point of closest approach to a pad may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeSection {
    /// Complete edge.
    pub edge: ConvexEdge,
    /// Parameter of the edge at the start of the section, in 0..1.
    pub from: f64,
    /// Parameter of the edge at the end of the section, in 0..=1.
    pub to: f64,
}

impl EdgeSection {
    /// Returns the point at the parameter `t` in 0..=1 of the section, m.
    pub fn point(&self, t: f64) -> DVec3 {
        self.edge.point(self.from + t * (self.to - self.from)).position
    }

    /// Returns the length, m; for an arc, that of the chord.
    pub fn length(&self) -> f64 {
        self.edge.length() * (self.to - self.from)
    }
}

/// Contact vertices and edges of an object; all empty for an ellipsoid.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfaceFeatures {
    /// All vertices of a mesh; the sharp corners of a closed-form shape; samples of the rounded edges and corners of a
    /// smoothed mesh.
    pub vertices: Vec<FeaturePoint>,
    /// Sharp convex edges; a rim is a closed chain of arcs.
    pub sharp_edges: Vec<ConvexEdge>,
    /// Convex edges between facets of a mesh that are not sharp; only those that a pad would detect are tested.
    pub blunt_edges: Vec<ConvexEdge>,
    /// Straight rounded convex edges.
    pub rounded_edges: Vec<RoundedEdge>,
    /// Circles on the smooth convex parts of a solid of revolution, in the order of its profile.
    pub rings: Vec<Ring>,
    /// Rod that represents a ball, a capsule or the lateral surface of a cylinder; sampled if thin compared with the
    /// pad spacing.
    pub rod: Option<Rod>,
}

/// Straight rounded convex edge: a sector of a cylinder. A pad whose spacing exceeds its radius would penetrate it
/// between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundedEdge {
    /// Ends of the axis, m.
    pub axis: [DVec3; 2],
    /// Radius, m.
    pub radius: f64,
    /// Unit normals of the two faces that it joins.
    pub normals: [DVec3; 2],
}

/// Largest angle between the normals of two faces that count as coplanar, rad.
const COPLANAR_ANGLE: f64 = 1e-6;
/// Radius of a rounded edge, over the spacing of the points on it, from which on the samples of a pad resolve the edge:
/// between them the pad then penetrates it by a fiftieth of their distance.
const RESOLVED_RADIUS: f64 = 12.0;

/// Returns the number of parts of at most `spacing` m into which a length is divided (at most 10,000); 1 if the spacing
/// is not positive.
pub(super) fn division_count(length: f64, spacing: f64) -> u32 {
    if spacing > 0.0 { (length / spacing).ceil().clamp(1.0, 1e4) as u32 } else { 1 }
}

impl RoundedEdge {
    /// Returns points at most `spacing` m apart along the edge and around it, without the lines where it meets the two
    /// faces.
    fn sample(&self, spacing: f64) -> impl Iterator<Item = FeaturePoint> {
        let [a, b] = self.axis;
        let angle = self.normals[0].angle_between(self.normals[1]);
        let (along, around) =
            (division_count(a.distance(b), spacing), division_count(angle * self.radius, spacing).max(2));
        let edge = *self;
        (1..around).flat_map(move |j| {
            let normal = edge.normals[0].slerp(edge.normals[1], f64::from(j) / f64::from(around));
            let at = move |i| a.lerp(b, f64::from(i) / f64::from(along)) + normal * edge.radius;
            (0..=along).map(move |i| FeaturePoint { position: at(i), normal, sharp: false })
        })
    }
}

impl SurfaceFeatures {
    /// Returns the vertices, then points on the sharp edges between their ends such that neighbours are at most
    /// `spacing` m apart (none if it is not positive; at most 10,000 per edge). Points of the same spacing follow on
    /// rounded edges with a radius below `RESOLVED_RADIUS * spacing`; points on the tight parts of a solid of
    /// revolution and all over a thin rod are spaced according to the contact `offset` (m). No point occurs twice.
    pub fn sample(&self, spacing: f64, offset: f64) -> Vec<FeaturePoint> {
        let mut points = self.vertices.clone();
        points.extend(self.sharp_edges.iter().flat_map(|e| e.sample(spacing)));
        let tight = self.rounded_edges.iter().filter(|e| e.radius < RESOLVED_RADIUS * spacing);
        points.extend(tight.flat_map(|e| e.sample(spacing)));
        points.extend(Ring::sample(&self.rings, spacing, offset));
        points.extend(self.rod.iter().flat_map(|rod| rod.sample(spacing, offset)));
        points
    }

    /// Returns, in sections of at most `length` m, the sharp edges and those blunt edges that a pad could penetrate by
    /// more than a fraction of the contact `offset` (m): an edge of the pad may cross them between its vertices.
    pub fn sections(&self, length: f64, offset: f64) -> impl Iterator<Item = EdgeSection> {
        let blunt = self.relevant_blunt_edges(length, offset);
        self.sharp_edges.iter().chain(blunt).flat_map(move |e| e.sections(length))
    }

    /// Returns the blunt edges to be tested if `length` (m) of them may lie between the samples of a pad: those where
    /// the penetration, an eighth of that length times the angle between the faces, exceeds `EDGE_CUT` contact offsets.
    fn relevant_blunt_edges(&self, length: f64, offset: f64) -> impl Iterator<Item = &ConvexEdge> {
        let cuts = move |e: &&ConvexEdge| e.angle * e.length().min(length) / 8.0 > EDGE_CUT * offset;
        self.blunt_edges.iter().filter(cuts)
    }

    /// Returns the number of vertices, points on sharp edges and sections of edges for a pad whose points are `spacing`
    /// m apart.
    pub fn count(&self, spacing: f64, offset: f64) -> u64 {
        let along = |e: &ConvexEdge, spacing: f64| u64::from(division_count(e.length(), spacing));
        let sharp = self.sharp_edges.iter().map(|e| along(e, 0.5 * spacing) + along(e, spacing)).sum::<u64>();
        let blunt = self.relevant_blunt_edges(spacing, offset).map(|e| along(e, spacing)).sum::<u64>();
        self.vertices.len() as u64 + sharp + blunt
    }

    pub(crate) fn of_rod(radius: f64, half: f64) -> Self {
        Self { rod: Some(Rod { radius, half, capped: true }), ..Self::default() }
    }

    pub(crate) fn of_mesh(mesh: &TriMesh, topology: &Topology) -> Self {
        let mut sharp = vec![false; mesh.vertices.len()];
        let (mut sharp_edges, mut blunt_edges) = (Vec::new(), Vec::new());
        for (edge, &normal) in topology.edges.iter().zip(&topology.edge_normals) {
            let [l, r] = edge.triangles.map(|t| topology.normals[t as usize]);
            let [a, b] = edge.ends.map(|v| mesh.vertices[v as usize]);
            // Viewed along the edge, with the left face on the left: across a convex edge the normal rotates from left
            // to right.
            let angle = l.cross(r).length().atan2(l.dot(r));
            let convex = l.cross(r).dot(b - a) > 0.0;
            let feature = ConvexEdge { a, b, normal, angle, round: false };
            if convex && angle > SHARP_ANGLE {
                edge.ends.iter().for_each(|&v| sharp[v as usize] = true);
                sharp_edges.push(feature);
            } else if convex && angle > COPLANAR_ANGLE {
                blunt_edges.push(feature);
            }
        }
        mark_tips(mesh, topology, &mut sharp);
        let used = |v: &usize| topology.vertex_normals[*v] != DVec3::ZERO;
        let vertices = (0..mesh.vertices.len())
            .filter(used)
            .map(|v| FeaturePoint { position: mesh.vertices[v], normal: topology.vertex_normals[v], sharp: sharp[v] })
            .collect();
        Self { vertices, sharp_edges, blunt_edges, ..Self::default() }
    }

    /// Returns the rims of a solid of revolution, each as `segments` arcs, its tips on the axis and its rings.
    pub(crate) fn of_profile(profile: &Profile, segments: u32) -> Self {
        let mut features = Self::default();
        for (i, &p) in profile.points().iter().enumerate() {
            let (before, after) = profile.adjacent_normals(i);
            let turn = before.perp_dot(after).atan2(before.dot(after));
            let normal = (before + after).try_normalize().unwrap_or(after);
            if turn <= SHARP_ANGLE {
                if turn > 0.0 {
                    features.rings.push(Ring::new(profile, i, turn, normal));
                }
                continue;
            }
            if p.x == 0.0 {
                let position = DVec3::new(0.0, 0.0, p.y);
                features.vertices.push(FeaturePoint { position, normal: DVec3::Z * normal.y.signum(), sharp: true });
                continue;
            }
            let ring = |k: u32| {
                let (sin, cos) = (TAU * f64::from(k % segments) / f64::from(segments)).sin_cos();
                (DVec3::new(p.x * cos, p.x * sin, p.y), DVec3::new(normal.x * cos, normal.x * sin, normal.y))
            };
            for k in 0..segments {
                let ((a, n), (b, _)) = (ring(k), ring(k + 1));
                features.vertices.push(FeaturePoint { position: a, normal: n, sharp: true });
                features.sharp_edges.push(ConvexEdge { a, b, normal: n, angle: turn, round: true });
            }
        }
        features
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        scaled.vertices.iter_mut().for_each(|v| v.position *= factor);
        scaled.rings = scaled.rings.iter().map(|r| r.scaled(factor)).collect();
        scaled.rod = scaled.rod.map(|rod| rod.scaled(factor));
        let edges = scaled.sharp_edges.iter_mut().chain(&mut scaled.blunt_edges);
        edges.for_each(|e| (e.a, e.b) = (factor * e.a, factor * e.b));
        scaled
            .rounded_edges
            .iter_mut()
            .for_each(|e| (e.axis, e.radius) = (e.axis.map(|p| p * factor), e.radius * factor));
        scaled
    }
}

/// Marks tips as sharp. The tip of a finely faceted cone has no sharp edge; therefore a convex vertex is also sharp if
/// the normal of an adjacent face deviates from the pseudo-normal by more than [`SHARP_ANGLE`].
fn mark_tips(mesh: &TriMesh, topology: &Topology, sharp: &mut [bool]) {
    let mut leans = vec![false; sharp.len()];
    let mut convex = vec![true; sharp.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let v = corners[i] as usize;
            let n = topology.vertex_normals[v];
            leans[v] |= n.dot(topology.normals[t]) < SHARP_ANGLE.cos();
            let along = mesh.vertices[corners[(i + 1) % 3] as usize] - mesh.vertices[v];
            convex[v] &= n.dot(along) < 0.0;
        }
    }
    for v in 0..sharp.len() {
        sharp[v] |= leans[v] && convex[v];
    }
}
