//! Snapshots: saved environments.

use super::draw::EpisodeKey;
use serde::{Deserialize, Serialize};

/// Version of the content of a snapshot.
const FORMAT: u32 = 1;

/// Saved episode and its actions: as equal input gives equal output, replaying it leads to the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Version of this format.
    pub format: u32,
    /// BLAKE3 of all of the scene that decides an episode, hexadecimal.
    pub scene: String,
    /// The episode.
    pub key: EpisodeKey,
    /// Name of the object in the hand; None where the episode has no feasible start, and before the first reset.
    pub object: Option<String>,
    /// Actions since its start, one after the other.
    pub actions: Vec<f32>,
    /// BLAKE3 of all the above, hexadecimal.
    pub checksum: String,
}

impl Snapshot {
    pub(crate) fn new(scene: &str, key: EpisodeKey, object: Option<&str>, actions: &[f32]) -> Self {
        let mut snapshot = Self {
            format: FORMAT,
            scene: scene.into(),
            key,
            object: object.map(str::to_string),
            actions: actions.to_vec(),
            checksum: String::new(),
        };
        snapshot.checksum = snapshot.sum();
        snapshot
    }

    /// Returns the snapshot as one line of JSON.
    pub fn to_json(&self) -> String {
        // Strings and numbers: there is nothing that could fail.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Reads the snapshot that [`Snapshot::to_json`] wrote.
    ///
    /// # Errors
    /// Fails for a text that is cut off or is no snapshot.
    pub fn from_json(text: &str) -> Result<Self, String> {
        serde_json::from_str(text)
            .map_err(|e| format!("the snapshot cannot be read: {e}; it is cut off, was changed, or holds NaN"))
    }

    /// Checks that the snapshot can be restored in environments of `scene`, whose actions have `size` numbers and whose episodes
    /// have at most `steps` steps. The error says why it cannot.
    pub(crate) fn check(&self, scene: &str, size: usize, steps: usize) -> Result<(), String> {
        if self.format != FORMAT {
            return Err(format!("the snapshot has format {}; this version of tactus reads {FORMAT}", self.format));
        }
        if let Some(at) = self.actions.iter().position(|a| !a.is_finite()) {
            let (step, bad) = (at / size + 1, self.actions[at]);
            return Err(format!("the snapshot holds {bad} in its action of step {step}; finite numbers are allowed"));
        }
        if self.scene != scene {
            return Err("the snapshot is of another scene: its task, objects, grasps, pads or backend differ".into());
        }
        let found = self.actions.len();
        if !found.is_multiple_of(size) || found / size > steps {
            return Err(format!(
                "the snapshot holds {found} numbers of actions; {size} a step are allowed, for at most {steps} steps"
            ));
        }
        if self.checksum != self.sum() {
            return Err("the snapshot was changed or damaged: its checksum does not fit; save it anew".into());
        }
        Ok(())
    }

    fn sum(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.scene.as_bytes());
        let EpisodeKey { seed, env, episode } = self.key;
        [u64::from(self.format), seed, env, episode].iter().for_each(|word| {
            hasher.update(&word.to_le_bytes());
        });
        hasher.update(self.object.as_deref().unwrap_or("\0").as_bytes());
        self.actions.iter().for_each(|a| {
            hasher.update(&a.to_le_bytes());
        });
        hasher.finalize().to_hex().to_string()
    }
}
