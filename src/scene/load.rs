//! Loads a scene file with its includes: `path -> Scene`, or one error that shows the line and the allowed values.

use super::check;
use super::diagnose::Diagnosis;
use super::excerpt::truncate_name;
use super::field_positions::{FieldPositions, Origins, SceneText};
use super::include::{Loader, folder};
use super::objects::{Name, Split};
use super::schema::{NamedScene, Scene};
use super::source::{display_path, is_stream};
use base::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Scene with the files from which it was loaded.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Complete scene; its paths are relative to the current directory.
    pub scene: Scene,
    /// Path of the scene file.
    pub path: PathBuf,
    /// Folder of the scene file.
    pub dir: PathBuf,
    /// Paths of all files read: the scene file, then its includes.
    pub sources: Vec<PathBuf>,
    /// Positions of the fields in the files.
    places: Arc<FieldPositions>,
}

impl Loaded {
    /// Converts an error about a field of the scene into one that shows the position of the field; returns other errors
    /// unchanged.
    pub fn locate_error(&self, error: Error) -> Error {
        self.places.place(error, None)
    }
}

/// Converts an error about a field of the scene with this `text`, from the file at `path`, into one that shows the
/// position of the field; returns other errors unchanged.
pub fn locate_error_in(path: &Path, text: &str, error: Error) -> Error {
    let sources = vec![SceneText { path: path.to_path_buf(), text: text.into() }];
    FieldPositions { sources, origins: Origins::new(), listed: Vec::new() }.place(error, None)
}

/// All scenes of a file, one per object.
#[derive(Debug, Clone)]
pub struct LoadedSet {
    /// Scenes in the order of the file, at least one. Their paths are relative to the current directory.
    pub scenes: Vec<NamedScene>,
    /// Division of the grasps into training and test sets.
    pub split: Split,
    /// Flag: the objects were drawn at random; an object without grasps is then omitted from a data set.
    pub drawn: bool,
    /// Path of the scene file.
    pub path: PathBuf,
    /// Paths of all files read: the scene file, then its includes.
    pub sources: Vec<PathBuf>,
    /// Positions of the fields in the files.
    places: Arc<FieldPositions>,
}

/// Loads a scene file of one object.
///
/// # Errors
/// Returns an error ready to print if a file cannot be read, a value is refused or the file has several objects.
pub fn load(path: impl AsRef<Path>) -> Result<Loaded> {
    load_object(path, None)
}

/// Loads the scene of one object from a scene file; None selects the only object.
///
/// # Errors
/// Returns an error ready to print if a file cannot be read, a value is refused, no object has this name, or
/// the file has several objects and none is named.
pub fn load_object(path: impl AsRef<Path>, object: Option<&str>) -> Result<Loaded> {
    let mut set = load_set(path)?.retain_object(object)?;
    if set.scenes.len() > 1 {
        let message =
            format!("{}: has several objects; choose one with --object: {}", set.path.display(), set.listed_names());
        return Err(Error::Argument(message));
    }
    let scene = set.scenes.swap_remove(0).scene;
    Ok(Loaded { scene, dir: folder(&set.path), path: set.path, sources: set.sources, places: set.places })
}

impl LoadedSet {
    /// Keeps only the object of this name; None keeps all.
    ///
    /// # Errors
    /// Fails if no object has this name.
    pub fn retain_object(mut self, object: Option<&str>) -> Result<Self> {
        let Some(name) = object else { return Ok(self) };
        match self.scenes.iter().position(|s| s.name.as_str() == name) {
            Some(index) => {
                self.scenes = vec![self.scenes.swap_remove(index)];
                Ok(self)
            }
            None => self.scene_error(format!(
                "has no object {}; it has: {}",
                format_args!("{:?}", truncate_name(name)),
                self.listed_names()
            )),
        }
    }

    /// Converts an error about a field of the scene of the object `name` into one that shows the position of the field;
    /// returns other errors unchanged.
    pub fn locate_error(&self, error: Error, name: &Name) -> Error {
        self.places.place(error, Some(name))
    }

    /// Checks that both pads of every scene are equal, as `what` requires.
    ///
    /// # Errors
    /// Fails at the field of a pad that differs.
    pub fn require_equal_pads(&self, what: &str) -> Result<()> {
        let alike = |named: &NamedScene| {
            named.scene.gripper.require_equal_fingers(what).map_err(|e| self.locate_error(e, &named.name))
        };
        self.scenes.iter().try_for_each(alike)
    }

    /// Returns the names of the first 20 objects for a message.
    fn listed_names(&self) -> String {
        const MAX_LISTED: usize = 20;
        let mut names: Vec<_> = self.scenes.iter().take(MAX_LISTED).map(|s| s.name.as_str()).collect();
        if self.scenes.len() > MAX_LISTED {
            names.push("...");
        }
        names.join(", ")
    }

    fn scene_error<T>(&self, message: String) -> Result<T> {
        Err(Error::Scene(format!("error: {}: {message}", display_path(&self.path).display())))
    }
}

/// Loads all scenes of a file, one per object.
///
/// # Errors
/// Returns an error ready to print if a file cannot be read, a value is refused, a field is missing or fields
/// do not fit together.
pub fn load_set(path: impl AsRef<Path>) -> Result<LoadedSet> {
    load_seeded(path, None)
}

/// Loads all scenes of a file, one per object; if `seed` is given, it replaces the seed of the universe.
///
/// # Errors
/// Fails as [`load_set`] does, and if a seed is given for a scene without a universe.
pub fn load_seeded(path: impl AsRef<Path>, seed: Option<u64>) -> Result<LoadedSet> {
    let path = path.as_ref();
    let mut loader = Loader::default();
    let (mut part, origins) = loader.read_tree(path, &mut Vec::new(), None)?;
    match (seed, &mut part.universe) {
        (Some(seed), Some(universe)) => universe.seed = seed,
        (Some(_), None) => {
            return Err(Error::Argument("--seed is allowed only for a scene with a universe".into()));
        }
        (None, _) => {}
    }
    let listed = part.objects.iter().flatten().map(|e| (e.name.clone(), e.grasps.is_some())).collect();
    let places = FieldPositions { sources: loader.sources, origins, listed };
    let at = |problem: check::Problem| places.error_at(&problem.path, &problem.message);
    check::objects(&part, places.shared()).map_err(at)?;
    let (split, drawn) = (part.split.unwrap_or_default(), part.universe.is_some());
    let stem = path.file_stem().filter(|_| !is_stream(path)).map_or("stdin".into(), |stem| stem.to_string_lossy());
    let name = Name::near(&stem);
    let main = &places.sources[0];
    let scenes = part.complete(&name).map_err(|field| {
        let end = main.text.trim_end().len();
        let message = format!("missing field `{field}`\nevery scene has at least `object` and `loading`");
        main.error(&Diagnosis::new(&message, end.saturating_sub(1)..end))
    })?;
    for (i, named) in scenes.iter().enumerate() {
        check::check(&named.scene).map_err(|p| places.error_at(&places.path_in_file(&p.path, Some(i)), &p.message))?;
    }
    let sources = places.sources.iter().map(|s| s.path.clone()).collect();
    Ok(LoadedSet { scenes, split, drawn, path: path.to_path_buf(), sources, places: Arc::new(places) })
}
