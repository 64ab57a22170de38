//! Loading of the grasp after first contact.

use super::defaults;
use super::dynamic::Dynamic;
use super::leaf::{Count, Length, Positive};
use super::vector::Vec3;
use serde::{Deserialize, Serialize};

/// Loading of a grasp, during which frames are recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Loading {
    /// Squeezing force raised from contact to `force`; frames are recorded at equal force steps.
    Squeeze(Squeeze),
    /// Pads moved by given distances after contact: tests on a fixed object.
    Press(Press),
    /// Motion of the hand in time, with inertia.
    Dynamic(Dynamic),
}

/// Force-controlled squeeze.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Squeeze {
    /// Final force, N: the SUM over the fingers of |normal force|, the convention of DefGraspSim. With two fingers each
    /// pad carries half of it (15 N is 7.5 N per pad); with `fingers: One` the single pad carries all of it.
    pub force: Positive,
    /// Force of the first frame, N; the frames are at equal force steps from there to `force`. None is one step of
    /// `frames` equal steps from zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Positive>,
    /// Force at which a free object is released, N: below it, the object is held in place and a support carries its
    /// weight. At most `force`. The default is the force at which the contact on each pad has grown from points to a
    /// patch (0.02 E t^2 per finger, with Young's modulus E and pad thickness t); for an object with weight, it is at
    /// least half of `force`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub release: Option<Positive>,
    /// Number of recorded frames: without `from`, frame k of n is at `force * k / n`, k = 1..=n.
    #[serde(default = "defaults::frames")]
    pub frames: Count<1, 10000>,
    /// Push applied to a free object after the squeeze, at the full `force`, in additional frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub push: Option<ObjectPush>,
}

/// Push on a squeezed object, raised in equal steps: frame k of n has the fraction k / n of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Push", deny_unknown_fields)]
pub struct ObjectPush {
    /// Force on the object's centre of mass, N, hand frame.
    #[serde(default = "defaults::push")]
    pub force: Vec3,
    /// Torque on the object, N m, hand frame, applied as couples of forces of fixed direction at points that move with
    /// the object.
    #[serde(default = "defaults::push")]
    pub torque: Vec3,
    /// Number of recorded frames of the push, after those of the squeeze.
    #[serde(default = "defaults::push_frames")]
    pub frames: Count<1, 10000>,
}

/// Displacement-controlled press: give `depth` (and `frames`) or `depths`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Press {
    /// Final travel of each finger after first contact of its pad, m.
    #[serde(default)]
    pub depth: Option<Length>,
    /// Number of recorded frames up to `depth`, at equal steps; [`defaults::FRAMES`] if not given.
    #[serde(default)]
    pub frames: Option<Count<1, 10000>>,
    /// Alternative to `depth`: increasing travels at which frames are recorded, m.
    #[serde(default)]
    pub depths: Option<Vec<Length>>,
}

impl Squeeze {
    /// Returns the total force at each recorded frame of the squeeze, N; the frames of the push, all at the last force,
    /// are not included.
    pub fn levels(&self) -> Vec<f64> {
        let (last, n) = (self.force.get(), self.frames.get());
        match self.from.map(Positive::get) {
            Some(first) if n > 1 => {
                let step = (last - first) / (n - 1) as f64;
                (0..n).map(|k| if k + 1 == n { last } else { first + step * k as f64 }).collect()
            }
            _ => steps(last, n),
        }
    }
}

impl ObjectPush {
    /// Returns the fraction of the push at each of its frames.
    pub fn push_fractions(&self) -> Vec<f64> {
        steps(1.0, self.frames.get())
    }
}

impl Press {
    /// Returns the travel after contact at each recorded frame, m.
    pub fn levels(&self) -> Vec<f64> {
        match (&self.depths, self.depth) {
            (Some(depths), _) => depths.iter().map(|d| d.get()).collect(),
            (None, Some(depth)) => steps(depth.get(), self.frames.unwrap_or(defaults::FRAMES).get()),
            // the loader refuses a press with neither
            (None, None) => Vec::new(),
        }
    }
}

impl Loading {
    /// Returns the load at each recorded frame: total force, N, travel after contact, m, or time, s.
    pub fn levels(&self) -> Vec<f64> {
        match self {
            Loading::Squeeze(squeeze) => squeeze.levels(),
            Loading::Press(press) => press.levels(),
            Loading::Dynamic(dynamic) => dynamic.times(),
        }
    }

    /// Sets the final force of a squeeze, the sum over the fingers, N.
    ///
    /// # Errors
    /// Returns a message for the user if the force is not allowed, or the loading is not a squeeze.
    pub fn set_force(&mut self, force: f64) -> Result<(), String> {
        let force = Positive::new(force).map_err(|m| format!("--force {m}"))?;
        match self {
            Loading::Squeeze(squeeze) => squeeze.force = force,
            Loading::Press(_) | Loading::Dynamic(_) => return Err("--force is allowed only for a squeeze".into()),
        }
        Ok(())
    }

    /// Sets the number of recorded frames; the final load is unchanged.
    ///
    /// # Errors
    /// Returns a message for the user if the number is not allowed, or the press has given `depths`.
    pub fn set_frames(&mut self, frames: u64) -> Result<(), String> {
        let frames = Count::new(frames).map_err(|m| format!("--frames {m}"))?;
        match self {
            Loading::Squeeze(squeeze) => squeeze.frames = frames,
            Loading::Press(press) if press.depths.is_some() => {
                return Err("--frames is not allowed for a press with `depths`".into());
            }
            Loading::Press(press) => press.frames = Some(frames),
            Loading::Dynamic(dynamic) => dynamic.frames = frames,
        }
        Ok(())
    }
}

/// Returns `n` levels at equal steps up to `last`, which is reached exactly.
fn steps(last: f64, n: usize) -> Vec<f64> {
    (1..=n).map(|k| if k == n { last } else { last * k as f64 / n as f64 }).collect()
}
