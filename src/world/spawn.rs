//! A world for one grasp: entities with the components that the scene needs, and the resources of a step.

use crate::gripper::GraspPose;
use crate::model::Model;
use crate::part::FingerModel;
use crate::world::components::*;
use crate::world::schedule::{
    BalanceReport, CurrentGrasp, ForceCommand, Next, Phase, Recorded, Shared, StepLoad, StepReport, Timings,
};
use crate::world::systems::audit::Audited;
use bevy_ecs::bundle::{Bundle, NoBundleEffect};
use bevy_ecs::component::{Component, Mutable};
use bevy_ecs::world::World;
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// Spawns a fresh world for a grasp at `pose`, in [`Phase::Place`].
pub fn spawn(model: &Arc<Model>, pose: GraspPose) -> World {
    let mut world = World::new();
    for (index, finger) in model.fingers.iter().enumerate() {
        let of = FingerIndex(index as u32);
        spawn_nodes(&mut world, model, finger, of);
        if model.needs.stress {
            world.spawn_batch((0..finger.body.element_count()).map(|_| (of, TetStress(0.0))));
        }
        let closing = ClosingDirection(finger.placement.closing);
        world.spawn((of, closing, FirstContact(0.0), FingerTravel(0.0), FingerForce(0.0), FingerWrench::default()));
    }
    let mut object = world.spawn(ObjectPose { position: DVec3::ZERO, rotation: DQuat::IDENTITY });
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
        world.spawn(HandPose { position: pose.position, rotation: pose.rotation });
    }
    begin(&mut world, model, pose);
    world
}

/// Takes a world of `model` to the start of a grasp at `pose`: columns and resources are as in a fresh one.
pub fn begin(world: &mut World, model: &Arc<Model>, pose: GraspPose) {
    for (rest, mut x) in world.query::<(&RestPosition, &mut Position)>().iter_mut(world) {
        x.0 = rest.0;
    }
    fill(world, NodalStress(0.0));
    fill(world, ContactForce(DVec3::ZERO));
    fill(world, NodeGap(0.0));
    fill(world, TetStress(0.0));
    fill(world, ContactEdge::default());
    fill(world, ContactFriction::default());
    fill(world, FirstContact(0.0));
    fill(world, FingerTravel(0.0));
    fill(world, FingerForce(0.0));
    fill(world, FingerWrench::default());
    let start = pose.object_in_hand();
    fill(world, ObjectPose { position: start.position, rotation: start.rotation });
    fill(world, ObjectWeight(start.rotation * model.gravity.unwrap_or_default() * model.mass));
    fill(world, ObjectVelocity::default());
    fill(world, ObjectMomentum::default());
    fill(world, InertialWrench::default());
    fill(world, GroundWrench::default());
    fill(world, HandPose { position: pose.position, rotation: pose.rotation });
    world.remove_resource::<ForceCommand>();
    world.insert_resource(Shared(model.clone()));
    world.insert_resource(CurrentGrasp(pose));
    world.insert_resource(Phase::Place);
    world.insert_resource(Next::default());
    world.insert_resource(StepLoad::default());
    world.insert_resource(StepReport::default());
    world.insert_resource(BalanceReport::default());
    world.insert_resource(Recorded::default());
    world.insert_resource(Timings::default());
    if model.needs.audit {
        world.insert_resource(Audited::default());
    }
}

/// Gives all entities with this component the same value.
fn fill<C: Component<Mutability = Mutable> + Clone>(world: &mut World, value: C) {
    world.query::<&mut C>().iter_mut(world).for_each(|mut own| own.clone_from(&value));
}

/// Spawns the contact edges, for a stepper that knows forces between nodes.
pub fn spawn_edges(world: &mut World, model: &Model) {
    for (index, finger) in model.fingers.iter().enumerate() {
        let of = FingerIndex(index as u32);
        let edges = (0..(finger.surface.points.len() + model.features.len()) as u32).map(|e| (EdgeIndex(e), of));
        if model.needs.friction {
            world.spawn_batch(edges.map(|(e, of)| (e, of, ContactEdge::default(), ContactFriction::default())));
        } else {
            world.spawn_batch(edges.map(|(e, of)| (e, of, ContactEdge::default())));
        }
    }
}

fn spawn_nodes(world: &mut World, model: &Model, finger: &FingerModel, of: FingerIndex) {
    let nodes = finger.body.rest.iter().map(|&x| (of, RestPosition(x), Position(x)));
    // All columns at once: one that comes later moves every node to another table.
    let (stress, force, gap) = (NodalStress(0.0), ContactForce(DVec3::ZERO), NodeGap(0.0));
    match (model.needs.stress, model.needs.contact_force, model.needs.gap) {
        (false, false, false) => with(world, nodes, ()),
        (false, false, true) => with(world, nodes, gap),
        (false, true, false) => with(world, nodes, force),
        (false, true, true) => with(world, nodes, (force, gap)),
        (true, false, false) => with(world, nodes, stress),
        (true, false, true) => with(world, nodes, (stress, gap)),
        (true, true, false) => with(world, nodes, (stress, force)),
        (true, true, true) => with(world, nodes, (stress, force, gap)),
    }
}

/// Spawns `nodes`, each with `more`.
fn with<N, M>(world: &mut World, nodes: impl Iterator<Item = N>, more: M)
where
    N: Bundle<Effect: NoBundleEffect>,
    M: Bundle<Effect: NoBundleEffect> + Clone,
{
    world.spawn_batch(nodes.map(|node| (node, more.clone())));
}
