//! Section of an unfinished data set: progress, and grasps that have ended.

use super::page::{Page, PageBlock, Section};
use super::recording::dataset_recording;
use super::run::name;
use super::source::ReportOptions;
use base::number::format_count;
use base::table::Table;
use dataset::inspect::sample_frames;
use dataset::{Manifest, unfinished};
use record::Status;
use std::path::Path;

/// Adds the unfinished data set in `dir`. Grasps that cannot be read yet are skipped.
pub fn unfinished(dir: &Path, manifest: &Manifest, wishes: &ReportOptions, page: &mut Page) {
    let mut table = Table::new("Objects", &["object", "grasps", "ended", "reached"]);
    let (mut ended, mut shown) = (0, Vec::new());
    for object in &manifest.objects {
        let finished = unfinished::finished(dir, object);
        let reached = finished.values().filter(|f| f.status == Status::Reached).map(|f| f.grasp);
        let reached: Vec<usize> = reached.collect();
        let counts = [object.grasps, finished.len(), reached.len()].map(|n| n.to_string());
        table.rows.push([object.name.clone()].into_iter().chain(counts).collect());
        ended += finished.len();
        shown.extend(reached.into_iter().map(|grasp| (object, grasp)));
    }
    for at in sample_frames(shown.len(), Some(wishes.grasps)) {
        let (object, grasp) = shown[at];
        let recording = unfinished::file(dir, object).and_then(|file| dataset_recording(&file, grasp, wishes.frames));
        page.recordings.extend(recording);
    }
    let mut blocks = vec![PageBlock::Table(table)];
    if wishes.model.is_some() {
        blocks.push(PageBlock::Note("The network is evaluated once the data set is finished.".into()));
    }
    let all = format_count(manifest.grasps, "grasp");
    let lead = format!("{} The data set is not finished: so far {ended} of {all} ended.", manifest.about);
    page.sections.push(Section::new(format!("Data set {}", name(dir)), lead.trim(), blocks));
}
