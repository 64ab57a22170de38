//! Splits of the poses of objects into training and test sets, by a seed.

use base::random::Random;
use scene::Split;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Grasp numbers by object.
pub type GraspNumbers = BTreeMap<String, Vec<usize>>;

/// Training set and test set.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrainTestSplit {
    /// Poses for training.
    pub train: GraspNumbers,
    /// Poses for testing.
    pub test: GraspNumbers,
}

/// Splits of a data set. They list all poses regardless of their status; only those that were reached should be read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Splits {
    /// Seed of the permutations.
    pub seed: u64,
    /// Fraction of the poses that are held out for testing.
    pub test_fraction: f64,
    /// Split by pose: the poses of every object are divided, so that test objects also occur in training.
    pub poses: TrainTestSplit,
}

impl Splits {
    /// Creates the splits of objects with these names and numbers of grasps.
    pub fn new(split: &Split, objects: &[(String, usize)]) -> Self {
        let mut poses = TrainTestSplit::default();
        for (name, count) in objects {
            // Each object has its own random stream, so that adding an object does not change the split of the others.
            let key = blake3::hash(name.as_bytes());
            let word = key.as_bytes()[..8].iter().fold(0_u64, |word, b| word << 8 | u64::from(*b));
            let mut random = Random::new(split.seed ^ word);
            let mut order: Vec<usize> = (0..*count).collect();
            random.shuffle(&mut order);
            let kept = ((*count as f64 * split.test.get()).round() as usize).min(count.saturating_sub(1));
            let mut train = order.split_off(kept);
            order.sort_unstable();
            train.sort_unstable();
            poses.test.insert(name.clone(), order);
            poses.train.insert(name.clone(), train);
        }
        Self { seed: split.seed, test_fraction: split.test.get(), poses }
    }

    /// Returns the split by pose of one object alone; None if there is no such object.
    pub fn single(&self, object: &str) -> Option<TrainTestSplit> {
        let only = |poses: &GraspNumbers| Some(GraspNumbers::from([(object.to_string(), poses.get(object)?.clone())]));
        Some(TrainTestSplit { train: only(&self.poses.train)?, test: only(&self.poses.test)? })
    }

    /// Returns the split by object: `families` are names separated by commas; objects of such a name, or whose name
    /// begins with one and a `-`, are the test set, and all others the training set.
    pub fn without(&self, families: &str) -> TrainTestSplit {
        let is = |name: &str, family: &str| {
            name.strip_prefix(family).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
        };
        let of = |name: &str| families.split(',').any(|family| is(name, family));
        let (test, train) = self.all().test.into_iter().partition(|(name, _)| of(name));
        TrainTestSplit { train, test }
    }

    /// Returns all poses of all objects as both sets, for training, or for testing a model that was trained on other
    /// data.
    pub fn all(&self) -> TrainTestSplit {
        let mut poses = self.poses.test.clone();
        for (name, train) in &self.poses.train {
            let all = poses.entry(name.clone()).or_default();
            all.extend(train);
            all.sort_unstable();
        }
        TrainTestSplit { train: poses.clone(), test: poses }
    }
}
