//! Bounds on robot descriptions: cyclic includes, files that never end or are not regular, elements nested too deeply.

use super::{measures, read, refused};
use std::fmt::Write;

const PADS: [&str; 2] = ["left_gel", "right_gel"];

/// MJCF file of the hand of the shipped scene with `more` before its `<worldbody>`.
pub fn with(more: &str) -> String {
    let text = std::fs::read_to_string(super::shipped("franka_gelsight.xml")).unwrap();
    text.replace("<worldbody>", &format!("{more}<worldbody>"))
}

#[test]
fn circles_and_files_that_are_none_are_refused_by_name() {
    let include = |file: &str| with(&format!("<include file=\"{file}\"/>"));
    let (a, b) = (include("b.xml"), "<mujoco><include file=\"a.xml\"/></mujoco>");
    refused(
        read(&[("a.xml", &a), ("b.xml", b)], "fr3_hand", PADS),
        &["b.xml:1:9: <include>", "in a cycle: a.xml -> b.xml -> a.xml"],
    );
    let model = |file: &str| with(&format!("<asset><model name=\"m\" file=\"{file}\"/></asset>"));
    refused(read(&[("a.xml", &model("a.xml"))], "fr3_hand", PADS), &["in a cycle: a.xml -> a.xml"]);
    refused(
        read(&[("a.xml", &include("none.xml"))], "fr3_hand", PADS),
        &["none.xml: cannot be read: no such file", "a.xml:"],
    );
    refused(read(&[("a.xml", &model("../none.xml"))], "fr3_hand", PADS), &["none.xml: cannot be read: no such file"]);
    refused(read(&[("a.xml", &include("/"))], "fr3_hand", PADS), &["is a directory, not a regular file"]);
    refused(
        read(&[("a.xml", &include("b.xml")), ("b.xml", "no XML")], "fr3_hand", PADS),
        &["b.xml:1:1:", "has no element"],
    );
    refused(read(&[("a.xml", "<mujoco><worldbody>")], "fr3_hand", PADS), &["a.xml:1:9: <worldbody> is not closed"]);
    refused(read(&[("a.xml", "<mujoco></worldbody>")], "fr3_hand", PADS), &["a.xml:1:", "is not valid XML"]);
    let many = "<mujoco>".to_string() + &"<include file=\"b.xml\"/>".repeat(300) + "</mujoco>";
    refused(read(&[("a.xml", &many), ("b.xml", "<mujoco/>")], "fr3_hand", PADS), &["more than 256 files are included"]);
}

/// Ten includes in each of eleven nested files are 1e11 includes; models attached ten times at each level give as many
/// links.
#[test]
fn includes_and_attached_models_that_multiply_end() {
    let mut files = vec![("a.xml".to_string(), with("<include file=\"1.xml\"/>"))];
    let mut models = vec![("a.xml".to_string(), with("<asset><model name=\"m\" file=\"1.xml\"/></asset>"))];
    for level in 1..12 {
        let next = level + 1;
        let include = format!("<include file=\"{next}.xml\"/>").repeat(10);
        files.push((format!("{level}.xml"), format!("<mujoco>{include}</mujoco>")));
        let asset = format!("<asset><model name=\"m\" file=\"{next}.xml\"/></asset>");
        let attach = "<attach model=\"m\"/>".repeat(10);
        models.push((format!("{level}.xml"), format!("<mujoco>{asset}<worldbody>{attach}</worldbody></mujoco>")));
    }
    let last = ("12.xml".to_string(), "<mujoco><worldbody><body/></worldbody></mujoco>".to_string());
    for (mut files, reason) in [(files, "more than 256 files are included"), (models, "results in more than")] {
        files.push(last.clone());
        let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        refused(read(&files, "fr3_hand", PADS), &[reason]);
    }
}

#[test]
fn elements_that_stand_in_each_other_without_end_are_refused() {
    let nested = |tag: &str, count: usize| format!("<{tag}>").repeat(count) + &format!("</{tag}>").repeat(count);
    let bodies = with(&format!("<worldbody>{}</worldbody>", nested("body", 5_000)));
    refused(read(&[("a.xml", &bodies)], "fr3_hand", PADS), &["a.xml:9:", "<body> is nested in more than 256 elements"]);
    let urdf = std::fs::read_to_string(super::shipped("franka_gelsight.urdf")).unwrap();
    let tags = urdf.replace("</robot>", &format!("{}</robot>", nested("a", 30_000)));
    refused(read(&[("a.urdf", &tags)], "fr3_hand", PADS), &["<a> is nested in more than 256 elements"]);
    // The nesting depths of a file and of one included in its innermost element add up.
    let deep = |file: &str| {
        format!("<mujoco>{}</mujoco>", nested("frame", 200).replacen("</", &format!("<include file=\"{file}\"/></"), 1))
    };
    let (main, inner) = (with("<include file=\"b.xml\"/>"), deep("c.xml"));
    let files = [("a.xml", main.as_str()), ("b.xml", &inner), ("c.xml", &nested("frame", 200))];
    refused(read(&files, "fr3_hand", PADS), &["c.xml:1:", "<frame> is nested in more than 256 elements"]);
}

/// A robot of 30,000 joints is read without a linear search for each name.
#[test]
fn a_robot_of_thirty_thousand_joints_is_read() {
    let urdf = std::fs::read_to_string(super::shipped("franka_gelsight.urdf")).unwrap();
    let mut more = String::new();
    for i in 0..30_000 {
        write!(more, "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"revolute\"><parent link=\"").unwrap();
        let parent = if i == 0 { "fr3_hand".into() } else { format!("l{}", i - 1) };
        write!(more, "{parent}\"/><child link=\"l{i}\"/></joint>").unwrap();
    }
    let text = urdf.replace("</robot>", &format!("{more}</robot>"));
    measures(&read(&[("a.urdf", &text)], "fr3_hand", PADS).unwrap(), [0.07, 0.04, 0.0, 0.1128], 1e-12);
    refused(read(&[("a.urdf", &text)], "hand", PADS), &["has no link \"hand\"; it has: fr3_hand", "..."]);
}
