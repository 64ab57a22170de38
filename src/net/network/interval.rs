//! Prediction interval of a network's error: split conformal prediction (Lei et al. 2018) on error indicators of an
//! answer.
//!
//! The logarithm of the error is estimated as a linear function of the indicators, by least squares on one half of the
//! grasps held out from the training, with non-negative weights where a larger indicator means a larger risk. The other
//! half yields the factor from the estimate to the end of the interval, so that the interval contains 90 % of the
//! errors of similar grasps.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use record::ErrorBound;
use serde::{Deserialize, Serialize};

/// Error indicators of an answer, all dimensionless: the constant 1; logarithms of the mismatch of the pressed nodes
/// and of the deepest overlap with the object, over the depth, and of depth over thickness; rotation of the object;
/// difference between nodal gaps and the smallest gaps around them, over the depth; push over force.
pub type ErrorIndicators = [f64; 7];

/// Indicators whose increase must never narrow an interval: all except the constant and the depth.
const RISKS: [usize; 5] = [1, 2, 4, 5, 6];
/// Fraction of unseen grasps within an interval.
pub const COVERAGE: f64 = 0.9;
/// Smallest number of grasps for an interval: ten for the estimate and ten for the factor. With fewer than nine errors
/// not even the largest is a bound: the bound is that of rank `ceil(0.9 (n + 1))` among `n` (Lei et al. 2018).
pub const MIN_GRASPS: usize = 20;
/// Error below which errors are not distinguished.
const LEAST: f64 = 1e-3;
/// Ridge regularisation of the coefficients, per sample.
const RIDGE: f64 = 1e-3;

/// Prediction interval of one quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Coefficients of the logarithm of the error, one per indicator.
    weights: ErrorIndicators,
    /// Factor from the estimate to the end of the interval.
    factor: f64,
}

/// Prediction intervals of displacement, stress and travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PredictionInterval {
    displacement: Bound,
    stress: Bound,
    travel: Bound,
    /// Number of grasps that it was fitted to.
    grasps: usize,
}

/// Indicators and relative errors of the levels of a grasp held out from the training.
pub type ValidationErrors = Vec<(ErrorIndicators, [f64; 3])>;

impl Bound {
    fn fit(levels: &[(ErrorIndicators, f64)], others: &[(ErrorIndicators, f64)]) -> Option<Self> {
        const N: usize = 7;
        let (mut matrix, mut right) = (Mat::<f64>::zeros(N, N), Mat::<f64>::zeros(N, 1));
        for (signs, error) in levels {
            let target = error.max(LEAST).ln();
            for (i, a) in signs.iter().enumerate() {
                right[(i, 0)] += a * target;
                signs.iter().enumerate().for_each(|(j, b)| matrix[(i, j)] += a * b);
            }
        }
        (0..N).for_each(|i| matrix[(i, i)] += RIDGE * levels.len() as f64);
        // Non-negative least squares (active set): the most negative weight of a risk is fixed at zero, one at a time.
        let mut used = [true; N];
        let weights: ErrorIndicators = loop {
            let held =
                |i: usize, j: usize| if used[i] && used[j] { matrix[(i, j)] } else { f64::from(u8::from(i == j)) };
            let wanted = Mat::from_fn(N, 1, |i, _| if used[i] { right[(i, 0)] } else { 0.0 });
            let solved = Mat::from_fn(N, N, held).llt(Side::Lower).ok()?.solve(&wanted);
            match RISKS.into_iter().min_by(|i, j| solved[(*i, 0)].total_cmp(&solved[(*j, 0)])) {
                Some(worst) if solved[(worst, 0)] < 0.0 => used[worst] = false,
                _ => break std::array::from_fn(|i| solved[(i, 0)]),
            }
        };
        let mut own = Self { weights, factor: 1.0 };
        let mut ratios: Vec<f64> = others.iter().map(|(signs, error)| error.max(LEAST) / own.at(signs)).collect();
        ratios.sort_by(f64::total_cmp);
        let rank = (COVERAGE * (ratios.len() + 1) as f64).ceil() as usize;
        own.factor = *ratios.get(rank.clamp(1, ratios.len().max(1)) - 1)?;
        Some(own).filter(|own| own.is_finite())
    }

    /// Returns the upper end of the interval for an answer with these indicators.
    fn at(&self, signs: &ErrorIndicators) -> f64 {
        self.factor * self.weights.iter().zip(signs).map(|(w, s)| w * s).sum::<f64>().clamp(-10.0, 10.0).exp()
    }

    fn is_finite(&self) -> bool {
        self.factor.is_finite() && self.factor > 0.0 && self.weights.iter().all(|w| w.is_finite())
    }
}

impl PredictionInterval {
    /// Fits the intervals to grasps held out from the training, one half for the estimate and one for the factor; None
    /// for fewer than [`MIN_GRASPS`].
    pub fn fit(kept: &[ValidationErrors]) -> Option<Self> {
        if kept.len() < MIN_GRASPS {
            return None;
        }
        let half = |odd: usize, k: usize| -> Vec<(ErrorIndicators, f64)> {
            let grasps = kept.iter().enumerate().filter(|(i, _)| i % 2 == odd);
            grasps.flat_map(|(_, levels)| levels.iter().map(|(signs, errors)| (*signs, errors[k]))).collect()
        };
        let bound = |k: usize| Bound::fit(&half(0, k), &half(1, k));
        Some(Self { displacement: bound(0)?, stress: bound(1)?, travel: bound(2)?, grasps: kept.len() })
    }

    /// Returns the upper ends of the intervals for an answer with these indicators.
    pub fn at(&self, signs: &ErrorIndicators) -> ErrorBound {
        ErrorBound {
            displacement: self.displacement.at(signs),
            stress: self.stress.at(signs),
            travel: self.travel.at(signs),
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
                Err(format!("`interval.{name}` contains {bound:?}; allowed: finite numbers, a factor above 0"))
            }
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
            vec![([1.0, sign, 0.0, random.uniform(), 0.0, 0.0, 0.0], [error, 2.0 * error, 0.5 * error])]
        };
        (0..count).map(|_| grasp()).collect()
    }

    #[test]
    fn nine_of_ten_unseen_grasps_lie_within_and_the_interval_follows_the_signs() {
        let mut random = Random::new(7);
        let interval = PredictionInterval::fit(&drawn(1000, &mut random)).unwrap();
        let unseen = drawn(4000, &mut random);
        let within =
            unseen.iter().flatten().filter(|(signs, error)| error[0] <= interval.at(signs).displacement).count();
        let part = within as f64 / unseen.len() as f64;
        assert!((part - COVERAGE).abs() < 0.03, "{part} within, not {COVERAGE}");
        let wide = |sign: f64| interval.at(&[1.0, sign, 0.0, 0.5, 0.0, 0.0, 0.0]).displacement;
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
            vec![([1.0, -2.0, -2.0, -1.0, turned, 0.0, 0.0], [error; 3])]
        };
        let interval = PredictionInterval::fit(&(0..200).map(|_| grasp()).collect::<Vec<_>>()).unwrap();
        let wide = |turned: f64| interval.at(&[1.0, -2.0, -2.0, -1.0, turned, 0.0, 0.0]).displacement;
        assert!(wide(1.0) >= wide(0.0), "{} turned, {} not", wide(1.0), wide(0.0));
    }
}
