//! Frame of a prediction for tactile sensors, bitwise identical to that recorded by a run with the network.

use super::batch::PredictedGrasp;
use super::contact_correction::object_pose;
use super::predicted_state::PadState;
use geometry::Pose;
use glam::DVec3;
use model::Model;
use record::{Frame, PadFrame};
use world::components::ContactForce;
use world::systems::{contact_area, slip};

impl PredictedGrasp {
    /// Returns the frame under load `load` with the inputs of tactile sensors: shape and forces of the pads, pose of
    /// the object; None after the last load.
    pub fn frame(&self, model: &Model, load: usize) -> Option<Frame> {
        let state = self.interpolation.at(load)?;
        let object = object_pose(model, &self.first_contact, &state.pads);
        let pad = |(f, pad): (usize, &PadState)| self.pad(model, f, pad, &object);
        Some(Frame {
            index: load,
            travel: state.pads.iter().map(|pad| pad.travel).collect(),
            object_position: object.position,
            object_rotation: object.rotation,
            pads: state.pads.iter().enumerate().map(pad).collect(),
            error: Some(state.error),
            ..Frame::default()
        })
    }

    fn pad(&self, model: &Model, f: usize, state: &PadState, object: &Pose) -> PadFrame {
        let finger = &model.fingers[f];
        let axes = finger.placement.rotation;
        let carried = finger.placement.closing * (self.first_contact.travel[f] + state.travel);
        let rest = &finger.body.rest;
        let place: Vec<DVec3> = rest.iter().zip(&state.displacement).map(|(x, u)| *x + axes * *u).collect();
        let position: Vec<DVec3> = place.iter().map(|x| *x + carried).collect();
        let force: Vec<ContactForce> = state.contact.iter().map(|force| ContactForce(axes * *force)).collect();
        let slips = || slip::slip_from_nodal_forces((model, f), position.iter().copied(), &force, object);
        PadFrame {
            displacement: place.iter().zip(rest).map(|(x, rest)| *x - *rest).collect(),
            slip: if model.needs.slip { slips() } else { Vec::new() },
            contact_area: if model.needs.contact_area {
                contact_area::area_from_nodal_forces(finger, &force)
            } else {
                0.0
            },
            contact_force: force.into_iter().map(|force| force.0).collect(),
            position,
            ..PadFrame::default()
        }
    }
}
