//! Text and CSV reports of a comparison of speed and error.

use super::quantity::QUANTITIES;
use super::refinement_study::RefinementStudy;
use super::report::{BenchReport, Point};
use std::fmt::Write;

/// Returns the report as text: a table with a row per configuration (wall times in s, errors against the reference in
/// %, median / 90th percentile / worst), the time profile of each, failures and notices, the mesh refinement study, and
/// the speed-ups at equal error.
pub fn text(report: &BenchReport) -> String {
    let width = report.points.iter().chain([&report.reference]).map(|p| p.label.len()).max().unwrap_or(0);
    let mut out = format!(
        "grasps: {}, repetitions: {}, threads: {}; errors in % against the reference, median / p90 / worst\n\n",
        report.grasps.len(),
        report.repeats,
        report.threads,
    );
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  {:<width$}  nodes   cold s  s/grasp  ms/frame  cpu s/grasp          displacement                stress   force  travel",
        "configuration"
    );
    for p in report.points.iter().chain([&report.reference]) {
        let spread = |name: &str, estimate: Option<f64>| match (p.errors.get(name), estimate) {
            (Some(s), _) => [s.median, s.p90, s.worst].map(|v| format!("{:5.1}", 100.0 * v)).join(" / "),
            (None, Some(e)) => format!("about {:.1}", 100.0 * e),
            (None, None) => "-".into(),
        };
        let middle = |e: Option<f64>| e.map_or("-".into(), |e| format!("{:.1}", 100.0 * e));
        let _ = writeln!(
            out,
            "{} {:<width$}  {:>5}  {:>7.3}  {:>7.4}  {:>8.3}  {:>11}  {:>20}  {:>20}  {:>6}  {:>6}",
            if p.dominated || p.errors.is_empty() { ' ' } else { '*' },
            p.label,
            p.nodes,
            p.cold_s,
            p.time_per_grasp_s,
            1e3 * p.time_per_frame_s,
            p.processor_time_per_grasp_s.map_or("-".into(), |t| format!("{t:.4}")),
            spread("displacement", p.displacement_error),
            spread("stress", p.stress_error),
            middle(p.force_error),
            middle(p.travel_error),
        );
    }
    out +=
        "\n* no other setting is as fast and as accurate in displacement; the reference's own error is an estimate\n\n";
    report.points.iter().chain([&report.reference]).for_each(|p| profile(&mut out, p, width));
    for p in &report.points {
        p.failed.iter().for_each(|reason| {
            let _ = writeln!(out, "{}: {reason}", p.label);
        });
    }
    report.notices.iter().for_each(|notice| {
        let _ = writeln!(out, "note: {notice}");
    });
    out += &refinement_text(&report.refinement_study);
    headline(&mut out, report);
    out
}

/// Returns the text of a mesh refinement study: its members, the relative differences of their displacement, stress and
/// force in %, the error estimate of the reference in %, with its parts and the observed order of convergence, and its
/// findings.
pub fn refinement_text(study: &RefinementStudy) -> String {
    let width = study.members.iter().map(|m| m.label.len()).max().unwrap_or(0);
    let percent = |v: Option<f64>| v.map_or("-".into(), |v| format!("{:.2}", 100.0 * v));
    let mut out =
        String::from("\ndifferences between the members of the refinement study, %: displacement, stress, force\n");
    for (i, m) in study.members.iter().enumerate() {
        let time = m.time_per_grasp_s.map_or("-".into(), |t| format!("{t:.2}"));
        let _ = write!(out, "{}  {:<width$}  {:>6} nodes {time:>8} s ", i + 1, m.label, m.nodes);
        for name in ["displacement", "stress", "force"] {
            let row = study.distances.get(name).map_or(&[][..], |table| &table[i]);
            let cells = (0..study.members.len()).map(|j| format!("{:>6}", percent(row.get(j).copied().flatten())));
            let _ = write!(out, " |{}", cells.collect::<String>());
        }
        out.push('\n');
    }
    out += "\nerror of the reference, %        error    last refinement   another mesh   path   order\n";
    for (name, e) in &study.errors {
        let _ = writeln!(
            out,
            "  {name:<26} {:>9} {:>18} {:>14} {:>6} {:>7}",
            percent(e.error),
            percent(e.by_levels),
            percent(e.by_alternative_mesh),
            percent(e.by_path),
            e.order.map_or("-".into(), |p| format!("{p:.1}")),
        );
    }
    study.findings.iter().for_each(|finding| {
        let _ = writeln!(out, "note: {finding}");
    });
    out
}

fn profile(out: &mut String, p: &Point, width: usize) {
    let mut stages: Vec<_> = p.profile.iter().collect();
    stages.sort_by(|a, b| b.1.total_cmp(a.1));
    let shares: Vec<_> = stages.iter().map(|(name, share)| format!("{name} {:.0} %", 100.0 * **share)).collect();
    let memory = p.peak_memory_bytes.map_or(String::new(), |b| format!("{:.0} MB, ", b as f64 / 1e6));
    let _ = writeln!(
        out,
        "  {:<width$}  {memory}{:.1} iterations per frame: {}",
        p.label,
        p.iterations_per_frame,
        shares.join(", ")
    );
}

fn headline(out: &mut String, report: &BenchReport) {
    out.push('\n');
    let mut contenders = report.points.iter().filter(|p| p.contender).peekable();
    if contenders.peek().is_none() {
        *out += "speed-up at equal error: no setting to compare; give a network with --model\n";
    }
    for p in contenders {
        p.speedups().iter().for_each(|speedup| {
            let _ = writeln!(out, "{speedup}");
        });
    }
}

/// Returns a CSV table with a row per configuration, the reference last: label, backend, sizes, times (s), memory
/// (bytes), number of failed grasps, and median, 90th percentile and worst of every error. SI units are part of the
/// column names; an error without a unit is relative. Unknown values are empty.
pub fn csv(report: &BenchReport) -> String {
    let mut columns: Vec<String> =
        ["label", "backend", "nodes", "unknowns", "cold_s", "time_per_grasp_s", "time_per_frame_s"]
            .map(String::from)
            .to_vec();
    columns.extend(["processor_time_per_grasp_s", "peak_memory_bytes", "failed", "dominated"].map(String::from));
    for (name, _) in QUANTITIES {
        columns.extend(["median", "p90", "worst"].map(|part| format!("{name}_{part}")));
    }
    let mut out = format!("{}\n", columns.join(","));
    for p in report.points.iter().chain([&report.reference]) {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:e}"));
        let mut row = vec![
            format!("\"{}\"", p.label.replace('"', "\"\"")),
            p.backend.clone(),
            p.nodes.to_string(),
            p.unknowns.map_or(String::new(), |n| n.to_string()),
            number(Some(p.cold_s)),
            number(Some(p.time_per_grasp_s)),
            number(Some(p.time_per_frame_s)),
            number(p.processor_time_per_grasp_s),
            p.peak_memory_bytes.map_or(String::new(), |b| b.to_string()),
            p.failed.len().to_string(),
            p.dominated.to_string(),
        ];
        for (name, _) in QUANTITIES {
            let spread = p.errors.get(name);
            row.extend([spread.map(|s| s.median), spread.map(|s| s.p90), spread.map(|s| s.worst)].map(number));
        }
        out += &format!("{}\n", row.join(","));
    }
    out
}
