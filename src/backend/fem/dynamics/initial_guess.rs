//! Initial guess of Newton's method in a time step.

use mech::newton::Newton;
use mech::potential::state::State;

/// Largest number of moves towards a prediction.
const MAX_ADVANCEMENTS: usize = 32;

/// Returns the initial guess of Newton's method for a time step from the state `from`. This is `predicted`, the
/// extrapolated state, if its potential is not higher than that of `from` and no point moves by more than `safe` (m),
/// so that nothing passes through a pad. Otherwise it is the last state without contact on the way to `predicted`
/// (conservative advancement, Mirtich and Canny 1995), if its potential is not higher; otherwise it is `from`.
pub fn initial_guess(newton: &Newton, from: &State, predicted: State, safe: f64) -> State {
    let motion = largest_motion(newton, from, &predicted);
    let (here, there) = (newton.energy(from), newton.energy(&predicted));
    // False for inverted elements, whose energy is not finite.
    let better = there <= here;
    if better && motion <= safe {
        return predicted;
    }
    let near = approach(newton, from, &predicted, motion);
    if newton.energy(&near) <= here { near } else { from.clone() }
}

/// Moves from `from` towards `to` until contact: conservative advancement (Mirtich & Canny 1995).
fn approach(newton: &Newton, from: &State, to: &State, motion: f64) -> State {
    let mut part = 0.0;
    let mut state = from.clone();
    for _ in 0..MAX_ADVANCEMENTS {
        let clearance = newton.clearance(&state);
        if clearance <= 0.0 || part >= 1.0 {
            break;
        }
        part = if motion > 0.0 { (part + clearance / motion).min(1.0) } else { 1.0 };
        state = to.extrapolated(from, part - 1.0);
    }
    state
}

/// Returns an upper bound of the relative motion between any points of pads and object, m.
fn largest_motion(newton: &Newton, from: &State, to: &State) -> f64 {
    let pairs = from.x.iter().flatten().zip(to.x.iter().flatten());
    let nodes = pairs.map(|(a, b)| a.distance_squared(*b)).fold(0.0, f64::max).sqrt();
    nodes + newton.rigid.difference(to, from).iter().map(|d| d.abs()).sum::<f64>()
}
