//! Inertia and weight of a free rigid object.

use super::block::{Pair, RigidBlock};
use super::cross::{cross_matrix, rotation_hessian};
use super::state::ObjectView;
use super::term::{Assembly, ObjectTerm};
use super::time_step::TimeStep;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use geometry::shape::MassProperties;
use geometry::{Pose, Wrench};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Energy `m / 2 h2 |c - target|2` of the centre of mass `c`, and for the rotation `R`, with the second moments
/// `J = integral of r r^T dm` in body axes,
///
/// ```text
/// |R - R0|2_J / 2 h2  -  L0 . log(R Rk^T) / h        |A|2_J = trace(A J A^T)
/// ```
///
/// Its gradient in a rotation of `R` is `(L(R0, R) - L0) / h` with the angular momentum
/// `L(R0, R) = axial(R J R0^T - R0 J R^T) / h` of the step (Moser & Veselov 1991), which is exactly conserved without
/// torque. No potential has the constant gradient `L0` on the rotation group, so that the lagged iterate `Rk` is used;
/// at the solution the balance is exact. The angular momentum must not correspond to more than about a radian per step.
#[derive(Debug, Clone)]
pub struct RigidInertia {
    /// Mass, kg.
    mass: f64,
    /// Centre of mass, object frame, m.
    center: DVec3,
    /// Second moments about it, object axes, kg m2.
    second: DMat3,
    /// Gravity, world axes, m/s2.
    gravity: DVec3,
    /// Motion at the last accepted state.
    state: RigidMotion,
    /// Rates of change of the velocity and the angular momentum in the last accepted step.
    rate: (DVec3, DVec3),
    step: TimeStep,
    /// Centre of mass at the end of the step under its weight alone, hand frame, m.
    target: DVec3,
    /// Rotation and angular momentum at the start, hand axes at the end of the step.
    from: DMat3,
    momentum: DVec3,
    /// Rotation at the last assembly.
    iterate: DMat3,
}

/// Motion of a rigid body in the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RigidMotion {
    /// Centre of mass, m.
    pub position: DVec3,
    /// Object axes to world axes.
    pub rotation: DQuat,
    /// Velocity of the centre of mass, m/s.
    pub velocity: DVec3,
    /// Angular momentum about the centre of mass, kg m2/s.
    pub momentum: DVec3,
}

impl RigidInertia {
    /// Creates the inertia of an object of `density` (kg/m3) that moves with `velocity` (m/s) and `spin` (rad/s), world
    /// axes.
    pub fn new(
        mass: &MassProperties,
        density: f64,
        gravity: DVec3,
        (velocity, spin): (DVec3, DVec3),
        hand: Pose,
        view: &ObjectView,
    ) -> Self {
        let inertia = mass.inertia * density;
        let trace = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
        let rotation = (hand.rotation * DQuat::from_mat3(&view.rotation)).normalize();
        let turn = DMat3::from_quat(rotation);
        let position = hand.transform(view.position + view.rotation * mass.center);
        let momentum = turn * (inertia * (turn.transpose() * spin));
        Self {
            mass: mass.volume * density,
            center: mass.center,
            second: DMat3::IDENTITY * (0.5 * trace) - inertia,
            gravity,
            state: RigidMotion { position, rotation, velocity, momentum },
            rate: (DVec3::ZERO, DVec3::ZERO),
            step: TimeStep { size: 1.0, hand },
            target: DVec3::ZERO,
            from: view.rotation,
            momentum: DVec3::ZERO,
            iterate: view.rotation,
        }
    }

    /// Begins a time step.
    pub fn begin_step(&mut self, step: &TimeStep) {
        self.step = *step;
        let (h, m) = (step.size, &self.state);
        self.target = step.hand.inverse_transform(m.position + m.velocity * h + self.gravity * (h * h));
        let back = step.hand.rotation.conjugate();
        self.from = DMat3::from_quat((back * m.rotation).normalize());
        self.momentum = back * m.momentum;
    }

    /// Motion at the last accepted state.
    pub fn motion(&self) -> &RigidMotion {
        &self.state
    }

    /// Angular velocity at the last accepted state, world axes, rad/s.
    pub fn spin(&self) -> DVec3 {
        let turn = DMat3::from_quat(self.state.rotation);
        let second = turn * self.second * turn.transpose();
        (DMat3::IDENTITY * trace(&second) - second).inverse() * self.state.momentum
    }

    /// Linear momentum, kg m/s, and angular momentum about the centre of mass, kg m2/s, world axes.
    pub fn momenta(&self) -> (DVec3, DVec3) {
        (self.state.velocity * self.mass, self.state.momentum)
    }

    /// Forces of inertia about the centre of mass, world axes: minus the rates of the momenta over the last accepted step.
    pub fn inertial_wrench(&self) -> Wrench {
        Wrench { force: self.rate.0 * -self.mass, torque: -self.rate.1 }
    }

    /// Weight, N, world axes.
    pub fn weight(&self) -> DVec3 {
        self.gravity * self.mass
    }

    /// Angular momentum of the rotation from `from` to `to` within a step.
    fn step_momentum(&self, to: &DMat3) -> DVec3 {
        axial(&(*to * self.second * self.from.transpose())) * (1.0 / self.step.size)
    }
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Axial vector of `a - a^T`.
fn axial(a: &DMat3) -> DVec3 {
    DVec3::new(a.y_axis.z - a.z_axis.y, a.z_axis.x - a.x_axis.z, a.x_axis.y - a.y_axis.x)
}

/// Rotation vector of a rotation by less than half a turn.
fn log(r: &DMat3) -> DVec3 {
    let sine = axial(r) * 0.5;
    let (s, c) = (sine.length(), 0.5 * (trace(r) - 1.0));
    if s == 0.0 { sine } else { sine * (s.atan2(c) / s) }
}

impl ObjectTerm for RigidInertia {
    fn energy(&self, view: &ObjectView) -> f64 {
        let h = self.step.size;
        let off = view.position + view.rotation * self.center - self.target;
        let d = view.rotation - self.from;
        let spread = trace(&(d * self.second * d.transpose()));
        let turn = log(&(view.rotation * self.iterate.transpose()));
        // The constant has the size of the terms that cancel in `d`: it sets the rounding tolerance of the line search.
        let constant = trace(&self.second);
        0.5 * (self.mass * off.length_squared() + spread + constant) / (h * h) - self.momentum.dot(turn) / h
    }

    fn assemble(&mut self, view: &ObjectView, how: Assembly, block: &mut RigidBlock) {
        if view.column.is_none() {
            return;
        }
        let h = self.step.size;
        self.iterate = view.rotation;
        let arm = view.rotation * self.center;
        let stiffness = self.mass / (h * h);
        let force = (view.position + arm - self.target) * stiffness;
        let torque = (self.step_momentum(&view.rotation) - self.momentum) / h;
        let mut a = view.rotation * self.second * self.from.transpose();
        let cross = cross_matrix(arm);
        let mut ww = cross.transpose() * cross * stiffness;
        if how.project {
            a = self.from * self.second * self.from.transpose();
        } else {
            ww += rotation_hessian(force, arm);
        }
        ww += (DMat3::IDENTITY * trace(&a) - (a + a.transpose()) * 0.5) * (1.0 / (h * h));
        let pair = Pair {
            force: -force,
            torque: arm.cross(force) + torque,
            dd: DMat3::IDENTITY * stiffness,
            dw: cross * stiffness,
            ww,
        };
        block.add_object_pair(view, &pair);
        block.force_scale += self.mass * self.gravity.length();
    }

    fn commit(&mut self, view: &ObjectView) {
        let (h, hand) = (self.step.size, &self.step.hand);
        let position = hand.transform(view.position + view.rotation * self.center);
        let velocity = (position - self.state.position) / h;
        let momentum = hand.rotation * self.step_momentum(&view.rotation);
        self.rate = ((velocity - self.state.velocity) / h, (momentum - self.state.momentum) / h);
        let rotation = (hand.rotation * DQuat::from_mat3(&view.rotation)).normalize();
        self.state = RigidMotion { position, rotation, velocity, momentum };
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&(self.state, self.rate, self.iterate));
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        (self.state, self.rate, self.iterate) = history.read()?;
        Ok(())
    }
}
