//! Bounded nonlinear least squares: Levenberg-Marquardt on the unit box, with finite-difference derivatives and a
//! confidence interval of each unknown.

use base::error::{Error, Result};
use distrs::StudentsT;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Finite-difference step: well above the noise of a simulation (about 1e-4 of a force).
const DIFFERENCE_STEP: f64 = 0.05;
/// Largest component of a step below which the fit has converged.
const STEP_TOLERANCE: f64 = 1e-3;
/// Root mean square below which the residuals are at the noise level of a simulation.
const NOISE_LEVEL: f64 = 1e-4;
/// Relative decrease of the sum of squares below which the fit has stalled.
const MIN_DECREASE: f64 = 1e-3;
/// Largest number of iterations.
const MAX_ITERATIONS: usize = 30;
/// Initial damping, a fraction of the diagonal of the normal matrix; it is divided by ten after a step that decreases
/// the squares and multiplied by ten after one that does not.
const INITIAL_DAMPING: f64 = 1e-3;
/// Damping beyond which the iteration ends.
const MAX_DAMPING: f64 = 1e6;
/// Confidence level of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Minimum of the sum of squares.
pub struct Minimum {
    /// Unknowns at the minimum, each in 0..=1.
    pub at: Vec<f64>,
    /// Residuals at the minimum.
    pub residual: Vec<f64>,
    /// Derivatives of the residuals at the minimum: a row per residual, a column per unknown.
    jacobian: Mat<f64>,
    /// True if the fit converged.
    pub converged: bool,
    /// Number of iterations.
    pub iterations: usize,
}

/// Minimises the squares from `start`. `residuals` takes several points at once; it returns None for a point without
/// residuals.
///
/// # Errors
/// Fails if `residuals` fails, or returns None at `start` or at a finite-difference point of an iterate.
pub fn minimise(start: &[f64], residuals: impl Fn(&[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>>) -> Result<Minimum> {
    let failed = || {
        Error::Argument(
            "a press fails close to the parameters of a successful one; narrow the ranges with --range".into(),
        )
    };
    let all = |points: &[Vec<f64>]| residuals(points)?.into_iter().collect::<Option<Vec<_>>>().ok_or_else(failed);
    let first = all(&[start.to_vec()])?.swap_remove(0);
    let jacobian = differences(start, &first, all)?;
    let mut now = Minimum { at: start.to_vec(), residual: first, jacobian, converged: false, iterations: 0 };
    let (mut damping, mut stalled) = (INITIAL_DAMPING, false);
    while now.iterations < MAX_ITERATIONS {
        now.iterations += 1;
        now.converged = stalled || now.rms() < NOISE_LEVEL;
        while !now.converged {
            let next = now.step(damping);
            let moved = next.iter().zip(&now.at).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            if moved < STEP_TOLERANCE || damping > MAX_DAMPING {
                now.converged = true;
                break;
            }
            let better = residuals(std::slice::from_ref(&next))?.swap_remove(0).filter(|r| squares(r) < now.squares());
            if let Some(residual) = better {
                stalled = now.squares() - squares(&residual) < MIN_DECREASE * now.squares();
                (now.at, now.residual) = (next, residual);
                now.jacobian = differences(&now.at, &now.residual, all)?;
                damping *= 0.1;
                break;
            }
            damping *= 10.0;
        }
        if now.converged {
            break;
        }
    }
    Ok(now)
}

fn squares(residual: &[f64]) -> f64 {
    residual.iter().map(|r| r * r).sum()
}

/// Computes the root mean square.
pub fn rms(residual: &[f64]) -> f64 {
    (squares(residual) / residual.len().max(1) as f64).sqrt()
}

/// Returns the finite-difference step at `u`, towards the centre of the box.
fn step(u: f64) -> f64 {
    if u < 0.5 { DIFFERENCE_STEP } else { -DIFFERENCE_STEP }
}

/// Returns the finite-difference points of `at`, one per unknown.
pub fn finite_difference_points(at: &[f64]) -> Vec<Vec<f64>> {
    let point = |k: usize| at.iter().enumerate().map(|(i, u)| if i == k { u + step(*u) } else { *u }).collect();
    (0..at.len()).map(point).collect()
}

/// Computes the Jacobian at a point with residuals `base`.
fn differences(at: &[f64], base: &[f64], all: impl Fn(&[Vec<f64>]) -> Result<Vec<Vec<f64>>>) -> Result<Mat<f64>> {
    let columns = all(&finite_difference_points(at))?;
    Ok(Mat::from_fn(base.len(), at.len(), |i, k| (columns[k][i] - base[i]) / step(at[k])))
}

impl Minimum {
    fn squares(&self) -> f64 {
        squares(&self.residual)
    }

    /// Returns the root mean square of the residuals.
    pub fn rms(&self) -> f64 {
        rms(&self.residual)
    }

    /// Returns half the derivative of the sum of squares with respect to unknown `k`.
    fn gradient(&self, k: usize) -> f64 {
        self.residual.iter().enumerate().map(|(i, r)| self.jacobian[(i, k)] * r).sum()
    }

    /// Returns the normal matrix (Gauss-Newton Hessian) of some unknowns.
    fn normal(&self, of: &[usize]) -> Mat<f64> {
        let product = |a: usize, b: usize| {
            (0..self.residual.len()).map(|i| self.jacobian[(i, of[a])] * self.jacobian[(i, of[b])]).sum()
        };
        Mat::from_fn(of.len(), of.len(), product)
    }

    /// Returns the end of a step. Unknowns at a bound with an outward descent direction stay there (active set).
    fn step(&self, damping: f64) -> Vec<f64> {
        let held = |k: usize| {
            let slope = self.gradient(k);
            (self.at[k] <= 0.0 && slope >= 0.0) || (self.at[k] >= 1.0 && slope <= 0.0)
        };
        let free: Vec<usize> = (0..self.at.len()).filter(|k| !held(*k)).collect();
        let mut next = self.at.clone();
        if free.is_empty() {
            return next;
        }
        let mut matrix = self.normal(&free);
        (0..free.len()).for_each(|k| matrix[(k, k)] += damping * matrix[(k, k)] + f64::MIN_POSITIVE);
        let right = Mat::from_fn(free.len(), 1, |k, _| -self.gradient(free[k]));
        if let Ok(factor) = matrix.llt(Side::Lower) {
            let step: Mat<f64> = factor.solve(&right);
            free.iter().enumerate().for_each(|(k, &of)| next[of] = (next[of] + step[(k, 0)]).clamp(0.0, 1.0));
        }
        next
    }

    /// Returns the unknowns that are not at a bound.
    fn inside(&self) -> Vec<usize> {
        (0..self.at.len()).filter(|&k| self.at[k] > 0.0 && self.at[k] < 1.0).collect()
    }

    /// Returns the degrees of freedom: the number of residuals minus the number of unknowns that are not at a bound.
    pub fn degrees_of_freedom(&self) -> usize {
        self.residual.len().saturating_sub(self.inside().len())
    }

    /// Returns half the width of the 95 % confidence interval of each unknown (Student's t, to first order). None at a
    /// bound, without degrees of freedom, and if the normal matrix is singular.
    pub fn intervals(&self) -> Vec<Option<f64>> {
        let (inside, freedom) = (self.inside(), self.degrees_of_freedom());
        let mut intervals = vec![None; self.at.len()];
        if inside.is_empty() || freedom == 0 {
            return intervals;
        }
        let Ok(factor) = self.normal(&inside).llt(Side::Lower) else { return intervals };
        let inverse: Mat<f64> = factor.solve(Mat::<f64>::identity(inside.len(), inside.len()));
        let quantile = StudentsT::ppf(0.5 + 0.5 * CONFIDENCE, freedom as f64);
        let variance = self.squares() / freedom as f64;
        for (k, &of) in inside.iter().enumerate() {
            intervals[of] = Some(quantile * (variance * inverse[(k, k)]).sqrt()).filter(|v| v.is_finite());
        }
        intervals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks a line fitted to points that are off by +-1 hundredth against textbook values, and an active bound.
    #[test]
    fn a_line_has_the_textbook_interval_and_a_bound_holds() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [0.11, 0.19, 0.31, 0.39]);
        let line = |points: &[Vec<f64>]| {
            let of = |u: &Vec<f64>| Some((0..4).map(|i| u[0] + u[1] * x[i] - y[i]).collect::<Vec<_>>());
            Ok(points.iter().map(of).collect())
        };
        let found = minimise(&[0.5, 0.5], line).unwrap();
        assert!(found.converged && (found.at[0] - 0.106).abs() < 2e-3 && (found.at[1] - 0.096).abs() < 1e-3);
        // Slope: s^2 / sum (x - mean)^2 with s^2 = 3.2e-4 / 2, sum = 5, and t(0.975, 2) = 4.3027.
        let slope = found.intervals()[1].unwrap();
        assert!((slope / (4.3027 * (1.6e-4_f64 / 5.0).sqrt()) - 1.0).abs() < 2e-2, "{slope}");
        let below = |points: &[Vec<f64>]| Ok(points.iter().map(|u| Some(vec![u[0] + 0.3, u[0] + 0.2])).collect());
        let edge = minimise(&[0.5], below).unwrap();
        assert!(edge.converged && edge.at[0] == 0.0 && edge.intervals()[0].is_none() && edge.degrees_of_freedom() == 2);
    }
}
