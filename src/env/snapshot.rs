//! Snapshots of environments.

use super::draw::EpisodeKey;
use serde::{Deserialize, Serialize};

/// Version of the snapshot format.
const FORMAT: u32 = 3;

/// Saved state of an environment, from which the episode continues bit for bit, in this or another process. Its size is
/// independent of the length of the episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Version of this format.
    pub format: u32,
    /// BLAKE3 identity hash of the scene, hexadecimal.
    pub scene: String,
    /// Key of the episode.
    pub key: EpisodeKey,
    /// State of the environment, see [`base::saved_state`].
    pub state: Vec<u8>,
    /// BLAKE3 hash of all fields above.
    pub checksum: [u8; 32],
}

impl Snapshot {
    pub(crate) fn new(scene: &str, key: EpisodeKey, state: Vec<u8>) -> Self {
        let mut snapshot = Self { format: FORMAT, scene: scene.into(), key, state, checksum: [0; 32] };
        snapshot.checksum = snapshot.sum();
        snapshot
    }

    /// Serialises the snapshot.
    ///
    /// # Errors
    /// Fails if the snapshot cannot be serialised; the message states the reason.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        postcard::to_stdvec(self).map_err(|e| format!("the snapshot cannot be written: {e}"))
    }

    /// Deserialises a snapshot written by [`Snapshot::to_bytes`].
    ///
    /// # Errors
    /// Fails if the bytes are truncated or not a snapshot.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        postcard::from_bytes(bytes)
            .map_err(|e| format!("the snapshot cannot be read: {e}; it is truncated or changed, or is not a snapshot"))
    }

    /// Checks that the snapshot can be restored in environments of identity `scene`. The error states the reason why
    /// not.
    pub(crate) fn check(&self, scene: &str) -> Result<(), String> {
        if self.format != FORMAT {
            return Err(format!("the snapshot has format {}; this version of tactus reads {FORMAT}", self.format));
        }
        if self.scene != scene {
            return Err(
                "the snapshot belongs to another scene: its task, objects, grasps, pads or backend differ".into()
            );
        }
        if self.checksum != self.sum() {
            return Err("the snapshot was changed or damaged: its checksum does not match; save it again".into());
        }
        Ok(())
    }

    fn sum(&self) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.scene.as_bytes());
        let EpisodeKey { seed, env, episode } = self.key;
        [u64::from(self.format), seed, env, episode].iter().for_each(|word| {
            hasher.update(&word.to_le_bytes());
        });
        hasher.update(&self.state);
        hasher.finalize().into()
    }
}
