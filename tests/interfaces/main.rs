//! Interfaces: the command line, files of runs and data sets, environments, reports.

#[path = "../fixtures/dataset_tiny.rs"]
mod dataset_tiny;
#[path = "../fixtures/env_made.rs"]
mod env_made;
#[path = "../fixtures/gnn_made.rs"]
mod gnn_made;
#[path = "../fixtures/keep.rs"]
mod keep;
#[path = "../fixtures/skipped.rs"]
mod skipped;
#[path = "../fixtures/synthetic.rs"]
mod synthetic;

mod bench_cli;
mod dataset;
mod dataset_resume;
mod dataset_sampling;
mod dataset_universe;
mod env_contract;
mod env_hand_over;
mod env_task;
mod examples;
mod fit;
mod integrity;
mod pads_that_differ;
mod record_run;
mod record_vtu;
mod render_pads;
mod report;
mod run_cli;
mod tactile;
#[cfg(unix)]
mod view;
