//! Step of a [`RigidEquilibrium`]: contact forces, travel and pose of the object in equilibrium under a given force.
//!
//! Basis functions in contact satisfy `C f + J q = a`: their displacement `C f` and the rigid motions `q` add up to
//! what the object prescribes (`a`). `J' f = l` balances the object and the fingers. Basis functions in tension leave
//! the active set, penetrating ones join it (primal-dual active set: Hintermueller, Ito and Kunisch 2002). Where
//! friction would exceed Coulomb's limit, the basis function slips against a spring along the face, whose compliance is
//! adapted until the force is at the limit (secant iteration).

use super::{Equilibrium, QueriedPoint, RigidEquilibrium};
use crate::linear_response::GraspLoad;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par};
use geometry::Wrench;
use glam::{DQuat, DVec3};
use mech::contact::coulomb::{cone_factor, tangential};
use rayon::prelude::*;

/// Number of rigid unknowns: travel of two fingers (the first one for both, if they are geared), translation and
/// rotation of the object.
const RIGID: usize = 8;
/// Maximum number of iterations of a step.
const ITERATIONS: usize = 16;
/// Iteration from which on springs of slipping basis functions change by half of their update, to prevent oscillation.
const HALVED_FROM: usize = 6;
/// Largest rigid motions of a step, within which gaps and normals at its start remain valid.
const LARGEST: [f64; RIGID] = [1.0, 1.0, 0.25, 0.25, 0.25, 0.1, 0.1, 0.1];
/// Damping of rigid motions over their stiffness, tried in turn until the motions are no larger (Marquardt 1963).
const DAMPING: [f64; 7] = [0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Regularisation of the rigid stiffness, over its largest entry, for motions that nothing constrains.
const HELD: f64 = 1e-7;
/// Gap above the smallest one up to which basis functions of a pad are active when it first makes contact.
const NEAR: f64 = 1e-3;
/// Relative change of the spring of a slipping basis function up to which it has converged.
const CONVERGED: f64 = 0.02;

type Rigid = [f64; RIGID];

/// Basis functions of a pad during a step.
struct Contact {
    active: Vec<bool>,
    /// Compliance of the spring against which a basis function slips; zero if it sticks.
    slip_compliance: Vec<f64>,
    force: Vec<DVec3>,
}

/// Solution `f = f0 - F q` for the active basis functions of a pad, still multiplied by the transposed factor of `C`.
struct Solved {
    basis: Vec<usize>,
    factor: Mat<f64>,
    /// Columns of `J`, then `a`, after the forward substitution.
    columns: Mat<f64>,
}

impl RigidEquilibrium {
    /// Finds the equilibrium under `load` from the state `before`, or an intermediate state, without queries of the
    /// object. Also returns the largest rigid motion over [`LARGEST`]: 1 if it was damped. An object that nothing
    /// constrains stays in its pose, and the fingers close on it: linear pads cannot determine whether it slips away.
    pub(crate) fn solve_equilibrium(&self, before: &Equilibrium, load: &GraspLoad) -> (Equilibrium, f64) {
        if self.free && !self.held {
            for damping in DAMPING {
                let (state, motion) = self.solve_with_damping(before, load, Some(damping));
                if motion < 1.0 {
                    return (state, if damping > 0.0 { 1.0 } else { motion });
                }
            }
        }
        let (state, motion) = self.solve_with_damping(before, load, None);
        (if motion < 1.0 { state } else { before.clone() }, 0.0)
    }

    /// Finds the equilibrium with an object that moves, with damping, or is fixed (None). Also returns the largest
    /// rigid motion over [`LARGEST`].
    fn solve_with_damping(&self, before: &Equilibrium, load: &GraspLoad, damping: Option<f64>) -> (Equilibrium, f64) {
        let mut contacts: Vec<Contact> = (0..self.fingers.len()).map(|p| Contact::new(before, p)).collect();
        let (mut rigid, mut now) = ([0.0; RIGID], before.clone());
        for iteration in 0..ITERATIONS {
            let solve = |(p, contact): (usize, &Contact)| self.factorise_active(p, before, contact);
            let Some(solved) = contacts.par_iter().enumerate().map(solve).collect::<Option<Vec<_>>>() else { break };
            rigid = self.balance(before, &contacts, &solved, load, damping);
            let part = if iteration < HALVED_FROM { 1.0 } else { 0.5 };
            let update = |(p, contact): (usize, &mut Contact)| {
                self.update_active_set(p, before, contact, &solved[p], &rigid, part)
            };
            // All pads are updated before the test, which stops at the first change.
            let unchanged: Vec<bool> = contacts.par_iter_mut().enumerate().map(update).collect();
            if unchanged.into_iter().all(|same| same) {
                break;
            }
        }
        (0..self.fingers.len()).for_each(|p| now.travel[p] += rigid[self.travel_unknown(p)]);
        let turn = DVec3::from_slice(&rigid[5..8]);
        now.translation += DVec3::from_slice(&rigid[2..5]);
        now.rotation = (DQuat::from_scaled_axis(turn) * now.rotation).normalize();
        for (p, contact) in contacts.iter().enumerate() {
            let held = |(function, force): (usize, &DVec3)| {
                let normal = before.queries[p][function].normal;
                let push = force.dot(normal).max(0.0);
                // Friction carries no more than Coulomb's limit.
                let (along, _) = tangential(*force, normal, self.friction);
                let along = along * cone_factor(along.length(), self.friction * push);
                if contact.active[function] { normal * push + along } else { DVec3::ZERO }
            };
            now.force[p] = contact.force.iter().enumerate().map(held).collect();
            now.displacement[p] = self.graph.basis.displacements(&now.force[p]);
            // The friction moment is bounded by Coulomb's limit, too.
            let (stiffness, most) = self.twist_resistance(contact);
            let twist = now.twist[p] + stiffness * turn.dot(self.fingers[p].closing);
            now.twist[p] = twist.clamp(-most, most);
        }
        let motions = rigid.iter().zip(LARGEST).map(|(q, most)| q.abs() / most);
        (now, motions.fold(0.0, f64::max))
    }

    /// Returns the index of the unknown that is the travel of `finger`: fingers around a free object are geared, as in
    /// the finite element model.
    fn travel_unknown(&self, finger: usize) -> usize {
        if self.free { 0 } else { finger }
    }

    /// Returns the motion of a point of `pad` relative to the object, along a direction of the pad, per unit of each
    /// rigid motion.
    fn rigid_jacobian_row(&self, pad: usize, before: &Equilibrium, query: &QueriedPoint, direction: DVec3) -> Rigid {
        let finger = &self.fingers[pad];
        let direction = finger.rotation * direction;
        let turned = (before.rotation * query.point).cross(direction);
        let mut row = [0.0; RIGID];
        row[self.travel_unknown(pad)] = direction.dot(finger.closing);
        for k in 0..3 {
            row[2 + k] = -direction[k];
            row[5 + k] = -turned[k];
        }
        row
    }

    /// Factorises the compliance of the active basis functions of `pad`; None if it is not positive definite.
    fn factorise_active(&self, pad: usize, before: &Equilibrium, contact: &Contact) -> Option<Solved> {
        let basis: Vec<usize> = (0..contact.active.len()).filter(|function| contact.active[*function]).collect();
        let n = 3 * basis.len();
        let mut factor = Mat::<f64>::zeros(n, n);
        let mut columns = Mat::<f64>::zeros(n, RIGID + 1);
        for (b, from) in basis.iter().enumerate() {
            let query = &before.queries[pad][*from];
            let asked = before.displacement[pad][*from] - query.normal * query.gap;
            for k in 0..3 {
                // The compliance is symmetric: its rows are its columns.
                let row = self.graph.basis.row(*from, k);
                let mut column = factor.col_mut(3 * b + k);
                for (a, to) in basis.iter().enumerate().skip(b) {
                    (0..3).for_each(|c| column[3 * a + c] = row[3 * to + c]);
                }
                for c in 0..3 {
                    let out = query.normal[k] * query.normal[c];
                    let along = f64::from(u8::from(k == c)) - out;
                    column[3 * b + c] += contact.slip_compliance[*from] * along
                        + self.basis_points[pad][*from].uncovered_compliance * out;
                }
                let moves = self.rigid_jacobian_row(pad, before, query, DVec3::AXES[k]);
                (0..RIGID).for_each(|m| columns[(3 * b + k, m)] = moves[m]);
                columns[(3 * b + k, RIGID)] = asked[k];
            }
        }
        let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
        let stack = MemStack::new(&mut memory);
        cholesky_in_place(factor.as_mut(), Default::default(), Par::Seq, stack, Default::default()).ok()?;
        solve_lower_triangular_in_place(factor.as_ref(), columns.as_mut(), Par::Seq);
        Some(Solved { basis, factor, columns })
    }

    /// Returns the stiffness of a pad against rotation about its closing direction within its active basis functions,
    /// and the moment that friction carries there: a function covers a part of the face and resists rotation about its
    /// centre.
    fn twist_resistance(&self, contact: &Contact) -> (f64, f64) {
        let (basis, t) = (&self.graph.basis, self.graph.thickness);
        let active = (0..contact.active.len()).filter(|function| contact.active[*function]);
        let of = |function: usize| {
            let radius = basis.radius[function] / t;
            let pressing = contact.force[function].z.abs();
            (
                radius * radius / (basis.self_compliance(function) + contact.slip_compliance[function]),
                self.friction * pressing * radius,
            )
        };
        active.map(of).fold((0.0, 0.0), |sum, of| (sum.0 + of.0, sum.1 + of.1))
    }

    /// Computes the rigid motions that balance the fingers and, if it moves (with `damping`), the object.
    fn balance(
        &self,
        before: &Equilibrium,
        contacts: &[Contact],
        solved: &[Solved],
        load: &GraspLoad,
        damping: Option<f64>,
    ) -> Rigid {
        let (mut stiffness, mut right) = ([[0.0; RIGID]; RIGID], [0.0; RIGID]);
        for (p, solved) in solved.iter().enumerate() {
            let dot = |a: usize, b: usize| solved.columns.col(a).transpose() * solved.columns.col(b);
            for a in 0..RIGID {
                (0..RIGID).for_each(|b| stiffness[a][b] += dot(a, b));
                right[a] += dot(a, RIGID);
            }
            right[self.travel_unknown(p)] += load.force;
            let (twisted, closing) = (self.twist_resistance(&contacts[p]).0, self.fingers[p].closing);
            for a in 0..3 {
                (0..3).for_each(|b| stiffness[5 + a][5 + b] += twisted * closing[a] * closing[b]);
                right[5 + a] -= before.twist[p] * closing[a];
            }
        }
        let Wrench { force, torque } = self.load_about_centre(load);
        let torque = torque + (before.rotation * self.weight[1]).cross(force);
        for k in 0..3 {
            right[2 + k] += force[k];
            right[5 + k] += torque[k];
        }
        let used =
            |a: usize| if a < 2 { (0..solved.len()).any(|p| self.travel_unknown(p) == a) } else { damping.is_some() };
        let damping = damping.unwrap_or(0.0);
        let scale = (0..RIGID).map(|a| stiffness[a][a]).fold(1e-9, f64::max);
        let matrix = Mat::<f64>::from_fn(RIGID, RIGID, |a, b| match (used(a) && used(b), a == b) {
            (true, same) => stiffness[a][b] + if same { HELD * scale + damping * stiffness[a][a] } else { 0.0 },
            (false, same) => f64::from(u8::from(same)),
        });
        let right = Mat::<f64>::from_fn(RIGID, 1, |a, _| if used(a) { right[a] } else { 0.0 });
        let motions = matrix.llt(faer::Side::Lower).map(|factor| faer::linalg::solvers::Solve::solve(&factor, &right));
        motions.map_or([0.0; RIGID], |x| std::array::from_fn(|a| x[(a, 0)].clamp(-LARGEST[a], LARGEST[a])))
    }

    /// Updates the forces on the basis functions of `pad` under the rigid motions, and which of them are in contact and
    /// slip. The springs of slipping basis functions change by `part` of their update. Returns true if nothing changed.
    fn update_active_set(
        &self,
        pad: usize,
        before: &Equilibrium,
        contact: &mut Contact,
        solved: &Solved,
        rigid: &Rigid,
        part: f64,
    ) -> bool {
        let Solved { basis, factor, columns } = solved;
        let mut forces = Mat::<f64>::from_fn(factor.nrows(), 1, |r, _| {
            columns[(r, RIGID)] - (0..RIGID).map(|m| columns[(r, m)] * rigid[m]).sum::<f64>()
        });
        solve_upper_triangular_in_place(factor.transpose(), forces.as_mut(), Par::Seq);
        contact.force.fill(DVec3::ZERO);
        for (a, function) in basis.iter().enumerate() {
            contact.force[*function] = DVec3::from_array([0, 1, 2].map(|k| forces[(3 * a + k, 0)]));
        }
        let moved = self.graph.basis.displacements(&contact.force);
        let mut same = true;
        for (function, query) in before.queries[pad].iter().enumerate() {
            let QueriedPoint { gap, normal, .. } = *query;
            if !contact.active[function] {
                let moves = self.rigid_jacobian_row(pad, before, query, normal);
                let by: f64 = moves.iter().zip(rigid).map(|(m, q)| m * q).sum();
                let inside = gap + by + normal.dot(moved[function] - before.displacement[pad][function]) < -1e-9;
                (contact.active[function], same) = (inside, same && !inside);
                continue;
            }
            let (force, slip_compliance) = (contact.force[function], contact.slip_compliance[function]);
            let push = force.dot(normal);
            if push < 0.0 {
                (contact.active[function], contact.slip_compliance[function], same) = (false, 0.0, false);
                continue;
            }
            let own = self.graph.basis.self_compliance(function);
            let beyond = tangential(force, normal, self.friction).1;
            let softer = ((own + slip_compliance) * beyond - own).clamp(0.0, 1e6);
            same &= (softer - slip_compliance).abs() <= CONVERGED * (own + softer);
            contact.slip_compliance[function] += part * (softer - slip_compliance);
        }
        same
    }
}

impl Contact {
    /// Creates the basis functions of pad `p` at the start of a step.
    fn new(before: &Equilibrium, p: usize) -> Self {
        let mut active: Vec<bool> = before.force[p].iter().map(|f| *f != DVec3::ZERO).collect();
        if !active.contains(&true) {
            let nearest = before.queries[p].iter().map(|s| s.gap).fold(f64::INFINITY, f64::min);
            active = before.queries[p].iter().map(|s| s.gap <= nearest + NEAR && s.normal != DVec3::ZERO).collect();
        }
        Self { slip_compliance: vec![0.0; active.len()], force: before.force[p].clone(), active }
    }
}
