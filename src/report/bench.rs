//! Sections of a report page for benchmarks: time against error of every setting, and cost against problem size.

use super::page::{Page, PageBlock, Section};
use base::error::{Error, Result};
use base::number::format_count;
use base::table::Table;
use bench::report::{BenchReport, Point};
use bench::sizes::SizeStudy;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Adds the section of a benchmark of time against error to `page`: chart, table of settings, speed-ups, notices and
/// time by stage. Reads `bench.json` and, if it exists, `bench.svg` in the folder `dir`.
///
/// # Errors
/// Fails if `bench.json` cannot be read or a file was not written by `tactus bench`.
pub fn comparison_section(dir: &Path, page: &mut Page) -> Result<()> {
    let report: BenchReport = read(&dir.join("bench.json"))?;
    let mut blocks = Vec::new();
    let chart = dir.join("bench.svg");
    if let Ok(svg) = std::fs::read_to_string(&chart) {
        if !svg.contains("<svg") {
            return Err(Error::file(&chart, "is not an SVG picture"));
        }
        blocks.push(PageBlock::Picture(svg, "Error against time, both logarithmic; lower left is better.".into()));
    }
    blocks.push(PageBlock::Table(points(&report)));
    for point in report.points.iter().filter(|p| p.contender) {
        blocks.extend(point.speedups().into_iter().map(|text| PageBlock::Note(format!("{text}."))));
    }
    blocks.extend(report.notices.iter().map(|notice| PageBlock::Note(notice.clone())));
    blocks.push(PageBlock::Table(stages(&report)));
    let lead = format!(
        "{}, {} of each setting on each grasp, {} per grasp. Errors are differences from {}, relative to the norm of \
         the field.",
        format_count(report.grasps.len(), "grasp"),
        format_count(report.repeats, "repetition"),
        format_count(report.threads, "thread"),
        report.reference.label
    );
    page.sections.push(Section::new("Speed against error", lead, blocks));
    Ok(())
}

/// Adds the section of a study of cost against problem size to `page`: time and memory of a frame for each mesh
/// density, and the fitted exponents. Reads `sizes.json` in the folder `dir`.
///
/// # Errors
/// Fails if the file cannot be read or was not written by `tactus bench`.
pub fn size_section(dir: &Path, page: &mut Page) -> Result<()> {
    let report: SizeStudy = read(&dir.join("sizes.json"))?;
    let columns =
        ["pad", "nodes", "unknowns", "ms per iteration", "iterations per frame", "s per frame", "processor s", "MB"];
    let mut table = Table::new("Cost of a frame", &columns);
    for s in &report.sizes {
        table.rows.push(vec![
            s.density.clone(),
            s.nodes.to_string(),
            s.unknowns.to_string(),
            format!("{:.1}", 1e3 * s.time_per_iteration_s),
            format!("{:.1}", s.iterations_per_frame),
            format!("{:.2}", s.time_per_frame_s),
            s.processor_time_per_frame_s.map_or("-".into(), |t| format!("{t:.2}")),
            megabytes(s.peak_memory_bytes),
        ]);
    }
    let power = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.2}"));
    let lead = format!(
        "Fitted exponent of the number of unknowns: {} for an iteration, {} for a frame, {} for the memory ({}).",
        power(report.iteration_exponent),
        power(report.frame_exponent),
        power(report.memory_exponent),
        format_count(report.threads, "thread")
    );
    page.sections.push(Section::new("Cost against size", lead, vec![PageBlock::Table(table)]));
    Ok(())
}

fn points(report: &BenchReport) -> Table {
    let columns = [
        "setting",
        "nodes",
        "s per grasp",
        "processor s",
        "displacement %",
        "stress %",
        "force %",
        "travel %",
        "MB",
        "",
    ];
    let mut table = Table::new("All settings", &columns);
    table.note = "Displacement and stress: median / 90th percentile / worst over grasps and frames; force and travel: \
                  median. The reference's own errors are estimates."
        .into();
    for p in report.points.iter().chain([&report.reference]) {
        let estimate = |e: Option<f64>| e.map_or("-".into(), |e| format!("about {:.1}", 100.0 * e));
        let spread = |name: &str, e: Option<f64>| match p.errors.get(name) {
            Some(s) => [s.median, s.p90, s.worst].map(|v| format!("{:5.1}", 100.0 * v)).join(" / "),
            None => estimate(e),
        };
        let middle = |name: &str, e: Option<f64>| match p.errors.get(name) {
            Some(s) => format!("{:.1}", 100.0 * s.median),
            None => estimate(e),
        };
        table.rows.push(vec![
            p.label.clone(),
            p.nodes.to_string(),
            format!("{:.3}", p.time_per_grasp_s),
            p.processor_time_per_grasp_s.map_or("-".into(), |t| format!("{t:.3}")),
            spread("displacement", p.displacement_error),
            spread("stress", p.stress_error),
            middle("force", p.force_error),
            middle("travel", p.travel_error),
            megabytes(p.peak_memory_bytes),
            remark(p),
        ]);
    }
    table
}

fn remark(p: &Point) -> String {
    match (p.failed.is_empty(), p.dominated) {
        (false, _) => format!("{} failed", p.failed.len()),
        (true, true) => "dominated".into(),
        (true, false) => String::new(),
    }
}

/// Returns the table of the time fraction of each stage.
fn stages(report: &BenchReport) -> Table {
    let mut table = Table::new("Time by stage", &["setting", "iterations per frame", "fraction of each stage"]);
    table.folded = true;
    for p in report.points.iter().chain([&report.reference]) {
        let mut stages: Vec<_> = p.profile.iter().collect();
        stages.sort_by(|a, b| b.1.total_cmp(a.1));
        let shares: Vec<_> = stages.iter().map(|(name, share)| format!("{name} {:.0} %", 100.0 * **share)).collect();
        table.rows.push(vec![p.label.clone(), format!("{:.1}", p.iterations_per_frame), shares.join(", ")]);
    }
    table
}

fn megabytes(bytes: Option<u64>) -> String {
    bytes.map_or("-".into(), |b| format!("{:.0}", b as f64 / 1e6))
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let bytes = std::fs::read(path).map_err(|e| Error::system(path, format!("cannot be read: {e}"), e.kind()))?;
    serde_json::from_slice(&bytes).map_err(|e| Error::file(path, format!("is not what `tactus bench` writes: {e}")))
}
