//! Contact of the object's contact vertices (vertices and points of sharp edges) with the faces of a pad, as a term of
//! the potential. It keeps a needle or a knife edge from passing between the sample points of the pad.

use super::candidate_list::{CandidateList, GapBounds};
use super::edge::EdgeState;
use super::edge_edge::deepest;
use super::face_bounds::FaceBounds;
use super::gap_hessian::curvature_form;
use super::incident_faces::IncidentFace;
use super::law::ContactLaw;
use super::pair::{friction_pair, project_weighted, slip, vertex_pair};
use super::pool::EdgePool;
use super::surface::ContactSurface;
use super::vertex_state::VertexState;
use crate::body::Body;
use crate::potential::block::{BodyBlock, Pair};
use crate::potential::edge::EdgeReading;
use crate::potential::state::{BodyMotion, BodyView, IncrementStart};
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
pub struct ContactVertex {
    /// Position in the object frame, m.
    pub position: DVec3,
    /// Flag: the point is on a sharp edge or corner; else it is a vertex of a smooth surface.
    pub sharp: bool,
    /// Segment of an edge along which the vertex may move.
    pub segment: Option<EdgeSection>,
}

impl ContactVertex {
    /// Creates a contact vertex that moves to the deepest point of an edge segment in a pad, so that the edge does not
    /// penetrate between fixed samples. It starts at a third of the segment, where no fixed sample is.
    pub fn on_segment(segment: EdgeSection) -> Self {
        Self { position: segment.point(1.0 / 3.0), sharp: false, segment: Some(segment) }
    }

    /// Law of this vertex. Vertices of a smooth surface have a reduced contact offset: the pad's own points carry that
    /// contact.
    fn law(&self, law: &ContactLaw) -> ContactLaw {
        if self.sharp { *law } else { law.with_reduced_offset() }
    }
}

/// Contact and friction between the object's contact vertices and a pad.
#[derive(Debug, Clone)]
pub struct VertexContact {
    /// One edge per contact vertex. The anchor of an edge is the position of the vertex relative to its sticking point
    /// on the pad at which friction vanishes, hand axes.
    pool: EdgePool,
    surface: Arc<ContactSurface>,
    vertices: Arc<[ContactVertex]>,
    /// Contact area per vertex, m2: that of a sample point of the pad, which it replaces.
    area: f64,
    sites: Vec<VertexState>,
    bounds: FaceBounds,
    candidates: CandidateList,
    accepted: AcceptedVertices,
    /// State from which the increment starts.
    from: Option<IncrementStart>,
}

/// State that a rollback restores.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct AcceptedVertices {
    sites: Vec<VertexState>,
    candidates: CandidateList,
}

impl VertexContact {
    /// Creates the term with all edges open. `vertices` are points of the object.
    pub fn new(law: ContactLaw, surface: Arc<ContactSurface>, vertices: Arc<[ContactVertex]>) -> Self {
        let pool = EdgePool::new(law, vertices.len());
        let sites: Vec<VertexState> = vertices.iter().map(|f| VertexState::new(f.position)).collect();
        let area = surface.spacing * surface.spacing;
        let (bounds, candidates) = (FaceBounds::new(law.offset), CandidateList::new(law.offset));
        let accepted = AcceptedVertices { sites: sites.clone(), candidates: candidates.clone() };
        Self { pool, surface, vertices, area, accepted, sites, bounds, candidates, from: None }
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
        self.vertices[i].law(&self.pool.law)
    }

    /// Contact vertices that may touch under `view`; None if the list is outdated.
    fn nearby(&self, view: &BodyView) -> Option<Vec<usize>> {
        self.candidates.nearby(view, self.pool.law.offset).map(<[usize]>::to_vec)
    }

    fn all(&self) -> Vec<usize> {
        (0..self.vertices.len()).collect()
    }

    /// Faces that contact vertex `i`, with the gap bounds `near`, presses on, for node positions `x`. If `keeps_faces`
    /// is set, the choice between one face and a whole fold is kept; else it may change.
    fn incident<'a>(
        &self,
        faces: impl FnOnce() -> &'a FaceBounds,
        i: usize,
        x: &[DVec3],
        near: GapBounds,
        keeps_faces: bool,
    ) -> Vec<IncidentFace> {
        let reach = self.law_of(i).offset;
        if !near.within(reach) {
            return Vec::new();
        }
        let faces = faces();
        faces.incident(&self.surface, x, near.at, reach, self.sites[i].last(keeps_faces), |closest_point| {
            near.with_valid_sign(closest_point, faces.offset)
        })
    }

    /// Sticking point of vertex `i` on the pad, and its displacement from the vertex plus `drag`, m.
    fn sticking_displacement(&self, i: usize, drag: Option<DVec3>, view: &BodyView) -> Option<(&Stencil, DVec3)> {
        let (drag, site) = (drag?, &self.sites[i]);
        let stick = &site.contact.as_ref()?.sticking_point;
        let arm = view.object.rotation * site.position;
        Some((stick, stick.position(view.x) + view.offset - view.object.position - arm + drag))
    }
}

impl BodyTerm for VertexContact {
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
            let near = self.candidates.bounds(i, self.sites[i].relative_position(view), moved);
            let law = self.law_of(i);
            let incident = self.incident(|| &*bounds, i, view.x, near, true);
            let energies = incident
                .iter()
                .map(|(closest_point, weight, _)| weight * law.normal_energy(closest_point.gap, e.scale));
            energy += self.area * energies.sum::<f64>();
            if let Some((_, displacement)) = self.sticking_displacement(i, e.sticking_point(), view) {
                let s = slip(displacement, e.plane);
                energy += self.area * e.friction_energy(&self.pool.law, s);
            }
        }
        energy
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock) {
        self.bounds.update(&self.surface, view.x);
        let sites = &self.sites;
        self.candidates.update(&self.surface, view.x, &self.bounds, sites.len(), |i| sites[i].relative_position(view));
        let moved = self.candidates.moved(view.x);
        let nearby = self.nearby(view);
        let anew = nearby.is_none();
        let mut seen = vec![GapBounds::UNKNOWN; self.vertices.len()];
        for i in nearby.unwrap_or_else(|| self.all()) {
            let near = self.candidates.bounds(i, self.sites[i].relative_position(view), moved);
            block.rigid.lag += (self.area * self.update(i, view, near, how.update_friction)).powi(2);
            let (e, law) = (*self.pool.edge(i), self.law_of(i));
            seen[i] = near.narrowed(self.sites[i].incident(), law.offset);
            let arm = view.object.rotation * self.sites[i].position;
            for (closest_point, weight, curvature) in self.sites[i].incident() {
                let e = e.at_contact_point(&law, closest_point.gap, -closest_point.normal);
                if e.pressure > 0.0 {
                    let pair = vertex_pair(&law, &e, weight * self.area, arm, curvature, how.project);
                    let place = self.surface.faces[closest_point.face].stencil(closest_point.l);
                    block.add_pair(body, view, &place, &project_weighted(pair, *weight, how.project));
                    let force = e.pressure * weight * self.area;
                    let bent = (how.complete_hessian && block.wants_hessian() && !how.project)
                        .then(|| curvature_form(&self.surface.faces[closest_point.face], view.x, closest_point, force))
                        .flatten();
                    if let Some(form) = bent {
                        block.add_form(body, view, &form, arm);
                    }
                }
            }
            if let Some((stick, s)) = self.sticking_displacement(i, e.sticking_point(), view) {
                let pair = friction_pair(&self.pool.law, &e, self.area, s, arm, how);
                block.add_pair(body, view, stick, &pair);
            }
        }
        self.candidates.store_assembly(view.x, seen);
        if anew {
            let radius = self.sites.iter().map(|site| site.position.length()).fold(0.0, f64::max);
            let pool = &self.pool;
            self.candidates.list(view, radius, |i| pool.edge(i).sticking_point().is_some());
        }
    }

    fn add_nonsymmetric_change(&self, body: &Body, view: &BodyView, motion: &BodyMotion, change: &mut BodyBlock) {
        for (i, site) in self.sites.iter().enumerate().filter(|(i, _)| self.pool.edge(*i).sticking_point().is_some()) {
            let (r, Some(touch)) = (view.object.rotation * site.position, &site.contact) else { continue };
            if let Some(drag) = self.pool.nonsymmetric_traction(i, &self.law_of(i), motion.relative(&touch.point, r)) {
                change.add_pair(body, view, &touch.sticking_point, &Pair::force(drag * -self.area, r));
            }
        }
    }

    fn begin_increment(&mut self, from: &IncrementStart) {
        self.from = Some(from.clone());
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        let (sites, tangential) = (&mut self.sites, self.pool.law.tangential);
        self.pool.commit(|i, e| {
            let place = sites[i].relative_position(view);
            sites[i].contact.as_mut().map_or(DVec3::ZERO, |touch| {
                touch.sticking_point = touch.point;
                place - touch.point.position(view.x) - e.traction * (1.0 / tangential)
            })
        });
        for (i, site) in self.sites.iter_mut().enumerate() {
            site.moves = 0;
            if self.pool.edge(i).anchor.is_none() && site.incident().is_empty() {
                site.contact = None;
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

    fn enforce_constraints(&mut self, _: &Body, view: &BodyView) -> bool {
        let (vertices, law) = (&self.vertices, self.pool.law);
        let stiff = self.pool.stiffen_penetrating(|i| vertices[i].law(&law).smallest_gap());
        self.move_to_deepest_points(view) && stiff
    }

    fn edge_count(&self) -> usize {
        self.vertices.len()
    }

    fn edge_readings(&self, view: &BodyView) -> Vec<EdgeReading> {
        let of = |(i, e): (usize, &EdgeState)| {
            let touch = self.sites[i].contact.as_ref();
            let (touched, report) = touch.map_or((Stencil::NONE, Stencil::NONE), |touch| (touch.point, touch.report));
            let force = e.normal * (e.pressure * self.area) + e.traction * self.area;
            EdgeReading { number: i, state: *e, point: touched.position(view.x) + view.offset, force, touched, report }
        };
        self.pool.near().map(of).collect()
    }

    fn set_edges(&mut self, edges: &[(usize, EdgeState)]) {
        self.pool.set_accepted(edges);
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
const MAX_VERTEX_MOVES: u32 = 2;

impl VertexContact {
    /// Moves contact vertices along their edges to their deepest points in the pad; returns true if none had to move.
    fn move_to_deepest_points(&mut self, view: &BodyView) -> bool {
        let moved = self.candidates.moved(view.x);
        let mut stay = true;
        for (i, (vertex, site)) in self.vertices.iter().zip(&mut self.sites).enumerate() {
            let Some(segment) = &vertex.segment else { continue };
            // The pad would penetrate where a vertex under pressure leaves: such a vertex moves only for a larger
            // depth.
            let most = self.pool.law.offset * VERTEX_MOVE_PENETRATION[usize::from(self.pool.edge(i).pressure > 0.0)];
            let near = self.candidates.bounds(i, site.relative_position(view), moved).within(segment.length());
            let free = near && site.moves < MAX_VERTEX_MOVES;
            let Some(deepest) = free.then(|| deepest(&self.bounds, &self.surface, view, segment, most)).flatten()
            else {
                continue;
            };
            site.position = deepest;
            site.contact = None;
            site.moves += 1;
            self.pool.reset(i);
            self.candidates.add(i, deepest.length());
            stay = false;
        }
        stay
    }

    /// Updates gap, pressure and friction of edge `i`, whose vertex has the gap bounds `near`; returns the lag of its
    /// friction, Pa.
    fn update(&mut self, i: usize, view: &BodyView, near: GapBounds, update_friction: bool) -> f64 {
        let law = self.law_of(i);
        let incident = self.incident(|| &self.bounds, i, view.x, near, false);
        // The object's outward normal at the contact is the pad's inward one.
        let places =
            incident.iter().map(|(closest_point, weight, _)| (closest_point.gap, -closest_point.normal, *weight));
        let lag = self.pool.set_pressure(i, &law, update_friction, places);
        let site = &mut self.sites[i];
        site.set_incident(incident, &self.surface);
        let Some(touch) = &mut site.contact else { return 0.0 };
        let Some(lag) = lag else {
            if let Some(accepted) = &self.accepted.sites[i].contact {
                touch.sticking_point = accepted.sticking_point;
            }
            return 0.0;
        };
        if self.pool.made_contact(i) {
            touch.sticking_point = touch.point;
            let normal = self.pool.edge(i).normal;
            let away = near.at - touch.point.position(view.x);
            let start =
                self.from.as_ref().map_or(away, |from| from.of_object(site.position) - from.point(&touch.point));
            // The normal component is that of the current state.
            let drag = start + normal * normal.dot(away - start);
            // `normal` is the outward normal of the object.
            self.pool.record_contact(i, &law, drag, || -normal.dot(start));
        }
        let displacement =
            self.sticking_displacement(i, self.pool.edge(i).anchor, view).map(|(_, displacement)| displacement);
        lag.hypot(
            displacement.map_or(0.0, |displacement| self.pool.update_traction(i, &law, update_friction, displacement)),
        )
    }
}
