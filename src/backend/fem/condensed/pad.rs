//! Static condensation of a single pad onto a patch, and recovery of the full pad.

use super::term::CondensedEnergy;
use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use faer::Mat;
use glam::{DVec3, Vec3};
use mech::body::Body;
use mech::body::cholesky::Factor;
use mech::body::pattern::FIXED;
use mech::body::single_precision::SinglePrecisionFactor;
use mech::newton::Failure;
use mech::potential::stencil::Stencil;
use model::part::FingerModel;
use std::sync::Arc;

/// Pad with the factor of its stiffness.
pub struct CondensedPad {
    body: Arc<Body>,
    dead_loads: Vec<DVec3>,
    eliminated: Option<(Arc<Body>, SinglePrecisionFactor)>,
    patch: Arc<[u32]>,
    stiffness: Arc<Mat<f64>>,
    /// Positions at which the pad was condensed, m.
    condensed_at: Vec<DVec3>,
    /// Equilibrium position of every node without load, m: current; `accepted`: at the level before the last, and at
    /// the last.
    center: Vec<DVec3>,
    accepted: [Vec<DVec3>; 2],
    /// Elastic forces less dead loads of the last corrected state, N per node.
    gradient: Vec<DVec3>,
}

/// Sums of squares over the nodes that measure a correction.
pub(crate) struct Correction {
    /// Sum for the change of the displacement, m2.
    pub change: f64,
    /// Sum for the displacement from the reference position, m2.
    pub displacement: f64,
    /// Sum for the out-of-balance forces before the correction, N2.
    pub residual: f64,
}

impl CondensedPad {
    /// Creates the pad of `finger` under `dead_loads` (N per node; empty for none), not condensed yet.
    pub fn new(finger: &FingerModel, dead_loads: Vec<DVec3>) -> Self {
        let rest = finger.body.rest.clone();
        Self {
            body: finger.body.clone(),
            dead_loads,
            eliminated: None,
            patch: Arc::from([]),
            stiffness: Arc::new(Mat::new()),
            condensed_at: Vec::new(),
            accepted: [rest.clone(), rest.clone()],
            gradient: vec![DVec3::ZERO; rest.len()],
            center: rest,
        }
    }

    /// Returns the full pad.
    pub fn body(&self) -> &Arc<Body> {
        &self.body
    }

    /// Returns the elastic forces less the dead loads at the last corrected state, N per node.
    pub fn gradient(&self) -> &[DVec3] {
        &self.gradient
    }

    /// Returns the potential of the full pad at positions `x`, J.
    pub fn energy(&self, x: &[DVec3]) -> f64 {
        self.body.energy(x) - self.dead_loads.iter().zip(x).map(|(f, x)| f.dot(*x)).sum::<f64>()
    }

    /// Returns true if a force at `stencil` acts only on nodes of the patch or on bonded ones.
    pub fn contains(&self, stencil: &Stencil) -> bool {
        stencil.slices().0.iter().all(|n| self.body.fixed[*n as usize] || self.patch.binary_search(n).is_ok())
    }

    /// Returns the pad as a term of the potential.
    pub fn term(&self) -> CondensedEnergy {
        let center = self.patch.iter().map(|&n| self.center[n as usize]).collect();
        CondensedEnergy { center, patch: self.patch.clone(), stiffness: self.stiffness.clone() }
    }

    /// Returns the retained nodes, ascending.
    pub fn patch(&self) -> &[u32] {
        &self.patch
    }

    /// Condenses the pad, with its stiffness at positions `x`, onto the ascending nodes of `patch`. Returns the
    /// condensed body if these nodes are new.
    ///
    /// # Errors
    /// Returns [`Failure::Singular`] if the stiffness cannot be factorised.
    pub fn condense(&mut self, x: &[DVec3], patch: Vec<u32>) -> std::result::Result<Option<Arc<Body>>, Failure> {
        let same = self.eliminated.as_ref().filter(|_| *patch == *self.patch).map(|(body, _)| body.clone());
        let left = same.is_none().then(|| Arc::new(self.body.condensed(&patch)));
        let body = same.unwrap_or_else(|| Arc::new(self.body.eliminating_last(&patch)));
        let mut factor = Factor::new(body.symbolic().map_err(|_| Failure::Singular)?, 1);
        let mut factorized = false;
        for project in [false, true] {
            let mut values = vec![0.0; body.pattern().row_idx.len()];
            self.gradient = dead_load_gradient(&self.dead_loads, x.len());
            body.add_stiffness(x, project, &mut self.gradient, &mut values);
            factorized = factor.factorize(body.pattern(), &values);
            if factorized {
                break;
            }
        }
        if !factorized {
            return Err(Failure::Singular);
        }
        self.stiffness = Arc::new(factor.condensed(3 * patch.len()));
        let factor = SinglePrecisionFactor::new(&factor);
        let back = solve(&body, &factor, &self.gradient);
        self.center = x.iter().zip(back).map(|(x, w)| *x - w).collect();
        self.accepted = [self.center.clone(), self.center.clone()];
        self.condensed_at = x.to_vec();
        self.patch = patch.into();
        self.eliminated = Some((body, factor));
        Ok(left)
    }

    /// Writes everything that the next correction depends on.
    pub(crate) fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.condensed_at);
        history.write(&(&self.patch, &self.center, &self.accepted, &self.gradient));
    }

    /// Reads what [`CondensedPad::save_state`] wrote; condenses the pad as before. Returns the condensed body if its
    /// nodes are new.
    ///
    /// # Errors
    /// Fails if the history does not match.
    pub(crate) fn restore_state(&mut self, history: &mut StateReader) -> Result<Option<Arc<Body>>> {
        let condensed_at: Vec<DVec3> = history.read()?;
        let (patch, center, accepted, gradient): (Vec<u32>, _, _, _) = history.read()?;
        let known =
            condensed_at.len() == self.body.rest.len() && patch.iter().all(|n| (*n as usize) < condensed_at.len());
        let left = match condensed_at.is_empty() {
            true => None,
            false if known => self.condense(&condensed_at, patch).map_err(|e| Error::Start(e.to_string()))?,
            false => return Err(Error::Start("the saved state belongs to other pads".into())),
        };
        (self.center, self.accepted, self.gradient) = (center, accepted, gradient);
        Ok(left)
    }

    /// Computes the positions `x` of the full pad from those of its patch, and corrects the centre by the full material
    /// law.
    pub(crate) fn correct(&mut self, x: &mut [DVec3]) -> Correction {
        // Only the patch is loaded, and its displacement is known.
        let (displacement, force) = self.term().force(x);
        let (mut moved, mut contact) = (vec![DVec3::ZERO; x.len()], vec![DVec3::ZERO; x.len()]);
        for ((&n, u), f) in self.patch.iter().zip(displacement.chunks_exact(3)).zip(force.chunks_exact(3)) {
            (moved[n as usize], contact[n as usize]) = (DVec3::from_slice(u), DVec3::from_slice(f));
        }
        let nothing = Correction { change: 0.0, displacement: 0.0, residual: 0.0 };
        let Some((body, factor)) = &self.eliminated else { return nothing };
        let mut moved = unknowns(body, &moved);
        factor.back_substitute(&mut moved, 3 * self.patch.len());
        let patch: Vec<DVec3> = self.patch.iter().map(|&n| x[n as usize]).collect();
        x.iter_mut().zip(&self.center).zip(nodes(body, &moved)).for_each(|((x, c), u)| *x = *c + u);
        // The positions of the patch are given; the single-precision solution must not round them.
        self.patch.iter().zip(patch).for_each(|(&n, given)| x[n as usize] = given);
        self.gradient = dead_load_gradient(&self.dead_loads, x.len());
        body.add_gradient(x, &mut self.gradient);
        contact.iter_mut().zip(&self.gradient).for_each(|(f, g)| *f = *g - *f);
        let change = solve(body, factor, &contact);
        self.center.iter_mut().zip(&change).for_each(|(c, w)| *c -= *w);
        let free = |(i, f): (usize, &DVec3)| if body.fixed[i] { 0.0 } else { f.length_squared() };
        Correction {
            change: change.iter().map(|w| w.length_squared()).sum(),
            displacement: x.iter().zip(&body.rest).map(|(x, r)| x.distance_squared(*r)).sum(),
            residual: contact.iter().enumerate().map(free).sum(),
        }
    }

    /// Restores the centre of the last accepted level.
    pub(crate) fn restore(&mut self) {
        self.center.clone_from(&self.accepted[1]);
    }

    /// Stores the centre as that of an accepted level.
    pub(crate) fn accept(&mut self) {
        self.accepted.swap(0, 1);
        self.accepted[1].clone_from(&self.center);
    }

    /// Extrapolates the centre by `factor` times its change between the last two accepted levels.
    pub(crate) fn predict(&mut self, factor: f64) {
        let [before, last] = &self.accepted;
        for ((c, last), before) in self.center.iter_mut().zip(last).zip(before) {
            *c = *last + (*last - *before) * factor;
        }
    }
}

/// Returns the gradient of the dead loads alone, N.
fn dead_load_gradient(dead_loads: &[DVec3], nodes: usize) -> Vec<DVec3> {
    let mut gradient: Vec<DVec3> = dead_loads.iter().map(|f| -*f).collect();
    gradient.resize(nodes, DVec3::ZERO);
    gradient
}

/// Computes the displacements under `force` (N per node), m; zero at fixed nodes.
fn solve(body: &Body, factor: &SinglePrecisionFactor, force: &[DVec3]) -> Vec<DVec3> {
    let mut rhs = unknowns(body, force);
    factor.solve(&mut rhs);
    nodes(body, &rhs).collect()
}

/// Returns the entries of the unknowns of `body` from the vectors of its nodes.
fn unknowns(body: &Body, nodes: &[DVec3]) -> Vec<f32> {
    let mut entries = vec![0.0; body.unknowns()];
    for (node, &p) in nodes.iter().zip(&body.pattern().position).filter(|(_, p)| **p != FIXED) {
        entries[3 * p as usize..3 * p as usize + 3].copy_from_slice(&node.as_vec3().to_array());
    }
    entries
}

/// Returns the vectors of the nodes of `body` from the entries of its unknowns; zero at fixed nodes.
fn nodes(body: &Body, entries: &[f32]) -> impl Iterator<Item = DVec3> {
    let of = |p: u32| if p == FIXED { DVec3::ZERO } else { Vec3::from_slice(&entries[3 * p as usize..]).as_dvec3() };
    body.pattern().position.iter().map(move |&p| of(p))
}
