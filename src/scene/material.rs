//! Material of the pads.

use super::defaults;
use super::leaf::{Modulus, Poisson, Positive};
use crate::robot::SoftPad;
use serde::de::{Deserializer, Error as _};
use serde::{Deserialize, Serialize, Serializer};

/// Soft material, given by law and constants or by the name of a preset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Material")]
pub enum MaterialChoice {
    /// Named material: `"gelsight_mini"`, `"tacgrasp"` or `"biotac"`.
    Preset(Preset),
    /// Compressible neo-Hookean material, given by E and nu.
    NeoHookean(Elastic),
    /// Compressible neo-Hookean material, given by C10 = mu / 2 and nu.
    NeoHookeanC10(ElasticC10),
    /// Corotated linear elasticity, given by E and nu: valid for large rotations and small strains.
    Corotational(Elastic),
    /// Linear elasticity, given by E and nu: valid for small rotations and small strains.
    Linear(Elastic),
}

impl Default for MaterialChoice {
    fn default() -> Self {
        MaterialChoice::Preset(Preset::GelSightMini)
    }
}

/// Constants of an isotropic elastic solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Elastic {
    /// Young's modulus E, Pa.
    pub young: Modulus,
    /// Poisson's ratio nu.
    pub poisson: Poisson,
    /// Density, kg/m3.
    #[serde(default = "defaults::gel_density")]
    pub density: Positive,
}

/// Constants of a neo-Hookean solid in the form reported by indentation tests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElasticC10 {
    /// C10, half the shear modulus, Pa.
    pub c10: Modulus,
    /// Poisson's ratio nu.
    pub poisson: Poisson,
    /// Density, kg/m3.
    #[serde(default = "defaults::gel_density")]
    pub density: Positive,
}

/// Named material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// `"gelsight_mini"`: neo-Hookean, C10 = 0.0725 MPa (E = 0.435 MPa if incompressible), nu 0.49; identified on the
    /// real sensor by FEATS.
    GelSightMini,
    /// `"tacgrasp"`: neo-Hookean, E 0.5 MPa, nu 0.4; in use with the tactile grasp data set.
    TacGrasp,
    /// `"biotac"`: neo-Hookean, E 1.552231 MPa, nu 0.316454.
    BioTac,
}

impl Preset {
    /// All presets.
    pub const ALL: [Preset; 3] = [Preset::GelSightMini, Preset::TacGrasp, Preset::BioTac];

    /// Returns the name in scene files.
    pub const fn name(self) -> &'static str {
        match self {
            Preset::GelSightMini => "gelsight_mini",
            Preset::TacGrasp => "tacgrasp",
            Preset::BioTac => "biotac",
        }
    }

    /// Returns the law and the constants.
    pub fn spec(self) -> MaterialSpec {
        let (young, poisson) = match self {
            Preset::GelSightMini => (young_of_c10(0.0725e6, 0.49), 0.49),
            Preset::TacGrasp => (0.5e6, 0.4),
            Preset::BioTac => (1.552231e6, 0.316454),
        };
        MaterialSpec { law: Law::NeoHookean, young, poisson, density: defaults::GEL_DENSITY.get() }
    }
}

impl Serialize for Preset {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Preset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Preset::ALL.into_iter().find(|p| p.name() == name).ok_or_else(|| {
            let names: Vec<_> = Preset::ALL.iter().map(|p| format!("{:?}", p.name())).collect();
            D::Error::custom(format!("unknown material preset {name:?}\nallowed: {}", names.join(", ")))
        })
    }
}

/// Constitutive law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Law {
    /// Compressible neo-Hookean.
    NeoHookean,
    /// Corotated linear.
    Corotational,
    /// Linear.
    Linear,
}

/// Material with its law and constants resolved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MaterialSpec {
    /// Constitutive law.
    pub law: Law,
    /// Young's modulus E, Pa.
    pub young: f64,
    /// Poisson's ratio nu.
    pub poisson: f64,
    /// Density, kg/m3.
    pub density: f64,
}

impl MaterialChoice {
    /// Returns the law and the constants.
    pub fn spec(self) -> MaterialSpec {
        let of = |law, e: Elastic| MaterialSpec {
            law,
            young: e.young.get(),
            poisson: e.poisson.get(),
            density: e.density.get(),
        };
        match self {
            MaterialChoice::Preset(preset) => preset.spec(),
            MaterialChoice::NeoHookean(e) => of(Law::NeoHookean, e),
            MaterialChoice::Corotational(e) => of(Law::Corotational, e),
            MaterialChoice::Linear(e) => of(Law::Linear, e),
            MaterialChoice::NeoHookeanC10(e) => MaterialSpec {
                law: Law::NeoHookean,
                young: young_of_c10(e.c10.get(), e.poisson.get()),
                poisson: e.poisson.get(),
                density: e.density.get(),
            },
        }
    }
}

impl MaterialChoice {
    /// Returns the material with the same law and density and other elastic constants: E, Pa, and Poisson's ratio.
    ///
    /// # Errors
    /// Fails if a constant is not allowed, with the message that a scene file would get.
    pub fn with(self, young: f64, poisson: f64) -> Result<Self, String> {
        let spec = self.spec();
        let elastic = Elastic {
            young: Modulus::new(young)?,
            poisson: Poisson::new(poisson)?,
            density: Positive::new(spec.density)?,
        };
        Ok(match spec.law {
            Law::NeoHookean => MaterialChoice::NeoHookean(elastic),
            Law::Corotational => MaterialChoice::Corotational(elastic),
            Law::Linear => MaterialChoice::Linear(elastic),
        })
    }
}

impl MaterialChoice {
    /// Returns the gel of a robot's pad: corotated linear elasticity, as in Isaac Gym.
    pub(super) fn of_robot(pad: &SoftPad) -> Result<Self, String> {
        Ok(MaterialChoice::Corotational(Elastic {
            young: Modulus::new(pad.young)?,
            poisson: Poisson::new(pad.poisson)?,
            density: pad.density.map_or(Ok(defaults::GEL_DENSITY), Positive::new)?,
        }))
    }
}

/// Computes E = 2 mu (1 + nu) with mu = 2 C10.
fn young_of_c10(c10: f64, poisson: f64) -> f64 {
    4.0 * c10 * (1.0 + poisson)
}
