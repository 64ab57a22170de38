//! Parameters that may be fitted, and their ranges.

use super::Curve;
use base::error::{Error, Result};
use base::number::format_number;
use scene::leaf::{Modulus, NonNegative, Poisson};
use serde::Serialize;

/// Constant that can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameter {
    /// Young's modulus of the gel, Pa.
    Young,
    /// Poisson's ratio of the gel.
    Poisson,
    /// Coefficient of friction between gel and object.
    Friction,
    /// Offset of the depth: true depth of the pad where the table has depth zero, m.
    DepthZero,
}

/// Values of the parameters, in the order of [`Parameter::ALL`].
pub type ParameterValues = [f64; 4];

/// Largest upward shift of the depth zero, as a fraction of the smallest depth of the table, so that every depth stays
/// positive.
const MAX_SHIFT: f64 = 0.9;

impl Parameter {
    /// All parameters.
    pub const ALL: [Self; 4] = [Self::Young, Self::Poisson, Self::Friction, Self::DepthZero];

    /// Returns the name on the command line and in `fit.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Young => "young",
            Self::Poisson => "poisson",
            Self::Friction => "friction",
            Self::DepthZero => "depth_zero",
        }
    }

    /// Returns the name as used in a sentence.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Young => "Young's modulus",
            Self::Poisson => "Poisson's ratio",
            Self::Friction => "friction",
            Self::DepthZero => "the zero of depth",
        }
    }

    /// Returns symbol and unit for a table header, and the factor from SI to that unit.
    pub const fn shown_as(self) -> (&'static str, f64) {
        match self {
            Self::Young => ("E kPa", 1e-3),
            Self::Poisson => ("nu", 1.0),
            Self::Friction => ("friction", 1.0),
            Self::DepthZero => ("zero um", 1e6),
        }
    }

    /// Returns the default range, SI, which covers gels of optical tactile sensors.
    const fn default_range(self) -> [f64; 2] {
        match self {
            // From TacEx' GelSight Mini (0.1 MPa) to the users of the tactile grasp data set (0.5 MPa); FEATS
            // identified 0.43 MPa.
            Self::Young => [0.1e6, 0.5e6],
            // From the same users (0.4) to the largest that mean dilatation still resolves; FEATS' CalculiX takes
            // 0.475, silicone is near 0.49.
            Self::Poisson => [0.4, 0.499],
            // From a lubricated face to bare silicone on plastic.
            Self::Friction => [0.0, 1.0],
            // No published value: the error in detecting first contact, either way.
            Self::DepthZero => [-1e-4, 1e-4],
        }
    }

    /// Returns the reason why a scene cannot have this value, if any.
    fn invalid_reason(self, value: f64) -> Option<String> {
        match self {
            Self::Young => Modulus::new(value).err(),
            Self::Poisson => Poisson::new(value).err(),
            Self::Friction => NonNegative::new(value).err(),
            Self::DepthZero => (!value.is_finite()).then(|| "must be a finite number".into()),
        }
    }
}

/// Smallest and largest value of each parameter, SI, in the order of [`Parameter::ALL`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranges(pub [[f64; 2]; 4]);

impl Default for Ranges {
    fn default() -> Self {
        Self(Parameter::ALL.map(Parameter::default_range))
    }
}

impl Ranges {
    /// Sets the range `NAME=LOW,HIGH`, SI.
    ///
    /// # Errors
    /// Fails, with a message, for an unknown name, an entry that is not two numbers, or values that no scene can have.
    pub fn set(&mut self, text: &str) -> std::result::Result<(), String> {
        let known = || Parameter::ALL.map(Parameter::name).join(", ");
        let form = || format!("`{text}` is not NAME=LOW,HIGH with NAME one of {}", known());
        let (name, ends) = text.split_once('=').ok_or_else(form)?;
        let index = Parameter::ALL.iter().position(|p| p.name() == name.trim()).ok_or_else(form)?;
        let (low, high) = ends.split_once(',').ok_or_else(form)?;
        let ends = [low, high].map(|end| end.trim().parse::<f64>());
        let [Ok(low), Ok(high)] = ends else { return Err(form()) };
        if let Some(message) = [low, high].into_iter().find_map(|end| Parameter::ALL[index].invalid_reason(end)) {
            return Err(format!("{name}: {message}"));
        }
        if low >= high {
            return Err(format!("{name}: the first number is the minimum, the second the maximum"));
        }
        self.0[index] = [low, high];
        Ok(())
    }

    /// Returns the same ranges with the depth zero limited so that the first point of the table stays below the
    /// surface.
    pub(super) fn above_surface(&self, curve: &Curve) -> Self {
        let mut ranges = *self;
        let first = curve.points.first().map_or(f64::INFINITY, |p| p.0);
        let zero = &mut ranges.0[Parameter::DepthZero as usize];
        zero[0] = zero[0].max(-MAX_SHIFT * first);
        ranges
    }

    /// Checks that all values are within their ranges.
    pub(super) fn check(&self, values: &ParameterValues) -> Result<()> {
        for (p, (value, [low, high])) in Parameter::ALL.into_iter().zip(values.iter().zip(self.0)) {
            if !(low..=high).contains(value) {
                return Err(Error::Argument(format!(
                    "{} of the scene is {}, outside its range of {} to {}; give --range {}=LOW,HIGH",
                    p.words(),
                    format_number(*value),
                    format_number(low),
                    format_number(high),
                    p.name()
                )));
            }
        }
        Ok(())
    }

    /// Returns the positions of the free parameters within their ranges, 0 to 1.
    pub(super) fn units(&self, values: &ParameterValues, free: &[Parameter]) -> Vec<f64> {
        free.iter().map(|p| *p as usize).map(|i| (values[i] - self.0[i][0]) / self.width(i)).collect()
    }

    /// Returns `start` with the free parameters at the given fractions of their ranges.
    pub(super) fn values(&self, start: &ParameterValues, free: &[Parameter], units: &[f64]) -> ParameterValues {
        let mut values = *start;
        for (p, u) in free.iter().zip(units) {
            let i = *p as usize;
            values[i] = self.0[i][0] + u * self.width(i);
        }
        values
    }

    /// Returns the length of a range.
    pub(super) fn width(&self, index: usize) -> f64 {
        self.0[index][1] - self.0[index][0]
    }
}
