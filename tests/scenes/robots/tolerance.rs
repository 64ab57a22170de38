//! Rounded angles and positions: axes and pads that are nearly perpendicular, parallel or aligned are accepted, with a
//! notice of the deviation.

use super::{measures, read, refused};
use tactus::scene::Gripper;

/// URDF hand whose fingers have these origins and joint axes, and whose pads are at `pad` on their fingers.
fn urdf([left, right]: [&str; 2], [axis, other]: [&str; 2], pad: &str) -> Result<Gripper, String> {
    let finger = |side: &str, origin: &str, axis: &str| {
        format!(
            r#"<link name="{side}"/><link name="{side}_pad"/><joint name="{side}_slide" type="prismatic"><parent link="palm"/><child link="{side}"/>
<origin {origin}/><axis xyz="{axis}"/><limit lower="0" upper="0.04"/></joint>
<joint name="{side}_fix" type="fixed"><parent link="{side}"/><child link="{side}_pad"/><origin xyz="{pad}"/></joint>"#
        )
    };
    let fingers = [finger("left", left, axis), finger("right", right, other)].concat();
    let text = format!("<robot name=\"g\"><link name=\"palm\"/>{fingers}</robot>");
    read(&[("g.urdf", &text)], "palm", ["left_pad", "right_pad"])
}

fn yawed(yaw: &str) -> Result<Gripper, String> {
    let right = format!("xyz=\"0 0 0.06\" rpy=\"0 0 {yaw}\"");
    urdf(["xyz=\"0 0 0.06\"", &right], ["0 1 0"; 2], "0 0 0.05")
}

#[test]
fn angles_of_few_digits_are_right_ones_with_a_note_by_how_much() {
    assert_eq!(yawed("3.141592653589793").unwrap().notice.0, None, "what is exact is no news");
    for (yaw, off) in
        [("3.1416", "7.3e-6 rad"), ("3.14159", "2.7e-6 rad"), ("3.14", "1.6e-3 rad"), ("-3.1416", "7.3e-6 rad")]
    {
        let gripper = yawed(yaw).unwrap();
        measures(&gripper, [0.08, 0.04, 0.0, 0.11], 1e-7);
        let notice = gripper.notice.0.unwrap();
        assert!(notice.contains(off) && notice.contains("g.urdf"), "{yaw}: {notice}");
    }
    refused(yawed("3.12"), &["must be parallel within 0.002 rad"]);
    for (roll, off) in [("1.5708", "3.7e-6 rad"), ("1.57", "8.0e-4 rad")] {
        let origin = format!("xyz=\"0 0 0.06\" rpy=\"{roll} 0 0\"");
        let gripper = urdf([&origin, &origin], ["0 0 -1", "0 0 1"], "0 0.05 0").unwrap();
        measures(&gripper, [0.08, 0.04, 0.0, 0.11], 1e-7);
        let notice = gripper.notice.0.unwrap();
        assert!(notice.contains(off), "{roll}: {notice}");
    }
    let origin = "xyz=\"0 0 0.06\" rpy=\"1.55 0 0\"";
    refused(
        urdf([origin, origin], ["0 0 -1", "0 0 1"], "0 0.05 0"),
        &["must be perpendicular to that within 0.002 rad"],
    );
}

/// CAD exports deviate by some micrometres; the placement is the mean of both pads.
#[test]
fn places_that_are_off_by_less_than_a_tenth_of_a_millimetre_are_in_line_with_a_note() {
    let turned = |z: &str| format!("xyz=\"0 0 {z}\" rpy=\"0 0 3.141592653589793\"");
    let gripper = urdf(["xyz=\"0.00001 0 0.06\"", &turned("0.060012")], ["0 1 0"; 2], "0 0 0.05").unwrap();
    measures(&gripper, [0.08, 0.04, 5e-6, 0.110006], 1e-12);
    let notice = gripper.notice.0.unwrap();
    assert!(notice.contains("offsets of up to 12.00 um") && !notice.contains("rad"), "{notice}");
    refused(
        urdf(["xyz=\"0 0 0.06\"", &turned("0.0602")], ["0 1 0"; 2], "0 0 0.05"),
        &["do not face each other within 0.0001 m"],
    );
}

/// As in the hand of a Piper: quaternions of six digits, and one finger with a negative range. Lengths agree to
/// 1e-6 m.
#[test]
fn quaternions_of_six_digits_are_right_angles() {
    let finger = |side: &str, quat: &str, axis: &str, range: &str, y: &str| {
        format!(
            r#"<body name="{side}" pos="0 0 0.135" quat="{quat}"><joint type="slide" axis="{axis}" range="{range}"/>
<site name="{side}_pad" pos="0 {y} 0"/></body>"#
        )
    };
    let left = finger("left", "0 0 0.707108 0.707105", "0 0 1", "0 0.035", "-0.03");
    let right = finger("right", "0 0 -0.707108 0.707105", "0 0 -1", "-0.035 0", "0.03");
    let text = format!("<mujoco><worldbody><body name=\"hand\">{left}{right}</body></worldbody></mujoco>");
    let gripper = read(&[("p.xml", &text)], "hand", ["left_pad", "right_pad"]);
    let gripper = gripper.unwrap();
    measures(&gripper, [0.07, 0.035, 0.0, 0.105], 1e-6);
    assert!(gripper.notice.0.unwrap().contains("errors of up to"), "the note says by how much");
}
