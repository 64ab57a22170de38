//! Code of a grasp: the result of its only pass of message passing.

/// Result of the pass over a grasp: the load-independent part of the decoder's first layer.
#[derive(Debug, Clone, Default)]
pub struct LatentCode {
    /// Part for nodes (pads * face nodes, padded decoder).
    pub node: Vec<f32>,
    /// Part for pads (pads, padded decoder).
    pub pad: Vec<f32>,
}
