//! Reads a scene file with its includes: `path -> Scene`, or one error that shows the line and says what is allowed.

use super::bonding::BondingRule;
use super::check;
use super::diagnose::{Diagnosis, clipped, explain};
use super::grasps::Grasps;
use super::gripper::Gripper;
use super::lint::lint;
use super::object::{Object, ObjectShape};
use super::objects::{Name, NamedScene, Split};
use super::outline::{Outline, VALUE_LIMIT};
use super::pad::Pads;
use super::schema::{Scene, ScenePart};
use super::source::{self, SIZE_LIMIT};
use super::stepper::{SHIPPED_MODELS, StepperChoice};
use crate::error::{Error, Result};
use crate::files::regular::other_kind;
use crate::robot::mount;
use ron::extensions::Extensions;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest chain of includes.
pub const INCLUDE_DEPTH: usize = 16;
/// Largest number of files that one scene may read: includes that include each other's includes multiply.
pub const INCLUDE_FILES: usize = 256;

/// Scene with the files that it came from.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Complete scene; its paths are valid from the current directory.
    pub scene: Scene,
    /// Path of the scene file.
    pub path: PathBuf,
    /// Folder of the scene file.
    pub dir: PathBuf,
    /// Paths of all files read: the scene file, then its includes.
    pub sources: Vec<PathBuf>,
    /// Positions of the fields in the files.
    places: Arc<Places>,
}

impl Loaded {
    /// Turns an error about a field of the scene into one that shows the place of the field; returns other errors
    /// unchanged.
    pub fn place(&self, error: Error) -> Error {
        self.places.place(error, None)
    }
}

/// All scenes of a file, one per object.
#[derive(Debug, Clone)]
pub struct LoadedSet {
    /// Scenes in the order of the file, at least one. Their paths are valid from the current directory.
    pub scenes: Vec<NamedScene>,
    /// Division of the poses into training and test.
    pub split: Split,
    /// Flag: the objects were drawn; one without grasps is left out of a data set.
    pub drawn: bool,
    /// Path of the scene file.
    pub path: PathBuf,
    /// Paths of all files read: the scene file, then its includes.
    pub sources: Vec<PathBuf>,
    /// Positions of the fields in the files.
    places: Arc<Places>,
}

/// Loads a scene file of one object.
///
/// # Errors
/// Returns an [`Error::Scene`] ready to print if a file cannot be read, a value is refused or the file has several
/// objects.
pub fn load(path: impl AsRef<Path>) -> Result<Loaded> {
    load_object(path, None)
}

/// Loads the scene of one object from a scene file; None stands for the only object.
///
/// # Errors
/// Returns an [`Error::Scene`] ready to print if a file cannot be read, a value is refused, no object has this name, or
/// the file has several objects and none is named.
pub fn load_object(path: impl AsRef<Path>, object: Option<&str>) -> Result<Loaded> {
    let mut set = load_set(path)?.only(object)?;
    if set.scenes.len() > 1 {
        return set.refuse(format!("has several objects; choose one with --object: {}", set.names()));
    }
    let scene = set.scenes.swap_remove(0).scene;
    Ok(Loaded { scene, dir: folder(&set.path), path: set.path, sources: set.sources, places: set.places })
}

impl LoadedSet {
    /// Keeps the object of this name; None keeps all.
    ///
    /// # Errors
    /// Fails if no object has this name.
    pub fn only(mut self, object: Option<&str>) -> Result<Self> {
        let Some(name) = object else { return Ok(self) };
        match self.scenes.iter().position(|s| s.name.as_str() == name) {
            Some(index) => {
                self.scenes = vec![self.scenes.swap_remove(index)];
                Ok(self)
            }
            None => {
                self.refuse(format!("has no object {}; it has: {}", format_args!("{:?}", clipped(name)), self.names()))
            }
        }
    }

    /// Turns an error about a field of the scene of the object `name` into one that shows the place of the field; returns other errors
    /// unchanged.
    pub fn place(&self, error: Error, name: &Name) -> Error {
        self.places.place(error, Some(name))
    }

    /// Returns the names of the objects for a message, at most the first 20.
    fn names(&self) -> String {
        const SHOWN: usize = 20;
        let mut names: Vec<_> = self.scenes.iter().take(SHOWN).map(|s| s.name.as_str()).collect();
        if self.scenes.len() > SHOWN {
            names.push("...");
        }
        names.join(", ")
    }

    fn refuse<T>(&self, message: String) -> Result<T> {
        Err(Error::Scene(format!("error: {}: {message}", self.path.display())))
    }
}

/// Loads all scenes of a file, one per object.
///
/// # Errors
/// Returns an [`Error::Scene`] ready to print if a file cannot be read, a value is refused, a field is missing or fields
/// do not fit together.
pub fn load_set(path: impl AsRef<Path>) -> Result<LoadedSet> {
    load_seeded(path, None)
}

/// Loads all scenes of a file, one per object; a universe is drawn with `seed` if that is given.
///
/// # Errors
/// Fails as [`load_set`] does, and for a seed of a scene that draws nothing.
pub fn load_seeded(path: impl AsRef<Path>, seed: Option<u64>) -> Result<LoadedSet> {
    let path = path.as_ref();
    let mut loader = Loader::default();
    let (mut part, origins) = loader.tree(path, &mut Vec::new(), None)?;
    match (seed, &mut part.universe) {
        (Some(seed), Some(universe)) => universe.seed = seed,
        (Some(_), None) => {
            return Err(Error::Scene("error: --seed is for a scene with a universe; this one draws nothing".into()));
        }
        (None, _) => {}
    }
    let listed = part.objects.iter().flatten().map(|e| (e.name.clone(), e.grasps.is_some())).collect();
    let places = Places { sources: loader.sources, origins, listed };
    let at = |problem: check::Problem| places.error_at(&problem.path, &problem.message);
    check::objects(&part, places.shared()).map_err(at)?;
    let (split, drawn) = (part.split.unwrap_or_default(), part.universe.is_some());
    let name = Name::near(&path.file_stem().unwrap_or_default().to_string_lossy());
    let main = &places.sources[0];
    let scenes = part.complete(&name).map_err(|field| {
        let end = main.text.trim_end().len();
        let message = format!("missing field `{field}`\nevery scene has at least `object` and `loading`");
        main.error(&Diagnosis::new(&message, end.saturating_sub(1)..end))
    })?;
    for (i, named) in scenes.iter().enumerate() {
        check::check(&named.scene).map_err(|p| places.error_at(&places.written(&p.path, Some(i)), &p.message))?;
    }
    let sources = places.sources.iter().map(|s| s.path.clone()).collect();
    Ok(LoadedSet { scenes, split, drawn, path: path.to_path_buf(), sources, places: Arc::new(places) })
}

/// Positions of the fields in the files of a scene.
#[derive(Debug)]
struct Places {
    sources: Vec<Source>,
    origins: Origins,
    /// Names of the listed objects, each with true if it has grasps of its own; empty if the scene has one object.
    listed: Vec<(Name, bool)>,
}

impl Places {
    fn place(&self, error: Error, name: Option<&Name>) -> Error {
        let Error::Field { field, source } = error else { return error };
        let index = name.and_then(|name| self.listed.iter().position(|(own, _)| own == name));
        let text = source.to_string();
        self.error_at(&self.written(field, index), text.strip_prefix("error: ").unwrap_or(&text))
    }

    /// Returns the path of a field as the file has it: an object and its grasps may stand in the list of objects.
    fn written(&self, field: &str, index: Option<usize>) -> String {
        let listed = index.and_then(|i| Some((i, self.listed.get(i)?.1)));
        match listed {
            _ if self.origins.contains_key("universe") && !field.starts_with("universe") => "universe".into(),
            Some((i, own)) if field.starts_with("object.") || (own && field.starts_with("grasps")) => {
                format!("objects[{i}].{field}")
            }
            _ => field.to_string(),
        }
    }

    /// Returns an error at a field, in the file that gives it.
    fn error_at(&self, field: &str, message: &str) -> Error {
        let first = field.split(['.', '[']).next().unwrap_or("");
        self.sources[self.origins.get(first).copied().unwrap_or(0)].error_at(field, message)
    }

    /// Returns the number of bytes of all files outside the list of objects.
    fn shared(&self) -> usize {
        let listed = self.origins.get("objects").map_or(0, |at| self.sources[*at].length("objects"));
        self.sources.iter().map(|s| s.text.len()).sum::<usize>() - listed
    }
}

/// Reads the text of one scene file.
fn parse(text: &str) -> std::result::Result<ScenePart, ron::error::SpannedError> {
    options().from_str(text)
}

/// Returns the RON dialect of scene files, for reading and writing: `Some` is implied, `Sphere(radius: 1)` needs no
/// double parentheses.
pub fn options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Returns the scene as a RON text that loads as the same scene, with all defaults written out.
///
/// # Errors
/// Fails if the scene cannot be written as RON.
pub fn to_ron(scene: &Scene) -> Result<String> {
    let pretty = ron::ser::PrettyConfig::new().indentor("    ").compact_arrays(true);
    options()
        .to_string_pretty(scene, pretty)
        .map(|text| format!("{text}\n"))
        .map_err(|e| Error::Scene(format!("error: the scene cannot be written as RON: {e}")))
}

/// Reads a scene that [`to_ron`] wrote; its paths are kept unchanged.
///
/// # Errors
/// Fails if the text is not a complete scene.
pub fn from_ron(text: &str) -> Result<Scene> {
    complete(parse(text).map_err(|e| Error::Scene(format!("error: no scene: {e}")))?)
}

/// Reads the scene of a `run.json`; its paths are kept unchanged.
///
/// # Errors
/// Fails if the value is not a complete scene.
pub fn from_json(value: &serde_json::Value) -> Result<Scene> {
    complete(ScenePart::deserialize(value).map_err(|e| Error::Scene(format!("error: no scene: {e}")))?)
}

fn complete(part: ScenePart) -> Result<Scene> {
    let mut scenes = part
        .complete(&Name::near("scene"))
        .map_err(|field| Error::Scene(format!("error: no complete scene: missing field `{field}`")))?;
    scenes.iter().try_for_each(|named| recheck(&named.scene))?;
    Ok(scenes.swap_remove(0).scene)
}

/// Checks a complete scene once more, after a change.
///
/// # Errors
/// Fails if a field does not fit the rest.
pub fn recheck(scene: &Scene) -> Result<()> {
    check::check(scene).map_err(|p| Error::Scene(format!("error: {}: {}", p.path, p.message)))
}

#[derive(Debug)]
struct Source {
    path: PathBuf,
    text: String,
}

impl Source {
    fn error(&self, diagnosis: &Diagnosis) -> Error {
        Error::Scene(diagnosis.render(&self.path, &self.text))
    }

    /// Returns the length of the value of a field of this file, bytes.
    fn length(&self, field: &str) -> usize {
        Outline::of(&self.text).find(field).map_or(0, |e| e.value.len())
    }

    /// Returns an error at a field of this file, named in the message.
    fn error_at(&self, field: &str, message: &str) -> Error {
        let span = Outline::of(&self.text).find(field).map_or(0..0, |e| e.value.clone());
        self.error(&Diagnosis::new(&format!("{field}: {message}"), span))
    }
}

/// Index of the source that gave each field.
type Origins = BTreeMap<&'static str, usize>;

#[derive(Default)]
struct Loader {
    sources: Vec<Source>,
}

impl Loader {
    /// Reads the file with all that it includes. `chain` holds the files being read, outermost first.
    fn tree(
        &mut self,
        path: &Path,
        chain: &mut Vec<PathBuf>,
        from: Option<(usize, usize)>,
    ) -> Result<(ScenePart, Origins)> {
        let text = match (source::read(path), from) {
            (Ok(text), _) => text,
            (Err(e), None) => return Err(e),
            (Err(e), Some((parent, place))) => {
                let message = e.to_string().trim_start_matches("error: ").to_string();
                return Err(self.sources[parent].error_at(&format!("include[{place}]"), &message));
            }
        };
        let index = self.sources.len();
        if self.sources.iter().map(|s| s.text.len()).sum::<usize>() + text.len() > SIZE_LIMIT as usize {
            let message =
                format!("{} and the files before it are together larger than {} MiB", path.display(), SIZE_LIMIT >> 20);
            return Err(Error::Scene(format!("error: {message}, the limit for a scene")));
        }
        self.sources.push(Source { path: path.to_path_buf(), text });
        let source = &self.sources[index];
        let mut own = read_part(source)?;
        let dir = folder(path);
        resolve_paths(&mut own, &dir, &source.text).map_err(|(field, message)| source.error_at(&field, &message))?;

        chain.push(path.canonicalize().unwrap_or_else(|_| path.to_path_buf()));
        let (mut whole, mut origins) = (ScenePart::default(), Origins::new());
        for (i, name) in std::mem::take(&mut own.include).iter().enumerate() {
            let included = dir.join(name);
            self.may_include(&included, chain)
                .map_err(|m| self.sources[index].error_at(&format!("include[{i}]"), &m))?;
            let (part, theirs) = self.tree(&included, chain, Some((index, i)))?;
            whole.take_over(part);
            origins.extend(theirs);
        }
        chain.pop();
        origins.extend(own.given().into_iter().map(|field| (field, index)));
        whole.take_over(own);
        Ok((whole, origins))
    }

    fn may_include(&self, path: &Path, chain: &[PathBuf]) -> std::result::Result<(), String> {
        let show = |chain: &[PathBuf]| {
            let names: Vec<_> = chain.iter().map(|p| p.file_name().unwrap_or_default().to_string_lossy()).collect();
            names.join(" -> ")
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if let Ok(canonical) = path.canonicalize()
            && let Some(first) = chain.iter().position(|p| *p == canonical)
        {
            return Err(format!("the files include each other in a circle: {} -> {name}", show(&chain[first..])));
        }
        if chain.len() > INCLUDE_DEPTH {
            return Err(format!("includes are nested more than {INCLUDE_DEPTH} deep: {} -> {name}", show(chain)));
        }
        if self.sources.len() >= INCLUDE_FILES {
            return Err(format!("the scene includes more than {INCLUDE_FILES} files"));
        }
        Ok(())
    }
}

/// Reads one file, not its includes.
fn read_part(source: &Source) -> Result<ScenePart> {
    let outline = Outline::of(&source.text);
    if outline.is_empty() {
        let message = "the scene is empty\na smallest scene: (object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 15))";
        return Err(source.error(&Diagnosis::new(message, 0..0)));
    }
    if outline.is_full() {
        let message = format!(
            "the scene holds more than {VALUE_LIMIT} values, the limit for a scene file\nlong lists of grasps go into a file: grasps: File(\"x_grasps.h5\")"
        );
        return Err(source.error(&Diagnosis::new(&message, 0..0)));
    }
    let part = parse(&source.text).map_err(|e| source.error(&explain(&e, &source.text, &outline)))?;
    lint(&source.text, &outline).map_err(|d| source.error(&d))?;
    Ok(part)
}

/// Resolves paths from the folder of the file that names them, refuses those that lead nowhere, and takes over what the descriptions of
/// robots say.
fn resolve_paths(part: &mut ScenePart, dir: &Path, text: &str) -> std::result::Result<(), (String, String)> {
    let file = |path: &mut PathBuf, field: String| {
        *path = dir.join(&*path);
        match path.metadata() {
            Ok(meta) => match other_kind(&meta) {
                Some(kind) => Err((field, format!("{} is {kind}, not a file", path.display()))),
                None => Ok(()),
            },
            Err(_) => {
                Err((field, format!("no file at {}\npaths start at the folder of the scene file", path.display())))
            }
        }
    };
    let object = |object: &mut Object, field: &str| match &mut object.shape {
        ObjectShape::Mesh(path) => file(path, format!("{field}.shape")),
        _ => Ok(()),
    };
    let grasps = |grasps: &mut Grasps, field: &str| match grasps {
        Grasps::File(grasps) => file(&mut grasps.path, format!("{field}.path")),
        _ => Ok(()),
    };
    let pads = |pads: &mut Pads, field: String| {
        let Pads::File(pad) = pads else { return Ok(()) };
        file(&mut pad.path, format!("{field}.path"))?;
        match &mut pad.bonded {
            BondingRule::NearMesh(mesh) => file(&mut mesh.path, format!("{field}.bonded.path")),
            BondingRule::NodesFile(path) => file(path, format!("{field}.bonded")),
            BondingRule::Plane(_) | BondingRule::Nodes(_) => Ok(()),
        }
    };
    let gripper = |gripper: &mut Gripper, field: &str| {
        pads(&mut gripper.pads, format!("{field}.pads"))?;
        if let Some(own) = gripper.right.as_mut().and_then(|right| right.pads.as_mut()) {
            pads(own, format!("{field}.right.pads"))?;
        }
        let Some(mut robot) = gripper.robot.take() else { return Ok(()) };
        file(&mut robot.path, format!("{field}.robot.path"))?;
        let outline = Outline::of(text);
        let given = |name: &&&str| {
            let field = format!("{field}.{name}");
            outline.find(&field).is_some_and(|entry| outline.path(entry) == field)
        };
        let twice = |names: &[&str]| match names.iter().find(given) {
            Some(name) => {
                let message = format!("the robot says what the {name} is; leave one of them out");
                Err((format!("{field}.{name}"), message))
            }
            None => Ok(()),
        };
        twice(&["opening", "stroke", "placement"])?;
        let pads = [robot.pads.0.as_str(), robot.pads.1.as_str()];
        let mounted = mount(&robot.path, &robot.hand, pads, robot.approach.vector());
        if let Ok((_, Some(_))) = &mounted {
            twice(&["pads", "material", "right.pads", "right.material"])?;
        }
        let taken = mounted.and_then(|(mount, soft)| gripper.take_over(&mount, soft));
        taken.map_err(|message| (format!("{field}.robot"), format!("{}: {message}", robot.path.display())))
    };
    part.object.as_mut().map_or(Ok(()), |o| object(o, "object"))?;
    part.grasps.as_mut().map_or(Ok(()), |g| grasps(g, "grasps"))?;
    part.gripper.as_mut().map_or(Ok(()), |g| gripper(g, "gripper"))?;
    for (i, entry) in part.objects.iter_mut().flatten().enumerate() {
        object(&mut entry.object, &format!("objects[{i}].object"))?;
        entry.grasps.as_mut().map_or(Ok(()), |g| grasps(g, &format!("objects[{i}].grasps")))?;
        entry.gripper.as_mut().map_or(Ok(()), |g| gripper(g, &format!("objects[{i}].gripper")))?;
    }
    if let Some(StepperChoice::Gnn(gnn)) = &mut part.stepper {
        // whether there is a model is for the engine to say
        if !SHIPPED_MODELS.iter().any(|name| gnn.model.as_os_str() == *name) {
            gnn.model = dir.join(&gnn.model);
        }
    }
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    path.parent().map(Path::to_path_buf).unwrap_or_default()
}
