//! Defaults of a scene file, each defined once: serde, `Default` and the documentation use these constants.

use super::axis::HandAxis;
use super::leaf::{Count, Depth, Finite, Fraction, Length, NonNegative, Positive, Ratio, Seconds};
use super::quaternion::QuaternionOrder;
use super::span::Span;
use super::vector::{Direction, Size, Tuple, Vec3};

/// Declares the constants; the name in parentheses is a function of the same value for `#[serde(default = "...")]`.
macro_rules! defaults {
    ($($(#[$doc:meta])* $name:ident $(($function:ident))?: $type:ty = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: $type = $value;
        $(pub(super) const fn $function() -> $type { $name })?)*
    };
}

defaults! {
    /// Object: factor on the lengths of the shape.
    SCALE: Positive = Positive::new_unchecked(1.0);
    /// Object: density, kg/m3.
    OBJECT_DENSITY (object_density): Positive = Positive::new_unchecked(1000.0);
    /// Object: rotation relative to the hand after which it counts as dropped, degrees.
    DROPPED_TURN_DEG (dropped_turn_deg): Positive = Positive::new_unchecked(45.0);
    /// Object: radius of rounded edges, m; zero is sharp.
    EDGE_RADIUS (edge_radius): Depth = Depth::new_unchecked(0.0);
    /// Object: segments of the full circumference of a generated surface.
    SEGMENTS (segments): Count<8, 512> = Count::new_unchecked(64);
    /// Lemon: tip to tip, m.
    LEMON_LENGTH (lemon_length): Length = Length::new_unchecked(0.060);
    /// Lemon: largest diameter, m.
    LEMON_DIAMETER (lemon_diameter): Length = Length::new_unchecked(0.044);
    /// Strawberry: stalk to tip, m.
    STRAWBERRY_LENGTH (strawberry_length): Length = Length::new_unchecked(0.040);
    /// Strawberry: largest diameter, m.
    STRAWBERRY_DIAMETER (strawberry_diameter): Length = Length::new_unchecked(0.034);
    /// Pear: end to end, m.
    PEAR_LENGTH (pear_length): Length = Length::new_unchecked(0.090);
    /// Pear: largest diameter, m.
    PEAR_DIAMETER (pear_diameter): Length = Length::new_unchecked(0.060);
    /// Banana: arc length of the centre line, m.
    BANANA_LENGTH (banana_length): Length = Length::new_unchecked(0.120);
    /// Banana: largest diameter, m.
    BANANA_DIAMETER (banana_diameter): Length = Length::new_unchecked(0.030);
    /// Banana: angle subtended by the arc, degrees.
    BANANA_BEND (banana_bend): Positive = Positive::new_unchecked(70.0);
    /// Potato: semi-axes before the lumps are added, m.
    POTATO_RADII (potato_radii): Size = Size::new_unchecked_size(0.034, 0.026, 0.022);
    /// Potato: height of the lumps as a fraction of the radius.
    POTATO_ROUGHNESS (potato_roughness): NonNegative = NonNegative::new_unchecked(0.06);

    /// Grasp file: order of the components of a quaternion.
    QUATERNION (quaternion): QuaternionOrder = QuaternionOrder::Wxyz;
    /// Grasp file: axis of its hand frame along which the fingers close.
    CLOSING (closing): HandAxis = HandAxis::X;
    /// Grasp file: axis of its hand frame along which the hand approaches.
    APPROACH (approach): HandAxis = HandAxis::Z;

    /// Gripper: distance between the two sensing faces when open, m.
    OPENING: Length = Length::new_unchecked(0.08);
    /// Gripper: largest travel of each finger, m.
    STROKE: Length = Length::new_unchecked(0.04);
    /// Gripper: coefficient of Coulomb friction between pad and object.
    FRICTION: NonNegative = NonNegative::new_unchecked(0.8);
    /// Placement: centre of the pads along the approach (hand z), m.
    PLACEMENT_Z: Finite = Finite::new_unchecked(0.1);
    /// Placement: centre of the pads along the finger width (hand y), m.
    PLACEMENT_Y: Finite = Finite::new_unchecked(0.0);

    /// Gel of a GelSight Mini: node spacing of the sensing face, m, on which the network was trained.
    GELSIGHT_SPACING: Length = Length::new_unchecked(2.6e-3);
    /// Box of gel: node spacing, m.
    PAD_SPACING: Length = Length::new_unchecked(1.5e-3);
    /// Pad: ratio of the thicknesses of successive layers, from the sensing face to the back.
    PAD_GRADING (pad_grading): Ratio = Ratio::new_unchecked(1.0);
    /// Pad: ratio of the cell widths at the rim and at the centre.
    PAD_FOCUS (pad_focus): Ratio = Ratio::new_unchecked(1.0);
    /// Disc pad: node spacing, m.
    DISC_SPACING: Length = Length::new_unchecked(1.0e-3);
    /// Pad file: conversion factor from the unit of the file to metres.
    PAD_SCALE (pad_scale): Positive = Positive::new_unchecked(1.0);
    /// Pad file: outward normal of the sensing face, in the axes of the file.
    PAD_OUTWARD (pad_outward): Vec3 = Vec3::new_unchecked3(0.0, 0.0, 1.0);
    /// Antipodal grasps: largest offset of the pads from the contacts, over half of their length and width.
    GRASP_OFFSET (grasp_offset): NonNegative = NonNegative::new_unchecked(0.0);
    /// Universe: number of objects.
    UNIVERSE_OBJECTS: Count<1, 10000> = Count::new_unchecked(2000);
    /// Universe: number of grasps per object.
    UNIVERSE_GRASPS: Count<1, 1000> = Count::new_unchecked(2);
    /// Universe: number of different sensors.
    UNIVERSE_SENSORS: Count<1, 10000> = Count::new_unchecked(96);
    /// Universe: range of the object width over the pad thickness.
    UNIVERSE_SIZE: Span = Tuple([Positive::new_unchecked(2.5), Positive::new_unchecked(14.0)]);
    /// Universe: range of the coefficient of friction.
    UNIVERSE_FRICTION: Span = Tuple([Positive::new_unchecked(0.2), Positive::new_unchecked(1.2)]);
    /// Universe: range of Poisson's ratio.
    UNIVERSE_POISSON: Span = Tuple([Positive::new_unchecked(0.3), Positive::new_unchecked(0.495)]);
    /// Universe: range of the final force per finger over E t^2.
    UNIVERSE_FORCE: Span = Tuple([Positive::new_unchecked(0.4), Positive::new_unchecked(1.2)]);
    /// Universe: range of the force per finger over E t^2 at which objects are released.
    UNIVERSE_RELEASE: Span = Tuple([Positive::new_unchecked(0.02), Positive::new_unchecked(0.4)]);
    /// Universe: fraction of the objects grasped perpendicular to faces or axes.
    UNIVERSE_SQUARE: NonNegative = NonNegative::new_unchecked(0.4);
    /// Universe: largest offset of the pads from the contacts, over half of their length and width.
    UNIVERSE_OFFSET: NonNegative = NonNegative::new_unchecked(0.9);
    /// Universe: fraction of the objects with weight.
    UNIVERSE_HEAVY: NonNegative = NonNegative::new_unchecked(0.4);
    /// Universe: largest weight over the final sum of the finger forces.
    UNIVERSE_WEIGHT: Positive = Positive::new_unchecked(0.5);
    /// Universe: fraction of the objects that are pushed.
    UNIVERSE_PUSHED: NonNegative = NonNegative::new_unchecked(0.5);
    /// Universe: largest push over the friction limit.
    UNIVERSE_PUSH: Span = Tuple([Positive::new_unchecked(0.04), Positive::new_unchecked(0.8)]);
    /// Universe: fraction of the objects pressed by one finger.
    UNIVERSE_SINGLE: NonNegative = NonNegative::new_unchecked(0.08);
    /// Universe: range of the pad length along the approach, m.
    UNIVERSE_PAD_LENGTH: Span = Tuple([Positive::new_unchecked(0.015), Positive::new_unchecked(0.035)]);
    /// Universe: range of the pad width, m.
    UNIVERSE_PAD_WIDTH: Span = Tuple([Positive::new_unchecked(0.012), Positive::new_unchecked(0.03)]);
    /// Universe: range of the pad thickness, m.
    UNIVERSE_PAD_THICKNESS: Span = Tuple([Positive::new_unchecked(0.002), Positive::new_unchecked(0.008)]);
    /// Universe: range of the number of cells of the sensing face.
    UNIVERSE_PAD_CELLS: Span = Tuple([Positive::new_unchecked(60.0), Positive::new_unchecked(160.0)]);
    /// Universe: fraction of the objects with round pads.
    UNIVERSE_PAD_ROUND: NonNegative = NonNegative::new_unchecked(0.15);
    /// Universe: fraction of the objects with domed pads.
    UNIVERSE_PAD_DOMED: NonNegative = NonNegative::new_unchecked(0.15);

    /// Soft material: density, kg/m3.
    GEL_DENSITY (gel_density): Positive = Positive::new_unchecked(1000.0);

    /// Data sets: fraction of the grasps of each object that is held out for the test set.
    SPLIT_TEST: Fraction = Fraction::new_unchecked(0.2);
    /// Sampled grasps: largest angle between the closing axis and the surface normals, degrees, unless the friction
    /// cone is narrower.
    TILT (tilt): Positive = Positive::new_unchecked(15.0);

    /// Loading: number of recorded frames.
    FRAMES (frames): Count<1, 10000> = Count::new_unchecked(50);

    /// Push: force, N, and torque, N m.
    PUSH (push): Vec3 = Vec3::new_unchecked3(0.0, 0.0, 0.0);
    /// Push: number of recorded frames.
    PUSH_FRAMES (push_frames): Count<1, 10000> = Count::new_unchecked(10);

    /// Dynamic: time step, s.
    TIME_STEP (time_step): Seconds = Seconds::new_unchecked(1e-3);
    /// Dynamic: ratio of viscosity to stiffness of the gel, s.
    DAMPING (damping): NonNegative = NonNegative::new_unchecked(0.0);
    /// Dynamic: speed of a finger that closes without contact, m/s (twice that of a finger of the Franka hand).
    CLOSING_SPEED (closing_speed): Positive = Positive::new_unchecked(0.1);
    /// Ground: outward normal.
    GROUND_NORMAL: Direction = Direction::new_unchecked3(0.0, 0.0, 1.0);
    /// Ground: coefficient of Coulomb friction between ground and object.
    GROUND_FRICTION: NonNegative = NonNegative::new_unchecked(0.8);

    /// Task: range of the sum of the finger forces, N.
    TASK_FORCE: Span = Tuple([Positive::new_unchecked(1.0), Positive::new_unchecked(15.0)]);
    /// Task: sum of the finger forces at the start, N.
    TASK_START: Positive = Positive::new_unchecked(4.0);
    /// Task: number of steps of an episode.
    TASK_STEPS: Count<1, 10000> = Count::new_unchecked(30);
    /// Task: number of steps in which the support is withdrawn.
    TASK_LIFT: Count<1, 10000> = Count::new_unchecked(5);
    /// Task: accumulated slip on the pads above which the object counts as lost, m.
    TASK_SLIP_LIMIT: Length = Length::new_unchecked(2e-3);
    /// Task: number of pairs of Young's modulus and friction prepared per object.
    TASK_VARIANTS: Count<1, 1000> = Count::new_unchecked(1);
    /// Task: largest displacement of the hand, m.
    TASK_SHIFT: Depth = Depth::new_unchecked(0.0);
    /// Task: largest rotation of the hand, degrees.
    TASK_TURN: NonNegative = NonNegative::new_unchecked(0.0);

    /// Markers: number along the long side of the pad.
    MARKER_ROWS: Count<1, 512> = Count::new_unchecked(9);
    /// Markers: number along the short side of the pad.
    MARKER_COLS: Count<1, 512> = Count::new_unchecked(7);
    /// Markers: size of a camera pixel on the face, m: that of a GelSight Mini at 320 x 240.
    MARKER_PIXEL: Length = Length::new_unchecked(63.4e-6);

    /// FEM: mean dilatation within each element (no volumetric locking).
    MEAN_DILATATION: bool = true;
    /// FEM: residual force over the force of the loading at which an increment counts as converged.
    FORCE_TOLERANCE: Positive = Positive::new_unchecked(2e-4);
    /// FEM: tolerance of the path error, over the displacement.
    PATH: Positive = Positive::new_unchecked(0.01);
    /// Condensed FEM: relative change of the displacement by one more correction with the full pad model.
    CONDENSED_ERROR: Positive = Positive::new_unchecked(0.01);
    /// FEM: largest number of Newton iterations before an increment is halved.
    MAX_ITERATIONS: Count<1, 10000> = Count::new_unchecked(40);
}
