//! Inference of a trained model: one pass per grasp, then any load level, in SI.

use super::face::{DecodeRequest, FaceEngine};
use super::grasp_output::GraspOutput;
use super::latent_code::LatentCode;
use super::output_arrays::OutputArrays;
pub use super::predicted_state::{GraspState, PadState};
use super::response::RequiredFields;
use crate::autodiff::tensor::{Matrix, NoneTape};
use crate::features::GraspFeatures;
use crate::features::loads::LoadFeatures;
use crate::linear_response::canonical_pads::{CanonicalPadList, CanonicalPads};
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::{GraspLoad, frame_loads};
use crate::network::card::{Card, StoredModel, WEIGHTS};
use crate::network::parameters::Parameters;
use crate::network::spec::NetworkSpec;
use crate::network::{Forward, Inputs, Network, build};
use base::error::{Error, Result};
use model::Model;
use rayon::prelude::*;
use record::FieldTransfer;
use std::path::Path;
use std::sync::Arc;

/// Number of load levels that are decoded together as tensors.
const TENSOR_BATCH_LEVELS: usize = 10;

/// Trained model with its network.
#[derive(Debug)]
pub struct Predictor {
    /// Card of the model.
    pub card: Card,
    /// Network of the model.
    pub network: Box<dyn Network>,
    /// Weights of the network.
    pub parameters: Parameters,
    /// The same network without tensors; None if its kind has no such engine.
    engine: Option<FaceEngine>,
    /// Canonical pads requested so far.
    pub(crate) pads: CanonicalPadList,
}

/// Encoded grasp: all that decoding a load level requires.
#[derive(Debug)]
pub struct EncodedGrasp {
    features: GraspFeatures,
    code: Encoded,
    /// Map of the fields to the mesh of the scene; None if it is the canonical one.
    to_scene: Option<Arc<FieldTransfer>>,
    fields: RequiredFields,
    /// Flag: the grasp is within the range of the training, apart from its forces.
    in_trained_range: bool,
}

impl EncodedGrasp {
    /// Omits the fields that its scene does not require: stress is then empty in all answers, and the displacement below
    /// the sensing faces zero.
    pub fn with_needed_fields(self) -> Self {
        let needs = &self.features.model.needs;
        let fields = RequiredFields { stress: needs.stress, interior: needs.stress || needs.interior };
        Self { fields, ..self }
    }

    /// Returns the model of the grasp.
    pub fn model(&self) -> &Model {
        &self.features.model
    }

    /// Returns the unit of force of the network, N.
    pub fn unit_force(&self) -> f64 {
        self.features.unit_force()
    }
}

#[derive(Debug)]
enum Encoded {
    Tensors(Vec<Matrix>),
    Engine(LatentCode),
}

impl Predictor {
    /// Opens the model in the folder `model`, or the shipped one of this name.
    ///
    /// # Errors
    /// Fails if the folder holds no model, and if card or weights are damaged or do not match.
    pub fn open(model: &Path) -> Result<Self> {
        let StoredModel { card, weights } = StoredModel::read(model)?;
        let (network, mut parameters) = build(&card.spec.network, None);
        let path = model.join(WEIGHTS);
        parameters.load(&weights, &path)?;
        if parameters.count() != card.parameters {
            let message = format!("contains {} numbers, but its card declares {}", parameters.count(), card.parameters);
            return Err(Error::file(path, message));
        }
        Ok(Self::of(card, network, parameters))
    }

    /// Creates the predictor of a trained network.
    pub fn of(card: Card, network: Box<dyn Network>, parameters: Parameters) -> Self {
        let engine = match &card.spec.network {
            NetworkSpec::Face(sizes) => Some(FaceEngine::new(sizes, &parameters, &card.normalisers)),
            NetworkSpec::Paper(_) => None,
        };
        let pads = CanonicalPadList::new(network.layout());
        Self { card, network, parameters, engine, pads }
    }

    /// Returns true if the training set had pushes on the object.
    pub fn supports_pushes(&self) -> bool {
        self.card.range.push[0] > 0.0
    }

    /// Switches to the reference implementation, which computes on a tape as in training.
    pub fn on_tape(self) -> Self {
        Self { engine: None, ..self }
    }

    /// Returns the canonical pads of `model`, if model and forces are within the trained range or it may `extrapolate`.
    ///
    /// # Errors
    /// Fails if the scene is outside the trained range; the message states where.
    pub fn pads_if_in_range(&self, model: &Arc<Model>, extrapolate: bool) -> Result<CanonicalPads> {
        // Checked first, because solving for the response of a new pad is expensive.
        self.card.range.check_model(model, extrapolate)?;
        self.canonical_pads(model)
    }

    /// Returns the canonical pads of `model`, if model and at least one force are within the trained range or it may
    /// `extrapolate`.
    ///
    /// # Errors
    /// Fails if the scene, or all of its forces, are outside the trained range; the message states where.
    pub fn pads_if_some_force_in_range(&self, model: &Arc<Model>, extrapolate: bool) -> Result<CanonicalPads> {
        self.card.range.check_model_some_force(model, extrapolate)?;
        self.canonical_pads(model)
    }

    /// Returns notes about the answers to grasps of `model`: frames without an answer, and whether their error is
    /// unknown; empty for a scene that is refused.
    pub fn notices(&self, model: &Model, extrapolate: bool) -> Vec<String> {
        let range = &self.card.range;
        if range.check_model_some_force(model, extrapolate).is_err() {
            return Vec::new();
        }
        let outside = range.outside(model).into_iter().chain(range.forces_outside(model));
        let outside = outside.map(|what| match extrapolate {
            true => format!("the error of the network is unknown outside the range of its training data: {what}"),
            false => format!("{what}: the network gives no prediction; `extrapolate` allows one of unknown error"),
        });
        outside.chain(self.card.unknown_error()).collect()
    }

    /// Returns indices and loads of the frames of `model` that have an answer.
    pub fn answerable_loads(&self, model: &Model, extrapolate: bool) -> Vec<(usize, GraspLoad)> {
        let loads = frame_loads(model);
        self.card.range.answerable_frames(model, extrapolate).into_iter().map(|frame| (frame, loads[frame])).collect()
    }

    /// Returns the canonical pads of `model`, in the trained range or not.
    ///
    /// # Errors
    /// Fails for a pad without a sensing face, or with one that is not star-shaped.
    pub fn canonical_pads(&self, model: &Arc<Model>) -> Result<CanonicalPads> {
        self.pads.of(model)
    }

    /// Encodes a grasp at first contact of the canonical pads, with the only pass of message passing.
    pub fn encode_first_contact(&self, pads: &CanonicalPads, touch: &GeometricContact) -> EncodedGrasp {
        let encoded = self.encode(GraspFeatures::new(&pads.model, &pads.graph, touch));
        EncodedGrasp { to_scene: pads.to_scene().cloned(), ..encoded }
    }

    /// Encodes a grasp from existing features; its answers are on the canonical mesh.
    pub fn encode(&self, features: GraspFeatures) -> EncodedGrasp {
        let code = match &self.engine {
            Some(engine) => Encoded::Engine(engine.encode(&features)),
            None => Encoded::Tensors(self.forward().encode(&self.parameters, &self.inputs(&features))),
        };
        let in_trained_range = self.card.range.outside(&features.model).is_none();
        EncodedGrasp { features, code, to_scene: None, fields: RequiredFields::ALL, in_trained_range }
    }

    fn forward(&self) -> &dyn Forward {
        self.network.as_ref()
    }

    fn inputs<'a>(&'a self, features: &'a GraspFeatures) -> Inputs<'a> {
        Inputs { features, normalisers: &self.card.normalisers, mirror: (false, false), tape: NoneTape }
    }

    /// Predicts the states of the pads under a load: a force per finger, N, or a force and a push.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn at(&self, encoded: &EncodedGrasp, load: impl Into<GraspLoad>) -> Result<GraspState> {
        Ok(self.states(encoded, &[load.into()])?.swap_remove(0))
    }

    /// Predicts the states of the pads under each of `loads`.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn states(&self, encoded: &EncodedGrasp, loads: &[GraspLoad]) -> Result<Vec<GraspState>> {
        let mut states = Vec::with_capacity(loads.len());
        let together = if self.engine.is_some() { FaceEngine::LOADS_PER_BATCH } else { TENSOR_BATCH_LEVELS };
        for some in loads.chunks(together) {
            let answer = self.decode(encoded, some)?;
            states.par_extend((0..some.len()).into_par_iter().map(|level| answer.at(level)));
        }
        Ok(states)
    }

    /// Computes the outputs for `grasps` on pads of one graph, in their order.
    fn outputs<'a>(&self, grasps: &'a [(&'a EncodedGrasp, LoadFeatures)]) -> Vec<OutputArrays> {
        let coded = |grasp: &'a (&'a EncodedGrasp, LoadFeatures)| match &grasp.0.code {
            Encoded::Engine(code) => Some(DecodeRequest { features: &grasp.0.features, code, loads: &grasp.1 }),
            Encoded::Tensors(_) => None,
        };
        let together: Option<Vec<DecodeRequest>> = grasps.iter().map(coded).collect();
        if let (Some(engine), Some(together)) = (&self.engine, together) {
            let fields = grasps.iter().map(|(encoded, _)| encoded.fields).reduce(RequiredFields::or);
            return engine.decode(&together, fields.unwrap_or(RequiredFields::ALL));
        }
        let alone = |(encoded, loads): &(&EncodedGrasp, LoadFeatures)| match &encoded.code {
            Encoded::Tensors(code) => {
                let inputs = self.inputs(&encoded.features);
                self.forward().decode(&self.parameters, &inputs, code, loads).into()
            }
            // A grasp encoded by another predictor is encoded again.
            Encoded::Engine(_) => {
                self.outputs(&[(&self.encode(encoded.features.clone()), loads.clone())]).swap_remove(0)
            }
        };
        grasps.iter().map(alone).collect()
    }

    /// Computes the output of the network for a grasp under each of `given`, all decoded together.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn decode(&self, encoded: &EncodedGrasp, given: &[GraspLoad]) -> Result<GraspOutput> {
        self.decode_batch(&[encoded], given).swap_remove(0)
    }

    /// Computes the output of the network for each of `grasps` on pads of one graph, under each of `given`, all decoded
    /// together. A grasp fails if its numbers are not finite.
    pub fn decode_batch(&self, grasps: &[&EncodedGrasp], given: &[GraspLoad]) -> Vec<Result<GraspOutput>> {
        let grasps: Vec<(&EncodedGrasp, LoadFeatures)> =
            grasps.iter().map(|encoded| (*encoded, encoded.features.loads(given))).collect();
        let outputs = self.outputs(&grasps);
        grasps
            .into_iter()
            .zip(outputs)
            .map(|((encoded, loads), out)| self.checked(encoded, given, loads, out))
            .collect()
    }

    /// Returns the answer with the travel consistent with its displacement field, and its error indicators.
    fn checked(
        &self,
        encoded: &EncodedGrasp,
        given: &[GraspLoad],
        loads: LoadFeatures,
        out: OutputArrays,
    ) -> Result<GraspOutput> {
        let (features, norms) = (&encoded.features, self.card.normalisers.clone());
        let (graph, pads) = (features.graph.clone(), features.pads);
        let (young, unit_force) = (features.young, features.unit_force());
        let mut answer = GraspOutput {
            loads,
            out,
            norms,
            graph,
            to_scene: encoded.to_scene.clone(),
            pads,
            fields: encoded.fields,
            young,
            unit_force,
            travel: Vec::new(),
            error_indicators: Vec::new(),
            interval: self.card.interval(),
            interval_valid: Vec::new(),
        };
        // A prediction interval is valid only within the range of the training.
        let known = |load: &GraspLoad| encoded.in_trained_range && self.card.range.contains_force(load.force);
        answer.interval_valid = answer.loads.load.iter().map(known).collect();
        match (0..given.len()).find(|level| !answer.is_finite(*level)) {
            None => {
                answer.correct_travel(features);
                Ok(answer)
            }
            Some(bad) => {
                let force = given[bad].force;
                Err(Error::Solver(format!("the network predicted values that are not finite at {force} N per finger")))
            }
        }
    }
}
