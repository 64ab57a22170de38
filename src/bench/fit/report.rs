//! Results of fitting a press to a measured curve, as numbers and as text.

use super::least_squares::{Minimum, rms};
use super::{Curve, Parameter, ParameterValues, Ranges};
use base::number::{format_number, round_significant};
use serde::Serialize;
use std::fmt::Write;

/// Root mean square of the relative residuals below which the scene already matches the table.
const MATCH_RMS: f64 = 1e-3;
/// Largest number of points whose residuals are listed individually.
const MAX_LISTED: usize = 8;

/// Fitted value of a parameter, with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FittedParameter {
    /// Parameter that was free in the fit.
    pub parameter: Parameter,
    /// Fitted value, in the SI unit of the parameter.
    pub value: f64,
    /// Half the width of the 95 % confidence interval (Student's t, linearised), in the SI unit of the parameter. None
    /// if [`Fit::freedom`] is zero, the value is at an end of its range, or the data do not determine the parameter.
    pub interval: Option<f64>,
    /// True if the value is at an end of its range.
    pub at_edge: bool,
}

/// Fit with some parameters free and the others at the values of the scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fit {
    /// Free parameters.
    pub free: Vec<FittedParameter>,
    /// All values, SI, in the order of [`Parameter::ALL`].
    pub values: ParameterValues,
    /// Simulated over measured force, minus one, at each depth.
    pub residuals: Vec<f64>,
    /// Root mean square of `residuals`.
    pub rms: f64,
    /// Degrees of freedom: number of points minus number of parameters inside their ranges; at zero there are no
    /// intervals.
    pub freedom: usize,
    /// True if the least-squares iteration converged.
    pub converged: bool,
    /// Number of Levenberg-Marquardt iterations.
    pub iterations: usize,
}

impl Fit {
    pub(super) fn new(free: &[Parameter], start: &ParameterValues, ranges: &Ranges, minimum: &Minimum) -> Self {
        let values = ranges.values(start, free, &minimum.at);
        let estimate = |((p, u), interval): ((&Parameter, &f64), Option<f64>)| FittedParameter {
            parameter: *p,
            value: values[*p as usize],
            interval: interval.map(|half| half * ranges.width(*p as usize)),
            at_edge: *u <= 0.0 || *u >= 1.0,
        };
        Self {
            free: free.iter().zip(&minimum.at).zip(minimum.intervals()).map(estimate).collect(),
            values,
            rms: minimum.rms(),
            residuals: minimum.residual.clone(),
            freedom: minimum.degrees_of_freedom(),
            converged: minimum.converged,
            iterations: minimum.iterations,
        }
    }

    /// Returns the name of the fit: the names of its free parameters, separated by commas, or `all`.
    pub fn name(&self) -> String {
        if self.free.len() == Parameter::ALL.len() {
            return "all".into();
        }
        let names: Vec<&str> = self.free.iter().map(|e| e.parameter.name()).collect();
        names.join(", ")
    }

    /// Returns the largest absolute value of `residuals`.
    pub fn largest(&self) -> f64 {
        largest(&self.residuals)
    }
}

fn largest(residuals: &[f64]) -> f64 {
    residuals.iter().fold(0.0, |most, r| most.max(r.abs()))
}

/// Results of all fits of a press to a measured curve of force against depth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitReport {
    /// Depths of the measured curve, m.
    pub depths_m: Vec<f64>,
    /// Measured force at each depth, N.
    pub forces_n: Vec<f64>,
    /// Parameters, in the order of `start`, `ranges` and the values of a fit.
    pub parameters: [Parameter; 4],
    /// Values of the parameters in the scene, SI.
    pub start: ParameterValues,
    /// Smallest and largest allowed value of each parameter, SI.
    pub ranges: [[f64; 2]; 4],
    /// Simulated over measured force, minus one, at each depth, with the values of the scene.
    pub given: Vec<f64>,
    /// Root mean square of `given`.
    pub given_rms: f64,
    /// Fits with each parameter free alone, each pair, and all, as far as the curve has enough points.
    pub fits: Vec<Fit>,
    /// Parameter whose fit alone has the smallest root mean square residual; None if the scene already matches the
    /// curve (`given_rms` at most 1e-3).
    pub explains: Option<Parameter>,
    /// Number of simulated presses.
    pub simulations: usize,
}

impl FitReport {
    pub(super) fn new(
        curve: &Curve,
        start: &ParameterValues,
        ranges: &Ranges,
        given: Vec<f64>,
        fits: Vec<Fit>,
        simulations: usize,
    ) -> Self {
        let given_rms = rms(&given);
        let singles = fits.iter().filter(|f| f.free.len() == 1);
        let best = singles.min_by(|a, b| a.rms.total_cmp(&b.rms)).filter(|_| given_rms > MATCH_RMS);
        Self {
            depths_m: curve.points.iter().map(|p| p.0).collect(),
            forces_n: curve.points.iter().map(|p| p.1).collect(),
            parameters: Parameter::ALL,
            start: *start,
            ranges: ranges.0,
            given,
            given_rms,
            explains: best.map(|f| f.free[0].parameter),
            fits,
            simulations,
        }
    }

    /// Returns true if every fit converged.
    pub fn converged(&self) -> bool {
        self.fits.iter().all(|f| f.converged)
    }

    /// Returns the fraction of the sum of squared residuals of the unchanged scene that `fit` removes, at most 1.
    pub fn explained_fraction(&self, fit: &Fit) -> f64 {
        1.0 - (fit.rms / self.given_rms).powi(2)
    }

    /// Returns the fit with the smallest root mean square residual among those with `count` free parameters; None if
    /// there are none.
    pub fn best(&self, count: usize) -> Option<&Fit> {
        self.fits.iter().filter(|f| f.free.len() == count).min_by(|a, b| a.rms.total_cmp(&b.rms))
    }

    /// Returns the report as text: a row for the unchanged scene and for each fit, with values, intervals and residuals
    /// in %, then the ranges and the parameter that explains most of the deviation.
    pub fn text(&self) -> String {
        let mut out = format!("{:<20}", "free");
        // Writing to a String cannot fail.
        Parameter::ALL.iter().for_each(|p| out += &format!("{:>17}", p.shown_as().0));
        let listed = self.depths_m.len() <= MAX_LISTED;
        if listed {
            self.depths_m.iter().for_each(|d| out += &format!("{:>9}", format!("{} mm", format_number(d * 1e3))));
        }
        out += "  largest     rms\n";
        self.row(&mut out, "values of the scene", self.start.map(|v| (v, String::new())), &self.given, self.given_rms);
        for fit in &self.fits {
            let cells = Parameter::ALL.map(|p| match fit.free.iter().find(|e| e.parameter == p) {
                Some(estimate) => (estimate.value, note(estimate)),
                None => (f64::NAN, String::new()),
            });
            self.row(&mut out, &fit.name(), cells, &fit.residuals, fit.rms);
            if !fit.converged {
                out += "    did not converge\n";
            }
        }
        out += "\nsimulated over measured force, minus one; +-: interval of 95 % confidence (Student's t, to first order)\n";
        out += "edge: at the end of its range; no +-: no interval, because there are as many parameters as points or \
            the value is at an edge\n";
        let ranges = Parameter::ALL.iter().zip(self.ranges).map(|(p, [low, high])| {
            let (name, scale) = p.shown_as();
            format!("{name} {} to {}", format_number(low * scale), format_number(high * scale))
        });
        let _ = writeln!(out, "ranges: {}", ranges.collect::<Vec<_>>().join(", "));
        out += &self.explanation();
        out
    }

    fn row(&self, out: &mut String, name: &str, cells: [(f64, String); 4], residuals: &[f64], rms: f64) {
        *out += &format!("{name:<20}");
        for (p, (value, note)) in Parameter::ALL.iter().zip(cells) {
            let text =
                if value.is_nan() { ".".into() } else { format!("{}{note}", format_4_digits(value * p.shown_as().1)) };
            *out += &format!("{text:>17}");
        }
        if residuals.len() <= MAX_LISTED {
            residuals.iter().for_each(|r| *out += &format!("{:>+7.1} %", 100.0 * r));
        }
        let _ = writeln!(out, "{:>7.1} % {:>5.1} %", 100.0 * largest(residuals), 100.0 * rms);
    }

    /// Names the parameter that explains the deviation.
    fn explanation(&self) -> String {
        let Some(explains) = self.explains else {
            return "the scene agrees with the table: there is no deviation to explain\n".into();
        };
        let singles = self.fits.iter().filter(|f| f.free.len() == 1);
        let shares: Vec<String> = singles
            .map(|f| format!("{} {:.0} %", f.free[0].parameter.words(), 100.0 * self.explained_fraction(f)))
            .collect();
        let mut text = format!(
            "{} alone explains most of the deviation; fractions of its sum of squares: {}\n",
            explains.words(),
            shares.join(", ")
        );
        for fit in [1, 2, 4].into_iter().filter_map(|count| self.best(count)) {
            let _ = writeln!(
                text,
                "best with {} free: {}, within {:.1} %",
                fit.free.len(),
                fit.name(),
                100.0 * fit.largest()
            );
        }
        text
    }
}

/// Returns the suffix of a fitted value in the table.
fn note(estimate: &FittedParameter) -> String {
    match estimate.interval {
        Some(half) => format!(" +-{}", format_2_digits(half * estimate.parameter.shown_as().1)),
        None if estimate.at_edge => " edge".into(),
        None => String::new(),
    }
}

/// Formats to four significant digits.
pub(super) fn format_4_digits(v: f64) -> String {
    format_number(round_significant(v, 4))
}

/// Formats to two significant digits.
pub(super) fn format_2_digits(v: f64) -> String {
    format_number(round_significant(v, 2))
}
