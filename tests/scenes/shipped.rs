//! Every shipped scene runs and keeps its promises; the torture scenes have a test of their own.

#[test]
fn every_scene_keeps_its_promises() {
    let all = crate::walk::scenes(&crate::walk::shipped(), &["torture"]);
    assert!(all.len() >= 8, "the shipped scenes are found: {all:?}");
    let broken: Vec<_> = all.iter().flat_map(|path| crate::walk::broken(path, 2)).collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
