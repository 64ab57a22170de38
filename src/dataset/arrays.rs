//! Arrays of an object's file with one row per grasp: names, shapes, types, units.

use base::error::Result;
use model::Model;
use model::sensors::ArraySpec;
use record::names;

/// Version of the layout; a reader rejects other versions.
pub const FORMAT: u64 = 3;

/// Type of the numbers, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberKind {
    /// Unsigned byte.
    U8,
    /// Unsigned 32-bit integer.
    U32,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

impl NumberKind {
    /// Returns the size of a number, bytes.
    pub fn size(self) -> usize {
        match self {
            NumberKind::U8 => 1,
            NumberKind::U32 | NumberKind::F32 => 4,
            NumberKind::F64 => 8,
        }
    }
}

/// Numbers that determine all shapes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileSizes {
    /// Number of grasps of the object.
    pub grasps: usize,
    /// Number of frames of a grasp.
    pub frames: usize,
    /// Number of pads.
    pub pads: usize,
    /// Number of nodes of a pad, mid-edge nodes included. If the pads differ, it is that of the larger one, and rows of
    /// the other are padded with zeros.
    pub nodes: usize,
    /// Number of corner nodes of all pads; in each pad they precede the mid-edge nodes.
    pub corners: usize,
    /// Number of tetrahedra of all pads.
    pub tets: usize,
    /// Arrays of tactile sensors.
    pub tactile: Vec<TactileLayout>,
}

/// Layout of an array of tactile sensors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TactileLayout {
    /// Name of the dataset.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Shape in a frame, pads first.
    pub shape: Vec<usize>,
}

impl TactileLayout {
    fn of(spec: ArraySpec) -> Self {
        Self { name: spec.file_name(), unit: spec.unit, shape: spec.shape }
    }
}

impl FileSizes {
    /// Returns the sizes for `grasps` grasps of `model`.
    ///
    /// # Errors
    /// Fails for a scene without fingers, because a data set describes the states of pads.
    pub fn of(model: &Model, grasps: usize) -> Result<Self> {
        model.finger()?;
        let pads = || model.fingers.iter().map(|finger| &finger.topology);
        Ok(Self {
            grasps,
            frames: model.levels.len(),
            pads: model.fingers.len(),
            nodes: pads().map(|pad| pad.rest.len()).max().unwrap_or(0),
            corners: pads().map(|pad| pad.corner_count).sum(),
            tets: pads().map(|pad| pad.elements.len()).sum(),
            tactile: model.sensors.iter().map(|sense| TactileLayout::of(sense.spec())).collect(),
        })
    }

    /// Returns the size of all rows of all grasps, bytes.
    pub fn bytes(&self) -> u64 {
        self.rows().map(|row| self.grasps as u64 * row.bytes() as u64).sum()
    }

    /// Returns the layouts of all rows of a grasp, in the order of the file: those of [`ARRAYS`], then those of tactile
    /// sensors.
    pub fn rows(&self) -> impl Iterator<Item = RowLayout<'_>> {
        let fixed = ARRAYS.iter().map(|array| RowLayout {
            name: array.name,
            kind: array.kind,
            shape: array.row_shape(self),
            unit: array.unit,
            about: array.about,
        });
        let tactile = self.tactile.iter().map(|array| RowLayout {
            name: &array.name,
            kind: NumberKind::F32,
            shape: [&[self.frames], array.shape.as_slice()].concat(),
            unit: &array.unit,
            about: "of tactile sensors, pad frame: docs/data-format.md",
        });
        fixed.chain(tactile)
    }
}

/// Layout of the row of a grasp in an array of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct RowLayout<'a> {
    /// Name of the dataset.
    pub name: &'a str,
    /// Type of the numbers.
    pub kind: NumberKind,
    /// Shape of the row.
    pub shape: Vec<usize>,
    /// Unit of the numbers.
    pub unit: &'a str,
    /// Description of the content.
    pub about: &'a str,
}

impl RowLayout<'_> {
    /// Returns the size of the row, bytes.
    pub fn bytes(&self) -> usize {
        self.shape.iter().product::<usize>() * self.kind.size()
    }
}

/// Layout of an array that every file has, with one row per grasp.
#[derive(Debug, Clone, Copy)]
pub struct ArrayLayout {
    /// Name of the dataset.
    pub name: &'static str,
    /// Type of the numbers.
    pub kind: NumberKind,
    /// Function that returns the shape of a row.
    shape: fn(&FileSizes) -> Vec<usize>,
    /// Unit of the numbers.
    pub unit: &'static str,
    /// Description of the content.
    pub about: &'static str,
}

impl ArrayLayout {
    /// Returns the shape of a row.
    pub fn row_shape(&self, sizes: &FileSizes) -> Vec<usize> {
        (self.shape)(sizes)
    }
    /// Returns the size of a row, bytes.
    pub fn row_bytes(&self, sizes: &FileSizes) -> usize {
        self.row_shape(sizes).iter().product::<usize>() * self.kind.size()
    }
}

/// Largest stored length of a reason, bytes.
pub const MAX_REASON_BYTES: usize = 256;

macro_rules! arrays {
    ($($row:ident $name:tt $kind:ident $sizes:ident $shape:tt $unit:literal $about:literal;)*) => {
        /// Arrays by name; `row as usize` is the index in [`ARRAYS`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum RowName {
            $(#[doc = $about] $row,)*
        }

        /// Arrays with one row per grasp that every file has, in the order of the file.
        pub const ARRAYS: &[ArrayLayout] = &[$(ArrayLayout {
            name: $name,
            kind: NumberKind::$kind,
            #[allow(unused_variables)]
            shape: |$sizes| arrays!(@shape $shape),
            unit: $unit,
            about: $about,
        },)*];
    };
    (@shape [$($n:expr),*]) => { vec![$($n),*] };
}

arrays! {
    StackedForces "_1_stacked_forces"       F32 s [s.frames] "N" "force of DefGraspSim: sum over the fingers of |normal force|; zero for a grasp that did not reach its load";
    StackedPositions "_1_stacked_positions"    F32 s [s.frames, s.corners, 3] "m" "corner nodes, left pad first, loader's world (Y up)";
    StackedStresses "_1_stacked_stresses"     F32 s [s.frames, s.tets] "Pa" "von Mises stress of the tetrahedra, left pad first";
    StackedObjectFrame "_1_stacked_object_frame" F32 s [s.frames, 4, 4] "1, m" "object frame to loader's world, homogeneous";
    Displacement (names::DISPLACEMENT) F32 s [s.frames, s.pads, s.nodes, 3] "m" "of every node against the pad carried rigidly by its finger, pad frame";
    ContactForce (names::CONTACT_FORCE) F32 s [s.frames, s.pads, s.nodes, 3] "N" "on the pad, per node, friction included, pad frame";
    VonMises (names::VON_MISES) F32 s [s.frames, s.pads, s.nodes] "Pa" "per node: volume-weighted mean of the tetrahedra at the node";
    Force (names::FORCE) F64 s [s.frames] "N" "applied force: sum over the fingers of |normal force|";
    Travel (names::TRAVEL) F64 s [s.frames, s.pads] "m" "closing travel of each finger since first contact";
    FingerPosition (names::FINGER_POSITION) F64 s [s.frames, s.pads] "m" "closing travel of each finger since the open hand";
    ObjectPose (names::OBJECT_POSE) F64 s [s.frames, 7] "m, 1" "px py pz qw qx qy qz: x_hand = R(q) x_object + p";
    ObjectLoad (names::OBJECT_LOAD) F64 s [s.frames, 6] "N, N m" "weight and push on the object: force and torque about its centre of mass, hand frame";
    Wrench (names::WRENCH) F64 s [s.frames, s.pads, 6] "N, N m" "force and torque of the contact on each pad about the origin of its pad frame, pad axes";
    Energy (names::ENERGY) F64 s [s.frames] "J" "value of the incremental potential";
    Residual (names::RESIDUAL) F64 s [s.frames] "N" "norm of the out-of-balance nodal forces";
    ForceBalance (names::FORCE_BALANCE) F64 s [s.frames] "1" "unbalanced force over applied force";
    TorqueBalance (names::TORQUE_BALANCE) F64 s [s.frames] "1" "unbalanced torque over applied force times object size";
    MinDetF (names::MIN_DET_F) F64 s [s.frames] "1" "smallest det F in any element";
    MinGap (names::MIN_GAP) F64 s [s.frames] "m" "smallest gap between pads and object";
    NewtonIterations (names::NEWTON_ITERATIONS) U32 s [s.frames] "1" "Newton iterations of the frame";
    Pose (names::GRASP_POSE) F64 s [7] "m, 1" "px py pz qw qx qy qz of the hand in the object frame: x_object = R(q) x_hand + p";
    RecordedFrames "recorded_frames" U32 s [] "1" "number of valid frames of the grasp, which come first";
    Status "status"         U8  s [] "1" "0 not simulated, 1 reached, 2 fault, 3 infeasible, 4 dropped";
    Reason "reason"         U8  s [MAX_REASON_BYTES] "text" "why the grasp was not reached, UTF-8, padded with zeros";
    Checksum "checksum"       U8  s [32] "1" "BLAKE3 of the grasp's rows of all other arrays, in the order of the file";
}
