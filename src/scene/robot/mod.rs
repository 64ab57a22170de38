//! Parallel grippers from robot descriptions (URDF or MJCF): poses of the pads and travel of the fingers.

mod fem;
mod finger;
mod mjcf;
mod mounting;
mod package;
mod soft;
mod tolerance;
mod tree;
mod urdf;
mod xml;

pub use mounting::{Mount, Mounted};
pub use soft::SoftPad;

use finger::{Finger, closing, gripper};
use glam::DVec3;
use std::path::Path;
use tolerance::Deviation;
use tree::LinkTree;
use xml::{XmlElement, XmlReader};

/// Reads the URDF or MJCF description at `path` and locates the pads on the hand whose base is the link `hand`: their
/// sensing faces are centred at the links `pads`, left first. `approach` is the approach direction, an axis of the
/// base.
///
/// URDF links with a `<fem>` are soft pads: their meshes define the sensing faces, and the pads are returned as well.
///
/// # Errors
/// Fails if the file cannot be read, if a link is missing, if the fingers do not form a parallel gripper, or if a soft
/// pad cannot be read or bonded; the message states the file, and the line if known.
pub fn mount(path: &Path, hand: &str, pads: [&str; 2], approach: DVec3) -> Result<Mounted, String> {
    XmlReader::default().file(path, None, |root, reader| match root.tag.as_str() {
        "robot" => {
            let (tree, elements) = urdf::read(&root)?;
            Description { path, tree: &tree, elements: &elements }.mount(hand, pads, approach)
        }
        "mujoco" => {
            let tree = mjcf::read(root, reader)?;
            Description { path, tree: &tree, elements: &[] }.mount(hand, pads, approach)
        }
        _ => Err(root.error("is not a robot description; allowed: <robot> of URDF, <mujoco> of MJCF")),
    })
}

/// Links of a robot description.
struct Description<'a> {
    path: &'a Path,
    tree: &'a LinkTree,
    /// XML elements of the links; empty for MJCF, whose soft bodies are not read.
    elements: &'a [&'a XmlElement],
}

impl Description<'_> {
    fn mount(&self, hand: &str, pads: [&str; 2], approach: DVec3) -> Result<Mounted, String> {
        let named = |message: String| format!("{}: {message}", self.path.display());
        let find = |name: &str| self.tree.find(name).map_err(named);
        let (base, ends) = (find(hand)?, [find(pads[0])?, find(pads[1])?]);
        let finger = |side: usize, face: DVec3| {
            Finger::of(self.tree, base, (ends[side], face)).map_err(|m| named(format!("{:?} {m}", pads[side])))
        };
        let mut deviation = Deviation::default();
        let mut tag = |side: usize| {
            let link = self.elements.get(ends[side]);
            link.map_or(Ok(None), |link| fem::read(self.path, link, &mut deviation))
        };
        let (faces, soft) = match (tag(0)?, tag(1)?) {
            (None, None) => ([DVec3::ZERO; 2], None),
            (Some(left), Some(right)) => {
                let tags = [left, right];
                let fingers = [finger(0, tags[0].pose.translation)?, finger(1, tags[1].pose.translation)?];
                let closing = closing(&fingers, approach, &mut deviation).map_err(named)?;
                let mut place = |side: usize, closing: DVec3| {
                    let directions = [closing, approach].map(|v| fingers[side].rotation.transpose() * v);
                    soft::place(
                        self.path,
                        (self.tree, self.elements),
                        ends[side],
                        &tags[side],
                        directions,
                        &mut deviation,
                    )
                };
                let ((left, left_face), (right, right_face)) = (place(0, closing)?, place(1, -closing)?);
                ([left_face, right_face], Some([left, right]))
            }
            _ => {
                let [left, right] = pads;
                return Err(named(format!("has a <fem> for one of the links {left:?} and {right:?}, not for both")));
            }
        };
        let fingers = [finger(0, faces[0])?, finger(1, faces[1])?];
        let (mount, unequal) = gripper(&fingers, approach, &mut deviation).map_err(named)?;
        let notices: Vec<String> = unequal.into_iter().chain(deviation.notice()).collect();
        let notice = (!notices.is_empty()).then(|| named(notices.join("; ")));
        Ok(Mounted { mount, soft, notice })
    }
}
