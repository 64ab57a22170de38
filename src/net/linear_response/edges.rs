//! Directed edges between nodes, and the sparse maps of messages along them.

use crate::matrix::Sparse;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Edges, sorted by receiver.
#[derive(Debug, Clone)]
pub struct Edges {
    /// Pairs of sender and receiver.
    pub list: Vec<(u32, u32)>,
    /// Map from node rows to edge rows: the row of the sender.
    pub senders: Arc<Sparse>,
    /// Map from node rows to edge rows: the row of the receiver.
    pub receivers: Arc<Sparse>,
    /// Map from edge rows to node rows: the sum over the edges of a receiver, divided by a typical number of
    /// neighbours.
    pub gather: Arc<Sparse>,
}

impl Edges {
    /// Creates the edges in both directions for `pairs` of `nodes` nodes; sums are divided by `usual`.
    pub fn new(pairs: impl IntoIterator<Item = (u32, u32)>, nodes: usize, usual: f32) -> Self {
        // As (receiver, sender), so that they are sorted by receiver.
        let both: BTreeSet<(u32, u32)> = pairs.into_iter().flat_map(|(a, b)| [(a, b), (b, a)]).collect();
        let list: Vec<(u32, u32)> = both.into_iter().map(|(receiver, sender)| (sender, receiver)).collect();
        let mut sum = vec![Vec::new(); nodes];
        list.iter().enumerate().for_each(|(e, (_, receiver))| sum[*receiver as usize].push((e as u32, 1.0 / usual)));
        Self {
            senders: Sparse::gather(list.iter().map(|e| e.0 as usize), nodes),
            receivers: Sparse::gather(list.iter().map(|e| e.1 as usize), nodes),
            gather: Sparse::new(&sum, list.len()),
            list,
        }
    }
}
