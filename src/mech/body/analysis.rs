//! Symbolic analysis for the factorisation of a body's stiffness. It is computed on first request; the network does not
//! need it.

use super::cholesky::Symbolic;
use super::pattern::{FIXED, Pattern, Slot};
use super::{Body, Elements};
use base::error::{Error, Result};
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// Analysis of one body, shared by all bodies that differ only in the positions of their nodes.
#[derive(Debug, Default)]
pub(crate) struct Analysis {
    pattern: OnceLock<Pattern>,
    /// Slots of the blocks of every element in the pattern.
    slots: OnceLock<Vec<Slot>>,
    symbolic: OnceLock<std::result::Result<Arc<Symbolic>, String>>,
}

impl Analysis {
    /// Creates an analysis with an elimination order of its own.
    pub(crate) fn of(pattern: Pattern) -> Arc<Self> {
        Arc::new(Self { pattern: pattern.into(), ..Self::default() })
    }
}

impl Body {
    /// Stiffness pattern and elimination order.
    pub fn pattern(&self) -> &Pattern {
        self.analysis.pattern.get_or_init(|| Pattern::new(self.elements.lists().into_iter(), &self.fixed))
    }

    /// Symbolic Cholesky analysis.
    ///
    /// # Errors
    /// Fails if the factorisation cannot be analysed (too large for memory).
    pub fn symbolic(&self) -> Result<&Arc<Symbolic>> {
        let made = self.analysis.symbolic.get_or_init(|| Symbolic::new(self.pattern()).map(Arc::new));
        made.as_ref().map_err(|message| Error::Solver(message.clone()))
    }

    /// Number of unknowns: three per free node.
    pub fn unknowns(&self) -> usize {
        3 * self.fixed.iter().filter(|fixed| !**fixed).count()
    }

    /// Slots of the node pairs of each element, each unordered pair once.
    pub(crate) fn slots(&self) -> &[Slot] {
        self.analysis.slots.get_or_init(|| {
            let pattern = self.pattern();
            let pairs = |nodes: &[u32]| -> Vec<Slot> {
                let of = |(i, a): (usize, &u32)| nodes[i..].iter().map(|b| pattern.slot(*a, *b)).collect::<Vec<_>>();
                nodes.iter().enumerate().flat_map(of).collect()
            };
            self.elements.lists().into_iter().flat_map(pairs).collect()
        })
    }

    /// Returns this body with its nodes at the reference positions `rest`; both share one analysis.
    pub fn placed(&self, rest: Vec<DVec3>) -> Self {
        let (elements, fixed) = (self.elements.clone(), self.fixed.clone());
        let mut body = Self::new(rest, elements, fixed, self.material.clone(), self.mean_dilatation);
        body.analysis = self.analysis.clone();
        body
    }

    /// Returns this body with the unknowns of the nodes `last` eliminated last, in their order.
    pub fn eliminating_last(&self, last: &[u32]) -> Self {
        let position = self.pattern().position_with_last(last);
        let pattern = Pattern::ordered(self.elements.lists().into_iter(), position);
        let mut body = self.placed(self.rest.clone());
        body.analysis = Analysis::of(pattern);
        body
    }

    /// Returns this body without elements, with all nodes but `kept` fixed and the kept nodes fully coupled: it holds
    /// the stiffness condensed to these nodes. Unknowns are in the order of `kept`.
    pub fn condensed(&self, kept: &[u32]) -> Self {
        let mut position = vec![FIXED; self.rest.len()];
        kept.iter().enumerate().for_each(|(k, &i)| position[i as usize] = k as u32);
        let fixed = position.iter().map(|p| *p == FIXED).collect();
        let pattern = Pattern::ordered(std::iter::once(kept), position);
        let nothing = Elements::Linear(Vec::new());
        let mut body = Self::new(self.rest.clone(), nothing, fixed, self.material.clone(), false);
        body.analysis = Analysis::of(pattern);
        body
    }
}
