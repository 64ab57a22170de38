//! Observations of an agent, one file each; runs and data sets record those of tactile sensors.
//!
//! A new observation needs a variant in [`Observe`], a file with a [`SensorModel`], and a line each in `name` and
//! `sensor_model`.

mod center_of_pressure;
mod contact_area;
mod depth_map;
mod force;
mod force_image;
mod grid;
mod height_map;
mod markers;
mod object_pose;
mod prediction_error;
mod pressure;
mod shear;
mod slip;
mod spec;
mod taxel_displacement;
mod taxel_force;
mod travel;
mod wrench;

pub use spec::ArraySpec;

use crate::part::FingerModel;
use geometry::shape::Shape;
use record::{Frame, TactileArray};
use scene::Observe;

/// Hand from which the shapes and bounds of observation arrays are derived.
#[derive(Debug, Clone, Copy)]
pub struct SensorSetup<'a> {
    /// Fingers, left first, with equal pads.
    pub fingers: &'a [FingerModel],
    /// Largest travel of a finger, m.
    pub stroke: f64,
    /// Largest sum of the finger forces, N; infinite if unbounded.
    pub force: f64,
}

/// Input of an observation.
#[derive(Debug, Clone, Copy)]
pub struct SensorInput<'a> {
    /// Fingers, left first.
    pub fingers: &'a [FingerModel],
    /// Object.
    pub object: &'a Shape,
    /// State after the step.
    pub frame: &'a Frame,
}

/// Sensor model that writes one observation array.
pub trait SensorModel: Send + Sync + std::fmt::Debug {
    /// Returns the specification of the array.
    fn spec(&self) -> ArraySpec;
    /// Fills `out`, which has the size of the array.
    fn write(&self, now: &SensorInput, out: &mut [f32]);
    /// Returns the array as it is stored in files.
    fn record(&self, now: &SensorInput) -> TactileArray {
        let spec = self.spec();
        let mut values = vec![0.0; spec.size()];
        self.write(now, &mut values);
        TactileArray { name: spec.file_name(), unit: spec.unit, shape: spec.shape, values }
    }
}

/// Creates the sensor model of an observation.
pub fn sensor_model(observe: &Observe, hand: &SensorSetup) -> Box<dyn SensorModel> {
    match observe {
        Observe::TaxelForce(grid) => Box::new(taxel_force::TaxelForce::new(hand, grid)),
        Observe::TaxelDisplacement(grid) => Box::new(taxel_displacement::TaxelDisplacement::new(hand, grid)),
        Observe::Pressure(grid) => Box::new(pressure::Pressure::new(hand, grid)),
        Observe::Shear(grid) => Box::new(shear::Shear::new(hand, grid)),
        Observe::HeightMap(grid) => Box::new(height_map::HeightMap::new(hand, grid)),
        Observe::DepthMap(grid) => Box::new(depth_map::DepthMap::new(hand, grid)),
        Observe::Markers(markers) => Box::new(markers::MarkerTracks::new(hand, markers)),
        Observe::CenterOfPressure => Box::new(center_of_pressure::CenterOfPressure::new(hand)),
        Observe::ContactArea => Box::new(contact_area::TouchedArea::new(hand)),
        Observe::Slip(grid) => Box::new(slip::SlipImage::new(hand, grid)),
        Observe::Wrench => Box::new(wrench::PadWrench::new(hand)),
        Observe::Travel => Box::new(travel::FingerTravel::new(hand)),
        Observe::ObjectPose => Box::new(object_pose::PoseInHand::new(hand)),
        Observe::Force => Box::new(force::AppliedForce::new(hand)),
        Observe::PredictionError => Box::new(prediction_error::PredictionError::new(hand)),
    }
}

/// Bound of a contact force relative to the largest applied force.
const MAX_FORCE_RATIO: f64 = 10.0;

impl SensorSetup<'_> {
    /// Returns the bounds of a contact force, N.
    fn force_bounds(&self) -> [f64; 2] {
        let most = MAX_FORCE_RATIO * self.force;
        [-most, most]
    }

    /// Returns a bound of the distance of a deformed node from the centre of its sensing face along any axis, m.
    fn reach(&self) -> f64 {
        let rest = self.fingers.iter().flat_map(|f| &f.topology.rest);
        rest.map(|x| x.abs().max_element()).fold(0.0, f64::max) + self.displacement_bounds()[1]
    }

    /// Returns the bounds of a displacement, m: twice the thickness of the bonded gel.
    fn displacement_bounds(&self) -> [f64; 2] {
        let most = 2.0 * self.fingers.first().map_or(0.0, |f| f.topology.thickness());
        [-most, most]
    }
}
