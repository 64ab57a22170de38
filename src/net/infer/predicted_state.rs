//! State that the network predicts for a grasp.

use glam::DVec3;
use record::{ErrorBound, FieldTransfer};

/// State predicted for one pad at one load level, pad frame, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct PadState {
    /// Displacement of every node, m; exactly zero where bonded.
    pub displacement: Vec<DVec3>,
    /// Von Mises stress of every node, Pa, >= 0.
    pub stress: Vec<f64>,
    /// Contact force on every node, N; the components along the closing direction sum to the pressing force of the
    /// finger.
    pub contact: Vec<DVec3>,
    /// Travel of the finger since first contact, m.
    pub travel: f64,
    /// Translation of the object (of its point midway between the pads) since first contact, m.
    pub translation: DVec3,
    /// Rotation vector of the object since first contact.
    pub rotation_vector: DVec3,
}

impl PadState {
    /// Returns the state on another mesh.
    fn transferred(&self, map: &FieldTransfer) -> Self {
        Self {
            displacement: map.displacement(&self.displacement),
            // Quadratic shape functions may be negative.
            stress: if self.stress.is_empty() {
                Vec::new()
            } else {
                map.values(&self.stress).into_iter().map(|s| s.max(0.0)).collect()
            },
            contact: map.force(&self.contact),
            ..*self
        }
    }
}

/// State predicted for a grasp at one load level.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspState {
    /// States of the pads, left first.
    pub pads: Vec<PadState>,
    /// Flag: a free object is still supported and does not move.
    pub held: bool,
    /// Upper ends of the prediction intervals (90 %); unknown outside the range of the training.
    pub error: ErrorBound,
}

impl GraspState {
    /// Returns the state on another mesh. The prediction intervals of the fields grow by the estimated error of their
    /// interpolation, which is independent of the error of the network; that of the displacement is estimated on the
    /// sensing faces, because an answer may omit the displacement below them.
    pub fn transferred(&self, map: &FieldTransfer) -> Self {
        let pads: Vec<PadState> = self.pads.iter().map(|pad| pad.transferred(map)).collect();
        let (mut displacement, mut stress) = ([0.0; 2], [0.0; 2]);
        for (own, there) in self.pads.iter().zip(&pads) {
            let squares = |field: &[DVec3]| map.face().iter().map(|i| field[*i as usize].length_squared()).sum::<f64>();
            displacement[0] += squares(&map.errors(&own.displacement));
            displacement[1] += squares(&there.displacement);
            if !own.stress.is_empty() {
                stress[0] += map.errors(&own.stress).iter().map(|s| s * s).sum::<f64>();
                stress[1] += there.stress.iter().map(|s| s * s).sum::<f64>();
            }
        }
        let grown = |bound: f64, [error, whole]: [f64; 2]| {
            if whole > 0.0 { bound.hypot((error / whole).sqrt()) } else { bound }
        };
        let error = ErrorBound {
            displacement: grown(self.error.displacement, displacement),
            stress: grown(self.error.stress, stress),
            ..self.error
        };
        Self { pads, error, ..*self }
    }
}
