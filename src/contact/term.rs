//! Contact of one pad's surface points with the object, as a term of the potential.

use super::edge::ContactEdge;
use super::law::Law;
use super::pair::{friction_pair, normal_pair, slip};
use super::surface::ContactSurface;
use crate::fem::body::Body;
use crate::fem::state::View;
use crate::fem::term::{Block, BodyTerm, Stencil};
use crate::shape::SignedDistance;
use glam::{DMat3, DVec3};
use std::any::Any;
use std::sync::Arc;

/// Contact and friction between a pad and the object.
#[derive(Debug, Clone)]
pub struct Contact {
    /// The law of every edge, softened while contact is being established.
    law: Law,
    given: Law,
    /// Current edges, one per surface point.
    pub edges: Vec<ContactEdge>,
    surface: Arc<ContactSurface>,
    object: Arc<dyn SignedDistance>,
    committed: Vec<ContactEdge>,
    damping: f64,
}

impl Contact {
    /// All edges open.
    pub fn new(law: Law, surface: Arc<ContactSurface>, object: Arc<dyn SignedDistance>) -> Self {
        let edges = vec![ContactEdge::default(); surface.points.len()];
        Self { law, given: law, committed: edges.clone(), edges, surface, object, damping: 1.0 }
    }

    /// The sample points of the pad.
    pub fn surface(&self) -> &ContactSurface {
        &self.surface
    }

    /// Smallest gap of the edges that were evaluated exactly in the last assembly, m.
    pub fn min_gap(&self) -> f64 {
        self.edges.iter().map(|e| e.gap).fold(f64::INFINITY, f64::min)
    }

    /// Force on the pad at point `i`, N, hand frame.
    pub fn force(&self, i: usize) -> DVec3 {
        let e = &self.edges[i];
        (e.normal * e.pressure + e.traction) * self.surface.area[i]
    }
}

/// Smallest gap of an accepted state, as a fraction of the offset.
pub(super) const MIN_GAP: f64 = 0.02;
/// Friction limit that counts as none, Pa.
pub(super) const NO_LIMIT: f64 = 1.0;
/// Distance within which the exact gap is looked up, m; farther points are skipped until they may have come this close.
const LOOK_AHEAD: f64 = 5e-4;

/// Position of a point in the hand frame and in the object's frame.
fn locate(stencil: &Stencil, view: &View) -> (DVec3, DVec3) {
    let world = stencil.position(view.x) + view.offset;
    (world, view.rotation.transpose() * (world - view.position))
}

impl BodyTerm for Contact {
    fn energy(&self, _: &Body, view: &View) -> f64 {
        let mut energy = 0.0;
        for ((e, stencil), area) in self.edges.iter().zip(&self.surface.points).zip(&self.surface.area) {
            let (world, q) = locate(stencil, view);
            if e.bound - q.distance(e.query) < self.law.offset
                && let Some(c) = self.object.closest(q, self.law.offset)
            {
                energy += area * self.law.normal_energy(c.distance, e.scale);
            }
            if let (Some(anchor), true) = (e.anchor, e.limit > 0.0) {
                let s = slip(world - view.position - view.rotation * anchor, e.plane);
                energy += area * self.law.friction_energy(s, e.limit);
            }
        }
        energy
    }

    fn assemble(&mut self, body: &Body, view: &View, project: bool, block: &mut Block) {
        for i in 0..self.edges.len() {
            let stencil = self.surface.points[i];
            let area = self.surface.area[i];
            block.lag += (area * self.update(i, &stencil, view)).powi(2);
            let e = &self.edges[i];
            let (world, q) = locate(&stencil, view);
            if e.pressure > 0.0 {
                let curvature = match project {
                    true => DMat3::ZERO,
                    false => self.object.closest(q, self.law.offset).map_or(DMat3::ZERO, |c| c.curvature),
                };
                let curvature = view.rotation * curvature * view.rotation.transpose();
                let pair = normal_pair(&self.law, e, area, world - view.position, &curvature, project);
                block.add_pair(body, view, &stencil, &pair);
            }
            if let (Some(anchor), true) = (e.anchor, e.limit > 0.0) {
                let arm = view.rotation * anchor;
                let pair = friction_pair(&self.law, e, area, world - view.position - arm, arm, project);
                block.add_pair(body, view, &stencil, &pair);
            }
        }
    }

    fn clearance(&self, _: &Body, view: &View) -> f64 {
        let mut nearest = f64::INFINITY;
        for (e, stencil) in self.edges.iter().zip(&self.surface.points) {
            let (_, q) = locate(stencil, view);
            // The bound of the last query spares most of the others.
            if e.bound - q.distance(e.query) < nearest {
                nearest = nearest.min(self.object.distance(q));
            }
        }
        nearest - 0.5 * self.law.offset
    }

    fn commit(&mut self, _: &Body, view: &View) {
        for (e, stencil) in self.edges.iter_mut().zip(&self.surface.points) {
            if e.pressure <= 0.0 {
                e.anchor = None;
            } else if e.slips {
                // The sticking point is dragged along, so that the spring carries just the limit.
                let (_, q) = locate(stencil, view);
                let drag = e.traction * (1.0 / self.law.tangential) - e.normal * e.gap;
                e.anchor = Some(q + view.rotation.transpose() * drag);
            }
        }
        self.committed.clone_from(&self.edges);
    }

    fn rollback(&mut self) {
        self.edges.clone_from(&self.committed);
    }

    fn satisfied(&mut self, _: &Body, _: &View) -> bool {
        let mut held = true;
        for e in self.edges.iter_mut().filter(|e| e.gap < MIN_GAP * self.law.offset) {
            e.scale *= 4.0;
            held = false;
        }
        held
    }

    fn damp(&mut self, damping: f64) {
        self.damping = damping;
    }

    fn soften(&mut self, factor: f64) {
        self.law = self.given.softened(factor);
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

impl Contact {
    /// Refreshes gap, pressure and friction of edge `i`; returns how far its friction limit lags, Pa.
    fn update(&mut self, i: usize, stencil: &Stencil, view: &View) -> f64 {
        let law = self.law;
        let e = &mut self.edges[i];
        let (world, q) = locate(stencil, view);
        // The distance changes no faster than the point moves: far points are skipped without a query.
        if e.bound - q.distance(e.query) >= law.offset {
            e.gap = f64::INFINITY;
        } else {
            // Look farther than needed, so that the bound spares the next queries.
            let reach = LOOK_AHEAD.max(law.offset);
            match self.object.closest(q, reach) {
                Some(c) => {
                    (e.gap, e.bound, e.query) = (c.distance, c.distance, q);
                    e.normal = view.rotation * c.normal;
                }
                None => (e.gap, e.bound, e.query) = (f64::INFINITY, reach, q),
            }
        }
        e.pressure = law.pressure(e.gap, e.scale).0;
        e.traction = DVec3::ZERO;
        e.slips = false;
        if law.friction == 0.0 {
            return 0.0;
        }
        let lag = e.relax_limit(law.friction, self.damping);
        if e.pressure <= 0.0 && (e.limit < NO_LIMIT || e.anchor.is_none()) {
            // A point that touched only on the way to this iterate has not stuck anywhere yet.
            e.limit = 0.0;
            e.anchor = self.committed[i].anchor;
            return 0.0;
        }
        let anchor = *e.anchor.get_or_insert(q - view.rotation.transpose() * e.normal * e.gap);
        let s = slip(world - view.position - view.rotation * anchor, e.plane);
        (e.traction, e.slips) = law.traction(s, e.limit);
        lag
    }
}
