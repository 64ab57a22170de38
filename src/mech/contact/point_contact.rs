//! Contact of the sample points of one pad with the object, as a term of the potential.

use super::edge::EdgeState;
use super::law::ContactLaw;
use super::pair::{friction_pair, normal_pair, project_weighted, slip};
use super::point_list::{DistanceBound, PointList, locate};
use super::pool::EdgePool;
use super::surface::ContactSurface;
use crate::body::Body;
use crate::potential::block::{BodyBlock, Pair};
use crate::potential::edge::EdgeReading;
use crate::potential::state::{BodyMotion, BodyView, IncrementStart};
use crate::potential::stencil::Stencil;
use crate::potential::term::{Assembly, BodyTerm};
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use base::scales::{EXACT_GAP_RADIUS, SUB_FACE_PENETRATION};
use geometry::shape::{ContactPoints, SignedDistance};
use glam::DVec3;
use std::sync::Arc;

/// Contact and friction between a pad and the object.
#[derive(Debug, Clone)]
pub struct PointContact {
    pool: EdgePool,
    near: PointList,
    /// Flags of the active points, current and last accepted: all vertices, and the sub-face samples where vertices
    /// carry contact or the object would penetrate.
    active: Vec<bool>,
    committed: Vec<bool>,
    surface: Arc<ContactSurface>,
    object: Arc<dyn SignedDistance>,
    /// State from which the increment starts.
    from: Option<IncrementStart>,
}

impl PointContact {
    /// Creates the term with all edges open.
    pub fn new(law: ContactLaw, surface: Arc<ContactSurface>, object: Arc<dyn SignedDistance>) -> Self {
        let active: Vec<bool> = (0..surface.points.len()).map(|i| i < surface.vertices).collect();
        let (pool, near) = (EdgePool::new(law, active.len()), PointList::new(active.len(), law.offset));
        Self { pool, near, committed: active.clone(), active, surface, object, from: None }
    }

    /// Edges of the points near the object, with the indices of the points; in ascending order once accepted.
    pub fn edges(&self) -> impl Iterator<Item = (usize, &EdgeState)> {
        self.pool.near()
    }

    /// Edge of point `i`.
    pub fn edge(&self, i: usize) -> &EdgeState {
        self.pool.edge(i)
    }

    /// Force on the pad at point `i`, N, hand frame.
    pub fn force(&self, i: usize) -> DVec3 {
        let e = self.pool.edge(i);
        (e.normal * e.pressure + e.traction) * self.surface.area[i]
    }
}

impl BodyTerm for PointContact {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        let mut energy = 0.0;
        for (i, seen) in self.near.points(view).filter(|(i, _)| self.active[*i]) {
            let (e, stencil, area, law) =
                (self.pool.edge(i), &self.surface.points[i], self.surface.area[i], self.law_of(i));
            let (world, q) = locate(stencil, view);
            if seen.bound(q) < law.offset
                && let Some(touch) = self.object.contact_points(q, law.offset, law.offset)
            {
                energy += area * touch.sum(|c| law.normal_energy(c.distance, e.scale));
            }
            if let Some(anchor) = e.sticking_point() {
                let s = slip(world - view.object.position - view.object.rotation * anchor, e.plane);
                energy += area * e.friction_energy(&law, s);
            }
        }
        energy
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock) {
        self.update_list(view);
        for k in 0..self.near.indices().len() {
            let (i, _) = self.near.get(k);
            if !self.active[i] {
                continue;
            }
            let stencil = self.surface.points[i];
            let area = self.surface.area[i];
            let (lag, touch) = self.update(k, &stencil, view, how.update_friction);
            block.rigid.lag += (area * lag).powi(2);
            let (law, e) = (&self.law_of(i), self.pool.edge(i));
            let (world, _) = locate(&stencil, view);
            for (c, weight) in touch.iter().flat_map(ContactPoints::points) {
                let e = e.at_contact_point(law, c.distance, view.object.rotation * c.normal);
                if e.pressure > 0.0 {
                    let curvature = view.object.rotation * c.curvature * view.object.rotation.transpose();
                    let pair =
                        normal_pair(law, &e, area * weight, world - view.object.position, &curvature, how.project);
                    block.add_pair(body, view, &stencil, &project_weighted(pair, weight, how.project));
                }
            }
            if let Some(anchor) = e.sticking_point() {
                let arm = view.object.rotation * anchor;
                let pair = friction_pair(law, e, area, world - view.object.position - arm, arm, how);
                block.add_pair(body, view, &stencil, &pair);
            }
        }
    }

    fn add_nonsymmetric_change(&self, body: &Body, view: &BodyView, motion: &BodyMotion, change: &mut BodyBlock) {
        for (i, _) in self.near.points(view) {
            let (e, stencil, area) = (self.pool.edge(i), &self.surface.points[i], self.surface.area[i]);
            if e.sticking_point().is_none() {
                continue;
            }
            let r = locate(stencil, view).0 - view.object.position;
            if let (Some(drag), Some(anchor)) =
                (self.pool.nonsymmetric_traction(i, &self.law_of(i), motion.relative(stencil, r)), e.anchor)
            {
                change.add_pair(body, view, stencil, &Pair::force(drag * -area, view.object.rotation * anchor));
            }
        }
    }

    fn clearance(&self, _: &Body, view: &BodyView) -> f64 {
        let nearest = |points: &mut dyn Iterator<Item = (usize, DistanceBound)>| {
            points.filter(|(i, _)| self.active[*i]).fold(f64::INFINITY, |nearest, (i, seen)| {
                let (_, q) = locate(&self.surface.points[i], view);
                // The bound of the last query excludes most of the others.
                if seen.bound(q) < nearest { nearest.min(self.object.distance(q)) } else { nearest }
            })
        };
        self.near.least(view, nearest) - 0.5 * self.pool.law.offset
    }

    fn begin_increment(&mut self, from: &IncrementStart) {
        self.from = Some(from.clone());
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        let (points, tangential) = (&self.surface.points, self.pool.law.tangential);
        self.pool.commit(|i, e| {
            let (_, q) = locate(&points[i], view);
            let drag = e.traction * (1.0 / tangential) - e.normal * e.gap;
            q + view.object.rotation.transpose() * drag
        });
        // Points under pressure and the sub-face samples around them are all listed.
        for i in self.near.indices().iter().copied().filter(|i| *i >= self.surface.vertices) {
            let pressed = |i: usize| self.pool.edge(i).pressure > 0.0;
            let patch = pressed(i) || self.surface.around(i).into_iter().any(pressed);
            if self.active[i] && !patch {
                self.pool.reset(i);
            }
            self.active[i] = patch;
        }
        self.committed.clone_from(&self.active);
    }

    fn rollback(&mut self) {
        self.pool.rollback();
        self.active.clone_from(&self.committed);
    }

    fn enforce_constraints(&mut self, _: &Body, view: &BodyView) -> bool {
        let (vertices, least) = (self.surface.vertices, self.pool.law.smallest_gap());
        let stiff = self.pool.stiffen_penetrating(|i| if i < vertices { least } else { 0.0 });
        self.activate_sub_face(view) && stiff
    }

    fn edge_count(&self) -> usize {
        self.active.len()
    }

    fn edge_readings(&self, view: &BodyView) -> Vec<EdgeReading> {
        let of = |(i, e): (usize, &EdgeState)| EdgeReading {
            number: i,
            state: *e,
            point: self.surface.points[i].position(view.x) + view.offset,
            force: self.force(i),
            touched: self.surface.points[i],
            report: self.surface.report[i],
        };
        self.pool.near().map(of).collect()
    }

    fn set_edges(&mut self, edges: &[(usize, EdgeState)]) {
        self.pool.set_accepted(edges);
        if edges.iter().any(|(i, _)| self.near.indices().binary_search(i).is_err()) {
            self.near.clear();
        }
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.active);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        self.near.clear();
        history.read_into(&mut self.active)?;
        self.committed.clone_from(&self.active);
        Ok(())
    }
}

impl PointContact {
    /// Indices of the active points.
    pub fn active_points(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.active.len()).filter(|i| self.active[*i])
    }

    /// Lists the points that can touch under `view`, if the current list may be incomplete.
    fn update_list(&mut self, view: &BodyView) {
        let Self { pool, active, surface, object, near, .. } = self;
        near.update(surface, &**object, view, |i| pool.has(i) || i >= surface.vertices && active[i]);
    }

    /// Activates the sub-face samples at which the object penetrates between vertices; returns true if there were none.
    fn activate_sub_face(&mut self, view: &BodyView) -> bool {
        let mut none = true;
        let offset = self.pool.law.offset;
        let (ahead, through) = (EXACT_GAP_RADIUS * offset, SUB_FACE_PENETRATION * offset);
        self.update_list(view);
        for k in 0..self.near.indices().len() {
            let (i, seen) = self.near.get(k);
            let (_, q) = locate(&self.surface.points[i], view);
            if self.active[i] || seen.bound(q) > -through {
                continue;
            }
            let distance = self.object.closest(q, ahead).map_or(ahead, |c| c.distance);
            self.near.store_bound(k, DistanceBound { at: q, bound: distance });
            if distance < -through {
                (self.active[i], none) = (true, false);
            }
        }
        none
    }

    /// Law of point `i`.
    pub fn law_of(&self, i: usize) -> ContactLaw {
        if i < self.surface.vertices { self.pool.law } else { self.pool.law.with_reduced_offset() }
    }

    /// Updates gap, pressure and friction of the edge of listed point `k`. Returns the lag of its friction, Pa, and its
    /// contact with the object, object axes.
    fn update(
        &mut self,
        k: usize,
        stencil: &Stencil,
        view: &BodyView,
        update_friction: bool,
    ) -> (f64, Option<ContactPoints>) {
        let (i, seen) = self.near.get(k);
        let law = self.law_of(i);
        let (world, q) = locate(stencil, view);
        let mut touch = None;
        // Far points are skipped without a query.
        if seen.bound(q) < law.offset {
            // The query reaches farther than needed, so that its bound makes the next queries unnecessary.
            let reach = EXACT_GAP_RADIUS * self.pool.law.offset;
            touch = self.object.contact_points(q, reach, law.offset);
            let bound = touch.as_ref().map_or(reach, |t| t.nearest.distance);
            self.near.store_bound(k, DistanceBound { at: q, bound });
        }
        let places = touch.iter().flat_map(ContactPoints::points);
        let places = places.map(|(c, weight)| (c.distance, view.object.rotation * c.normal, weight));
        let Some(lag) = self.pool.set_pressure(i, &law, update_friction, places) else { return (0.0, touch) };
        let e = *self.pool.edge(i);
        let mut anchor = e.anchor.unwrap_or(q);
        if self.pool.made_contact(i) {
            let start = self.from.as_ref().map_or(q, |from| from.in_object(stencil));
            // The start position, moved along the normal onto the surface in contact. The gap of a point that has left
            // again is infinite, hence the limit.
            let normal = view.object.rotation.transpose() * e.normal;
            anchor = start + normal * (normal.dot(q - start) - e.gap.min(law.offset));
            self.pool.record_contact(i, &law, anchor, || self.object.distance(start));
        }
        let behind = self.pool.update_traction(
            i,
            &law,
            update_friction,
            world - view.object.position - view.object.rotation * anchor,
        );
        (lag.hypot(behind), touch)
    }
}
