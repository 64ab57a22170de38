//! HDF5 file of one object: created at its full size with empty rows, then filled row by row.
//!
//! The arrays are contiguous and uncompressed. The position of a row is fixed before its content is known, so a grasp
//! is written by seeking to it. Memory holds one grasp per thread regardless of the number of grasps, and the speed of
//! reading is that of the disk.

use super::arrays::{FORMAT, FileSizes, NumberKind, RowName};
use super::progress::FinishedGrasp;
use super::row_positions::{RemainderChecksum, RowPositions, is_row_verified};
use super::rows::{GraspRows, checksum, code};
use base::error::{Error, Result};
use base::files::atomic::{cannot_write, replace_durable};
use glam::{DQuat, DVec3};
use hdf5_pure::{AttrValue, Datatype, File, FileBuilder, GroupBuilder};
use model::Model;
use model::part::FingerModel;
use record::{PadTopology, names};
use scene::{NamedScene, to_ron};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Attribute of a file with the names of its arrays of tactile sensors, in their order.
pub const TACTILE: &str = "tactile";

/// Creates the file of an object at `path` with empty rows, atomically.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn create(path: &Path, named: &NamedScene, model: &Model, sizes: &FileSizes, mirrored: bool) -> Result<()> {
    let scene = to_ron(&named.scene)?;
    replace_durable(path, |temporary| {
        let mut builder = FileBuilder::new();
        attributes(&mut builder, named, model, &scene, mirrored);
        fixed(&mut builder, model);
        let tactile: Vec<&str> = sizes.tactile.iter().map(|array| array.name.as_str()).collect();
        if !tactile.is_empty() {
            builder.set_attr(TACTILE, text(&tactile.join(",")));
        }
        for array in sizes.rows() {
            let bytes = sizes.grasps * array.bytes();
            let shape: Vec<u64> = std::iter::once(sizes.grasps).chain(array.shape).map(|n| n as u64).collect();
            // Zeroed memory from the operating system is not allocated until it is written, and this is never written.
            builder
                .create_dataset(array.name)
                .with_raw_data(datatype(array.kind), vec![0; bytes], shape.iter().product())
                .with_shape(&shape)
                .set_attr("unit", text(array.unit))
                .set_attr("about", text(array.about));
        }
        let file = std::fs::File::create(temporary)?;
        let mut sparse = Sparse { file, length: 0 };
        builder.finish_to(&mut sparse).map_err(std::io::Error::other)?;
        sparse.file.set_len(sparse.length)
    })
}

fn datatype(kind: NumberKind) -> Datatype {
    match kind {
        NumberKind::U8 => hdf5_pure::make_u8_type(),
        NumberKind::U32 => hdf5_pure::make_u32_type(),
        NumberKind::F32 => hdf5_pure::make_f32_type(),
        NumberKind::F64 => hdf5_pure::make_f64_type(),
    }
}

fn text(text: &str) -> AttrValue {
    AttrValue::String(text.into())
}

fn attributes(builder: &mut FileBuilder, named: &NamedScene, model: &Model, scene: &str, mirrored: bool) {
    let spec = named.scene.gripper.material.spec();
    builder.set_attr("format", AttrValue::U64(FORMAT));
    for (name, value) in [
        ("tactus", env!("CARGO_PKG_VERSION")),
        ("object", named.name.as_str()),
        ("scene", scene),
        ("element", &model.fingers[0].element),
        ("law", &format!("{:?}", spec.law)),
        ("units", "SI: m, N, Pa, kg, s; quaternions (w, x, y, z)"),
        ("hand_frame", "origin at the hand base, +z approach, fingers close along x, y finger width; right-handed"),
        ("pad_frame", "origin at the centre of the sensing face, +z out of the gel, x along the approach"),
        ("force_convention", "sum over the fingers of |normal force|: 15 N is 7.5 N per pad"),
        ("loader_world", "hand (x, y, z) is (y, z, x) + offset, Y up; left pad first; frames are levels of the load"),
        (
            "loader_right_pad",
            if mirrored {
                "node and tetrahedron i of the right pad mirror those of the left along pad x"
            } else {
                "the right pad is not the mirror image of the left one: the loader's undeformed shape of it is wrong"
            },
        ),
    ] {
        builder.set_attr(name, text(value));
    }
    for (name, value) in [
        ("young_pa", spec.young),
        ("poisson", spec.poisson),
        ("gel_density_kg_m3", model.fingers[0].gel_density),
        ("friction", named.scene.gripper.friction.get()),
        ("object_mass_kg", model.mass),
        ("opening_m", model.opening),
    ] {
        builder.set_attr(name, AttrValue::F64(value));
    }
    let gravity = model.gravity.unwrap_or_default().to_array();
    builder.set_attr("gravity_m_s2", AttrValue::F64Array(gravity.to_vec()));
}

/// Adds the content that is the same for all grasps: pads and object.
fn fixed(builder: &mut FileBuilder, model: &Model) {
    let [left, right] = names::PADS;
    let mut group = builder.create_group(left);
    topology(&mut group, &model.fingers[0].topology);
    let pose = |f: &FingerModel| {
        let (p, q) = (f.placement.origin, DQuat::from_mat3(&f.placement.rotation));
        [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
    };
    let poses: Vec<f64> = model.fingers.iter().flat_map(pose).collect();
    let about = "px py pz qw qx qy qz of each pad at zero travel: x_hand = R(q) x_pad + p";
    doubles(&mut group, names::PAD_POSE, "m, 1", about, 7, &poses);
    let closing: Vec<_> = model.fingers.iter().map(|f| f.placement.closing).collect();
    doubles(&mut group, names::CLOSING, "1", "closing direction of each finger, hand frame", 3, &flat(&closing));
    builder.add_group(group.finish());
    if let [one, other] = model.fingers.as_slice()
        && one.topology != other.topology
    {
        let mut group = builder.create_group(right);
        topology(&mut group, &other.topology);
        builder.add_group(group.finish());
    }

    let surface = &model.object.surface;
    let mut group = builder.create_group("object");
    doubles(&mut group, names::VERTICES, "m", "surface of the object, object frame", 3, &flat(&surface.vertices));
    integers(&mut group, names::TRIANGLES, "triangles of the object, outward", 3, surface.triangles.as_flattened());
    builder.add_group(group.finish());
}

fn flat(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.to_array()).collect()
}

/// Adds the mesh of a pad.
fn topology(group: &mut GroupBuilder, pad: &PadTopology) {
    let about = "rest positions of the nodes of a pad, pad frame; corners first";
    doubles(group, names::REST, "m", about, 3, &flat(&pad.rest));
    let about = "nodes of each tetrahedron: 4 corners, then the middles of (0,1) (1,2) (2,0) (0,3) (1,3) (2,3)";
    integers(group, names::TETS, about, pad.elements.width(), pad.elements.nodes());
    integers(group, names::SURFACE, "corner triangles of the whole surface, outward", 3, pad.surface.as_flattened());
    integers(group, names::SENSING, "triangles of the sensing face, outward", 3, pad.sensing.as_flattened());
    let bonded: Vec<u8> = pad.bonded.iter().map(|b| u8::from(*b)).collect();
    let dataset = group.create_dataset(names::BONDED).with_u8_data(&bonded);
    dataset.set_attr("unit", text("1")).set_attr("about", text("1 where the node is bonded to the finger"));
}

fn doubles(group: &mut GroupBuilder, name: &str, unit: &str, about: &str, width: usize, values: &[f64]) {
    let shape = [(values.len() / width) as u64, width as u64];
    let dataset = group.create_dataset(name).with_f64_data(values).with_shape(&shape);
    dataset.set_attr("unit", text(unit)).set_attr("about", text(about));
}

fn integers(group: &mut GroupBuilder, name: &str, about: &str, width: usize, values: &[u32]) {
    let shape = [(values.len() / width) as u64, width as u64];
    let dataset = group.create_dataset(name).with_u32_data(values).with_shape(&shape);
    dataset.set_attr("unit", text("1")).set_attr("about", text(about));
}

/// Writer of a sparse file: it leaves holes in place of zeros.
struct Sparse {
    file: std::fs::File,
    length: u64,
}

impl Write for Sparse {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if bytes.len() >= 4096 && bytes.iter().all(|b| *b == 0) {
            self.file.seek(SeekFrom::Current(bytes.len() as i64))?;
        } else {
            self.file.write_all(bytes)?;
        }
        self.length += bytes.len() as u64;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

/// Writer of rows into an existing file.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    places: RowPositions,
}

impl Writer {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// Fails if the file cannot be read or has another layout.
    pub fn open(path: &Path, sizes: &FileSizes) -> Result<Self> {
        let file = File::open_streaming(path).map_err(|e| Error::file(path, e.to_string()))?;
        Ok(Self { path: path.to_path_buf(), places: RowPositions::find(path, &file, sizes)? })
    }

    /// Returns the BLAKE3 of the layout: the file without any rows.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn layout(&self) -> Result<String> {
        Ok(RemainderChecksum::of(&self.path, self.places.ranges(|_| true))?.blake3)
    }

    /// Returns true if the rows of a grasp agree with its `record`.
    pub fn rows_match(&self, record: &FinishedGrasp) -> bool {
        let rows = std::fs::File::open(&self.path).and_then(|mut file| self.places.read(&mut file, record.grasp));
        rows.is_ok_and(|rows| {
            let row = |name: RowName| rows[name as usize].as_slice();
            let sum = checksum(&rows);
            sum.as_bytes() == row(RowName::Checksum)
                && sum.to_hex().as_str() == record.checksum
                && row(RowName::Status) == [code(record.status)]
                && row(RowName::RecordedFrames) == (record.frames as u32).to_le_bytes()
        })
    }

    /// Returns the seal, which covers everything that the checksums of the grasps do not cover.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn remainder_checksum(&self) -> Result<RemainderChecksum> {
        RemainderChecksum::of(&self.path, self.places.ranges(is_row_verified))
    }

    /// Writes the rows of a grasp and waits until they are on disk.
    ///
    /// # Errors
    /// Fails if the file cannot be opened or written.
    pub fn write(&self, grasp: usize, rows: &GraspRows) -> Result<()> {
        let write = || {
            // Each call opens its own handle, because several grasps may end at the same time.
            let mut file = std::fs::OpenOptions::new().write(true).open(&self.path)?;
            for (array, row) in rows.0.iter().enumerate() {
                file.seek(SeekFrom::Start(self.places.row(array, grasp).0))?;
                file.write_all(row)?;
            }
            file.sync_data()
        };
        write().map_err(|e| cannot_write(&self.path, &e))
    }
}
