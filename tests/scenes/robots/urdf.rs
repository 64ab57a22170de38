//! URDF joints: limits, mimic joints, names.

use super::{measures, read, refused};
use tactus::scene::Gripper;

/// A hand whose fingers slide along ±y, with these tags in the joints.
fn hand(left: &str, right: &str, more: &str) -> Result<Gripper, String> {
    let finger = |side: &str, axis: &str, joint: &str| {
        format!(
            r#"<link name="{side}_finger"/><link name="{side}_pad"/>
<joint name="{side}_slide" type="prismatic">
  <parent link="palm"/><child link="{side}_finger"/><origin xyz="0 0 0.06"/><axis xyz="{axis}"/>{joint}
</joint>
<joint name="{side}_fix" type="fixed"><parent link="{side}_finger"/><child link="{side}_pad"/><origin xyz="0 0 0.05"/></joint>
"#
        )
    };
    let (left, right) = (finger("left", "0 1 0", left), finger("right", "0 -1 0", right));
    let urdf = format!("<robot name=\"g\">\n<link name=\"palm\"/>\n{left}{right}{more}</robot>");
    read(&[("g.urdf", &urdf)], "palm", ["left_pad", "right_pad"])
}

const OPEN: &str = "<limit lower=\"0\" upper=\"0.04\"/>";
const EXPECTED: [f64; 4] = [0.08, 0.04, 0.0, 0.11];

#[test]
fn a_follower_takes_the_range_of_its_leader_whatever_its_own_limits() {
    let follow = "<mimic joint=\"left_slide\"/>";
    for own in ["", OPEN, "<limit lower=\"-1\" upper=\"1\"/>"] {
        measures(&hand(OPEN, &format!("{own}{follow}"), "").unwrap(), EXPECTED, 1e-12);
    }
    // The angle of a separate joint drives both fingers, as the motor of a Robotiq 2F-85 does.
    let motor = r#"<link name="crank"/><joint name="motor" type="revolute"><parent link="palm"/><child link="crank"/>
        <limit lower="0" upper="0.8"/></joint>"#;
    let follow = "<mimic joint=\"motor\" multiplier=\"0.05\"/>";
    measures(&hand(follow, follow, motor).unwrap(), EXPECTED, 1e-12);
    // Chained mimic joints with offsets: 0.5 * (2 * q - 0.04) + 0.02 = q.
    let chain = r#"<link name="bar"/><joint name="bar" type="prismatic"><parent link="palm"/><child link="bar"/>
        <mimic joint="left_slide" multiplier="2" offset="-0.04"/></joint>"#;
    let right = "<mimic joint=\"bar\" multiplier=\"0.5\" offset=\"0.02\"/>";
    measures(&hand(OPEN, right, chain).unwrap(), EXPECTED, 1e-12);
}

/// One joint closes the left finger by 40 mm and the right one by 20 mm: the opening is 60 mm, the stroke of each
/// finger 30 mm about their midpoint, and a notice states this.
#[test]
fn fingers_that_one_joint_closes_by_unequal_ways_meet_in_their_middle() {
    let follow = format!("{OPEN}<mimic joint=\"left_slide\" multiplier=\"0.5\"/>");
    let gripper = hand(OPEN, &follow, "").unwrap();
    measures(&gripper, [0.06, 0.03, 0.0, 0.11], 1e-12);
    let notice = gripper.notice.0.unwrap();
    assert!(notice.contains("by 0.04 m and 0.02 m") && notice.contains("from -0.01 m to 0 m"), "{notice}");
    // Independent joints of unequal range, and fingers that meet off the centre of the hand, are refused.
    refused(hand(OPEN, "<limit lower=\"0\" upper=\"0.02\"/>", ""), &["0.04 m and 0.02 m", "or follow one joint"]);
    let beside = "<mimic joint=\"left_slide\" multiplier=\"0.5\" offset=\"0.03\"/>";
    refused(hand(OPEN, beside, ""), &["off its middle"]);
}

#[test]
fn followers_that_make_no_parallel_gripper_are_refused_by_their_gear() {
    let follow = |words: &str| hand(OPEN, &format!("{OPEN}<mimic joint=\"left_slide\" {words}/>"), "");
    refused(follow("multiplier=\"-1\""), &["moves both fingers in the same direction"]);
    refused(follow("offset=\"0.02\""), &["0.01 m off its middle"]);
    refused(follow("multiplier=\"half\""), &["g.urdf:10:", "<mimic multiplier=\"half\">: \"half\" is not a number"]);
    refused(hand("<mimic joint=\"right_slide\"/>", "<mimic joint=\"left_slide\"/>", ""), &["form a cycle"]);
    refused(
        hand(OPEN, "<mimic joint=\"motor\"/>", ""),
        &["<mimic", "refers to the joint \"motor\", which does not exist"],
    );
    refused(hand("", "<mimic joint=\"left_slide\"/>", ""), &["\"left_slide\"> has no <limit>"]);
    refused(
        hand(OPEN, OPEN, "").and(read(&[("g.urdf", ROTATING)], "base", ["left", "right"])),
        &["g.urdf:3:", "<joint name=\"finger_joint\"> is revolute", "give opening, stroke and placement"],
    );
}

/// The fingers of a 2F-85 rotate, so its pads move on arcs.
const ROTATING: &str = r#"<robot name="2f_85">
<link name="base"/><link name="left"/><link name="right"/>
<joint name="finger_joint" type="revolute"><parent link="base"/><child link="left"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="0.8" velocity="2" effort="1000"/></joint>
<joint name="right_joint" type="revolute"><parent link="base"/><child link="right"/><axis xyz="1 0 0"/>
  <limit lower="-0.8" upper="0" velocity="2" effort="1000"/><mimic joint="finger_joint" multiplier="-1"/></joint>
</robot>"#;

#[test]
fn limits_are_those_of_the_way_alone_and_what_they_lack_is_said() {
    measures(&hand(OPEN, "<limit upper=\"0.04\"/>", "").unwrap(), EXPECTED, 1e-12);
    measures(&hand(OPEN, "<limit upper=\"0.04\" effort=\"1e9.0\"/>", "").unwrap(), EXPECTED, 1e-12);
    let write = "as in <limit lower=\"0\" upper=\"0.04\"/>";
    refused(
        hand(OPEN, "", ""),
        &["\"right_pad\" slides without limits", "<joint name=\"right_slide\"> has no <limit>", write],
    );
    refused(
        hand("<limit effort=\"1\"/>", OPEN, ""),
        &["\"left_slide\"", "lower, 0, is the same as its upper, 0", write],
    );
    let inverted = "<limit lower=\"0.04\" upper=\"0\"/>";
    refused(hand(OPEN, inverted, ""), &["\"right_slide\"", "lower, 0.04, is above its upper, 0", write]);
}

#[test]
fn names_axes_and_macros_that_are_none_are_refused_with_their_line() {
    refused(hand(OPEN, OPEN, "<link name=\"palm\"/>"), &["g.urdf:13:1:", "has the name of an earlier element"]);
    let again = r#"<joint name="again" type="fixed"><parent link="palm"/><child link="left_pad"/></joint>"#;
    refused(
        hand(OPEN, OPEN, again),
        &["g.urdf:13:1: <joint name=\"again\">", "\"left_pad\", which is already a child of \"left_finger\""],
    );
    refused(hand(OPEN, OPEN, "<xacro:finger side=\"left\"/>"), &["<xacro:finger>", "expand the file first"]);
    refused(hand(OPEN, OPEN, "<link/>"), &["g.urdf:13:1: <link> has no name"]);
    let turned = r#"<link name="a"/><joint name="t" type="fixed"><parent link="palm"/><child link="a"/><origin rpy="90 0 0"/></joint>"#;
    refused(hand(OPEN, OPEN, turned), &["<origin rpy=\"90 0 0\">", "90 degrees are 1.5707963"]);
    refused(hand("<axis xyz=\"0 0 0\"/>", OPEN, "").and(hand(OPEN, OPEN, "<joint/>")), &["has no"]);
}

/// The root element, not the file extension, determines the format.
#[test]
fn descriptions_are_known_by_their_element_and_not_by_their_ending() {
    let urdf = std::fs::read_to_string(super::shipped("franka_gelsight.urdf")).unwrap();
    let read = |name: &str| read(&[(name, &urdf)], "fr3_hand", ["left_gel", "right_gel"]);
    measures(&read("hand.xml").unwrap(), [0.07, 0.04, 0.0, 0.1128], 1e-12);
    measures(&read("HAND.URDF").unwrap(), [0.07, 0.04, 0.0, 0.1128], 1e-12);
}
