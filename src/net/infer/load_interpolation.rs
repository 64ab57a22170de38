//! All loads of a grasp by interpolation between a few.
//!
//! The fields of a grasp are smooth functions of its load. Therefore a few loads are decoded, and the others are
//! interpolated on request by cubic Hermite polynomials, with slopes from the parabolas through three loads. These are
//! linear combinations of decoded states, so that contact forces still balance the load. For every decoded load,
//! interpolation from the other loads yields an error estimate; where it is not small against the error that the
//! network predicts, more loads are decoded. Reproducing the network more closely would be useless, since the true
//! fields are smoother in the load than the network: a dozen loads of fifty are as close to finite elements as all.

use super::FaceEngine;
use super::grasp_output::{GraspOutput, linear_combination};
use super::predict::{EncodedGrasp, Predictor};
use super::predicted_state::GraspState;
use crate::linear_response::GraspLoad;
use base::error::Result;
use geometry::Wrench;
use glam::DVec3;
use model::Model;
use record::ErrorBound;
use std::ops::Range;

/// Number of loads of a ramp, and of a push, that are decoded initially.
const INITIAL_LOADS: usize = 12;
/// Largest ratio of the interpolation error of the displacement to the error predicted by the network: if both are
/// independent, their combination is 3 % larger than the latter, sqrt(1 + 0.25^2).
const LARGEST_ERROR_RATIO: f64 = 0.25;
/// Smallest factor by which halving the distance between the loads reduces the error of the cubic polynomial, even at a
/// kink.
const ERROR_REDUCTION: f64 = 2.0;

/// States of a grasp under increasing loads.
#[derive(Debug)]
pub struct LoadInterpolation {
    /// Ranges of loads within which a polynomial may be used.
    pieces: Vec<Piece>,
    answers: Vec<GraspOutput>,
}

/// Range of loads: of a squeeze before or after the release of the object, or of a push under one squeeze.
#[derive(Debug)]
struct Piece {
    loads: Range<usize>,
    /// Coordinate of every load: the square root of a force, in which displacements are almost linear, or the index of
    /// a push.
    along: Vec<f64>,
    /// Decoded loads in ascending order: (load, answer, level in it).
    decoded: Vec<(usize, usize, usize)>,
}

impl LoadInterpolation {
    /// Returns the number of loads of a grasp of `model` that are decoded initially.
    pub fn initial_load_count(model: &Model, loads: &[GraspLoad]) -> usize {
        Self::of(model, loads).initial_loads().len()
    }

    /// Decodes as many of `loads` as a grasp requires.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn new(predictor: &Predictor, encoded: &EncodedGrasp, loads: &[GraspLoad]) -> Result<Self> {
        Self::decode_batch(predictor, &[encoded], loads).swap_remove(0)
    }

    /// Decodes as many of `loads` as each of `grasps` requires, all of one model. The initial loads are decoded for all
    /// grasps together. A grasp fails if its predicted numbers are not finite.
    pub fn decode_batch(predictor: &Predictor, grasps: &[&EncodedGrasp], loads: &[GraspLoad]) -> Vec<Result<Self>> {
        let Some(model) = grasps.first().map(|encoded| encoded.model()) else { return Vec::new() };
        let first = Self::of(model, loads).initial_loads();
        let mut ramps: Vec<Result<Self>> = grasps.iter().map(|_| Ok(Self::of(model, loads))).collect();
        for some in first.chunks(FaceEngine::LOADS_PER_BATCH) {
            let given: Vec<GraspLoad> = some.iter().map(|load| loads[*load]).collect();
            for (ramp, answer) in ramps.iter_mut().zip(predictor.decode_batch(grasps, &given)) {
                match (ramp.as_mut(), answer) {
                    (Ok(ramp), Ok(answer)) => ramp.add(some, answer),
                    (_, Err(error)) => *ramp = Err(error),
                    (Err(_), Ok(_)) => {}
                }
            }
        }
        let goes_on = |(ramp, encoded): (Result<Self>, &&EncodedGrasp)| ramp?.refined(predictor, encoded, loads);
        ramps.into_iter().zip(grasps).map(goes_on).collect()
    }

    /// Creates the ramp of `loads` on a grasp of `model`, without decoded loads.
    fn of(model: &Model, loads: &[GraspLoad]) -> Self {
        Self { pieces: pieces(loads, |load| model.holds_object(load.force)), answers: Vec::new() }
    }

    /// Returns the loads that are decoded initially.
    fn initial_loads(&self) -> Vec<usize> {
        self.pieces.iter().flat_map(|piece| evenly(&piece.loads, &piece.along)).collect()
    }

    /// Decodes more loads until interpolation is accurate enough for the others.
    fn refined(mut self, predictor: &Predictor, encoded: &EncodedGrasp, loads: &[GraspLoad]) -> Result<Self> {
        loop {
            self.pieces.iter_mut().for_each(|piece| piece.decoded.sort_unstable());
            let missing: Vec<usize> = self.pieces.iter().flat_map(|piece| self.missing(piece)).collect();
            if missing.is_empty() {
                return Ok(self);
            }
            for some in missing.chunks(FaceEngine::LOADS_PER_BATCH) {
                let given: Vec<GraspLoad> = some.iter().map(|load| loads[*load]).collect();
                self.add(some, predictor.decode(encoded, &given)?);
            }
        }
    }

    /// Adds the answer under the loads with the indices `some`.
    fn add(&mut self, some: &[usize], answer: GraspOutput) {
        self.answers.push(answer);
        for (level, load) in some.iter().enumerate() {
            let piece = self.pieces.iter_mut().find(|piece| piece.loads.contains(load));
            piece.into_iter().for_each(|piece| piece.decoded.push((*load, self.answers.len() - 1, level)));
        }
    }

    /// Returns the number of loads.
    pub fn len(&self) -> usize {
        self.pieces.last().map_or(0, |piece| piece.loads.end)
    }

    /// Returns true if there is no load.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of decoded loads.
    pub fn decoded(&self) -> usize {
        self.pieces.iter().map(|piece| piece.decoded.len()).sum()
    }

    /// Returns the state under the load with index `load`; None after the last.
    pub fn at(&self, load: usize) -> Option<GraspState> {
        let piece = self.pieces.iter().find(|piece| piece.loads.contains(&load))?;
        Some(linear_combination(&self.parts(piece, &piece.decoded, load)))
    }

    /// Returns the largest upper ends of the prediction intervals (90 %) over all decoded states.
    pub fn error(&self) -> ErrorBound {
        let all = self.answers.iter().flat_map(|answer| (0..answer.loads.load.len()).map(|level| answer.error(level)));
        all.reduce(|a, b| a.or_larger(&b)).unwrap_or(ErrorBound::UNKNOWN)
    }

    /// Returns the decoded states among `known`, with weights, whose combination is the state of `load`.
    fn parts(&self, piece: &Piece, known: &[(usize, usize, usize)], load: usize) -> Vec<(&GraspOutput, usize, f64)> {
        let along = |load: usize| piece.along[load - piece.loads.start];
        let nodes: Vec<f64> = known.iter().map(|(load, ..)| along(*load)).collect();
        let weights = hermite(&nodes, along(load)).into_iter();
        weights.map(|(k, weight)| (&self.answers[known[k].1], known[k].2, weight)).collect()
    }

    /// Returns the loads to decode next: midpoints of intervals in which interpolation is not accurate enough.
    fn missing(&self, piece: &Piece) -> Vec<usize> {
        let Piece { decoded: known, .. } = piece;
        let mut missing = Vec::new();
        for k in 1..known.len().saturating_sub(1) {
            let (load, answer, level) = known[k];
            let others: Vec<_> = [&known[..k], &known[k + 1..]].concat();
            let exact = displacement(&[(&self.answers[answer], level, 1.0)]);
            let guessed = displacement(&self.parts(piece, &others, load));
            let norm = |v: &mut dyn Iterator<Item = DVec3>| v.map(|v| v.length_squared()).sum::<f64>().sqrt();
            let off = norm(&mut exact.iter().zip(&guessed).map(|(a, b)| *a - *b));
            // If the error is unknown, every load is decoded.
            let own = Some(self.answers[answer].error(level)).filter(ErrorBound::is_known);
            let own = own.map_or(0.0, |error| error.displacement);
            if off > ERROR_REDUCTION * LARGEST_ERROR_RATIO * own * norm(&mut exact.iter().copied()) {
                missing.extend([[known[k - 1].0, load], [load, known[k + 1].0]].iter().filter_map(|[a, b]| {
                    let amid = a.midpoint(*b);
                    (amid != *a).then_some(amid)
                }));
            }
        }
        missing.dedup();
        missing
    }
}

/// Splits the loads into pieces: the squeeze while it `holds` the object, the squeeze after that, and the push under
/// its last force.
fn pieces(loads: &[GraspLoad], holds: impl Fn(&GraspLoad) -> bool) -> Vec<Piece> {
    let pushed = |load: &GraspLoad| load.push != Wrench::ZERO;
    let start = loads.iter().position(pushed).unwrap_or(loads.len());
    let rising = loads[..start].windows(2).all(|pair| pair[0].force < pair[1].force);
    let free = loads[..start].iter().position(|load| !holds(load)).unwrap_or(start);
    let along = |i: usize| if i < start { loads[i].force.sqrt() } else { (1 + i - start) as f64 };
    let piece = |loads: Range<usize>| Piece { along: loads.clone().map(along).collect(), loads, decoded: Vec::new() };
    // Loads that do not increase monotonically are not interpolated.
    let squeeze: Vec<Range<usize>> = match rising {
        true => vec![0..free, free..start],
        false => (0..start).map(|i| i..i + 1).collect(),
    };
    let all = squeeze.into_iter().chain(std::iter::once(start..loads.len()));
    all.filter(|range| !range.is_empty()).map(piece).collect()
}

/// Returns at most [`INITIAL_LOADS`] indices of a range, evenly spaced along its coordinate, including the first and
/// the last.
fn evenly(range: &Range<usize>, along: &[f64]) -> Vec<usize> {
    let last = along.len() - 1;
    if last < INITIAL_LOADS {
        return range.clone().collect();
    }
    let wanted = |k: usize| along[0] + (along[last] - along[0]) * k as f64 / (INITIAL_LOADS - 1) as f64;
    let mut few: Vec<usize> = (0..INITIAL_LOADS).map(|k| along.partition_point(|x| *x < wanted(k)).min(last)).collect();
    few.dedup();
    few.into_iter().map(|k| range.start + k).collect()
}

/// Returns the displacement of the face nodes of all pads in a linear combination of states, m.
fn displacement(parts: &[(&GraspOutput, usize, f64)]) -> Vec<DVec3> {
    let mut sum: Vec<DVec3> = Vec::new();
    for (answer, level, weight) in parts {
        let own = answer.face_displacement(*level);
        sum.resize(own.len(), DVec3::ZERO);
        sum.iter_mut().zip(own).for_each(|(sum, u)| *sum += u * *weight);
    }
    sum
}

/// Returns the weights of the values at ascending `nodes` in the value at `x` of a cubic Hermite polynomial with the
/// slopes of the parabolas through three neighbours; exact for parabolas.
fn hermite(nodes: &[f64], x: f64) -> Vec<(usize, f64)> {
    let last = nodes.len() - 1;
    let right = nodes.partition_point(|node| *node < x);
    if right <= last && nodes[right] == x || last == 0 {
        return vec![(right.min(last), 1.0)];
    }
    let right = right.clamp(1, last);
    let left = right - 1;
    let (width, s) = (nodes[right] - nodes[left], (x - nodes[left]) / (nodes[right] - nodes[left]));
    let [a, b] = [(1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s), s * s * (3.0 - 2.0 * s)];
    let [c, d] = [s * (1.0 - s) * (1.0 - s) * width, s * s * (s - 1.0) * width];
    let mut weights = vec![(left, a), (right, b)];
    let mut add = |node: usize, weight: f64| match weights.iter_mut().find(|(k, _)| *k == node) {
        Some((_, sum)) => *sum += weight,
        None => weights.push((node, weight)),
    };
    for (node, weight) in [(left, c), (right, d)] {
        slope(nodes, node).into_iter().for_each(|(k, part)| add(k, weight * part));
    }
    weights
}

/// Returns the weights of the values at `nodes` in the slope at one of them, that of the parabola through three
/// neighbouring nodes.
fn slope(nodes: &[f64], at: usize) -> Vec<(usize, f64)> {
    let last = nodes.len() - 1;
    if last == 1 {
        let width = nodes[1] - nodes[0];
        return vec![(0, -1.0 / width), (1, 1.0 / width)];
    }
    let first = at.saturating_sub(1).min(last - 2);
    let own = [first, first + 1, first + 2];
    let x = nodes[at];
    let of = |k: usize| {
        let [p, q] = [0, 1].map(|i| nodes[own[(k + 1 + i) % 3]]);
        (2.0 * x - p - q) / ((nodes[own[k]] - p) * (nodes[own[k]] - q))
    };
    (0..3).map(|k| (own[k], of(k))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_interpolated_exactly_and_nodes_have_their_values() {
        let nodes = [0.3, 1.0, 1.4, 3.0, 3.5];
        let parabola = |x: f64| 2.0 - 3.0 * x + 0.7 * x * x;
        for x in [0.3, 0.5, 1.0, 1.2, 2.9, 3.2, 3.5] {
            let weights = hermite(&nodes, x);
            let value: f64 = weights.iter().map(|(k, w)| w * parabola(nodes[*k])).sum();
            assert!((value - parabola(x)).abs() < 1e-12, "{value} at {x}");
            assert!((weights.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert_eq!(hermite(&nodes, 1.4), [(2, 1.0)]);
        assert_eq!(hermite(&[2.0], 2.0), [(0, 1.0)]);
        let between: f64 = hermite(&[1.0, 3.0], 1.5).iter().map(|(k, w)| w * [10.0, 30.0][*k]).sum();
        assert!((between - 15.0).abs() < 1e-12);
    }

    #[test]
    fn few_loads_are_spread_from_the_first_to_the_last() {
        assert_eq!(evenly(&(3..6), &[1.0, 2.0, 3.0]), [3, 4, 5]);
        let along: Vec<f64> = (0..50).map(|k| f64::from(1 + k).sqrt()).collect();
        let few = evenly(&(0..50), &along);
        assert_eq!((few[0], few[1], few[few.len() - 1]), (0, 2, 49), "{few:?}");
        let load = |force: f64, push: f64| GraspLoad { force, push: Wrench { force: DVec3::X * push, ..Wrench::ZERO } };
        let loads = [load(1.0, 0.0), load(2.0, 0.0), load(2.0, 0.5), load(2.0, 1.0)];
        let ranges = |release: f64| {
            let held = |load: &GraspLoad| load.force < release;
            pieces(&loads, held).into_iter().map(|piece| piece.loads).collect::<Vec<_>>()
        };
        assert_eq!(ranges(0.0), [0..2, 2..4]);
        assert_eq!(ranges(2.0), [0..1, 1..2, 2..4], "an object that is held is another grasp than one that is free");
    }
}
