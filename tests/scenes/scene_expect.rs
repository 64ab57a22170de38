//! Evaluation of expectations: they hold or fail as measured, and fail where nothing was measured.

use tactus::model::evaluation::{Findings, GraspMeasurements, Verdict, evaluate, evaluate_all};
use tactus::record::Status;
use tactus::scene::*;

fn expectations(text: &str) -> Vec<Expectation> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    let text = format!("(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 15), expect: [{text}])");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene.expect
}

fn judge(text: &str, measured: &GraspMeasurements) -> Verdict {
    evaluate(&expectations(text)[0], measured)
}

const FINE: Findings = Findings { finite: true, min_det_f: 0.6, penetration: 1e-7, offset: 1e-5, imbalance: 1e-4 };

fn audited(findings: Findings) -> GraspMeasurements {
    GraspMeasurements { findings: Some(findings), ..good() }
}

fn good() -> GraspMeasurements {
    GraspMeasurements {
        status: Status::Reached,
        reason: String::new(),
        force_n: 15.0,
        travel_m: [1.5e-3, 1.7e-3],
        findings: Some(FINE),
        force_balance: 1e-5,
        torque_balance: 2e-5,
        max_stress_pa: 1e5,
        curve: vec![(1e-3, 5.0), (2e-3, 15.0)],
        ..GraspMeasurements::default()
    }
}

const ALL: &str =
    "ReachesForce, ForceBalance(relative: 1e-3), TorqueBalance(relative: 1e-3), NoInversion, NoPenetration,
    Finite, Penetration(at_most: 1e-6), Converged(relative: 1e-3),
    Travel(at_most: 2e-3, at_least: 1e-3), Force(at_least: 14.9), ForceAt(depth: 1.5e-3, force: 10.5, relative: 0.05),
    MaxStress(at_most: 2e5)";

#[test]
fn all_hold_of_a_good_grasp_and_none_of_an_unmeasured_one() {
    for e in expectations(ALL) {
        assert!(evaluate(&e, &good()).held, "{e:?}");
        let nothing = evaluate(&e, &GraspMeasurements::default());
        assert!(!nothing.held && nothing.value.is_none(), "{e:?}");
        assert_eq!(nothing.name, e.name());
    }
}

#[test]
fn the_violated_bound_is_shown() {
    let held = judge("Travel(at_most: 1.6e-3)", &good());
    assert_eq!((held.held, held.value, held.bound, &*held.unit), (false, Some(1.7e-3), Some(1.6e-3), "m"));
    let held = judge("Force(at_least: 16, at_most: 20)", &good());
    assert_eq!((held.held, held.value, held.bound, &*held.unit), (false, Some(15.0), Some(16.0), "N"));
    // the first finger violates the bound, the second does not
    let held = judge("Travel(at_least: 1.6e-3)", &good());
    assert_eq!((held.held, held.value), (false, Some(1.5e-3)));
    // a press with one finger has one travel
    assert!(judge("Travel(at_most: 2e-3)", &GraspMeasurements { travel_m: [1e-3, f64::NAN], ..good() }).held);
}

#[test]
fn inversion_and_penetration_are_noticed() {
    assert!(!judge("NoInversion", &audited(Findings { min_det_f: -0.1, ..FINE })).held);
    assert!(!judge("NoInversion", &audited(Findings { min_det_f: 0.0, ..FINE })).held);
    assert!(!judge("NoPenetration", &audited(Findings { penetration: 1.1e-5, ..FINE })).held);
    assert!(judge("NoPenetration", &audited(Findings { penetration: 0.0, ..FINE })).held);
    assert!(!judge("Penetration(at_most: 2e-5)", &audited(Findings { penetration: 3e-5, ..FINE })).held);
    assert!(!judge("Converged(relative: 1e-3)", &audited(Findings { imbalance: 2e-3, ..FINE })).held);
    assert!(!judge("Finite", &audited(Findings { finite: false, ..FINE })).held);
}

#[test]
fn the_worst_frame_counts_and_nan_is_worse_than_any_number() {
    let worst = FINE.merge_worst(Findings { min_det_f: 0.1, penetration: f64::NAN, ..FINE }).merge_worst(FINE);
    assert_eq!((worst.min_det_f, worst.imbalance, worst.finite), (0.1, 1e-4, true));
    assert!(worst.penetration.is_nan() && !judge("NoPenetration", &audited(worst)).held);
}

#[test]
fn force_at_a_depth_is_interpolated_and_never_extrapolated() {
    let at = |depth: &str| judge(&format!("ForceAt(depth: {depth}, force: 1, relative: 1e-9)"), &good()).value;
    assert_eq!(at("0.5e-3"), Some(2.5));
    assert_eq!(at("2e-3"), Some(15.0));
    assert_eq!(at("2.1e-3"), None);
}

#[test]
fn failures_can_be_expected() {
    let fault =
        GraspMeasurements { status: Status::Fault, reason: "line search: no step below 1e-12".into(), ..good() };
    assert!(judge("Fault(contains: \"line search\")", &fault).held);
    assert!(judge("Fault()", &fault).held);
    assert!(!judge("Fault(contains: \"stroke\")", &fault).held);
    assert!(!judge("Infeasible()", &fault).held);
    assert!(!judge("Fault()", &good()).held);
    let reached = judge("ReachesForce", &fault);
    assert_eq!((reached.held, reached.detail.as_deref()), (false, Some("fault: line search: no step below 1e-12")));
}

#[test]
fn of_several_grasps_the_worst_speaks_and_no_grasp_proves_nothing() {
    let e = &expectations("NoInversion")[0];
    let bad = audited(Findings { min_det_f: -1.0, ..FINE });
    assert_eq!(evaluate_all(e, &[good(), bad, good()]).value, Some(-1.0));
    assert!(evaluate_all(e, &[good(), good()]).held);
    assert!(!evaluate_all(e, &[]).held);
    let e = &expectations("NoPenetration")[0];
    let deep = |penetration: f64| audited(Findings { penetration, ..FINE });
    assert_eq!(evaluate_all(e, &[deep(1e-6), deep(8e-6), deep(2e-6)]).value, Some(8e-6));
    assert_eq!(evaluate_all(e, &[deep(2e-5), deep(5e-5), deep(1e-6)]).value, Some(5e-5));
}
