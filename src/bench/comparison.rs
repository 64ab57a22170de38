//! Comparison of all configurations on the same grasps. Repetitions are interleaved, so that other load on the machine
//! affects all configurations alike.

pub use super::entry::{BenchEntry, PreparedConfiguration, add_stages};
use super::refinement_study::{self, PairDistances, RefinementStudy, Role, StudyMember};
use super::report::BenchReport;
pub use super::settings::ComparisonSettings;
use super::sweep::Sweep;
use super::values::{FrameValues, values};
use base::error::{Error, Result};
use geometry::Pose;
use model::Model;
use model::grasp::grasp_poses;
use record::error_norm::{Fields, Points};
use scene::Scene;
use std::path::PathBuf;

/// Compares the settings around those of `scene` and the networks in `models`; `progress` is called for every
/// simulation.
///
/// # Errors
/// Fails if the scene is not supported by a bench or cannot be built, a network rejects it, or the reference completes
/// no grasp.
pub fn compare(
    scene: &Scene,
    models: &[PathBuf],
    settings: &ComparisonSettings,
    mut progress: impl FnMut(&str),
) -> Result<BenchReport> {
    let sweep = Sweep::new(scene)?;
    let mut run = RefinementRun::new(&sweep, settings)?;
    let mut entries: Vec<BenchEntry> = sweep.configurations(models)?.into_iter().map(BenchEntry::new).collect();
    let mut grasps = sample(&grasp_poses(scene)?, settings.grasps);
    if let Some((_, pose)) = grasps.first() {
        // In order of size, because memory that the allocator keeps from one configuration is reused by the next.
        let mut all: Vec<&mut BenchEntry> = entries.iter_mut().chain([run.reference()]).collect();
        all.sort_by_key(|e| e.configuration.nodes);
        for entry in all {
            progress(&format!("memory: {}", entry.configuration.label));
            entry.measure_memory(*pose)?;
        }
    }
    for turn in 0..settings.repeats {
        let mut lost = Vec::new();
        for (index, pose) in &grasps {
            let mut truth = Vec::new();
            if turn == 0 {
                match run.grasp(*index, *pose, &mut progress)?.into_iter().find(|s| s.role == Role::Reference) {
                    Some(step) => truth = step.fields,
                    None => {
                        lost.push(*index);
                        continue;
                    }
                }
            }
            for entry in &mut entries {
                progress(&format!(
                    "repetition {} of {}, grasp {index}: {}",
                    turn + 1,
                    settings.repeats,
                    entry.configuration.label
                ));
                let own = entry.run(&run.pool, *index, *pose, &run.points)?;
                entry.add_errors(&run.points, &own, &truth);
            }
        }
        grasps.retain(|(index, _)| !lost.contains(index));
    }
    if grasps.is_empty() {
        return Err(Error::Solver(format!("the reference failed for all grasps: {}", run.notices.join("; "))));
    }
    let numbers = grasps.iter().map(|(index, _)| *index).collect();
    let (study, notices) = (run.results(), std::mem::take(&mut run.notices));
    Ok(BenchReport::new(settings, numbers, (run.reference(), study), &entries, notices))
}

/// Result of a member of the mesh refinement study for a grasp.
#[derive(Debug)]
pub struct MemberResult {
    /// Role of the member.
    pub role: Role,
    /// Fields of its frames at the common points; empty if it failed.
    pub fields: Vec<Fields>,
    /// Values of its last frame.
    pub values: FrameValues,
}

/// Members of the mesh refinement study, with their distances accumulated over the grasps.
#[derive(Debug)]
pub struct RefinementRun {
    members: Vec<(Role, BenchEntry)>,
    reference: usize,
    pairs: PairDistances,
    /// Points at which fields are compared.
    pub points: Points,
    /// Thread pool in which grasps run.
    pub pool: rayon::ThreadPool,
    /// Notices of failed grasps, with the reason.
    pub notices: Vec<String>,
}

impl RefinementRun {
    /// Creates the mesh refinement study for the scene of a sweep.
    ///
    /// # Errors
    /// Fails if a pad cannot be meshed or threads cannot be started.
    pub fn new(sweep: &Sweep, settings: &ComparisonSettings) -> Result<Self> {
        let members: Vec<_> = refinement_study::members(sweep, settings.levels)?
            .into_iter()
            .map(|(role, c)| (role, BenchEntry::new(c)))
            .collect();
        let reference = members.iter().position(|(role, _)| *role == Role::Reference).unwrap_or(0);
        // Quadrature points of the mesh one level below the reference: it resolves the edge of a contact patch with an
        // affordable number of points.
        let (_, sampled) = &members[reference.saturating_sub(1)];
        let points = Points::of(&Model::build(&sampled.configuration.scene)?.finger()?.topology);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(settings.threads)
            .build()
            .map_err(|e| Error::Start(format!("cannot start {} threads: {e}", settings.threads)))?;
        Ok(Self { pairs: PairDistances::new(members.len()), reference, members, points, pool, notices: Vec::new() })
    }

    /// Returns the reference.
    pub fn reference(&mut self) -> &mut BenchEntry {
        &mut self.members[self.reference].1
    }

    /// Simulates a grasp with all members. If the reference fails, the result is empty. Every member that fails adds a
    /// notice and is omitted from the result.
    ///
    /// # Errors
    /// Fails if the grasp cannot be run.
    pub fn grasp(&mut self, index: usize, pose: Pose, progress: &mut impl FnMut(&str)) -> Result<Vec<MemberResult>> {
        let (mut steps, mut levels) = (Vec::new(), Vec::new());
        for (role, entry) in &mut self.members {
            progress(&format!("grasp {index}: {}", entry.configuration.label));
            let frames = entry.simulate(&self.pool, index, pose, &self.points)?;
            let model = entry.prepared.as_ref().map(|p| p.model.clone());
            let last = model.as_ref().zip(frames.last());
            let values = last.map_or_else(FrameValues::new, |(model, frame)| values(model, frame));
            steps.push(MemberResult { role: *role, fields: entry.fields(&frames), values });
            if let Some(reason) = entry.failed.pop() {
                let whose = if *role == Role::Reference {
                    "the reference; the grasp is omitted"
                } else {
                    &entry.configuration.label
                };
                self.notices.push(format!("{reason} in {whose}"));
            }
            levels = model.map_or(levels, |m| m.levels.clone());
            if *role != Role::Reference {
                // Released because it is large and not needed before the next grasp.
                entry.prepared = None;
            }
        }
        let fails = |s: &MemberResult| s.fields.is_empty();
        if steps.iter().any(|s| s.role == Role::Reference && fails(s)) {
            return Ok(Vec::new());
        }
        let fields: Vec<&[Fields]> = steps.iter().map(|s| &s.fields[..]).collect();
        self.pairs.add(&self.points, &levels, &fields);
        steps.retain(|s| !fails(s));
        Ok(steps)
    }

    /// Returns the results of the mesh refinement study for the grasps so far.
    pub fn results(&self) -> RefinementStudy {
        let member = |(role, entry): &(Role, BenchEntry)| StudyMember {
            label: entry.configuration.label.clone(),
            role: *role,
            nodes: entry.configuration.nodes,
            time_per_grasp_s: Some(entry.time_per_grasp()).filter(|t| t.is_finite()),
        };
        RefinementStudy::new(self.members.iter().map(member).collect(), &self.pairs)
    }
}

/// Returns evenly spread grasps with their numbers.
fn sample(poses: &[Pose], wanted: usize) -> Vec<(usize, Pose)> {
    let count = wanted.clamp(1, poses.len().max(1));
    let numbers = (0..count).map(|i| i * poses.len() / count);
    numbers.filter_map(|i| poses.get(i).map(|p| (i, *p))).collect()
}
