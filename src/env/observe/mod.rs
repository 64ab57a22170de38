//! What an agent sees: one file per observation.
//!
//! To add one: a file with a [`Sense`] and what makes it, a line in `observations!`.

mod force;
mod grid;
mod object_pose;
mod taxels;
mod travel;
mod wrench;

pub use grid::Grid;

use super::spec::ArraySpec;
use crate::model::Model;
use crate::record::Frame;
use crate::scene::Task;
use serde::{Deserialize, Serialize};

/// What there is to see.
#[derive(Debug, Clone, Copy)]
pub struct Now<'a> {
    /// The scene of this episode.
    pub model: &'a Model,
    /// The state after the step.
    pub frame: &'a Frame,
}

/// Writes one array.
pub trait Sense: Send + Sync + std::fmt::Debug {
    /// The array.
    fn spec(&self) -> ArraySpec;
    /// Fills `out`, which has the size of the array.
    fn write(&self, now: &Now, out: &mut [f32]);
}

/// Declares [`Observe`]: the variant, its settings, the name of its array, what makes its sense.
macro_rules! observations {
    ($($(#[$doc:meta])* $variant:ident $(($settings:ty))?, $name:literal, $make:path;)*) => {
        /// An observation.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub enum Observe {
            $($(#[$doc])* $variant $(($settings))?,)*
        }

        impl Observe {
            /// Name of its array.
            pub fn name(&self) -> &'static str {
                match self {
                    $(observations!(@pattern $variant $(($settings))?) => $name,)*
                }
            }

            /// What writes it, for episodes of `task` in scenes with the pads of `model`.
            pub fn sense(&self, model: &Model, task: &Task) -> Box<dyn Sense> {
                match self {
                    $(observations!(@bind settings $variant $(($settings))?) =>
                        Box::new(observations!(@make $make, model, task, settings $(($settings))?)),)*
                }
            }
        }
    };
    (@pattern $variant:ident) => { Observe::$variant };
    (@pattern $variant:ident ($settings:ty)) => { Observe::$variant(_) };
    (@bind $settings:ident $variant:ident) => { Observe::$variant };
    (@bind $settings:ident $variant:ident ($type:ty)) => { Observe::$variant($settings) };
    (@make $make:path, $model:ident, $task:ident, $settings:ident) => { $make($model, $task) };
    (@make $make:path, $model:ident, $task:ident, $settings:ident ($type:ty)) => { $make($model, $task, $settings) };
}

observations! {
    /// Contact force on the pads as an image, N.
    TaxelForce(Grid), "taxel_force", taxels::ForceImage::new;
    /// Displacement of the sensing face as an image, m.
    TaxelDisplacement(Grid), "taxel_displacement", taxels::DisplacementImage::new;
    /// Force and torque on each pad.
    Wrench, "wrench", wrench::PadWrench::new;
    /// Travel of each finger since first contact, m.
    Travel, "travel", travel::FingerTravel::new;
    /// Pose of the object in the hand.
    ObjectPose, "object_pose", object_pose::PoseInHand::new;
    /// Force that closes the fingers, N.
    Force, "force", force::Applied::new;
}

impl Observe {
    /// What an agent sees unless said otherwise.
    pub const USUAL: [Observe; 4] =
        [Observe::TaxelForce(Grid::USUAL), Observe::Wrench, Observe::Travel, Observe::Force];
}

/// A contact carries at most this many times the largest force that the fingers are given.
const MOST: f64 = 10.0;

/// Bounds of a contact force, N.
fn force_bounds(task: &Task) -> [f64; 2] {
    let most = MOST * task.force.at(1.0);
    [-most, most]
}
