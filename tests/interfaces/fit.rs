//! `tactus fit`: known constants are recovered, the measured curve of a sensor is fitted, and invalid tables are
//! refused with a message.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tactus::backend::choose;
use tactus::bench::fit::{Curve, Fit, FitReport, Parameter, Ranges, fit};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::scene::{Scene, from_ron};
use tactus::world::run::run_grasps;

/// Constants from which a table or scene is made: SI units; `zero` is the depth offset of the table, m.
#[derive(Clone, Copy)]
struct Made {
    young: f64,
    poisson: f64,
    friction: f64,
    zero: f64,
}

/// The values that the fits start from.
const START: Made = Made { young: 3e5, poisson: 0.45, friction: 0.2, zero: 0.0 };
/// Depths of the tables, m.
const DEPTHS: [f64; 6] = [0.3e-3, 0.6e-3, 0.9e-3, 1.2e-3, 1.5e-3, 1.8e-3];

/// Scene of a press into a coarse pad, whose depths exceed those of the table by `zero`.
fn text(made: Made) -> String {
    let Made { young, poisson, friction, zero } = made;
    let depths: Vec<String> = DEPTHS.iter().map(|d| format!("{:e}", d + zero)).collect();
    format!(
        "(object: (shape: Sphere(radius: 6e-3), motion: Fixed),
          gripper: (pads: Box(size: (0.016, 0.016, 0.0045), cells: (4, 4, 2)), opening: 0.02, friction: {friction},
                    fingers: One, material: NeoHookean(young: {young}, poisson: {poisson})),
          loading: Press(depths: [{}]), stepper: Fem(element: Linear, threads: 1))",
        depths.join(", ")
    )
}

fn scene(made: Made) -> Scene {
    from_ron(&text(made)).expect("scene")
}

/// Table of such a press: [`DEPTHS`] and the simulated forces.
fn curve(made: Made) -> Curve {
    let scene = scene(made);
    let model = Model::build(&scene).expect("model");
    let grasps = [(0, grasp_poses(&scene).expect("poses")[0])];
    let outcomes = run_grasps(&model, choose(&scene).expect("stepper").as_ref(), &grasps, 1, &()).expect("run");
    let forces = outcomes[0].measured.curve.iter().map(|(_, force)| *force);
    Curve { points: DEPTHS.into_iter().zip(forces).collect() }
}

fn fitted(made: Made) -> FitReport {
    let report = fit(&scene(START), &curve(made), &Ranges::default(), 2, |_| ()).expect("fit");
    println!("{}", report.text());
    assert!(report.converged());
    report
}

fn of<'a>(report: &'a FitReport, free: &[Parameter]) -> &'a Fit {
    let is = |f: &&Fit| f.free.iter().map(|e| e.parameter).eq(free.iter().copied());
    report.fits.iter().find(is).expect("every parameter, pair and all")
}

/// Asserts that a fitted value is within `allowed` of the true one (SI units).
#[track_caller]
fn near(fit: &Fit, parameter: Parameter, truth: f64, allowed: f64) {
    let found = fit.free.iter().find(|e| e.parameter == parameter).expect("free");
    assert!((found.value - truth).abs() < allowed, "{parameter:?}: {} instead of {truth}", found.value);
}

/// A fit of modulus and depth zero alone recovers those of a simulated curve to 1 % and 1 um. With all four constants
/// free the true values are within the intervals, which are wide because the curve is insensitive to friction.
#[test]
fn constants_of_a_simulated_curve_are_found_again() {
    let made = Made { young: 3.6e5, zero: 30e-6, ..START };
    let report = fitted(made);
    let pair = of(&report, &[Parameter::Young, Parameter::DepthZero]);
    near(pair, Parameter::Young, made.young, 0.01 * made.young);
    near(pair, Parameter::DepthZero, made.zero, 1e-6);
    assert!(pair.largest() < 2e-3, "{}", pair.largest());
    assert!(report.best(1).expect("singles").largest() > 5.0 * pair.largest(), "a single one cannot make up for two");
    let all = of(&report, &Parameter::ALL);
    assert_eq!((report.fits.len(), all.freedom), (11, 2));
    let truth = [made.young, made.poisson, made.friction, made.zero];
    for (estimate, truth) in all.free.iter().zip(truth) {
        let half = estimate.interval.expect("an interval");
        assert!(
            (estimate.value - truth).abs() < half,
            "{:?}: {} +- {half} is not {truth}",
            estimate.parameter,
            estimate.value
        );
    }
}

/// If a table differs from the scene in one constant, that constant explains the difference to 0.1 %, the error of the
/// solver.
#[test]
fn the_constant_that_differs_is_named() {
    let report = fitted(Made { young: 3.4e5, ..START });
    let young = of(&report, &[Parameter::Young]);
    assert_eq!(report.explains, Some(Parameter::Young));
    assert!(report.explained_fraction(young) > 0.999 && young.largest() < 1e-3);
    near(young, Parameter::Young, 3.4e5, 340.0);
    let report = fitted(Made { zero: -25e-6, ..START });
    let zero = of(&report, &[Parameter::DepthZero]);
    assert_eq!(report.explains, Some(Parameter::DepthZero));
    assert!(report.explained_fraction(zero) > 0.999 && zero.largest() < 2e-3);
    near(zero, Parameter::DepthZero, -25e-6, 0.5e-6);
}

#[test]
fn a_scene_that_meets_its_table_has_nothing_to_explain() {
    let mut curve = curve(START);
    curve.points.truncate(2);
    let report = fit(&scene(START), &curve, &Ranges::default(), 2, |_| ()).expect("fit");
    assert_eq!(report.explains, None);
    assert!(report.text().contains("there is no deviation to explain"));
    // Two points allow no fit of all four constants and no interval of a pair.
    assert_eq!(report.fits.len(), 10);
    assert!(report.fits.iter().filter(|f| f.free.len() == 2 && f.freedom == 0).all(|f| f.free[0].interval.is_none()));
}

fn tactus(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

fn file(dir: &Path, name: &str, text: &str) -> PathBuf {
    let path = dir.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Runs the command on the coarse press, asserts exit code 2, and returns stderr.
fn refused(dir: &Path, table: &str, more: &[&str]) -> String {
    let (scene, table) = (file(dir, "press.ron", &text(START)), file(dir, "curve.csv", table));
    let arguments = ["fit", scene.to_str().unwrap(), "--curve", table.to_str().unwrap()];
    let out = tactus(&[&arguments, more].concat());
    assert_eq!(out.status.code(), Some(2), "{}", String::from_utf8_lossy(&out.stdout));
    String::from_utf8_lossy(&out.stderr).into_owned()
}

#[test]
fn tables_that_are_none_are_refused_by_line() {
    let dir = tempfile::tempdir().unwrap();
    let head = "# comment\ndepth_m,force_n\n1e-3,2.0\n";
    for (table, place, says) in [
        ("depth,force\n1e-3,2\n", "curve.csv:1: ", "the header must be `depth_m,force_n`, found `depth,force`"),
        ("", "curve.csv:1: ", "the header must be"),
        (&format!("{head}2e-3,three\n"), "curve.csv:4: ", "force_n must be a number, found `three`"),
        (&format!("{head}2e-3\n"), "curve.csv:4: ", "two numbers, found 1"),
        (&format!("{head}2e-3,1,2\n"), "curve.csv:4: ", "two numbers, found 3"),
        (&format!("{head}2e-3,-1\n"), "curve.csv:4: ", "force_n must be above zero, found -1"),
        (&format!("{head}2e-3,inf\n"), "curve.csv:4: ", "force_n must be a finite number"),
        (&format!("{head}5,1\n"), "curve.csv:4: ", "lengths are in metres"),
        (&format!("{head}0.5e-3,1\n"), "curve.csv:4: ", "depths must increase: 0.0005 m after 0.001 m"),
        (head, "curve.csv: ", "has 1 point; a fit needs at least 2"),
        ("depth_m,force_n\n1e-3,1\n9e-3,2\n", "", "exceeds the thickness of the pad"),
    ] {
        let error = refused(dir.path(), table, &[]);
        assert!(error.contains(place) && error.contains(says), "expected {place}{says} in\n{error}");
    }
    std::fs::write(dir.path().join("curve.csv"), [b'd', 0xff, b'\n']).unwrap();
    let table = dir.path().join("curve.csv");
    let out = tactus(&["fit", "scenes/press_sphere.ron", "--curve", table.to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&out.stderr).contains("curve.csv:1: is not UTF-8 text"));
}

#[test]
fn scenes_and_ranges_that_cannot_be_fitted_are_refused_in_words() {
    let dir = tempfile::tempdir().unwrap();
    let table = "depth_m,force_n\n0.5e-3,1\n1e-3,2\n";
    for (range, says) in [
        ("stiffness=1,2", "is not NAME=LOW,HIGH with NAME one of young, poisson, friction, depth_zero"),
        ("young=2e5", "is not NAME=LOW,HIGH"),
        ("young=0.2,0.5", "stiffness is in pascals"),
        ("poisson=0.4,0.5", "below 0.5"),
        ("friction=0.5,0.1", "the first number is the minimum"),
        ("young=4e5,5e5", "Young's modulus of the scene is 300000, outside its range of 400000 to 500000"),
    ] {
        let error = refused(dir.path(), table, &["--range", range]);
        assert!(error.contains(says), "{range}: expected {says} in\n{error}");
    }
    let table = file(dir.path(), "curve.csv", table);
    let out = tactus(&["fit", "scenes/quickstart.ron", "--curve", table.to_str().unwrap()]);
    assert_eq!(out.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&out.stderr).contains("a fit needs a press"));
}

/// The press of the real GelSight Mini on a coarse, condensed mesh (3.5 mm), and the files of the command. The depth
/// zero explains more than 85 % of the deviation; with depth zero and friction free, all four forces are met within 5
/// %.
#[test]
#[ignore = "thorough: a fit of a measured curve"]
fn the_curve_of_the_real_sensor_is_met_within_5_percent_by_zero_and_friction() {
    let dir = tempfile::tempdir().unwrap();
    let shipped = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/press_sphere.ron")).unwrap();
    let coarse = shipped.replace("spacing: 2.5e-3", "spacing: 3.5e-3");
    let quick =
        coarse.replace("    loading: Press", "    stepper: Fem(solver: Condensed(error: 0.005)),\n    loading: Press");
    assert!(coarse != shipped && quick != coarse);
    let (scene, out) = (file(dir.path(), "press.ron", &quick), dir.path().join("out"));
    let arguments = ["fit", scene.to_str().unwrap(), "--curve", "scenes/press_sphere.csv", "--format", "json", "-o"];
    let ran = tactus(&[&arguments[..], &[out.to_str().unwrap()]].concat());
    assert_eq!(ran.status.code(), Some(0), "{}", String::from_utf8_lossy(&ran.stderr));
    let report: Value = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(report, serde_json::from_slice::<Value>(&std::fs::read(out.join("fit.json")).unwrap()).unwrap());
    assert!(out.join("fit.png").exists() && out.join("fit.svg").exists());

    let fit = |names: &[&str]| {
        let is = |f: &&Value| f["free"].as_array().unwrap().iter().map(|e| &e["parameter"]).eq(names);
        report["fits"].as_array().unwrap().iter().find(is).unwrap()
    };
    let given = report["given_rms"].as_f64().unwrap();
    let explained = |names: &[&str]| 1.0 - (fit(names)["rms"].as_f64().unwrap() / given).powi(2);
    let largest = |names: &[&str]| {
        let residuals = fit(names)["residuals"].as_array().unwrap().iter();
        residuals.map(|r| r.as_f64().unwrap().abs()).fold(0.0, f64::max)
    };
    assert_eq!(report["explains"], "depth_zero");
    assert!(explained(&["depth_zero"]) > 0.85, "{}", explained(&["depth_zero"]));
    assert!(largest(&["depth_zero"]) < 0.06, "{}", largest(&["depth_zero"]));
    for single in ["young", "poisson", "friction"] {
        assert!(explained(&[single]) < 0.85, "{single} explains {}", explained(&[single]));
        assert!(largest(&[single]) > 0.07, "no other one meets the curve: {single} {}", largest(&[single]));
    }
    let pair = ["friction", "depth_zero"];
    assert!(largest(&pair) < 0.05, "{}", largest(&pair));
    let [friction, zero] = [0, 1].map(|k| fit(&pair)["free"][k]["value"].as_f64().unwrap());
    assert!(friction < 0.1 && (20e-6..70e-6).contains(&zero), "friction {friction}, zero {zero} m");
    // Four points and four unknowns: each unknown at an edge of its range adds a degree of freedom, and has no
    // interval.
    let all = fit(&["young", "poisson", "friction", "depth_zero"]);
    let edges = all["free"].as_array().unwrap().iter().filter(|e| e["at_edge"] == true);
    assert!(edges.clone().all(|e| e["interval"].is_null()));
    assert_eq!(all["freedom"], edges.count());
}
