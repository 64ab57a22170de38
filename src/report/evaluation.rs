//! Section of a data set, and of a network evaluated on it.

use super::chart::{Abscissa, Chart, ChartQuantity, Series};
use super::page::{Page, PageBlock, Section};
use super::recording::{Errors, RecordedState, Recording, dataset_recording};
use super::run::name;
use super::source::ReportOptions;
use super::unfinished::unfinished;
use base::error::{Error, Result};
use base::number::format_count;
use base::table::Table;
use dataset::inspect::sample_frames;
use dataset::{DataSet, Manifest};
use net::eval::table::{ErrorRow, ranks, rows};
use net::eval::{GraspEvaluation, evaluate, frames};
use net::infer::predict::Predictor;
use net::train::data::split;
use net::train::sample::model_of;
use record::PadTopology;
use std::path::Path;

/// Relative errors in tables and charts: key in the error rows, displayed name.
const RELATIVE: [(&str, &str); 4] =
    [("displacement", "displacement"), ("stress", "stress"), ("contact_force", "contact force"), ("travel", "travel")];
/// Errors with a unit in tables: key in the error rows, displayed name.
const ABSOLUTE: [(&str, &str); 5] = [
    ("displacement_mm", "displacement, mm"),
    ("displacement_worst_mm", "largest, mm"),
    ("stress_kpa", "stress, kPa"),
    ("travel_mm", "travel, mm"),
    ("object_deg", "turn of object, deg"),
];

/// Adds the data set in `dir`, and the network of `wishes` evaluated on it.
///
/// # Errors
/// Fails if the data set or the model cannot be read, or if the data is outside of the training range of the model.
pub fn data_set(dir: &Path, wishes: &ReportOptions, page: &mut Page) -> Result<()> {
    if let Some(manifest) = Manifest::read(dir)?
        && !manifest.finished
    {
        unfinished(dir, &manifest, wishes, page);
        return Ok(());
    }
    let set = DataSet::open(dir)?;
    let mut blocks = match &wishes.model {
        Some(model) => evaluate_network(&set, model, wishes, page)?,
        None => {
            let poses = split(&[&set.splits], wishes.split.as_deref().unwrap_or("poses"))?.remove(0).test;
            let all = set.select(&poses);
            for at in sample_frames(all.len(), Some(wishes.grasps)) {
                let (object, grasp) = all[at];
                page.recordings.push(dataset_recording(&set.objects[object], grasp, wishes.frames)?);
            }
            Vec::new()
        }
    };
    blocks.push(PageBlock::Table(objects(&set)));
    blocks.extend(set.damaged.iter().map(|damaged| PageBlock::Note(damaged.to_string())));
    let m = &set.manifest;
    let lead = format!(
        "{} {}, {}, {} each.",
        m.about,
        format_count(m.objects.len(), "object"),
        format_count(m.grasps, "grasp"),
        format_count(m.frames, "frame")
    );
    page.sections.push(Section::new(format!("Data set {}", name(dir)), lead.trim(), blocks));
    Ok(())
}

fn objects(set: &DataSet) -> Table {
    let mut table = Table::new(
        "Objects",
        &["object", "grasps", "reached", "dropped", "fault", "infeasible", "nodes per pad", "tetrahedra"],
    );
    table.folded = true;
    for o in &set.manifest.objects {
        let file = set.objects.iter().find(|f| f.name == o.name);
        let size = |pick: fn(&PadTopology) -> usize| {
            let mut sizes: Vec<_> = file.iter().flat_map(|f| &f.pads).map(|pad| pick(pad).to_string()).collect();
            sizes.dedup();
            if sizes.is_empty() { "-".into() } else { sizes.join(", ") }
        };
        let counts = [o.grasps, o.reached, o.dropped, o.fault, o.infeasible].map(|n| n.to_string());
        let sizes = [size(|pad| pad.rest.len()), size(|pad| pad.elements.len())];
        table.rows.push([o.name.clone()].into_iter().chain(counts).chain(sizes).collect());
    }
    table
}

/// Returns the tables and charts of the network; adds recordings of grasps ranging from the best to the worst to the
/// page.
fn evaluate_network(set: &DataSet, model: &Path, wishes: &ReportOptions, page: &mut Page) -> Result<Vec<PageBlock>> {
    let predictor = Predictor::open(model)?;
    let split = wishes.split.clone().unwrap_or_else(|| predictor.card.split.clone());
    let judged = evaluate(set, &predictor, &split, false)?;
    let table = rows(&split, &judged);
    let mut ranked: Vec<&GraspEvaluation> = judged.iter().filter(|j| !j.frames.is_empty()).collect();
    ranked.sort_by(|a, b| last(a).total_cmp(&last(b)));
    for (at, role) in example_ranks(ranked.len(), wishes.grasps) {
        page.recordings.push(comparison_recording(set, &predictor, ranked[at], &role, wishes.frames)?);
    }
    let (stress, displacement) = ranks(&judged);
    let mut notes = vec![PageBlock::Note(format!(
        "Network {}, {} parameters, split {split}: {}. Kendall's tau of the order of the grasps: {stress:.3} by peak stress, \
         {displacement:.3} by peak displacement.",
        name(model),
        predictor.card.parameters,
        format_count(judged.len(), "test grasp")
    ))];
    if set.manifest.plan == predictor.card.data && split != predictor.card.split {
        let own = &predictor.card.split;
        notes.push(PageBlock::Note(format!(
            "It was trained on split {own} of this data set; {split} may contain grasps of its training data."
        )));
    }
    let note =
        "Median / 90th percentile / worst over grasps and frames above a fifth of the load; with a unit: median.";
    let by = |title: &str, prefix: &'static str| {
        let mut own = errors(title, &table, prefix);
        own.note = note.into();
        PageBlock::Table(own)
    };
    notes.extend([
        PageBlock::Chart(by_object(&table)),
        by("Error by object, table", "object "),
        PageBlock::Chart(by_force(set, &table, &judged)),
        PageBlock::Table(errors("Error by fraction of the load", &table, "load ")),
        PageBlock::Table(worst(&ranked)),
    ]);
    Ok(notes)
}

/// Returns the displacement error at full load, by which grasps are ranked.
fn last(judged: &GraspEvaluation) -> f64 {
    judged.frames.last().map_or(0.0, |f| f.displacement)
}

/// Returns ranks among `count` ranked grasps with their roles: one is the median, two are median and worst, more are
/// spread evenly from the best to the worst.
fn example_ranks(count: usize, wanted: usize) -> Vec<(usize, String)> {
    let Some(end) = count.checked_sub(1) else { return Vec::new() };
    let places: Vec<usize> = match wanted.min(count) {
        0 => Vec::new(),
        1 => vec![end / 2],
        2 => vec![end / 2, end],
        n => (0..n).map(|i| (2 * i * end + n - 1) / (2 * (n - 1))).collect(),
    };
    let role = |at: usize| match at {
        _ if at == end => "worst".into(),
        0 => "best".into(),
        _ if at == end / 2 || at == count / 2 => "median".into(),
        _ => format!("rank {} of {count}", at + 1),
    };
    places.into_iter().map(|at| (at, role(at))).collect()
}

fn comparison_recording(
    set: &DataSet,
    predictor: &Predictor,
    judged: &GraspEvaluation,
    role: &str,
    most: usize,
) -> Result<Recording> {
    let missing = || Error::Start("an evaluated grasp is not in the data set".into());
    let error = judged.frames.last().ok_or_else(missing)?;
    let file = set.objects.iter().find(|f| f.name == error.object).ok_or_else(missing)?;
    let grasp = file.grasp(error.grasp)?;
    let wanted = sample_frames(grasp.frames, Some(most));
    let [truth, predicted] = frames::reference_and_prediction(file, &model_of(file)?, predictor, &grasp, &wanted)?;
    let at = |pick: fn(&net::eval::FrameError) -> f64| {
        let of = |k: &usize| judged.frames.iter().find(|f| f.frame == *k).map_or(f64::NAN, pick);
        wanted.iter().map(of).collect()
    };
    Ok(Recording {
        name: format!("{}, grasp {}", file.name, error.grasp),
        about: format!("{role}: {:.1} % of the displacement", 100.0 * error.displacement),
        pads: file.pads.clone(),
        object: file.object.clone(),
        states: vec![
            RecordedState { label: "finite elements".into(), frames: truth },
            RecordedState { label: "network".into(), frames: predicted },
        ],
        errors: Some(Errors {
            displacement: at(|f| f.displacement),
            stress: at(|f| f.stress),
            contact_force: at(|f| f.contact_force),
        }),
    })
}

/// Returns the error table of the groups whose names start with `prefix`; the table by object includes the group of
/// all.
fn errors(title: &str, table: &[ErrorRow], prefix: &str) -> Table {
    let relative = RELATIVE.map(|(_, name)| format!("{name}, %"));
    let columns: Vec<&str> = ["group", "frames"]
        .into_iter()
        .chain(relative.iter().map(String::as_str))
        .chain(ABSOLUTE.iter().map(|(_, name)| *name))
        .collect();
    let mut out = Table::new(title, &columns);
    let mut groups: Vec<&str> = table.iter().map(|r| r.group.as_str()).collect();
    groups.dedup();
    for group in groups.into_iter().filter(|g| g.starts_with(prefix) || (*g == "all" && prefix == "object ")) {
        let of = |quantity: &str| table.iter().find(|r| r.group == group && r.quantity == quantity);
        let spread = |(quantity, _): &(&str, &str), scale: f64, digits: usize| {
            let row = of(quantity);
            row.map_or("-".into(), |r| {
                [r.median, r.p90, r.worst].map(|v| format!("{:5.digits$}", scale * v)).join(" / ")
            })
        };
        let mut row = vec![group.trim_start_matches(prefix).to_string()];
        row.push(of("displacement").map_or(0, |r| r.samples).to_string());
        row.extend(RELATIVE.iter().map(|q| spread(q, 100.0, 1)));
        row.extend(ABSOLUTE.iter().map(|q| of(q.0).map_or("-".into(), |r| format!("{:.3}", r.median))));
        out.rows.push(row);
    }
    out
}

/// Returns the relative errors of `groups` in percent, for a chart.
fn quantities(table: &[ErrorRow], groups: &[String]) -> Vec<ChartQuantity> {
    let of = |(quantity, name): &(&str, &str)| {
        let pick = |value: fn(&ErrorRow) -> f64| {
            let of = |group: &String| table.iter().find(|r| r.group == *group && r.quantity == *quantity);
            groups.iter().map(|g| of(g).map_or(f64::NAN, |r| 100.0 * value(r))).collect()
        };
        ChartQuantity {
            name: name.to_string(),
            unit: "%".into(),
            series: vec![
                Series::new("median", pick(|r| r.median)),
                Series::new("90 % below", pick(|r| r.p90)),
                Series::new("worst", pick(|r| r.worst)),
            ],
        }
    };
    RELATIVE.iter().map(of).collect()
}

fn by_object(table: &[ErrorRow]) -> Chart {
    let names = table.iter().filter(|r| r.quantity == "displacement").filter_map(|r| r.group.strip_prefix("object "));
    let names: Vec<String> = names.map(String::from).collect();
    let groups: Vec<String> = names.iter().map(|n| format!("object {n}")).collect();
    Chart { title: "Error by object".into(), quantities: quantities(table, &groups), over: Abscissa::Names(names) }
}

fn by_force(set: &DataSet, table: &[ErrorRow], judged: &[GraspEvaluation]) -> Chart {
    let pads = set.objects.first().map_or(1, |o| o.sizes.pads) as f64;
    // All grasps have the same load levels, so the frame index determines the force.
    let frames = judged.first().map_or(&[][..], |j| &j.frames);
    let groups: Vec<String> = frames.iter().map(|f| format!("frame {:03}", f.frame)).collect();
    let over = Abscissa::Axis { label: "force, N".into(), at: frames.iter().map(|f| pads * f.force_n).collect() };
    Chart { title: "Error by force".into(), quantities: quantities(table, &groups), over }
}

fn worst(ranked: &[&GraspEvaluation]) -> Table {
    let columns = ["object", "grasp", "displacement, %", "stress, %", "contact force, %", "travel, %", "largest, mm"];
    let mut table = Table::new("All test grasps at full load, worst first", &columns);
    table.folded = true;
    for f in ranked.iter().rev().filter_map(|j| j.frames.last()) {
        let percent = [f.displacement, f.stress, f.contact_force, f.travel].map(|v| format!("{:.1}", 100.0 * v));
        let row = [f.object.clone(), f.grasp.to_string()].into_iter().chain(percent);
        table.rows.push(row.chain([format!("{:.3}", f.displacement_worst_mm)]).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::example_ranks;

    #[test]
    fn few_grasps_stand_for_many() {
        let of = |count, wanted| {
            example_ranks(count, wanted).into_iter().map(|(at, role)| format!("{at} {role}")).collect::<Vec<_>>()
        };
        assert_eq!(of(9, 1), ["4 median"]);
        assert_eq!(of(9, 2), ["4 median", "8 worst"]);
        assert_eq!(of(9, 3), ["0 best", "4 median", "8 worst"]);
        assert_eq!(of(2, 5), ["0 best", "1 worst"]);
        assert_eq!(of(1, 3), ["0 worst"]);
        assert!(of(0, 3).is_empty());
    }
}
