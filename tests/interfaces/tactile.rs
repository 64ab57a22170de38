//! Tactile images of the sensing faces, compared with the nodal forces and positions of which they are made.

use crate::env_made::{STEPS, actions, batch, changed, condensed, config, fem, gnn};
use crate::gnn_made::made;
use std::collections::HashMap;
use std::path::Path;
use std::sync::LazyLock;
use tactus::dataset::DataSet;
use tactus::env::StepView;
use tactus::model::Needs;
use tactus::scene::NamedScene;

/// Numbers of rows and columns: taxels larger than the elements, and much smaller.
const GRIDS: [[usize; 2]; 2] = [[5, 4], [120, 100]];
/// Size of the GelSight Mini gel, m.
const SIZE: [f64; 2] = [25.25e-3, 20.75e-3];
/// Default height of the pads above the hand base, m.
const PLACED: f64 = 0.1;

/// The task with additional observations.
fn seeing(observe: &str) -> Vec<NamedScene> {
    changed(|task| task.replacen("observe: [", &format!("observe: [{observe}, "), 1))
}

fn area([rows, cols]: [usize; 2]) -> f64 {
    SIZE[0] * SIZE[1] / (rows * cols) as f64
}

/// Forces of the taxels, for every backend, and pressure and shear, which are contact force per area, for any size of
/// the taxels: their sums and integrals equal the force of the wrench (1 N) to 1e-5 N. Taxels carry the applied force
/// to 1e-3 of it.
#[test]
fn images_of_the_contact_force_sum_to_the_wrench() {
    let images = |[rows, cols]: [usize; 2]| {
        seeing(&format!("Pressure(rows: {rows}, cols: {cols}), Shear(rows: {rows}, cols: {cols})"))
    };
    let on_condensed = |mut set: Vec<NamedScene>| {
        set.iter_mut().zip(condensed()).for_each(|(own, other)| own.scene.stepper = other.scene.stepper);
        set
    };
    for (name, set, grid, steps) in [
        ("whole pads", images(GRIDS[0]), Some(GRIDS[0]), STEPS),
        ("whole pads", images(GRIDS[1]), Some(GRIDS[1]), 3),
        ("condensed pads", on_condensed(images(GRIDS[0])), Some(GRIDS[0]), STEPS),
        ("condensed pads", on_condensed(images(GRIDS[1])), Some(GRIDS[1]), 3),
        ("network", gnn(fem(), &made().model), None, STEPS),
    ] {
        let mut env = batch(&set, config(2));
        env.reset(None, None).unwrap();
        for step in 0..steps {
            let view = env.step(&actions(0, 2, step)).unwrap();
            let sum = |values: &[f32], first: usize, step: usize| -> f64 {
                values.iter().skip(first).step_by(step).map(|v| f64::from(*v)).sum()
            };
            let is_wrench = |what: &str, found: [f64; 3], wrench: &[f32]| {
                for (axis, (found, wrench)) in found.into_iter().zip(wrench).enumerate() {
                    let off = (found - f64::from(*wrench)).abs();
                    assert!(
                        off < 1e-5,
                        "{name}, {what}: {found} N of the image, {wrench} N of the wrench along {axis}"
                    );
                }
            };
            let wrenches = || view.obs("wrench").unwrap().chunks_exact(6);
            let forces = view.obs("force").unwrap();
            let taxels = view.obs("taxel_force").unwrap().chunks_exact(5 * 4 * 3);
            for (pad, (image, wrench)) in taxels.zip(wrenches()).enumerate() {
                is_wrench(&format!("taxels of pad {pad}"), [0, 1, 2].map(|axis| sum(image, axis, 3)), wrench);
                let applied = f64::from(forces[pad / 2]) / 2.0;
                let carried = -sum(image, 2, 3);
                assert!(
                    (carried - applied).abs() < 1e-3 * applied,
                    "{name}, pad {pad}: {carried} N against {applied} N"
                );
            }
            // Later the force may be at its least, where the object presses with half a newton.
            let Some([rows, cols]) = grid.filter(|_| step < 3) else { continue };
            let pressure = view.obs("pressure").unwrap().chunks_exact(rows * cols);
            let shear = view.obs("shear").unwrap().chunks_exact(rows * cols * 2);
            for ((pressure, shear), wrench) in pressure.zip(shear).zip(wrenches()) {
                let found = [sum(shear, 0, 2), sum(shear, 1, 2), -sum(pressure, 0, 1)].map(|v| v * area([rows, cols]));
                assert!(found[2] < -0.5, "{name}: the object presses with {found:?} N");
                is_wrench(&format!("{rows} x {cols}"), found, wrench);
            }
        }
    }
}

/// Observations by name.
type Seen = HashMap<&'static str, Vec<f32>>;

fn kept(view: StepView, names: &[&'static str]) -> Seen {
    names.iter().map(|name| (*name, view.obs(name).unwrap().to_vec())).collect()
}

/// Numbers of rows and columns of the depth and height maps.
const MAP: [usize; 2] = [40, 48];

/// Observations after one step of a grasp of the ball, shared by tests.
static STEPPED: LazyLock<Seen> = LazyLock::new(|| {
    let ([rows, cols], [many_rows, many_cols]) = (MAP, GRIDS[1]);
    let set = seeing(&format!(
        "Pressure(rows: {many_rows}, cols: {many_cols}), DepthMap(rows: {rows}, cols: {cols}),
         HeightMap(rows: {rows}, cols: {cols}), Markers(rows: 5, cols: 4, pixel: 1e-4)"
    ));
    let mut env = batch(&set[..1], config(1));
    env.reset(None, None).unwrap();
    let names = ["pressure", "depth_map", "height_map", "markers", "object_pose", "taxel_displacement"];
    kept(env.step(&actions(0, 1, 0)).unwrap(), &names)
});

/// Traction is interpolated linearly between the nodes, so a fine image has no holes or spikes: the change from taxel
/// to taxel is at most the largest value times the taxel size over the least height of a triangle (about 1.8 mm).
#[test]
fn a_fine_image_of_the_pressure_is_smooth() {
    let [rows, cols] = GRIDS[1];
    for image in STEPPED["pressure"].chunks_exact(rows * cols) {
        let most = image.iter().copied().fold(0.0, f32::max);
        let along = (0..rows).flat_map(|r| (1..cols).map(move |c| (r * cols + c - 1, r * cols + c)));
        let across = (1..rows).flat_map(|r| (0..cols).map(move |c| ((r - 1) * cols + c, r * cols + c)));
        let jump = along.chain(across).map(|(a, b)| (image[a] - image[b]).abs()).fold(0.0, f32::max);
        assert!(jump < 0.15 * most, "{jump} Pa between neighbours, {most} Pa at most");
        assert!(image.iter().all(|p| *p > -0.02 * most), "nothing pulls");
    }
}

/// Where gel and object touch, the dent follows the surface of the object: at the deepest point the gap is at most
/// 10 um (1/400 of the thickness), and nowhere does the gel penetrate the object between contact samples by more than
/// 5 um.
#[test]
fn the_dent_is_the_mould_of_the_object_where_they_touch() {
    let [rows, cols] = MAP;
    let (depth, height) = (&STEPPED["depth_map"], &STEPPED["height_map"]);
    for (depth, height) in depth.chunks_exact(rows * cols).zip(height.chunks_exact(rows * cols)) {
        let deepest = (0..rows * cols).max_by(|a, b| depth[*a].total_cmp(&depth[*b])).unwrap();
        assert!(depth[deepest] > 1e-4, "{} m deep", depth[deepest]);
        assert!(depth.contains(&0.0), "the ball is not as wide as the pad");
        let apart = -height[deepest] - depth[deepest];
        assert!((0.0..1e-5).contains(&apart), "{apart} m between the dent and the mould at the deepest");
        let into = depth.iter().zip(height).map(|(d, h)| d + h).filter(|v| v.is_finite());
        let worst = into.zip(depth).filter(|(_, d)| **d > 0.0).map(|(v, _)| v).fold(f32::MIN, f32::max);
        assert!(worst < 5e-6, "the gel reaches {worst} m into the object");
    }
}

/// The gel is nearly incompressible and bonded: a pressed face has a dent of more than 0.1 mm and a bulge of more than
/// 1 um around it, and its mean height is below a fifth of the depth of the dent.
#[test]
fn a_height_map_shows_the_dent_and_the_bulge_around_it() {
    let [rows, cols] = MAP;
    for (pad, map) in STEPPED["height_map"].chunks_exact(rows * cols).enumerate() {
        let deepest = map.iter().copied().fold(0.0, f32::min);
        let highest = map.iter().copied().fold(0.0, f32::max);
        let mean = map.iter().sum::<f32>() / map.len() as f32;
        assert!(deepest < -1e-4, "pad {pad}: the ball dents it by {deepest} m only");
        assert!(highest > 1e-6, "pad {pad}: nothing bulges");
        assert!(mean.abs() < 0.2 * deepest.abs(), "pad {pad}: {mean} m on average, {deepest} m at the deepest");
    }
}

/// A rigid ball gives a spherical cap in the depth map: around the deepest point, the depth follows the surface of the
/// ball to 1 um.
#[test]
fn a_ball_leaves_a_spherical_cap_in_the_depth_map() {
    let [rows, cols] = MAP;
    let pose = &STEPPED["object_pose"];
    for (pad, depth) in STEPPED["depth_map"].chunks_exact(rows * cols).enumerate() {
        let at = |k: usize| {
            [(k / cols, rows, 0), (k % cols, cols, 1)].map(|(i, n, a)| SIZE[a] * ((i as f64 + 0.5) / n as f64 - 0.5))
        };
        let deepest = (0..depth.len()).max_by(|a, b| depth[*a].total_cmp(&depth[*b])).unwrap();
        // Height of the ball's surface above its lowest point, in the coordinates of two pads that face each other at
        // the default height.
        let side = [-1.0, 1.0][pad];
        let center = [f64::from(pose[2]) - PLACED, side * f64::from(pose[1])];
        let rise = |k: usize| {
            let [x, y] = at(k);
            0.02 - (0.02f64.powi(2) - (x - center[0]).powi(2) - (y - center[1]).powi(2)).sqrt()
        };
        for (k, found) in depth.iter().enumerate().filter(|(_, d)| **d > 0.0) {
            let wanted = f64::from(depth[deepest]) - (rise(k) - rise(deepest));
            assert!((f64::from(*found) - wanted).abs() < 1e-6, "{found} m in place of {wanted} m at {:?}", at(k));
        }
    }
}

/// Markers move with the face: those at the centres of taxels have the displacements of the taxels, and positions and
/// pixels agree to 10 nm.
#[test]
fn markers_move_with_the_face() {
    let taxels = STEPPED["taxel_displacement"].chunks_exact(3);
    let mut most = 0.0_f32;
    for (k, (marker, taxel)) in STEPPED["markers"].chunks_exact(8).zip(taxels).enumerate() {
        assert_eq!(marker[3..6], *taxel);
        most = taxel.iter().fold(most, |most, u| most.max(u.abs()));
        let rest =
            [(k / 4 % 5, 5, 0), (k % 4, 4, 1)].map(|(i, n, a)| SIZE[a] * ((i as f64 + 0.5) / f64::from(n) - 0.5));
        for axis in 0..2 {
            let moved = f64::from(marker[axis]) - f64::from(marker[3 + axis]);
            assert!((moved - rest[axis]).abs() < 1e-8, "printed at {moved} m, not at {} m", rest[axis]);
            assert!((marker[6 + axis] * 1e-4 - marker[axis]).abs() < 1e-8);
        }
    }
    assert!(most > 1e-4, "{most} m");
}

/// The task with friction `mu`, closing force (N) and node spacing (m).
fn pressing(observe: &str, [mu, force, spacing]: [&str; 3]) -> Vec<NamedScene> {
    changed(|task| {
        let task = task.replacen("observe: [", &format!("observe: [{observe}, "), 1);
        let task = task.replacen("spacing: 8e-3)", &format!("spacing: {spacing}), friction: {mu}"), 1);
        task.replacen("force: (1.0, 2.0), start: 1.5", &format!("force: (1.0, 10.0), start: {force}"), 1)
    })
}

/// Passes the observations after the hand has closed on the ball to `look`.
fn closed(observe: &str, numbers: [&str; 3], look: impl Fn(StepView)) {
    let set = pressing(observe, numbers);
    let mut env = batch(&set[..1], config(1));
    look(env.reset(None, None).unwrap());
}

/// The torque about the centre of the face is that of the normal force at the centre of pressure, to a lever of 0.1 mm:
/// the remainder is due to shear on a face that is not flat.
#[test]
fn the_centre_of_pressure_is_the_lever_of_the_torque() {
    closed("CenterOfPressure", ["0.8", "1.5", "8e-3"], |view| {
        let centers = view.obs("center_of_pressure").unwrap().chunks_exact(3);
        for (center, wrench) in centers.zip(view.obs("wrench").unwrap().chunks_exact(6)) {
            let [force, x, y] = [wrench[2], wrench[3], wrench[4]];
            let lever = [-y / force, x / force];
            for (center, lever) in center.iter().zip(lever) {
                assert!((center - lever).abs() < 1e-4, "{center} m, a lever of {lever} m");
            }
            assert!((-2e-3..0.0).contains(&center[2]), "pressed in by {} m", -center[2]);
        }
    });
}

/// Numbers of rows and columns of the maps of [`SQUEEZED`].
const FINE: [usize; 2] = [100, 80];

/// Observations of finite elements after the hand has closed on the ball with 8 N, shared by tests.
static SQUEEZED: LazyLock<Seen> = LazyLock::new(|| {
    let [rows, cols] = FINE;
    let maps = format!("ContactArea, DepthMap(rows: {rows}, cols: {cols}), HeightMap(rows: {rows}, cols: {cols})");
    let set = pressing(&maps, ["0.8", "8.0", "2.6e-3"]);
    let mut env = batch(&set[..1], config(1));
    kept(env.reset(None, None).unwrap(), &["contact_area", "depth_map", "height_map"])
});

/// The contact area equals the area where the gap is below 10 um, to 15 %: each contact sample represents 0.4 mm2 of
/// 13 mm2.
#[test]
fn the_contact_area_is_that_where_the_gel_lies_on_the_object() {
    let [rows, cols] = FINE;
    let (depth, height) = (&SQUEEZED["depth_map"], &SQUEEZED["height_map"]);
    let images = depth.chunks_exact(rows * cols).zip(height.chunks_exact(rows * cols));
    for ((depth, height), found) in images.zip(&SQUEEZED["contact_area"]) {
        let touches = depth.iter().zip(height).filter(|(d, h)| **d > 0.0 && **d + **h > -1e-5).count();
        let seen = touches as f64 * area([rows, cols]);
        assert!(seen > 1e-5 && (f64::from(*found) / seen - 1.0).abs() < 0.15, "{found} m2, by the gaps {seen} m2");
    }
}

/// The whole contact slips without friction, none of it at a friction of 100, less than a tenth of its centre at 0.3.
#[test]
fn slip_is_all_nothing_or_at_the_rim() {
    let observe = "Slip(rows: 9, cols: 9), Pressure(rows: 9, cols: 9)";
    let extremes = |mu: &str, wanted: f32| {
        closed(observe, [mu, "1.5", "8e-3"], |view| {
            let pressed =
                view.obs("pressure").unwrap().iter().zip(view.obs("slip").unwrap()).filter(|(p, _)| **p > 0.0);
            let slips: Vec<f32> = pressed.map(|(_, slip)| *slip).collect();
            assert!(slips.len() > 8 && slips.iter().all(|s| (s - wanted).abs() < 1e-6), "friction {mu}: {slips:?}");
        });
    };
    extremes("0", 1.0);
    extremes("100", 0.0);
    closed(observe, ["0.3", "1.5", "8e-3"], |view| {
        let slip = view.obs("slip").unwrap();
        assert!(slip.iter().all(|s| (0.0..=1.0).contains(s)));
        let middle = 9 * 4 + 4;
        assert!(slip[middle] < 0.1, "{} of the middle slides", slip[middle]);
    });
}

/// A network has no contact samples: contact area and slip follow from its nodal forces. The area of the shipped
/// network agrees with that of finite elements to 50 %, and a ball that is held does not slip at the centre of the
/// contact.
#[test]
fn a_network_says_what_touches_and_slides() {
    let set = gnn(pressing("ContactArea, Slip(rows: 9, cols: 9)", ["0.8", "8.0", "2.6e-3"]), Path::new("universe"));
    let mut env = batch(&set[..1], config(1));
    let view = env.reset(None, None).unwrap();
    let [network, slip] = ["contact_area", "slip"].map(|name| view.obs(name).unwrap());
    let elements = &SQUEEZED["contact_area"];
    for (elements, network) in elements.iter().zip(network) {
        assert!((network / elements - 1.0).abs() < 0.5, "{network} m2 of the network, {elements} m2 of elements");
    }
    assert!(slip.iter().all(|slip| (0.0..=1.0).contains(slip)) && slip[9 * 4 + 4] == 0.0, "{slip:?}");
}

/// A data set computed on a finer mesh holds the tactile images of a run bit for bit.
#[test]
fn a_data_set_holds_the_images_of_a_run() {
    let scene = "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3), friction: 0.2), stepper: Fem(mesh: (finer: 1.2)),
        loading: Squeeze(force: 2.0, frames: 2), record: (vtu: false, pictures: false, tactile: [Pressure(), Slip(rows: 3, cols: 2)]))";
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, scene).unwrap();
    for (command, out) in [("run", "run"), ("dataset", "set")] {
        let mut tactus = std::process::Command::new(env!("CARGO_BIN_EXE_tactus"));
        let output = tactus.arg(command).arg(&path).arg("-o").arg(dir.path().join(out)).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let set = DataSet::open(dir.path().join("set")).unwrap();
    let grasp = set.objects[0].grasp(0).unwrap();
    let file = std::fs::File::open(dir.path().join("run/grasp_000/arrays.npz")).unwrap();
    let mut run = ndarray_npy::NpzReader::new(file).unwrap();
    let names: Vec<_> = grasp.tactile.iter().map(|array| (array.name.as_str(), array.unit.as_str())).collect();
    assert_eq!(names, [("pressure_pa", "Pa"), ("slip", "1")]);
    for array in &grasp.tactile {
        let own: ndarray::ArrayD<f32> = run.by_name(&array.name).unwrap();
        assert_eq!(own.shape(), array.shape, "{}", array.name);
        assert!(own.iter().eq(&array.values) && own.iter().any(|v| *v != 0.0), "{}", array.name);
    }
    assert!(tactus::scene::from_ron(&scene.replace("Pressure()", "Wrench")).is_err(), "runs have it anyway");
}

/// Quantities that a scene does not request are not computed.
#[test]
fn nothing_is_computed_that_the_scene_does_not_ask_for() {
    let needs = |record: &str| {
        let scene = format!(
            "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3)), loading: Squeeze(force: 2.0),
              record: (fields: [], {record}))"
        );
        Needs::from_scene(&tactus::scene::from_ron(&scene).unwrap())
    };
    let none = needs("");
    assert!(!none.tactile && !none.slip && !none.contact_area && !none.contact_force);
    let shape = needs("tactile: [HeightMap()]");
    assert!(shape.tactile && !shape.slip && !shape.contact_area && !shape.contact_force);
    let slip = needs("tactile: [Slip()]");
    assert!(slip.tactile && slip.slip && slip.contact_force && !slip.contact_area);
}
