//! Reader of the file of one object, one grasp at a time: only requested data is held in memory.

use super::arrays::{ARRAYS, FORMAT, FileSizes, RowName, TactileLayout};
use super::file::TACTILE;
use super::row_positions::RowPositions;
use super::rows::checksum;
use base::error::{Error, Result};
use base::number::format_count;
use geometry::Pose;
use geometry::mesh::TriMesh;
use glam::DVec3;
use hdf5_pure::{AttrValue, File, Layout};
use record::{ElementNodes, PadTopology, TactileArray, names};
use scene::{from_ron, locate_error_in};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// File of one object.
#[derive(Debug)]
pub struct ObjectFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Name of the object.
    pub name: String,
    /// Sizes that determine all shapes.
    pub sizes: FileSizes,
    /// Scene with all defaults, RON, from which [`model::Model::build`] builds the same model.
    pub scene: String,
    /// Meshes of the pads, left first, pad frame: reference positions, tetrahedra, faces.
    pub pads: Vec<PadTopology>,
    /// Pose of each pad in the hand at zero travel: `x_hand = rotation * x_pad + position`.
    pub pad_poses: Vec<Pose>,
    /// Closing direction of each finger, hand frame.
    pub closing: Vec<DVec3>,
    /// Surface of the object, object frame, m.
    pub object: TriMesh,
    /// Status per grasp: 0 not simulated, 1 reached, 2 fault, 3 infeasible, 4 dropped.
    pub status: Vec<u8>,
    /// Numeric attributes of the file: material, friction, gravity and others.
    pub numbers: HashMap<String, Vec<f64>>,
    places: RowPositions,
    handles: Mutex<Vec<std::fs::File>>,
}

/// Frames of one grasp. Arrays are row-major, pads left first; see [`ARRAYS`] for units and frames.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredGrasp {
    /// Number of valid frames; all arrays are truncated to them.
    pub frames: usize,
    /// Displacement, shape (frames, pads, nodes, 3), m, pad frame; if the pads differ, that of the smaller one is
    /// padded with zeros.
    pub displacement: Vec<f32>,
    /// Contact force, shape (frames, pads, nodes, 3), N, pad frame.
    pub contact_force: Vec<f32>,
    /// Von Mises stress, shape (frames, pads, nodes), Pa.
    pub von_mises: Vec<f32>,
    /// Applied force, shape (frames), N.
    pub force: Vec<f64>,
    /// Travel since first contact, shape (frames, pads), m.
    pub travel: Vec<f64>,
    /// Travel since the open hand, shape (frames, pads), m.
    pub finger_position: Vec<f64>,
    /// Pose of the object, px py pz qw qx qy qz, shape (frames, 7), in the hand frame.
    pub object_pose: Vec<f64>,
    /// Weight and push on the object: force and torque about its centre of mass, shape (frames, 6), N and N m, hand
    /// frame.
    pub object_load: Vec<f64>,
    /// Force and torque of the contact, shape (frames, pads, 6), N and N m, pad frame.
    pub wrench: Vec<f64>,
    /// Pose of the hand in the object frame, shape (7).
    pub grasp_pose: Vec<f64>,
    /// Arrays of tactile sensors, each of shape (frames, pads, ...).
    pub tactile: Vec<TactileArray>,
    /// Reason if the load was not reached; otherwise empty.
    pub reason: String,
}

impl ObjectFile {
    /// Opens the file of one object; reads pads, object and status, but no frame.
    ///
    /// # Errors
    /// Fails if the file was not written by `tactus dataset`, or is truncated.
    pub fn open(path: &Path) -> Result<Self> {
        let fail = |message: String| Error::file(path, message);
        let read = |e: hdf5_pure::Error| fail(format!("is not readable as HDF5: {e}"));
        let file = File::open_streaming(path).map_err(read)?;
        let attributes = file.root().attrs().map_err(read)?;
        let format = attributes.get("format").and_then(AttrValue::as_u64);
        if format != Some(FORMAT) {
            let found = format.map_or("no `format`".into(), |f| format!("layout {f}"));
            return Err(fail(format!(
                "has {found}, and this build reads data sets of layout {FORMAT}, whose arrays are named by their \
                 units: generate it again with `tactus dataset SCENE -o DIR`; models trained on it stay valid"
            )));
        }
        let text = |name: &str| {
            let value = attributes.get(name).and_then(AttrValue::as_str).map(str::to_string);
            value.ok_or_else(|| fail(format!("has no attribute `{name}`")))
        };
        let shape = |name: &str| -> Result<Vec<usize>> {
            let dataset = file.dataset(name).map_err(|e| fail(format!("array `{name}`: {e}")))?;
            Ok(dataset.shape().map_err(read)?.into_iter().map(|n| n as usize).collect())
        };
        let bad = |name: &str, e: hdf5_pure::Error| fail(format!("array `{name}`: {e}"));
        // Only contiguous arrays are accepted: the file size bounds their memory, whereas a compressed array may claim
        // any size.
        let plain = |name: &str, size: u64| {
            let dataset = file.dataset(name).map_err(|e| bad(name, e))?;
            let counts = dataset.shape().map_err(|e| bad(name, e))?;
            let bytes = counts.iter().try_fold(size, |n, k| n.checked_mul(*k));
            match dataset.layout().map_err(|e| bad(name, e))? {
                Layout::Contiguous { size, .. } if Some(size) == bytes && size <= file.file_size() => Ok(dataset),
                _ => Err(fail(format!(
                    "array `{name}` of shape {counts:?} is compressed, or larger than the file; write it with `tactus dataset`"
                ))),
            }
        };
        let doubles = |name: &str| plain(name, 8)?.read_f64().map_err(|e| bad(name, e));
        let integers = |name: &str| plain(name, 4)?.read_u32().map_err(|e| bad(name, e));
        let bytes = |name: &str| plain(name, 1)?.read_u8().map_err(|e| bad(name, e));

        let (big, positions, stresses) =
            (shape(names::DISPLACEMENT)?, shape("_1_stacked_positions")?, shape("_1_stacked_stresses")?);
        let ([grasps, frames, pads, nodes, 3], [_, _, corners, 3], [_, _, tets]) =
            (big.as_slice(), positions.as_slice(), stresses.as_slice())
        else {
            return Err(fail(format!(
                "`{}` has shape {big:?}; it must be (grasps, frames, pads, nodes, 3)",
                names::DISPLACEMENT
            )));
        };
        if !(1..=2).contains(pads) {
            return Err(fail(format!("has {pads} pads; it must be 1 or 2")));
        }
        let seen = attributes.get(TACTILE).and_then(AttrValue::as_str).unwrap_or_default();
        let tactile = seen.split(',').filter(|name| !name.is_empty()).map(|name| {
            let unit = file.dataset(name).and_then(|dataset| dataset.attrs()).map_err(|e| bad(name, e))?;
            let unit = unit.get("unit").and_then(AttrValue::as_str).unwrap_or_default().to_string();
            // The first two dimensions are grasps and frames.
            Ok(TactileLayout { name: name.into(), unit, shape: shape(name)?.into_iter().skip(2).collect() })
        });
        let sizes = FileSizes {
            grasps: *grasps,
            frames: *frames,
            pads: *pads,
            nodes: *nodes,
            corners: *corners,
            tets: *tets,
            tactile: tactile.collect::<Result<_>>()?,
        };
        let places = RowPositions::find(path, &file, &sizes)?;
        let triangles = |name: &str| Ok::<_, Error>(integers(name)?.as_chunks::<3>().0.to_vec());
        let points = |name: &str| {
            Ok::<_, Error>(doubles(name)?.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect::<Vec<_>>())
        };
        let mesh = |group: &str| -> Result<PadTopology> {
            let of = |name: &str| format!("{group}/{name}");
            let width = shape(&of(names::TETS))?.get(1).copied().unwrap_or(0);
            let elements = ElementNodes::from_flat(&integers(&of(names::TETS))?, width)
                .ok_or_else(|| fail(format!("`{group}/tets` has {width} nodes per tetrahedron; it must be 4 or 10")))?;
            Ok(PadTopology {
                rest: points(&of(names::REST))?,
                corner_count: elements.corners(),
                elements,
                surface: triangles(&of(names::SURFACE))?,
                sensing: triangles(&of(names::SENSING))?,
                bonded: bytes(&of(names::BONDED))?.into_iter().map(|b| b != 0).collect(),
            })
        };
        let [left, right] = names::PADS;
        let mut meshes = vec![mesh(left)?; *pads];
        if let (Some(own), true) = (meshes.get_mut(1), file.group(right).is_ok()) {
            *own = mesh(right)?;
        }
        meshes.iter().enumerate().try_for_each(|(i, pad)| record::check::topology(i, pad)).map_err(fail)?;
        let object = TriMesh {
            vertices: points(&format!("object/{}", names::VERTICES))?,
            triangles: triangles("object/triangles")?,
        };
        record::check::object(&object).map_err(fail)?;
        let (pad_poses, closing) = (
            doubles(&format!("{left}/{}", names::PAD_POSE))?
                .as_chunks::<7>()
                .0
                .iter()
                .map(|v| Pose::from_row(v))
                .collect::<Vec<_>>(),
            points(&format!("{left}/{}", names::CLOSING))?,
        );
        let count = |of: fn(&PadTopology) -> usize| meshes.iter().map(of);
        if count(|pad| pad.rest.len()).max() != Some(sizes.nodes)
            || count(|pad| pad.corner_count).sum::<usize>() != sizes.corners
            || count(|pad| pad.elements.len()).sum::<usize>() != sizes.tets
            || pad_poses.len() != *pads
            || closing.len() != *pads
        {
            return Err(fail("the arrays of the pad do not match those of the frames".into()));
        }
        Ok(Self {
            name: text("object")?,
            scene: text("scene")?,
            numbers: attributes.iter().filter_map(|(k, v)| Some((k.clone(), v.to_f64s()?))).collect(),
            status: bytes("status")?,
            path: path.to_path_buf(),
            sizes,
            pads: meshes,
            pad_poses,
            closing,
            object,
            places,
            handles: Mutex::default(),
        })
    }

    /// Fails if the pads differ, for `what` (a noun with its article), which supports only equal pads; the error shows
    /// the line in the scene.
    ///
    /// # Errors
    /// Fails if they differ, or if the scene cannot be read.
    pub fn require_equal_pads(&self, what: &str) -> Result<()> {
        let refused = from_ron(&self.scene)?.gripper.require_equal_fingers(what);
        refused.map_err(|e| locate_error_in(&self.path, &self.scene, e))
    }

    /// Returns the numbers of the grasps that reached their load.
    pub fn reached(&self) -> impl Iterator<Item = usize> + '_ {
        self.status.iter().enumerate().filter(|(_, s)| **s == 1).map(|(g, _)| g)
    }

    /// Reads a grasp; may be called from any thread and in any order.
    ///
    /// # Errors
    /// Fails if the grasp does not exist, or its rows are damaged.
    pub fn grasp(&self, grasp: usize) -> Result<StoredGrasp> {
        if grasp >= self.sizes.grasps {
            let message =
                format!("has no grasp {grasp}; it has {}, counted from 0", format_count(self.sizes.grasps, "grasp"));
            return Err(Error::file(&self.path, message));
        }
        let rows =
            self.rows(grasp).map_err(|e| Error::file(&self.path, format!("grasp {grasp} cannot be read: {e}")))?;
        if checksum(&rows).as_bytes() != rows[RowName::Checksum as usize].as_slice() {
            let message = format!(
                "grasp {grasp} is damaged: its rows do not match its checksum; omit it, or generate the file again"
            );
            return Err(Error::file(&self.path, message));
        }
        Ok(self.decode(&rows))
    }

    /// Reads all rows of a grasp.
    fn rows(&self, grasp: usize) -> std::io::Result<Vec<Vec<u8>>> {
        // Each concurrent read needs its own handle, because a handle has one position; handles are reused.
        let kept = self.handles.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut file = kept.map_or_else(|| std::fs::File::open(&self.path), Ok)?;
        let rows = self.places.read(&mut file, grasp);
        self.handles.lock().unwrap_or_else(PoisonError::into_inner).push(file);
        rows
    }

    fn decode(&self, rows: &[Vec<u8>]) -> StoredGrasp {
        let row = |name: RowName| rows[name as usize].as_slice();
        let frames = row(RowName::RecordedFrames).as_chunks().0.first().map_or(0, |b| u32::from_le_bytes(*b) as usize);
        let frames = frames.min(self.sizes.frames);
        let cut = |name: RowName| {
            let row = row(name);
            &row[..row.len() / self.sizes.frames.max(1) * frames]
        };
        let singles = |name: RowName| cut(name).as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        let doubles = |name: RowName| cut(name).as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        let tactile = |(array, row): (&TactileLayout, &Vec<u8>)| {
            let size: usize = array.shape.iter().product();
            let values = row.as_chunks().0[..frames * size].iter().map(|b| f32::from_le_bytes(*b)).collect();
            let shape = [&[frames], array.shape.as_slice()].concat();
            TactileArray { name: array.name.clone(), unit: array.unit.clone(), shape, values }
        };
        let reason = row(RowName::Reason).split(|b| *b == 0).next().unwrap_or_default();
        StoredGrasp {
            frames,
            displacement: singles(RowName::Displacement),
            contact_force: singles(RowName::ContactForce),
            von_mises: singles(RowName::VonMises),
            force: doubles(RowName::Force),
            travel: doubles(RowName::Travel),
            finger_position: doubles(RowName::FingerPosition),
            object_pose: doubles(RowName::ObjectPose),
            object_load: doubles(RowName::ObjectLoad),
            wrench: doubles(RowName::Wrench),
            tactile: self.sizes.tactile.iter().zip(&rows[ARRAYS.len()..]).map(tactile).collect(),
            grasp_pose: row(RowName::Pose).as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
            reason: String::from_utf8_lossy(reason).into_owned(),
        }
    }
}
