//! Command `tactus eval`: errors of a trained model.

use super::console::Console;
use super::output::{EXIT_OK, Format};
use super::run::pool;
use base::error::{Error, Result};
use base::files::atomic::create_dir;
use base::machine::machine_threads;
use base::number::format_count;
use dataset::DataSet;
use net::eval::acceptance::{Acceptance, acceptances};
use net::eval::dump;
use net::eval::slip::{SlipEvaluation, slip_loads};
use net::eval::table::{ALL, ErrorRow, ranks, rows};
use net::eval::{GraspEvaluation, frames, picture, test_grasps};
use net::infer::predict::Predictor;
use net::train::sample::model_of;
use record::render::save;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Arguments of `tactus eval`.
#[derive(Debug, clap::Args)]
pub struct EvalArgs {
    /// Folder of a data set.
    pub data: PathBuf,
    /// Folder of a trained model.
    #[arg(long, value_name = "DIR")]
    pub model: PathBuf,
    /// Test grasps: `poses`, `all`, `single:OBJECT` or `without:OBJECT`; the default is the split on which the model
    /// was trained.
    #[arg(long)]
    pub split: Option<String>,
    /// Also evaluate grasps outside the range of the training data, where the error is unknown.
    #[arg(long)]
    pub extrapolate: bool,
    /// Folder for pictures of the worst grasps, each with the truth above the prediction.
    #[arg(short, long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Number of worst grasps that are drawn and listed in the JSON report.
    #[arg(long, default_value_t = 5)]
    pub worst: usize,
    /// Write the inputs and outputs of the network for the first test grasp as `.npz`, to verify another
    /// implementation: see tests/network/torch_check.py.
    #[arg(long, value_name = "FILE")]
    pub dump: Option<PathBuf>,
    /// Also print the errors by object, by fifth of the load and by frame.
    #[arg(long)]
    pub groups: bool,
    /// Number of threads; the default is all threads of the machine. The errors are bitwise independent of it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Evaluates a trained model on the test grasps of a split.
///
/// # Errors
/// Fails if the data set or the model cannot be read, the split is invalid, or a file cannot be written.
pub fn eval(args: &EvalArgs, console: &dyn Console) -> Result<u8> {
    pool(args.threads.map_or_else(machine_threads, |n| n as usize))?.install(|| evaluate(args, console))
}

fn evaluate(args: &EvalArgs, console: &dyn Console) -> Result<u8> {
    let set = DataSet::open(&args.data)?;
    let predictor = Predictor::open(&args.model)?;
    let split = args.split.clone().unwrap_or_else(|| predictor.card.split.clone());
    if set.manifest.plan == predictor.card.data && split != predictor.card.split {
        console.warn(&format!(
            "note: the network was trained on split {} of this data set; {split} may contain grasps of its training \
             data",
            predictor.card.split
        ));
    }
    predictor.card.unknown_error().iter().for_each(|notice| console.warn(&format!("note: {notice}")));
    if let Some(path) = &args.dump {
        let samples = test_grasps(&set, &predictor, &split, args.extrapolate)?;
        samples.first().map_or(Ok(()), |sample| dump::write(path, &predictor, sample))?;
    }
    let judged = net::eval::evaluate(&set, &predictor, &split, args.extrapolate)?;
    let slip = slip_loads(&set, &predictor, &split)?;
    let mut table = rows(&split, &judged);
    let (stress, displacement) = ranks(&judged);
    let accepted = acceptances(&judged);
    let mean = |k: usize| judged.iter().map(|j| j.time_s[k]).sum::<f64>() / judged.len().max(1) as f64;
    let mut worst: Vec<&GraspEvaluation> = judged.iter().collect();
    let badness = |j: &GraspEvaluation| j.frames.last().map_or(0.0, |f| f.displacement);
    worst.sort_by(|a, b| badness(b).total_cmp(&badness(a)));
    worst.truncate(args.worst);
    if let Some(dir) = &args.pictures {
        create_dir(dir)?;
        worst.iter().try_for_each(|j| draw(&set, &predictor, j, dir))?;
    }
    let text = match args.format {
        Format::Text => {
            table.retain(|row| args.groups || row.group == ALL);
            report(&table, &accepted, slip.as_ref(), judged.len(), (stress, displacement), (mean(0), mean(1)))
        }
        Format::Json => {
            let worst: Vec<_> = worst.iter().filter_map(|j| j.frames.last()).collect();
            let object = json!({
                "split": split, "model": args.model, "grasps": judged.len(), "tables": table,
                "error_at_most": accepted, "slip": slip,
                "kendall_tau": { "peak_stress": stress, "peak_displacement": displacement },
                "encode_s": mean(0), "decode_all_frames_s": mean(1), "worst": worst,
            });
            format!("{object}\n")
        }
    };
    console.print(&text)?;
    Ok(EXIT_OK)
}

fn report(
    table: &[ErrorRow],
    accepted: &[Acceptance],
    slip: Option<&SlipEvaluation>,
    grasps: usize,
    (stress, displacement): (f64, f64),
    (encode, decode): (f64, f64),
) -> String {
    let mut out = format!("{}; relative errors in %\n", format_count(grasps, "grasp"));
    out += "group                 quantity                  median       p90     worst  frames  within  interval\n";
    // Writing to a String cannot fail.
    for r in table {
        let scale = if r.quantity.contains('_') && r.quantity != "contact_force" { 1.0 } else { 100.0 };
        let [median, p90, worst] = [r.median, r.p90, r.worst].map(|v| v * scale);
        let _ = writeln!(
            out,
            "{:<20}  {:<22} {median:>9.4} {p90:>9.4} {worst:>9.4}  {:>6}{}",
            r.group,
            r.quantity,
            r.samples,
            r.covered
                .zip(r.interval)
                .map_or_else(String::new, |(part, end)| { format!("  {:>4.0} %  {:>8.4}", 100.0 * part, scale * end) })
        );
    }
    let _ = writeln!(out, "Kendall's tau of the grasps: peak stress {stress:.3}, peak displacement {displacement:.3}");
    for Acceptance { error_at_most, kept, median, worst } in accepted {
        let [bound, kept, median, worst] = [error_at_most, kept, median, worst].map(|v| 100.0 * v);
        let _ = writeln!(
            out,
            "error_at_most {bound:>2.0} %: the network computes {kept:.0} % of the grasps, with displacement errors of \
             {median:.1} % (median) and {worst:.1} % (worst)"
        );
    }
    if let Some(SlipEvaluation { grasps, close, covered, median }) = slip {
        let [close, median] = [close, median].map(|v| 100.0 * v);
        let covered = covered.map_or_else(String::new, |part| format!(", {:.0} % within its interval", 100.0 * part));
        let _ = writeln!(
            out,
            "slip: {} dropped under a push; the predicted load is within a tenth for {close:.0} % of them, with an \
             error of {median:.1} % (median){covered}",
            format_count(*grasps, "grasp"),
        );
    }
    let _ = writeln!(out, "network: {:.2} ms per grasp, {:.2} ms for all its frames", encode * 1e3, decode * 1e3);
    out
}

/// Draws the last frame of a grasp.
fn draw(set: &DataSet, predictor: &Predictor, judged: &GraspEvaluation, dir: &Path) -> Result<()> {
    let Some(error) = judged.frames.last() else { return Ok(()) };
    let missing = || Error::Start(format!("object {} is not in the data set", error.object));
    let file = set.objects.iter().find(|f| f.name == error.object).ok_or_else(missing)?;
    let (model, grasp) = (model_of(file)?, file.grasp(error.grasp)?);
    let [truth, predicted] = frames::reference_and_prediction(file, &model, predictor, &grasp, &[error.frame])?;
    let page = picture::draw(file, error.grasp, &truth[0], &predicted[0])?;
    save(&page, &dir.join(format!("{}_{:03}.png", error.object, error.grasp)))
}
