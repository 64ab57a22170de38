//! Contact of one pad's surface points with the object, as a term of the potential.

use super::edge::ContactEdge;
use super::law::Law;
use super::pair::{friction_pair, normal_pair, slip, weighed};
use super::pool::EdgePool;
use super::surface::ContactSurface;
use crate::fem::body::Body;
use crate::fem::state::{Motion, View};
use crate::fem::term::{Block, BodyTerm, Pair, Stencil};
use crate::shape::{SignedDistance, Touch};
use glam::DVec3;
use std::any::Any;
use std::sync::Arc;

/// Contact and friction between a pad and the object.
#[derive(Debug, Clone)]
pub struct Contact {
    /// One edge per surface point.
    pool: EdgePool,
    surface: Arc<ContactSurface>,
    object: Arc<dyn SignedDistance>,
}

impl Contact {
    /// All edges open.
    pub fn new(law: Law, surface: Arc<ContactSurface>, object: Arc<dyn SignedDistance>) -> Self {
        Self { pool: EdgePool::new(law, surface.points.len()), surface, object }
    }

    /// Current edges, one per surface point.
    pub fn edges(&self) -> &[ContactEdge] {
        &self.pool.edges
    }

    /// The sample points of the pad.
    pub fn surface(&self) -> &ContactSurface {
        &self.surface
    }

    /// Smallest gap of the edges that were evaluated exactly in the last assembly, m.
    pub fn min_gap(&self) -> f64 {
        self.pool.min_gap()
    }

    /// Force on the pad at point `i`, N, hand frame.
    pub fn force(&self, i: usize) -> DVec3 {
        let e = &self.pool.edges[i];
        (e.normal * e.pressure + e.traction) * self.surface.area[i]
    }
}

/// Distance within which the exact gap is looked up, m; farther points are skipped until they may have come this close.
const LOOK_AHEAD: f64 = 5e-4;

/// Position of a point in the hand frame and in the object's frame.
fn locate(stencil: &Stencil, view: &View) -> (DVec3, DVec3) {
    let world = stencil.position(view.x) + view.offset;
    (world, view.rotation.transpose() * (world - view.position))
}

impl BodyTerm for Contact {
    fn energy(&self, _: &Body, view: &View) -> f64 {
        let (law, mut energy) = (&self.pool.law, 0.0);
        for ((e, stencil), area) in self.pool.edges.iter().zip(self.surface.points.iter()).zip(&self.surface.area) {
            let (world, q) = locate(stencil, view);
            if e.bound - q.distance(e.query) < law.offset
                && let Some(touch) = self.object.touch(q, law.offset, law.offset)
            {
                energy += area * touch.sum(|c| law.normal_energy(c.distance, e.scale));
            }
            if let Some(anchor) = e.sticks() {
                let s = slip(world - view.position - view.rotation * anchor, e.plane);
                energy += area * law.friction_energy(s, e.limit);
            }
        }
        energy
    }

    fn assemble(&mut self, body: &Body, view: &View, project: bool, block: &mut Block) {
        for i in 0..self.surface.points.len() {
            let stencil = self.surface.points[i];
            let area = self.surface.area[i];
            let (lag, touch) = self.update(i, &stencil, view);
            block.lag += (area * lag).powi(2);
            let (law, e) = (&self.pool.law, &self.pool.edges[i]);
            let (world, _) = locate(&stencil, view);
            for (c, weight) in touch.iter().flat_map(Touch::places) {
                let e = e.on(law, c.distance, view.rotation * c.normal);
                if e.pressure > 0.0 {
                    let curvature = view.rotation * c.curvature * view.rotation.transpose();
                    let pair = normal_pair(law, &e, area * weight, world - view.position, &curvature, project);
                    block.add_pair(body, view, &stencil, &weighed(pair, weight, project));
                }
            }
            if let Some(anchor) = e.sticks() {
                let arm = view.rotation * anchor;
                let pair = friction_pair(law, e, area, world - view.position - arm, arm, project);
                block.add_pair(body, view, &stencil, &pair);
            }
        }
    }

    fn couple(&self, body: &Body, view: &View, motion: &Motion, change: &mut Block) {
        for (i, (stencil, area)) in self.surface.points.iter().zip(&self.surface.area).enumerate() {
            if !self.pool.edges[i].slips {
                continue;
            }
            let r = locate(stencil, view).0 - view.position;
            if let (Some(drag), Some(anchor)) =
                (self.pool.drag(i, &self.pool.law, motion.relative(stencil, r)), self.pool.edges[i].anchor)
            {
                change.add_pair(body, view, stencil, &Pair::force(drag * -area, view.rotation * anchor));
            }
        }
    }

    fn clearance(&self, _: &Body, view: &View) -> f64 {
        let mut nearest = f64::INFINITY;
        for (e, stencil) in self.pool.edges.iter().zip(self.surface.points.iter()) {
            let (_, q) = locate(stencil, view);
            // The bound of the last query spares most of the others.
            if e.bound - q.distance(e.query) < nearest {
                nearest = nearest.min(self.object.distance(q));
            }
        }
        nearest - 0.5 * self.pool.law.offset
    }

    fn commit(&mut self, _: &Body, view: &View) {
        let (points, tangential) = (&self.surface.points, self.pool.law.tangential);
        self.pool.commit(|i, e| {
            let (_, q) = locate(&points[i], view);
            let drag = e.traction * (1.0 / tangential) - e.normal * e.gap;
            q + view.rotation.transpose() * drag
        });
    }

    fn rollback(&mut self) {
        self.pool.rollback();
    }

    fn satisfied(&mut self, _: &Body, _: &View) -> bool {
        let offset = self.pool.law.offset;
        self.pool.satisfied(|_| offset)
    }

    fn damp(&mut self, damping: f64) {
        self.pool.damping = damping;
    }

    fn soften(&mut self, factor: f64) {
        self.pool.soften(factor);
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

impl Contact {
    /// Refreshes gap, pressure and friction of edge `i`; returns how far its friction limit lags, Pa, and where it touches the object,
    /// object axes.
    fn update(&mut self, i: usize, stencil: &Stencil, view: &View) -> (f64, Option<Touch>) {
        let law = self.pool.law;
        let e = &mut self.pool.edges[i];
        let (world, q) = locate(stencil, view);
        let mut touch = None;
        // The distance changes no faster than the point moves: far points are skipped without a query.
        if e.bound - q.distance(e.query) < law.offset {
            // Look farther than needed, so that the bound spares the next queries.
            let reach = LOOK_AHEAD.max(law.offset);
            touch = self.object.touch(q, reach, law.offset);
            (e.bound, e.query) = (touch.as_ref().map_or(reach, |t| t.nearest.distance), q);
        }
        let places = touch.iter().flat_map(Touch::places);
        let places = places.map(|(c, weight)| (c.distance, view.rotation * c.normal, weight));
        let Some(lag) = self.pool.press(i, &law, places) else { return (0.0, touch) };
        let e = &mut self.pool.edges[i];
        let anchor = *e.anchor.get_or_insert(q - view.rotation.transpose() * e.normal * e.gap);
        self.pool.rub(i, world - view.position - view.rotation * anchor);
        (lag, touch)
    }
}
