//! The rigid object.

use super::defaults;
use super::leaf::{Count, Depth, Length, NonNegative, Positive};
use super::vector::{Size, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The rigid object: shape, weight and whether it may move.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Its shape, in the object frame.
    pub shape: ObjectShape,
    /// Factor on all lengths of the shape.
    #[serde(default = "defaults::scale")]
    pub scale: Positive,
    /// Mends the surface of a file that bounds no solid: welds, fills holes, and else samples its winding number anew.
    #[serde(default)]
    pub repair: bool,
    /// kg/m3.
    #[serde(default = "defaults::object_density")]
    pub density: Positive,
    /// Divisions of a full turn of a generated round surface: what is drawn and written, and the contact geometry where the
    /// shape has no closed form.
    #[serde(default = "defaults::segments")]
    pub segments: Count<8, 512>,
    /// Whether it may move.
    #[serde(default)]
    pub motion: ObjectMotion,
    /// Velocity of its centre of mass at the start of a dynamic scene, world axes, m/s.
    #[serde(default)]
    pub velocity: Option<Vec3>,
    /// Angular velocity at the start of a dynamic scene, world axes, rad/s.
    #[serde(default)]
    pub spin: Option<Vec3>,
}

/// Whether the object may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename = "Motion")]
pub enum ObjectMotion {
    /// Moves as a rigid body under contact, friction and gravity.
    #[default]
    Free,
    /// Held in place.
    Fixed,
}

/// A shape, centred on its frame's origin unless said otherwise, its axis along z where it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Shape")]
pub enum ObjectShape {
    /// A closed surface from an OBJ, STL or PLY file, in metres (else use `scale`), in the file's own frame.
    Mesh(PathBuf),
    /// A ball.
    Sphere(Sphere),
    /// A box with edges along x, y, z.
    Cuboid(Cuboid),
    /// An ellipsoid with axes along x, y, z.
    Ellipsoid(Ellipsoid),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A cylinder with half balls on its ends.
    Capsule(Capsule),
    /// A prism over a regular polygon.
    Prism(Prism),
    /// A cylinder with a hole along its axis.
    Annulus(Annulus),
    /// A cylinder with a bottom and no lid.
    Cup(Cup),
    /// A spindle with two nipples, along z.
    Lemon(Lemon),
    /// A rounded cone, along z, tip down.
    Strawberry(Strawberry),
    /// A bulb at -z that narrows to +z.
    Pear(Pear),
    /// A bent spindle in the xz plane.
    Banana(Banana),
    /// A lumpy ellipsoid.
    Potato(Potato),
    /// A profile turned about z.
    Revolve(Revolve),
    /// A tube about a path, its radius changing on the way.
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
    /// A ball.
    Sphere {
        /// m.
        radius: Length,
    }
    /// A box.
    Cuboid {
        /// Edge lengths along x, y, z, rounding included, m.
        size: Size,
        /// Radius of all edges and corners, m; zero is sharp; at most half the smallest size.
        #[serde(default = "defaults::edge_radius")]
        edge_radius: Depth,
    }
    /// An ellipsoid.
    Ellipsoid {
        /// Half axes along x, y, z, m.
        radii: Size,
    }
    /// A cylinder with sharp rims.
    Cylinder {
        /// m.
        radius: Length,
        /// Along z, m.
        height: Length,
    }
    /// A capsule.
    Capsule {
        /// m.
        radius: Length,
        /// Of the cylindrical part alone, m: the whole is `height + 2 radius` long.
        height: Length,
    }
    /// A prism over a regular polygon.
    Prism {
        /// Corners of the polygon.
        sides: Count<3, 100>,
        /// From the axis to a corner, m.
        radius: Length,
        /// Along z, m.
        height: Length,
    }
    /// A cylinder with a hole.
    Annulus {
        /// Outer radius, m.
        outer: Length,
        /// Radius of the hole, m.
        inner: Length,
        /// Along z, m.
        height: Length,
    }
    /// A cup, open at the top (+z).
    Cup {
        /// Outer radius, m.
        radius: Length,
        /// Along z, m.
        height: Length,
        /// Thickness of wall and bottom, m.
        wall: Length,
    }
    /// A lemon.
    Lemon {
        /// Tip to tip, m.
        #[serde(default = "defaults::lemon_length")]
        length: Length,
        /// Largest, m.
        #[serde(default = "defaults::lemon_diameter")]
        diameter: Length,
    }
    /// A strawberry.
    Strawberry {
        /// Stalk to tip, m.
        #[serde(default = "defaults::strawberry_length")]
        length: Length,
        /// Largest, m.
        #[serde(default = "defaults::strawberry_diameter")]
        diameter: Length,
    }
    /// A pear.
    Pear {
        /// End to end, m.
        #[serde(default = "defaults::pear_length")]
        length: Length,
        /// Largest, m.
        #[serde(default = "defaults::pear_diameter")]
        diameter: Length,
    }
    /// A banana.
    Banana {
        /// Along its bend, m.
        #[serde(default = "defaults::banana_length")]
        length: Length,
        /// Largest, m.
        #[serde(default = "defaults::banana_diameter")]
        diameter: Length,
        /// Angle that its arc turns, degrees; 1 to 170.
        #[serde(default = "defaults::banana_bend")]
        bend_deg: Positive,
    }
    /// A potato.
    Potato {
        /// Half axes before it is made lumpy, m.
        #[serde(default = "defaults::potato_radii")]
        radii: Size,
        /// Height of its lumps as a fraction of its radius; at most 0.3.
        #[serde(default = "defaults::potato_roughness")]
        roughness: NonNegative,
        /// Which potato: the same seed gives the same one.
        #[serde(default)]
        seed: u64,
    }
    /// A solid of revolution.
    Revolve {
        /// Points (r, z), m: a line from the axis to the axis (r = 0 at both ends, r > 0 between), or a loop off it.
        profile: Vec<Vec2>,
        /// The profile is a loop (its first point not repeated): the solid is a ring.
        #[serde(default)]
        closed: bool,
    }
    /// A swept tube.
    Sweep {
        /// Points of the centre line, m.
        path: Vec<Vec3>,
        /// Radius at each point, or one for all, m. Zero at an end makes a tip, else the end is flat.
        radii: Vec<Depth>,
    }
}
