//! World for one grasp: entities with the components that the scene needs, and the resources of a step.

use crate::components::*;
use crate::schedule::{
    BalanceReport, FallbackReason, ForceCommand, GraspPose, NextPhase, Phase, RecordedFrame, SharedModel, StepLoad,
    StepReport, Timings,
};
use crate::systems::audit::AuditFindings;
use bevy_ecs::component::{Component, Mutable};
use bevy_ecs::entity::Entity;
use bevy_ecs::world::World;
use geometry::Pose;
use glam::DVec3;
use model::Model;
use model::part::FingerModel;
use std::sync::Arc;

/// Spawns a new world for a grasp at `pose`, in [`Phase::Place`].
pub fn spawn(model: &Arc<Model>, pose: Pose) -> World {
    let mut world = World::new();
    spawn_nodes(&mut world, model);
    for (of, finger) in pads(model) {
        if model.needs.stress {
            world.spawn_batch((0..finger.body.element_count()).map(|_| (of, TetStress(0.0))));
        }
        let closing = ClosingDirection(finger.placement.closing);
        let state = (FirstContact(0.0), FingerTravel(0.0), FingerForce(0.0), FingerWrench::default());
        let mut entity = world.spawn((of, closing, state));
        if model.needs.contact_area {
            entity.insert(ContactArea(0.0));
        }
    }
    let mut object = world.spawn(ObjectPose(Pose::IDENTITY));
    if model.needs.free_object {
        if model.needs.task || model.gravity.is_some() {
            object.insert(ObjectWeight(DVec3::ZERO));
        }
        if model.needs.dynamic {
            object.insert((ObjectVelocity::default(), ObjectMomentum::default(), InertialWrench::default()));
        }
        if model.needs.ground {
            object.insert(GroundWrench::default());
        }
    }
    if model.needs.dynamic {
        world.spawn(HandPose(pose));
    }
    reset(&mut world, model, pose);
    world
}

/// Resets a world of `model` to the start of a grasp at `pose`: columns and resources are as in a new one.
pub fn reset(world: &mut World, model: &Arc<Model>, pose: Pose) {
    for (rest, mut x) in world.query::<(&RestPosition, &mut Position)>().iter_mut(world) {
        x.0 = rest.0;
    }
    set_all(world, NodalStress(0.0));
    set_all(world, ContactForce(DVec3::ZERO));
    set_all(world, NodeGap(0.0));
    set_all(world, NodeSlip(0.0));
    set_all(world, TetStress(0.0));
    set_all(world, ContactEdge::default());
    set_all(world, ContactFriction::default());
    set_all(world, FirstContact(0.0));
    set_all(world, FingerTravel(0.0));
    set_all(world, FingerForce(0.0));
    set_all(world, FingerWrench::default());
    set_all(world, ContactArea(0.0));
    let start = pose.inverse();
    set_all(world, ObjectPose(start));
    set_all(world, ObjectWeight(start.rotation * model.gravity.unwrap_or_default() * model.mass));
    set_all(world, ObjectVelocity::default());
    set_all(world, ObjectMomentum::default());
    set_all(world, InertialWrench::default());
    set_all(world, GroundWrench::default());
    set_all(world, HandPose(pose));
    world.remove_resource::<ForceCommand>();
    world.remove_resource::<FallbackReason>();
    world.insert_resource(SharedModel(model.clone()));
    world.insert_resource(GraspPose(pose));
    world.insert_resource(Phase::Place);
    world.insert_resource(NextPhase::default());
    world.insert_resource(StepLoad::default());
    world.insert_resource(StepReport::default());
    world.insert_resource(BalanceReport::default());
    world.insert_resource(RecordedFrame::default());
    world.insert_resource(Timings::default());
    if model.needs.audit {
        world.insert_resource(AuditFindings::default());
    }
}

/// Sets this component of all entities to the same value.
fn set_all<C: Component<Mutability = Mutable> + Clone>(world: &mut World, value: C) {
    world.query::<&mut C>().iter_mut(world).for_each(|mut own| own.clone_from(&value));
}

/// Spawns the contact edges, for a stepper that computes contact forces between nodes.
pub fn spawn_edges(world: &mut World, model: &Model) {
    let edges = pads(model).flat_map(|(of, finger)| {
        let count = finger.surface.points.len() + model.features.len();
        (0..count).map(move |_| (of, ContactEdge::default()))
    });
    let edges: Vec<Entity> = world.spawn_batch(edges).collect();
    if model.needs.friction {
        add_column(world, &edges, ContactFriction::default());
    }
}

/// Spawns the nodes of all pads.
fn spawn_nodes(world: &mut World, model: &Model) {
    let nodes =
        pads(model).flat_map(|(of, finger)| finger.body.rest.iter().map(move |&x| (of, RestPosition(x), Position(x))));
    let nodes: Vec<Entity> = world.spawn_batch(nodes).collect();
    if model.needs.stress {
        add_column(world, &nodes, NodalStress(0.0));
    }
    if model.needs.contact_force {
        add_column(world, &nodes, ContactForce(DVec3::ZERO));
    }
    if model.needs.gap {
        add_column(world, &nodes, NodeGap(0.0));
    }
    if model.needs.slip {
        add_column(world, &nodes, NodeSlip(0.0));
    }
}

/// Returns the pads in the order of their fingers.
fn pads(model: &Model) -> impl Iterator<Item = (FingerIndex, &FingerModel)> {
    (0..).map(FingerIndex).zip(&model.fingers)
}

/// Adds a component with this value to entities. They move to another table one by one, so their order is preserved.
fn add_column<C: Component + Copy>(world: &mut World, entities: &[Entity], value: C) {
    world.insert_batch(entities.iter().map(|&entity| (entity, value)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_in_the_order_of_their_spawn_when_columns_are_added() {
        let mut world = World::new();
        let nodes: Vec<Entity> =
            world.spawn_batch((0..100).map(|i| (FingerIndex(i / 60), FirstContact(f64::from(i))))).collect();
        add_column(&mut world, &nodes, NodalStress(0.0));
        add_column(&mut world, &nodes, NodeGap(0.0));
        let mut query = world.query::<(&FingerIndex, &FirstContact, &NodalStress, &NodeGap)>();
        let tables: Vec<_> = query.contiguous_iter(&world).expect(TABLES).collect();
        let [(finger, index, ..)] = tables[..] else { panic!("{} tables", tables.len()) };
        assert!(index.iter().map(|i| i.0).eq((0..100).map(f64::from)));
        assert_eq!(rows_by_pad(finger).collect::<Vec<_>>(), [(0, 0..60), (1, 60..100)]);
    }
}
