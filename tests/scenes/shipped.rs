//! Every shipped scene runs and meets its expectations; the torture scenes are tested in `torture.rs`, the references in
//! `certified.rs`.

#[test]
#[ignore = "thorough: every scene of the folder"]
fn every_scene_keeps_its_promises() {
    let mut all = crate::promises::scenes(&crate::promises::shipped(), &["torture"]);
    all.retain(|path| !path.ends_with(crate::promises::REFERENCES));
    assert!(all.len() >= 8, "the shipped scenes are found: {all:?}");
    let broken = crate::promises::all_broken(&all);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
