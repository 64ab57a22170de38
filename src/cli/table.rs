//! Text report of a run.

use backend::simulate::SimulationResult;
use base::number::format_number;
use geometry::Pose;
use mech::path::continuation::MethodCounts;
use model::evaluation::Verdict;
use record::RunReport;
use scene::{Expectation, Scene, StepperChoice};
use std::fmt::Write;
use world::run::Outcome;

/// Renders the heading, a row per grasp, the expectations and the profile.
pub fn render(scene: &Scene, grasps: &[(usize, Pose)], simulated: &SimulationResult) -> String {
    let SimulationResult { outcomes, verdicts, report, wall_s } = simulated;
    let mut out = String::new();
    // Writing to a String cannot fail, so the results below are ignored.
    if !scene.about.is_empty() {
        let _ = writeln!(out, "{}", scene.about);
    }
    let mut sizes: Vec<String> =
        report.pads.iter().map(|p| format!("{} nodes, {} tetrahedra", p.nodes, p.tets)).collect();
    sizes.dedup();
    let sizes = if sizes.is_empty() { "0 nodes, 0 tetrahedra".into() } else { sizes.join(", and of ") };
    let _ = writeln!(
        out,
        "{} on {} thread{}; {} pad{} of {sizes}\n",
        report.backend,
        report.threads,
        plural(report.threads),
        report.pads.len(),
        plural(report.pads.len()),
    );
    rows(&mut out, grasps, outcomes);
    if !verdicts.is_empty() {
        out.push('\n');
        if let StepperChoice::Gnn(_) = scene.stepper {
            let _ = writeln!(out, "expectations from {}:", scene.expectations_source());
        }
        scene.expectations().iter().zip(verdicts).for_each(|(e, h)| expectation(&mut out, e, h));
    }
    profile(&mut out, outcomes, report, *wall_s);
    out
}

fn plural(n: usize) -> &'static str {
    if n == 1 { "" } else { "s" }
}

fn rows(out: &mut String, grasps: &[(usize, Pose)], outcomes: &[Outcome]) {
    out.push_str(
        "grasp  status      frames  force N  travel mm  stress kPa   gap um  min det F  balance  iterations  time s\n",
    );
    for ((index, _), o) in grasps.iter().zip(outcomes) {
        let s = &o.summary;
        let status = s.status.as_str();
        let optional = |value: Option<f64>, scale: f64, digits: usize| {
            value.filter(|v| v.is_finite()).map_or("-".into(), |v| format!("{:.digits$}", v * scale))
        };
        let some = (s.frames > 0).then_some(());
        let _ = writeln!(
            out,
            "{index:>5}  {status:<10}  {:>6}  {:>7}  {:>9}  {:>10}  {:>7}  {:>9}  {:>7}  {:>10}  {:>6.2}",
            s.frames,
            optional(some.map(|()| s.force_n), 1.0, 3),
            optional(some.map(|()| s.travel_m), 1e3, 4),
            optional(Some(o.measured.max_stress_pa), 1e-3, 2),
            optional(s.min_gap_m, 1e6, 2),
            optional(s.min_det_f, 1.0, 3),
            s.force_balance.map_or("-".into(), |b| format!("{b:.0e}")),
            s.newton_iterations,
            s.wall_s,
        );
        if let Some(reason) = &s.reason {
            let _ = writeln!(out, "       {reason}");
        }
        if let Some(reason) = &s.handed_over {
            let _ = writeln!(out, "       computed by finite elements: {reason}");
        }
        if let Some(error) = &s.error {
            let _ = writeln!(out, "       {error}");
        }
        for moved in &s.sensitivity {
            let _ = match moved.displacement.zip(moved.object_m) {
                Some((pads, object)) => writeln!(
                    out,
                    "       {}: the pad displacement changes by {:.1} %, the object moves by {:.3} mm",
                    moved.change.name(),
                    1e2 * pads,
                    1e3 * object
                ),
                None => writeln!(out, "       {}: {}", moved.change.name(), moved.status.as_str()),
            };
        }
    }
}

fn expectation(out: &mut String, expectation: &Expectation, held: &Verdict) {
    let mut text = held.to_string();
    if let Expectation::ForceAt(at) = expectation {
        let _ = write!(text, " (+-{} %) at {} mm", 100.0 * at.relative.get(), format_number(1e3 * at.depth.get()));
    }
    let _ = writeln!(out, "{}  {:<14} {text}", held.label(), held.name);
}

fn profile(out: &mut String, outcomes: &[Outcome], report: &RunReport, wall: f64) {
    let total: f64 = report.profile_s.values().sum();
    let iterations: u64 = outcomes.iter().map(|o| o.timings.iterations).sum();
    if total <= 0.0 {
        return;
    }
    let mut stages: Vec<_> = report.profile_s.iter().collect();
    stages.sort_by(|a, b| b.1.total_cmp(a.1));
    let shares: Vec<_> = stages.iter().map(|(name, s)| format!("{name} {:.0} %", 100.0 * **s / total)).collect();
    let _ = writeln!(out, "\n{wall:.2} s wall, {iterations} Newton iterations: {}", shares.join(", "));
    let mut methods = MethodCounts::default();
    outcomes.iter().for_each(|o| methods += o.timings.methods);
    if methods != MethodCounts::default() {
        let _ = writeln!(out, "{methods}");
    }
    let stage = |name: &str| report.profile_s.get(name).copied().unwrap_or(0.0);
    let factorization = stage("factorization");
    if factorization > 0.0 && iterations > 0 {
        let whole = factorization + stage("assembly") + stage("solve") + stage("line_search");
        let _ = writeln!(
            out,
            "one Newton iteration takes {:.1} ms, {:.1} times the time of its factorisation",
            1e3 * whole / iterations as f64,
            whole / factorization
        );
    }
}
