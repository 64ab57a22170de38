//! Rigid object of a scene.

use base::error::{Error, Result};
use base::number::{format_number, round_significant};
use base::scales;
use base::stats::median;
use geometry::Aabb;
use geometry::mesh::io::read_tri_mesh;
use geometry::mesh::{TriMesh, format_point};
use geometry::shape::{Shape, ShapeKind, SurfaceDefinition, valid_surface};
use glam::DVec3;
use mech::contact::ContactVertex;
use scene::leaf::MAX_LENGTH;
use scene::{self, object as o};
use std::sync::Arc;

/// Largest distance of a point of the object from the origin of its frame, m.
const MAX_DISTANCE: f64 = 1e3;

/// Ratio of a vertex's distance from the median position to the median of these distances above which it counts as a
/// stray vertex and not as part of a slender object.
const STRAY_RATIO: f64 = 100.0;

/// Largest number of contact vertices of the object: they take about 1.5 GB.
const MAX_FEATURES: u64 = 1_000_000;

/// Reads or generates the object and scales it; adds repairs of a file to `notices`.
///
/// # Errors
/// Fails for an unreadable file, a size beyond the limits, or a surface that does not enclose a volume; the message
/// names the file.
pub fn build(object: &scene::Object, notices: &mut Vec<String>) -> Result<Shape> {
    let scale = object.factor();
    let shape = match &object.shape {
        o::ObjectShape::Mesh(path) => {
            let (mesh, news) = read_tri_mesh(path)?;
            notices.extend(news);
            let stem = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
            let read = || {
                within_limits(&mesh, scale)?;
                let (mesh, news) = valid_surface(mesh, object.repair)?;
                notices.extend(news.into_iter().map(|n| format!("{}: {n}", path.display())));
                Shape::from_mesh(mesh)
            };
            let shape = read().map_err(|e| match e {
                Error::Mesh(message) => Error::file(path, message),
                other => other,
            })?;
            shape.with_name(stem)
        }
        generated => kind(generated).build(object.segments.get() as u32)?,
    };
    if scale == 1.0 { Ok(shape) } else { shape.scaled(scale) }
}

/// Returns `shape`, the shape of `object`, with its contact surface for pads of this `thickness` (m; `None` without
/// pads) with points `spacing` (m) apart. Adds the kind of the surface and its error to `notices`.
///
/// # Errors
/// Fails for a radius that is too small for the size of the object.
pub fn with_contact_surface(
    object: &scene::Object,
    shape: Shape,
    thickness: Option<f64>,
    spacing: f64,
    notices: &mut Vec<String>,
) -> Result<Shape> {
    let SurfaceDefinition::Facets = shape.definition else { return Ok(shape) };
    let count = shape.surface.triangles.len();
    let default_radius = thickness.map(scales::edge_radius);
    let (shape, why) = match (&object.surface, &object.shape, default_radius) {
        (Some(o::ObjectSurface::Smooth(smooth)), _, Some(default)) => {
            (shape.smoothed(smooth.radius.map_or(default, |radius| radius.get()), spacing)?, None)
        }
        (None, o::ObjectShape::Mesh(_), Some(default)) => shape.with_suitable_surface(default, spacing),
        _ => (shape, None),
    };
    let name = &shape.name;
    notices.push(match &shape.definition {
        SurfaceDefinition::Smooth(smooth) => format!(
            "the {name} is a smooth surface through its mesh of {count} triangles, with edges rounded by about {} mm; \
             its deviation from the mesh is at most {} mm, {} mm rms; `surface: Faceted` keeps the facets",
            format_number(1e3 * smooth.level.spacing()),
            format_number(round_significant(1e3 * smooth.largest, 2)),
            format_number(round_significant(1e3 * smooth.rms, 2)),
        ),
        _ => {
            let why = why.map_or_else(String::new, |why| format!(": {why}"));
            format!("the {name} is its faceted surface mesh of {count} triangles{why}")
        }
    });
    Ok(shape)
}

/// Checks that the scaled object is not too large and not too far from its origin.
fn within_limits(mesh: &TriMesh, scale: f64) -> Result<()> {
    let size = scale * Aabb::from_points(mesh.vertices.iter().copied()).size().max_element();
    if size > MAX_LENGTH {
        if let Some((v, away)) = stray_vertex(mesh) {
            return Err(Error::Mesh(format!(
                "the object is {} m wide because its vertex {v} (0-based) at {} lies {} m from the middle of the others: remove it, or \
                 the facets that use it",
                format_number(size),
                format_point(scale * mesh.vertices[v]),
                format_number(scale * away)
            )));
        }
        let (unit, factor) = if size < 5.0 { ("centimetres", 1e-2) } else { ("millimetres", 1e-3) };
        return Err(Error::Mesh(format!(
            "the object is {} m wide, but at most {MAX_LENGTH} m is allowed: if the file is in {unit}, write `scale: \
             {:e}`",
            (size * 1e3).round() / 1e3,
            scale * factor
        )));
    }
    let far = mesh.vertices.iter().find(|p| scale * p.abs().max_element() > MAX_DISTANCE);
    far.map_or(Ok(()), |p| {
        Err(Error::Mesh(format!(
            "the object is {} from the origin of its file; coordinates must be within {MAX_DISTANCE} m: move it there",
            format_point(scale * *p)
        )))
    })
}

/// Returns the vertex farthest from the median position of all vertices, and its distance, m, if it exceeds the median
/// distance by the factor [`STRAY_RATIO`].
fn stray_vertex(mesh: &TriMesh) -> Option<(usize, f64)> {
    let middle = DVec3::from_array([0, 1, 2].map(|axis| median(mesh.vertices.iter().map(|p| p[axis]))));
    let away = |p: &DVec3| p.distance(middle);
    let most = median(mesh.vertices.iter().map(away));
    let farthest = mesh.vertices.iter().map(away).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (farthest.1 > STRAY_RATIO * most).then_some(farthest)
}

/// Returns the generator of a shape that is not from a file.
fn kind(shape: &o::ObjectShape) -> ShapeKind {
    match shape {
        // Never reached for a mesh; any valid shape will do.
        o::ObjectShape::Mesh(_) => ShapeKind::Sphere { radius: 1.0 },
        o::ObjectShape::Sphere(s) => ShapeKind::Sphere { radius: s.radius.get() },
        o::ObjectShape::Cuboid(s) => ShapeKind::Cuboid { size: s.size.size(), edge_radius: s.edge_radius.get() },
        o::ObjectShape::Ellipsoid(s) => ShapeKind::Ellipsoid { semi_axes: s.radii.size() },
        o::ObjectShape::Cylinder(s) => ShapeKind::Cylinder { radius: s.radius.get(), height: s.height.get() },
        // A scene gives the height of the cylindrical part, the generator takes the total length.
        o::ObjectShape::Capsule(s) => {
            ShapeKind::Capsule { radius: s.radius.get(), length: s.height.get() + 2.0 * s.radius.get() }
        }
        o::ObjectShape::Prism(s) => {
            ShapeKind::Prism { sides: s.sides.get() as u32, radius: s.radius.get(), height: s.height.get() }
        }
        o::ObjectShape::Annulus(s) => {
            ShapeKind::Annulus { outer_radius: s.outer.get(), inner_radius: s.inner.get(), height: s.height.get() }
        }
        o::ObjectShape::Cup(s) => ShapeKind::Cup { radius: s.radius.get(), height: s.height.get(), wall: s.wall.get() },
        o::ObjectShape::Lemon(s) => ShapeKind::Lemon { length: s.length.get(), diameter: s.diameter.get() },
        o::ObjectShape::Strawberry(s) => ShapeKind::Strawberry { length: s.length.get(), diameter: s.diameter.get() },
        o::ObjectShape::Pear(s) => ShapeKind::Pear { length: s.length.get(), diameter: s.diameter.get() },
        o::ObjectShape::Banana(s) => ShapeKind::Banana {
            length: s.length.get(),
            diameter: s.diameter.get(),
            bend: s.bend_deg.get().to_radians(),
        },
        o::ObjectShape::Potato(s) => {
            ShapeKind::Potato { semi_axes: s.radii.size(), roughness: s.roughness.get(), seed: s.seed }
        }
        o::ObjectShape::Revolve(s) => ShapeKind::Revolve {
            profile: s.profile.iter().map(|p| glam::DVec2::from_array(p.pair())).collect(),
            closed: s.closed,
        },
        o::ObjectShape::Sweep(s) => ShapeKind::Sweep {
            path: s.path.iter().map(|p| p.dvec3()).collect(),
            // A single radius applies to all points.
            radii: (0..s.path.len()).filter_map(|i| s.radii.get(i).or(s.radii.first())).map(|r| r.get()).collect(),
        },
    }
}

/// Returns the contact vertices of the object for a pad with sample spacing `spacing` (m) and contact offset `offset`
/// (m). Points along sharp edges are half the spacing apart; an edge between facets has one movable vertex per segment
/// of the length of the spacing.
///
/// # Errors
/// Fails if there are more than `MAX_FEATURES` vertices.
pub fn features(shape: &Shape, spacing: f64, offset: f64) -> Result<Arc<[ContactVertex]>> {
    let count = shape.features.count(spacing, offset);
    if count > MAX_FEATURES {
        return Err(Error::Mesh(format!(
            "the {} has {count} vertices and points on edges at the pad's spacing of {spacing:.2e} m, at most \
             {MAX_FEATURES} are allowed: simplify its mesh, or write a larger `spacing`",
            shape.name
        )));
    }
    let points = shape.features.sample(0.5 * spacing, offset).into_iter();
    let fixed = points.map(|f| ContactVertex { position: f.position, sharp: f.sharp, segment: None });
    Ok(fixed.chain(shape.features.sections(spacing, offset).map(ContactVertex::on_segment)).collect())
}
