//! Simulated press with given constants; every simulation is cached.

use super::{Curve, Parameter, ParameterValues};
use backend::choose;
use base::error::{Error, Result};
use base::number::format_count;
use geometry::Pose;
use model::Model;
use model::grasp::grasp_poses;
use rayon::prelude::*;
use record::Status;
use scene::leaf::{Length, NonNegative};
use scene::{Field, Loading, Record, Scene, loading};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use world::Stepper;
use world::run::run_grasps;

/// Cache key: bits of Poisson's ratio, friction and depth zero. Young's modulus is absent because forces are
/// proportional to it, in all material laws and in the contact.
type Key = [u64; 3];

/// Press at the depths of a curve.
pub struct PressRuns<'a> {
    scene: Scene,
    stepper: Box<dyn Stepper>,
    pose: Pose,
    curve: &'a Curve,
    pool: rayon::ThreadPool,
    /// Forces with the scene's own Young's modulus, N; None if the press failed.
    known: Mutex<BTreeMap<Key, Option<Vec<f64>>>>,
}

impl<'a> PressRuns<'a> {
    /// Prepares the press of a scene; presses run in parallel on `threads` threads, one thread each.
    ///
    /// # Errors
    /// Fails for a scene that is not a press, that has several grasps or gravity, or whose pads differ.
    pub fn new(scene: &Scene, curve: &'a Curve, threads: usize) -> Result<Self> {
        scene.gripper.require_equal_fingers("a fit")?;
        let refused = |message: &str| Err(Error::Scene(format!("error: a fit {message}")));
        if !matches!(scene.loading, Loading::Press(_)) {
            return refused("needs a press; use loading: Press(depths: [...])");
        }
        if scene.gravity.is_some() {
            return refused("needs a gel without weight; leave `gravity` out");
        }
        let poses = grasp_poses(scene)?;
        let &[pose] = &poses[..] else {
            return refused(&format!("needs one press, and the scene has {}", format_count(poses.len(), "grasp")));
        };
        let mut scene = scene.clone();
        scene.clear_expectations();
        scene.record = Record {
            fields: vec![Field::ContactForce],
            pictures: false,
            arrays: None,
            vtu: false,
            tactile: Vec::new(),
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| Error::Start(format!("cannot start {threads} threads: {e}")))?;
        Ok(Self { stepper: choose(&scene)?, scene, pose, curve, pool, known: Mutex::default() })
    }

    /// Returns the scene's own values.
    pub fn start(&self) -> ParameterValues {
        let spec = self.scene.gripper.material.spec();
        [spec.young, spec.poisson, self.scene.gripper.friction.get(), 0.0]
    }

    /// Returns the pool in which presses run.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }

    /// Returns the number of simulations so far.
    pub fn simulations(&self) -> usize {
        self.known.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Returns, for each of `values`, the simulated over the measured force, minus one, at every point of the curve;
    /// None if the press fails.
    ///
    /// # Errors
    /// Fails if a model cannot be built or run.
    pub fn residuals(&self, values: &[ParameterValues]) -> Result<Vec<Option<Vec<f64>>>> {
        let missing: BTreeMap<Key, ParameterValues> = {
            let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            values.iter().map(|v| (key(v), *v)).filter(|(k, _)| !known.contains_key(k)).collect()
        };
        let missing: Vec<(Key, ParameterValues)> = missing.into_iter().collect();
        let run = |(key, values): &(Key, ParameterValues)| self.simulate(values).map(|forces| (*key, forces));
        let new: Vec<(Key, Option<Vec<f64>>)> =
            self.pool.install(|| missing.par_iter().map(run).collect::<Result<_>>())?;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.extend(new);
        let young = self.start()[Parameter::Young as usize];
        let of = |v: &ParameterValues| {
            let forces = known.get(&key(v)).cloned().flatten()?;
            let scale = v[Parameter::Young as usize] / young;
            Some(forces.iter().zip(&self.curve.points).map(|(f, (_, measured))| scale * f / measured - 1.0).collect())
        };
        Ok(values.iter().map(of).collect())
    }

    /// Returns the residuals at one set of values.
    ///
    /// # Errors
    /// Fails in the cases of [`Self::residuals`], and also if the press fails.
    pub fn residuals_of(&self, values: &ParameterValues) -> Result<Vec<f64>> {
        let of = self.residuals(&[*values])?.into_iter().flatten().next();
        of.ok_or_else(|| {
            Error::Solver("the press of the scene fails at the depths of the table; see `tactus run`".into())
        })
    }

    /// Simulates the forces at the depths of the curve with the scene's Young's modulus, N; returns None if the press
    /// fails.
    fn simulate(&self, [_, poisson, friction, zero]: &ParameterValues) -> Result<Option<Vec<f64>>> {
        let leaf = |message: String| Error::Start(format!("the press cannot be fitted: {message}"));
        let mut scene = self.scene.clone();
        let young = self.start()[Parameter::Young as usize];
        scene.gripper.material = scene.gripper.material.with(young, *poisson).map_err(leaf)?;
        scene.gripper.friction = NonNegative::new(*friction).map_err(leaf)?;
        let depths = self.curve.points.iter().map(|(d, _)| Length::new(d + zero));
        let depths = Some(depths.collect::<std::result::Result<_, _>>().map_err(leaf)?);
        scene.loading = Loading::Press(loading::Press { depth: None, frames: None, depths });
        let model = Model::build(&scene)?;
        let outcomes = run_grasps(&model, self.stepper.as_ref(), &[(0, self.pose)], 1, &())?;
        let whole = outcomes.into_iter().find(|o| o.summary.status == Status::Reached);
        Ok(whole.map(|o| o.measured.curve.iter().map(|(_, force)| *force).collect()))
    }
}

fn key(values: &ParameterValues) -> Key {
    let [_, poisson, friction, zero] = values.map(f64::to_bits);
    [poisson, friction, zero]
}
