//! Prediction interval of a network's error: cross-conformal prediction (Vovk 2015; Lei et al. 2018) on error indicators
//! of an answer.
//!
//! The logarithm of the error and its spread are estimated as linear functions of the indicators, by least squares with
//! non-negative weights where a larger indicator means a larger risk. Each grasp held out from the training is compared
//! with an estimate from the others; the quantile of these comparisons yields the end of the interval, so that it
//! contains 90 % of the errors of similar grasps. There is a quantile for each group of answers (Mondrian prediction),
//! because errors of small loads and of loaded objects are distributed differently.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use record::ErrorBound;
use serde::{Deserialize, Serialize};

/// Number of error indicators.
pub const INDICATORS: usize = 10;
/// Error indicators of an answer, all dimensionless: the constant 1; logarithms of the mismatch of the pressed nodes
/// and of the deepest overlap with the object, over the depth, and of depth over thickness; rotation of the object;
/// difference between nodal gaps and the smallest gaps around them, over the depth; weight and push over force;
/// logarithms of the fraction of the contact force that the network moves to other nodes, of the change of its travel
/// that closes the contact, over the depth, and of the contact area over the square of the thickness.
pub type ErrorIndicators = [f64; INDICATORS];

/// Indicators whose increase must never narrow an interval.
const RISKS: [usize; 7] = [1, 2, 4, 5, 6, 7, 8];
/// Indices of the indicators that determine the group of an answer: depth, and load on the object.
const DEPTH: usize = 3;
const LOAD: usize = 6;
/// Number of groups: small and large depth, without and with a load on the object.
const GROUPS: usize = 4;
/// Fraction of unseen grasps within an interval.
pub const COVERAGE: f64 = 0.9;
/// Smallest number of grasps for an interval. With fewer than nine errors not even the largest is a bound: the bound is
/// that of rank `ceil(0.9 (n + 1))` among `n` (Lei et al. 2018).
pub const MIN_GRASPS: usize = 20;
/// Smallest number of grasps for a quantile of a group of its own.
const MIN_GROUP: usize = 15;
/// Number of parts of the held-out grasps, each of which is compared with an estimate from the others.
const FOLDS: usize = 10;
/// Error below which errors are not distinguished.
const LEAST: f64 = 1e-3;
/// Ridge regularisation of the coefficients, per sample.
const RIDGE: f64 = 1e-3;
/// Smallest and largest spread, over its mean.
const SPREAD: [f64; 2] = [0.5, 2.0];

/// Prediction interval of one quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    estimate: Estimate,
    /// Number of spreads from the estimate to the end of the interval, for each group.
    quantiles: [f64; GROUPS],
}

/// Estimate of the logarithm of the error and of its spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Estimate {
    /// Coefficients of the logarithm of the error, one per indicator.
    mean: ErrorIndicators,
    /// Coefficients of the absolute deviation from it.
    deviation: ErrorIndicators,
    /// Mean absolute deviation.
    typical: f64,
}

/// Prediction intervals of displacement, stress and travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PredictionInterval {
    displacement: Bound,
    stress: Bound,
    travel: Bound,
    /// Logarithm of depth over thickness that separates small from large depths.
    depth: f64,
    /// Number of grasps that it was fitted to.
    grasps: usize,
}

/// Indicators and relative errors of the levels of a grasp held out from the training.
pub type ValidationErrors = Vec<(ErrorIndicators, [f64; 3])>;

/// Returns the product of coefficients and indicators.
pub(super) fn dot<const N: usize>(weights: &[f64; N], signs: &[f64; N]) -> f64 {
    weights.iter().zip(signs).map(|(w, s)| w * s).sum()
}

/// Fits a target by a linear function of the indicators with the regularisation `ridge` per row and non-negative
/// weights of `risks`.
pub(super) fn least_squares<const N: usize>(rows: &[([f64; N], f64)], ridge: f64, risks: &[usize]) -> Option<[f64; N]> {
    let (mut matrix, mut right) = (Mat::<f64>::zeros(N, N), Mat::<f64>::zeros(N, 1));
    for (signs, target) in rows {
        for (i, a) in signs.iter().enumerate() {
            right[(i, 0)] += a * target;
            signs.iter().enumerate().for_each(|(j, b)| matrix[(i, j)] += a * b);
        }
    }
    (0..N).for_each(|i| matrix[(i, i)] += ridge * rows.len() as f64);
    // Non-negative least squares (active set): the most negative weight of a risk is fixed at zero, one at a time.
    let mut used = [true; N];
    loop {
        let held = |i: usize, j: usize| if used[i] && used[j] { matrix[(i, j)] } else { f64::from(u8::from(i == j)) };
        let wanted = Mat::from_fn(N, 1, |i, _| if used[i] { right[(i, 0)] } else { 0.0 });
        let solved = Mat::from_fn(N, N, held).llt(Side::Lower).ok()?.solve(&wanted);
        match risks.iter().min_by(|i, j| solved[(**i, 0)].total_cmp(&solved[(**j, 0)])) {
            Some(&worst) if solved[(worst, 0)] < 0.0 => used[worst] = false,
            _ => return Some(std::array::from_fn(|i| solved[(i, 0)])),
        }
    }
}

impl Estimate {
    fn fit(levels: &[(ErrorIndicators, f64)]) -> Option<Self> {
        let logarithms: Vec<_> = levels.iter().map(|(signs, error)| (*signs, error.max(LEAST).ln())).collect();
        let mean = least_squares(&logarithms, RIDGE, &RISKS)?;
        let apart: Vec<_> =
            logarithms.iter().map(|(signs, error)| (*signs, (error - dot(&mean, signs)).abs())).collect();
        let typical = apart.iter().map(|(_, apart)| apart).sum::<f64>() / apart.len().max(1) as f64;
        Some(Self { mean, deviation: least_squares(&apart, RIDGE, &RISKS)?, typical: typical.max(LEAST) })
    }

    fn spread(&self, signs: &ErrorIndicators) -> f64 {
        dot(&self.deviation, signs).clamp(SPREAD[0] * self.typical, SPREAD[1] * self.typical)
    }

    /// Returns the number of spreads by which the logarithm of `error` exceeds the estimate.
    fn score(&self, signs: &ErrorIndicators, error: f64) -> f64 {
        (error.max(LEAST).ln() - dot(&self.mean, signs)) / self.spread(signs)
    }

    fn is_finite(&self) -> bool {
        self.mean.iter().chain(&self.deviation).all(|w| w.is_finite()) && self.typical.is_finite() && self.typical > 0.0
    }
}

/// Returns the group of an answer.
fn group(signs: &ErrorIndicators, depth: f64) -> usize {
    usize::from(signs[DEPTH] > depth) + 2 * usize::from(signs[LOAD] > 0.0)
}

impl Bound {
    /// Fits the bound of quantity `k` to held-out grasps; `depth` separates small from large depths.
    fn fit(kept: &[ValidationErrors], k: usize, depth: f64) -> Option<Self> {
        let levels = |wanted: &dyn Fn(usize) -> bool| -> Vec<(ErrorIndicators, f64)> {
            let grasps = kept.iter().enumerate().filter(|(i, _)| wanted(*i));
            grasps.flat_map(|(_, levels)| levels.iter().map(|(signs, errors)| (*signs, errors[k]))).collect()
        };
        let mut scores: [Vec<f64>; GROUPS] = Default::default();
        let mut members = [0; GROUPS];
        for fold in 0..FOLDS {
            let others = Estimate::fit(&levels(&|i| i % FOLDS != fold))?;
            for grasp in kept.iter().skip(fold).step_by(FOLDS) {
                let mut seen = [false; GROUPS];
                for (signs, errors) in grasp {
                    let group = group(signs, depth);
                    seen[group] = true;
                    scores[group].push(others.score(signs, errors[k]));
                }
                members.iter_mut().zip(seen).for_each(|(count, seen)| *count += usize::from(seen));
            }
        }
        let quantile = |mut scores: Vec<f64>| {
            scores.sort_by(f64::total_cmp);
            let rank = (COVERAGE * (scores.len() + 1) as f64).ceil() as usize;
            scores.get(rank.clamp(1, scores.len().max(1)) - 1).copied()
        };
        let all = quantile(scores.concat())?;
        let own = |g: usize| if members[g] < MIN_GROUP { Some(all) } else { quantile(scores[g].clone()) };
        let [a, b, c, d] = [0, 1, 2, 3].map(own);
        let bound = Self { estimate: Estimate::fit(&levels(&|_| true))?, quantiles: [a?, b?, c?, d?] };
        Some(bound).filter(Self::is_finite)
    }

    /// Returns the upper end of the interval for an answer with these indicators, of the group `group`.
    fn at(&self, signs: &ErrorIndicators, group: usize) -> f64 {
        let end = dot(&self.estimate.mean, signs) + self.quantiles[group] * self.estimate.spread(signs);
        end.clamp(-10.0, 10.0).exp()
    }

    fn is_finite(&self) -> bool {
        self.estimate.is_finite() && self.quantiles.iter().all(|q| q.is_finite())
    }
}

impl PredictionInterval {
    /// Fits the intervals to grasps held out from the training; None for fewer than [`MIN_GRASPS`].
    pub fn fit(kept: &[ValidationErrors]) -> Option<Self> {
        if kept.len() < MIN_GRASPS {
            return None;
        }
        let mut depths: Vec<f64> = kept.iter().flatten().map(|(signs, _)| signs[DEPTH]).collect();
        depths.sort_by(f64::total_cmp);
        let depth = *depths.get(depths.len() / 2)?;
        let bound = |k: usize| Bound::fit(kept, k, depth);
        Some(Self { displacement: bound(0)?, stress: bound(1)?, travel: bound(2)?, depth, grasps: kept.len() })
    }

    /// Returns the upper ends of the intervals for an answer with these indicators.
    pub fn at(&self, signs: &ErrorIndicators) -> ErrorBound {
        let group = group(signs, self.depth);
        ErrorBound {
            displacement: self.displacement.at(signs, group),
            stress: self.stress.at(signs, group),
            travel: self.travel.at(signs, group),
        }
    }

    /// Returns true if it was fitted to enough grasps; older models have intervals from fewer.
    pub fn has_enough_grasps(&self) -> bool {
        self.grasps >= MIN_GRASPS
    }

    /// Checks that the values are valid. The error states what is wrong.
    pub(crate) fn check(&self) -> Result<(), String> {
        let all = [("displacement", self.displacement), ("stress", self.stress), ("travel", self.travel)];
        match all.into_iter().find(|(_, bound)| !bound.is_finite()) {
            Some((name, bound)) => {
                Err(format!("`interval.{name}` contains {bound:?}; allowed: finite numbers, a spread above 0"))
            }
            None if !self.depth.is_finite() => Err(format!("`interval.depth` is {}; allowed: a number", self.depth)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::random::Random;

    /// Draws grasps whose error depends on an indicator, with multiplicative scatter.
    fn drawn(count: usize, random: &mut Random) -> Vec<ValidationErrors> {
        let mut grasp = || {
            let sign = 4.0 * random.uniform() - 4.0;
            let error = (0.8 * sign - 1.0 + 0.6 * (random.uniform() + random.uniform() - 1.0)).exp();
            let loaded = f64::from(u8::from(random.uniform() < 0.5));
            let signs = [1.0, sign, 0.0, random.uniform(), 0.0, 0.0, loaded, 0.0, 0.0, 0.0];
            // Loads on the object double the error.
            let error = error * (1.0 + loaded);
            vec![(signs, [error, 2.0 * error, 0.5 * error])]
        };
        (0..count).map(|_| grasp()).collect()
    }

    #[test]
    fn nine_of_ten_unseen_grasps_lie_within_and_the_interval_follows_the_signs() {
        let mut random = Random::new(7);
        let interval = PredictionInterval::fit(&drawn(1000, &mut random)).unwrap();
        let unseen = drawn(4000, &mut random);
        for loaded in [0.0, 1.0] {
            let group: Vec<_> = unseen.iter().flatten().filter(|(signs, _)| signs[LOAD] == loaded).collect();
            let within = group.iter().filter(|(signs, error)| error[0] <= interval.at(signs).displacement).count();
            let part = within as f64 / group.len() as f64;
            assert!((part - COVERAGE).abs() < 0.03, "{part} within, not {COVERAGE}");
        }
        let wide = |sign: f64| interval.at(&[1.0, sign, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).displacement;
        let ratio = wide(-1.0) / wide(-3.0);
        assert!((ratio / 1.6_f64.exp() - 1.0).abs() < 0.1, "widths differ by {ratio}");
    }

    #[test]
    fn fewer_than_twenty_grasps_give_no_interval() {
        let mut random = Random::new(9);
        assert!(PredictionInterval::fit(&drawn(MIN_GRASPS - 1, &mut random)).is_none());
        assert!(PredictionInterval::fit(&drawn(MIN_GRASPS, &mut random)).unwrap().has_enough_grasps());
    }

    #[test]
    fn a_risk_never_narrows_the_interval() {
        let mut random = Random::new(8);
        let mut grasp = || {
            let turned = random.uniform();
            let error = 0.1 * (-3.0 * turned + 0.2 * random.uniform()).exp();
            vec![([1.0, -2.0, -2.0, -1.0, turned, 0.0, 0.0, -3.0, -3.0, 0.0], [error; 3])]
        };
        let interval = PredictionInterval::fit(&(0..200).map(|_| grasp()).collect::<Vec<_>>()).unwrap();
        let wide = |turned: f64| interval.at(&[1.0, -2.0, -2.0, -1.0, turned, 0.0, 0.0, -3.0, -3.0, 0.0]).displacement;
        assert!(wide(1.0) >= wide(0.0), "{} turned, {} not", wide(1.0), wide(0.0));
    }
}
