//! MJCF as in MuJoCo: includes, attached models, frames, classes, names of sites, coupled joints.

use super::{measures, read, refused};
use tactus::scene::Gripper;

const FINGERS: &str = r#"<body name="left" pos="0 0 0.06"><joint name="jl" type="slide" axis="0 1 0" range="0 0.04"/>
  <site name="left_pad" pos="0 0 0.05"/></body>
<body name="right" pos="0 0 0.06" quat="0 0 0 1"><joint name="jr" type="slide" axis="0 1 0" range="0 0.04"/>
  <site name="right_pad" pos="0 0 0.05"/></body>"#;
const EXPECTED: [f64; 4] = [0.08, 0.04, 0.0, 0.11];
const PADS: [&str; 2] = ["left_pad", "right_pad"];

fn palm() -> String {
    format!("<body name=\"palm\" pos=\"0.3 0 0.2\" euler=\"0 20 0\">{FINGERS}</body>")
}

fn world(bodies: &str) -> String {
    format!("<mujoco><worldbody>{bodies}</worldbody></mujoco>")
}

fn one(text: &str) -> Result<Gripper, String> {
    read(&[("g.xml", text)], "palm", PADS)
}

#[test]
fn files_included_anywhere_stand_where_mujoco_puts_them() {
    let main = r#"<mujoco><include file="parts/hand.xml"/></mujoco>"#;
    let included = format!("<mujocoinclude><worldbody>{}</worldbody></mujocoinclude>", palm());
    let hand = ("parts/hand.xml", included.as_str());
    measures(&read(&[("g.xml", main), hand], "palm", PADS).unwrap(), EXPECTED, 1e-12);
    // Inside a body.
    let body = world("<body name=\"palm\"><include file=\"parts/fingers.xml\"/></body>");
    let fingers = format!("<mujocoinclude>{FINGERS}</mujocoinclude>");
    measures(&read(&[("g.xml", &body), ("parts/fingers.xml", &fingers)], "palm", PADS).unwrap(), EXPECTED, 1e-12);
    // The path in an included file starts at the folder of the main file, or else at that of the included one.
    for file in ["parts/hand.xml", "hand.xml"] {
        let nested = format!("<mujoco><include file=\"{file}\"/></mujoco>");
        let main = r#"<mujoco><include file="parts/nested.xml"/></mujoco>"#;
        let files = [("g.xml", main), ("parts/nested.xml", nested.as_str()), hand];
        measures(&read(&files, "palm", PADS).unwrap(), EXPECTED, 1e-12);
    }
    // Compiler settings of a later file apply to an earlier one, as in a single file.
    let radian = world(&palm().replace("euler=\"0 20 0\"", "euler=\"0 0 0\""))
        .replace("quat=\"0 0 0 1\"", "euler=\"0 0 3.141592653589793\"");
    let main = r#"<mujoco><include file="hand.xml"/><include file="settings.xml"/></mujoco>"#;
    let settings = r#"<mujocoinclude><compiler angle="radian"/></mujocoinclude>"#;
    let files = [("g.xml", main), ("hand.xml", radian.as_str()), ("settings.xml", settings)];
    measures(&read(&files, "palm", PADS).unwrap(), EXPECTED, 1e-12);
}

#[test]
fn attached_models_frames_and_the_world_carry_fingers() {
    let attach = |attach: &str| {
        format!(
            r#"<mujoco><asset><model name="h" file="parts/hand.xml"/></asset><worldbody><body name="arm">
            <frame pos="0 0 0.1" euler="0 0 30">{attach}</frame></body></worldbody></mujoco>"#
        )
    };
    let hand = world(&palm());
    let pads = ["a_left_pad", "a_right_pad"];
    let files = |attached: &str| [("g.xml".to_string(), attach(attached)), ("parts/hand.xml".into(), hand.clone())];
    let load = |attached: &str, hand: &str| {
        let files = files(attached);
        read(&[(&files[0].0, &files[0].1), (&files[1].0, &files[1].1)], hand, pads)
    };
    measures(&load(r#"<attach model="h" body="palm" prefix="a_"/>"#, "a_palm").unwrap(), EXPECTED, 1e-12);
    measures(&load(r#"<attach model="h" prefix="a_"/>"#, "a_palm").unwrap(), EXPECTED, 1e-12);
    refused(load(r#"<attach model="i" prefix="a_"/>"#, "a_palm"), &["g.xml:2:", "refers to the model \"i\""]);
    refused(load(r#"<attach model="h" body="p" prefix="a_"/>"#, "a_palm"), &["\"h\" has no link \"body:p\""]);
    // The hand is the world body; then a frame rotates the joint and the site of each finger.
    measures(&read(&[("g.xml", &world(FINGERS))], "world", PADS).unwrap(), EXPECTED, 1e-12);
    let framed = FINGERS.replace("><joint", "><frame euler=\"90 0 0\"><joint").replace("</body>", "</frame></body>");
    let framed = framed.replace("axis=\"0 1 0\"", "axis=\"0 0 -1\"").replace("pos=\"0 0 0.05\"", "pos=\"0 0.05 0\"");
    measures(&read(&[("g.xml", &world(&framed))], "world", PADS).unwrap(), EXPECTED, 1e-12);
}

#[test]
fn classes_give_joints_and_sites_what_they_leave_out() {
    let text = r#"<mujoco><compiler angle="radian" eulerseq="zyx"/>
<default><site pos="0 0 0.05" euler="1 0 0"/>
  <default class="finger"><joint type="slide" axis="0 1 0" range="0 0.03"/>
    <default class="wide"><joint range="0 0.04"/></default></default></default>
<worldbody><body name="palm" childclass="finger">
  <body pos="0 0 0.06"><joint class="wide"/><site name="left_pad"/></body>
  <body pos="0 0 0.06" euler="3.141592653589793 0 0"><joint class="wide"/><site name="right_pad" quat="1 0 0 0"/></body>
</body></worldbody></mujoco>"#;
    measures(&one(text).unwrap(), EXPECTED, 1e-12);
    measures(&one(&text.replace(" class=\"wide\"/><", "/><")).unwrap(), [0.06, 0.03, 0.0, 0.11], 1e-12);
    refused(
        one(&text.replace("joint class=\"wide\"", "joint class=\"w\"")),
        &["g.xml:6:", "the class \"w\", which does not exist"],
    );
}

#[test]
fn a_site_and_a_body_of_one_name_are_told_apart() {
    let text = world(&palm().replace("left_pad", "left").replace("right_pad", "right"));
    let load = |left: &str, right: &str| read(&[("g.xml", &text)], "palm", [left, right]);
    refused(load("left", "right"), &["a body and a site named \"left\"; write \"site:left\" or \"body:left\""]);
    measures(&load("site:left", "site:right").unwrap(), EXPECTED, 1e-12);
    measures(&load("body:left", "body:right").unwrap(), [0.08, 0.04, 0.0, 0.06], 1e-12);
}

#[test]
fn equalities_of_joints_couple_fingers_as_mimics_do() {
    let coupled = |right: &str, equality: &str| {
        let hand = palm().replace("name=\"jr\" type=\"slide\" axis=\"0 1 0\" range=\"0 0.04\"", right);
        one(&format!("<mujoco><worldbody>{hand}</worldbody><equality>{equality}</equality></mujoco>"))
    };
    let free = "name=\"jr\" type=\"slide\" axis=\"0 1 0\"";
    let joint = |more: &str| format!("<joint joint1=\"jr\" joint2=\"jl\" {more}/>");
    measures(&coupled(free, &joint("")).unwrap(), EXPECTED, 1e-12);
    measures(&coupled(&free.replace("0 1 0", "0 -1 0"), &joint("polycoef=\"0 -1\"")).unwrap(), EXPECTED, 1e-12);
    // The polynomial relates displacements from the initial positions of the joints (`ref`).
    measures(&coupled(&format!("{free} ref=\"0.01\""), &joint("polycoef=\"0 1 0 0 0\"")).unwrap(), EXPECTED, 1e-12);
    // The right finger travels half as far as the left one.
    measures(&coupled(free, &joint("polycoef=\"0 0.5 0 0 0\"")).unwrap(), [0.06, 0.03, 0.0, 0.11], 1e-12);
    refused(coupled(free, &joint("polycoef=\"0 1 3 0 0\"")), &["g.xml:", "polycoef of higher than first order"]);
    refused(coupled(free, &joint("active=\"false\"")), &["<joint name=\"jr\"> has no range", "as in range=\"0 0.04\""]);
    refused(
        coupled(&format!("{free} range=\"0 0.04\" limited=\"false\""), ""),
        &["\"jr\"> has a range, but is not limited"],
    );
    refused(coupled(&format!("{free} range=\"0.04 0\""), ""), &["a range from 0.04 to 0, which is decreasing"]);
    refused(coupled("name=\"jr\"", ""), &["<joint name=\"jr\"> is of type hinge"]);
}
