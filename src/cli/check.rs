//! Command `tactus check`: checks a scene, shows it with defaults and includes, and shows what would run.

use super::console::Console;
use super::findings::{Found, TRIED};
use super::run::about_object;
use super::{Format, OK, REFUSED};
use crate::backend::choose;
use crate::backend::fem::condensed::nodes_at_contact;
use crate::error::{Error, Result};
use crate::geometry::mesh::io::{write_obj, write_stl};
use crate::grasp::{aim_notice, grasps_of, write_grasps_h5};
use crate::gripper::Hand;
use crate::gripper::hand::HandPart;
use crate::limits::machine_threads;
use crate::model::Model;
use crate::number::counted;
use crate::run::effort::expected_seconds;
use crate::scene::{self, Scene, load_set, to_ron};
use crate::world::components::{FingerIndex, FingerTravel, ObjectPose};
use crate::world::environment::Environment;
use crate::world::schedule::Phase;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `tactus check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Object to take from a scene with several; without it all are checked, one after the other.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Write the object's surface (`.obj`, `.stl`, metres) or the grasps (`.h5`, as DefGraspSim's) to this file.
    #[arg(long, value_name = "FILE")]
    pub export: Option<PathBuf>,
    /// Form of the output.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Loads the scene, builds everything that a run would build, closes every grasp to first contact, and prints the findings. The text form
/// is the complete scene, with the findings as comments: it loads as the same scene. Several objects are printed one after the other;
/// their JSON is one object with the list `objects`.
///
/// # Errors
/// Fails if the scene or an argument is refused, or a file cannot be written.
pub fn check(args: &CheckArgs, console: &dyn Console) -> Result<u8> {
    let set = load_set(&args.scene)?.only(args.object.as_deref())?;
    let several = set.scenes.len() > 1;
    if several && args.export.is_some() {
        return Err(Error::Argument("--export writes one object; choose it with --object".into()));
    }
    let (mut runs, mut objects, mut errors) = (true, Vec::new(), Vec::new());
    for named in set.scenes.iter().take(EXAMINED) {
        let (scene, name) = (&named.scene, named.name.as_str());
        let found = examine(scene).map_err(|e| set.place(e, &named.name));
        let mut json = match &found {
            Ok(found) if args.format == Format::Json => found.json(scene, &set.sources),
            Ok(_) => Value::Null,
            // A reader of JSON wants the reason on stdout, too.
            Err(error) => json!({"scene": scene, "sources": set.sources, "problems": [error.to_string()]}),
        };
        if args.format == Format::Json && several {
            json["name"] = json!(name);
            objects.push(json);
        } else if args.format == Format::Json {
            console.print(&format!("{json}\n"))?;
        } else if let Ok(found) = &found {
            let head = if several { format!("// object {name}\n") } else { String::new() };
            let foot = if several { "\n" } else { "" };
            console.print(&format!("{head}{}{}{}{foot}", found.overview(), to_ron(scene)?, found.details()))?;
        }
        match found {
            Ok(found) => {
                runs &= found.runs;
                args.export.as_ref().map_or(Ok(()), |path| export(path, &found))?;
            }
            Err(error) if several => errors.push(about_object(name, &error).to_string()),
            Err(error) => return Err(error),
        }
    }
    let more = set.scenes.len().saturating_sub(EXAMINED);
    if several && args.format == Format::Json {
        console.print(&format!("{}\n", json!({ "objects": objects, "more": more })))?;
    } else if more > 0 {
        console.print(&format!("// and {}, not examined: choose one with --object\n", counted(more, "more object")))?;
    }
    if !errors.is_empty() {
        return Err(Error::Scene(errors.join("\n")));
    }
    Ok(if runs { OK } else { REFUSED })
}

/// Writes the export that the file's name asks for.
fn export(path: &Path, found: &Found) -> Result<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("obj") => write_obj(path, &found.model.object.surface),
        Some("stl") => write_stl(path, &found.model.object.surface),
        Some("h5") => write_grasps_h5(path, &found.poses),
        _ => Err(Error::file(path, "cannot be exported to; allowed: a file name that ends in .obj, .stl or .h5")),
    }
}

/// Largest number of objects of a scene that are examined: a check answers within seconds.
const EXAMINED: usize = 50;
fn examine(scene: &Scene) -> Result<Found> {
    let stepper = choose(scene)?;
    // First, as it refuses what is too large.
    let model = Model::build(scene)?;
    let grasps = grasps_of(scene)?;
    let poses = grasps.poses;
    let first = poses.first().ok_or_else(|| Error::Start("the scene has no grasp".into()))?;
    let mut environment = Environment::new(&model, stepper.as_ref(), *first)?;
    let systems = environment.systems().into_iter().map(|(set, names)| (format!("{set:?}").to_lowercase(), names));
    let mut found = Found {
        systems: systems.collect(),
        components: environment.components().into_iter().collect(),
        unknowns: model.unknowns(),
        poses: poses.clone(),
        notices: grasps.notices,
        problems: Vec::new(),
        expected: expected_seconds(scene, &model, poses.len(), machine_threads()),
        runs: false,
        model: model.clone(),
    };
    found.notices.extend(stepper.notices(&model));
    let pad = model.pad_bounds();
    found.notices.extend(pad.and_then(|pad| aim_notice(scene, &model.object, pad, &poses)));
    let hand = pad.map(|pad| Hand::new(pad, &scene.gripper));
    for (index, pose) in poses.iter().enumerate().take(TRIED) {
        // Only pads are simulated, so this is to be known and no problem.
        let part = hand.as_ref().and_then(|h| h.obstacle(model.object.distance.as_ref(), pose, 0.0, 0.0));
        if let Some(part @ (HandPart::Palm | HandPart::Finger)) = part {
            let part = part.name();
            found.notices.push(format!("grasp {index}: the {part} of a real hand would collide with the object"));
        }
        environment.restart(stepper.as_ref(), *pose)?;
        while matches!(environment.phase(), Phase::Place | Phase::Close) {
            environment.step();
        }
        match environment.phase() {
            Phase::Infeasible { reason } => found.problems.push(format!("grasp {index}: {reason}")),
            _ if !std::mem::replace(&mut found.runs, true) => found.condense(scene, index, &mut environment),
            _ => {}
        }
    }
    Ok(found)
}

impl Found {
    /// Adds the unknowns of condensed pads, which only a grasp at first contact has.
    fn condense(&mut self, scene: &Scene, grasp: usize, environment: &mut Environment) {
        let scene::StepperChoice::Fem(scene::Fem { solver: scene::Solver::Condensed(_), .. }) = scene.stepper else {
            return;
        };
        let world = environment.world_mut();
        let mut travel = vec![0.0; self.model.fingers.len()];
        let mut fingers = world.query::<(&FingerIndex, &FingerTravel)>();
        fingers.iter(world).for_each(|(i, t)| travel[i.0 as usize] = t.0);
        let mut poses = world.query::<&ObjectPose>();
        let Some(pose) = poses.iter(world).next() else { return };
        let full = std::mem::take(&mut self.unknowns.pads);
        self.unknowns.pads = nodes_at_contact(&self.model, pose, &travel).into_iter().map(|n| 3 * n).collect();
        self.unknowns.total -= full.iter().sum::<usize>() - self.unknowns.pads.iter().sum::<usize>();
        self.notices.push(format!(
            "unknowns are those of grasp {grasp} at first contact and grow with it; {} of the pads are condensed",
            full.iter().sum::<usize>()
        ));
    }
}
