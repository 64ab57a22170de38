//! Quantities whose errors are compared.

use record::error_norm::FrameDistance;
use std::borrow::Cow;

/// Name of a quantity or a stage; owned if read from `bench.json`.
pub type QuantityName = Cow<'static, str>;

/// Name of a quantity, and the function that reads it.
pub(crate) type ComparedQuantity = (&'static str, fn(&FrameDistance) -> f64);

/// Quantities that are compared; a name without unit is relative.
pub const QUANTITIES: [ComparedQuantity; 6] = [
    ("displacement", |e| e.displacement),
    ("stress", |e| e.stress),
    ("force", |e| e.force),
    ("travel", |e| e.travel),
    ("displacement_max_m", |e| e.displacement_max_m),
    ("stress_max_pa", |e| e.stress_max_pa),
];
