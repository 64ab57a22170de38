//! Neural network: gradients, training, inference, and the mechanics of pads with linear compliance.

#[path = "../fixtures/dataset_tiny.rs"]
mod dataset_tiny;
#[path = "../fixtures/gnn_made.rs"]
mod gnn_made;
#[path = "../fixtures/keep.rs"]
mod keep;
#[path = "../fixtures/skipped.rs"]
mod skipped;

mod gnn;
mod gnn_gradients;
mod gnn_infer;
mod gnn_mechanics;
mod gnn_pads;
mod gnn_release;
mod gnn_slopes;
mod gnn_torch;
mod gnn_train;
mod gnn_trust;
