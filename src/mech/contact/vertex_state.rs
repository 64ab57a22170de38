//! Position of a contact vertex on the object, and its contact with a pad.

use super::incident_faces::{IncidentFace, LastContact};
use super::surface::ContactSurface;
use crate::potential::state::BodyView;
use crate::potential::stencil::Stencil;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Position of a contact vertex on the object, and its contact with a pad.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct VertexState {
    /// Position of the vertex in the object frame, m.
    pub position: DVec3,
    /// Number of moves along its edge since the last accepted state.
    pub moves: u32,
    /// Contact with the pad, if any. Few vertices are near a pad; for the others, a copy of the state costs nothing.
    pub contact: Option<Box<VertexContactPoint>>,
}

/// Current contact point of a vertex on the pad, and its sticking point.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct VertexContactPoint {
    /// Faces that the vertex presses on, the nearest first.
    pub incident: Vec<IncidentFace>,
    /// Contact point on the nearest face.
    pub point: Stencil,
    /// Sticking point on the pad.
    pub sticking_point: Stencil,
    /// Nodes among which reports distribute the force.
    pub report: Stencil,
}

impl VertexState {
    /// Creates the site of a vertex at `position` (object frame, m) without contact.
    pub fn new(position: DVec3) -> Self {
        Self { position, moves: 0, contact: None }
    }

    /// Faces that the vertex presses on, the nearest first.
    pub fn incident(&self) -> &[IncidentFace] {
        self.contact.as_ref().map_or(&[], |touch| &touch.incident)
    }

    /// Contact at the last assembly; its choice of faces is kept if it `keeps_faces`.
    pub fn last(&self, keeps_faces: bool) -> Option<LastContact> {
        let folded = self.incident().len() > 1;
        self.incident().first().map(|(closest_point, ..)| LastContact {
            face: closest_point.face,
            extended: closest_point.extended,
            folded,
            keeps_faces,
        })
    }

    /// Sets the `incident` faces of `surface` that the vertex currently presses on.
    pub fn set_incident(&mut self, incident: Vec<IncidentFace>, surface: &ContactSurface) {
        let Some((closest_point, ..)) = incident.first() else {
            self.contact.iter_mut().for_each(|touch| touch.incident.clear());
            return;
        };
        let face = &surface.faces[closest_point.face];
        let (point, report) = (face.stencil(closest_point.l), face.report_stencil(closest_point.l));
        let fresh = || Box::new(VertexContactPoint { incident: Vec::new(), point, sticking_point: point, report });
        let touch = self.contact.get_or_insert_with(fresh);
        (touch.incident, touch.point, touch.report) = (incident, point, report);
    }

    /// Position of the vertex under `view`, m, relative to the finger.
    pub fn relative_position(&self, view: &BodyView) -> DVec3 {
        view.object.position + view.object.rotation * self.position - view.offset
    }
}
