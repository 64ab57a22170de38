//! A trained model in use: one pass per grasp, then any load level, in SI.

use super::answer::Answer;
use super::{Code, FaceEngine};
use crate::error::{Error, Result};
use crate::linear::compliance_cache::ComplianceCache;
use crate::linear::first_contact::GeometricContact;
use crate::linear::pad_graph::{PadGraph, mesh_hash};
use crate::model::Model;
use crate::net::autodiff::tape::{Matrix, Tape};
use crate::net::features::GraspFeatures;
use crate::net::features::loads::LoadFeatures;
use crate::net::network::card::{Card, Trained, WEIGHTS};
use crate::net::network::parameters::Parameters;
use crate::net::network::spec::NetworkSpec;
use crate::net::network::{Inputs, Network, NetworkOutput, build};
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Load levels that are decoded together on a tape.
const LEVELS: usize = 10;

/// A trained model.
#[derive(Debug)]
pub struct Predictor {
    /// What it is.
    pub card: Card,
    /// The network.
    pub network: Box<dyn Network>,
    /// Its weights.
    pub parameters: Parameters,
    /// The same network without a tape, where there is one.
    engine: Option<FaceEngine>,
    /// Graphs of the pads asked about so far.
    graphs: Mutex<Vec<Arc<PadGraph>>>,
}

/// A grasp that has been looked at: all that a load level needs.
#[derive(Debug)]
pub struct Seen {
    features: GraspFeatures,
    code: Encoded,
    /// Whether stress is wanted.
    stress: bool,
}

impl Seen {
    /// The same for those who do not ask for stress: theirs is empty.
    pub fn without_stress(self) -> Self {
        Self { stress: false, ..self }
    }

    /// The force that the network measures in, N.
    pub fn unit_force(&self) -> f64 {
        self.features.unit_force()
    }
}

#[derive(Debug)]
enum Encoded {
    Tape(Vec<Matrix>),
    Engine(Code),
}

/// What is predicted for one pad at one load level, pad frame, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct PadState {
    /// Displacement of every node, m; exactly zero where bonded.
    pub displacement: Vec<DVec3>,
    /// Von Mises stress of every node, Pa, >= 0.
    pub stress: Vec<f64>,
    /// Contact force on every node, N; along the closing direction they sum to what the finger presses with.
    pub contact: Vec<DVec3>,
    /// Travel of the finger since first contact, m.
    pub travel: f64,
    /// Translation of the object (its point amid the pads) since first contact, m.
    pub shift: DVec3,
    /// Rotation vector of the object since first contact.
    pub turn: DVec3,
}

impl Predictor {
    /// The model in the folder `model`, or the one that ships under this name.
    ///
    /// # Errors
    /// A folder that holds none, a card or weights that are damaged or do not fit each other.
    pub fn open(model: &Path) -> Result<Self> {
        let Trained { card, weights } = Trained::read(model)?;
        let (network, mut parameters) = build(&card.spec.network, None);
        let path = model.join(WEIGHTS);
        parameters.load(&weights, &path)?;
        if parameters.count() != card.parameters {
            let message = format!("holds {} numbers, the card beside it says {}", parameters.count(), card.parameters);
            return Err(Error::file(path, message));
        }
        let engine = match &card.spec.network {
            NetworkSpec::Face(sizes) => Some(FaceEngine::new(sizes, &parameters, &card.normalisers)),
            NetworkSpec::Paper(_) => None,
        };
        Ok(Self { card, network, parameters, engine, graphs: Mutex::default() })
    }

    /// The same, computed operation by operation as in training: the reference.
    pub fn on_tape(self) -> Self {
        Self { engine: None, ..self }
    }

    /// The graph of the pads of `model`, if the network was trained for it.
    ///
    /// # Errors
    /// What of the scene lies outside the trained range.
    pub fn admit(&self, model: &Model) -> Result<Arc<PadGraph>> {
        // Before the response of a pad is solved for that it does not know.
        let hash = model.fingers.first().map_or_else(String::new, |finger| mesh_hash(&finger.topology));
        self.card.range.admits(model, &hash)?;
        self.graph(model)
    }

    /// The graph of the pads of `model`, trained for or not.
    ///
    /// # Errors
    /// A pad without a sensing face.
    pub fn graph(&self, model: &Model) -> Result<Arc<PadGraph>> {
        let finger = model.finger()?;
        let mut known = self.graphs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(graph) = known.iter().find(|g| g.fits(finger)) {
            return Ok(graph.clone());
        }
        let graph = Arc::new(PadGraph::keeping(finger, self.network.layout(), ComplianceCache::of_user().as_ref())?);
        known.push(graph.clone());
        Ok(graph)
    }

    /// Looks at a grasp at first contact: the one pass of message passing.
    pub fn look(&self, model: &Model, graph: &Arc<PadGraph>, touch: &GeometricContact) -> Seen {
        self.encode(GraspFeatures::new(model, graph, touch))
    }

    /// The same from features made earlier.
    pub fn encode(&self, features: GraspFeatures) -> Seen {
        let code = match &self.engine {
            Some(engine) => Encoded::Engine(engine.encode(&features)),
            None => Encoded::Tape(self.network.encode(&Tape::silent(), &self.parameters, &self.inputs(&features))),
        };
        Seen { features, code, stress: true }
    }

    fn inputs<'a>(&'a self, features: &'a GraspFeatures) -> Inputs<'a> {
        Inputs { features, normalisers: &self.card.normalisers, mirror: (false, false) }
    }

    /// The pads when each finger closes with `force`, N.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn at(&self, seen: &Seen, force: f64) -> Result<Vec<PadState>> {
        Ok(self.ramp(seen, &[force])?.swap_remove(0))
    }

    /// The pads at each of `forces`, N per finger: (forces, pads).
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn ramp(&self, seen: &Seen, forces: &[f64]) -> Result<Vec<Vec<PadState>>> {
        let mut states = Vec::with_capacity(forces.len());
        let together = if self.engine.is_some() { FaceEngine::LOADS } else { LEVELS };
        for some in forces.chunks(together) {
            let answer = self.answer(seen, some)?;
            states.par_extend((0..some.len()).into_par_iter().map(|level| answer.mixed(&[(level, 1.0)])));
        }
        Ok(states)
    }

    fn output(&self, seen: &Seen, loads: &LoadFeatures) -> NetworkOutput {
        match (&seen.code, &self.engine) {
            (Encoded::Engine(code), Some(engine)) => engine.decode(&seen.features, code, loads, seen.stress),
            (Encoded::Tape(code), _) => {
                let inputs = self.inputs(&seen.features);
                self.network.decode(&Tape::silent(), &self.parameters, &inputs, code, loads)
            }
            // What one predictor has seen, another one sees anew.
            (Encoded::Engine(_), None) => self.output(&self.encode(seen.features.clone()), loads),
        }
    }

    /// What the network says at each of `forces`, N per finger, all of them decoded together.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn answer(&self, seen: &Seen, forces: &[f64]) -> Result<Answer> {
        let loads = seen.features.loads(forces);
        let out = self.output(seen, &loads);
        let (features, norms) = (&seen.features, self.card.normalisers.clone());
        let (graph, pads) = (features.graph.clone(), features.pads);
        let (young, unit_force) = (features.young, features.unit_force());
        let answer = Answer { loads, out, norms, graph, pads, stress: seen.stress, young, unit_force };
        match (0..forces.len()).find(|level| !answer.is_finite(*level)) {
            None => Ok(answer),
            Some(bad) => {
                let force = forces[bad];
                Err(Error::Solver(format!("the network gave numbers that are not finite at {force} N per finger")))
            }
        }
    }
}
