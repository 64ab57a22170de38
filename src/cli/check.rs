//! Command `tactus check`: checks a scene without simulating it, and prints it with includes and defaults written out,
//! together with the properties of its run.

use super::console::Console;
use super::findings::{MAX_GRASPS, SceneFindings};
use super::output::{EXIT_ERROR, EXIT_OK, Format};
use super::plausible::implausible;
use super::run::with_object_name;
use backend::choose;
use backend::fem::condensed::nodes_at_contact;
use base::error::{Error, Result};
use base::machine::machine_threads;
use base::number::format_count;
use geometry::Pose;
use geometry::mesh::io::{write_obj, write_stl};
use model::grasp::{aim_notice, resolve_grasps, write_grasps_h5};
use model::gripper::Hand;
use model::gripper::hand::HandPart;
use model::{Model, Unknowns};
use net::linear_response::first_contact::GeometricContact;
use rayon::prelude::*;
use scene::{self, Grasps, NamedScene, Scene, load_set, to_ron};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use world::environment::Environment;
use world::run::expected_time::ExpectedTime;

/// Arguments of `tactus check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Scene file; `-` is standard input.
    pub scene: PathBuf,
    /// Object to check if the scene has several; the default is all of them, one after the other.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Write the surface of the object (`.obj` or `.stl`, metres) or the grasps (`.h5`, in the format of DefGraspSim)
    /// to this file.
    #[arg(long, value_name = "FILE")]
    pub export: Option<PathBuf>,
    /// Format of the output.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Loads the scene, builds all data of a run, closes its grasps (at most 1000 of each object, at most 50 objects) to
/// first contact geometrically, without a solver, and prints the findings to `console`. The text output is the complete
/// scene with the findings as comments, and can be loaded as the same scene; problems are at the end. Several objects
/// are printed one after the other; in JSON they are the list `objects` of one JSON object. Returns the exit code: 0 if
/// each examined object has a grasp that can start, otherwise 2.
///
/// # Errors
/// Fails if the scene or an argument is invalid, or a file cannot be written.
pub fn check(args: &CheckArgs, console: &dyn Console) -> Result<u8> {
    let set = load_set(&args.scene)?.retain_object(args.object.as_deref())?;
    let several = set.scenes.len() > 1;
    if several && args.export.is_some() {
        return Err(Error::Argument("--export writes one object; choose it with --object".into()));
    }
    let (mut runs, mut objects, mut errors, mut problems) = (true, Vec::new(), Vec::new(), String::new());
    let examined = &set.scenes[..set.scenes.len().min(MAX_OBJECTS)];
    // Chunks of one object per thread limit the memory, because each object has its own pads.
    for chunk in examined.chunks(machine_threads()) {
        let found = chunk
            .par_iter()
            .map(|named| (named, check_scene(&named.scene).map_err(|e| set.locate_error(e, &named.name))));
        for (NamedScene { name, scene, .. }, found) in found.collect::<Vec<_>>() {
            let name = name.as_str();
            let mut json = match &found {
                Ok(found) if args.format == Format::Json => found.json(scene, &set.sources),
                Ok(_) => Value::Null,
                // In JSON, the reason is also on stdout.
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
                let details = found.details(console.is_verbose());
                console.print(&format!("{head}{}{}{details}{foot}", found.overview(), to_ron(scene)?))?;
                problems += &found.problem_lines(several.then_some(name));
            }
            match found {
                Ok(found) => {
                    runs &= found.started > 0;
                    args.export.as_ref().map_or(Ok(()), |path| export(path, &found))?;
                }
                Err(error) if several => errors.push(with_object_name(name, &error).to_string()),
                Err(error) => return Err(error),
            }
        }
    }
    let more = set.scenes.len() - examined.len();
    if several && args.format == Format::Json {
        console.print(&format!("{}\n", json!({ "objects": objects, "more": more })))?;
    } else if more > 0 {
        console.print(&format!(
            "// and {} that were not checked: choose one with --object\n",
            format_count(more, "more object")
        ))?;
    }
    console.print(&problems)?;
    if !errors.is_empty() {
        return Err(Error::Scene(errors.join("\n")));
    }
    Ok(if runs { EXIT_OK } else { EXIT_ERROR })
}

/// Writes the export in the format that the extension of the file name selects.
fn export(path: &Path, found: &SceneFindings) -> Result<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("obj") => write_obj(path, &found.model.object.surface),
        Some("stl") => write_stl(path, &found.model.object.surface),
        Some("h5") => write_grasps_h5(path, &found.poses),
        _ => Err(Error::file(path, "cannot be exported to; allowed: a file name that ends in .obj, .stl or .h5")),
    }
}

/// Largest number of objects of a scene that are examined, so that a check takes seconds.
const MAX_OBJECTS: usize = 50;

/// Builds what a run of `scene` would build, and closes its grasps to first contact. Nothing is factorised and no
/// network is evaluated.
fn check_scene(scene: &Scene) -> Result<SceneFindings> {
    let stepper = choose(scene)?;
    // The model is built before the grasps because it rejects scenes that are too large.
    let model = Model::build(scene)?;
    let grasps = resolve_grasps(scene)?;
    let poses = grasps.poses;
    let first = poses.first().ok_or_else(|| Error::Start("the scene has no grasp".into()))?;
    let environment = Environment::new(&model, stepper.as_ref(), *first)?;
    let systems = environment.systems().into_iter().map(|(set, names)| (format!("{set:?}").to_lowercase(), names));
    let tried = &poses[..poses.len().min(MAX_GRASPS)];
    let contacts: Vec<_> = tried.par_iter().map(|pose| GeometricContact::find(&model, *pose)).collect();
    let expected = ExpectedTime::of(scene, &model, poses.len(), machine_threads());
    let (mut unknowns, mut notices, mut problems) = (model.unknowns(), grasps.notices, Vec::new());
    if let Some((grasp, contact)) = contacts.iter().enumerate().find_map(|(i, c)| Some((i, c.as_ref().ok()?))) {
        notices.extend(condensed(scene, &model, contact, &mut unknowns).map(|whole| {
            format!(
                "the number of unknowns is that of grasp {grasp} at first contact and increases with the contact \
                area; {whole} unknowns of the pads are condensed"
            )
        }));
        problems.extend(implausible(scene, &model, &poses[grasp], &expected));
    }
    let mut found = SceneFindings {
        systems: systems.collect(),
        components: environment.components().into_iter().collect(),
        expected,
        unknowns,
        notices,
        problems,
        started: contacts.iter().filter(|contact| contact.is_ok()).count(),
        model: model.clone(),
        poses,
    };
    found.notices.extend(stepper.notices(&model));
    let pad = model.pad_bounds();
    found.notices.extend(pad.and_then(|pad| aim_notice(scene, &model.object, pad, &found.poses)));
    // Sampled grasps are free of collisions with the hand by construction. For others a collision is a notice and not a
    // problem, because only the pads are simulated.
    let hand = pad.filter(|_| !matches!(scene.grasps, Grasps::Antipodal(_))).map(|pad| Hand::new(pad, &scene.gripper));
    let distance = model.object.distance.as_ref();
    let met = |(grasp, pose): (usize, &Pose)| match hand.as_ref()?.first_collision(distance, pose, 0.0, 0.0)? {
        part @ (HandPart::Palm | HandPart::Finger) => {
            Some(format!("grasp {grasp}: the {} of a real hand would collide with the object", part.name()))
        }
        _ => None,
    };
    let met: Vec<String> = found.poses[..contacts.len()].par_iter().enumerate().filter_map(met).collect();
    found.notices.extend(met);
    let unfit = contacts.iter().enumerate().filter_map(|(grasp, contact)| Some((grasp, contact.as_ref().err()?)));
    found.problems.extend(unfit.map(|(grasp, reason)| format!("grasp {grasp}: {reason}")));
    Ok(found)
}

/// Replaces the numbers of `unknowns` of condensed pads by those at first contact of a grasp, on which they depend.
/// Returns the number of unknowns of the full pads; None if the pads are not condensed.
fn condensed(scene: &Scene, model: &Model, contact: &GeometricContact, unknowns: &mut Unknowns) -> Option<usize> {
    let scene::StepperChoice::Fem(scene::Fem { solver: scene::Solver::Condensed(_), .. }) = scene.stepper else {
        return None;
    };
    let nodes = nodes_at_contact(model, &contact.object, &contact.travel);
    let whole = unknowns.pads.iter().sum::<usize>();
    unknowns.pads = nodes.into_iter().map(|n| 3 * n).collect();
    unknowns.total -= whole - unknowns.pads.iter().sum::<usize>();
    Some(whole)
}
