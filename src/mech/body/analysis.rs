//! Symbolic analysis for the factorisation of a body's stiffness. It is computed on first request; the network does not
//! need it.

use super::cholesky::Symbolic;
use super::elements::Elements;
use super::pattern::{Pattern, Slot};
use base::error::{Error, Result};
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

    /// Stiffness pattern and elimination order of `elements`, whose `fixed` nodes have no unknowns.
    #[inline]
    pub(super) fn pattern(&self, elements: &Elements, fixed: &[bool]) -> &Pattern {
        self.pattern.get_or_init(|| Pattern::new(elements.lists().into_iter(), fixed))
    }

    /// Symbolic Cholesky analysis of the same.
    pub(super) fn symbolic(&self, elements: &Elements, fixed: &[bool]) -> Result<&Arc<Symbolic>> {
        let made = self.symbolic.get_or_init(|| Symbolic::new(self.pattern(elements, fixed)).map(Arc::new));
        made.as_ref().map_err(|message| Error::Solver(message.clone()))
    }

    /// Slots of the node pairs of each element, each unordered pair once.
    pub(super) fn slots(&self, elements: &Elements, fixed: &[bool]) -> &[Slot] {
        self.slots.get_or_init(|| {
            let pattern = self.pattern(elements, fixed);
            let pairs = |nodes: &[u32]| -> Vec<Slot> {
                let of = |(i, a): (usize, &u32)| nodes[i..].iter().map(|b| pattern.slot(*a, *b)).collect::<Vec<_>>();
                nodes.iter().enumerate().flat_map(of).collect()
            };
            elements.lists().into_iter().flat_map(pairs).collect()
        })
    }
}
