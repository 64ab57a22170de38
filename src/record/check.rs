//! Checks before writing: array sizes must match and numbers must be finite, because a NaN in a file silently corrupts
//! training data.

use super::frame::{Frame, PadFrame, PadTopology, pad_name};
use super::tactile::TactileArray;
use geometry::mesh::TriMesh;
use glam::DVec3;
use std::borrow::Borrow;

/// Result of a check; the error names the invalid field and the reason. The caller adds the file name.
type CheckResult = std::result::Result<(), String>;

/// Checks that node indices are in range, that `bonded` has one entry per node and that coordinates are finite.
pub fn topology(pad: usize, topology: &PadTopology) -> CheckResult {
    let name = format!("topology of pad {pad} ({})", pad_name(pad));
    let nodes = topology.rest.len();
    length(&name, "bonded", topology.bonded.len(), nodes, "nodes")?;
    if topology.corner_count > nodes {
        return Err(format!("{name}: corner_count is {}, allowed are at most {nodes} (nodes)", topology.corner_count));
    }
    vectors(&name, "rest", &topology.rest)?;
    indices(&name, "elements", topology.elements.nodes(), nodes)?;
    indices(&name, "surface", topology.surface.as_flattened(), nodes)?;
    indices(&name, "sensing", topology.sensing.as_flattened(), nodes)
}

/// Checks that the vertex indices of the object's surface are in range and its vertices finite.
pub fn object(mesh: &TriMesh) -> CheckResult {
    vectors("object surface", "vertices", &mesh.vertices)?;
    indices("object surface", "triangles", mesh.triangles.as_flattened(), mesh.vertices.len())
}

/// Checks that every number is finite and that array lengths match the topologies.
pub fn frame<T: Borrow<PadTopology>>(topologies: &[T], frame: &Frame) -> CheckResult {
    let name = format!("frame {}", frame.index);
    length(&name, "pads", frame.pads.len(), topologies.len(), "pads of the grasp")?;
    length(&name, "travel", frame.travel.len(), topologies.len(), "pads of the grasp")?;
    let scalars = [
        ("applied_force", frame.applied_force),
        ("time", frame.time),
        ("energy", frame.energy),
        ("force_balance", frame.force_balance),
        ("torque_balance", frame.torque_balance),
        ("residual", frame.residual),
    ];
    for (field, value) in scalars {
        finite(&name, field, value)?;
    }
    // In a dynamic scene the minimum is infinite if nothing is near contact (`min_gap`) or there is no pad
    // (`min_det_f`).
    for (field, value) in [("min_det_f", frame.min_det_f), ("min_gap", frame.min_gap)] {
        if frame.moving.is_none() || value != f64::INFINITY {
            finite(&name, field, value)?;
        }
    }
    if let Some(m) = &frame.moving {
        let vectors_of = [m.hand_position, m.velocity, m.spin, m.momentum, m.angular_momentum, m.ground_force];
        vectors(&name, "moving", &vectors_of)?;
        numbers(&name, "moving.hand_rotation", &m.hand_rotation.to_array())?;
    }
    numbers(&name, "travel", &frame.travel)?;
    vectors(&name, "object_position", &[frame.object_position])?;
    numbers(&name, "object_rotation", &frame.object_rotation.to_array())?;
    for TactileArray { name: field, shape, values, .. } in &frame.tactile {
        length(&name, field, values.len(), shape.iter().product(), "its shape")?;
        let bad = values.iter().position(|v| !v.is_finite());
        bad.map_or(Ok(()), |i| finite(&name, &format!("{field}[{i}]"), f64::from(values[i])))?;
    }
    for (index, (pad, topology)) in frame.pads.iter().zip(topologies).enumerate() {
        pad_frame(&format!("{name}, pad {index} ({})", pad_name(index)), pad, topology.borrow())?;
    }
    Ok(())
}

fn pad_frame(name: &str, pad: &PadFrame, topology: &PadTopology) -> CheckResult {
    let (nodes, tets) = (topology.rest.len(), topology.elements.len());
    for (field, values) in [("position", &pad.position), ("displacement", &pad.displacement)] {
        length(name, field, values.len(), nodes, "nodes")?;
        vectors(name, field, values)?;
    }
    optional(name, "contact_force", pad.contact_force.len(), nodes, "nodes")?;
    vectors(name, "contact_force", &pad.contact_force)?;
    optional(name, "von_mises_node", pad.von_mises_node.len(), nodes, "nodes")?;
    numbers(name, "von_mises_node", &pad.von_mises_node)?;
    optional(name, "von_mises_element", pad.von_mises_element.len(), tets, "tetrahedra")?;
    numbers(name, "von_mises_element", &pad.von_mises_element)?;
    optional(name, "gap", pad.gap.len(), nodes, "nodes")?;
    numbers(name, "gap", &pad.gap)?;
    optional(name, "slip", pad.slip.len(), nodes, "nodes")?;
    numbers(name, "slip", &pad.slip)?;
    finite(name, "contact_area", pad.contact_area)?;
    vectors(name, "wrench.force", &[pad.wrench.force])?;
    vectors(name, "wrench.torque", &[pad.wrench.torque])
}

/// Checks that a number is finite.
pub fn finite(name: &str, field: &str, value: f64) -> CheckResult {
    if value.is_finite() { Ok(()) } else { Err(format!("{name}: {field} is {value}, only finite numbers are written")) }
}

fn numbers(name: &str, field: &str, values: &[f64]) -> CheckResult {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => finite(name, &format!("{field}[{i}]"), values[i]),
    }
}

fn vectors(name: &str, field: &str, values: &[DVec3]) -> CheckResult {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(format!("{name}: {field}[{i}] is {}, only finite numbers are written", values[i])),
    }
}

fn length(name: &str, field: &str, got: usize, want: usize, of: &str) -> CheckResult {
    if got == want { Ok(()) } else { Err(format!("{name}: {field} has {got} entries instead of {want} ({of})")) }
}

/// Checks the length of an optional field, which is empty if the scene does not record it.
fn optional(name: &str, field: &str, got: usize, want: usize, of: &str) -> CheckResult {
    if got == 0 { Ok(()) } else { length(name, field, got, want, of) }
}

fn indices(name: &str, field: &str, values: &[u32], nodes: usize) -> CheckResult {
    match values.iter().find(|&&i| i as usize >= nodes) {
        None => Ok(()),
        Some(i) => Err(format!("{name}: {field} refers to node {i}, but there are {nodes} (counted from 0)")),
    }
}
