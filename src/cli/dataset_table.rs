//! Text report of `tactus dataset`.

use base::number::format_count;
use base::stats::median;
use dataset::Manifest;
use dataset::sensitivity::SensitivityRow;
use std::fmt::Write;
use world::run::sensitivity::CHANGES;

/// Returns the text report of a data set: a row for each object with its numbers of grasps by status and its size (MB),
/// then the failed grasps with their reasons, the expectations and their verdicts, and the time per computed grasp.
/// `resumed` is the number of grasps that an earlier run had computed, `wall` the wall time of this run, s.
pub(super) fn dataset_text(manifest: &Manifest, resumed: usize, wall: f64) -> String {
    let mut out = String::from("object            grasps  reached  dropped  fault  infeasible        MB\n");
    // Writing to a String cannot fail.
    for o in &manifest.objects {
        let (mb, name) = (o.bytes as f64 / 1e6, &o.name);
        let _ = writeln!(
            out,
            "{name:<16}  {:>6}  {:>7}  {:>7}  {:>5}  {:>10}  {mb:>8.2}",
            o.grasps, o.reached, o.dropped, o.fault, o.infeasible
        );
    }
    for o in &manifest.objects {
        for f in &o.failures {
            let _ = writeln!(out, "{} grasp {}: {}", o.name, f.grasp, f.reason);
        }
    }
    for o in &manifest.objects {
        for p in &o.expectations {
            let (verdict, worst) = (p.worst.label(), &p.worst);
            let by: Vec<String> = p.broken_by.iter().map(usize::to_string).collect();
            let by = if by.is_empty() { String::new() } else { format!(" (grasps {})", by.join(", ")) };
            let _ = writeln!(out, "{verdict}  {:<16} {:<14} at worst {worst}{by}", o.name, worst.name);
        }
    }
    let computed = manifest.grasps - resumed;
    let rate = if computed > 0 { format!(", {:.2} s per grasp", wall / computed as f64) } else { String::new() };
    let _ = writeln!(
        out,
        "{} of {} grasps reached; {computed} computed in {wall:.1} s{rate}; {resumed} were already finished",
        manifest.sum(|o| o.reached),
        manifest.grasps
    );
    out
}

/// Returns the text report of a sensitivity study, a line per kind of change: median and largest change of the pad
/// displacement (%) and of the displacement of the object (mm), over the grasps that reach their load with and without
/// the change.
pub(super) fn sensitivity_text(spreads: &[SensitivityRow]) -> String {
    let mut out = String::new();
    for change in CHANGES {
        let moved = spreads.iter().filter(|s| s.change == change).filter_map(|s| s.displacement.zip(s.object_m));
        let (pads, object): (Vec<_>, Vec<_>) = moved.unzip();
        if pads.is_empty() {
            continue;
        }
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "{}: the pad displacements of {} change by {:.2} % (median) to {:.1} % (largest), the objects move by \
             {:.3} to {:.2} mm",
            change.name(),
            format_count(pads.len(), "grasp"),
            1e2 * median(pads.iter().copied()),
            1e2 * most(&pads),
            1e3 * median(object.iter().copied()),
            1e3 * most(&object),
        );
    }
    out
}
