//! A world for one grasp: entities with the components that the scene needs, and the resources of a step.

use crate::audit::Audited;
use crate::components::*;
use crate::grasp::GraspPose;
use crate::model::{FingerModel, Model};
use crate::schedule::{Advance, Balance, Grasp, Next, Phase, Recorded, Shared, Timings};
use bevy_ecs::world::World;
use glam::DVec3;
use std::sync::Arc;

/// A fresh world for a grasp at `pose`, in [`Phase::Place`].
pub fn spawn(model: &Arc<Model>, pose: GraspPose) -> World {
    let mut world = World::new();
    for (index, finger) in model.fingers.iter().enumerate() {
        let of = FingerIndex(index as u32);
        spawn_nodes(&mut world, model, finger, of);
        if model.needs.stress {
            world.spawn_batch((0..finger.body.element_count()).map(|t| (TetIndex(t as u32), of, TetStress(0.0))));
        }
        let points = (finger.surface.points.len() + model.features.len()) as u32;
        if model.needs.friction {
            world.spawn_batch(
                (0..points).map(|e| (EdgeIndex(e), of, ContactEdge::default(), ContactFriction::default())),
            );
        } else {
            world.spawn_batch((0..points).map(|e| (EdgeIndex(e), of, ContactEdge::default())));
        }
        let closing = ClosingDirection(finger.placement.closing);
        world.spawn((of, closing, FirstContact(0.0), FingerTravel(0.0), FingerForce(0.0), FingerWrench::default()));
    }
    let start = pose.object_in_hand();
    let mut object = world.spawn(ObjectPose { position: start.position, rotation: start.rotation });
    if model.needs.free_object {
        object.insert(FreeObject);
        if model.needs.task || model.gravity.is_some() {
            let gravity = model.gravity.unwrap_or_default();
            object.insert(ObjectWeight(start.rotation * gravity * model.mass));
        }
        if model.needs.dynamic {
            object.insert((ObjectVelocity::default(), ObjectMomentum::default(), InertialWrench::default()));
        }
        if model.needs.ground {
            object.insert(GroundWrench::default());
        }
    }
    if model.needs.dynamic {
        world.spawn(HandPose { position: pose.position, rotation: pose.rotation });
    }
    world.insert_resource(Shared(model.clone()));
    world.insert_resource(Grasp(pose));
    world.insert_resource(Phase::Place);
    world.insert_resource(Next::default());
    world.insert_resource(Advance::default());
    world.insert_resource(Balance::default());
    world.insert_resource(Recorded::default());
    world.insert_resource(Timings::default());
    if model.needs.audit {
        world.insert_resource(Audited::default());
    }
    world
}

fn spawn_nodes(world: &mut World, model: &Model, finger: &FingerModel, of: FingerIndex) {
    let mut on_surface = vec![false; finger.body.rest.len()];
    for face in &finger.surface.faces {
        face.corners.iter().chain(face.mids.iter().flatten()).for_each(|&n| on_surface[n as usize] = true);
    }
    for (i, &rest) in finger.body.rest.iter().enumerate() {
        let kind = match (finger.body.fixed[i], on_surface[i]) {
            (true, _) => NodeKind::Bonded,
            (false, true) => NodeKind::Surface,
            (false, false) => NodeKind::Interior,
        };
        let mut node = world.spawn((NodeIndex(i as u32), of, kind, RestPosition(rest), Position(rest)));
        if model.needs.stress {
            node.insert(NodalStress(0.0));
        }
        if model.needs.contact_force {
            node.insert(ContactForce(DVec3::ZERO));
        }
        if model.needs.gap {
            node.insert(NodeGap(0.0));
        }
    }
}
