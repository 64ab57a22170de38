//! Hard cases, each with its expectations: by default those that take a second or two, all of them with
//! `TACTUS_ALL_SCENES=1 cargo test --release --test scenes torture:: -- --nocapture`.

use crate::skipped::data;

fn all() -> bool {
    std::env::var_os("TACTUS_ALL_SCENES").is_some()
}

#[test]
#[ignore = "thorough: every hard scene"]
fn hard_scenes_keep_their_promises() {
    let without: &[&str] = if all() { &[] } else { &["slow"] };
    let scenes = crate::promises::scenes(&crate::promises::shipped().join("torture"), without);
    assert!(scenes.len() >= 32, "{} torture scenes are found", scenes.len());
    let broken = crate::promises::all_broken(&scenes);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Pad meshes from other programs: file, its orientation and bonding, further fields of the scene, and true if the case
/// is quick.
const PADS: [(&str, &str, &str, bool); 4] = [
    ("gelsight_mini_e430/tet.msh", "", "", true),
    ("gelsight_mini_875/tet.msh", "", "", false),
    ("round_pad/round_pad.tet", "bonded: Plane(within: 1e-6),", "stepper: Fem(element: Linear),", true),
    (
        "biotac/int_ext_skin_combined_ftw.tet",
        "outward: (0, -1, 0), bonded: Plane(within: 6e-3),",
        "stepper: Fem(element: Linear),",
        false,
    ),
];

#[test]
fn real_pads_hold_a_ball() {
    let Some(pads) = data("pads") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = Vec::new();
    for (file, placement, more, quick) in PADS {
        if !quick && !all() {
            continue;
        }
        let path = folder.path().join(file.replace(['/', '.'], "_")).with_extension("ron");
        let text = format!(
            "Scene(object: (shape: Sphere(radius: 0.015)), gripper: (pads: File(path: {:?}, {placement})), {more}
             loading: Squeeze(force: 6.0, frames: 3), record: (fields: [ContactForce]),
             expect: [ReachesForce, ForceBalance(relative: 1e-3), TorqueBalance(relative: 1e-3), Finite, NoInversion,
                      NoPenetration, Converged(relative: 1e-3)])",
            pads.join(file)
        );
        std::fs::write(&path, text).unwrap();
        scenes.push(path);
    }
    let broken = crate::promises::all_broken(&scenes);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
