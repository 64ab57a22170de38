//! Force on a point of a free object, as a term of the potential: weight, and pushes.

use super::block::RigidBlock;
use super::state::ObjectView;
use super::term::{Assembly, ObjectTerm};
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use glam::{DMat3, DVec3};

/// Dead load at a point of the object: potential `-f . x`.
#[derive(Debug, Clone, Copy)]
pub struct PointLoad {
    /// Full force, N, hand frame.
    pub force: DVec3,
    /// Point in the object frame, m.
    pub point: DVec3,
    /// Position of the point at the start, hand frame, m: reference of the potential, which avoids cancellation.
    pub start: DVec3,
    /// Acting fraction of the force: a support carries the rest of a weight, and a push is raised gradually.
    pub fraction: f64,
}

impl PointLoad {
    /// Creates a load of `force` N at `point` (object frame, m), which is at `start` (hand frame, m).
    pub fn new(force: DVec3, point: DVec3, start: DVec3) -> Self {
        Self { force, point, start, fraction: 1.0 }
    }

    /// Acting force, N.
    fn acting(&self) -> DVec3 {
        self.force * self.fraction
    }
}

impl ObjectTerm for PointLoad {
    fn energy(&self, view: &ObjectView) -> f64 {
        -self.acting().dot(view.position + view.rotation * self.point - self.start)
    }

    fn assemble(&mut self, view: &ObjectView, how: Assembly, block: &mut RigidBlock) {
        let (f, r) = (self.acting(), view.rotation * self.point);
        let (Some(c), true) = (view.column, f != DVec3::ZERO) else { return };
        let torque = r.cross(f).to_array();
        for (k, (f, t)) in f.to_array().into_iter().zip(torque).enumerate() {
            block.gradient[c + k] -= f;
            block.gradient[c + 3 + k] -= t / view.length;
        }
        if block.wants_hessian && !how.project {
            // Second derivative in w of -f . (w x (w x r)) / 2.
            let half = DMat3::from_cols(f * r.x + r * f.x, f * r.y + r * f.y, f * r.z + r * f.z) * 0.5;
            let h = (half - DMat3::IDENTITY * f.dot(r)) * (-1.0 / (view.length * view.length));
            for i in 0..3 {
                for j in 0..3 {
                    block.hessian[c + 3 + i][c + 3 + j] += h.col(j)[i];
                }
            }
        }
        block.force_scale += f.length();
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&(self.force, self.fraction));
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        (self.force, self.fraction) = history.read()?;
        Ok(())
    }
}
