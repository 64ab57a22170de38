//! Evaluation of the expectations of a scene on the outcome of a grasp.

use crate::evaluation::Findings;
use glam::DVec3;
pub use record::Status;
use scene::expect::{Bounds, Expectation, Reason};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Quantities of one grasp on which expectations are evaluated, the worst over its frames if an expectation is about
/// all frames. A quantity that was not measured is NaN, and every expectation about it fails.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspMeasurements {
    /// Status at the end of the grasp.
    pub status: Status,
    /// Reason why it did not reach the loading; empty if it did.
    pub reason: String,
    /// Sum over the fingers of |normal force| at the last frame, N.
    pub force_n: f64,
    /// Travel of each finger after contact at the last frame, m; a missing finger is NaN.
    pub travel_m: [f64; 2],
    /// Worst findings of the audit over all frames; None if no audit was requested or there is no frame.
    pub findings: Option<Findings>,
    /// Largest residual force on the object over the applied force.
    pub force_balance: f64,
    /// Largest residual torque on the object over applied force times object size.
    pub torque_balance: f64,
    /// Largest von Mises stress of the last frame, Pa.
    pub max_stress_pa: f64,
    /// Largest value of `last_slip_m` in any frame, m.
    pub slip_m: f64,
    /// Slip at the last frame: upper bound of the displacement of any point of the object relative to the hand, or to
    /// the world without fingers, m.
    pub last_slip_m: f64,
    /// Centre of mass of the object in the world at the last frame, m.
    pub position_m: [f64; 3],
    /// Speed of the centre of mass at the last frame, m/s.
    pub speed_m_s: f64,
    /// Normal force of the ground at the last frame, N.
    pub ground_force_n: f64,
    /// Largest total torque of the pads about the closing direction in any frame, N m.
    pub torque_n_m: f64,
    /// Largest change of linear or angular momentum of the object over its initial value.
    pub momentum_drift: f64,
    /// Curve of the first finger: (travel after contact, m; force, N) at each recorded frame.
    pub curve: Vec<(f64, f64)>,
}

impl Default for GraspMeasurements {
    /// Creates a record in which nothing is measured.
    fn default() -> Self {
        Self {
            status: Status::Infeasible,
            reason: String::new(),
            force_n: f64::NAN,
            travel_m: [f64::NAN; 2],
            findings: None,
            force_balance: f64::NAN,
            torque_balance: f64::NAN,
            max_stress_pa: f64::NAN,
            slip_m: f64::NAN,
            last_slip_m: f64::NAN,
            position_m: [f64::NAN; 3],
            speed_m_s: f64::NAN,
            ground_force_n: f64::NAN,
            torque_n_m: f64::NAN,
            momentum_drift: f64::NAN,
            curve: Vec::new(),
        }
    }
}

/// Verdict on one expectation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name of the expectation.
    pub name: Cow<'static, str>,
    /// True if the expectation holds.
    pub held: bool,
    /// Measured value, in `unit`; None if it was not measured, or the expectation is not about a number.
    pub value: Option<f64>,
    /// Bound that the value was compared with (the violated bound if one was), in `unit`.
    pub bound: Option<f64>,
    /// Unit: "N", "m", "Pa" or "" for ratios.
    pub unit: Cow<'static, str>,
    /// Status and reason at the end of the grasp, for expectations about them.
    pub detail: Option<String>,
}

/// Evaluates one expectation on one grasp.
pub fn evaluate(expectation: &Expectation, m: &GraspMeasurements) -> Verdict {
    let verdict = |held: bool, value: f64, bound: f64| Verdict {
        name: expectation.name().into(),
        held,
        value: value.is_finite().then_some(value),
        bound: bound.is_finite().then_some(bound),
        unit: expectation.unit().into(),
        detail: None,
    };
    let bounded = |bounds: &Bounds, value: f64| {
        let (held, value, bound) = within(bounds, value);
        verdict(held, value, bound)
    };
    let ended = |status: Status, reason: &Reason| {
        let held = m.status == status && m.reason.contains(&reason.contains);
        Verdict { detail: Some(ending(m)), ..verdict(held, f64::NAN, f64::NAN) }
    };
    // Comparisons with NaN are false, so no expectation about an unmeasured quantity holds.
    match expectation {
        Expectation::ReachesForce => {
            Verdict { detail: Some(ending(m)), ..verdict(m.status == Status::Reached, m.force_n, f64::NAN) }
        }
        Expectation::ForceBalance(r) => verdict(m.force_balance <= r.relative.get(), m.force_balance, r.relative.get()),
        Expectation::TorqueBalance(r) => {
            verdict(m.torque_balance <= r.relative.get(), m.torque_balance, r.relative.get())
        }
        Expectation::Finite => verdict(m.findings.is_some_and(|f| f.finite), f64::NAN, f64::NAN),
        Expectation::NoInversion => {
            let det = m.findings.map_or(f64::NAN, |f| f.min_det_f);
            verdict(det > 0.0, det, 0.0)
        }
        Expectation::NoPenetration => {
            let (depth, offset) = m.findings.map_or((f64::NAN, f64::NAN), |f| (f.penetration, f.offset));
            verdict(depth <= offset, depth, offset)
        }
        Expectation::Penetration(bounds) => {
            let (held, value, bound) = within(bounds, m.findings.map_or(f64::NAN, |f| f.penetration));
            verdict(held, value, bound)
        }
        Expectation::Converged(r) => {
            let imbalance = m.findings.map_or(f64::NAN, |f| f.imbalance);
            verdict(imbalance <= r.relative.get(), imbalance, r.relative.get())
        }
        Expectation::Travel(bounds) => {
            let fingers: Vec<f64> = m.travel_m.into_iter().filter(|t| !t.is_nan()).collect();
            let (held, value, bound) = fingers.iter().map(|&t| within(bounds, t)).fold(
                (!fingers.is_empty(), f64::NAN, f64::NAN),
                // The first violation is reported.
                |worst, next| if !worst.0 && !worst.1.is_nan() { worst } else { (worst.0 && next.0, next.1, next.2) },
            );
            verdict(held, value, bound)
        }
        Expectation::Force(bounds) => bounded(bounds, m.force_n),
        Expectation::MaxStress(bounds) => bounded(bounds, m.max_stress_pa),
        Expectation::ObjectHeld(slip) => {
            verdict(m.slip_m <= slip.slip_at_most.get(), m.slip_m, slip.slip_at_most.get())
        }
        Expectation::ObjectSlides(bounds) => bounded(bounds, m.last_slip_m),
        Expectation::ObjectAt(place) => {
            let off = (DVec3::from_array(m.position_m) - place.position.dvec3()).length();
            verdict(off <= place.within.get(), off, place.within.get())
        }
        Expectation::ObjectSpeed(bounds) => bounded(bounds, m.speed_m_s),
        Expectation::GroundForce(bounds) => bounded(bounds, m.ground_force_n),
        Expectation::Torque(bounds) => bounded(bounds, m.torque_n_m),
        Expectation::MomentumKept(r) => {
            verdict(m.momentum_drift <= r.relative.get(), m.momentum_drift, r.relative.get())
        }
        Expectation::ForceAt(point) => {
            let force = interpolate(&m.curve, point.depth.get());
            let error = (force - point.force.get()).abs();
            verdict(error <= point.relative.get() * point.force.get(), force, point.force.get())
        }
        Expectation::Dropped(reason) => ended(Status::Dropped, reason),
        Expectation::Fault(reason) => ended(Status::Fault, reason),
        Expectation::Infeasible(reason) => ended(Status::Infeasible, reason),
    }
}

impl fmt::Display for Verdict {
    /// Writes the measured value, its bound and the detail.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let number =
            |v: f64| if v != 0.0 && !(1e-2..1e5).contains(&v.abs()) { format!("{v:.3e}") } else { format!("{v:.4}") };
        let value = self.value.map(|v| format!("{}{unit}", number(v)));
        let bound = self.bound.map(|b| format!("bound {}{unit}", number(b)));
        let numbers: Vec<String> = value.into_iter().chain(bound).collect();
        let parts = [Some(numbers.join(", ")).filter(|n| !n.is_empty()), self.detail.clone()];
        f.write_str(&parts.into_iter().flatten().collect::<Vec<_>>().join(" "))
    }
}

impl Verdict {
    /// Returns the verdict as a word of a report; all words have the same width.
    pub fn label(&self) -> &'static str {
        if self.held { "held    " } else { "VIOLATED" }
    }

    /// Returns the distance of the value to its bound, positive if the expectation holds and negative otherwise;
    /// infinite if there is no value or bound.
    fn margin(&self) -> f64 {
        let far = self.value.zip(self.bound).map_or(f64::INFINITY, |(value, bound)| (value - bound).abs());
        if self.held { far } else { -far }
    }

    /// Returns the worse of two verdicts, or `self` if they are equal: a violated one, otherwise the one with the
    /// smaller margin.
    pub fn worse_of(self, other: Self) -> Self {
        let order = self.held.cmp(&other.held).then(self.margin().total_cmp(&other.margin()));
        if order.is_gt() { other } else { self }
    }
}

/// Evaluates an expectation on all grasps of a scene by the worst of them. Without a grasp every expectation fails.
pub fn evaluate_all(expectation: &Expectation, grasps: &[GraspMeasurements]) -> Verdict {
    let worst = grasps.iter().map(|measured| evaluate(expectation, measured)).reduce(Verdict::worse_of);
    worst.unwrap_or_else(|| Verdict { held: false, ..evaluate(expectation, &GraspMeasurements::default()) })
}

fn within(bounds: &Bounds, value: f64) -> (bool, f64, f64) {
    let (low, high) = (bounds.at_least.map(|b| b.get()), bounds.at_most.map(|b| b.get()));
    if let Some(low) = low.filter(|low| value < *low || value.is_nan()) {
        return (false, value, low);
    }
    if let Some(high) = high.filter(|high| value > *high || value.is_nan()) {
        return (false, value, high);
    }
    (!value.is_nan(), value, high.or(low).unwrap_or(f64::NAN))
}

/// Returns the force at a depth on the recorded curve, which starts at (0, 0); NaN beyond its end.
fn interpolate(curve: &[(f64, f64)], depth: f64) -> f64 {
    // An end point that is reached up to rounding counts as reached.
    let slack = 1e-9 * depth.abs();
    let mut from = (0.0, 0.0);
    for &to in curve {
        if depth <= to.0 + slack {
            let t = if to.0 > from.0 { ((depth - from.0) / (to.0 - from.0)).clamp(0.0, 1.0) } else { 1.0 };
            return from.1 + t * (to.1 - from.1);
        }
        from = to;
    }
    f64::NAN
}

fn ending(m: &GraspMeasurements) -> String {
    let status = m.status.as_str();
    if m.reason.is_empty() { status.to_string() } else { format!("{status}: {}", m.reason) }
}
