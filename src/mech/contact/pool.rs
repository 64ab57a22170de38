//! State shared by the contact edges of a pad, whichever side is sampled: law, history, friction.

use super::edge::EdgeState;
use super::law::ContactLaw;
use super::pair::slip;
use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use base::scales::NEGLIGIBLE_FRICTION;
use glam::DVec3;

/// Edges of one contact term, current and last accepted. Only points near a surface have an edge, a few hundred out of
/// thousands; the others are open.
#[derive(Debug, Clone)]
pub(crate) struct EdgePool {
    /// Edges that are not open, with the indices of their points; in ascending order once accepted.
    near: Vec<(usize, EdgeState)>,
    /// Index in `near` of the edge of each point.
    slot: Vec<u32>,
    /// Edges as last accepted, in the order of their points.
    committed: Vec<(usize, EdgeState)>,
    /// Law of every edge.
    pub law: ContactLaw,
    /// Friction limit that counts as zero, in the unit of the pressure.
    pub negligible: f64,
}

/// Slot of a point without an edge.
const NO_EDGE: u32 = u32::MAX;

impl EdgePool {
    /// Creates `count` open edges.
    pub fn new(law: ContactLaw, count: usize) -> Self {
        let slot = vec![NO_EDGE; count];
        Self {
            near: Vec::new(),
            slot,
            committed: Vec::new(),
            law,
            negligible: NEGLIGIBLE_FRICTION * law.stiffness * law.offset,
        }
    }

    /// Edge of point `i`.
    #[inline(always)]
    pub fn edge(&self, i: usize) -> &EdgeState {
        self.near.get(self.slot[i] as usize).map_or(&EdgeState::OPEN, |(_, e)| e)
    }

    /// Returns true if point `i` has an edge.
    pub fn has(&self, i: usize) -> bool {
        self.slot[i] != NO_EDGE
    }

    /// Mutable edge of point `i`.
    pub fn edge_mut(&mut self, i: usize) -> &mut EdgeState {
        if self.slot[i] == NO_EDGE {
            self.slot[i] = self.near.len() as u32;
            self.near.push((i, EdgeState::OPEN));
        }
        &mut self.near[self.slot[i] as usize].1
    }

    /// Edges that are not open, with the indices of their points; in ascending order once accepted.
    pub fn near(&self) -> impl Iterator<Item = (usize, &EdgeState)> {
        self.near.iter().map(|(i, e)| (*i, e))
    }

    /// Smallest gap, m; `+inf` if no surface is near.
    pub fn min_gap(&self) -> f64 {
        self.near().map(|(_, e)| e.gap).fold(f64::INFINITY, f64::min)
    }

    /// Accepts the current edges. Edges without pressure lose their sticking point. For edges that slip or made contact
    /// within the increment, `dragged` returns the new sticking point, at which the full spring carries the same
    /// traction.
    pub fn commit(&mut self, mut dragged: impl FnMut(usize, &EdgeState) -> DVec3) {
        for (i, e) in &mut self.near {
            if e.pressure <= 0.0 {
                e.anchor = None;
            } else if e.slips || e.active_fraction < 1.0 {
                e.anchor = Some(dragged(*i, e));
            }
            (e.initial_gap, e.active_fraction) = (None, 1.0);
        }
        self.sort();
        self.committed.clone_from(&self.near);
    }

    /// Drops the open edges and sorts the others by their points.
    fn sort(&mut self) {
        let slot = &mut self.slot;
        self.near.iter().for_each(|(i, _)| slot[*i] = NO_EDGE);
        self.near.retain(|(_, e)| !e.is_open());
        self.near.sort_unstable_by_key(|(i, _)| *i);
        self.near.iter().zip(0..).for_each(|((i, _), k)| slot[*i] = k);
    }

    /// Opens edge `i`, whose point has been replaced by another one.
    pub fn reset(&mut self, i: usize) {
        if self.slot[i] != NO_EDGE {
            *self.edge_mut(i) = EdgeState::OPEN;
        }
        self.committed.retain(|(k, _)| *k != i);
    }

    /// Restores accepted edges.
    pub fn set_accepted(&mut self, edges: &[(usize, EdgeState)]) {
        self.committed = edges.to_vec();
        self.rollback();
    }

    /// Writes the edges last accepted.
    pub fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.committed);
    }

    /// Reads the edges last accepted.
    ///
    /// # Errors
    /// Fails if the history does not match these edges.
    pub fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        let edges: Vec<(usize, EdgeState)> = history.read()?;
        if edges.iter().any(|(i, _)| *i >= self.slot.len()) {
            return Err(Error::Start("the saved state has contact edges that the scene does not have".into()));
        }
        self.set_accepted(&edges);
        Ok(())
    }

    /// Restores the edges last accepted.
    pub fn rollback(&mut self) {
        let slot = &mut self.slot;
        self.near.iter().for_each(|(i, _)| slot[*i] = NO_EDGE);
        self.near.clone_from(&self.committed);
        self.near.iter().zip(0..).for_each(|((i, _), k)| slot[*i] = k);
    }

    /// Stiffens the edges with gaps below `least(i)` (m); returns true if there were none.
    pub fn stiffen_penetrating(&mut self, least: impl Fn(usize) -> f64) -> bool {
        let mut satisfied = true;
        for (i, e) in &mut self.near {
            if e.gap < least(*i) {
                e.scale *= 4.0;
                satisfied = false;
            }
        }
        satisfied
    }

    /// Sets gap, normal and pressure of edge `i` under `law` from its contact points (gap, m, normal and weight of
    /// each, the nearest first) and, if it is to `update_friction`, its friction limit. Returns the lag of the limit,
    /// Pa, if friction acts; [`EdgePool::update_traction`] must be called next.
    pub fn set_pressure(
        &mut self,
        i: usize,
        law: &ContactLaw,
        update_friction: bool,
        places: impl Iterator<Item = (f64, DVec3, f64)>,
    ) -> Option<f64> {
        let mut places = places.peekable();
        if places.peek().is_none() && self.slot[i] == NO_EDGE {
            return None;
        }
        let negligible = self.negligible;
        let e = self.edge_mut(i);
        e.set_pressure(law, places);
        e.traction = DVec3::ZERO;
        e.slips = false;
        if law.friction == 0.0 {
            return None;
        }
        let lag = e.set_limit(law.friction, update_friction);
        if e.pressure <= 0.0 && (e.limit <= negligible || e.anchor.is_none()) {
            // A point that was in contact only at an earlier iterate has not stuck yet: its accepted anchor is
            // restored.
            e.limit = 0.0;
            let known = self.committed.binary_search_by_key(&i, |(k, _)| *k);
            let anchor = known.ok().and_then(|k| self.committed[k].1.anchor);
            let e = self.edge_mut(i);
            (e.anchor, e.initial_gap, e.active_fraction) = (anchor, None, 1.0);
            return None;
        }
        Some(lag)
    }

    /// Returns true if edge `i` made contact within the increment; [`EdgePool::record_contact`] must be called next.
    pub fn made_contact(&self, i: usize) -> bool {
        let e = self.edge(i);
        e.anchor.is_none() || e.initial_gap.is_some()
    }

    /// Records that edge `i` made contact within the increment, at whose start its point was at `start`, at the gap
    /// `clear()` (m).
    pub fn record_contact(&mut self, i: usize, law: &ContactLaw, start: DVec3, clear: impl FnOnce() -> f64) {
        let e = self.edge_mut(i);
        e.anchor = Some(start);
        if e.initial_gap.is_none() {
            e.initial_gap = Some(clear());
            e.active_fraction = e.current_active_fraction(law.offset);
        }
    }

    /// Change of the friction traction of edge `i` on the pad, Pa, when its points move by `u` (m) relative to each
    /// other, which its potential does not include. Where the edge slips, the limit follows the pressure; where it made
    /// contact within the increment, the active fraction grows with the depth.
    pub fn nonsymmetric_traction(&self, i: usize, law: &ContactLaw, u: DVec3) -> Option<DVec3> {
        let e = self.edge(i);
        let stiffness = law.pressure(e.gap, e.scale).1;
        let rate = match e.slips {
            true => e.traction.normalize_or_zero() * (law.friction * stiffness),
            false => e.traction * ((1.0 - e.active_fraction) / (law.offset - e.gap)),
        };
        (stiffness > 0.0 && rate != DVec3::ZERO).then(|| rate * -e.normal.dot(u))
    }

    /// Sets the traction of edge `i`, whose points have moved apart by `s` (m) since they stuck or since the start of
    /// the increment; returns the lag of the traction due to the active fraction, Pa.
    pub fn update_traction(&mut self, i: usize, law: &ContactLaw, update_friction: bool, s: DVec3) -> f64 {
        let e = self.edge_mut(i);
        let s = slip(s, e.plane);
        let missing = e.current_active_fraction(law.offset) - e.active_fraction;
        e.active_fraction += if update_friction { missing } else { 0.0 };
        (e.traction, e.slips) = law.with_active_fraction(e.active_fraction).traction(s, e.limit);
        if update_friction { 0.0 } else { (law.tangential * s.length() * missing.abs()).min(e.limit) }
    }
}
