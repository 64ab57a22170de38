//! History of the terms: begin, accept and reject increments, copy, contact readings, serialisation.

use super::Newton;
use super::object::ObjectTerms;
use crate::potential::edge::{EdgeReading, EdgeState};
use crate::potential::state::{IncrementStart, State};
use crate::potential::term::BodyTerm;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use rayon::prelude::*;
use std::sync::Arc;

/// Copy of all terms, with their history.
pub struct SavedTerms {
    gel: Vec<Vec<Box<dyn BodyTerm>>>,
    terms: Vec<Vec<Box<dyn BodyTerm>>>,
    object: ObjectTerms,
}

impl Newton {
    /// Terms of body `i`: its gel, then the others.
    pub(super) fn body_terms(&self, i: usize) -> impl Iterator<Item = &dyn BodyTerm> {
        self.gel[i].iter().chain(&self.terms[i]).map(|t| &**t)
    }

    /// Copies all terms with their history.
    pub fn save_terms(&self) -> SavedTerms {
        let copy = |terms: &Vec<Vec<Box<dyn BodyTerm>>>| {
            terms.iter().map(|terms| terms.iter().map(|t| t.boxed_clone()).collect()).collect()
        };
        SavedTerms { gel: copy(&self.gel), terms: copy(&self.terms), object: self.object.clone() }
    }

    /// Restores saved terms.
    pub fn restore_terms(&mut self, saved: SavedTerms) {
        (self.gel, self.terms, self.object) = (saved.gel, saved.terms, saved.object);
    }

    /// Begins an increment at the accepted state `from`.
    pub fn begin_increment(&mut self, from: &State) {
        let (from, step) = (Arc::new(from.clone()), self.step);
        for (i, (gel, terms)) in self.gel.iter_mut().zip(&mut self.terms).enumerate() {
            let start = IncrementStart::new(from.clone(), i, &self.rigid, step);
            gel.iter_mut().chain(terms).for_each(|t| t.begin_increment(&start));
        }
        step.iter().for_each(|step| self.object.begin_step(step));
    }

    /// Updates the history of all terms to an accepted state.
    pub fn commit(&mut self, state: &State) {
        let terms = self.gel.iter_mut().zip(&mut self.terms);
        for (i, (b, (gel, terms))) in self.blocks.iter().zip(terms).enumerate() {
            let view = state.view(i, &self.rigid);
            gel.iter_mut().chain(terms).for_each(|t| t.commit(&b.body, &view));
        }
        self.object.commit(state, &self.rigid);
    }

    /// Discards all changes of the terms since the last commit.
    pub fn rollback(&mut self) {
        self.gel.iter_mut().chain(&mut self.terms).flatten().for_each(|t| t.rollback());
        self.object.rollback();
    }

    /// Returns true if the converged `state` satisfies every term; all are evaluated, since each may stiffen itself.
    pub(crate) fn enforce_constraints(&mut self, state: &State) -> bool {
        let (rigid, blocks) = (&self.rigid, &self.blocks);
        let terms = self.gel.par_iter_mut().zip(&mut self.terms).enumerate();
        let asked = terms.map(|(i, (gel, terms))| {
            let view = state.view(i, rigid);
            let asked = gel.iter_mut().chain(terms).map(|t| t.enforce_constraints(&blocks[i].body, &view));
            asked.filter(|satisfied| !satisfied).count() == 0
        });
        let bodies: Vec<bool> = asked.collect();
        self.object.enforce_constraints() && bodies.into_iter().all(|satisfied| satisfied)
    }

    /// Contact edges of body `i` that are not open at `state`, numbered within the body.
    pub fn edge_readings(&self, state: &State, i: usize) -> Vec<EdgeReading> {
        let view = state.view(i, &self.rigid);
        let (mut all, mut first) = (Vec::new(), 0);
        for term in self.body_terms(i) {
            let numbered = |edge: EdgeReading| EdgeReading { number: first + edge.number, ..edge };
            all.extend(term.edge_readings(&view).into_iter().map(numbered));
            first += term.edge_count();
        }
        all
    }

    /// Restores the accepted edges of body `i` that are not open, given by their numbers within the body in ascending
    /// order.
    pub fn set_edges(&mut self, i: usize, edges: &[(usize, EdgeState)]) {
        let (mut rest, mut first) = (edges, 0);
        for term in self.gel[i].iter_mut().chain(&mut self.terms[i]) {
            let next = first + term.edge_count();
            let (own, others) = rest.split_at(rest.partition_point(|(number, _)| *number < next));
            let own: Vec<_> = own.iter().map(|(number, edge)| (number - first, *edge)).collect();
            term.set_edges(&own);
            (rest, first) = (others, next);
        }
    }

    /// Writes the history of all terms.
    pub fn save_state(&self, history: &mut StateWriter) {
        (0..self.blocks.len()).flat_map(|i| self.body_terms(i)).for_each(|t| t.save_state(history));
        self.object.save_state(history);
    }

    /// Reads the history of the same terms.
    ///
    /// # Errors
    /// Fails if the history does not match these terms.
    pub fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        for (gel, terms) in self.gel.iter_mut().zip(&mut self.terms) {
            gel.iter_mut().chain(terms).try_for_each(|t| t.restore_state(history))?;
        }
        self.object.restore_state(history)
    }
}
