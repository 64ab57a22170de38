//! Named gels, each with its source.

/// Elastic constants and density of a named gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GelPreset {
    /// Name used in scenes.
    pub name: &'static str,
    /// Young's modulus of the undeformed gel, Pa.
    pub young: f64,
    /// Poisson's ratio of the undeformed gel.
    pub poisson: f64,
    /// Density, kg/m3.
    pub density: f64,
    /// Source of the numbers.
    pub source: &'static str,
}

/// All presets.
pub const PRESETS: [GelPreset; 3] = [
    GelPreset {
        name: "gelsight_mini",
        // 4 C10 (1 + nu) with C10 = 0.0725 MPa.
        young: 432_100.0,
        poisson: 0.49,
        density: 1000.0,
        source: "FEATS (2024): C10 = 0.0725 MPa identified on the real sensor, nearly incompressible",
    },
    GelPreset {
        name: "tacgrasp",
        young: 5.0e5,
        poisson: 0.4,
        density: 1000.0,
        source: "values used with the tactile grasp data set of networks like DefGraspNets",
    },
    GelPreset {
        name: "biotac",
        young: 1.552_231e6,
        poisson: 0.316_454,
        density: 1000.0,
        source: "Narang et al. (2021): BioTac skin",
    },
];

/// The preset of this name, if there is one.
pub fn new_unchecked(name: &str) -> Option<GelPreset> {
    PRESETS.into_iter().find(|p| p.name == name)
}
