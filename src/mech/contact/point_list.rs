//! Points of a pad that can touch the object, and bounds of their distances to it.

use super::nearby::NearbyList;
use super::surface::ContactSurface;
use crate::potential::state::BodyView;
use crate::potential::stencil::Stencil;
use base::scales::{EXACT_GAP_RADIUS, POINT_LIST_RADIUS};
use geometry::shape::SignedDistance;
use glam::DVec3;
use std::sync::Arc;

/// Distance of a point to the object at its last query. It stays valid when states are accepted or rolled back.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistanceBound {
    /// Position of the point at the query, object frame, m.
    pub at: DVec3,
    /// Lower bound of the distance there, m.
    pub bound: f64,
}

impl DistanceBound {
    /// Lower bound of the distance of the point, now at `q`, m: it changes no faster than the point moves.
    #[inline(always)]
    pub fn bound(&self, q: DVec3) -> f64 {
        self.bound - q.distance(self.at)
    }
}

/// Position of the point of the pad at `stencil`, in the hand frame and in the object's frame.
#[inline(always)]
pub(crate) fn locate(stencil: &Stencil, view: &BodyView) -> (DVec3, DVec3) {
    let world = stencil.position(view.x) + view.offset;
    (world, view.object.rotation.transpose() * (world - view.object.position))
}

/// Points that are near the object, have an edge or are active sub-face samples, and the sub-face samples next to them.
#[derive(Debug, Clone)]
pub(crate) struct PointList {
    /// Distances of all points when the list was last built, or before.
    all: Arc<Vec<DistanceBound>>,
    nearby: Arc<NearbyList>,
    /// Distances of the listed points at their last queries.
    listed: Vec<DistanceBound>,
    /// Contact offset, m.
    offset: f64,
}

impl PointList {
    /// Creates the list of `count` points with unknown distances; contact has this `offset` (m).
    pub fn new(count: usize, offset: f64) -> Self {
        let all = Arc::new(vec![DistanceBound { at: DVec3::ZERO, bound: f64::NEG_INFINITY }; count]);
        Self { all, nearby: Arc::default(), listed: Vec::new(), offset }
    }

    /// Discards the list.
    pub fn clear(&mut self) {
        (self.nearby, self.listed) = (Arc::default(), Vec::new());
    }

    /// Lower bound of the distance of the points that are not listed, under `view`, m; `-inf` if it is unknown.
    fn unlisted_bound(&self, view: &BodyView) -> f64 {
        POINT_LIST_RADIUS * self.offset - self.nearby.moved(view)
    }

    /// Returns true if no point that is not listed can touch under `view`.
    fn is_valid(&self, view: &BodyView) -> bool {
        self.unlisted_bound(view) >= self.offset
    }

    /// Returns the smallest distance that `nearest` finds among the points passed to it: the listed points, or all
    /// points where others may be nearer.
    pub fn least(
        &self,
        view: &BodyView,
        nearest: impl Fn(&mut dyn Iterator<Item = (usize, DistanceBound)>) -> f64,
    ) -> f64 {
        let listed = nearest(&mut (0..self.listed.len()).map(|k| self.get(k)));
        let found = listed <= self.unlisted_bound(view);
        if found { listed } else { nearest(&mut self.all.iter().copied().enumerate()) }
    }

    /// Indices of the listed points, ascending.
    pub fn indices(&self) -> &[usize] {
        &self.nearby.list
    }

    /// Index of listed point `k`, and the bound of its distance.
    pub fn get(&self, k: usize) -> (usize, DistanceBound) {
        (self.nearby.list[k], self.listed[k])
    }

    /// Stores the distance of listed point `k`.
    pub fn store_bound(&mut self, k: usize, seen: DistanceBound) {
        self.listed[k] = seen;
    }

    /// Points that can touch under `view`, ascending: those listed, or all if pad or object have moved too far since.
    pub fn points(&self, view: &BodyView) -> impl Iterator<Item = (usize, DistanceBound)> + '_ {
        let known = self.is_valid(view);
        let count = if known { self.listed.len() } else { self.all.len() };
        (0..count).map(move |k| if known { self.get(k) } else { (k, self.all[k]) })
    }

    /// Rebuilds the list of points of `surface` if pad and object have moved too far: those near the `object`, those
    /// that `matter` at any distance, and the sub-face samples next to them.
    pub fn update(
        &mut self,
        surface: &ContactSurface,
        object: &dyn SignedDistance,
        view: &BodyView,
        matter: impl Fn(usize) -> bool,
    ) {
        if self.is_valid(view) {
            return;
        }
        let (reach, far) = (POINT_LIST_RADIUS * self.offset, EXACT_GAP_RADIUS * self.offset);
        let all = Arc::make_mut(&mut self.all);
        let mut near = vec![false; all.len()];
        let mut radius = 0.0_f64;
        for (i, stencil) in surface.points.iter().enumerate() {
            let (_, q) = locate(stencil, view);
            radius = radius.max(q.length());
            if all[i].bound(q) < reach {
                all[i] = DistanceBound { at: q, bound: object.closest(q, far).map_or(far, |c| c.distance) };
            }
            let beside = |i: usize| i >= surface.vertices && surface.around(i).into_iter().any(|vertex| near[vertex]);
            near[i] = all[i].bound(q) < reach || matter(i) || beside(i);
        }
        let list: Vec<usize> = (0..near.len()).filter(|i| near[*i]).collect();
        self.listed = list.iter().map(|i| all[*i]).collect();
        self.nearby = Arc::new(NearbyList::new(list, view, radius));
    }
}
