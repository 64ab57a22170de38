//! Graph network: trained on data sets, then used as one of the solver backends.
//!
//! ```text
//! Model + grasp -> linear_response/first_contact.rs -> features/ (on linear_response/pad_graph.rs) -> network/ -> infer/predict.rs
//!                  -> infer/grasp_output.rs -> backend/network.rs
//! a load        -> linear_response/rigid_equilibrium/ -> linear_response/projected_gradient.rs
//!                  -> features/loads.rs (linear_response/balance.rs) -> network/
//! PyTorch       -> infer/input_derivatives.rs (inputs with their derivatives) -> infer/inputs.rs (plain arrays)
//! data set      -> train/sample.rs: the same, and the results of FEM -> train/
//!                  -> network/card.rs (models/NAME), features/range.rs
//! ```

pub mod autodiff;
pub mod eval;
pub mod features;
pub mod infer;
pub mod linear_response;
pub mod matrix;
pub mod network;
pub mod train;

pub use network::shipped::DEFAULT_MODEL;
