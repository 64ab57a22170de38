//! Bodies derived from another one, with other positions, elimination order or elements.

use super::analysis::Analysis;
use super::pattern::{FIXED, Pattern};
use super::{Body, Elements};
use glam::DVec3;

impl Body {
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
