//! Configurations of a comparison: finite-element settings around those of the scene, and networks.

use super::density::{coarser, describe, nodes};
use base::error::{Error, Result};
use model::accuracy;
use scene::leaf::Positive;
use scene::{Condensed, Element, Fem, Field, Fingers, Gnn, Loading, Pads, Scene, Solver, StepperChoice};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::path::{Path, PathBuf};

/// Configuration that simulates the grasps of the scene.
#[derive(Debug, Clone)]
pub struct Configuration {
    /// Name in tables and charts.
    pub label: String,
    /// Scene with the settings of this configuration.
    pub scene: Scene,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// True for a network or a fast mode, whose speed-up over full finite elements at equal error is reported.
    pub contender: bool,
}

/// Setting of the finite elements, and the cell widths at which it is evaluated, relative to those of the scene.
struct Setting {
    name: &'static str,
    /// Change from the default: 10-node tetrahedra with mean dilatation and the full pad model.
    change: fn(&mut Fem),
    cells: &'static [f64],
    /// True for a fast mode, whose speed-up is reported as for a network.
    fast: bool,
}

/// All settings.
const SETTINGS: [Setting; 4] = [
    Setting { name: "quadratic", change: |_| (), cells: &[2.0, SQRT_2, 1.0, FRAC_1_SQRT_2], fast: false },
    Setting {
        name: "linear",
        change: |fem| fem.element = Element::Linear,
        cells: &[SQRT_2, 1.0, FRAC_1_SQRT_2, 0.5],
        fast: false,
    },
    Setting { name: "quadratic, 10 x tolerance", change: loosen, cells: &[SQRT_2, 1.0], fast: false },
    Setting {
        name: "condensed",
        change: |fem| fem.solver = Solver::Condensed(Condensed::default()),
        cells: &[SQRT_2, 1.0, FRAC_1_SQRT_2],
        fast: true,
    },
];

/// Sets ten times the force tolerance.
fn loosen(fem: &mut Fem) {
    // The result is positive; only an overflow is invalid.
    if let Ok(force) = Positive::new(10.0 * fem.tolerance.force.get()) {
        fem.tolerance.force = force;
    }
}

/// Generator of the configurations of a scene.
#[derive(Debug)]
pub struct Sweep {
    /// Scene that records the compared fields and has no expectations.
    pub scene: Scene,
    /// Settings from which all configurations start.
    pub fem: Fem,
    made: Vec<(Configuration, Fem)>,
}

impl Sweep {
    /// Creates a sweep around the settings of `scene`. The compared fields are recorded; the expectations of the scene
    /// are removed, because evaluating them takes time.
    ///
    /// # Errors
    /// Fails if the scene has no pads, pads that differ, or dynamic loading.
    pub fn new(scene: &Scene) -> Result<Self> {
        if scene.gripper.fingers == Fingers::None {
            return Err(Error::Start("a bench compares pads, and the scene has none (`fingers: None`)".into()));
        }
        if matches!(scene.loading, Loading::Dynamic(_)) {
            return Err(Error::Start(
                "a bench supports `Squeeze` and `Press`; the scene's loading is `Dynamic`".into(),
            ));
        }
        scene.gripper.require_equal_fingers("a bench")?;
        let mut scene = accuracy::with_chosen_mesh(scene)?;
        scene.clear_expectations();
        for field in [Field::Displacement, Field::Stress] {
            if !scene.record.fields.contains(&field) {
                scene.record.fields.push(field);
            }
        }
        let fem = match scene.stepper {
            StepperChoice::Fem(Fem { tolerance, path, max_iterations, .. }) => {
                Fem { tolerance, path, max_iterations, ..Fem::default() }
            }
            StepperChoice::Gnn(_) => Fem::default(),
        };
        Ok(Self { scene, fem, made: Vec::new() })
    }

    /// Returns all configurations. Settings that result in equal meshes occur once.
    ///
    /// # Errors
    /// Fails if a pad cannot be meshed.
    pub fn configurations(mut self, models: &[PathBuf]) -> Result<Vec<Configuration>> {
        for setting in &SETTINGS {
            let mut fem = self.fem;
            (setting.change)(&mut fem);
            for factor in self.cells(setting) {
                let new = self.configuration(setting.name, coarser(&self.scene.gripper.pads, *factor)?, fem)?;
                self.add(Configuration { contender: setting.fast, ..new }, fem);
            }
        }
        let networks = models.iter().map(|model| self.network(model)).collect::<Result<Vec<_>>>()?;
        Ok(self.made.into_iter().map(|(c, _)| c).chain(networks).collect())
    }

    /// Returns the configuration of a network on the pads of the scene.
    fn network(&self, folder: &Path) -> Result<Configuration> {
        let scene = Scene { stepper: StepperChoice::Gnn(Gnn::new(folder)), ..self.scene.clone() };
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy();
        let label = format!("network {name}");
        // Network scenes have the default element.
        let nodes = nodes(&scene.gripper.pads, Element::default())?;
        Ok(Configuration { label, scene, nodes, contender: true })
    }

    /// Returns the relative cell widths at which a setting is evaluated; a pad from a file has only its own mesh.
    fn cells(&self, setting: &Setting) -> &'static [f64] {
        if self.refinable() { setting.cells } else { &[1.0] }
    }

    /// Returns true if the pads of the scene can be meshed with finer and coarser cells.
    pub fn refinable(&self) -> bool {
        !matches!(self.scene.gripper.pads, Pads::File(_))
    }

    fn add(&mut self, new: Configuration, fem: Fem) {
        // Spacings are rounded to whole cells, so two of them may result in the same mesh.
        if !self.made.iter().any(|(c, f)| *f == fem && c.nodes == new.nodes) {
            self.made.push((new, fem));
        }
    }

    /// Returns the scene with other pads and settings as a configuration.
    ///
    /// # Errors
    /// Fails if a pad cannot be meshed.
    pub fn configuration(&self, name: &str, pads: Pads, fem: Fem) -> Result<Configuration> {
        let nodes = nodes(&pads, fem.element)?;
        let label = format!("{name} {}", describe(&pads));
        let mut scene = self.scene.clone();
        (scene.gripper.pads, scene.stepper) = (pads, StepperChoice::Fem(fem));
        Ok(Configuration { label, scene, nodes, contender: false })
    }
}
