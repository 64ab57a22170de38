//! Output of the network as plain arrays.

use crate::autodiff::tensor::values;
use crate::network::NetworkOutput;

/// [`NetworkOutput`] as plain arrays; stress is empty if not required.
#[derive(Debug)]
pub struct OutputArrays {
    /// Displacement (levels * pads * nodes, 3).
    pub displacement: Vec<f32>,
    /// Stress (levels * pads * nodes).
    pub stress: Vec<f32>,
    /// Contact force (levels * pads * face nodes, 3).
    pub contact: Vec<f32>,
    /// Travel (levels * pads).
    pub travel: Vec<f32>,
    /// Motion (levels * pads, 6).
    pub motion: Vec<f32>,
}

impl From<NetworkOutput> for OutputArrays {
    fn from(out: NetworkOutput) -> Self {
        Self {
            displacement: values(&out.displacement),
            stress: values(&out.stress),
            contact: values(&out.contact),
            travel: values(&out.travel),
            motion: values(&out.motion),
        }
    }
}
