//! Reference of a benchmark, and an estimate of its error by a mesh refinement study. Its members use condensed pads: a
//! sequence of meshes, each level finer than the previous one by the square root of two, whose finest is the
//! reference; a mesh of another kind that is equally fine at the centre; and the reference with half the path
//! tolerance.
//!
//! The true error is unknown, but two distances bracket it. The change by the last refinement includes the larger error
//! of the coarser mesh and overestimates it. A mesh of another kind shares part of the error with the reference, so its
//! distance underestimates it. Their geometric mean is the estimate (docs/verification.md compares it with meshes twice
//! as fine). The observed order of convergence is reported, and [`RefinementStudy::findings`] states where the order,
//! the two distances or the path error are inconsistent.

use super::density::{alternative_mesh, coarser};
use super::quantity::{QUANTITIES, QuantityName};
use super::sweep::{Configuration, Sweep};
use base::error::Result;
use base::stats::median;
use net::eval::table::MIN_LOAD_FRACTION;
use record::error_norm::{Fields, FrameDistance, Points};
use scene::leaf::Positive;
use scene::{Condensed, Fem, Solver};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;

/// Default number of mesh levels: the cells of the finest are narrower than the scene's by a factor of 2.8.
pub const DEFAULT_LEVELS: usize = 4;
/// Tolerance of the condensed pads of all members: far below the error of their meshes.
const TIGHT_TOLERANCE: Condensed = Condensed { error: Positive::new_unchecked(0.002) };
/// Factor within which an error estimate should be accurate.
const ESTIMATE_FACTOR: f64 = 2.0;

/// Role of a member of the mesh refinement study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Level of the refinement sequence other than the finest.
    #[serde(rename = "rung")]
    MeshLevel,
    /// Finest level of the refinement sequence.
    Reference,
    /// Mesh of another kind.
    #[serde(rename = "other")]
    AlternativeMesh,
    /// Reference with half the path tolerance.
    HalfPath,
}

/// Returns the members of the mesh refinement study of the scene of `sweep`: `levels` mesh levels (one if its pads are
/// from a file), each finer than the previous one by the square root of two, the finest being the reference; then a
/// mesh of another kind, and the reference with half the path tolerance, where they exist.
///
/// # Errors
/// Fails if a pad cannot be meshed.
pub fn members(sweep: &Sweep, levels: usize) -> Result<Vec<(Role, Configuration)>> {
    let fem = Fem { solver: Solver::Condensed(TIGHT_TOLERANCE), ..sweep.fem };
    let pads = &sweep.scene.gripper.pads;
    let mut members: Vec<(Role, Configuration)> = Vec::new();
    for level in 0..if sweep.refinable() { levels } else { 1 } {
        let finer = coarser(pads, FRAC_1_SQRT_2.powi(level as i32))?;
        let new = sweep.configuration("condensed, tight tolerance", finer, fem)?;
        // Spacings are rounded to whole cells, so two of them may result in the same mesh.
        if members.last().is_none_or(|(_, last)| last.nodes < new.nodes) {
            members.push((Role::MeshLevel, new));
        }
    }
    let Some((role, reference)) = members.last_mut() else { return Ok(members) };
    *role = Role::Reference;
    reference.label = format!("reference, {}", reference.label);
    let finest = reference.scene.gripper.pads.clone();
    if let Some(other) = alternative_mesh(&finest)? {
        members.push((Role::AlternativeMesh, sweep.configuration("condensed, tight tolerance", other, fem)?));
    }
    if sweep.scene.gripper.friction.get() > 0.0
        && let Ok(path) = Positive::new(0.5 * fem.path.get())
    {
        members.push((Role::HalfPath, sweep.configuration("half the path tolerance", finest, Fem { path, ..fem })?));
    }
    Ok(members)
}

/// Distances between the results of all pairs of members of a mesh refinement study, accumulated over grasps and
/// frames.
#[derive(Debug)]
pub struct PairDistances(Vec<Vec<Vec<FrameDistance>>>);

impl PairDistances {
    /// Creates empty distances for a study with `members` members.
    pub fn new(members: usize) -> Self {
        Self((0..members).map(|_| vec![Vec::new(); members]).collect())
    }

    /// Adds the results of one grasp. `points` are the common points at which fields are compared, `levels` the loads
    /// of the frames (N or m), and `fields` the frames of each member, in the order of the members.
    pub fn add(&mut self, points: &Points, levels: &[f64], fields: &[&[Fields]]) {
        for (i, own) in fields.iter().enumerate() {
            for (j, other) in fields.iter().enumerate().skip(i + 1) {
                self.0[i][j].extend(distances(points, levels, own, other));
            }
        }
    }
}

/// Returns the distance of each frame of `own` from the same frame of `truth`, for the frames whose load in `levels` (N
/// or m) is at least the fraction [`MIN_LOAD_FRACTION`] of the last one. `points` are the common points at which fields
/// are compared.
pub fn distances(points: &Points, levels: &[f64], own: &[Fields], truth: &[Fields]) -> Vec<FrameDistance> {
    // Deformation is almost zero at small loads, where relative errors are not meaningful.
    let least = (MIN_LOAD_FRACTION - 1e-9) * levels.last().copied().unwrap_or(1.0);
    let frames = own.iter().zip(truth).zip(levels).filter(|(_, level)| **level >= least);
    frames.map(|((own, truth), _)| FrameDistance::of(points, own, truth)).collect()
}

/// Reported properties of a member of the mesh refinement study.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct StudyMember {
    /// Name of the member in tables: solver and mesh.
    pub label: String,
    /// Role of the member in the study.
    pub role: Role,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// Wall time of a grasp, s; None (`null` in JSON) if no grasp reached its load.
    pub time_per_grasp_s: Option<f64>,
}

/// Results of the mesh refinement study.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RefinementStudy {
    /// Members of the study, mesh levels from coarse to fine first.
    pub members: Vec<StudyMember>,
    /// Distances by quantity, as a square matrix: element `[i][j]` with i < j is the distance of member i from member
    /// j, the median over grasps and frames. It is relative to the norm of member j, except for quantities with a unit
    /// in their name. Other elements are None (`null` in JSON).
    pub distances: BTreeMap<QuantityName, Vec<Vec<Option<f64>>>>,
    /// Estimated errors of the reference, by quantity, for the relative quantities.
    pub errors: BTreeMap<QuantityName, ErrorEstimate>,
    /// Findings, one sentence each: inconsistent estimates, or missing members.
    pub findings: Vec<String>,
}

/// Estimated relative error of the reference in one quantity, with its parts. Unknown values are None (`null` in JSON).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorEstimate {
    /// Total error: root of the sum of squares of mesh error and path error, as far as they are known.
    pub error: Option<f64>,
    /// Order of convergence in the cell width, observed on the last three mesh levels; None with fewer, or if they do
    /// not converge.
    pub order: Option<f64>,
    /// Distance between the last two mesh levels: an upper bound of the error of the finest.
    #[serde(rename = "by_rungs")]
    pub by_levels: Option<f64>,
    /// Distance to the mesh of another kind: a lower bound of the error, because the two meshes share a part of it.
    #[serde(rename = "by_other")]
    pub by_alternative_mesh: Option<f64>,
    /// Path error: twice the change by halving the path tolerance.
    pub by_path: Option<f64>,
}

impl RefinementStudy {
    /// Computes the results from the properties of the members and the distances between them in `pairs`, in the same
    /// order.
    pub fn new(members: Vec<StudyMember>, pairs: &PairDistances) -> Self {
        let table = |pick: fn(&FrameDistance) -> f64| -> Vec<Vec<Option<f64>>> {
            let middle = |d: &Vec<FrameDistance>| Some(median(d.iter().map(pick))).filter(|m| m.is_finite());
            pairs.0.iter().map(|row| row.iter().map(middle).collect()).collect()
        };
        let distances: BTreeMap<QuantityName, _> =
            QUANTITIES.iter().map(|(name, pick)| (QuantityName::from(*name), table(*pick))).collect();
        let relative = distances.iter().filter(|(name, _)| !name.contains("_max_"));
        let errors: BTreeMap<QuantityName, ErrorEstimate> =
            relative.map(|(name, table)| (name.clone(), ErrorEstimate::of(&members, table))).collect();
        let mut study = Self { members, distances, errors, findings: Vec::new() };
        study.findings = ["displacement", "stress"].into_iter().flat_map(|name| study.finding(name)).collect();
        if study.members.iter().filter(|m| matches!(m.role, Role::MeshLevel | Role::Reference)).count() < 2 {
            let text = "the pads have only one mesh: its discretisation error is unknown, only the effect of other \
                settings is measured";
            study.findings.push(text.into());
        }
        study
    }

    /// Returns a sentence if the parts of the error estimate of a quantity are inconsistent.
    fn finding(&self, name: &str) -> Option<String> {
        let e = self.errors.get(name)?;
        let percent = |v: f64| format!("{:.2} %", 100.0 * v);
        let mesh = e.mesh()?;
        let mut doubts = Vec::new();
        match (e.order, e.by_levels) {
            (Some(order), Some(last)) => {
                let left = last / (2_f64.powf(0.5 * order) - 1.0);
                if left > ESTIMATE_FACTOR * mesh {
                    doubts.push(format!("the observed order of convergence {order:.1} implies {}", percent(left)));
                }
            }
            (None, Some(_)) => doubts.push("the last three mesh levels do not converge".into()),
            _ => {}
        }
        if let (Some(last), Some(other)) = (e.by_levels, e.by_alternative_mesh)
            && (last / other > ESTIMATE_FACTOR * ESTIMATE_FACTOR || other > last)
        {
            doubts.push(format!(
                "the change by the last refinement is {}, that by the mesh of another kind {}",
                percent(last),
                percent(other)
            ));
        }
        if let Some(path) = e.by_path.filter(|path| *path > mesh) {
            doubts.push(format!("the path error ({}) is larger", percent(path)));
        }
        let text =
            || format!("{name}: the estimate of the mesh error is {}, but {}", percent(mesh), doubts.join(", and "));
        (!doubts.is_empty()).then(text)
    }
}

impl ErrorEstimate {
    fn of(members: &[StudyMember], table: &[Vec<Option<f64>>]) -> Self {
        let find = |role: Role| members.iter().position(|m| m.role == role);
        let Some(reference) = find(Role::Reference) else { return Self::default() };
        let from = |other: Option<usize>| table[reference][other?];
        let before = |k: usize| -> Option<f64> { table[reference.checked_sub(k + 1)?][reference.checked_sub(k)?] };
        // With an error c h^p, the ratio of successive distances is 2^(p/2).
        let ratio = before(1).zip(before(0)).map(|(coarse, fine)| coarse / fine).filter(|r| *r > 1.0 && r.is_finite());
        let mut estimate = Self {
            error: None,
            order: ratio.map(|r| 2.0 * r.log2()),
            by_levels: before(0),
            by_alternative_mesh: from(find(Role::AlternativeMesh)),
            by_path: from(find(Role::HalfPath)).map(|d| 2.0 * d),
        };
        estimate.error = estimate.mesh().into_iter().chain(estimate.by_path).reduce(f64::hypot);
        estimate
    }

    /// Returns the mesh error: the geometric mean of the upper and the lower bound, or the only known bound.
    pub fn mesh(&self) -> Option<f64> {
        self.by_levels.into_iter().chain(self.by_alternative_mesh).reduce(|more, less| (more * less).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the estimate for members whose fields are the given numbers.
    fn estimate(values: &[(Role, f64)]) -> ErrorEstimate {
        let member = |role| StudyMember { label: String::new(), role, nodes: 0, time_per_grasp_s: None };
        let members: Vec<StudyMember> = values.iter().map(|(role, _)| member(*role)).collect();
        let table: Vec<Vec<_>> =
            values.iter().map(|(_, a)| values.iter().map(|(_, b)| Some((a - b).abs())).collect()).collect();
        ErrorEstimate::of(&members, &table)
    }

    #[test]
    fn the_order_of_a_power_law_is_found_whatever_it_is() {
        for order in [0.5, 1.0, 2.0, 3.0] {
            let error = |level: f64| 0.3 * 2_f64.powf(-0.5 * level * order);
            let levels = [(Role::MeshLevel, error(0.0)), (Role::MeshLevel, error(1.0)), (Role::Reference, error(2.0))];
            let found = estimate(&levels);
            assert!(found.order.is_some_and(|p| (p - order).abs() < 1e-9), "{found:?}");
            let last = error(1.0) - error(2.0);
            assert!(found.error.is_some_and(|e| (e - last).abs() < 1e-12), "{found:?} for {last}");
        }
    }

    #[test]
    fn a_sequence_that_does_not_converge_gives_no_order() {
        let found = estimate(&[
            (Role::MeshLevel, 0.0),
            (Role::MeshLevel, 0.1),
            (Role::Reference, 0.3),
            (Role::AlternativeMesh, 0.25),
        ]);
        assert_eq!(found.order, None);
        assert!(found.error.is_some_and(|e| (e - 0.1).abs() < 1e-12), "the mean of 0.2 and 0.05: {found:?}");
    }

    #[test]
    fn the_path_counts_beside_the_mesh() {
        let found = estimate(&[(Role::Reference, 0.0), (Role::AlternativeMesh, 0.03), (Role::HalfPath, 0.02)]);
        assert!(found.error.is_some_and(|e| (e - 0.05).abs() < 1e-12), "{found:?}");
    }
}
