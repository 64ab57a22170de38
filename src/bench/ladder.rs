//! Reference of a bench, and its distance from the truth. The members are condensed pads of meshes, each finer than the one before by the
//! square root of two, the finest of which is the reference; a mesh of another kind, as fine at the centre; and the reference once more
//! along a path of half the tolerance.
//!
//! The truth is unknown, but two distances bracket it. The change by the last refinement contains the larger error of the mesh before and
//! is too large; a mesh of another kind shares a part of the error, and its distance is too small. Their geometric mean is the estimate
//! (docs/verification.md compares it with meshes twice as fine). The order that the rungs show is reported, and [`MeshLadder::findings`]
//! state where it, the two distances or the path are inconsistent.

use super::density::{coarser, other_kind};
use super::report::{QUANTITIES, QuantityName};
use super::sweep::{Configuration, Sweep};
use crate::distance::{Distance, Fields, Points};
use crate::error::Result;
use crate::net::eval::table::FROM_LOAD;
use crate::scene::leaf::Positive;
use crate::scene::{Condensed, Fem, Solver};
use crate::stats::median;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;

/// Default number of rungs: the cells of the last are 2.8 times as narrow as the scene's.
pub const RUNGS: usize = 4;
/// Error of the condensed pads of a ladder: far below that of their meshes.
const SHARP: Condensed = Condensed { error: Positive::preset(0.002) };
/// Factor to which an estimate should be accurate.
const GOOD: f64 = 2.0;

/// Role of a member of a ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Mesh of the first kind, one of several from coarse to fine.
    Rung,
    /// Finest mesh of the first kind.
    Reference,
    /// Mesh of another kind.
    Other,
    /// Reference along a path of half the tolerance.
    HalfPath,
}

/// Returns the members of the ladder of a scene, `rungs` of them on meshes of one kind: one if its pads are from a file.
///
/// # Errors
/// Fails if a pad cannot be meshed so finely.
pub fn members(sweep: &Sweep, rungs: usize) -> Result<Vec<(Role, Configuration)>> {
    let fem = Fem { solver: Solver::Condensed(SHARP), ..sweep.fem };
    let pads = &sweep.scene.gripper.pads;
    let mut members: Vec<(Role, Configuration)> = Vec::new();
    for rung in 0..if sweep.refinable() { rungs } else { 1 } {
        let finer = coarser(pads, FRAC_1_SQRT_2.powi(rung as i32))?;
        let new = sweep.configuration("condensed, sharp", finer, fem)?;
        // Spacings are rounded to whole cells: two of them may give one mesh.
        if members.last().is_none_or(|(_, last)| last.nodes < new.nodes) {
            members.push((Role::Rung, new));
        }
    }
    let Some((role, reference)) = members.last_mut() else { return Ok(members) };
    *role = Role::Reference;
    reference.label = format!("reference, {}", reference.label);
    let finest = reference.scene.gripper.pads.clone();
    if let Some(other) = other_kind(&finest)? {
        members.push((Role::Other, sweep.configuration("condensed, sharp", other, fem)?));
    }
    if sweep.scene.gripper.friction.get() > 0.0
        && let Ok(path) = Positive::new(0.5 * fem.path.get())
    {
        members.push((Role::HalfPath, sweep.configuration("half the path, sharp", finest, Fem { path, ..fem })?));
    }
    Ok(members)
}

/// Distances of all pairs of members, as grasp after grasp comes in.
#[derive(Debug)]
pub struct Tally(Vec<Vec<Vec<Distance>>>);

impl Tally {
    /// Returns an empty tally of `members` members.
    pub fn new(members: usize) -> Self {
        Self((0..members).map(|_| vec![Vec::new(); members]).collect())
    }

    /// Adds a grasp: per member its frames, at the loads `levels`.
    pub fn add(&mut self, points: &Points, levels: &[f64], fields: &[&[Fields]]) {
        for (i, own) in fields.iter().enumerate() {
            for (j, other) in fields.iter().enumerate().skip(i + 1) {
                self.0[i][j].extend(distances(points, levels, own, other));
            }
        }
    }
}

/// Returns the distances of the loaded frames of a grasp, `own` from `truth`.
pub fn distances(points: &Points, levels: &[f64], own: &[Fields], truth: &[Fields]) -> Vec<Distance> {
    // Next to nothing is deformed at a small load, and relative errors say little there.
    let least = (FROM_LOAD - 1e-9) * levels.last().copied().unwrap_or(1.0);
    let frames = own.iter().zip(truth).zip(levels).filter(|(_, level)| **level >= least);
    frames.map(|((own, truth), _)| Distance::of(points, own, truth)).collect()
}

/// Member as it is reported.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Member {
    /// Name of the member.
    pub label: String,
    /// Role of the member.
    pub role: Role,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// Wall time of a grasp, s; null if no grasp reached its end.
    pub time_per_grasp_s: Option<f64>,
}

/// Ladder with its results.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MeshLadder {
    /// Members of the ladder.
    pub members: Vec<Member>,
    /// Distances per quantity: of member i from member j > i, over the norm of j, median over grasps and frames; null elsewhere.
    pub distances: BTreeMap<QuantityName, Vec<Vec<Option<f64>>>>,
    /// Errors of the reference, per relative quantity.
    pub errors: BTreeMap<QuantityName, ErrorEstimate>,
    /// Findings in sentences: estimates that disagree, or missing parts.
    pub findings: Vec<String>,
}

/// Relative error of the reference, with its sources.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorEstimate {
    /// Error of the mesh and of the path together, as the square root of the sum of squares; null if neither is known.
    pub error: Option<f64>,
    /// Order of convergence in the width of the cells that the last three rungs show; null without three, or if they do not converge.
    pub order: Option<f64>,
    /// Distance of the last two rungs: more than the error of the last.
    pub by_rungs: Option<f64>,
    /// Distance to the mesh of another kind: less than the error, of which the two share a part.
    pub by_other: Option<f64>,
    /// Error of the path: twice the change by half the tolerance.
    pub by_path: Option<f64>,
}

impl MeshLadder {
    /// Builds the ladder from the distances of its members.
    pub fn new(members: Vec<Member>, tally: &Tally) -> Self {
        let table = |pick: fn(&Distance) -> f64| -> Vec<Vec<Option<f64>>> {
            let middle = |d: &Vec<Distance>| Some(median(d.iter().map(pick))).filter(|m| m.is_finite());
            tally.0.iter().map(|row| row.iter().map(middle).collect()).collect()
        };
        let distances: BTreeMap<QuantityName, _> =
            QUANTITIES.iter().map(|(name, pick)| (QuantityName::from(*name), table(*pick))).collect();
        let relative = distances.iter().filter(|(name, _)| !name.contains("_max_"));
        let errors: BTreeMap<QuantityName, ErrorEstimate> =
            relative.map(|(name, table)| (name.clone(), ErrorEstimate::of(&members, table))).collect();
        let mut ladder = Self { members, distances, errors, findings: Vec::new() };
        ladder.findings = ["displacement", "stress"].into_iter().flat_map(|name| ladder.finding(name)).collect();
        if ladder.members.iter().filter(|m| matches!(m.role, Role::Rung | Role::Reference)).count() < 2 {
            let text = "the pads have one mesh: how much of the answer is the mesh's error is not known, only what settings change on it";
            ladder.findings.push(text.into());
        }
        ladder
    }

    /// Returns the finding about the error of a quantity.
    fn finding(&self, name: &str) -> Option<String> {
        let e = self.errors.get(name)?;
        let percent = |v: f64| format!("{:.2} %", 100.0 * v);
        let mesh = e.mesh()?;
        let mut doubts = Vec::new();
        match (e.order, e.by_rungs) {
            (Some(order), Some(last)) => {
                let left = last / (2_f64.powf(0.5 * order) - 1.0);
                if left > GOOD * mesh {
                    doubts.push(format!("the order {order:.1} that the rungs show would leave {}", percent(left)));
                }
            }
            (None, Some(_)) => doubts.push("the last three rungs do not converge".into()),
            _ => {}
        }
        if let (Some(last), Some(other)) = (e.by_rungs, e.by_other)
            && (last / other > GOOD * GOOD || other > last)
        {
            doubts.push(format!(
                "the last refinement changed {}, the mesh of another kind {}",
                percent(last),
                percent(other)
            ));
        }
        if let Some(path) = e.by_path.filter(|path| *path > mesh) {
            doubts.push(format!("the path is more in doubt ({}) than the mesh", percent(path)));
        }
        let text = || format!("{name}: the mesh's error is taken for {}, but {}", percent(mesh), doubts.join(", and "));
        (!doubts.is_empty()).then(text)
    }
}

impl ErrorEstimate {
    fn of(members: &[Member], table: &[Vec<Option<f64>>]) -> Self {
        let find = |role: Role| members.iter().position(|m| m.role == role);
        let Some(reference) = find(Role::Reference) else { return Self::default() };
        let from = |other: Option<usize>| table[reference][other?];
        let before = |k: usize| -> Option<f64> { table[reference.checked_sub(k + 1)?][reference.checked_sub(k)?] };
        // With an error c h^p the distances of neighbours are in the ratio 2^(p/2).
        let ratio = before(1).zip(before(0)).map(|(coarse, fine)| coarse / fine).filter(|r| *r > 1.0 && r.is_finite());
        let mut estimate = Self {
            error: None,
            order: ratio.map(|r| 2.0 * r.log2()),
            by_rungs: before(0),
            by_other: from(find(Role::Other)),
            by_path: from(find(Role::HalfPath)).map(|d| 2.0 * d),
        };
        estimate.error = estimate.mesh().into_iter().chain(estimate.by_path).reduce(f64::hypot);
        estimate
    }

    /// Returns the error of the mesh: the geometric mean of the upper and the lower bound, or the one that is known.
    pub fn mesh(&self) -> Option<f64> {
        self.by_rungs.into_iter().chain(self.by_other).reduce(|more, less| (more * less).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a ladder whose fields are numbers.
    fn ladder(values: &[(Role, f64)]) -> ErrorEstimate {
        let member = |role| Member { label: String::new(), role, nodes: 0, time_per_grasp_s: None };
        let members: Vec<Member> = values.iter().map(|(role, _)| member(*role)).collect();
        let table: Vec<Vec<_>> =
            values.iter().map(|(_, a)| values.iter().map(|(_, b)| Some((a - b).abs())).collect()).collect();
        ErrorEstimate::of(&members, &table)
    }

    #[test]
    fn the_order_of_a_power_law_is_found_whatever_it_is() {
        for order in [0.5, 1.0, 2.0, 3.0] {
            let error = |rung: f64| 0.3 * 2_f64.powf(-0.5 * rung * order);
            let rungs = [(Role::Rung, error(0.0)), (Role::Rung, error(1.0)), (Role::Reference, error(2.0))];
            let found = ladder(&rungs);
            assert!(found.order.is_some_and(|p| (p - order).abs() < 1e-9), "{found:?}");
            let last = error(1.0) - error(2.0);
            assert!(found.error.is_some_and(|e| (e - last).abs() < 1e-12), "{found:?} for {last}");
        }
    }

    #[test]
    fn a_ladder_that_does_not_converge_gives_no_order() {
        let found = ladder(&[(Role::Rung, 0.0), (Role::Rung, 0.1), (Role::Reference, 0.3), (Role::Other, 0.25)]);
        assert_eq!(found.order, None);
        assert!(found.error.is_some_and(|e| (e - 0.1).abs() < 1e-12), "the mean of 0.2 and 0.05: {found:?}");
    }

    #[test]
    fn the_path_counts_beside_the_mesh() {
        let found = ladder(&[(Role::Reference, 0.0), (Role::Other, 0.03), (Role::HalfPath, 0.02)]);
        assert!(found.error.is_some_and(|e| (e - 0.05).abs() < 1e-12), "{found:?}");
    }
}
