//! Where a feature of the object meets a pad.

use super::incident_faces::{IncidentFace, LastContact};
use super::surface::ContactSurface;
use crate::mech::potential::state::BodyView;
use crate::mech::potential::term::Stencil;
use glam::DVec3;

/// Where a feature is on the object, and what it presses on.
#[derive(Debug, Clone)]
pub(crate) struct Site {
    /// Position of the feature in the object frame, m.
    pub position: DVec3,
    /// How often it has moved along its edge since the last accepted state.
    pub moves: u32,
    /// Few features are near a pad: the others are copied with every state at no cost.
    pub touch: Option<Box<FeatureTouch>>,
}

/// Where a feature meets the pad now, and where it sticks.
#[derive(Debug, Clone)]
pub(crate) struct FeatureTouch {
    /// The faces it presses on, the nearest first.
    pub incident: Vec<IncidentFace>,
    /// Where the nearest is touched.
    pub now: Stencil,
    /// Where it sticks.
    pub stick: Stencil,
    /// Nodes that share the force for reporting.
    pub report: Stencil,
}

impl Site {
    /// Of a feature at `position` (object frame, m) that is nowhere near.
    pub fn new(position: DVec3) -> Self {
        Self { position, moves: 0, touch: None }
    }

    /// The faces it presses on, the nearest first.
    pub fn incident(&self) -> &[IncidentFace] {
        self.touch.as_ref().map_or(&[], |touch| &touch.incident)
    }

    /// What it pressed on at the last assembly.
    pub fn last(&self, stays: bool) -> Option<LastContact> {
        let folded = self.incident().len() > 1;
        self.incident().first().map(|(closest_point, ..)| LastContact {
            face: closest_point.face,
            carried: closest_point.carried,
            folded,
            stays,
        })
    }

    /// It presses on `incident faces` of `surface` now.
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

    /// Where the feature is under `view`, m, relative to the finger.
    pub fn place(&self, view: &BodyView) -> DVec3 {
        view.position + view.rotation * self.position - view.offset
    }
}
