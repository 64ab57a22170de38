//! Training: data-parallel over the cores, bitwise identical on any number of threads, resumable after an interruption
//! at any time.
//!
//! All random choices are functions of (seed, epoch, grasp), so that an epoch depends on earlier ones only through
//! weights and moments, which are stored after each epoch (`checkpoint.rs`).

pub mod adam;
mod checkpoint;
pub mod curves;
pub mod data;
pub mod frame_error;
pub mod loss;
pub mod sample;
pub mod slipped;
mod training_state;

use self::frame_error::frame_error;
use self::loss::LossValue;
use self::sample::{LabelNodes, Sample};
use self::slipped::SlippedGrasp;
pub use self::training_state::TrainingState;
use super::autodiff::tensor::{NoneTape, Real, SharedTape, Tape, Values, gradients};
use super::features::VERSION;
use super::features::range::TrainedRange;
use super::infer::predict::Predictor;
use super::network::card::{CARD, Card, StoredModel, WEIGHTS};
use super::network::interval::{ErrorIndicators, PredictionInterval, ValidationErrors};
use super::network::parameters::Parameters;
use super::network::slip_interval::SlipInterval;
use super::network::spec::{Spec, Training};
use super::network::{Forward, Inputs, Network, Normalisers, build};
use crate::linear_response::canonical_pads::CanonicalPadList;
use adam::Adam;
use base::error::{Error, Result};
use base::files::lock::FolderLock;
use base::interrupt;
use base::random::Random;
use checkpoint::StoredCheckpoint;
use curves::Epoch;
use dataset::DataSet;
use dfdx::prelude::AsArray;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Training run of a network.
#[derive(Debug)]
pub struct Trainer {
    dir: PathBuf,
    card: Card,
    network: Box<dyn Network>,
    samples: Vec<Sample>,
    validation: Vec<Sample>,
    slipped: Vec<SlippedGrasp>,
    /// State of the run: weights, those of the best epoch, moments, and all epochs so far.
    state: TrainingState,
    /// Notices about the start, one sentence each.
    pub notices: Vec<String>,
    _lock: FolderLock,
}

/// Reason for the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrainingEnd {
    /// Completion of all epochs.
    Epochs,
    /// Early stop: the validation loss has not fallen for long enough.
    Patience,
}

impl Trainer {
    /// Reads the training grasps of `split` in all of `sets`, and the state of an earlier run of the same plan in
    /// `dir`. The weights start from those of the model `from`, whose statistics are kept and whose range is extended,
    /// or from random ones. Locks `dir` until it is dropped.
    ///
    /// # Errors
    /// Fails if the data cannot be used, if the folder is locked by another training or holds another model, and if the
    /// network of `from` differs.
    pub fn new(sets: &[DataSet], spec: &Spec, split: &str, dir: &Path, from: Option<&Path>) -> Result<Self> {
        // First of all, so that a model written meanwhile by another process is not overwritten at the end.
        let lock = FolderLock::exclusive(dir, "tactus train")?;
        let (network, mut parameters) = build(&spec.network, Some(spec.training.seed));
        let start = from.map(StoredModel::read).transpose()?;
        if let (Some(start), Some(path)) = (&start, from) {
            if start.card.spec.network != spec.network {
                let message = "contains another network than the model file: both need the same `network`";
                return Err(Error::file(path, message));
            }
            parameters.load(&start.weights, &path.join(WEIGHTS))?;
        }
        let splits = data::split(&sets.iter().map(|set| &set.splits).collect::<Vec<_>>(), split)?;
        let all: Vec<_> = sets.iter().zip(splits.iter().map(|split| &split.train)).collect();
        let known = CanonicalPadList::new(network.layout());
        let (samples, range) = data::read(&all, &known, LabelNodes::Canonical, spec.training.frames.get())?;
        let slipped = slipped::read(&all, &known)?;
        if samples.len() < 2 {
            return Err(Error::Start(
                "training needs at least two grasps: one for training, one for early stopping".into(),
            ));
        }
        let (samples, validation) = data::split_validation(samples, spec.training.validation.get(), spec.training.seed);
        let mut card = card(spec, sets, split, [&samples, &validation], range, &parameters);
        if let Some(StoredModel { card: start, .. }) = start {
            card.normalisers = start.normalisers.with_bounds_from(&card.normalisers);
            card.range.extend(&start.range)?;
            card.start = start.data;
        }
        let adam = Adam::new(&parameters);
        let state = TrainingState { best: parameters.clone(), parameters, adam, epochs: Vec::new() };
        let notices = lock.notice().into_iter().collect();
        let mut trainer =
            Self { dir: dir.to_path_buf(), card, network, samples, validation, slipped, state, notices, _lock: lock };
        match checkpoint::read(dir, &trainer.plan()?, &trainer.state)? {
            StoredCheckpoint::State(state) => trainer.state = *state,
            StoredCheckpoint::Nothing | StoredCheckpoint::Damaged(_) if dir.join(CARD).exists() => {
                let message = "already contains a trained model; choose another folder, or remove this one";
                return Err(Error::file(dir, message));
            }
            StoredCheckpoint::Nothing => {}
            StoredCheckpoint::Damaged(path) => {
                trainer.notices.push(format!("{}: is damaged; training starts from the beginning", path.display()));
            }
        }
        Ok(trainer)
    }

    /// Returns the plan: everything that determines the resulting weights.
    fn plan(&self) -> Result<String> {
        let spec = ron::to_string(&self.card.spec).map_err(|e| Error::Solver(e.to_string()))?;
        let Card { tactus, features, data, split, start, .. } = &self.card;
        Ok(format!("{tactus} features {features} {data} {split} {start} {spec}"))
    }

    /// Returns the card of the model in training.
    pub fn card(&self) -> &Card {
        &self.card
    }

    /// Returns the loss curve so far.
    pub fn epochs(&self) -> &[Epoch] {
        &self.state.epochs
    }

    /// Returns the numbers of training and validation grasps.
    pub fn counts(&self) -> (usize, usize) {
        (self.samples.len(), self.validation.len())
    }

    /// Trains to the end and calls `watch` after every epoch. Every epoch is stored on disk before the next one starts.
    ///
    /// # Errors
    /// Fails if the loss is not finite, in which case the last good epoch stays on disk, and if files cannot be
    /// written.
    pub fn run(&mut self, mut watch: impl FnMut(&Self)) -> Result<TrainingEnd> {
        let training = self.card.spec.training;
        let plan = self.plan()?;
        let end = loop {
            let done = self.state.epochs.len();
            let since = self.state.best_epoch().map_or(0, |(best, _)| done - 1 - best);
            if done >= training.epochs.get() {
                break TrainingEnd::Epochs;
            }
            if since >= training.patience.get() {
                break TrainingEnd::Patience;
            }
            self.epoch(done)?;
            checkpoint::write(&self.dir, &plan, &self.state)?;
            curves::write(&self.dir, &self.state.epochs)?;
            watch(self);
        };
        self.finish()?;
        Ok(end)
    }

    fn epoch(&mut self, number: usize) -> Result<()> {
        let training = self.card.spec.training;
        let mut order: Vec<usize> = (0..self.samples.len()).collect();
        let mut random = Random::new(random_seed(training.seed, number, usize::MAX));
        random.shuffle(&mut order);
        let batches = order.len().div_ceil(training.batch.get());
        let mut state = self.state.clone();
        let mut total = 0.0;
        for (k, batch) in order.chunks(training.batch.get()).enumerate() {
            // In the order of the batch, independent of the scheduling of threads.
            let parts: Vec<(f64, Vec<Values<f32>>)> = batch
                .par_iter()
                .map(|&i| interrupt::check().map(|()| self.gradient(&state.parameters, i, number)))
                .collect::<Result<_>>()?;
            let loss = parts.iter().map(|p| p.0).sum::<f64>() / batch.len() as f64;
            let mut gradients: Vec<Values<f32>> =
                parts.into_iter().map(|p| p.1).reduce(sum_gradients).unwrap_or_default();
            let square = gradients.iter().flat_map(|g| g.iter()).map(|g| f64::from(*g).powi(2)).sum::<f64>();
            let norm = square.sqrt() / batch.len() as f64;
            if !loss.is_finite() || !norm.is_finite() {
                let kept = self.state.epochs.len();
                return Err(Error::Solver(format!(
                    "the loss is not finite in epoch {number}; the {kept} epochs before it are saved in {}; reduce \
                     `learning_rate`",
                    self.dir.display()
                )));
            }
            let scale = ((training.clip.get() / norm).min(1.0) / batch.len() as f64) as f32;
            gradients.iter_mut().flat_map(|g| g.iter_mut()).for_each(|g| *g *= scale);
            let rate = learning_rate(&training, number * batches + k, batches);
            state.adam.update(&mut state.parameters, &gradients, rate);
            total += loss * batch.len() as f64;
        }
        let validation =
            loss(self.network.as_ref(), &state.parameters, &self.card.normalisers, &training, &self.validation);
        interrupt::check()?;
        if !validation.is_finite() {
            return Err(Error::Solver(format!(
                "the validation loss is not finite in epoch {number}; reduce `learning_rate`"
            )));
        }
        if state.best_epoch().is_none_or(|(_, best)| validation < best) {
            state.best = state.parameters.clone();
        }
        let rate = learning_rate(&training, number * batches, batches);
        state.epochs.push(Epoch { training: total / order.len() as f64, validation, rate });
        self.state = state;
        Ok(())
    }

    /// Computes the loss of training grasp `i`, and its gradient.
    fn gradient(&self, parameters: &Parameters, i: usize, epoch: usize) -> (f64, Vec<Values<f32>>) {
        let training = &self.card.spec.training;
        let mut random = Random::new(random_seed(training.seed, epoch, i));
        let sample = &self.samples[i];
        let mut levels: Vec<usize> = (0..sample.forces.len()).collect();
        random.shuffle(&mut levels);
        levels.truncate(training.levels.get());
        levels.sort_unstable();
        let mut coin = || training.mirror && random.uniform_below(2) == 1;
        let mirror = (coin(), coin());
        let inputs = Inputs {
            features: &sample.features,
            normalisers: &self.card.normalisers,
            mirror,
            tape: SharedTape::default(),
        };
        let loss = sample_loss(self.network.as_ref(), parameters, &inputs, training, &sample.select_levels(&levels));
        (f64::from(loss.array()), gradients(loss, &parameters.matrices))
    }

    /// Fits the load at which objects slip, by the predictions of `predictor`, to the grasps that did.
    fn slip(&self, predictor: &Predictor) -> Option<SlipInterval> {
        let loads = self.slipped.par_iter().filter_map(|grasp| grasp.slip_load(predictor));
        SlipInterval::fit(&loads.map(|load| (load.indicators, load.used)).collect::<Vec<_>>())
    }

    /// Fits the prediction interval of `predictor` to the grasps held out from the training.
    fn interval(&self, predictor: &Predictor) -> Result<Option<PredictionInterval>> {
        let kept = self.validation.par_iter().map(|sample| {
            interrupt::check()?;
            let answer = predictor.decode(&predictor.encode(sample.features.clone()), &sample.grasp_loads)?;
            let level = |(k, signs): (usize, &ErrorIndicators)| {
                let error = frame_error(sample, k, &answer.at(k));
                (*signs, [error.displacement, error.stress, error.travel])
            };
            Ok(answer.error_indicators.iter().enumerate().map(level).collect())
        });
        Ok(PredictionInterval::fit(&kept.collect::<Result<Vec<ValidationErrors>>>()?))
    }

    /// Writes the model: card with prediction interval, best weights, curves.
    fn finish(&mut self) -> Result<()> {
        let Some((best, loss)) = self.state.best_epoch() else { return Ok(()) };
        (self.card.epochs, self.card.validation_loss) = (best + 1, loss);
        let (network, _) = build(&self.card.spec.network, None);
        let predictor = Predictor::of(self.card.clone(), network, self.state.best.clone());
        (self.card.interval, self.card.slip) = (self.interval(&predictor)?, self.slip(&predictor));
        curves::draw(&self.dir, &self.state.epochs)?;
        self.card.write(&self.dir, &self.state.best.to_bytes()?)?;
        checkpoint::remove(&self.dir)
    }
}

/// Computes the loss of a sample whose features are those of `inputs`.
pub fn sample_loss<E: Real, T: Tape<E>>(
    network: &(impl Forward<E, T> + ?Sized),
    parameters: &Parameters<E>,
    inputs: &Inputs<T>,
    training: &Training,
    sample: &Sample,
) -> LossValue<E, T> {
    let code = network.encode(parameters, inputs);
    let output = network.decode(parameters, inputs, &code, &sample.loads);
    sample.loss(output, inputs.normalisers, inputs.mirror, &training.weights)
}

/// Computes the mean loss over all levels of `samples`, without mirrors.
pub fn loss(
    network: &dyn Network,
    parameters: &Parameters,
    normalisers: &Normalisers,
    training: &Training,
    samples: &[Sample],
) -> f64 {
    let of = |s: &Sample| {
        // After an interrupt the loss is not used.
        if interrupt::requested() {
            return f64::NAN;
        }
        let inputs = Inputs { features: &s.features, normalisers, mirror: (false, false), tape: NoneTape };
        f64::from(sample_loss(network, parameters, &inputs, training, s).array())
    };
    let losses: Vec<f64> = samples.par_iter().map(of).collect();
    losses.iter().sum::<f64>() / losses.len().max(1) as f64
}

/// Returns the learning rate of a step.
fn learning_rate(training: &Training, step: usize, per_epoch: usize) -> f64 {
    let total = (training.epochs.get() * per_epoch) as f64;
    let (at, warm) = ((step as f64 + 0.5) / total, 0.02);
    let fall = 0.5 * (1.0 + (std::f64::consts::PI * (at - warm).max(0.0) / (1.0 - warm)).cos());
    training.learning_rate.get() * if at < warm { at / warm } else { fall }
}

/// Returns the random seed of a grasp in an epoch.
fn random_seed(seed: u64, epoch: usize, grasp: usize) -> u64 {
    let mut random = Random::new(seed ^ (epoch as u64).rotate_left(32));
    random.next_u64() ^ Random::new(grasp as u64).next_u64()
}

fn sum_gradients(mut a: Vec<Values<f32>>, b: Vec<Values<f32>>) -> Vec<Values<f32>> {
    a.iter_mut().zip(&b).for_each(|(a, b)| a.iter_mut().zip(b.iter()).for_each(|(a, b)| *a += *b));
    a
}

fn card(
    spec: &Spec,
    sets: &[DataSet],
    split: &str,
    [samples, validation]: [&[Sample]; 2],
    range: TrainedRange,
    parameters: &Parameters,
) -> Card {
    Card {
        tactus: env!("CARGO_PKG_VERSION").into(),
        features: VERSION,
        spec: spec.clone(),
        data: data::plan(sets),
        split: split.into(),
        start: String::new(),
        grasps: samples.len(),
        parameters: parameters.count(),
        units: "displacement, travel, shift: m; stress: Pa; contact force: N; turn: rad; frame of each pad".into(),
        validation_loss: f64::NAN,
        epochs: 0,
        normalisers: data::normalisers(samples, validation),
        range,
        kept: validation.len(),
        interval: None,
        slip: None,
        checksum: String::new(),
    }
}
