//! Table of references: values of single grasps with error estimates from a mesh refinement study.

use super::comparison::RefinementRun;
use super::quantity::QuantityName;
use super::refinement_study::{ErrorEstimate, RefinementStudy, Role};
use super::settings::ComparisonSettings;
use super::sweep::Sweep;
use super::values::FrameValues;
use base::error::{Error, Result};
use base::number::{format_number, round_significant};
use base::table::Table;
use model::grasp::grasp_poses;
use scene::{Field, NamedScene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// References of a folder.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct References {
    /// Rows, one per object.
    pub rows: Vec<Reference>,
}

/// Reference of one grasp at its last frame.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Reference {
    /// Name of the object.
    pub name: String,
    /// File of the scene; the reference is its first grasp.
    pub scene: String,
    /// Mesh of the values.
    pub reference: String,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// Wall time of the reference, s.
    pub time_s: Option<f64>,
    /// Values with their errors, SI; the name ends with the unit.
    pub values: BTreeMap<QuantityName, Certified>,
    /// Errors of the reference's fields over the frames of the grasp, relative.
    pub fields: BTreeMap<QuantityName, ErrorEstimate>,
    /// Distances of all pairs of meshes for displacement and stress, as in [`RefinementStudy::distances`].
    pub distances: BTreeMap<QuantityName, Vec<Vec<Option<f64>>>>,
    /// Notices and findings of the mesh refinement study.
    pub findings: Vec<String>,
}

/// Value with its error, both in the value's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Certified {
    /// Value of the reference.
    pub value: f64,
    /// Error estimate: the root sum of squares of the mesh error, which is the larger of the changes by the last
    /// refinement and by a mesh of another kind, and of the path error, which is twice the change by halving the path
    /// tolerance.
    pub error: f64,
}

/// Computes the reference of the first grasp of `named`, from the scene file `scene`; `progress` is called for every
/// mesh.
///
/// # Errors
/// Fails if the scene is not supported by a bench or cannot be built, or the reference does not complete the grasp.
pub fn certify(
    named: &NamedScene,
    scene: &Path,
    settings: &ComparisonSettings,
    mut progress: impl FnMut(&str),
) -> Result<(Reference, RefinementStudy)> {
    let mut sweep = Sweep::new(&named.scene)?;
    if !sweep.scene.record.fields.contains(&Field::ContactForce) {
        sweep.scene.record.fields.push(Field::ContactForce);
    }
    let mut run = RefinementRun::new(&sweep, settings)?;
    let pose = *grasp_poses(&named.scene)?.first().ok_or_else(|| Error::Start("the scene has no grasp".into()))?;
    let name = named.name.as_str();
    let steps = run.grasp(0, pose, &mut |text| progress(&format!("{name}: {text}")))?;
    let of = |role: Role| steps.iter().rev().find(|s| s.role == role).map(|s| &s.values);
    let Some(own) = of(Role::Reference) else {
        return Err(Error::Solver(format!("{name}: {}", run.notices.join("; "))));
    };
    let certified = |(name, value): (&QuantityName, &f64)| {
        let change = |other: Option<&FrameValues>| other.and_then(|v| v.get(name)).map(|v| (v - value).abs());
        let mesh = change(of(Role::MeshLevel)).into_iter().chain(change(of(Role::AlternativeMesh))).reduce(f64::max);
        let path = change(of(Role::HalfPath)).map(|c| 2.0 * c);
        let error = mesh.into_iter().chain(path).reduce(f64::hypot).unwrap_or(f64::NAN);
        (name.clone(), Certified { value: *value, error })
    };
    let values = own.iter().map(certified).collect();
    let (study, reference) = (run.results(), run.reference());
    let row = Reference {
        name: name.into(),
        scene: scene.display().to_string(),
        reference: reference.configuration.label.clone(),
        nodes: reference.configuration.nodes,
        time_s: Some(reference.time_per_grasp()).filter(|t| t.is_finite()),
        values,
        fields: study.errors.clone(),
        distances: ["displacement", "stress"]
            .into_iter()
            .filter_map(|name| Some((QuantityName::from(name), study.distances.get(name)?.clone())))
            .collect(),
        findings: run.notices.iter().chain(&study.findings).cloned().collect(),
    };
    Ok((row, study))
}

/// Columns of the table: name of a value, heading, and factor from the value's SI unit to that of the column.
const COLUMNS: [(&str, &str, f64); 6] = [
    ("force_n", "force, N", 1.0),
    ("travel_m", "travel, mm", 1e3),
    ("displacement_max_m", "largest displacement, mm", 1e3),
    ("displacement_rms_m", "rms displacement, mm", 1e3),
    ("stress_mean_pa", "mean von Mises stress, kPa", 1e-3),
    ("patch_radius_m", "rms radius of the force, mm", 1e3),
];

impl References {
    /// Reads the references written to `references.json` in a folder; returns none if there is no such file.
    ///
    /// # Errors
    /// Fails if the file cannot be read or is not such a file.
    pub fn read(dir: &Path) -> Result<Self> {
        let path = dir.join("references.json");
        if !path.exists() {
            return Ok(Self::default());
        }
        let bytes = std::fs::read(&path).map_err(|e| Error::system(&path, format!("cannot be read: {e}"), e.kind()))?;
        serde_json::from_slice(&bytes)
            .map_err(|e| Error::file(&path, format!("is not what `tactus bench --certify` writes: {e}")))
    }

    /// Adds a row, or replaces the row of the same name.
    pub fn put(&mut self, row: Reference) {
        match self.rows.iter_mut().find(|r| r.name == row.name) {
            Some(old) => *old = row,
            None => self.rows.push(row),
        }
    }

    /// Returns the rows as Markdown.
    pub fn markdown(&self) -> String {
        let names = ["object"].into_iter().chain(COLUMNS.map(|c| c.1)).chain(["field: displacement", "field: stress"]);
        let mut table = Table::new("References", &names.collect::<Vec<_>>());
        for row in &self.rows {
            let value = |(name, _, unit): (&str, &str, f64)| {
                let c = row.values.get(name);
                c.map_or("-".into(), |c| {
                    format!(
                        "{} ± {}",
                        format_number(c.value * unit),
                        format_number(round_significant(c.error * unit, 2))
                    )
                })
            };
            let field = |name: &str| {
                let error = row.fields.get(name).and_then(|e| e.error);
                error.map_or("-".into(), |e| format!("{:.1} %", 100.0 * e))
            };
            let cells = [row.name.clone()].into_iter().chain(COLUMNS.map(value));
            table.rows.push(cells.chain(["displacement", "stress"].map(field)).collect());
        }
        let mut out = format!("{MARKDOWN_HEADER}\n{}\n", table.markdown());
        for row in &self.rows {
            let time = row.time_s.map_or(String::new(), |t| format!(", {t:.0} s"));
            out += &format!("- {}: {} of `{}`, {} nodes per pad{time}", row.name, row.reference, row.scene, row.nodes);
            row.findings.iter().for_each(|f| out += &format!("; {f}"));
            out.push('\n');
        }
        out
    }
}

const MARKDOWN_HEADER: &str = "# References

Values of single grasps at their last frame, over both pads, each with an estimate of its own error, written by
`tactus bench SCENE --certify -o docs`; `references.json` has the same in SI. An error combines
the larger of the changes by the last mesh refinement and by a mesh of another kind with twice the change by half the path tolerance. The
last two columns are relative L2 errors of the fields of the reference over the volume.
";
