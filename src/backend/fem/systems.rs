//! Systems of the finite element backend: columns -> solver -> one load level -> columns.

use super::dynamics::systems::{advance_time, measure_ground, measure_motion};
use super::solver::GraspSolver;
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use geometry::Wrench;
use glam::DVec3;
use mech::path::continuation::MethodCounts;
use mech::potential::edge::{EdgeReading, EdgeState};
use model::Needs;
use rayon::prelude::*;
use std::collections::BTreeMap;
use world::components::*;
use world::schedule::{
    BalanceReport, NextPhase, Phase, SharedModel, StepLoad, StepReport, StepSet, Timings, computes_frame, reached,
};
use world::systems::apart::reject_pad_overlap;
use world::systems::inversion::inversion_message;
use world::systems::measure::measure_balance;
use world::systems::sense::close_to_contact;

/// Adds the systems to their sets, except those for quantities that the scene does not need.
pub fn register(schedule: &mut Schedule, needs: &Needs, force_driven: bool) {
    let sense = (read_state, read_contact).chain().run_if(computes_frame).after(close_to_contact);
    schedule.add_systems(sense.in_set(StepSet::Sense));
    if needs.task {
        schedule.add_systems(read_weight.run_if(computes_frame).after(read_contact).in_set(StepSet::Sense));
    }
    if needs.dynamic {
        schedule.add_systems((advance_time, write_state).chain().run_if(computes_frame).in_set(StepSet::Advance));
        schedule.add_systems(measure_motion.run_if(reached).before(measure_balance).in_set(StepSet::Measure));
    } else {
        schedule.add_systems((advance_level, write_state).chain().run_if(computes_frame).in_set(StepSet::Advance));
    }
    if needs.ground {
        let ground = measure_ground.run_if(reached).after(read_edges).before(measure_balance);
        let ground = ground.before(measure_stress);
        schedule.add_systems(ground.in_set(StepSet::Measure));
    }
    let contact = (read_edges, write_edges, measure_wrench).chain().run_if(reached).before(measure_balance);
    schedule.add_systems(contact.in_set(StepSet::Measure));
    if needs.friction {
        schedule.add_systems(write_friction.run_if(reached).after(read_edges).in_set(StepSet::Measure));
    }
    schedule.add_systems(report_timings.run_if(computes_frame).in_set(StepSet::Measure));
    if !force_driven && !needs.dynamic {
        schedule.add_systems(measure_reaction.run_if(reached).before(measure_balance).in_set(StepSet::Measure));
    }
    if needs.contact_force {
        schedule.add_systems(measure_nodal_force.run_if(reached).after(read_edges).in_set(StepSet::Measure));
    }
    schedule.add_systems(refuse_inversion.run_if(reached).after(reject_pad_overlap).in_set(StepSet::Accept));
    if needs.stress {
        schedule.add_systems(measure_stress.run_if(reached).in_set(StepSet::Measure));
    }
}

/// Copies columns to the solver: the world holds the state, the solver works on a copy.
pub fn read_state(
    mut solver: ResMut<GraspSolver>,
    nodes: Query<(&FingerIndex, &Position)>,
    fingers: Query<(&FingerIndex, &FingerTravel)>,
    pose: Single<&ObjectPose>,
) {
    let state = &mut solver.path.state;
    for (finger, position) in nodes.contiguous_iter().expect(TABLES) {
        for (f, rows) in rows_by_pad(finger) {
            state.x[f].iter_mut().zip(&position[rows]).for_each(|(x, position)| *x = position.0);
        }
    }
    for (finger, travel) in &fingers {
        state.travel[finger.0 as usize] = travel.0;
    }
    (state.position, state.rotation) = (pose.0.position, pose.0.rotation);
}

/// Copies contact edges from their columns to the solver: active contacts and their friction anchors.
pub fn read_contact(
    mut solver: ResMut<GraspSolver>,
    edges: Query<(&FingerIndex, &ContactEdge, Option<&ContactFriction>)>,
) {
    for (finger, edges, friction) in edges.contiguous_iter().expect(TABLES) {
        for (f, rows) in rows_by_pad(finger) {
            let friction = friction.map(|friction| &friction[rows.clone()]);
            let known = edges[rows].iter().enumerate().map(|(k, edge)| {
                let ContactEdge { gap, normal, pressure, scale, .. } = *edge;
                let ContactFriction { anchor, plane, limit, traction, slips } =
                    friction.map_or_else(ContactFriction::default, |friction| friction[k]);
                let rest = EdgeState::OPEN;
                (k, EdgeState { gap, normal, pressure, scale, anchor, plane, limit, traction, slips, ..rest })
            });
            let closed: Vec<_> = known.filter(|(_, edge)| !edge.is_open()).collect();
            solver.path.newton.set_edges(f, &closed);
        }
    }
}

/// Copies the force on the object from its column to the solver.
pub fn read_weight(mut solver: ResMut<GraspSolver>, weight: Single<&ObjectWeight>) {
    solver.set_weight(weight.0);
}

/// Advances one load level; on failure the state is the last accepted one and the grasp ends.
pub fn advance_level(
    mut solver: ResMut<GraspSolver>,
    shared: Res<SharedModel>,
    load: Res<StepLoad>,
    mut report: ResMut<StepReport>,
    mut balance: ResMut<BalanceReport>,
    mut next: ResMut<NextPhase>,
) {
    match solver.advance(&shared.0, *load) {
        Ok(done) => {
            report.reached = true;
            balance.object_fixed = solver.path.newton.object_fixed;
            report.iterations = done.iterations;
            report.residual = done.residual;
        }
        Err(stop) => next.request(stop.into()),
    }
}

/// Copies the state from the solver to the columns.
pub fn write_state(
    solver: Res<GraspSolver>,
    mut nodes: Query<(&FingerIndex, &mut Position)>,
    mut fingers: Query<(&FingerIndex, &mut FingerTravel)>,
    mut pose: Single<&mut ObjectPose>,
) {
    let state = &solver.path.state;
    for (finger, mut position) in nodes.contiguous_iter_mut().expect(TABLES) {
        // No system observes single nodes: setting the change tick of each would cost more than the write.
        let position = position.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            position[rows].iter_mut().zip(&state.x[f]).for_each(|(position, x)| position.0 = *x);
        }
    }
    for (finger, mut travel) in &mut fingers {
        travel.0 = state.travel[finger.0 as usize];
    }
    pose.0 = state.pose();
}

/// Contact edges of every finger that are not open at the level just reached, in order.
#[derive(Resource, Default)]
pub struct EdgeReadings(Vec<Vec<EdgeReading>>);

/// Reads the edges from the solver, once for all systems that use them; measures the smallest gap and the potential.
pub fn read_edges(solver: Res<GraspSolver>, mut edges: ResMut<EdgeReadings>, mut report: ResMut<StepReport>) {
    let (newton, state) = (&solver.path.newton, &solver.path.state);
    edges.0 = (0..newton.bodies()).map(|i| newton.edge_readings(state, i)).collect();
    report.min_gap = edges.0.iter().flatten().map(|edge| edge.state.gap).fold(f64::INFINITY, f64::min);
    report.energy = solver.energy();
}

/// Writes a column of the edges from their readings; open edges get the default.
fn write_column<C: Component<Mutability = Mutable> + Default + Clone>(
    edges: &EdgeReadings,
    mut pool: Query<(&FingerIndex, &mut C)>,
    of: impl Fn(&EdgeReading) -> C,
) {
    for (finger, mut column) in pool.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            let own = &mut column[rows];
            own.fill(C::default());
            edges.0[f].iter().for_each(|edge| own[edge.number] = of(edge));
        }
    }
}

/// Copies the edges to their columns.
pub fn write_edges(edges: Res<EdgeReadings>, pool: Query<(&FingerIndex, &mut ContactEdge)>) {
    write_column(&edges, pool, |EdgeReading { state, point, force, .. }| {
        let EdgeState { gap, normal, pressure, scale, .. } = *state;
        ContactEdge { gap, normal, pressure, scale, point: *point, force: *force }
    });
}

/// Copies friction on the edges to its column.
pub fn write_friction(edges: Res<EdgeReadings>, pool: Query<(&FingerIndex, &mut ContactFriction)>) {
    write_column(&edges, pool, |EdgeReading { state, .. }| {
        let EdgeState { anchor, plane, limit, traction, slips, .. } = *state;
        ContactFriction { anchor, plane, limit, traction, slips }
    });
}

/// Measures the wrench on every pad: the sum over its contact edges, in their order.
pub fn measure_wrench(
    shared: Res<SharedModel>,
    pool: Query<(&FingerIndex, &ContactEdge)>,
    mut fingers: Query<(&FingerIndex, &ClosingDirection, &FingerTravel, &mut FingerWrench)>,
) {
    let mut sums = vec![Wrench::ZERO; shared.0.fingers.len()];
    let carried = fingers.iter().map(|(f, closing, travel, _)| (f.0 as usize, closing.0 * travel.0));
    let origins: BTreeMap<usize, DVec3> =
        carried.map(|(f, carried)| (f, shared.0.fingers[f].placement.origin + carried)).collect();
    for (finger, edges) in pool.contiguous_iter().expect(TABLES) {
        for (f, rows) in rows_by_pad(finger) {
            for edge in edges[rows].iter().filter(|edge| edge.force != DVec3::ZERO) {
                sums[f].force += edge.force;
                sums[f].torque += (edge.point - origins[&f]).cross(edge.force);
            }
        }
    }
    for (finger, _, _, mut wrench) in &mut fingers {
        wrench.0 = sums[finger.0 as usize];
    }
}

/// Measures the force of the mount of a finger with prescribed travel: the reaction of the bonded nodes along the
/// closing direction, without the gel's own weight.
pub fn measure_reaction(
    solver: Res<GraspSolver>,
    shared: Res<SharedModel>,
    mut fingers: Query<(&FingerIndex, &ClosingDirection, &mut FingerForce)>,
) {
    for (finger, closing, mut force) in &mut fingers {
        let i = finger.0 as usize;
        force.0 = (solver.mount_force(i) + solver.gel_weight(&shared.0, i)).dot(closing.0);
    }
}

/// Distributes the contact forces of the edges to the nodes; the sum is preserved.
pub fn measure_nodal_force(
    solver: Res<GraspSolver>,
    edges: Res<EdgeReadings>,
    mut nodes: Query<(&FingerIndex, &mut ContactForce)>,
) {
    let mut force: Vec<Vec<DVec3>> = solver.path.state.x.iter().map(|x| vec![DVec3::ZERO; x.len()]).collect();
    for (edges, force) in edges.0.iter().zip(&mut force) {
        for e in edges.iter().filter(|e| e.active()) {
            let (nodes, weights) = e.report.slices();
            nodes.iter().zip(weights).for_each(|(&n, &w)| force[n as usize] += e.force * w);
        }
    }
    for (finger, mut column) in nodes.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            column[rows].iter_mut().zip(&force[f]).for_each(|(own, force)| own.0 = *force);
        }
    }
}

/// Measures von Mises stress on nodes and tetrahedra.
pub fn measure_stress(
    solver: Res<GraspSolver>,
    mut nodes: Query<(&FingerIndex, &mut NodalStress)>,
    mut tets: Query<(&FingerIndex, &mut TetStress)>,
) {
    let pads = solver.path.state.x.par_iter().enumerate();
    let stress: Vec<_> = pads.map(|(i, x)| solver.body(i).stress(x)).collect();
    for (finger, mut column) in nodes.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            column[rows].iter_mut().zip(&stress[f].node).for_each(|(own, s)| own.0 = *s);
        }
    }
    for (finger, mut column) in tets.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            column[rows].iter_mut().zip(&stress[f].element).for_each(|(own, s)| own.0 = *s);
        }
    }
}

/// Measures the smallest det F. Ends the grasp with a fault, without recording the frame, if an element is inverted.
pub fn refuse_inversion(
    solver: Res<GraspSolver>,
    shared: Res<SharedModel>,
    load: Res<StepLoad>,
    mut report: ResMut<StepReport>,
    mut next: ResMut<NextPhase>,
) {
    let x = &solver.path.state.x;
    let smallest: Vec<f64> = x.par_iter().enumerate().map(|(i, x)| solver.body(i).min_det_f(x)).collect();
    report.min_det_f = smallest.into_iter().fold(f64::INFINITY, f64::min);
    if report.min_det_f <= 0.0 {
        report.reached = false;
        let x: Vec<_> = x.iter().map(|x| &x[..]).collect();
        next.request(Phase::Fault {
            reason: format!("at load {:.4e}: {}", load.level, inversion_message(&shared.0, &x)),
        });
    }
}

/// Reports the time spent in each stage, the iterations and the methods used.
pub fn report_timings(solver: Res<GraspSolver>, mut timings: ResMut<Timings>) {
    let p = &solver.path.newton.profile;
    let stages = [
        ("assembly", p.assembly),
        ("factorization", p.factorization),
        ("line_search", p.line_search),
        ("solve", p.solve),
    ];
    timings.stages.extend(stages);
    timings.iterations = p.iterations;
    timings.methods = MethodCounts { frozen: p.frozen, projected: p.projections, ..solver.path.methods };
}
