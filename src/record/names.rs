//! Names of the recorded quantities, shared by `arrays.npz`, `.vtu`, `frames.csv`, data sets and Python. A name ends in
//! its unit if it has a single unit; shapes, frames and files are in `docs/data-format.md`.

/// Groups of the constant arrays of the left pad, and of the right pad if it differs.
pub const PADS: [&str; 2] = ["pad", "right_pad"];

/// Declares names with their units.
macro_rules! names {
    ($($(#[$doc:meta])* $name:ident $text:literal $unit:literal;)*) => {
        $($(#[$doc])* pub const $name: &str = $text;)*

        /// All names with their units: "1" for a dimensionless quantity, units separated by commas for a mixed
        /// quantity.
        pub const ALL: &[(&str, &str)] = &[$(($text, $unit),)*];
    };
}

names! {
    /// Node positions.
    POSITION "position_m" "m";
    /// Node displacements relative to the pad carried rigidly by its finger.
    DISPLACEMENT "displacement_m" "m";
    /// Nodal contact force on the pad, friction included.
    CONTACT_FORCE "contact_force_n" "N";
    /// Von Mises stress per node: volume-weighted mean of the tetrahedra at the node.
    VON_MISES "von_mises_pa" "Pa";
    /// Von Mises stress per tetrahedron.
    ELEMENT_VON_MISES "element_von_mises_pa" "Pa";
    /// Signed distance of each node to the object.
    GAP "gap_m" "m";
    /// Applied force: sum over the fingers of |normal force|.
    FORCE "force_n" "N";
    /// Time of a dynamic scene.
    TIME "time_s" "s";
    /// Closing travel of each finger since first contact.
    TRAVEL "travel_m" "m";
    /// Closing travel of each finger from the open hand.
    FINGER_POSITION "finger_position_m" "m";
    /// Pose of the object: px py pz qw qx qy qz.
    OBJECT_POSE "object_pose" "m, 1";
    /// External load on the object (weight and applied push): force and torque about its centre of mass, hand frame.
    OBJECT_LOAD "object_load" "N, N m";
    /// Pose of each pad at zero travel: px py pz qw qx qy qz.
    PAD_POSE "pad_pose" "m, 1";
    /// Pose of the hand in the world: px py pz qw qx qy qz.
    HAND_POSE "hand_pose" "m, 1";
    /// Pose of the hand in the object frame: px py pz qw qx qy qz.
    GRASP_POSE "grasp_pose" "m, 1";
    /// Linear and angular velocity of the object.
    OBJECT_MOTION "object_motion" "m/s, rad/s";
    /// Force of the ground on the object.
    GROUND_FORCE "ground_force_n" "N";
    /// Contact force and torque on each pad.
    WRENCH "wrench" "N, N m";
    /// Smallest remaining fraction, over the loads of a grasp, of the load at which the object slips; negative if it does.
    SLIP_MARGIN "slip_margin" "1";
    /// Lower end of the 90 % interval of the slip margin; -inf if unknown.
    SLIP_MARGIN_LOW "slip_margin_low" "1";
    /// Upper end of the 90 % interval of the slip margin; inf if unknown.
    SLIP_MARGIN_HIGH "slip_margin_high" "1";
    /// Value of the incremental potential.
    ENERGY "energy_j" "J";
    /// Norm of the unbalanced nodal forces.
    RESIDUAL "residual_n" "N";
    /// Unbalanced force over applied force.
    FORCE_BALANCE "force_balance" "1";
    /// Unbalanced torque over applied force times object size.
    TORQUE_BALANCE "torque_balance" "1";
    /// Smallest det F over all elements.
    MIN_DET_F "min_det_f" "1";
    /// Smallest gap between the object and pads or ground.
    MIN_GAP "min_gap_m" "m";
    /// Number of Newton iterations of the frame.
    NEWTON_ITERATIONS "newton_iterations" "1";
    /// Reference positions of the nodes.
    REST "rest_m" "m";
    /// Nodes of each tetrahedron.
    TETS "tets" "1";
    /// Triangles of the outer surface of a pad.
    SURFACE "surface" "1";
    /// Triangles of the sensing faces.
    SENSING "sensing" "1";
    /// Flag per node: bonded to the finger.
    BONDED "bonded" "1";
    /// Index of the pad of each node.
    PAD_OF_NODE "pad_of_node" "1";
    /// Index of the pad of each tetrahedron.
    PAD_OF_TET "pad_of_tet" "1";
    /// Closing direction of each finger.
    CLOSING "closing" "1";
    /// Vertices of the object surface.
    VERTICES "vertices_m" "m";
    /// Triangles of the object surface.
    TRIANGLES "triangles" "1";
}
