//! Graphs of the pads that a program uses, each created once.

use super::compliance_cache::ComplianceCache;
use super::pad_graph::{Layout, PadGraph, mesh_hash};
use base::error::Result;
use base::interrupt;
use model::part::FingerModel;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Graphs of the pads used so far.
#[derive(Debug)]
pub struct PadGraphs {
    layout: Layout,
    graphs: Mutex<Vec<Arc<PadGraph>>>,
}

impl PadGraphs {
    /// Creates the empty list for a network of this layout.
    pub fn new(layout: Layout) -> Self {
        Self { layout, graphs: Mutex::default() }
    }

    /// Returns the graphs of the pads of `fingers`; equal pads share one. Linear responses of new pads are read from
    /// the user's cache, or computed in parallel.
    ///
    /// # Errors
    /// Fails as [`PadGraph::with_cache`] does, and if it is interrupted.
    pub fn get_or_build(&self, fingers: &[&FingerModel]) -> Result<Vec<Arc<PadGraph>>> {
        let named: Vec<(String, f64)> =
            fingers.iter().map(|finger| (mesh_hash(&finger.topology), finger.body.material.moduli().poisson)).collect();
        let mut graphs = self.graphs.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |graphs: &[Arc<PadGraph>], (hash, poisson): &(String, f64)| {
            graphs.iter().find(|graph| graph.matches(hash, *poisson)).cloned()
        };
        let mut new: Vec<usize> = Vec::new();
        for (i, name) in named.iter().enumerate() {
            if find(&graphs, name).is_none() && !new.iter().any(|k| named[*k] == *name) {
                new.push(i);
            }
        }
        let cache = ComplianceCache::of_user();
        let made = new.par_iter().map(|i| {
            interrupt::check()?;
            Ok(Arc::new(PadGraph::with_cache(fingers[*i], self.layout, cache.as_ref())?))
        });
        graphs.extend(made.collect::<Result<Vec<_>>>()?);
        Ok(named.iter().filter_map(|name| find(&graphs, name)).collect())
    }
}
