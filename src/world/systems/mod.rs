//! Systems common to all steppers (commands of the gripper, balance of the forces, the frame), and the schedule that
//! holds them.

pub mod apart;
pub mod audit;
pub mod contact_area;
pub mod control;
pub mod inversion;
pub mod measure;
mod record;
pub mod sense;
pub mod slip;
mod tactile;

use crate::schedule::{StepLabel, StepSet, computes_frame, reached};
use crate::systems::audit::audit_frame;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, SingleThreadedExecutor};
use model::Needs;

/// Returns the schedule without a stepper. Two systems that access the same data in an undefined order are an error.
pub fn schedule(needs: &Needs) -> Schedule {
    let mut schedule = Schedule::new(StepLabel);
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        hierarchy_detection: LogLevel::Error,
        ..ScheduleBuildSettings::new()
    });
    // Worlds run in parallel; within one, threads would only add overhead.
    schedule.set_executor(SingleThreadedExecutor::new());
    use StepSet::*;
    schedule.configure_sets((Control, Sense, Advance, Accept, Measure, Record).chain());
    register(&mut schedule, needs);
    schedule
}

/// Adds the shared systems to their sets.
pub fn register(schedule: &mut Schedule, needs: &Needs) {
    schedule.add_systems(
        (control::place_object, control::set_load.run_if(computes_frame)).chain().in_set(StepSet::Control),
    );
    if needs.gravity && needs.free_object {
        // The first requested phase applies.
        schedule.add_systems(control::refuse_weight.before(control::place_object).in_set(StepSet::Control));
    }
    schedule.add_systems(sense::close_to_contact.in_set(StepSet::Sense));
    if needs.pads_apart {
        schedule.add_systems(apart::reject_pad_overlap.run_if(reached).in_set(StepSet::Accept));
    }
    schedule.add_systems(measure::measure_balance.run_if(reached).in_set(StepSet::Measure));
    let refuse = measure::refuse_imbalance.run_if(reached).before(record::record_frame);
    schedule.add_systems(refuse.in_set(StepSet::Record));
    if needs.gap {
        schedule.add_systems(measure::measure_gap.run_if(reached).in_set(StepSet::Measure));
    }
    // In the last set, all measurements of the stepper are complete.
    if needs.contact_area {
        let area = contact_area::measure_contact_area.run_if(reached).before(record::record_frame);
        schedule.add_systems(area.in_set(StepSet::Record));
    }
    if needs.slip {
        schedule.add_systems(slip::measure_slip.run_if(reached).before(record::record_frame).in_set(StepSet::Record));
    }
    if needs.tactile {
        let see = tactile::record_tactile.run_if(reached).after(record::record_frame).before(record::advance_phase);
        schedule.add_systems(see.before(audit_frame).in_set(StepSet::Record));
    }
    if needs.audit {
        let judge = audit_frame.run_if(reached).after(record::record_frame).before(record::advance_phase);
        schedule.add_systems(judge.in_set(StepSet::Record));
    }
    schedule.add_systems((record::record_frame.run_if(reached), record::advance_phase).chain().in_set(StepSet::Record));
}
