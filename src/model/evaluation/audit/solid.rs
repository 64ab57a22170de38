//! Object as a solid: whether a point is inside, and how deep. The solid is defined by the scene's dimensions for
//! ellipsoids, boxes and capsules, otherwise by the mesh of the surface. Of the distance functions of the contact, it
//! uses only the level set of a smooth surface.

use super::columns::Columns;
use geometry::mesh::TriMesh;
use geometry::shape::level_set::LevelSet;
use geometry::shape::{Shape, SurfaceDefinition};
use glam::{DVec2, DVec3};
use scene::{self, object as o};
use std::sync::Arc;

/// Rigid object in its own frame.
#[derive(Debug)]
pub enum Solid {
    /// Ellipsoid `|q / semi| < 1`; semi-axes, m.
    Ellipsoid(DVec3),
    /// Points within `radius` of a box about the origin, m.
    RoundBox {
        /// Half edge lengths of the box.
        core: DVec3,
        /// Radius of the rounding.
        radius: f64,
    },
    /// Solid of revolution about z, given by its section in the half-plane (rho, z).
    Revolved {
        /// Outline of the section, m.
        outline: Vec<[DVec2; 2]>,
        /// Largest distance of any point from the axis, m.
        reach: f64,
    },
    /// Closed triangle surface.
    Surface(Columns),
    /// Zero level set of a function that is defined near a triangle surface; elsewhere the triangles determine what is
    /// inside.
    Level(Arc<LevelSet>, Columns),
}

impl Solid {
    /// Creates the solid of the scene's object with the geometry `shape`.
    pub fn new(object: &scene::Object, shape: &Shape) -> Self {
        let scale = object.factor();
        match &object.shape {
            o::ObjectShape::Sphere(s) => Self::Ellipsoid(DVec3::splat(scale * s.radius.get())),
            o::ObjectShape::Ellipsoid(s) => Self::Ellipsoid(scale * s.radii.size()),
            o::ObjectShape::Cuboid(s) => {
                let radius = scale * s.edge_radius.get();
                Self::RoundBox { core: 0.5 * scale * s.size.size() - radius, radius }
            }
            o::ObjectShape::Capsule(s) => {
                Self::RoundBox { core: DVec3::Z * (0.5 * scale * s.height.get()), radius: scale * s.radius.get() }
            }
            o::ObjectShape::Cylinder(_)
            | o::ObjectShape::Annulus(_)
            | o::ObjectShape::Cup(_)
            | o::ObjectShape::Lemon(_)
            | o::ObjectShape::Strawberry(_)
            | o::ObjectShape::Pear(_)
            | o::ObjectShape::Revolve(_) => {
                let outline = section(&shape.surface);
                let reach = outline.iter().flatten().fold(0.0, |reach, p| f64::max(reach, p.x)) * (1.0 + 1e-9);
                Self::Revolved { outline, reach }
            }
            o::ObjectShape::Mesh(_)
            | o::ObjectShape::Prism(_)
            | o::ObjectShape::Banana(_)
            | o::ObjectShape::Potato(_)
            | o::ObjectShape::Sweep(_) => {
                let columns = Columns::new(&shape.surface);
                match &shape.definition {
                    SurfaceDefinition::Smooth(smooth) => Self::Level(smooth.level.clone(), columns),
                    SurfaceDefinition::ClosedForm | SurfaceDefinition::Facets => Self::Surface(columns),
                }
            }
        }
    }

    /// Returns the depth of `q` inside, m; zero outside. For ellipsoids and level sets it is accurate to first order.
    pub fn depth(&self, q: DVec3) -> f64 {
        match self {
            Self::Ellipsoid(semi) => {
                let level = (q / *semi).length();
                let slope = (q / (*semi * *semi)).length() / level;
                if level < 1e-6 { semi.min_element() } else { ((1.0 - level) / slope).max(0.0) }
            }
            Self::RoundBox { core, radius } => {
                let d = q.abs() - *core;
                (radius - d.max(DVec3::ZERO).length() - d.max_element().min(0.0)).max(0.0)
            }
            Self::Revolved { outline, reach } => {
                let p = DVec2::new(q.x.hypot(q.y), q.z);
                // This skips most points of a pad.
                if p.x <= *reach && crossings(outline, p) {
                    outline.iter().map(|s| apart(*s, p)).fold(f64::INFINITY, f64::min)
                } else {
                    0.0
                }
            }
            Self::Surface(columns) => columns.depth(q),
            // To first order; the level is undefined only far from the surface.
            Self::Level(level, columns) => {
                level.height(q).map_or_else(|| columns.depth(q), |height| (-height).max(0.0))
            }
        }
    }
}

/// Returns the outline of a solid of revolution in the half-plane y = 0, x >= 0, in which its mesh has vertices on the
/// true surface.
fn section(drawing: &TriMesh) -> Vec<[DVec2; 2]> {
    let size = drawing.vertices.iter().fold(0.0, |m: f64, p| m.max(p.length()));
    let on = |p: DVec3| p.y.abs() < 1e-9 * size && p.x > -1e-9 * size;
    let mut outline = Vec::new();
    for t in 0..drawing.triangles.len() {
        let corners = drawing.corners(t);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            // Each edge is taken once: one of its two triangles lies at y > 0.
            if on(a) && on(b) && corners[(k + 2) % 3].y > 0.0 {
                outline.push([a, b].map(|p| DVec2::new(p.x, p.z)));
            }
        }
    }
    outline
}

/// Returns true if a ray from `p` away from the axis crosses the outline an odd number of times.
fn crossings(outline: &[[DVec2; 2]], p: DVec2) -> bool {
    let mut odd = false;
    for &[a, b] in outline {
        if (a.y > p.y) != (b.y > p.y) {
            odd ^= p.x < a.x + (p.y - a.y) * (b.x - a.x) / (b.y - a.y);
        }
    }
    odd
}

/// Returns the distance of `p` to a line segment, m.
fn apart([a, b]: [DVec2; 2], p: DVec2) -> f64 {
    let e = b - a;
    (p - a - e * ((p - a).dot(e) / e.length_squared()).clamp(0.0, 1.0)).length()
}
