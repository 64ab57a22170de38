//! Directed edges between nodes, and the maps that carry messages along them.

use crate::kernel::Sparse;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Edges, sorted by receiver.
#[derive(Debug, Clone)]
pub struct Edges {
    /// Pairs of sender and receiver.
    pub list: Vec<(u32, u32)>,
    /// Map that gives each edge the row of its sender.
    pub senders: Arc<Sparse>,
    /// Map that gives each edge the row of its receiver.
    pub receivers: Arc<Sparse>,
    /// Map from rows of edges to rows of receivers, summed and divided by a usual number of neighbours.
    pub gather: Arc<Sparse>,
}

impl Edges {
    /// Creates both directions of `pairs`, which join `nodes` nodes; sums are divided by `usual`.
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
