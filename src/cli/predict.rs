//! Command `tactus predict`: predictions of a network for all grasps of a scene.

use super::console::Console;
use super::dataset::limit;
use super::output::{EXIT_EXPECTATION_FAILED, EXIT_OK, Format};
use super::run::pool;
use base::error::{Error, Result};
use base::files::atomic::{create_dir, replace};
use base::machine::machine_threads;
use base::number::format_count;
use model::Model;
use model::grasp::grasp_poses;
use ndarray::IxDyn;
use ndarray_npy::NpzWriter;
use net::DEFAULT_MODEL;
use net::infer::arrays::each_array;
use net::infer::batch::PredictedGrasp;
use net::infer::friction_margin::slip_reason;
use net::infer::predict::{GraspState, Predictor};
use net::linear_response::GraspLoad;
use rayon::prelude::*;
use record::ErrorBound;
use record::arrays::{io_error, put};
use scene::{NamedScene, load_set};
use serde::Serialize;
use serde_json::json;
use std::fmt::Write;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `tactus predict`.
#[derive(Debug, clap::Args)]
pub struct PredictArgs {
    /// Scene file; `-` is standard input.
    pub scene: PathBuf,
    /// Object to predict if the scene has several; the default is all of them, one after the other.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Folder of the trained model; the default is that of the scene, otherwise `universe`, which is part of tactus.
    #[arg(long, value_name = "MODEL")]
    pub model: Option<PathBuf>,
    /// Predict only the first N grasps of each object.
    #[arg(long, value_name = "N")]
    pub grasps: Option<u64>,
    /// Number of loads of each grasp; overrides the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Folder for the arrays: one `NAME.npz` for each object.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the arrays of an earlier prediction in the folder instead of failing.
    #[arg(long, requires = "out")]
    pub overwrite: bool,
    /// Allow predictions outside the range of the training data, where their error is unknown.
    #[arg(long)]
    pub extrapolate: bool,
    /// Number of threads; the default is all threads of the machine. The predictions are bitwise independent of it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Predictions for the grasps of an object.
#[derive(Debug, Serialize)]
struct Report {
    name: String,
    loads: usize,
    decoded_loads: f64,
    threads: usize,
    wall_s: f64,
    grasps_per_s: f64,
    notices: Vec<String>,
    grasps: Vec<Row>,
}

/// Result of a grasp with its number.
#[derive(Debug, Serialize)]
struct Row {
    grasp: usize,
    #[serde(flatten)]
    end: GraspOutcome,
}

/// Result of a grasp.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum GraspOutcome {
    /// Prediction of the network.
    Answer(LastLoadSummary),
    /// Reason why there is no prediction.
    Failed { reason: String },
}

/// Summary of a grasp at its last load.
#[derive(Debug, Serialize)]
struct LastLoadSummary {
    travel_mm: f64,
    displacement_mm: f64,
    stress_kpa: Option<f64>,
    object_deg: f64,
    error: ErrorBound,
}

/// Predicts the grasps of a scene.
///
/// # Errors
/// Fails if the scene, the model or an argument is invalid, or the file cannot be written.
pub fn predict(args: &PredictArgs, console: &dyn Console) -> Result<u8> {
    let mut set = load_set(&args.scene)?.retain_object(args.object.as_deref())?;
    limit(&mut set.scenes, args.grasps, args.frames)?;
    let threads = args.threads.map_or_else(machine_threads, |n| n as usize);
    let pool = pool(threads)?;
    let own = set.scenes.first().and_then(|named| named.scene.stepper.model());
    let predictor = Predictor::open(args.model.as_deref().or(own).unwrap_or(DEFAULT_MODEL.as_ref()))?;
    // Existing files are detected before anything is computed.
    let earlier = set.scenes.iter().filter_map(|named| arrays_of(args, named)).find(|path| path.exists());
    if let Some(path) = earlier.filter(|_| !args.overwrite) {
        let message = "contains an earlier prediction; choose another output directory, or use --overwrite";
        return Err(Error::file(path, message));
    }
    let mut reports = Vec::new();
    for named in &set.scenes {
        let report =
            pool.install(|| object(args, &predictor, named, threads)).map_err(|e| set.locate_error(e, &named.name))?;
        report.notices.iter().for_each(|notice| console.warn(&format!("note: {notice}")));
        if args.format == Format::Text {
            console.print(&report.text())?;
        }
        reports.push(report);
    }
    if args.format == Format::Json {
        console.print(&format!("{:#}\n", json!({ "objects": reports })))?;
    }
    let good = reports.iter().flat_map(|report| &report.grasps).all(|row| matches!(row.end, GraspOutcome::Answer(_)));
    Ok(if good { EXIT_OK } else { EXIT_EXPECTATION_FAILED })
}

/// Returns the path of the array file of an object; None without an output folder.
fn arrays_of(args: &PredictArgs, named: &NamedScene) -> Option<PathBuf> {
    args.out.as_ref().map(|dir| dir.join(format!("{}.npz", named.name.as_str())))
}

/// Predicts the grasps of an object.
fn object(args: &PredictArgs, predictor: &Predictor, named: &NamedScene, threads: usize) -> Result<Report> {
    let model = Model::build(&named.scene.without_finer_mesh())?;
    let poses = grasp_poses(&named.scene)?;
    let extrapolate = args.extrapolate || named.scene.stepper.extrapolates();
    // The linear response of new pads is computed here, outside the measured time of a grasp.
    predictor.pads_if_some_force_in_range(&model, extrapolate)?;
    let loads: Vec<GraspLoad> =
        predictor.answerable_loads(&model, extrapolate).into_iter().map(|(_, load)| load).collect();
    let clock = Instant::now();
    let answers = predictor.predict_batch(&model, &poses, extrapolate)?;
    let grasps =
        answers.par_iter().enumerate().map(|(grasp, answer)| Row { grasp, end: GraspOutcome::of(answer) }).collect();
    let wall_s = clock.elapsed().as_secs_f64();
    if let (Some(dir), Some(path)) = (&args.out, arrays_of(args, named)) {
        create_dir(dir).and_then(|()| replace(&path, |path| write(path, &model, &loads, &answers)))?;
    }
    let answered: Vec<&PredictedGrasp> = answers.iter().flatten().collect();
    let decoded: usize = answered.iter().map(|answer| answer.interpolation.decoded()).sum();
    Ok(Report {
        name: named.name.as_str().into(),
        loads: loads.len(),
        decoded_loads: decoded as f64 / answered.len().max(1) as f64,
        threads,
        wall_s,
        grasps_per_s: poses.len() as f64 / wall_s,
        notices: predictor.notices(&model, extrapolate),
        grasps,
    })
}

impl Report {
    fn text(&self) -> String {
        let mut text = format!("object {}\n", self.name);
        text += "grasp  travel mm  displacement mm  stress kPa  object deg  bound of the displacement error\n";
        for Row { grasp, end } in &self.grasps {
            // Writing to a String cannot fail.
            let _ = match end {
                GraspOutcome::Answer(end) => writeln!(
                    text,
                    "{grasp:>5}  {:>9.3}  {:>15.3}  {:>10}  {:>10.2}  {}",
                    end.travel_mm,
                    end.displacement_mm,
                    end.stress_kpa.map_or_else(|| "-".into(), |s| format!("{s:.1}")),
                    end.object_deg,
                    match end.error {
                        error if error.is_known() => format!("{:.1} %", 100.0 * error.displacement),
                        _ => "unknown".into(),
                    },
                ),
                GraspOutcome::Failed { reason } => writeln!(text, "{grasp:>5}  {reason}"),
            };
        }
        let answered = self.grasps.iter().filter(|row| matches!(row.end, GraspOutcome::Answer(_))).count();
        let _ = writeln!(
            text,
            "{answered} of {} grasps in {:.2} s on {}, {:.0} per second; {} each, {:.1} of them decoded",
            self.grasps.len(),
            self.wall_s,
            format_count(self.threads, "thread"),
            self.grasps_per_s,
            format_count(self.loads, "load"),
            self.decoded_loads
        );
        text
    }
}

impl GraspOutcome {
    fn of(answer: &Result<PredictedGrasp>) -> Self {
        let last = |answer: &PredictedGrasp| {
            answer.interpolation.len().checked_sub(1).and_then(|last| answer.interpolation.at(last))
        };
        match answer.as_ref().map(|answer| (slip_reason(&answer.friction_margin), last(answer))) {
            Ok((Some(reason), _)) => Self::Failed { reason },
            Ok((None, Some(state))) => Self::Answer(LastLoadSummary::of(&state)),
            Ok((None, None)) => Self::Failed { reason: "there is no load".into() },
            Err(error) => Self::Failed { reason: error.to_string() },
        }
    }
}

impl LastLoadSummary {
    fn of(state: &GraspState) -> Self {
        let most = |v: &mut dyn Iterator<Item = f64>| v.fold(0.0, f64::max);
        let stress = most(&mut state.pads.iter().flat_map(|p| &p.stress).copied());
        Self {
            travel_mm: 1e3 * state.pads.iter().map(|p| p.travel).sum::<f64>() / state.pads.len() as f64,
            displacement_mm: 1e3 * most(&mut state.pads.iter().flat_map(|p| &p.displacement).map(|u| u.length())),
            stress_kpa: state.pads.iter().any(|p| !p.stress.is_empty()).then_some(1e-3 * stress),
            object_deg: most(&mut state.pads.iter().map(|p| p.rotation_vector.length())).to_degrees(),
            error: state.error,
        }
    }
}

/// Writes the arrays of all grasps that have a prediction.
fn write(path: &Path, model: &Model, loads: &[GraspLoad], answers: &[Result<PredictedGrasp>]) -> io::Result<()> {
    let mut npz = NpzWriter::new(BufWriter::new(std::fs::File::create(path)?));
    each_array(model, loads, answers, |name, shape, numbers| put(&mut npz, name, IxDyn(shape), &numbers))?;
    npz.finish().map(drop).map_err(io_error)
}
