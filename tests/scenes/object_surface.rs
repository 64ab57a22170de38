//! Contact surface of a scanned object: it belongs to the object and the thickness of the pads, not to their mesh.

use tactus::base::scales::edge_radius;
use tactus::geometry::mesh::io::write_stl;
use tactus::geometry::shape::{ShapeKind, SurfaceDefinition};
use tactus::model::Model;
use tactus::scene::load;

/// Distances of 200 points from a scanned lemon are the same bits between pads with nodes 1.3, 2.6 and 5.2 mm apart; its
/// edges are rounded by a quarter of the thickness of 4 mm.
#[test]
fn meshes_of_one_pad_touch_the_same_object() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, scene] = ["lemon.stl", "scene.ron"].map(|name| folder.path().join(name));
    let lemon = ShapeKind::Lemon { length: 0.05, diameter: 0.035 }.build(24).unwrap();
    write_stl(&mesh, &lemon.surface).unwrap();
    let objects = ["1.3e-3", "2.6e-3", "5.2e-3"].map(|spacing| {
        let text = format!(
            "(object: (shape: Mesh(\"lemon.stl\")), gripper: (pads: GelSightMini(spacing: {spacing})), loading: Squeeze(force: 4, frames: 2))"
        );
        std::fs::write(&scene, text).unwrap();
        Model::build(&load(&scene).unwrap().scene).unwrap().object.clone()
    });
    let SurfaceDefinition::Smooth(smooth) = &objects[0].definition else { panic!("the surface is not smooth") };
    assert_eq!(smooth.level.spacing(), edge_radius(4e-3));
    for k in 0..200 {
        let (turn, height) = (0.7 * f64::from(k), 0.03 * (f64::from(k) / 100.0 - 1.0));
        let point = glam::DVec3::new(0.018 * turn.cos(), 0.018 * turn.sin(), height);
        let [a, b, c] = objects.each_ref().map(|object| object.distance.distance(point));
        assert!(a == b && b == c, "{a} {b} {c} m at {point}");
    }
}
