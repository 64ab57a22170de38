//! Pads from a file, simulated on a finer mesh of their shape.

use crate::keep::Keep;
use tactus::backend::choose;
use tactus::geometry::mesh::io::write_tet;
use tactus::geometry::pad::{Resolution, box_pad};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::scene::load;
use tactus::world::run::run_grasps;

/// A pad read from a file and the box from which the file was written, both on meshes twice as fine as the file, are
/// pressed to the same travel by a ball within 1 %, and differ from the mesh of the file by more than that.
#[test]
fn a_pad_from_a_file_is_simulated_on_a_finer_mesh_of_its_shape() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, path] = ["pad.tet", "scene.ron"].map(|name| folder.path().join(name));
    let pad = box_pad(0.016, 0.012, 0.004, &Resolution::spacing(4e-3)).unwrap();
    write_tet(&mesh, &pad.mesh).unwrap();
    let travel = |pads: &str, finer: &str| {
        let text = format!(
            "(object: (shape: Sphere(radius: 0.01)), gripper: (pads: {pads}), loading: Squeeze(force: 4, frames: 1),
              stepper: Fem({finer}))"
        );
        std::fs::write(&path, text).unwrap();
        let scene = load(&path).unwrap().scene;
        let model = Model::build(&scene).unwrap();
        let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
        let frames = Keep::default();
        run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 1, &frames).unwrap();
        let frames = frames.0.into_inner().unwrap();
        frames[0].travel[0]
    };
    let file = travel("File(\"pad.tet\")", "mesh: (finer: 2.0)");
    let made = travel("Box(size: (0.016, 0.012, 0.004), spacing: 4e-3)", "mesh: (finer: 2.0)");
    let coarse = travel("File(\"pad.tet\")", "");
    assert!((file / made - 1.0).abs() < 0.01, "{file} m from the file, {made} m generated");
    assert!((coarse / made - 1.0).abs() > 0.01, "{coarse} m on the mesh of the file, {made} m on the finer one");
}
