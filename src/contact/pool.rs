//! What the contact edges of a pad share, whichever side is sampled: law, history, friction.

use super::edge::ContactEdge;
use super::law::Law;
use super::pair::slip;
use glam::DVec3;

/// The edges of one contact term, as they are and as last accepted.
#[derive(Debug, Clone)]
pub(super) struct EdgePool {
    /// Current edges.
    pub edges: Vec<ContactEdge>,
    /// The law of every edge, softened while contact is being established.
    pub law: Law,
    given: Law,
    committed: Vec<ContactEdge>,
    /// Part of the way that lagged friction goes per iteration.
    pub damping: f64,
    /// Friction limit that counts as none, in the unit of the pressure.
    pub negligible: f64,
}

/// Friction limit that counts as none on a pad, Pa.
const NO_LIMIT: f64 = 1.0;

impl EdgePool {
    /// `count` open edges.
    pub fn new(law: Law, count: usize) -> Self {
        let edges = vec![ContactEdge::default(); count];
        Self { committed: edges.clone(), edges, law, given: law, damping: 1.0, negligible: NO_LIMIT }
    }

    /// Smallest gap, m; `+inf` if nothing is near.
    pub fn min_gap(&self) -> f64 {
        self.edges.iter().map(|e| e.gap).fold(f64::INFINITY, f64::min)
    }

    /// Softens the law by `factor`; 1 gives it back.
    pub fn soften(&mut self, factor: f64) {
        self.law = self.given.softened(factor);
    }

    /// Accepts the edges as they are. Open edges forget where they stuck; of slipping ones `dragged` says where they stick
    /// now, so that the spring carries just the limit.
    pub fn commit(&mut self, mut dragged: impl FnMut(usize, &ContactEdge) -> DVec3) {
        for (i, e) in self.edges.iter_mut().enumerate() {
            if e.pressure <= 0.0 {
                e.anchor = None;
            } else if e.slips {
                e.anchor = Some(dragged(i, e));
            }
        }
        self.committed.clone_from(&self.edges);
    }

    /// Opens edge `i`, whose point is another from now on.
    pub fn renew(&mut self, i: usize) {
        self.edges[i] = ContactEdge::default();
        self.committed[i] = ContactEdge::default();
    }

    /// Back to the edges last accepted.
    pub fn rollback(&mut self) {
        self.edges.clone_from(&self.committed);
    }

    /// Stiffens the edges that come closer than they may, `least(i)` (m); true if there were none.
    pub fn satisfied(&mut self, least: impl Fn(usize) -> f64) -> bool {
        let mut held = true;
        for (i, e) in self.edges.iter_mut().enumerate() {
            if e.gap < least(i) {
                e.scale *= 4.0;
                held = false;
            }
        }
        held
    }

    /// Sets gap, normal and pressure of edge `i` under `law` from the places that it touches (gap, m, normal and weight of each, the
    /// nearest first) and relaxes its friction limit. Some if friction acts: how far the limit lags, Pa; [`EdgePool::rub`] must follow.
    pub fn press(&mut self, i: usize, law: &Law, places: impl Iterator<Item = (f64, DVec3, f64)>) -> Option<f64> {
        let e = &mut self.edges[i];
        e.press(law, places);
        e.traction = DVec3::ZERO;
        e.slips = false;
        if law.friction == 0.0 {
            return None;
        }
        let lag = e.relax_limit(law.friction, self.damping);
        if e.pressure <= 0.0 && (e.limit <= self.negligible || e.anchor.is_none()) {
            // A point that touched only on the way to this iterate has not stuck anywhere yet.
            e.limit = 0.0;
            e.anchor = self.committed[i].anchor;
            return None;
        }
        Some(lag)
    }

    /// How the force of slipping edge `i` on the pad changes per area when its points move by `u` (m) against each other: the
    /// limit follows the pressure, Pa.
    pub fn drag(&self, i: usize, law: &Law, u: DVec3) -> Option<DVec3> {
        let e = &self.edges[i];
        let stiffness = law.pressure(e.gap, e.scale).1;
        (e.slips && stiffness > 0.0)
            .then(|| e.traction.normalize_or_zero() * (-law.friction * stiffness * e.normal.dot(u)))
    }

    /// Sets the traction of edge `i`, whose points have moved apart by `s` (m) since they stuck.
    pub fn rub(&mut self, i: usize, s: DVec3) {
        let e = &mut self.edges[i];
        (e.traction, e.slips) = self.law.traction(slip(s, e.plane), e.limit);
    }
}
