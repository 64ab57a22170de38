//! Command `tactus dataset inspect`: contents and integrity of a data set.

use super::console::Console;
use super::output::{EXIT_EXPECTATION_FAILED, EXIT_OK, Format};
use base::error::Result;
use base::files::atomic::create_dir;
use base::number::format_count;
use dataset::DataSet;
use dataset::inspect::{self, Inspection, InspectionSampling};
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `tactus dataset inspect`.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// Folder of the data set.
    pub dir: PathBuf,
    /// Folder for pictures of the inspected grasps; without it none are drawn.
    #[arg(short, long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Inspect only every Nth grasp of each object.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub every: u64,
    /// Inspect only N frames of each grasp, evenly spread and including the last.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Prints the contents; the exit code is 1 if a file or a grasp is damaged.
///
/// # Errors
/// Fails if the data set cannot be opened or a picture cannot be written.
pub fn inspect(args: &InspectArgs, console: &dyn Console) -> Result<u8> {
    let set = DataSet::open(&args.dir)?;
    if let Some(dir) = &args.pictures {
        create_dir(dir)?;
    }
    let thinning = InspectionSampling { every: args.every as usize, frames: args.frames.map(|n| n as usize) };
    let found = inspect::inspect(&set, thinning, args.pictures.as_deref())?;
    let text = match args.format {
        Format::Text => render(&set, &found),
        Format::Json => format!("{}\n", serde_json::json!({"manifest": set.manifest, "inspection": found})),
    };
    console.print(&text)?;
    Ok(if found.damaged.is_empty() { EXIT_OK } else { EXIT_EXPECTATION_FAILED })
}

fn render(set: &DataSet, found: &Inspection) -> String {
    let mut out = String::new();
    let m = &set.manifest;
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{}", m.about);
    let _ = writeln!(
        out,
        "{}, {} ({} reached), {} each, {:.1} MB; tactus {}\n",
        format_count(m.objects.len(), "object"),
        format_count(m.grasps, "grasp"),
        m.sum(|o| o.reached),
        format_count(m.frames, "frame"),
        m.bytes as f64 / 1e6,
        m.tactus
    );
    out.push_str("object            grasps  reached   read  frames   nodes    tets\n");
    for o in &found.objects {
        let _ = writeln!(
            out,
            "{:<16}  {:>6}  {:>7}  {:>5}  {:>6}  {:>6}  {:>6}",
            o.name, o.grasps, o.reached, o.read_grasps, o.read_frames, o.nodes, o.tets
        );
    }
    out.push_str("\nquantity                      min        mean         max  histogram\n");
    for r in &found.ranges {
        let most = r.histogram.iter().copied().max().unwrap_or(1).max(1);
        let bar = |n: &usize| [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'][(n * 8).div_ceil(most)];
        let bars: String = r.histogram.iter().map(bar).collect();
        let _ = writeln!(out, "{:<20}  {:>10.3e}  {:>10.3e}  {:>10.3e}  {bars}", r.name, r.min, r.mean, r.max);
    }
    for o in found.objects.iter().filter(|o| !o.failures.is_empty()) {
        o.failures.iter().for_each(|f| {
            let _ = writeln!(out, "{} grasp {} ({}): {}", o.name, f.grasp, format_count(f.frames, "frame"), f.reason);
        });
    }
    let (s, t) = (&set.splits, |poses: &dataset::split::GraspNumbers| set.select(poses).len());
    let _ =
        writeln!(out, "\nsplit of the poses (reached grasps): {} train, {} test", t(&s.poses.train), t(&s.poses.test));
    for damage in &found.damaged {
        let _ = writeln!(out, "damaged: {damage}");
    }
    out
}
