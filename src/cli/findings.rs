//! Findings about a scene: as text, with the most important facts first, and as JSON.

use base::number::format_number;
use geometry::Aabb;
use geometry::Pose;
use geometry::mesh::topology::check_edges;
use geometry::shape::SurfaceDefinition;
use glam::DVec3;
use indicatif::HumanDuration;
use model::part::FingerModel;
use model::{Model, Unknowns};
use record::pad_name;
use scene::Scene;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use world::run::expected_time::{EXPECTED_TIME_FACTOR, ExpectedTime};

/// Largest number of grasps that are closed to first contact: a check then takes seconds, and the first grasps of a
/// data set are sufficient.
pub(super) const MAX_GRASPS: usize = 1000;

/// Largest number of problems that are printed; the JSON lists all.
const MAX_PROBLEMS: usize = 20;

/// Findings about a scene.
pub(super) struct SceneFindings {
    pub model: Arc<Model>,
    pub systems: Vec<(String, Vec<String>)>,
    pub components: Vec<(String, usize)>,
    pub unknowns: Unknowns,
    pub poses: Vec<Pose>,
    pub notices: Vec<String>,
    pub problems: Vec<String>,
    /// Expected time of all grasps.
    pub expected: ExpectedTime,
    /// Number of those grasps closed to first contact that can start.
    pub started: usize,
}

impl SceneFindings {
    /// Returns the number of grasps that were closed to first contact.
    fn closed_grasps(&self) -> usize {
        self.poses.len().min(MAX_GRASPS)
    }

    pub fn json(&self, scene: &Scene, sources: &[PathBuf]) -> Value {
        let m = &self.model;
        let solid = check_edges(&m.object.surface);
        let own = Aabb::from_points(m.object.surface.vertices.iter().copied());
        let held = self.object_bounds();
        let corners = |bounds: &Aabb| json!([bounds.min.to_array(), bounds.max.to_array()]);
        let quality = |f: &FingerModel| {
            let q = &f.quality;
            json!({
                "worst_index": q.worst_index,
                "worst_mean_ratio": q.worst,
                "worst_centroid_m": q.worst_centroid.to_array(),
                "mean_mean_ratio": q.mean,
                "min_edge_m": q.min_edge,
                "max_edge_m": q.max_edge,
                "volume_m3": q.total_volume,
            })
        };
        let object = |pairs: &[(String, Value)]| Value::Object(pairs.iter().cloned().collect());
        let systems: Vec<_> = self.systems.iter().map(|(set, names)| (set.clone(), json!(names))).collect();
        let components: Vec<_> = self.components.iter().map(|(name, count)| (name.clone(), json!(count))).collect();
        json!({
            "scene": scene,
            "sources": sources,
            "systems": object(&systems),
            "components": object(&components),
            "unknowns": self.unknowns,
            "needs": m.needs,
            "release_n": m.is_released_later().then(|| m.release * m.fingers.len() as f64),
            "path_error": m.path_error,
            "pads": m.pad_reports(),
            "quality": m.fingers.first().map(quality),
            "right_quality": m.fingers.get(1).filter(|_| !m.has_equal_pads()).map(quality),
            "expected_s": self.expected.wall_s,
            "expected_processor_s": self.expected.processor_s,
            "object": {
                "name": m.object.name,
                "closed_form": matches!(m.object.definition, SurfaceDefinition::ClosedForm),
                "watertight": solid.is_solid(),
                "volume_m3": m.object.mass.volume,
                "mass_kg": m.mass,
                "bounding_radius_m": m.object.bounding_radius,
                "bounds_m": corners(&own),
                "bounds_in_hand_m": held.as_ref().map(corners),
            },
            "grasps": self.poses.len(),
            "tried": self.closed_grasps(),
            "notices": m.notices.iter().chain(&m.pad_notices()).chain(&self.notices).collect::<Vec<_>>(),
            "problems": self.problems,
        })
    }

    /// Returns the bounds of the object in the hand frame of the first grasp, m.
    fn object_bounds(&self) -> Option<Aabb> {
        let pose = self.poses.first().map(Pose::inverse)?;
        Some(Aabb::from_points(self.model.object.surface.vertices.iter().map(|x| pose.rotation * *x + pose.position)))
    }

    /// Returns the main facts as comment lines: sizes, positions, expected time, loads and notices.
    pub fn overview(&self) -> String {
        let mut lines = Vec::new();
        self.write_overview(&mut |text| lines.push(text.to_string()));
        comment(&lines)
    }

    /// Returns the details as comment lines: the meshes and the unknowns, and all systems and components if `systems`.
    pub fn details(&self, systems: bool) -> String {
        let mut lines = vec![String::new()];
        self.write_details(systems, &mut |text| lines.push(text.to_string()));
        comment(&lines)
    }

    /// Returns the problems as comment lines, with the name of the `object` if it is given.
    pub fn problem_lines(&self, object: Option<&str>) -> String {
        let about = object.map_or_else(String::new, |name| format!("object {name}: "));
        let shown = self.problems.iter().take(MAX_PROBLEMS).map(|problem| format!("problem: {about}{problem}"));
        let more = self.problems.len().saturating_sub(MAX_PROBLEMS);
        let rest = (more > 0).then(|| format!("problem: {about}{more} more of this kind; --format json lists them"));
        comment(&shown.chain(rest).collect::<Vec<_>>())
    }

    fn write_overview(&self, line: &mut dyn FnMut(&str)) {
        let m = &self.model;
        let own = Aabb::from_points(m.object.surface.vertices.iter().copied());
        line(&format!("object: {}, {} in its own frame", extent(&own), format_box(&own)));
        if let (Some(pose), Some(held)) = (self.poses.first(), self.object_bounds()) {
            // Adding zero turns -0 into +0.
            let (p, q) = (pose.position * 1e3 + DVec3::ZERO, pose.rotation);
            line(&format!(
                "grasp 0: the hand is at ({:.1}, {:.1}, {:.1}) mm in the object frame, with orientation (w, x, y, z) = \
                 ({:.4}, {:.4}, {:.4}, {:.4})",
                p.x, p.y, p.z, q.w, q.x, q.y, q.z
            ));
            line(&format!(
                "in the hand frame of grasp 0: {}; fingers close along x, the hand approaches along z",
                format_box(&held)
            ));
        }
        let all = if self.poses.len() == 1 { "1 grasp".into() } else { format!("{} grasps", self.poses.len()) };
        let ExpectedTime { processor_s, wall_s, .. } = self.expected;
        line(&format!(
            "time: about {} of processor time for {all}, {} on this machine, within a factor of {EXPECTED_TIME_FACTOR}",
            duration(processor_s),
            duration(wall_s)
        ));
        let solid = check_edges(&m.object.surface);
        line(&format!(
            "{}: {}, {}, volume {:.2} cm3, mass {:.2} g, {}",
            m.object.name,
            match m.object.definition {
                SurfaceDefinition::ClosedForm => "distance in closed form",
                SurfaceDefinition::Facets => "distance to its facets",
                SurfaceDefinition::Smooth(_) => "distance to a smooth surface through its mesh",
            },
            solid.defect_message().unwrap_or_else(|| "watertight".into()),
            m.object.mass.volume * 1e6,
            m.mass * 1e3,
            if m.free { "free" } else { "fixed" },
        ));
        for (index, pad) in m.pad_reports().iter().enumerate() {
            let size = m.fingers.get(index).map(|finger| extent(&finger.bounds())).unwrap_or_default();
            let (name, element) = (pad_name(index), &pad.element);
            line(&format!("{name} pad: {size} in the hand, {} nodes, {} tetrahedra, {element}", pad.nodes, pad.tets));
        }
        let total = m.fingers.len() as f64;
        if m.is_released_later() {
            line(&format!(
                "release: the object is fixed up to {:.4} N, the sum over the fingers, and free afterwards",
                m.release * total
            ));
        }
        line(&format!(
            "contact: active at gaps below {} m; all lengths of the contact method are multiples of this gap",
            format_number(m.offset)
        ));
        if let Some(path) = m.path_error {
            line(&format!("path: the increments are chosen for a relative path error of {path:e} of the displacement"));
        }
        let (all, tried) = (self.poses.len(), self.closed_grasps());
        let untried = if tried < all { format!("; {} more were not checked", all - tried) } else { String::new() };
        line(&format!("{} of {tried} grasps can start{untried}", self.started));
        m.notices
            .iter()
            .chain(&m.pad_notices())
            .chain(&self.notices)
            .for_each(|notice| line(&format!("note: {notice}")));
    }

    fn write_details(&self, systems: bool, line: &mut dyn FnMut(&str)) {
        let m = &self.model;
        for (side, finger) in m.fingers.iter().enumerate().take(if m.has_equal_pads() { 1 } else { 2 }) {
            let (q, c) = (&finger.quality, finger.quality.worst_centroid * 1e3);
            let name = if m.has_equal_pads() { "pad".into() } else { format!("{} pad", pad_name(side)) };
            line(&format!(
                "{name} mesh: mean ratio {:.3} on average, worst {:.3} in tetrahedron {} at ({:.3}, {:.3}, {:.3}) mm of the pad; edges {:.3} to {:.3} mm",
                q.mean,
                q.worst,
                q.worst_index,
                c.x,
                c.y,
                c.z,
                q.min_edge * 1e3,
                q.max_edge * 1e3
            ));
        }
        let u = &self.unknowns;
        let pads: Vec<_> = u.pads.iter().map(usize::to_string).collect();
        line(&format!(
            "unknowns: {} = {} (pads) + {} (travels) + {} (pose)",
            u.total,
            pads.join(" + "),
            u.travels,
            u.pose
        ));
        if systems {
            line("");
            for (set, names) in &self.systems {
                line(&format!("{set:<8} {}", names.join(", ")));
            }
            line("");
            let components: Vec<_> = self.components.iter().map(|(name, count)| format!("{count} {name}")).collect();
            line(&format!("components: {}", components.join(", ")));
        }
    }
}

/// Formats a time.
fn duration(seconds: f64) -> String {
    if seconds < 2.0 {
        format!("{seconds:.1} s")
    } else {
        HumanDuration(Duration::from_secs_f64(seconds.min(1e12))).to_string()
    }
}

/// Formats lines of text as comments of a scene.
fn comment(lines: &[String]) -> String {
    lines.iter().map(|line| format!("{}\n", format!("// {line}").trim_end())).collect()
}

/// Formats the edge lengths of a box.
fn extent(bounds: &Aabb) -> String {
    let size = bounds.size() * 1e3;
    format!("{:.1} x {:.1} x {:.1} mm", size.x, size.y, size.z)
}

/// Formats the corners of a box.
fn format_box(bounds: &Aabb) -> String {
    let [low, high] =
        [bounds.min, bounds.max].map(|x| x * 1e3).map(|x| format!("({:.1}, {:.1}, {:.1})", x.x, x.y, x.z));
    format!("from {low} to {high} mm")
}
