//! Bodies and sites of an MJCF model, with includes, default classes, frames and attached models, as in MuJoCo.

mod defaults;
mod include;
mod orientation;

use super::tree::{Joint, Link, LinkTree, MAX_LINKS, Mimic, Mobility};
use super::xml::{XmlElement, XmlReader};
use defaults::{Defaults, MAIN};
use glam::{DAffine3, DVec3};
use orientation::Compiler;
use std::collections::HashMap;

/// Name of the root link.
const WORLD: &str = "world";

/// Reads the links of a `<mujoco>`; a site is a link fixed to its body.
pub(super) fn read(mut root: XmlElement, reader: &mut XmlReader) -> Result<LinkTree, String> {
    let folder = root.folder().to_path_buf();
    include::expand(&mut root, &folder, 0, reader)?;
    let mut model = Model::default();
    root.children_with_tag("compiler").try_for_each(|compiler| model.compiler.add(compiler))?;
    root.children_with_tag("default").for_each(|class| model.defaults.add(class, MAIN));
    for asset in root.children_with_tag("asset").flat_map(|asset| asset.children_with_tag("model")) {
        let path = folder.join(asset.required_text("file")?);
        let (name, tree) = reader.file(&path, Some(asset), |root, reader| match root.tag.as_str() {
            "mujoco" => {
                let name = asset.text("name").or(root.text("model")).unwrap_or_default().to_string();
                Ok((name, read(root, reader)?))
            }
            _ => Err(root.error("is not <mujoco>, the only element that can be attached")),
        })?;
        model.attachable.insert(name, tree);
    }
    let mobility = Mobility::Fixed;
    model.tree.links.push(Link { name: WORLD.into(), site: false, parent: None, pose: DAffine3::IDENTITY, mobility });
    let world = Context { body: 0, class: MAIN, frame: DAffine3::IDENTITY };
    root.children_with_tag("worldbody").try_for_each(|body| model.add(body, &world))?;
    let numbers: HashMap<String, usize> =
        (0..).zip(&model.tree.joints).map(|(number, joint): (usize, &Joint)| (joint.name.clone(), number)).collect();
    root.children_with_tag("equality")
        .flat_map(|all| all.children_with_tag("joint"))
        .try_for_each(|equality| model.couple(equality, &numbers))?;
    Ok(model.tree)
}

/// Model being read.
#[derive(Default)]
struct Model {
    compiler: Compiler,
    defaults: Defaults,
    /// Models of `<asset>` by name.
    attachable: HashMap<String, LinkTree>,
    tree: LinkTree,
}

/// Context of the elements being read.
struct Context<'a> {
    /// Index of the enclosing body.
    body: usize,
    /// Default class of elements that name none.
    class: &'a str,
    /// Transform from the innermost frame to the body, m.
    frame: DAffine3,
}

impl Model {
    /// Adds the contents of a body or a frame.
    fn add(&mut self, of: &XmlElement, context: &Context) -> Result<(), String> {
        for element in &of.children {
            let class = element.text("childclass").unwrap_or(context.class);
            match element.tag.as_str() {
                "body" => {
                    let pose = context.frame * self.compiler.pose(element)?;
                    let body = self.link(element, context, pose, false);
                    self.add(element, &Context { body, class, frame: DAffine3::IDENTITY })?;
                }
                "frame" => {
                    let frame = context.frame * self.compiler.pose(element)?;
                    self.add(element, &Context { body: context.body, class, frame })?;
                }
                "site" => {
                    let merged = self.defaults.apply(element, class)?;
                    let pose = context.frame * self.compiler.pose(&merged)?;
                    self.link(element, context, pose, true);
                }
                "joint" | "freejoint" => {
                    let mobility = self.joint(element, context)?;
                    let own = &mut self.tree.links[context.body].mobility;
                    *own = match own {
                        Mobility::Fixed => mobility,
                        _ => Mobility::Other(element.error("is the second joint of its body")),
                    };
                }
                "attach" => self.attach(element, context)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn link(&mut self, element: &XmlElement, context: &Context, pose: DAffine3, site: bool) -> usize {
        let name = element.text("name").unwrap_or_default().to_string();
        self.tree.links.push(Link { name, site, parent: Some(context.body), pose, mobility: Mobility::Fixed });
        self.tree.links.len() - 1
    }

    fn joint(&mut self, own: &XmlElement, context: &Context) -> Result<Mobility, String> {
        let joint = self.defaults.apply(own, context.class)?;
        let kind = if own.tag == "freejoint" { "free" } else { joint.text("type").unwrap_or("hinge") };
        let range = self.range(&joint, kind);
        self.tree.joints.push(Joint { name: joint.text("name").unwrap_or_default().into(), range, mimic: None });
        if kind != "slide" {
            return Ok(Mobility::Other(own.error(format_args!("is of type {kind}"))));
        }
        let axis = joint.numbers("axis")?.map_or(DVec3::Z, DVec3::from_array);
        let unit = axis.try_normalize().ok_or_else(|| own.error("has an axis of zero length"))?;
        Ok(Mobility::Slides { axis: context.frame.transform_vector3(unit), joint: self.tree.joints.len() - 1 })
    }

    /// Returns the lower and the upper limit of a joint relative to its reference position `ref`.
    fn range(&self, joint: &XmlElement, kind: &str) -> Result<[f64; 2], String> {
        const RANGE_ADVICE: &str = "write how far the finger slides, in m, as in range=\"0 0.04\"";
        let limited = match joint.text("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.compiler.autolimits,
        };
        let range: Option<[f64; 2]> = joint.numbers("range")?;
        let [a, b] = match range {
            Some(range) if limited => range,
            Some(_) => return Err(joint.error("has a range, but is not limited; write limited=\"true\"")),
            None => return Err(joint.error(format_args!("has no range; {RANGE_ADVICE}"))),
        };
        if a >= b {
            let order = if a > b { "decreasing" } else { "empty" };
            return Err(joint.error(format_args!("has a range from {a} to {b}, which is {order}; {RANGE_ADVICE}")));
        }
        let drawn = joint.number("ref")?.unwrap_or(0.0);
        let scale = if kind == "hinge" && self.compiler.degrees { 1f64.to_radians() } else { 1.0 };
        Ok([a, b].map(|position| (position - drawn) * scale))
    }

    /// Adds the body named by an `<attach>` with its subtree, or the whole world of the model if it names none.
    fn attach(&mut self, attach: &XmlElement, context: &Context) -> Result<(), String> {
        let (model, prefix) = (attach.required_text("model")?, attach.text("prefix").unwrap_or_default());
        let missing = || attach.error(format_args!("refers to the model {model:?}, which no <asset> defines"));
        let other = self.attachable.get(model).ok_or_else(missing)?;
        let root = match attach.text("body") {
            Some(body) => {
                other.find(&format!("body:{body}")).map_err(|e| attach.error(format_args!("{model:?} {e}")))?
            }
            None => 0,
        };
        if self.tree.links.len() + other.links.len() > MAX_LINKS {
            return Err(attach.error(format_args!("results in more than {MAX_LINKS} links")));
        }
        let joints = self.tree.joints.len();
        let prefixed = |name: &str| if name.is_empty() { String::new() } else { format!("{prefix}{name}") };
        self.tree.joints.extend(other.joints.iter().map(|joint| Joint {
            name: prefixed(&joint.name),
            range: joint.range.clone(),
            mimic: joint.mimic.clone().map(|mimic| Mimic { leader: mimic.leader + joints, ..mimic }),
        }));
        // Parents precede their children in the list.
        let mut taken: Vec<Option<usize>> = vec![None; other.links.len()];
        for (number, link) in other.links.iter().enumerate() {
            let carrier = link.parent.and_then(|parent| taken[parent]);
            let (parent, pose) = match carrier {
                _ if number == root && root == 0 => {
                    taken[0] = Some(context.body);
                    continue;
                }
                _ if number == root => (context.body, context.frame * link.pose),
                Some(parent) if parent == context.body => (parent, context.frame * link.pose),
                Some(parent) => (parent, link.pose),
                None => continue,
            };
            let mobility = match &link.mobility {
                Mobility::Slides { axis, joint } => Mobility::Slides { axis: *axis, joint: joint + joints },
                other => other.clone(),
            };
            taken[number] = Some(self.tree.links.len());
            self.tree.links.push(Link {
                name: prefixed(&link.name),
                site: link.site,
                parent: Some(parent),
                pose,
                mobility,
            });
        }
        Ok(())
    }

    /// Applies an equality of joints: the first joint follows the second.
    fn couple(&mut self, equality: &XmlElement, numbers: &HashMap<String, usize>) -> Result<(), String> {
        if equality.text("active") == Some("false") {
            return Ok(());
        }
        let find = |name: &str| {
            let missing = || equality.error(format_args!("refers to the joint {name:?}, which does not exist"));
            numbers.get(name).copied().ok_or_else(missing)
        };
        let follower = find(equality.required_text("joint1")?)?;
        let leader = equality.text("joint2").map(find).transpose()?;
        let mut polynomial = [0.0, 1.0, 0.0, 0.0, 0.0];
        let given = equality.list("polycoef")?.unwrap_or_default();
        polynomial.iter_mut().zip(given).for_each(|(own, given)| *own = given);
        let [offset, gear, bent @ ..] = polynomial;
        let joint = &mut self.tree.joints[follower];
        match leader {
            Some(_) if joint.mimic.is_some() => {
                joint.mimic = None;
                joint.range = Err(equality.error("is the second one for its first joint"));
            }
            Some(_) if bent != [0.0; 3] => {
                joint.range = Err(equality.error(
                    "has a polycoef of higher than first order; only a linear relation between fingers is supported",
                ));
            }
            Some(leader) => joint.mimic = Some(Mimic { leader, gear, offset }),
            None => joint.range = Err(equality.error(format_args!("fixes joint {:?}", joint.name))),
        }
        Ok(())
    }
}
