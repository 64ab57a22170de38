//! Training and test: which poses of which objects, fixed by a seed.

use crate::random::Random;
use crate::scene::Split;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Grasp numbers by object.
pub type Poses = BTreeMap<String, Vec<usize>>;

/// A training and a test set.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sets {
    /// To train on.
    pub train: Poses,
    /// To judge on.
    pub test: Poses,
}

/// All splits of a data set. They name all poses, whatever became of them: read only those that were reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Splits {
    /// Seed of the permutations.
    pub seed: u64,
    /// Part of the poses kept for the test.
    pub test_fraction: f64,
    /// Seen objects, unseen poses: the poses of every object are shared out.
    pub poses: Sets,
    /// One object alone, unseen poses.
    pub single_object: BTreeMap<String, Sets>,
    /// An unseen object: all poses of all others against all poses of this one.
    pub leave_one_object_out: BTreeMap<String, Sets>,
}

impl Splits {
    /// The splits of objects with so many grasps.
    pub fn new(split: &Split, objects: &[(String, usize)]) -> Self {
        let mut poses = Sets::default();
        for (name, count) in objects {
            // A stream of its own for each object: adding an object does not change the split of the others.
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
        let only = |poses: &Poses, name: &String| Poses::from([(name.clone(), poses[name].clone())]);
        let single = |name: &String| Sets { train: only(&poses.train, name), test: only(&poses.test, name) };
        let all: Poses = objects.iter().map(|(name, count)| (name.clone(), (0..*count).collect())).collect();
        let without = |name: &String| Sets {
            train: all.iter().filter(|(other, _)| *other != name).map(|(n, p)| (n.clone(), p.clone())).collect(),
            test: only(&all, name),
        };
        let names = || objects.iter().map(|(name, _)| name);
        Self {
            seed: split.seed,
            test_fraction: split.test.get(),
            single_object: names().map(|n| (n.clone(), single(n))).collect(),
            leave_one_object_out: names().map(|n| (n.clone(), without(n))).collect(),
            poses,
        }
    }

    /// All poses of all objects, to train on or to judge by: for a data set that another one's model has never seen.
    pub fn all(&self) -> Sets {
        let mut poses = self.poses.test.clone();
        for (name, train) in &self.poses.train {
            let all = poses.entry(name.clone()).or_default();
            all.extend(train);
            all.sort_unstable();
        }
        Sets { train: poses.clone(), test: poses }
    }
}
