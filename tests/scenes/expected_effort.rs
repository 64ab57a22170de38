//! Number of iterations that `check` predicts for a run, against measurements.

use std::path::Path;
use tactus::model::Model;
use tactus::scene::load_set;
use tactus::world::run::expected_time::{EXPECTED_TIME_FACTOR, ExpectedTime};

/// Name and number of Newton iterations of each hard case that reaches its force, from `docs/results.md`.
fn measured() -> Vec<(String, f64)> {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results.md")).unwrap();
    let table = text.split("<!-- table hard_cases").nth(1).unwrap().split("<!-- end -->").next().unwrap();
    let rows = table.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
    let reached = rows.filter(|row| row.get(2) == Some(&"reached"));
    reached.map(|row| (row[1].to_string(), row[3].parse().unwrap())).collect()
}

/// In at least seven of eight hard cases the predicted number of iterations is right to within the factor
/// [`EXPECTED_TIME_FACTOR`].
#[test]
fn hard_cases_take_the_iterations_that_are_expected() {
    let (mut all, mut off) = (0, Vec::new());
    for (name, iterations) in measured() {
        let at = |folder: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{folder}/{name}.ron"));
        let Some(path) = ["torture", "dynamic"].map(at).into_iter().find(|path| path.exists()) else { continue };
        let scene = load_set(&path).unwrap().scenes.swap_remove(0).scene;
        let expected = ExpectedTime::of(&scene, &Model::build(&scene).unwrap(), 1, 1).iterations;
        let factor = (iterations / expected).max(expected / iterations);
        all += 1;
        if factor > f64::from(EXPECTED_TIME_FACTOR) {
            off.push(format!("{name}: {iterations} iterations, expected {expected}"));
        }
    }
    assert!(all > 60, "{all} cases");
    assert!(8 * off.len() <= all, "{} of {all}: {}", off.len(), off.join("; "));
}
