//! What it takes to factorise the stiffness of a body, made when first asked for: the network never does.

use super::cholesky::Symbolic;
use super::pattern::{FIXED, Pattern, Slot};
use super::{Body, Elements};
use crate::error::{Error, Result};
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// Of one body, and of all that are alike but for where they lie.
#[derive(Debug, Default)]
pub(crate) struct Analysis {
    pattern: OnceLock<Pattern>,
    /// Where the blocks of every element lie in the pattern.
    slots: OnceLock<Vec<Slot>>,
    symbolic: OnceLock<std::result::Result<Arc<Symbolic>, String>>,
}

impl Analysis {
    /// With an order of elimination of its own.
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
    /// When the factorisation cannot be analysed (too large for memory).
    pub fn symbolic(&self) -> Result<&Arc<Symbolic>> {
        let made = self.analysis.symbolic.get_or_init(|| Symbolic::new(self.pattern()).map(Arc::new));
        made.as_ref().map_err(|message| Error::Solver(message.clone()))
    }

    /// Number of unknowns: three per free node.
    pub fn unknowns(&self) -> usize {
        3 * self.fixed.iter().filter(|fixed| !**fixed).count()
    }

    /// Per element, where the blocks of its node pairs lie, each unordered pair once.
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

    /// This body with its nodes at `rest`, and one analysis with it.
    pub fn placed(&self, rest: Vec<DVec3>) -> Self {
        let (elements, fixed) = (self.elements.clone(), self.fixed.clone());
        let mut body = Self::new(rest, elements, fixed, self.material.clone(), self.mean_dilatation);
        body.analysis = self.analysis.clone();
        body
    }

    /// This body with the unknowns of the nodes `last` eliminated last, in their order.
    pub fn eliminating_last(&self, last: &[u32]) -> Self {
        let position = self.pattern().position_with_last(last);
        let pattern = Pattern::ordered(self.elements.lists().into_iter(), position);
        let mut body = self.placed(self.rest.clone());
        body.analysis = Analysis::of(pattern);
        body
    }

    /// The nodes of this body without its elements, all but `kept` fixed and those coupled with each other: the host of what
    /// is left when the others are eliminated. Unknowns are in the order of `kept`.
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
