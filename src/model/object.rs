//! The rigid object of a scene.

use crate::contact::Feature;
use crate::error::{Error, Result};
use crate::mesh::io::read_tri_mesh;
use crate::scene::{self, object as o};
use crate::shape::{Shape, ShapeKind};
use std::sync::Arc;

/// Reads or generates the object, at its scale; repairs of a file go to `notices`.
///
/// # Errors
/// An unreadable file, or a surface that does not enclose a volume, with the file's name.
pub fn build(object: &scene::Object, notices: &mut Vec<String>) -> Result<Shape> {
    let shape = match &object.shape {
        o::Shape::Mesh(path) => {
            let (mesh, news) = read_tri_mesh(path)?;
            notices.extend(news);
            let stem = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
            let shape = Shape::from_mesh(mesh).map_err(|e| match e {
                Error::Mesh(message) => Error::file(path, message),
                other => other,
            })?;
            shape.named(stem)
        }
        generated => kind(generated).build(object.segments.get() as u32)?,
    };
    let scale = object.scale.get();
    let shape = if scale == 1.0 { shape } else { shape.scaled(scale)? };
    if !shape.exact {
        let n = shape.surface.triangles.len();
        notices.push(format!("the {} is its surface mesh of {n} triangles, facets included", shape.name));
    }
    Ok(shape)
}

/// The generator of a shape that is not a file.
fn kind(shape: &o::Shape) -> ShapeKind {
    match shape {
        // A mesh never gets here; a unit ball is the harmless answer.
        o::Shape::Mesh(_) => ShapeKind::Sphere { radius: 1.0 },
        o::Shape::Sphere(s) => ShapeKind::Sphere { radius: s.radius.get() },
        o::Shape::Cuboid(s) => ShapeKind::Cuboid { size: s.size.size(), edge_radius: s.edge_radius.get() },
        o::Shape::Ellipsoid(s) => ShapeKind::Ellipsoid { semi_axes: s.radii.size() },
        o::Shape::Cylinder(s) => ShapeKind::Cylinder { radius: s.radius.get(), height: s.height.get() },
        // A scene gives the height of the cylindrical part, the generator takes the whole length.
        o::Shape::Capsule(s) => {
            ShapeKind::Capsule { radius: s.radius.get(), length: s.height.get() + 2.0 * s.radius.get() }
        }
        o::Shape::Prism(s) => {
            ShapeKind::Prism { sides: s.sides.get() as u32, radius: s.radius.get(), height: s.height.get() }
        }
        o::Shape::Annulus(s) => {
            ShapeKind::Annulus { outer_radius: s.outer.get(), inner_radius: s.inner.get(), height: s.height.get() }
        }
        o::Shape::Cup(s) => ShapeKind::Cup { radius: s.radius.get(), height: s.height.get(), wall: s.wall.get() },
        o::Shape::Lemon(s) => ShapeKind::Lemon { length: s.length.get(), diameter: s.diameter.get() },
        o::Shape::Strawberry(s) => ShapeKind::Strawberry { length: s.length.get(), diameter: s.diameter.get() },
        o::Shape::Pear(s) => ShapeKind::Pear { length: s.length.get(), diameter: s.diameter.get() },
        o::Shape::Banana(s) => ShapeKind::Banana {
            length: s.length.get(),
            diameter: s.diameter.get(),
            bend: s.bend_deg.get().to_radians(),
        },
        o::Shape::Potato(s) => {
            ShapeKind::Potato { semi_axes: s.radii.size(), roughness: s.roughness.get(), seed: s.seed }
        }
        o::Shape::Revolve(s) => ShapeKind::Revolve {
            profile: s.profile.iter().map(|p| glam::DVec2::from_array(p.pair())).collect(),
            closed: s.closed,
        },
        o::Shape::Sweep(s) => ShapeKind::Sweep {
            path: s.path.iter().map(|p| p.dvec3()).collect(),
            // One radius is that of all points.
            radii: (0..s.path.len()).filter_map(|i| s.radii.get(i).or(s.radii.first())).map(|r| r.get()).collect(),
        },
    }
}

/// Features of the object for a pad whose points lie `spacing` (m) apart: half of it along sharp edges, and one on every stretch of
/// an edge between facets that is as long as that.
pub fn features(shape: &Shape, spacing: f64) -> Arc<[Feature]> {
    let points = shape.features.sample(0.5 * spacing).into_iter();
    let fixed = points.map(|f| Feature { position: f.position, sharp: f.sharp, along: None });
    fixed.chain(shape.features.stretches(spacing).map(Feature::along)).collect()
}
