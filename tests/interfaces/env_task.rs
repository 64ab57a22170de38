//! The task of a scene: errors are reported with their place, rewards have their documented values, and a grasp holds
//! the Coulomb limit.

use crate::env_made::{batch, changed, config, fem};
use tactus::env::StepInfo;
use tactus::env::reward::{RewardTerm, term};
use tactus::scene::Reward;
use tactus::scene::load;
use tactus::scene::reward::{EconomyReward, HoldReward, SlipReward};

#[test]
fn mistakes_in_a_task_are_reported_in_place() {
    let refusal = |task: &str, rest: &str| {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.ron");
        let text = format!("(object: (shape: Sphere(radius: 0.02)),\n{rest} task: ({task}))");
        std::fs::write(&path, text).unwrap();
        load(&path).unwrap_err().to_string()
    };
    let squeeze = "loading: Squeeze(force: 5),";
    let falling = refusal("force: (5, 1)", squeeze);
    assert!(falling.contains("t.ron:2:") && falling.contains("the first number is the minimum"), "{falling}");
    assert!(refusal("force: (1, 2), start: 3", squeeze).contains("must lie within the allowed force, 1 to 2 N"));
    assert!(refusal("observe: []", squeeze).contains("the agent has no observations"));
    assert!(refusal("observe: [Force, Force]", squeeze).contains("two observations have the same name"));
    assert!(refusal("gravity: (0, 0, inf)", squeeze).contains("finite"));
    assert!(refusal("", "loading: Squeeze(force: 5), gravity: (0, 0, -9.81),").contains("move `gravity` into `task`"));
    assert!(refusal("", "loading: Press(depth: 1e-3),").contains("a task squeezes by force"));
    assert!(refusal("rewrad: []", squeeze).contains("reward"), "the nearest field is named");
}

#[test]
fn rewards_pay_what_they_say() {
    let info = StepInfo { held: true, slip: 2e-3, force: 5.0, max_force: 10.0, stress: 3e4, ..StepInfo::default() };
    let hold = HoldReward::default();
    assert_eq!((hold.reward(&info), hold.reward(&StepInfo { held: false, ..info })), (1.0, -10.0));
    assert_eq!(SlipReward::default().reward(&info), -2.0, "per mm");
    assert_eq!(EconomyReward::default().reward(&info), -0.5);
    let stress: Reward = tactus::scene::dialect::options().from_str("Stress(limit: 2e4)").unwrap();
    assert!((term(&stress).reward(&info) + 0.5).abs() < 1e-12, "half as much again as the limit");
    assert!(term(&stress).needs_stress() && !hold.needs_stress());
}

#[test]
fn a_reward_of_the_users_own_replaces_that_of_the_scene() {
    let mut env = batch(&fem(), config(1)).with_reward(|info| info.force);
    env.reset(None, None).unwrap();
    assert_eq!(env.step(&[1.0]).unwrap().reward(), [2.0], "the largest force, N");
}

#[test]
fn friction_holds_what_coulomb_says_and_no_more() {
    // Two pads with friction 0.8 and a normal force of 1 N each hold up to 1.6 N, the weight of 163 g.
    let outcome = |grams: f64| {
        let density = grams * 1e-3 / (4.0 / 3.0 * std::f64::consts::PI * 0.02_f64.powi(3));
        let ball = r#"objects: [(name: "ball", object: (shape: Sphere(radius: 0.02)), grasps: List([(position: (0, 0, -0.1))]))],"#;
        let set = changed(|text| {
            let head = text.find("objects:").unwrap();
            let tail = text.find("gripper:").unwrap();
            let text = format!("{}{ball}\n{}", &text[..head], &text[tail..]);
            let text = text.replace("pushes: (force: (0.02, 0.1), every: 3, lasts: 2),", "");
            text.replace("randomise: (density: (300, 600), shift: 1e-3, turn_deg: 2),", "")
                .replace("(shape: Sphere(radius: 0.02))", &format!("(shape: Sphere(radius: 0.02), density: {density})"))
        });
        let friction = set[0].scene.gripper.friction.get();
        let mut env = batch(&set, config(1));
        env.reset(None, None).unwrap();
        let mut margins = Vec::new();
        loop {
            let view = env.step(&[1.0]).unwrap();
            let info = view.info()[0];
            let expected = 1.0 - info.load / (friction * 2.0);
            if info.held {
                assert!((info.margin - expected).abs() < 0.03, "{} against {expected}", info.margin);
                margins.push(info.margin);
            }
            if view.ended()[0] {
                return (view.truncated()[0], margins, view.fault(0).map(str::to_owned));
            }
        }
    };
    let (held, margins, _) = outcome(130.0);
    assert!(held && margins.len() == 5, "1.28 N of 1.6 N: {margins:?}");
    let (held, _, fault) = outcome(190.0);
    assert!(!held, "1.86 N of 1.6 N slips out");
    // The solve stops as dropped when the object moves beyond its limit.
    assert_eq!(fault, None, "an object that slips out of the hand is no fault of the solver");
}
