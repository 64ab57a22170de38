//! Creation of a data set: simulates objects and their grasps in parallel, and resumes an interrupted run.

use super::arrays::{FORMAT, FileSizes};
use super::compatible::{LoaderFrame, sensor};
use super::file::{Writer, create};
use super::manifest::{ExcludedObject, MANIFEST_NAME, Manifest, ObjectEntry};
use super::plan::{PlannedObject, PlannedPads, Selection, plan_hash};
use super::progress::{self, FinishedGrasp, ProgressRecords};
use super::queue::longest_first;
use super::recorder::{DatasetObserver, DatasetRecorder};
use super::rows::Encoder;
use super::sensitivity::{self, SensitivityRow};
use super::split::Splits;
use base::error::{Error, Result};
use base::files::atomic::{cannot_write, create_dir, remove_temporary_files, sync_folder, write_durable};
use base::files::lock::{FolderLock, WriteLock};
use base::interrupt;
use geometry::mesh::io::{write_stl, write_tet};
use model::Model;
use model::grasp::write_grasps_h5;
use model::limits;
use rayon::prelude::*;
use scene::LoadedSet;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use world::StepperFactory;
use world::run::run_grasps;

/// Plan of all simulations of a data set, complete before the first simulation.
#[derive(Debug)]
pub struct Campaign {
    dir: PathBuf,
    objects: Vec<PlannedObject>,
    splits: Splits,
    manifest: Manifest,
    choose: StepperFactory,
}

impl Campaign {
    /// Plans a data set in `dir` with the backends that `choose` opens: loads or samples all grasps, and determines the
    /// content of every file.
    ///
    /// # Errors
    /// Fails if a scene cannot be built or the folder holds another data set.
    pub fn plan(set: &LoadedSet, dir: &Path, choose: StepperFactory) -> Result<Self> {
        Self::plan_selected(set, dir, choose, None)
    }

    /// Plans a data set that contains only the grasps chosen by `selection`.
    ///
    /// # Errors
    /// Fails as [`Campaign::plan`] does, and if a score cannot be computed.
    pub fn plan_selected(
        set: &LoadedSet,
        dir: &Path,
        choose: StepperFactory,
        selection: Option<&Selection>,
    ) -> Result<Self> {
        let first = set.scenes.first().ok_or_else(|| Error::Start("the scene has no object".into()))?;
        let pads = PlannedPads::of(&first.scene).map_err(|e| set.locate_error(e, &first.name))?;
        let planned = set.scenes.par_iter().map(|named| {
            interrupt::check()?;
            match PlannedObject::new(named, (&first.scene, &pads)) {
                Err(error) if set.drawn => Ok(Err(ExcludedObject::new(&named.name, &error))),
                planned => planned.map(Ok).map_err(|e| set.locate_error(e, &named.name)),
            }
        });
        let (mut objects, mut entries, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for planned in planned.collect::<Result<Vec<_>>>()? {
            match planned {
                Ok((object, entry)) => {
                    objects.push(object);
                    entries.push(entry);
                }
                Err(without) => left_out.push(without),
            }
        }
        selection.map_or(Ok(()), |selection| selection.apply(&mut objects, &mut entries))?;
        if objects.is_empty() {
            return Err(Error::Start("no sampled object has a grasp; sample more, or other objects".into()));
        }
        let counts: Vec<_> = objects.iter().map(|o| (o.named.name.as_str().to_string(), o.poses.len())).collect();
        let splits = Splits::new(&set.split, &counts);
        let manifest = Manifest {
            format: FORMAT,
            checksum: String::new(),
            tactus: env!("CARGO_PKG_VERSION").into(),
            finished: false,
            about: set.scenes.first().map(|s| s.scene.about.clone()).unwrap_or_default(),
            plan: plan_hash(objects.iter().map(|o| (&o.named, o.poses.as_slice())), &splits)?,
            grasps: objects.iter().map(|o| o.poses.len()).sum(),
            frames: pads.sizes.frames,
            bytes: 0,
            splits: String::new(),
            objects: entries,
            left_out,
        };
        let mut campaign = Self { dir: dir.to_path_buf(), objects, splits, manifest, choose };
        campaign.resume()?;
        Ok(campaign)
    }

    /// Adopts the manifest of an earlier run that finished; fails if the folder holds another plan.
    fn resume(&mut self) -> Result<()> {
        match Manifest::read(&self.dir)? {
            Some(earlier) if earlier.plan != self.manifest.plan => {
                let message = "contains another data set (its scene, grasps or version of tactus differ); \
                               choose another folder, or remove this one";
                Err(Error::file(&self.dir, message))
            }
            // Only this manifest holds the results of the finished grasps.
            Some(earlier) if earlier.finished => {
                let entry = |e: &ObjectEntry| (e.name.clone(), e.file.clone(), e.grasps);
                if !earlier.objects.iter().map(entry).eq(self.manifest.objects.iter().map(entry)) {
                    let message = "does not list the objects of its plan: it was changed or damaged; restore it from a \
                        copy, or remove the folder and generate the data set again";
                    return Err(Error::file(self.dir.join(MANIFEST_NAME), message));
                }
                self.manifest = earlier;
                Ok(())
            }
            // Everything else in an unfinished manifest follows from the plan.
            Some(_) | None => Ok(()),
        }
    }

    /// Returns the upper bound of the total size of all files, bytes.
    pub fn bytes(&self) -> u64 {
        self.objects.iter().map(|o| o.limit).fold(0, u64::saturating_add)
    }

    /// Fails if the part of the files that is not on the disk yet does not fit on it.
    fn check_disk(&self) -> Result<()> {
        let taken = |object: &PlannedObject| {
            let path = self.dir.join(&object.file);
            let there = [open(&path), path].iter().filter_map(|p| p.metadata().ok()).map(|m| allocated(&m)).max();
            there.unwrap_or(0)
        };
        let open = self.objects.iter().map(|o| o.limit.saturating_sub(taken(o))).fold(0, u64::saturating_add);
        limits::check_disk_space(open, &self.dir)
    }

    /// Returns the manifest: that of the finished data set on the disk, otherwise that of the plan.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns the number of grasps that are already finished.
    pub fn finished(&self) -> usize {
        if self.manifest.finished {
            return self.manifest.grasps;
        }
        self.objects.iter().map(|o| self.progress(o).finished(o.poses.len()).len()).sum()
    }

    /// Checks that the backend supports the first object, before anything is written.
    fn admit(&self) -> Result<()> {
        let Some(PlannedObject { named, .. }) = self.objects.first() else { return Ok(()) };
        (self.choose)(&named.scene)?.check_support(&Model::build(&named.scene)?)
    }

    /// Runs the unfinished grasps on `threads` threads, and completes the data set.
    ///
    /// # Errors
    /// Fails if a file cannot be written, a model cannot be built or the folder is in use. A failed grasp is part of
    /// the data set, not an error.
    pub fn run(&mut self, threads: usize, watcher: &dyn DatasetObserver) -> Result<Manifest> {
        if !self.manifest.finished {
            self.check_disk()?;
            self.admit()?;
        }
        // Held while this campaign writes, so that no two processes write to the same folder.
        let lock = FolderLock::exclusive(&self.dir, COMMAND)?;
        lock.notice().iter().for_each(|notice| watcher.notice(notice));
        self.resume()?;
        if !self.manifest.finished {
            self.manifest.write(&self.dir)?;
            let finished = longest_first(&self.expected_work(), threads, |index, threads| {
                self.object(&self.objects[index], index == 0, threads, watcher)
            })?;
            self.manifest
                .objects
                .iter_mut()
                .zip(finished)
                .for_each(|(entry, finished)| entry.add_results(finished.values()));
            let text = serde_json::to_string(&self.splits).map_err(|e| Error::file(&self.dir, e.to_string()))?;
            let text = text + "\n";
            write_durable(&self.dir.join("splits.json"), text.as_bytes())?;
            self.manifest.splits = blake3::hash(text.as_bytes()).to_hex().to_string();
            for (entry, object) in self.manifest.objects.iter_mut().zip(&self.objects) {
                let path = self.dir.join(&entry.file);
                (entry.bytes, entry.blake3) = (size(&path)?, super::set::hash(&path)?);
                entry.seal = Some(Writer::open(&path, &object.sizes)?.remainder_checksum()?);
            }
            self.manifest.bytes = self.manifest.objects.iter().map(|o| o.bytes).sum();
            self.manifest.finished = true;
            self.manifest.write(&self.dir)?;
        }
        progress::remove(&self.dir.join(PROGRESS))?;
        // These temporary files are not part of the data set; a failure to remove them is not an error.
        let _ = std::fs::remove_file(self.dir.join(LAYOUT_LOCK));
        remove_temporary_files(&self.dir.join("dgs_output"));
        self.objects.iter().for_each(|object| remove_temporary_files(&self.loader_folder(object)));
        Ok(self.manifest.clone())
    }

    /// Measures the sensitivity of the first `most` grasps of each object, on `threads` threads. Returns one row per
    /// change of a grasp, including those of an earlier run.
    ///
    /// # Errors
    /// Fails if a file cannot be written, a model cannot be built or the folder is in use.
    pub fn sensitivity(&self, most: usize, threads: usize) -> Result<Vec<SensitivityRow>> {
        let _lock = FolderLock::exclusive(&self.dir, COMMAND)?;
        let plan = self.manifest.plan.as_str();
        let mut table = sensitivity::read(&self.dir, plan)?;
        for object in &self.objects {
            interrupt::check()?;
            let poses = &object.poses[..most.min(object.poses.len())];
            sensitivity::measure((&self.dir, plan), &mut table, (&object.named, poses), self.choose, threads)?;
        }
        Ok(table)
    }

    /// Returns the folder of an object's files for the public loader.
    fn loader_folder(&self, object: &PlannedObject) -> PathBuf {
        self.dir.join("dgn_dataset").join(object.named.name.as_str())
    }

    fn progress(&self, object: &PlannedObject) -> ProgressRecords {
        ProgressRecords::of(self.dir.join(PROGRESS).join(object.named.name.as_str()))
    }

    /// Runs the unfinished grasps of a part on `threads` threads, concurrently with the other parts, on one machine or
    /// on several that share the folder. Part `part` (from 0) of `parts` consists of every `parts`th grasp.
    /// [`Campaign::run`] then finds all grasps finished and completes the data set. The files do not depend on the
    /// division into parts. Returns the number of grasps that ran.
    ///
    /// # Errors
    /// Fails in the cases of [`Campaign::run`].
    pub fn run_part(
        mut self,
        part: usize,
        parts: usize,
        threads: usize,
        watcher: &dyn DatasetObserver,
    ) -> Result<usize> {
        if self.manifest.finished {
            return Ok(0);
        }
        self.check_disk()?;
        self.admit()?;
        let lock = FolderLock::shared(&self.dir, COMMAND)?;
        lock.notice().iter().for_each(|notice| watcher.notice(notice));
        self.resume()?;
        let turn = self.lock_shared_files()?;
        self.manifest.write(&self.dir)?;
        drop(turn);
        let ran = longest_first(&self.expected_work(), threads, |index, threads| {
            self.simulate(&self.objects[index], index == 0, |grasp| grasp % parts == part, threads, watcher)
        })?;
        Ok(ran.into_iter().sum())
    }

    /// Returns the expected work of each object: grasps x frames x nodes.
    fn expected_work(&self) -> Vec<u64> {
        let of = |FileSizes { grasps, frames, nodes, .. }: &FileSizes| (grasps * frames * nodes) as u64;
        self.objects.iter().map(|object| of(&object.sizes)).collect()
    }

    /// Runs the unfinished grasps of one object, and renames its file to the final name.
    fn object(
        &self,
        object: &PlannedObject,
        first: bool,
        threads: usize,
        watcher: &dyn DatasetObserver,
    ) -> Result<BTreeMap<usize, FinishedGrasp>> {
        let path = self.dir.join(&object.file);
        let rename = |from: &Path, to: &Path| std::fs::rename(from, to).map_err(|e| cannot_write(to, &e));
        // The renaming is the last step: a file with its final name is complete unless it was damaged later.
        if path.exists() && !self.is_complete(object, &path) {
            rename(&path, &open(&path))?;
        }
        if !path.exists() {
            self.simulate(object, first, |_| true, threads, watcher)?;
            rename(&open(&path), &path)?;
            sync_folder(&path);
        }
        let finished = self.progress(object).finished(object.poses.len());
        if finished.len() < object.poses.len() {
            return Err(Error::file(
                &path,
                "records of its grasps are missing; run the same `tactus dataset` command again",
            ));
        }
        Ok(finished)
    }

    /// Returns true if the file at `path` has the layout of the object and intact rows of all its grasps.
    fn is_complete(&self, object: &PlannedObject, path: &Path) -> bool {
        let Ok(writer) = Writer::open(path, &object.sizes) else { return false };
        let sound = self.intact_grasps(object, &writer);
        sound.len() == object.poses.len() && self.has_layout(object, path)
    }

    /// Returns true if the file at `path` has the layout of the object, regardless of its rows.
    fn has_layout(&self, object: &PlannedObject, path: &Path) -> bool {
        let layout = Writer::open(path, &object.sizes).and_then(|writer| writer.layout());
        layout.is_ok_and(|layout| self.progress(object).layout() == Some(self.layout_record(&layout)))
    }

    /// Returns the record of a layout. It contains the plan, so that a layout of another plan is not recognised.
    fn layout_record(&self, layout: &str) -> String {
        format!("{} {layout}", self.manifest.plan)
    }

    /// Returns the grasps whose records and rows are intact.
    fn intact_grasps(&self, object: &PlannedObject, writer: &Writer) -> BTreeMap<usize, FinishedGrasp> {
        let finished = self.progress(object).finished(object.poses.len());
        finished.into_par_iter().filter(|(_, record)| writer.rows_match(record)).collect()
    }

    /// Runs the unfinished ones among the `wanted` grasps of an object; returns their number.
    fn simulate(
        &self,
        object: &PlannedObject,
        first: bool,
        wanted: impl Fn(usize) -> bool,
        threads: usize,
        watcher: &dyn DatasetObserver,
    ) -> Result<usize> {
        let progress = self.progress(object);
        let path = self.dir.join(&object.file);
        if path.exists() {
            return Ok(0);
        }
        interrupt::check()?;
        let scene = &object.named.scene;
        let model = Model::build(scene)?;
        let recorded =
            if scene.finer_mesh().is_some() { Model::build(&scene.without_finer_mesh())? } else { model.clone() };
        let world = LoaderFrame::new(&scene.gripper.placement);
        let encoder = Encoder::new(&recorded, object.sizes.clone(), world);
        self.lay_out(object, &recorded, encoder.mirrored, first)?;
        let writer = Writer::open(&open(&path), &object.sizes)?;
        let done = self.intact_grasps(object, &writer);
        let open_grasps = (0..object.poses.len()).filter(|g| wanted(*g) && !done.contains_key(g));
        let grasps: Vec<_> = open_grasps.map(|g| (g, object.poses[g])).collect();
        let stepper = (self.choose)(scene)?;
        let recorder = DatasetRecorder::new(
            &object.named,
            &object.poses,
            [&model, &recorded],
            (encoder, writer),
            &progress,
            watcher,
        );
        run_grasps(&model, stepper.as_ref(), &grasps, threads, &recorder)?;
        Ok(grasps.len())
    }

    /// Waits until no other part writes the files that all parts share. Otherwise a part that starts at the same time
    /// could rename a half-written file.
    fn lock_shared_files(&self) -> Result<WriteLock> {
        WriteLock::acquire(&self.dir.join(LAYOUT_LOCK), COMMAND)
    }

    /// Writes the files of one object, with empty rows, unless they exist. One part does this while the others wait.
    fn lay_out(&self, object: &PlannedObject, model: &Model, mirrored: bool, first: bool) -> Result<()> {
        let _turn = self.lock_shared_files()?;
        let open = open(&self.dir.join(&object.file));
        if !open.exists() || !self.has_layout(object, &open) {
            let name = object.named.name.as_str();
            let about = self.loader_folder(object);
            create_dir(&about)?;
            let pad = sensor(&model.finger()?.topology);
            if first {
                write_tet(self.dir.join("tactile_sensor.tet"), &pad)?;
            } else if object.own_pads {
                write_tet(about.join(format!("{name}_sensor.tet")), &pad)?;
            }
            write_stl(about.join(format!("{name}_processed.stl")), &model.object.surface)?;
            write_grasps_h5(about.join(format!("{name}_grasps.h5")), &object.poses)?;
            create_dir(&self.dir.join("dgs_output"))?;
            // Records of finished grasps are invalid without the file with their rows.
            self.progress(object).clear()?;
            create(&open, &object.named, model, &object.sizes, mirrored)?;
            let layout = Writer::open(&open, &object.sizes)?.layout()?;
            self.progress(object).record_layout(&self.layout_record(&layout))?;
        }
        Ok(())
    }
}

/// Returns the disk space that a file occupies, bytes; rows that have not been written may occupy none.
fn allocated(meta: &std::fs::Metadata) -> u64 {
    #[cfg(unix)]
    return std::os::unix::fs::MetadataExt::blocks(meta) * 512;
    #[cfg(not(unix))]
    return meta.len();
}

/// Returns the path of an object's file while grasps are unfinished.
pub(super) fn open(path: &Path) -> PathBuf {
    path.with_extension("h5.open")
}

/// Name of the folder with the records of finished grasps.
pub(super) const PROGRESS: &str = ".progress";
/// Name of the command that locks the folder.
const COMMAND: &str = "tactus dataset";
/// File that is locked while the manifest is written and an object's files are laid out.
const LAYOUT_LOCK: &str = ".laying_out";

fn size(path: &Path) -> Result<u64> {
    let meta = std::fs::metadata(path).map_err(|e| Error::system(path, format!("cannot be read: {e}"), e.kind()))?;
    Ok(meta.len())
}
