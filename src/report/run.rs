//! Section of a run: outcomes of its grasps, expectations, frames.

use super::page::{Page, PageBlock, Section};
use super::recording::{RecordedState, Recording};
use super::source::ReportOptions;
use base::error::Result;
use base::number::format_count;
use base::table::Table;
use dataset::inspect::sample_frames;
use record::{Frame, RunReport, meshes, read};
use std::path::Path;
use world::run::grasp_files::directory;

/// Adds the run in `dir`.
///
/// # Errors
/// Fails if the folder has no readable `run.json`. Frames that cannot be shown result in a note on the page.
pub fn run(dir: &Path, wishes: &ReportOptions, page: &mut Page) -> Result<()> {
    let report = read::run_report(dir)?;
    let mut blocks = vec![PageBlock::Table(grasps(&report))];
    if !report.expectations.is_empty() {
        blocks.push(PageBlock::Table(expectations(&report)));
    }
    blocks.extend(report.pads.first().and_then(|p| p.notice.clone()).map(PageBlock::Note));
    if !report.finished {
        let so_far = format_count(report.grasps.len(), "grasp");
        blocks.insert(0, PageBlock::Note(format!("The run is not finished: so far {so_far} ended.")));
    }
    match recordings(dir, &report, wishes) {
        Ok(found) => page.recordings.extend(found),
        Err(error) => blocks.push(PageBlock::Note(format!("No grasp in 3-D: {error}"))),
    }
    let about = report.scene.get("about").and_then(|v| v.as_str()).unwrap_or_default();
    let mut pads: Vec<String> = report.pads.iter().map(|p| format!("{} nodes ({})", p.nodes, p.element)).collect();
    pads.dedup();
    let pads = if pads.is_empty() { "no pads".into() } else { format!("pads of {}", pads.join(" and ")) };
    let lead = format!("{about} {}, {pads}, backend {}.", format_count(report.grasps.len(), "grasp"), report.backend);
    let mut section = Section::new(format!("Run {}", name(dir)), lead.trim(), blocks);
    section.origin_texts =
        [&report.command, &report.machine].into_iter().filter(|text| !text.is_empty()).cloned().collect();
    page.sections.push(section);
    Ok(())
}

/// Returns the last component of a path, for headings.
pub fn name(dir: &Path) -> String {
    let whole = dir.canonicalize().unwrap_or_else(|_| dir.to_path_buf());
    whole.file_name().unwrap_or(whole.as_os_str()).to_string_lossy().into_owned()
}

fn recordings(dir: &Path, report: &RunReport, wishes: &ReportOptions) -> Result<Vec<Recording>> {
    let shown: Vec<usize> = report.grasps.iter().filter(|g| g.frames > 0).map(|g| g.grasp).collect();
    let shown: Vec<usize> = sample_frames(shown.len(), Some(wishes.grasps)).into_iter().map(|i| shown[i]).collect();
    if shown.is_empty() || report.pads.is_empty() {
        return Ok(Vec::new());
    }
    let (pads, object) = meshes::read(dir, report.pads.len())?;
    let nodes: Vec<usize> = pads.iter().map(|pad| pad.rest.len()).collect();
    let shape = report.scene.pointer("/object/shape").and_then(|shape| shape.as_object()?.keys().next());
    let shape = shape.map_or("object".into(), |name| name.to_lowercase());
    let label = if report.backend.starts_with("gnn") { "network" } else { "finite elements" };
    let recording = |grasp: usize| {
        let path = dir.join(directory(grasp)).join("arrays.npz");
        let frames = match read::frames(&path, &nodes) {
            // The grasp has just ended and its arrays are still being written.
            Err(_) if !report.finished => return None,
            frames => frames,
        };
        let of = |frames: Vec<Frame>| Recording {
            name: format!("{}, {}, grasp {grasp}", name(dir), shape),
            about: String::new(),
            pads: pads.clone(),
            object: object.clone(),
            states: vec![RecordedState {
                label: label.into(),
                frames: sample_frames(frames.len(), Some(wishes.frames))
                    .into_iter()
                    .map(|k| frames[k].clone())
                    .collect(),
            }],
            errors: None,
        };
        Some(frames.map(of))
    };
    shown.into_iter().filter_map(recording).collect()
}

fn grasps(report: &RunReport) -> Table {
    let columns = [
        "grasp",
        "frames",
        "force, N",
        "travel, mm",
        "smallest det F",
        "smallest gap, µm",
        "balance",
        "iterations",
        "s",
    ];
    let mut table = Table::new("Grasps", &columns);
    table.note = "Force and travel at the last frame; force is the sum over the fingers.".into();
    for g in &report.grasps {
        let status = g.status.as_str();
        let reason = g.reason.as_ref().map_or(String::new(), |r| format!(": {r}"));
        let handed = g.handed_over.as_ref().map_or(String::new(), |r| format!("; computed by finite elements: {r}"));
        let error = g.error.map_or(String::new(), |error| format!("; {error}"));
        table.rows.push(vec![
            format!("{} {status}{reason}{handed}{error}", g.grasp),
            g.frames.to_string(),
            format!("{:.2}", g.force_n),
            format!("{:.3}", 1e3 * g.travel_m),
            g.min_det_f.map_or("-".into(), |v| format!("{v:.3}")),
            g.min_gap_m.map_or("-".into(), |v| format!("{:.2}", 1e6 * v)),
            g.force_balance.map_or("-".into(), |v| format!("{v:.1e}")),
            g.newton_iterations.to_string(),
            format!("{:.2}", g.wall_s),
        ]);
    }
    table
}

/// Formats four significant digits, in scientific notation for very small and large values.
fn significant(v: f64) -> String {
    match v.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{v:.3e}"),
        size => format!("{v:.*}", (3 - size.log10().floor() as i32).max(0) as usize),
    }
}

fn expectations(report: &RunReport) -> Table {
    let mut table = Table::new("Expectations of the scene", &["expectation", "", "value", "bound"]);
    let number = |v: Option<f64>| v.map_or("-".into(), significant);
    for e in &report.expectations {
        let held = if e.held { "held" } else { "not held" };
        table.rows.push(vec![e.name.clone(), held.into(), number(e.value), number(e.bound)]);
    }
    table
}
