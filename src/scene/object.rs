//! Rigid object.

use super::defaults;
use super::leaf::{Count, Depth, Length, NonNegative, Positive};
use super::vector::{Size, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Rigid object: shape, density and motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Shape in the object frame.
    pub shape: ObjectShape,
    /// Factor on all lengths of the shape. None takes the `object/scale` of the grasp file, or 1 if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Positive>,
    /// Flag: a surface from a file that does not bound a solid is repaired. Vertices are welded and holes filled; if
    /// that does not suffice, the surface is rebuilt as the isosurface 1/2 of its generalised winding number, sampled
    /// on a grid.
    #[serde(default)]
    pub repair: bool,
    /// Contact surface of an object given as a triangle mesh. With None, a mesh file gets a smooth surface whose edges
    /// are rounded with a radius of at most a quarter of the pad thickness, unless its edges lie between flat faces or
    /// it is too large, too thin or too sharp for that; `tactus check` reports the choice and the largest deviation
    /// from the mesh. Generated shapes keep their facets with None.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<ObjectSurface>,
    /// Density, kg/m3.
    #[serde(default = "defaults::object_density")]
    pub density: Positive,
    /// Number of segments of the full circumference of a generated round surface. The mesh is used for pictures and
    /// files, and for contact if the shape has no distance function in closed form.
    #[serde(default = "defaults::segments")]
    pub segments: Count<8, 512>,
    /// Motion of the object: free or fixed.
    #[serde(default)]
    pub motion: ObjectMotion,
    /// Motion relative to the hand after which a free object counts as dropped, in a quasi-static scene.
    #[serde(default)]
    pub dropped_after: DroppedAfter,
    /// Velocity of the object's centre of mass at the start of a dynamic scene, world axes, m/s.
    #[serde(default)]
    pub velocity: Option<Vec3>,
    /// Angular velocity of the object at the start of a dynamic scene, world axes, rad/s.
    #[serde(default)]
    pub spin: Option<Vec3>,
}

impl Object {
    /// Returns the factor on all lengths of the shape.
    pub fn factor(&self) -> f64 {
        self.scale.unwrap_or(defaults::SCALE).get()
    }
}

/// Motion of the object: free or fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename = "Motion")]
pub enum ObjectMotion {
    /// Rigid body that moves under contact, friction and gravity.
    #[default]
    Free,
    /// Object held in place.
    Fixed,
}

/// Motion of an object relative to the hand after which it counts as dropped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DroppedAfter {
    /// Displacement of the point of the object that was midway between the pads, m. None is half of the shorter side of
    /// a pad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<Length>,
    /// Rotation of the object, degrees.
    #[serde(default = "defaults::dropped_turn_deg")]
    pub turn_deg: Positive,
}

impl Default for DroppedAfter {
    fn default() -> Self {
        Self { distance: None, turn_deg: defaults::DROPPED_TURN_DEG }
    }
}

/// Contact surface of a triangle mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ObjectSurface {
    /// The facets with all their edges.
    Faceted,
    /// A smooth surface that approximates the mesh.
    Smooth(SmoothObjectSurface),
}

/// Smooth surface that approximates a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmoothObjectSurface {
    /// Radius with which edges are rounded, m. None is a quarter of the pad thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<Length>,
}

/// Shape, centred on the origin of its frame unless stated otherwise, with its axis along z if it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Shape")]
pub enum ObjectShape {
    /// Closed surface from an OBJ, STL or PLY file, in metres (otherwise use `scale`), in the file's own frame.
    Mesh(PathBuf),
    /// Sphere.
    Sphere(Sphere),
    /// Box with edges along x, y, z.
    Cuboid(Cuboid),
    /// Ellipsoid with axes along x, y, z.
    Ellipsoid(Ellipsoid),
    /// Cylinder.
    Cylinder(Cylinder),
    /// Cylinder with hemispherical ends.
    Capsule(Capsule),
    /// Prism over a regular polygon.
    Prism(Prism),
    /// Cylinder with a hole along its axis.
    Annulus(Annulus),
    /// Hollow cylinder with a bottom, open at the top.
    Cup(Cup),
    /// Spindle along z with a nipple at each end.
    Lemon(Lemon),
    /// Rounded cone, along z, tip down.
    Strawberry(Strawberry),
    /// Body of revolution along z, thick at -z and narrow at +z.
    Pear(Pear),
    /// Spindle bent along a circular arc in the xz plane.
    Banana(Banana),
    /// Ellipsoid with random lumps.
    Potato(Potato),
    /// Solid of revolution about z.
    Revolve(Revolve),
    /// Solid with circular cross-sections of variable radius along a path.
    Sweep(Sweep),
}

/// Declares the structs of the shapes, which deny unknown fields.
macro_rules! shapes {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty,)* })*) => {
        $($(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name { $($(#[$field_meta])* pub $field: $type,)* })*
    };
}

shapes! {
    /// Sphere.
    Sphere {
        /// Radius, m.
        radius: Length,
    }
    /// Box.
    Cuboid {
        /// Outer edge lengths along x, y, z, m.
        size: Size,
        /// Radius of all edges and corners, m; zero keeps them sharp; at most half the smallest edge length.
        #[serde(default = "defaults::edge_radius")]
        edge_radius: Depth,
    }
    /// Ellipsoid.
    Ellipsoid {
        /// Semi-axes along x, y, z, m.
        radii: Size,
    }
    /// Cylinder with sharp rims.
    Cylinder {
        /// Radius, m.
        radius: Length,
        /// Height along z, m.
        height: Length,
    }
    /// Capsule.
    Capsule {
        /// Radius, m.
        radius: Length,
        /// Height of the cylindrical part, m; the total length is `height + 2 radius`.
        height: Length,
    }
    /// Prism over a regular polygon.
    Prism {
        /// Number of sides of the polygon.
        sides: Count<3, 100>,
        /// Distance from the axis to a corner, m.
        radius: Length,
        /// Height along z, m.
        height: Length,
    }
    /// Cylinder with a hole.
    Annulus {
        /// Outer radius, m.
        outer: Length,
        /// Radius of the hole, m.
        inner: Length,
        /// Height along z, m.
        height: Length,
    }
    /// Cup, open at the top (+z).
    Cup {
        /// Outer radius, m.
        radius: Length,
        /// Height along z, m.
        height: Length,
        /// Thickness of wall and bottom, m.
        wall: Length,
    }
    /// Lemon.
    Lemon {
        /// Length from tip to tip, m.
        #[serde(default = "defaults::lemon_length")]
        length: Length,
        /// Largest diameter, m.
        #[serde(default = "defaults::lemon_diameter")]
        diameter: Length,
    }
    /// Strawberry.
    Strawberry {
        /// Length from stalk to tip, m.
        #[serde(default = "defaults::strawberry_length")]
        length: Length,
        /// Largest diameter, m.
        #[serde(default = "defaults::strawberry_diameter")]
        diameter: Length,
    }
    /// Pear.
    Pear {
        /// Length from end to end, m.
        #[serde(default = "defaults::pear_length")]
        length: Length,
        /// Largest diameter, m.
        #[serde(default = "defaults::pear_diameter")]
        diameter: Length,
    }
    /// Banana.
    Banana {
        /// Arc length of the centre line, m.
        #[serde(default = "defaults::banana_length")]
        length: Length,
        /// Largest diameter, m.
        #[serde(default = "defaults::banana_diameter")]
        diameter: Length,
        /// Angle subtended by the arc, degrees; 1 to 170.
        #[serde(default = "defaults::banana_bend")]
        bend_deg: Positive,
    }
    /// Potato.
    Potato {
        /// Semi-axes before the lumps are added, m.
        #[serde(default = "defaults::potato_radii")]
        radii: Size,
        /// Height of the lumps as a fraction of the radius; at most 0.3.
        #[serde(default = "defaults::potato_roughness")]
        roughness: NonNegative,
        /// Seed of the lumps; the same seed gives the same potato.
        #[serde(default)]
        seed: u64,
    }
    /// Solid of revolution.
    Revolve {
        /// Points (r, z) of the profile, m: an open line from axis to axis (r = 0 at both ends, r > 0 between), or a
        /// closed loop off the axis.
        profile: Vec<Vec2>,
        /// Flag: the profile is a closed loop (the first point is not repeated), so that the solid is a ring.
        #[serde(default)]
        closed: bool,
    }
    /// Solid swept along a path.
    Sweep {
        /// Points of the centre line, m.
        path: Vec<Vec3>,
        /// Radius at each point, or one radius for all points, m. A radius of zero at an end makes a tip; otherwise the
        /// end is flat.
        radii: Vec<Depth>,
    }
}
