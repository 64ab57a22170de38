//! Rigid object.

use super::defaults;
use super::leaf::{Count, Depth, Length, NonNegative, Positive};
use super::vector::{Size, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Rigid object: shape, weight and freedom to move.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Shape in the object frame.
    pub shape: ObjectShape,
    /// Factor on all lengths of the shape. None takes the `object/scale` that the grasp file has, and 1 without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Positive>,
    /// Switch for the repair of a surface from a file that does not bound a solid: vertices are welded and holes filled;
    /// if that is not enough, the winding number of the surface is sampled anew.
    #[serde(default)]
    pub repair: bool,
    /// Surface that the pads feel of an object that is a mesh. None rounds the facets of a mesh file, with twice the distance of the points of
    /// a pad as the radius, unless flat faces meet at its edges or it is too thin or too sharp for that; `tactus check` says which, and
    /// by how much it is off. Generated shapes keep their facets then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<ObjectSurface>,
    /// Density, kg/m3.
    #[serde(default = "defaults::object_density")]
    pub density: Positive,
    /// Divisions of a full turn of a generated round surface, which is drawn and written and is the contact geometry if
    /// the shape has no closed form.
    #[serde(default = "defaults::segments")]
    pub segments: Count<8, 512>,
    /// Freedom of the object to move.
    #[serde(default)]
    pub motion: ObjectMotion,
    /// Motion in the hand after which a free object counts as dropped, in a scene without time.
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

/// Freedom of the object to move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename = "Motion")]
pub enum ObjectMotion {
    /// Rigid body that moves under contact, friction and gravity.
    #[default]
    Free,
    /// Object held in place.
    Fixed,
}

/// Motion of an object in the hand after which it counts as dropped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DroppedAfter {
    /// Motion of the point of the object that was at the centre of the grasp, m. None is half of the narrower side of a pad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<Length>,
    /// Turn of the object, degrees.
    #[serde(default = "defaults::dropped_turn_deg")]
    pub turn_deg: Positive,
}

impl Default for DroppedAfter {
    fn default() -> Self {
        Self { distance: None, turn_deg: defaults::DROPPED_TURN_DEG }
    }
}

/// Surface of a mesh that pads feel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ObjectSurface {
    /// The facets with all their edges.
    Faceted,
    /// A smooth surface through the mesh.
    Smooth(SmoothObjectSurface),
}

/// Smooth surface through a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmoothObjectSurface {
    /// Radius with which edges are rounded, m. None is twice the distance of the points of a pad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<Length>,
}

/// Shape, centred on the origin of its frame unless stated otherwise, with its axis along z if it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Shape")]
pub enum ObjectShape {
    /// Closed surface from an OBJ, STL or PLY file, in metres (otherwise use `scale`), in the file's own frame.
    Mesh(PathBuf),
    /// Ball.
    Sphere(Sphere),
    /// Box with edges along x, y, z.
    Cuboid(Cuboid),
    /// Ellipsoid with axes along x, y, z.
    Ellipsoid(Ellipsoid),
    /// Cylinder.
    Cylinder(Cylinder),
    /// Cylinder with half balls on its ends.
    Capsule(Capsule),
    /// Prism over a regular polygon.
    Prism(Prism),
    /// Cylinder with a hole along its axis.
    Annulus(Annulus),
    /// Cylinder with a bottom and no lid.
    Cup(Cup),
    /// Spindle with two nipples, along z.
    Lemon(Lemon),
    /// Rounded cone, along z, tip down.
    Strawberry(Strawberry),
    /// Bulb at -z that narrows to +z.
    Pear(Pear),
    /// Bent spindle in the xz plane.
    Banana(Banana),
    /// Lumpy ellipsoid.
    Potato(Potato),
    /// Profile turned about z.
    Revolve(Revolve),
    /// Tube along a path, with a radius that changes on the way.
    Sweep(Sweep),
}

/// Declares the shapes: strict structs of documented fields.
macro_rules! shapes {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty,)* })*) => {
        $($(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name { $($(#[$field_meta])* pub $field: $type,)* })*
    };
}

shapes! {
    /// Ball.
    Sphere {
        /// Radius, m.
        radius: Length,
    }
    /// Box.
    Cuboid {
        /// Edge lengths along x, y, z, rounding included, m.
        size: Size,
        /// Radius of all edges and corners, m; zero is sharp; at most half the smallest size.
        #[serde(default = "defaults::edge_radius")]
        edge_radius: Depth,
    }
    /// Ellipsoid.
    Ellipsoid {
        /// Half axes along x, y, z, m.
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
        /// Height of the cylindrical part alone, m: the whole is `height + 2 radius` long.
        height: Length,
    }
    /// Prism over a regular polygon.
    Prism {
        /// Number of corners of the polygon.
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
        /// Length along the bend, m.
        #[serde(default = "defaults::banana_length")]
        length: Length,
        /// Largest diameter, m.
        #[serde(default = "defaults::banana_diameter")]
        diameter: Length,
        /// Angle that the arc turns, degrees; 1 to 170.
        #[serde(default = "defaults::banana_bend")]
        bend_deg: Positive,
    }
    /// Potato.
    Potato {
        /// Half axes before the lumps are added, m.
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
        /// Points (r, z) of the profile, m: a line from the axis to the axis (r = 0 at both ends, r > 0 between), or a
        /// loop off it.
        profile: Vec<Vec2>,
        /// Flag of a profile that is a loop (its first point not repeated): the solid is then a ring.
        #[serde(default)]
        closed: bool,
    }
    /// Swept tube.
    Sweep {
        /// Points of the centre line, m.
        path: Vec<Vec3>,
        /// Radius at each point, or one for all, m. Zero at an end makes a tip; otherwise the end is flat.
        radii: Vec<Depth>,
    }
}
