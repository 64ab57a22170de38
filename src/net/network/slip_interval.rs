//! Load at which an object slips, and its interval: conformal prediction (Vovk 2015) of the load that finite elements
//! hold over the one that the limit surface of the predicted pressure holds.
//!
//! The limit surface assumes that the whole contact slides at once under the pressure before the push. An object that
//! tilts, rolls or slides in part is lost earlier or later. The logarithm of the ratio is estimated as a linear function
//! of indicators of the grasp, by least absolute deviations, because a few objects roll out at a fraction of the load;
//! the quantiles of the differences from estimates by other grasps are the ends of the interval.

use super::interval::{MIN_GRASPS, dot, least_squares};
use serde::{Deserialize, Serialize};

/// Number of indicators of slip.
pub const SLIP_INDICATORS: usize = 8;
/// Indicators of slip, all dimensionless: the constant 1; share of the twist in the load; moment that tilts the object
/// at the limit, over the pressing force and the radius of the pressure; logarithms of travel and of the radius of the
/// pressure, over the thickness; coefficient of friction; force over `E t^2`; distance of the centres of pressure of
/// the pads across the closing direction, over the radius.
pub type SlipIndicators = [f64; SLIP_INDICATORS];

/// Probability on each side of the interval.
const TAIL: f64 = 0.05;
/// Number of parts of the grasps, each of which is compared with an estimate from the others.
const FOLDS: usize = 10;
/// Ridge regularisation of the coefficients: with few grasps, the load is that of the limit surface.
const RIDGE: f64 = 7.0;
/// Number of iterations of reweighted least squares (Holland and Welsch 1977), and the deviation below which all weights
/// are equal.
const REWEIGHTINGS: usize = 20;
const DEVIATION: f64 = 0.05;
/// Largest logarithm of the ratio: outside, the indicators are not those of the grasps of the fit.
const FARTHEST: f64 = 1.0;

/// Load on the object at which a grasp slips, as a ratio of that of the limit surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SlipInterval {
    /// Coefficients of the logarithm of the ratio, one per indicator.
    mean: SlipIndicators,
    /// Ends of the interval of the logarithm, relative to its estimate.
    ends: [f64; 2],
    /// Number of grasps of the fit.
    grasps: usize,
}

/// Remaining fractions of the load at which the object slips: 1 without load, 0 where it slips, negative beyond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionMargin {
    /// Expected fraction.
    pub expected: f64,
    /// Interval that contains the fraction with probability 0.9; infinite if it is unknown.
    pub interval: [f64; 2],
}

impl FrictionMargin {
    /// Margin of an object without load.
    pub const WHOLE: Self = Self { expected: 1.0, interval: [1.0; 2] };

    /// Returns the margin of a load that is the fraction `used` of the limit, with an unknown interval.
    pub fn of_limit(used: f64) -> Self {
        Self { expected: 1.0 - used, interval: [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// Returns the smaller of two margins.
    pub fn or_smaller(self, other: Self) -> Self {
        if other.expected < self.expected { other } else { self }
    }
}

impl SlipInterval {
    /// Fits the ratio to grasps that slipped: their indicators, and the fraction of the limit surface's load at which
    /// they did. None for fewer than [`MIN_GRASPS`].
    pub fn fit(slipped: &[(SlipIndicators, f64)]) -> Option<Self> {
        if slipped.len() < MIN_GRASPS {
            return None;
        }
        let rows: Vec<_> = slipped.iter().map(|(signs, used)| (*signs, clamped(used.ln()))).collect();
        let mut off = Vec::with_capacity(rows.len());
        for fold in 0..FOLDS {
            let others: Vec<_> = rows.iter().enumerate().filter(|(i, _)| i % FOLDS != fold).map(|(_, r)| *r).collect();
            let mean = least_deviations(&others)?;
            off.extend(rows.iter().skip(fold).step_by(FOLDS).map(|(signs, found)| found - clamped(dot(&mean, signs))));
        }
        off.sort_by(f64::total_cmp);
        let rank = (TAIL * (off.len() + 1) as f64).floor() as usize;
        let ends = [off[rank.saturating_sub(1)], off[(off.len() - rank).min(off.len() - 1)]];
        Some(Self { mean: least_deviations(&rows)?, ends, grasps: slipped.len() }).filter(|fit| fit.check().is_ok())
    }

    /// Returns the margin of a load that is the fraction `used` of the limit surface's.
    pub fn margin(&self, signs: &SlipIndicators, used: f64) -> FrictionMargin {
        let mean = clamped(dot(&self.mean, signs));
        let left = |ratio: f64| 1.0 - used / ratio.exp();
        FrictionMargin { expected: left(mean), interval: self.ends.map(|end| left(mean + end)) }
    }

    /// Checks that the values are valid. The error states what is wrong.
    pub(crate) fn check(&self) -> Result<(), String> {
        let valid = self.mean.iter().chain(&self.ends).all(|v| v.is_finite()) && self.ends[0] <= self.ends[1];
        let message = || format!("`slip` contains {self:?}; allowed: finite numbers, ascending `ends`");
        if valid { Ok(()) } else { Err(message()) }
    }
}

/// Fits a target by a linear function of the indicators with the least sum of absolute deviations.
fn least_deviations(rows: &[(SlipIndicators, f64)]) -> Option<SlipIndicators> {
    let mut mean = [0.0; SLIP_INDICATORS];
    for _ in 0..REWEIGHTINGS {
        let weighted: Vec<_> = rows
            .iter()
            .map(|(signs, target)| {
                let weight = (DEVIATION / (target - dot(&mean, signs)).abs().max(DEVIATION)).sqrt();
                (signs.map(|sign| weight * sign), weight * target)
            })
            .collect();
        mean = least_squares(&weighted, RIDGE / rows.len() as f64, &[])?;
    }
    Some(mean)
}

fn clamped(logarithm: f64) -> f64 {
    logarithm.clamp(-FARTHEST, FARTHEST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::random::Random;

    /// Of 2,000 grasps whose ratio falls with the tilt and scatters by 10 %, 90 % (within 2 %) lie within an interval
    /// fitted to 4,000 others, so many that the regularisation is weak: the interval follows the tilt.
    #[test]
    fn nine_of_ten_grasps_slip_within_the_interval() {
        let mut random = Random::new(3);
        let mut drawn = |count: usize| -> Vec<(SlipIndicators, f64)> {
            let mut grasp = || {
                let tilt = random.uniform();
                let used = (-0.3 * tilt + 0.2 * (random.uniform() - 0.5)).exp();
                ([1.0, 0.0, tilt, 0.0, 0.0, 0.0, 0.0, 0.0], used)
            };
            (0..count).map(|_| grasp()).collect()
        };
        let fit = SlipInterval::fit(&drawn(4000)).unwrap();
        let unseen = drawn(2000);
        let within = unseen.iter().filter(|(signs, used)| {
            let [low, high] = fit.margin(signs, *used).interval;
            low <= 0.0 && 0.0 <= high
        });
        let part = within.count() as f64 / unseen.len() as f64;
        assert!((part - 0.9).abs() < 0.02, "{part} within");
        let expected = |tilt: f64| fit.margin(&[1.0, 0.0, tilt, 0.0, 0.0, 0.0, 0.0, 0.0], 0.5).expected;
        assert!((expected(0.0) - 0.5).abs() < 0.02 && (expected(1.0) - (1.0 - 0.5 * 0.3_f64.exp())).abs() < 0.02);
        assert!(SlipInterval::fit(&drawn(MIN_GRASPS - 1)).is_none());
    }
}
