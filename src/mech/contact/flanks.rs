//! What a feature of the object presses on: the nearest face of the pad and, in a fold, its other flanks.
//!
//! An edge of the object folds the pad around it, and comes to rest in the fold: in truth it touches both flanks. The least of their
//! distances has a kink there, about which Newton's method would jump for ever; the sum over both has none (see
//! [`Rings::beside`](crate::geometry::mesh::rings::Rings::beside)).

use super::foot::{Foot, ON_RIM, carried_on, on_edge, on_face};
use super::project::FaceBounds;
use super::surface::ContactSurface;
use crate::geometry::mesh::rings::{Part, Place, View};
use crate::geometry::shape::outer;
use crate::scales::FACE_KEPT;
use glam::{DMat3, DVec3};

/// A foot, its weight in the sum over all of them, and how the direction to it turns as the feature moves, 1/m.
pub(crate) type Flank = (Foot, f64, DMat3);

impl Foot {
    /// The part of its face that it lies on.
    pub(crate) fn part(&self) -> Part {
        let on = |k: usize| self.l[k] <= ON_RIM;
        match [on(0), on(1), on(2)] {
            [false, false, false] => Part::Face,
            // Opposite to corner `k` lies edge `k + 1`.
            [true, false, false] => Part::Edge(1),
            [false, true, false] => Part::Edge(2),
            [false, false, true] => Part::Edge(0),
            [_, true, true] => Part::Corner(0),
            [true, _, true] => Part::Corner(1),
            [true, true, _] => Part::Corner(2),
        }
    }
}

/// Cosine of the angle between faces from which on a fold is shallow (15 degrees).
const SHALLOW: f64 = 0.966;
/// The same where one face counted last (18 degrees), and where the whole fold did (12): the choice does not swing.
const SHALLOW_STILL: f64 = 0.951;
const SHALLOW_AGAIN: f64 = 0.978;
/// The same while the choice of one face stays (30 degrees).
const NOT_SHALLOW: f64 = 0.866;
/// What a feature pressed on at the last assembly.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Last {
    /// The nearest face.
    pub face: usize,
    /// Whether it was carried on beyond its rim.
    pub carried: bool,
    /// Whether others counted beside it.
    pub folded: bool,
    /// Whether that choice stays as it is, so that the energy along a line has no jumps; else it is made anew, though not for little.
    pub stays: bool,
}

impl Last {
    /// Cosine of the angle between faces from which on a fold is shallow.
    fn shallow(self) -> f64 {
        match (self.stays, self.folded) {
            (false, false) => SHALLOW_STILL,
            (false, true) => SHALLOW_AGAIN,
            (true, false) => NOT_SHALLOW,
            (true, true) => f64::INFINITY,
        }
    }

    /// Difference of distance up to which its face is kept at a shallow fold, m, where contact has this `offset` (m).
    fn kept(self, offset: f64) -> f64 {
        match (self.stays, self.carried) {
            (false, _) => FACE_KEPT * offset,
            (true, true) => f64::INFINITY,
            (true, false) => 0.0,
        }
    }
}

impl FaceBounds {
    /// The feet of a feature at `y` (relative to the finger, m), the nearest first; none if it is farther than `reach` (m) from the
    /// surface.
    ///
    /// At a shallow fold, like that between faces of a pad that is smoothly bent, the normal hardly changes, but within a fraction of
    /// the reach; there just one face counts, and that of `last` is kept as long as it is nearly as near. `side` knows better on which
    /// side of the surface the feature is.
    pub(crate) fn flanks(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        reach: f64,
        last: Option<Last>,
        side: impl Fn(Foot) -> Foot,
    ) -> Vec<Flank> {
        let Some(nearest) = self.closest_as(surface, x, y, reach, side) else { return Vec::new() };
        if inside(surface, x, &nearest, 2.0 * reach) && last.is_none_or(|last| last.face == nearest.face) {
            return vec![(nearest, 1.0, DMat3::ZERO)];
        }
        let others = self.beside(surface, x, y, reach, &nearest);
        let least = last.map_or(SHALLOW, Last::shallow);
        let shallow = |foot: &Foot| foot.normal.dot(nearest.normal) > least;
        if others.iter().all(|(foot, ..)| shallow(foot)) {
            let kept = last.and_then(|last| {
                let foot = carried_on(last.face, &surface.faces[last.face], x, y)?;
                (shallow(&foot) && (foot.gap - nearest.gap).abs() < last.kept(self.offset)).then_some(foot)
            });
            return vec![(kept.unwrap_or(nearest), 1.0, DMat3::ZERO)];
        }
        let mut flanks = vec![(nearest, 1.0, DMat3::ZERO)];
        flanks.extend(others);
        flanks
    }

    /// All feet within `reach` but the nearest.
    fn beside(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3, reach: f64, nearest: &Foot) -> Vec<Flank> {
        let view = |t: u32| {
            let (i, face) = (t as usize, &surface.faces[t as usize]);
            if self.away(i, face, x, y, reach) >= reach {
                return View::Beyond;
            }
            match on_face(i, face, x, y) {
                foot if foot.gap.abs() >= reach => View::Beyond,
                foot if foot.part() == Part::Face && foot.gap < 0.0 => View::Behind,
                foot => View::At(foot.part()),
            }
        };
        let along = |t: u32, i: usize| {
            let l = on_edge(&surface.faces[t as usize], x, (i + 2) % 3, y);
            if l[i] <= ON_RIM {
                Part::Corner((i + 1) % 3)
            } else if l[(i + 1) % 3] <= ON_RIM {
                Part::Corner(i)
            } else {
                Part::Edge(i)
            }
        };
        let others = surface.rings.beside(nearest.face as u32, nearest.part(), view, along).into_iter();
        others
            .filter_map(|(place, weight)| {
                outside(surface, x, y, place).map(|(foot, curvature)| (foot, weight, curvature))
            })
            .collect()
    }
}

/// Whether a foot lies farther than `margin` (m) from the rim of its face.
fn inside(surface: &ContactSurface, x: &[DVec3], foot: &Foot, margin: f64) -> bool {
    let [a, b, c] = surface.faces[foot.face].corners.map(|n| x[n as usize]);
    let twice = (b - a).cross(c - a).length();
    let edges = [(c - b).length(), (a - c).length(), (b - a).length()];
    (0..3).all(|k| foot.l[k] * twice > margin * edges[k])
}

/// The foot on a place of the surface that faces `y`, and how the direction to it turns.
fn outside(surface: &ContactSurface, x: &[DVec3], y: DVec3, place: Place) -> Option<(Foot, DMat3)> {
    let (face, l, along) = match place {
        Place::Face(i) => return Some((on_face(i as usize, &surface.faces[i as usize], x, y), DMat3::ZERO)),
        Place::Edge(e) => {
            let (t, i) = surface.rings.owner(e);
            let face = &surface.faces[t as usize];
            let [a, b] = [i, (i + 1) % 3].map(|k| x[face.corners[k] as usize]);
            (t, on_edge(face, x, (i + 2) % 3, y), (b - a).normalize_or_zero())
        }
        Place::Corner(v) => {
            let (t, i) = surface.rings.owner_of_corner(v)?;
            (t, std::array::from_fn(|k| f64::from(u8::from(k == i))), DVec3::ZERO)
        }
    };
    let away = y - surface.faces[face as usize].stencil(l).position(x);
    let normal = away.try_normalize()?;
    let across = DMat3::IDENTITY - outer(along) - outer(normal);
    Some((Foot::at(face as usize, l, away.length(), normal), across * away.length().recip()))
}
