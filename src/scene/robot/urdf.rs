//! Links and joints of a URDF.

use super::tree::{Joint, Link, LinkTree, Mimic, Mobility};
use super::xml::XmlElement;
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use std::collections::HashMap;

/// Reads the links of a `<robot>`; returns the tree and the XML elements of the links.
pub(super) fn read(robot: &XmlElement) -> Result<(LinkTree, Vec<&XmlElement>), String> {
    check_expanded(robot)?;
    let mut tree = LinkTree::default();
    let elements: Vec<&XmlElement> = robot.children_with_tag("link").collect();
    let links = by_name(&elements)?;
    for element in &elements {
        let name = element.required_text("name")?.to_string();
        tree.links.push(Link { name, site: false, parent: None, pose: DAffine3::IDENTITY, mobility: Mobility::Fixed });
    }
    let joints: Vec<&XmlElement> = robot.children_with_tag("joint").collect();
    let numbers = by_name(&joints)?;
    for (number, joint) in joints.iter().enumerate() {
        let end = |tag: &str| {
            let name =
                joint.child(tag).ok_or_else(|| joint.error(format_args!("has no <{tag}>")))?.required_text("link")?;
            let missing = || joint.error(format_args!("refers to the link {name:?}, which does not exist"));
            links.get(name).copied().ok_or_else(missing)
        };
        let (parent, child) = (end("parent")?, end("child")?);
        if let Some(first) = tree.links[child].parent {
            let [own, first] = [child, first].map(|i| &tree.links[i].name);
            return Err(joint.error(format_args!("has the child link {own:?}, which is already a child of {first:?}")));
        }
        let link = &mut tree.links[child];
        link.parent = Some(parent);
        link.pose = origin(joint)?;
        link.mobility = mobility(joint, number)?;
        let mimic = joint.child("mimic").map(|mimic| read_mimic(mimic, &numbers)).transpose()?;
        tree.joints.push(Joint { name: joint.required_text("name")?.to_string(), range: range(joint), mimic });
    }
    Ok((tree, elements))
}

/// Rejects unexpanded xacro macros.
fn check_expanded(element: &XmlElement) -> Result<(), String> {
    if element.tag.starts_with("xacro:") {
        return Err(element.error("is a macro; expand the file first: xacro FILE > robot.urdf"));
    }
    element.children.iter().try_for_each(check_expanded)
}

/// Returns the indices of elements by name; fails if a name is not unique.
fn by_name<'a>(elements: &[&'a XmlElement]) -> Result<HashMap<&'a str, usize>, String> {
    let mut numbers = HashMap::new();
    for (number, element) in elements.iter().enumerate() {
        if numbers.insert(element.required_text("name")?, number).is_some() {
            return Err(element.error("has the name of an earlier element; give each a unique name"));
        }
    }
    Ok(numbers)
}

/// Returns the transform given by the `<origin>` of an element, from its axes to those of its parent, m.
pub(super) fn origin(of: &XmlElement) -> Result<DAffine3, String> {
    let Some(origin) = of.child("origin") else { return Ok(DAffine3::IDENTITY) };
    let [xyz, rpy] = [origin.numbers("xyz")?, origin.numbers("rpy")?].map(Option::unwrap_or_default);
    origin.check_radians("rpy", &rpy)?;
    let [roll, pitch, yaw] = rpy;
    let rotation = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
    Ok(DAffine3::from_rotation_translation(rotation, DVec3::from_array(xyz)))
}

fn mobility(joint: &XmlElement, number: usize) -> Result<Mobility, String> {
    match joint.required_text("type")? {
        "fixed" => Ok(Mobility::Fixed),
        "prismatic" => {
            let axis = joint.child("axis").map(|axis| axis.numbers("xyz")).transpose()?.flatten();
            let axis = DVec3::from_array(axis.unwrap_or([1.0, 0.0, 0.0]));
            let unit = axis.try_normalize().ok_or_else(|| joint.error("has an <axis> of zero length"))?;
            Ok(Mobility::Slides { axis: unit, joint: number })
        }
        kind => Ok(Mobility::Other(joint.error(format_args!("is {kind}")))),
    }
}

fn read_mimic(mimic: &XmlElement, numbers: &HashMap<&str, usize>) -> Result<Mimic, String> {
    let name = mimic.required_text("joint")?;
    let missing = || mimic.error(format_args!("refers to the joint {name:?}, which does not exist"));
    let leader = *numbers.get(name).ok_or_else(missing)?;
    let (gear, offset) = (mimic.number("multiplier")?.unwrap_or(1.0), mimic.number("offset")?.unwrap_or(0.0));
    Ok(Mimic { leader, gear, offset })
}

/// Returns the lower and the upper limit of a joint; effort and velocity limits are ignored.
fn range(joint: &XmlElement) -> Result<[f64; 2], String> {
    const WRITE: &str = "write how far the finger slides, in m, as in <limit lower=\"0\" upper=\"0.04\"/>";
    let limit = joint.child("limit").ok_or_else(|| joint.error(format_args!("has no <limit>; {WRITE}")))?;
    let [lower, upper] = [limit.number("lower")?.unwrap_or(0.0), limit.number("upper")?.unwrap_or(0.0)];
    if lower < upper {
        return Ok([lower, upper]);
    }
    let order = if lower > upper { "above" } else { "the same as" };
    Err(joint.error(format_args!("has a <limit> whose lower, {lower}, is {order} its upper, {upper}; {WRITE}")))
}
