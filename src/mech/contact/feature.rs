//! Contact of the object's contact vertices (vertices and points of sharp edges) with the faces of a pad, as a term of
//! the potential. It keeps a needle or a knife edge from passing between the sample points of the pad.

use super::candidate_list::{CandidateList, GapBounds};
use super::edge::EdgeState;
use super::edge_edge::deepest;
use super::gap_hessian::bend;
use super::incident_faces::IncidentFace;
use super::law::ContactLaw;
use super::pair::{feature_pair, friction_pair, project_weighted, slip};
use super::pool::EdgePool;
use super::project::FaceBounds;
use super::site::Site;
use super::surface::ContactSurface;
use crate::body::Body;
use crate::potential::block::{BodyBlock, Pair};
use crate::potential::edge::EdgeReading;
use crate::potential::state::{BodyMotion, BodyView, Departure};
use crate::potential::stencil::Stencil;
use crate::potential::term::{Assembly, BodyTerm};
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use base::scales::VERTEX_MOVE_PENETRATION;
use geometry::shape::EdgeSection;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::cell::LazyCell;
use std::sync::Arc;

/// Contact vertex: a point of the object that must not pass between the sample points of a pad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feature {
    /// Position in the object frame, m.
    pub position: DVec3,
    /// Flag: the point is on a sharp edge or corner; else it is a vertex of a smooth surface.
    pub sharp: bool,
    /// Segment of an edge along which the vertex may move.
    pub along: Option<EdgeSection>,
}

impl Feature {
    /// Creates a contact vertex that moves to the deepest point of an edge segment in a pad, so that the edge does not
    /// penetrate between fixed samples. It starts at a third of the segment, where no fixed sample is.
    pub fn along(stretch: EdgeSection) -> Self {
        Self { position: stretch.point(1.0 / 3.0), sharp: false, along: Some(stretch) }
    }

    /// Law of this vertex. Vertices of a smooth surface have a reduced contact offset: the pad's own points carry that
    /// contact.
    fn law(&self, law: &ContactLaw) -> ContactLaw {
        if self.sharp { *law } else { law.with_reduced_offset() }
    }
}

/// Contact and friction between the object's contact vertices and a pad.
#[derive(Debug, Clone)]
pub struct FeatureContact {
    /// One edge per contact vertex. The anchor of an edge is the position of the vertex relative to its sticking point
    /// on the pad at which friction vanishes, hand axes.
    pool: EdgePool,
    surface: Arc<ContactSurface>,
    features: Arc<[Feature]>,
    /// Contact area per vertex, m2: that of a sample point of the pad, which it replaces.
    area: f64,
    sites: Vec<Site>,
    bounds: FaceBounds,
    candidates: CandidateList,
    accepted: Accepted,
    /// State from which the increment starts.
    from: Option<Departure>,
}

/// State that a rollback restores.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Accepted {
    sites: Vec<Site>,
    candidates: CandidateList,
}

impl FeatureContact {
    /// Creates the term with all edges open. `features` are points of the object.
    pub fn new(law: ContactLaw, surface: Arc<ContactSurface>, features: Arc<[Feature]>) -> Self {
        let pool = EdgePool::new(law, features.len());
        let sites: Vec<Site> = features.iter().map(|f| Site::new(f.position)).collect();
        let area = surface.spacing * surface.spacing;
        let (bounds, candidates) = (FaceBounds::new(law.offset), CandidateList::new(law.offset));
        let accepted = Accepted { sites: sites.clone(), candidates: candidates.clone() };
        Self { pool, surface, features, area, accepted, sites, bounds, candidates, from: None }
    }

    /// Edges of the contact vertices near the pad, with the indices of the vertices; in ascending order once accepted.
    pub fn edges(&self) -> impl Iterator<Item = (usize, &EdgeState)> {
        self.pool.near()
    }

    /// Edge of contact vertex `i`.
    pub fn edge(&self, i: usize) -> &EdgeState {
        self.pool.edge(i)
    }

    /// Law of contact vertex `i`.
    fn law_of(&self, i: usize) -> ContactLaw {
        self.features[i].law(&self.pool.law)
    }

    /// Contact vertices that may touch under `view`; None if the list is outdated.
    fn nearby(&self, view: &BodyView) -> Option<Vec<usize>> {
        self.candidates.nearby(view, self.pool.law.offset).map(<[usize]>::to_vec)
    }

    fn all(&self) -> Vec<usize> {
        (0..self.features.len()).collect()
    }

    /// Faces that contact vertex `i`, with the gap bounds `near`, presses on, for node positions `x`. If `stays` is
    /// set, the choice between one face and a whole fold is kept; else it may change.
    fn incident<'a>(
        &self,
        faces: impl FnOnce() -> &'a FaceBounds,
        i: usize,
        x: &[DVec3],
        near: GapBounds,
        stays: bool,
    ) -> Vec<IncidentFace> {
        let reach = self.law_of(i).offset;
        if !near.within(reach) {
            return Vec::new();
        }
        let faces = faces();
        faces.incident(&self.surface, x, near.at, reach, self.sites[i].last(stays), |closest_point| {
            near.with_valid_sign(closest_point, faces.offset)
        })
    }

    /// Sticking point of vertex `i` on the pad, and its displacement from the vertex plus `nonsymmetric_traction`, m.
    fn stretch(&self, i: usize, drag: Option<DVec3>, view: &BodyView) -> Option<(&Stencil, DVec3)> {
        let (drag, site) = (drag?, &self.sites[i]);
        let stick = &site.touch.as_ref()?.stick;
        let arm = view.object.rotation * site.position;
        Some((stick, stick.position(view.x) + view.offset - view.object.position - arm + drag))
    }
}

impl BodyTerm for FeatureContact {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        // Computed only if a vertex is near.
        let bounds = LazyCell::new(|| {
            let mut bounds = FaceBounds::new(self.pool.law.offset);
            bounds.update(&self.surface, view.x);
            bounds
        });
        let moved = self.candidates.moved(view.x);
        let mut energy = 0.0;
        for i in self.nearby(view).unwrap_or_else(|| self.all()) {
            let e = self.pool.edge(i);
            let near = self.candidates.bounds(i, self.sites[i].place(view), moved);
            let law = self.law_of(i);
            let incident = self.incident(|| &*bounds, i, view.x, near, true);
            let energies = incident
                .iter()
                .map(|(closest_point, weight, _)| weight * law.normal_energy(closest_point.gap, e.scale));
            energy += self.area * energies.sum::<f64>();
            if let Some((_, stretch)) = self.stretch(i, e.sticking_point(), view) {
                let s = slip(stretch, e.plane);
                energy += self.area * e.friction_energy(&self.pool.law, s);
            }
        }
        energy
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock) {
        self.bounds.update(&self.surface, view.x);
        let sites = &self.sites;
        self.candidates.update(&self.surface, view.x, &self.bounds, sites.len(), |i| sites[i].place(view));
        let moved = self.candidates.moved(view.x);
        let nearby = self.nearby(view);
        let anew = nearby.is_none();
        let mut seen = vec![GapBounds::UNKNOWN; self.features.len()];
        for i in nearby.unwrap_or_else(|| self.all()) {
            let near = self.candidates.bounds(i, self.sites[i].place(view), moved);
            block.rigid.lag += (self.area * self.update(i, view, near, how.follow)).powi(2);
            let (e, law) = (*self.pool.edge(i), self.law_of(i));
            seen[i] = near.narrowed(self.sites[i].incident(), law.offset);
            let arm = view.object.rotation * self.sites[i].position;
            for (closest_point, weight, curvature) in self.sites[i].incident() {
                let e = e.on(&law, closest_point.gap, -closest_point.normal);
                if e.pressure > 0.0 {
                    let pair = feature_pair(&law, &e, weight * self.area, arm, curvature, how.project);
                    let place = self.surface.faces[closest_point.face].stencil(closest_point.l);
                    block.add_pair(body, view, &place, &project_weighted(pair, *weight, how.project));
                    let force = e.pressure * weight * self.area;
                    let bent = (how.sharp && block.wants_hessian() && !how.project)
                        .then(|| bend(&self.surface.faces[closest_point.face], view.x, closest_point, force))
                        .flatten();
                    if let Some(form) = bent {
                        block.add_form(body, view, &form, arm);
                    }
                }
            }
            if let Some((stick, s)) = self.stretch(i, e.sticking_point(), view) {
                let pair = friction_pair(&self.pool.law, &e, self.area, s, arm, how);
                block.add_pair(body, view, stick, &pair);
            }
        }
        self.candidates.remember(view.x, seen);
        if anew {
            let radius = self.sites.iter().map(|site| site.position.length()).fold(0.0, f64::max);
            let pool = &self.pool;
            self.candidates.list(view, radius, |i| pool.edge(i).sticking_point().is_some());
        }
    }

    fn couple(&self, body: &Body, view: &BodyView, motion: &BodyMotion, change: &mut BodyBlock) {
        for (i, site) in self.sites.iter().enumerate().filter(|(i, _)| self.pool.edge(*i).sticking_point().is_some()) {
            let (r, Some(touch)) = (view.object.rotation * site.position, &site.touch) else { continue };
            if let Some(drag) = self.pool.nonsymmetric_traction(i, &self.law_of(i), motion.relative(&touch.now, r)) {
                change.add_pair(body, view, &touch.stick, &Pair::force(drag * -self.area, r));
            }
        }
    }

    fn depart(&mut self, from: &Departure) {
        self.from = Some(from.clone());
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        let (sites, tangential) = (&mut self.sites, self.pool.law.tangential);
        self.pool.commit(|i, e| {
            let place = sites[i].place(view);
            sites[i].touch.as_mut().map_or(DVec3::ZERO, |touch| {
                touch.stick = touch.now;
                place - touch.now.position(view.x) - e.traction * (1.0 / tangential)
            })
        });
        for (i, site) in self.sites.iter_mut().enumerate() {
            site.moves = 0;
            if self.pool.edge(i).anchor.is_none() && site.incident().is_empty() {
                site.touch = None;
            }
        }
        self.accepted.sites.clone_from(&self.sites);
        self.accepted.candidates.clone_from(&self.candidates);
    }

    fn rollback(&mut self) {
        self.pool.rollback();
        self.sites.clone_from(&self.accepted.sites);
        self.candidates.clone_from(&self.accepted.candidates);
    }

    fn satisfied(&mut self, _: &Body, view: &BodyView) -> bool {
        let (features, law) = (&self.features, self.pool.law);
        let stiff = self.pool.satisfied(|i| features[i].law(&law).least());
        self.follow(view) && stiff
    }

    fn edge_count(&self) -> usize {
        self.features.len()
    }

    fn edge_readings(&self, view: &BodyView) -> Vec<EdgeReading> {
        let of = |(i, e): (usize, &EdgeState)| {
            let touch = self.sites[i].touch.as_ref();
            let (touched, report) = touch.map_or((Stencil::NONE, Stencil::NONE), |touch| (touch.now, touch.report));
            let force = e.normal * (e.pressure * self.area) + e.traction * self.area;
            EdgeReading { number: i, state: *e, point: touched.position(view.x) + view.offset, force, touched, report }
        };
        self.pool.near().map(of).collect()
    }

    fn set_edges(&mut self, edges: &[(usize, EdgeState)]) {
        self.pool.set(edges);
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.accepted);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        self.accepted = history.read()?;
        self.rollback();
        Ok(())
    }
}

/// Maximum number of moves of a contact vertex along its edge in one increment.
const MOVES: u32 = 2;

impl FeatureContact {
    /// Moves contact vertices along their edges to their deepest points in the pad; returns true if none had to move.
    fn follow(&mut self, view: &BodyView) -> bool {
        let moved = self.candidates.moved(view.x);
        let mut stay = true;
        for (i, (feature, site)) in self.features.iter().zip(&mut self.sites).enumerate() {
            let Some(stretch) = &feature.along else { continue };
            // The pad would penetrate where a vertex under pressure leaves: such a vertex moves only for a larger
            // depth.
            let most = self.pool.law.offset * VERTEX_MOVE_PENETRATION[usize::from(self.pool.edge(i).pressure > 0.0)];
            let near = self.candidates.bounds(i, site.place(view), moved).within(stretch.length());
            let free = near && site.moves < MOVES;
            let Some(deepest) = free.then(|| deepest(&self.bounds, &self.surface, view, stretch, most)).flatten()
            else {
                continue;
            };
            site.position = deepest;
            site.touch = None;
            site.moves += 1;
            self.pool.renew(i);
            self.candidates.add(i, deepest.length());
            stay = false;
        }
        stay
    }

    /// Updates gap, pressure and friction of edge `i`, whose vertex has the gap bounds `near`; returns the lag of its
    /// friction, Pa.
    fn update(&mut self, i: usize, view: &BodyView, near: GapBounds, follow: bool) -> f64 {
        let law = self.law_of(i);
        let incident = self.incident(|| &self.bounds, i, view.x, near, false);
        // The object's outward normal at the contact is the pad's inward one.
        let places =
            incident.iter().map(|(closest_point, weight, _)| (closest_point.gap, -closest_point.normal, *weight));
        let lag = self.pool.press(i, &law, follow, places);
        let site = &mut self.sites[i];
        site.press(incident, &self.surface);
        let Some(touch) = &mut site.touch else { return 0.0 };
        let Some(lag) = lag else {
            if let Some(accepted) = &self.accepted.sites[i].touch {
                touch.stick = accepted.stick;
            }
            return 0.0;
        };
        if self.pool.made_contact(i) {
            touch.stick = touch.now;
            let normal = self.pool.edge(i).normal;
            let away = near.at - touch.now.position(view.x);
            let start = self.from.as_ref().map_or(away, |from| from.of_object(site.position) - from.point(&touch.now));
            // The normal component is that of the current state.
            let drag = start + normal * normal.dot(away - start);
            // `normal` is the outward normal of the object.
            self.pool.touch(i, &law, drag, || -normal.dot(start));
        }
        let stretch = self.stretch(i, self.pool.edge(i).anchor, view).map(|(_, stretch)| stretch);
        lag.hypot(stretch.map_or(0.0, |stretch| self.pool.update_traction(i, &law, follow, stretch)))
    }
}
