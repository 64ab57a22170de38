//! What a tactile sensor sees: images of the sensing faces against the forces and nodes they are made of.

use crate::env_made::{actions, batch, changed, condensed, config};
use tactus::scene::NamedScene;

/// Numbers of rows and columns: taxels wider than the elements, and much finer.
const GRIDS: [[usize; 2]; 2] = [[5, 4], [120, 100]];
/// Size of the GelSight Mini gel, m.
const SIZE: [f64; 2] = [25.25e-3, 20.75e-3];

/// The task with more observations, of the elements or condensed.
fn seeing(observe: &str) -> Vec<NamedScene> {
    changed(|task| task.replacen("observe: [", &format!("observe: [{observe}, "), 1))
}

fn area([rows, cols]: [usize; 2]) -> f64 {
    SIZE[0] * SIZE[1] / (rows * cols) as f64
}

/// Pressure and shear are the contact force per area of a taxel, whatever its size: their integrals are the wrench, to 1e-5 N of 1 N.
#[test]
fn pressure_and_shear_integrate_to_the_contact_force() {
    for [rows, cols] in GRIDS {
        let images = format!("Pressure(rows: {rows}, cols: {cols}), Shear(rows: {rows}, cols: {cols})");
        let mut sets = [seeing(&images), seeing(&images)];
        sets[1].iter_mut().zip(condensed()).for_each(|(own, other)| own.scene.stepper = other.scene.stepper);
        for set in sets {
            let mut env = batch(&set, config(2));
            env.reset(None, None).unwrap();
            for step in 0..3 {
                let view = env.step(&actions(0, 2, step)).unwrap();
                let pressure = view.obs("pressure").unwrap().chunks_exact(rows * cols);
                let shear = view.obs("shear").unwrap().chunks_exact(rows * cols * 2);
                for ((pressure, shear), wrench) in pressure.zip(shear).zip(view.obs("wrench").unwrap().chunks_exact(6))
                {
                    let sum = |values: &[f32], first: usize, step: usize| -> f64 {
                        let own = values.iter().skip(first).step_by(step);
                        own.map(|v| f64::from(*v)).sum::<f64>() * area([rows, cols])
                    };
                    let found = [sum(shear, 0, 2), sum(shear, 1, 2), -sum(pressure, 0, 1)];
                    assert!(found[2] < -0.5, "the object presses with {found:?} N");
                    for (found, wrench) in found.into_iter().zip(wrench) {
                        let off = (found - f64::from(*wrench)).abs();
                        assert!(off < 1e-5, "{found} N of the image, {wrench} N of the wrench, {rows} x {cols}");
                    }
                }
            }
        }
    }
}

/// Traction is linear between the nodes: however fine the image, it has no holes and no spikes. Over one taxel it changes by at most
/// the largest value times the size of the taxel over the least height of a triangle, here about 1.8 mm.
#[test]
fn a_fine_image_of_the_pressure_is_smooth() {
    let [rows, cols] = GRIDS[1];
    let set = seeing(&format!("Pressure(rows: {rows}, cols: {cols})"));
    let mut env = batch(&set[..1], config(1));
    env.reset(None, None).unwrap();
    let view = env.step(&actions(0, 1, 0)).unwrap();
    for image in view.obs("pressure").unwrap().chunks_exact(rows * cols) {
        let most = image.iter().copied().fold(0.0, f32::max);
        let along = (0..rows).flat_map(|r| (1..cols).map(move |c| (r * cols + c - 1, r * cols + c)));
        let across = (1..rows).flat_map(|r| (0..cols).map(move |c| ((r - 1) * cols + c, r * cols + c)));
        let jump = along.chain(across).map(|(a, b)| (image[a] - image[b]).abs()).fold(0.0, f32::max);
        assert!(jump < 0.15 * most, "{jump} Pa between neighbours, {most} Pa at most");
        assert!(image.iter().all(|p| *p > -0.02 * most), "nothing pulls");
    }
}
