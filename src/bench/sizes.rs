//! Cost against mesh size: one grasp with pads of increasing numbers of nodes.

use super::clock::{peak_memory, processor_time, reset_peak_memory};
use super::density::{coarser, describe, nodes};
use super::entry::add_stages;
use backend::choose;
use base::error::{Error, Result};
use base::stats::median;
use model::grasp::grasp_poses;
use model::{Model, accuracy};
use record::Status;
use scene::{Element, Pads, Scene, StepperChoice};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use world::run::run_grasp;

/// Cost at one mesh size.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SizePoint {
    /// Spacing or numbers of cells of the pads.
    pub density: String,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// Number of unknowns of the solver.
    pub unknowns: usize,
    /// Number of Newton iterations per frame.
    pub iterations_per_frame: f64,
    /// Wall time of a Newton iteration, s: assembly, factorisation, solve and line search.
    pub time_per_iteration_s: f64,
    /// Wall time of a frame, s.
    pub time_per_frame_s: f64,
    /// Processor time of a frame, all threads, s; null if the system does not provide it.
    pub processor_time_per_frame_s: Option<f64>,
    /// Largest resident memory of the process with this size alone, bytes; null if the system does not provide it.
    pub peak_memory_bytes: Option<u64>,
}

/// Growth of the cost with the mesh size.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SizeStudy {
    /// Sizes from small to large.
    pub sizes: Vec<SizePoint>,
    /// Fitted exponent of the time of an iteration in the number of unknowns; null with fewer than two sizes.
    pub iteration_exponent: Option<f64>,
    /// Fitted exponent of the time of a frame in the number of unknowns.
    pub frame_exponent: Option<f64>,
    /// Fitted exponent of the memory in the number of unknowns.
    pub memory_exponent: Option<f64>,
    /// Number of threads.
    pub threads: usize,
    /// Number of repetitions of each size; times are medians.
    pub repeats: usize,
}

/// Runs the first grasp of `scene` with pads of about `wanted` nodes each, `repeats` times, interleaved over the sizes.
///
/// # Errors
/// Fails for a network scene, a pad that cannot be meshed at another size, and a size at which the grasp does not reach
/// its load.
pub fn cost_by_size(
    scene: &Scene,
    wanted: &[usize],
    threads: usize,
    repeats: usize,
    mut progress: impl FnMut(&str),
) -> Result<SizeStudy> {
    let StepperChoice::Fem(fem) = scene.stepper else {
        return Err(Error::Start("cost against size needs finite elements; the scene's stepper is a network".into()));
    };
    scene.gripper.require_equal_fingers("a bench")?;
    let scene = &accuracy::with_chosen_mesh(scene)?;
    let mut wanted = wanted.to_vec();
    wanted.sort_unstable();
    let mut pads = wanted.iter().map(|n| of_size(&scene.gripper.pads, fem.element, *n)).collect::<Result<Vec<_>>>()?;
    pads.dedup();
    let pose = *grasp_poses(scene)?.first().ok_or_else(|| Error::Start("the scene has no grasp".into()))?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Error::Start(format!("cannot start {threads} threads: {e}")))?;
    let mut turns: Vec<Vec<SizePoint>> = vec![Vec::new(); pads.len()];
    for turn in 0..repeats {
        for (pads, sizes) in pads.iter().zip(&mut turns) {
            let mut scene = scene.clone();
            scene.clear_expectations();
            scene.gripper.pads = pads.clone();
            let density = describe(pads);
            progress(&format!("repetition {} of {repeats}: {density}", turn + 1));
            let known = reset_peak_memory();
            let (model, stepper) = (Model::build(&scene)?, choose(&scene)?);
            model.finger()?;
            let before = processor_time();
            let outcome = pool.install(|| run_grasp(&model, stepper.as_ref(), 0, pose, &()))?;
            let processor = processor_time().zip(before).map(|(now, before)| now - before);
            if outcome.summary.status != Status::Reached {
                let reason = outcome.summary.reason.unwrap_or_default();
                return Err(Error::Solver(format!("pads of {density}: {reason}")));
            }
            let mut stages = BTreeMap::new();
            add_stages(&mut stages, &outcome);
            let newton: f64 =
                ["assembly", "factorization", "solve", "line_search"].iter().filter_map(|s| stages.get(s)).sum();
            let (frames, iterations) = (outcome.summary.frames as f64, outcome.timings.iterations as f64);
            sizes.push(SizePoint {
                density,
                nodes: model.finger()?.body.rest.len(),
                unknowns: model.unknowns().total,
                iterations_per_frame: iterations / frames,
                time_per_iteration_s: newton / iterations,
                time_per_frame_s: outcome.summary.wall_s / frames,
                processor_time_per_frame_s: processor.map(|t| t / frames),
                peak_memory_bytes: peak_memory().filter(|_| known),
            });
        }
    }
    let sizes: Vec<SizePoint> = turns.iter().filter_map(|t| median_point(t)).collect();
    let fit = |pick: fn(&SizePoint) -> Option<f64>| {
        exponent(sizes.iter().filter_map(|s| pick(s).map(|v| (s.unknowns as f64, v))).collect())
    };
    Ok(SizeStudy {
        iteration_exponent: fit(|s| Some(s.time_per_iteration_s)),
        frame_exponent: fit(|s| Some(s.time_per_frame_s)),
        memory_exponent: fit(|s| s.peak_memory_bytes.map(|b| b as f64)),
        threads,
        repeats,
        sizes,
    })
}

/// Returns the median times over the repetitions of one size, and the largest memory.
fn median_point(turns: &[SizePoint]) -> Option<SizePoint> {
    let of = |pick: fn(&SizePoint) -> f64| median(turns.iter().map(pick));
    Some(SizePoint {
        time_per_iteration_s: of(|s| s.time_per_iteration_s),
        time_per_frame_s: of(|s| s.time_per_frame_s),
        processor_time_per_frame_s: Some(of(|s| s.processor_time_per_frame_s.unwrap_or(f64::NAN)))
            .filter(|t| t.is_finite()),
        peak_memory_bytes: turns.iter().filter_map(|s| s.peak_memory_bytes).max(),
        ..turns.first()?.clone()
    })
}

/// Returns `pads` with the cells for which the number of nodes is closest to `wanted`, as a ratio.
fn of_size(pads: &Pads, element: Element, wanted: usize) -> Result<Pads> {
    let count = |factor: f64| coarser(pads, factor).and_then(|p| nodes(&p, element));
    let step = 1.3;
    let (mut fine, mut coarse) = (1.0, 1.0);
    while count(fine)? < wanted {
        fine /= step;
    }
    // The number of cells has a minimum, so the coarsest pad may have more nodes than wanted.
    while count(coarse)? > wanted && coarse < 1e3 {
        coarse *= step;
    }
    let mut best = (f64::INFINITY, 1.0);
    for _ in 0..12 {
        let factor = f64::sqrt(fine * coarse);
        let found = count(factor)?;
        let off = (found as f64 / wanted as f64).ln().abs();
        if off < best.0 {
            best = (off, factor);
        }
        if found > wanted { fine = factor } else { coarse = factor }
    }
    coarser(pads, best.1)
}

/// Fits the exponent of a power law by least squares of the logarithms.
fn exponent(points: Vec<(f64, f64)>) -> Option<f64> {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let xx: f64 = logs.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let xy: f64 = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    (xx > 0.0).then_some(xy / xx)
}

/// Returns the table as text.
pub fn text(report: &SizeStudy) -> String {
    let head = "density    nodes  unknowns  iterations/frame  ms/iteration  s/frame  cpu s/frame  memory MB\n";
    let row = |s: &SizePoint| {
        format!(
            "{:<8} {:>7}  {:>8}  {:>16.1}  {:>12.2}  {:>7.3}  {:>11}  {:>9}\n",
            s.density,
            s.nodes,
            s.unknowns,
            s.iterations_per_frame,
            1e3 * s.time_per_iteration_s,
            s.time_per_frame_s,
            s.processor_time_per_frame_s.map_or("-".into(), |t| format!("{t:.3}")),
            s.peak_memory_bytes.map_or("-".into(), |b| format!("{:.0}", b as f64 / 1e6)),
        )
    };
    let power = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.2}"));
    format!(
        "threads: {}, repetitions: {}\n\n{head}{}\ncost ~ unknowns^p: p = {} (iteration), {} (frame), {} (memory)\n",
        report.threads,
        report.repeats,
        report.sizes.iter().map(row).collect::<String>(),
        power(report.iteration_exponent),
        power(report.frame_exponent),
        power(report.memory_exponent),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power_law_is_found() {
        let points = [10.0, 40.0, 300.0].map(|x: f64| (x, 3.0 * x.powf(1.4))).to_vec();
        assert!(exponent(points).is_some_and(|p| (p - 1.4).abs() < 1e-12));
        assert_eq!(exponent(vec![(5.0, 1.0)]), None);
    }

    #[test]
    fn pads_come_near_the_wanted_number_of_nodes() {
        for wanted in [500, 2000, 9000] {
            let pads = of_size(&Pads::default(), Element::Quadratic, wanted).unwrap();
            let found = nodes(&pads, Element::Quadratic).unwrap() as f64 / wanted as f64;
            assert!((0.7..1.4).contains(&found), "{wanted}: off by a factor of {found}");
        }
    }
}
