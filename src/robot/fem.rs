//! The tag `<fem>` of a link, by which Isaac Gym's dialect of URDF describes a soft body.

use glam::{DQuat, DVec3, EulerRot};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// Angle within which a rotation about an axis is a multiple of a right angle: many files write 1.57.
const SQUARE: f64 = 2e-3;

/// Soft body of a link.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FemTag {
    /// Rotation and translation from the axes of the mesh to those of the link, m.
    pub rotation: DQuat,
    pub position: DVec3,
    /// Density, kg/m3; None where the file is silent.
    pub density: Option<f64>,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Distance from the body that carries it within which nodes are bonded, m.
    pub attach: f64,
    /// Name of the file with the mesh, as it stands there.
    pub mesh: String,
    /// Factor from the unit of the mesh to metres.
    pub scale: f64,
}

/// Reads the soft bodies of a URDF by the names of their links.
pub(super) fn read(path: &Path) -> Result<BTreeMap<String, FemTag>, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("cannot be read: {e}"))?;
    let document = Document::parse(&text).map_err(|e| format!("is no readable URDF: {e}"))?;
    let links = document.descendants().filter(|node| node.has_tag_name("link"));
    let soft = links.filter_map(|link| Some((link.attribute("name")?, child(link, "fem")?)));
    soft.map(|(name, fem)| {
        tag(fem).map(|tag| (name.to_string(), tag)).map_err(|e| format!("the <fem> of link {name:?} {e}"))
    })
    .collect()
}

fn child<'a, 'i>(of: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    of.children().find(|node| node.has_tag_name(name))
}

fn tag(fem: Node) -> Result<FemTag, String> {
    let number = |name: &str| match child(fem, name).and_then(|node| node.attribute("value")) {
        Some(text) => match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(format!("has <{name} value={text:?}>; a number is needed")),
        },
        None => Ok(None),
    };
    let needed = |name: &str| number(name)?.ok_or_else(|| format!("has no <{name} value=\"...\">"));
    let vector = |name: &str| -> Result<DVec3, String> {
        let text = child(fem, "origin").and_then(|node| node.attribute(name)).unwrap_or("0 0 0");
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        match numbers[..] {
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err(format!("has an <origin> whose {name} is {text:?}; three numbers are needed")),
        }
    };
    let square = |angle: f64| {
        let right = (angle / FRAC_PI_2).round() * FRAC_PI_2;
        if (angle - right).abs() < SQUARE { right } else { angle }
    };
    let [roll, pitch, yaw] = vector("rpy")?.to_array().map(square);
    let mesh = child(fem, "tetmesh").and_then(|node| node.attribute("filename"));
    Ok(FemTag {
        rotation: DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll),
        position: vector("xyz")?,
        density: number("density")?,
        young: needed("youngs")?,
        poisson: needed("poissons")?,
        attach: needed("attachDistance")?,
        mesh: mesh.ok_or("has no <tetmesh filename=\"...\">")?.to_string(),
        scale: number("scale")?.unwrap_or(1.0),
    })
}
