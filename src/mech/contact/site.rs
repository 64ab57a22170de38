//! Place where a feature of the object meets a pad.

use super::incident_faces::{IncidentFace, LastContact};
use super::surface::ContactSurface;
use crate::mech::potential::state::BodyView;
use crate::mech::potential::term::Stencil;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Position of a feature on the object, and its contact with a pad.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Site {
    /// Position of the feature in the object frame, m.
    pub position: DVec3,
    /// Number of moves along its edge since the last accepted state.
    pub moves: u32,
    /// Contact with the pad, if any. Few features are near a pad: the others are copied with every state at no cost.
    pub touch: Option<Box<FeatureTouch>>,
}

/// Point where a feature meets the pad now, and point where it sticks.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FeatureTouch {
    /// Faces that the feature presses on, the nearest first.
    pub incident: Vec<IncidentFace>,
    /// Point of the nearest face that is touched.
    pub now: Stencil,
    /// Point of the pad where the feature sticks.
    pub stick: Stencil,
    /// Nodes that share the force for reporting.
    pub report: Stencil,
}

impl Site {
    /// Creates the site of a feature at `position` (object frame, m) that is nowhere near.
    pub fn new(position: DVec3) -> Self {
        Self { position, moves: 0, touch: None }
    }

    /// Faces that the feature presses on, the nearest first.
    pub fn incident(&self) -> &[IncidentFace] {
        self.touch.as_ref().map_or(&[], |touch| &touch.incident)
    }

    /// Contact at the last assembly; `stays` keeps its choice of faces.
    pub fn last(&self, stays: bool) -> Option<LastContact> {
        let folded = self.incident().len() > 1;
        self.incident().first().map(|(closest_point, ..)| LastContact {
            face: closest_point.face,
            carried: closest_point.carried,
            folded,
            stays,
        })
    }

    /// Sets the `incident` faces of `surface` that the feature presses on now.
    pub fn press(&mut self, incident: Vec<IncidentFace>, surface: &ContactSurface) {
        let Some((closest_point, ..)) = incident.first() else {
            self.touch.iter_mut().for_each(|touch| touch.incident.clear());
            return;
        };
        let face = &surface.faces[closest_point.face];
        let (now, report) = (face.stencil(closest_point.l), face.report_stencil(closest_point.l));
        let fresh = || Box::new(FeatureTouch { incident: Vec::new(), now, stick: now, report });
        let touch = self.touch.get_or_insert_with(fresh);
        (touch.incident, touch.now, touch.report) = (incident, now, report);
    }

    /// Position of the feature under `view`, m, relative to the finger.
    pub fn place(&self, view: &BodyView) -> DVec3 {
        view.object.position + view.object.rotation * self.position - view.offset
    }
}
