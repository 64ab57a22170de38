//! Constants of a press fitted to a measured curve of force against depth, by least squares of relative force errors.
//!
//! ```text
//! scene + curve.rs (table) -> press.rs (forces of given values) -> least_squares.rs -> report.rs, chart.rs
//! ```
//!
//! Each parameter is fitted alone, in pairs, and all together if the table has at least as many points as parameters.

pub mod chart;
pub mod curve;
mod least_squares;
pub mod parameter;
mod press;
pub mod report;

pub use curve::Curve;
pub use parameter::{Parameter, ParameterValues, Ranges};
pub use report::{Fit, FitReport, FittedParameter};

use base::error::Result;
use press::PressRuns;
use rayon::prelude::*;
use scene::Scene;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Fits the press of `scene` to `curve`, with every parameter inside its range, on `threads` threads. Reports each
/// stage to `progress`.
///
/// # Errors
/// Fails for a scene that is not a single press of a gel without gravity, or whose own values lie outside the ranges;
/// for a press that fails with the values of the scene; and with [`base::error::Error::Interrupted`].
pub fn fit(
    scene: &Scene,
    curve: &Curve,
    ranges: &Ranges,
    threads: usize,
    progress: impl Fn(&str) + Sync,
) -> Result<FitReport> {
    let press = PressRuns::new(scene, curve, threads)?;
    let ranges = ranges.above_surface(curve);
    let start = press.start();
    ranges.check(&start)?;
    progress("the press with the values of the scene");
    let given = press.residuals_of(&start)?;
    let sets: Vec<_> = sets().into_iter().filter(|free| free.len() <= curve.points.len()).collect();
    let values = |free: &[Parameter], units: &[Vec<f64>]| -> Vec<ParameterValues> {
        units.iter().map(|u| ranges.values(&start, free, u)).collect()
    };
    // The finite-difference points that all fits begin with, in one parallel batch.
    let beside = least_squares::finite_difference_points(&ranges.units(&start, &Parameter::ALL));
    press.residuals(&values(&Parameter::ALL, &beside))?;
    let done = AtomicUsize::new(0);
    let one = |free: &Vec<Parameter>| {
        let residuals = |units: &[Vec<f64>]| press.residuals(&values(free, units));
        let minimum = least_squares::minimise(&ranges.units(&start, free), residuals)?;
        progress(&format!("{} of {} fits", 1 + done.fetch_add(1, Ordering::Relaxed), sets.len()));
        Ok(Fit::new(free, &start, &ranges, &minimum))
    };
    let fits = press.pool().install(|| sets.par_iter().map(one).collect::<Result<Vec<_>>>())?;
    Ok(FitReport::new(curve, &start, &ranges, given, fits, press.simulations()))
}

/// Returns the sets of simultaneously free parameters: each alone, each pair, all.
fn sets() -> Vec<Vec<Parameter>> {
    let all = Parameter::ALL;
    let pairs = (0..all.len()).flat_map(|a| (a + 1..all.len()).map(move |b| vec![all[a], all[b]]));
    all.iter().map(|p| vec![*p]).chain(pairs).chain([all.to_vec()]).collect()
}
