//! `sensitivity.csv`: sensitivity of the grasps of a data set to small changes, as a scale for the errors of a network
//! on them.
//!
//! The table has one row per change of a grasp, after a first line with the plan of the data set. An interrupted run is
//! resumed at the next object.

use base::error::{Error, Result};
use base::files::atomic::{cannot_write, write_durable};
use geometry::Pose;
use model::Model;
use record::sensitivity::{Change, ChangeEffect};
use scene::NamedScene;
use serde::{Deserialize, Serialize};
use std::path::Path;
use world::StepperFactory;
use world::run::run_grasps;
use world::run::sensitivity::{FinalStates, LastFrames, sensitivity};

/// Name of the file.
pub const SENSITIVITY_NAME: &str = "sensitivity.csv";

/// Effect of a change on a grasp of the data set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SensitivityRow {
    /// Name of the object.
    pub object: String,
    /// Number of the grasp, from 0.
    pub grasp: usize,
    /// Change that was made.
    pub change: Change,
    /// Status of the grasp with the change.
    pub status: record::Status,
    /// Difference of the displacements of both pads over their norm; None unless both grasps were reached.
    pub displacement: Option<f64>,
    /// Additional displacement of the object, m; None unless both grasps were reached.
    pub object_m: Option<f64>,
}

/// Reads the table of the data set with this `plan`; returns an empty one if there is none or it has another plan.
///
/// # Errors
/// Fails if the file is not such a table.
pub fn read(dir: &Path, plan: &str) -> Result<Vec<SensitivityRow>> {
    let path = dir.join(SENSITIVITY_NAME);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(Error::file(&path, format!("cannot be read: {e}"))),
    };
    let Some(table) = text.strip_prefix(&first_line(plan)) else { return Ok(Vec::new()) };
    let rows = csv::Reader::from_reader(table.as_bytes()).into_deserialize().collect::<std::result::Result<_, _>>();
    rows.map_err(|e| {
        Error::file(&path, format!("is not a table of sensitivities: {e}; remove it and generate it again"))
    })
}

/// Measures the grasps of one object at `poses`, except those already in the `table`, and writes the extended table to
/// `dir`.
///
/// # Errors
/// Fails if a model cannot be built, the grasps cannot be run or the table cannot be written.
pub fn measure(
    (dir, plan): (&Path, &str),
    table: &mut Vec<SensitivityRow>,
    (object, poses): (&NamedScene, &[Pose]),
    choose: StepperFactory,
    threads: usize,
) -> Result<()> {
    let name = object.name.as_str();
    let open = |grasp: &usize| !table.iter().any(|row| row.object == name && row.grasp == *grasp);
    let grasps: Vec<_> = (0..poses.len()).filter(open).map(|grasp| (grasp, poses[grasp])).collect();
    if grasps.is_empty() {
        return Ok(());
    }
    let model = Model::build(&object.scene)?;
    let stepper = choose(&object.scene)?;
    let last = LastFrames::default();
    let outcomes = run_grasps(&model, stepper.as_ref(), &grasps, threads, &last)?;
    let ends = FinalStates::of(&outcomes, last);
    let answers = sensitivity(&object.scene, &model, stepper.as_ref(), (&grasps, &ends), threads)?;
    for ((grasp, _), moved) in grasps.iter().zip(answers) {
        table.extend(moved.into_iter().map(|ChangeEffect { change, status, displacement, object_m }| SensitivityRow {
            object: name.into(),
            grasp: *grasp,
            change,
            status,
            displacement,
            object_m,
        }));
    }
    let path = dir.join(SENSITIVITY_NAME);
    let mut writer = csv::Writer::from_writer(first_line(plan).into_bytes());
    table.iter().try_for_each(|row| writer.serialize(row)).map_err(|e| Error::file(&path, e.to_string()))?;
    let bytes = writer.into_inner().map_err(|e| cannot_write(&path, e.error()))?;
    write_durable(&path, &bytes)
}

/// Returns the first line of the table, which identifies its data set.
fn first_line(plan: &str) -> String {
    format!("# plan {plan}\n")
}
