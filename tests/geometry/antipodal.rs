//! Sampled antipodal grasps, checked independently of the sampler's own code.

use glam::DVec3;
use std::path::Path;
use tactus::model::grasp::{grasp_poses, keep_first, resolve_grasps, sample_grasps};
use tactus::model::part::object;
use tactus::scene::{GraspCount, Grasps, Scene, load, load_set};

fn scene(shape: &str, antipodal: &str, gripper: &str) -> Scene {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.ron");
    let text = format!(
        "(object: (shape: {shape}), grasps: Antipodal({antipodal}), gripper: ({gripper}), loading: Squeeze(force: 5))"
    );
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene
}

#[test]
fn contacts_face_each_other_within_the_cone_and_the_pads_are_centred_on_them() {
    let set = load_set(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.ron")).unwrap();
    for mut named in set.scenes {
        let name = named.name.as_str().to_string();
        if let Grasps::Antipodal(wanted) = &mut named.scene.grasps {
            wanted.count = tactus::scene::leaf::Count::new(20).unwrap();
        }
        let shape = object::build(&named.scene.object, &mut Vec::new()).unwrap();
        let poses = grasp_poses(&named.scene).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(poses.len(), 20, "{name}");
        // Largest tilt of the scene: 15 degrees, less than the half-angle of the friction cone at 0.8.
        let least = 15_f64.to_radians().cos() - 1e-6;
        for (i, pose) in poses.iter().enumerate() {
            let closing = pose.rotation * DVec3::X;
            let center = pose.transform(DVec3::new(0.0, 0.0, 0.1));
            let [left, right] = [closing, -closing].map(|way| {
                let start = center - way * 0.04;
                assert!(shape.distance.distance(start) > 0.0, "{name} {i}: the object reaches the open pad");
                let hit = shape.ray(start, way).unwrap_or_else(|| panic!("{name} {i}: a pad meets nothing"));
                // The normal is constant on each facet of a mesh.
                assert!(-hit.normal.dot(way) > least, "{name} {i}: normal {} against {way}", hit.normal);
                start + way * hit.t
            });
            assert!(
                (0.5 * (left + right) - center).length() < 1e-6 * shape.bounding_radius.max(1.0),
                "{name} {i}: the pads' centre is the middle of the contacts, m"
            );
            // No vertex of the object is inside the palm, 204 x 63 x 66 mm from the hand's origin.
            for vertex in &shape.surface.vertices {
                let p = pose.inverse_transform(*vertex);
                let inside = p.x.abs() < 0.102 && p.y.abs() < 0.0315 && p.z > 0.0 && p.z < 0.0659;
                assert!(!inside, "{name} {i}: {p} is in the palm");
            }
        }
    }
}

#[test]
fn a_seed_fixes_the_grasps_and_more_grasps_begin_with_the_same_ones() {
    let poses = |antipodal: &str| grasp_poses(&scene("Lemon()", antipodal, "")).unwrap();
    let (five, nine) = (poses("count: 5, seed: 3"), poses("count: 9, seed: 3"));
    assert_eq!(five[..], nine[..5]);
    assert_ne!(five, poses("count: 5, seed: 4"));
    let mut cut = scene("Lemon()", "count: 9, seed: 3", "");
    keep_first(&mut cut.grasps, GraspCount::new(5).unwrap()).unwrap();
    assert_eq!(five, grasp_poses(&cut).unwrap());
}

#[test]
fn points_are_uniform_by_area_and_approaches_about_the_axis() {
    let poses = grasp_poses(&scene("Sphere(radius: 0.02)", "count: 4000, seed: 1", "")).unwrap();
    let mean = |v: &dyn Fn(usize) -> DVec3| (0..poses.len()).map(v).sum::<DVec3>() / poses.len() as f64;
    // The mean of n random unit vectors has a norm of about 1 / sqrt(n) = 0.016.
    assert!(mean(&|i| poses[i].rotation * DVec3::X).length() < 0.05, "closing axes have no preferred direction");
    assert!(mean(&|i| poses[i].rotation * DVec3::Z).length() < 0.05, "approaches have no preferred direction");
    let up = (0..poses.len()).filter(|&i| (poses[i].rotation * DVec3::X).z.abs() > 0.5).count() as f64;
    assert!((up / poses.len() as f64 - 0.5).abs() < 0.03, "half of the axes lie in half of the sphere's area");
}

#[test]
fn rejections_are_counted_and_named() {
    let tube = scene("Annulus(outer: 0.025, inner: 0.015, height: 0.04)", "count: 20", "");
    let Grasps::Antipodal(wanted) = &tube.grasps else { unreachable!() };
    let sampled = sample_grasps(&tube, wanted).unwrap();
    assert_eq!(sampled.poses.len() + sampled.rejected.iter().sum::<usize>(), sampled.tries);
    assert!(sampled.report().contains("occluded by another part of the object"), "{}", sampled.report());
    assert_eq!(resolve_grasps(&tube).unwrap().notices, [sampled.report()]);
}

#[test]
fn an_object_that_does_not_fit_says_why() {
    let refused = |shape: &str, gripper: &str| grasp_poses(&scene(shape, "count: 1", gripper)).unwrap_err().to_string();
    let text = refused("Sphere(radius: 0.05)", "");
    assert!(text.contains("0 antipodal grasps from 2000 tries") && text.contains("too wide"), "{text}");
    let text = refused("Sphere(radius: 0.02)", "stroke: 0.01");
    assert!(text.contains("out of the fingers' stroke"), "{text}");
    let text = refused("Revolve(profile: [(0, -0.02), (0.02, 0.02), (0, 0.02)])", "friction: 0.1");
    assert!(text.contains("opposite normal outside the friction cone"), "{text}");
}

#[test]
fn sampled_grasps_go_through_a_grasp_file_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let lemon = scene("Lemon()", "count: 8, seed: 3", "");
    let (ron, h5) = (dir.path().join("lemon.ron"), dir.path().join("lemon_grasps.h5"));
    std::fs::write(&ron, tactus::scene::to_ron(&lemon).unwrap()).unwrap();
    let mut check = std::process::Command::new(env!("CARGO_BIN_EXE_tactus"));
    let out = check.arg("check").arg(&ron).arg("--export").arg(&h5).output().unwrap();
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(String::from_utf8_lossy(&out.stdout).contains("8 antipodal grasps from"), "the report is printed");
    // Quaternions in files are normalised up to rounding.
    let (read, sampled) = (tactus::model::grasp::read_grasps_h5(&h5).unwrap(), grasp_poses(&lemon).unwrap());
    assert_eq!(read.len(), 8);
    for (a, b) in read.iter().zip(&sampled) {
        assert!(a.position == b.position && a.rotation.abs_diff_eq(b.rotation, 1e-15));
    }
}
