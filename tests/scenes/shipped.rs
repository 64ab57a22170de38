//! Every shipped scene runs and meets its expectations; the torture scenes are tested in `torture.rs`.

#[test]
fn every_scene_keeps_its_promises() {
    let all = crate::promises::scenes(&crate::promises::shipped(), &["torture"]);
    assert!(all.len() >= 8, "the shipped scenes are found: {all:?}");
    let broken: Vec<_> = all.iter().flat_map(|path| crate::promises::broken(path, 2)).collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
