//! Damage is detected: a file that differs from what was written is refused by name, recomputed, or gives the same
//! result.
//!
//! ```text
//! TACTUS_MUTATIONS=5000 cargo test --release --test interfaces integrity:: -- --nocapture
//! ```
//!
//! damages files of data sets, models, checkpoints and cached responses five thousand times; without the variable, 120
//! times.

use crate::dataset_tiny::{copy, linear};
use crate::gnn_made::{SPEC, ball, command, made, ron, set};
use hdf5_pure::{AttrValue, FileBuilder};
use serde_json::Value;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, SystemTime};
use tactus::base::files::atomic::write_atomic;
use tactus::base::files::lock::FolderLock;
use tactus::base::files::lock_file::LockFile;
use tactus::base::random::Random;
use tactus::dataset::arrays::{ARRAYS, FORMAT, FileSizes, NumberKind};
use tactus::dataset::{DataSet, ObjectFile, StoredGrasp};
use tactus::model::part::FingerModel;
use tactus::net::features::GraspFeatures;
use tactus::net::infer::predict::{GraspState, Predictor};
use tactus::net::linear_response::compliance_cache::{ComplianceCache, ComplianceKey, MOST};
use tactus::net::linear_response::first_contact::GeometricContact;
use tactus::net::linear_response::pad_graph::{Layout, PadGraph, mesh_hash};
use tactus::net::network::spec::Spec;
use tactus::net::train::Trainer;

const LAYOUT: Layout = Layout::Face { depths: 3 };

fn tactus(folder: &Path, cache: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.current_dir(folder).env("XDG_CACHE_HOME", cache).args(arguments).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn files(dir: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(dir).into_iter().flatten().map(|e| e.unwrap().path());
    let all = entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] });
    let mut all: Vec<PathBuf> = all.collect();
    all.sort();
    all
}

/// A scene within the training range of the shipped network, except for `spacing` (m).
fn ball_scene(spacing: &str, stepper: &str) -> String {
    format!(
        "Scene(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(shape: Flat, spacing: {spacing}), \
         material: Preset(\"gelsight_mini\"), friction: 0.8), loading: Squeeze(force: 4.0, frames: 3){stepper})"
    )
}

/// Grasps of a printed report, without their times.
fn grasps(output: &Output) -> Value {
    let mut report: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", errors(output)));
    for grasp in report["grasps"].as_array_mut().unwrap() {
        grasp.as_object_mut().unwrap().retain(|key, _| !key.contains("wall"));
    }
    report["grasps"].take()
}

#[test]
fn a_network_compares_the_pads_before_it_solves_for_them() {
    let dir = tempfile::tempdir().unwrap();
    let (folder, cache) = (dir.path(), dir.path().join("cache"));
    let longer = ball_scene("2.6e-3", "").replace("GelSightMini(shape: Flat, ", "Box(size: (0.03, 0.02, 0.004), ");
    std::fs::write(folder.join("longer.ron"), longer).unwrap();
    let model = made().model.to_str().unwrap();
    let refused = tactus(folder, &cache, &["run", "longer.ron", "--backend", "gnn", "--model", model]);
    let text = errors(&refused);
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(text.contains("the length of its pads is 7.500 times their thickness"), "{text}");
    assert!(text.contains("the training range is 6.312 to 6.312"), "{text}");
    assert!(files(&cache).is_empty(), "something was solved: {:?}", files(&cache));
    for (scene, why) in
        [("fingers: None", "a free object between 0 finger(s)"), ("fingers: One", "a free object between 1 finger(s)")]
    {
        let text = ball_scene("2.6e-3", "").replace("friction: 0.8", &format!("friction: 0.8, {scene}"));
        std::fs::write(folder.join("hand.ron"), text).unwrap();
        let refused = tactus(folder, &cache, &["run", "hand.ron", "--backend", "gnn", "--model", model]);
        let text = errors(&refused);
        assert!(matches!(refused.status.code(), Some(1 | 2)) && !text.contains("panicked"), "{scene}: {text}");
        // The scene itself may be refused before the network is.
        assert!(text.contains(why) || text.contains("finger"), "{scene}: {text}");
    }
}

#[test]
fn models_that_ship_work_in_any_folder_with_any_cache_and_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let (folder, cache) = (dir.path(), dir.path().join("cache"));
    std::fs::write(folder.join("a.ron"), ball_scene("2.6e-3", "")).unwrap();
    std::fs::write(folder.join("b.ron"), ball_scene("2.6e-3", ", stepper: Gnn(model: \"universe\")")).unwrap();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/universe");
    let run = |cache: &Path, more: &[&str]| {
        let output = tactus(folder, cache, &[&["run"][..], more, &["--format", "json"]].concat());
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", errors(&output));
        grasps(&output)
    };
    let expected = run(&cache, &["a.ron", "--backend", "gnn", "--model", own.to_str().unwrap()]);
    let kept = files(&cache);
    assert!(kept.len() == 1 && kept[0].parent().unwrap() == cache.join("tactus"), "{kept:?}");
    assert_eq!(run(&cache, &["a.ron", "--backend", "gnn"]), expected);
    assert_eq!(run(&cache, &["a.ron", "--backend", "gnn", "--model", "universe", "--threads", "2"]), expected);
    assert_eq!(run(&cache, &["b.ron", "--threads", "1"]), expected, "a name in a scene");
    // A cached response with a block of zeros is recomputed.
    let whole = std::fs::read(&kept[0]).unwrap();
    let mut zeroed = whole.clone();
    zeroed[whole.len() / 2..][..4096].fill(0);
    std::fs::write(&kept[0], &zeroed).unwrap();
    assert_eq!(run(&cache, &["b.ron"]), expected, "a damaged response was believed");
    assert!(std::fs::read(&kept[0]).unwrap() == whole, "not made anew");
    // A cache folder that cannot be written.
    std::fs::write(folder.join("file"), "").unwrap();
    assert_eq!(run(&folder.join("file"), &["b.ron"]), expected);
    let missing = tactus(folder, &cache, &["run", "a.ron", "--backend", "gnn", "--model", "nowhere"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(errors(&missing).contains("built-in networks: universe"), "{}", errors(&missing));
}

fn key(finger: &FingerModel) -> ComplianceKey {
    let face: std::collections::BTreeSet<u32> = finger.topology.sensing.iter().flatten().copied().collect();
    ComplianceKey::of(finger, &face.into_iter().collect::<Vec<_>>(), &mesh_hash(&finger.topology))
}

#[test]
fn kept_responses_are_bounded_and_shared_by_those_that_make_them_at_once() {
    let (model, _) = ball(made());
    let finger = &model.fingers[0];
    let dir = tempfile::tempdir().unwrap();
    let cache = ComplianceCache::at(dir.path());
    let fresh = PadGraph::new(finger, LAYOUT).unwrap().compliance;
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let kept = PadGraph::with_cache(finger, LAYOUT, Some(&cache)).unwrap().compliance;
                assert!(kept.response[..] == fresh.response[..]);
            });
        }
    });
    assert_eq!(files(dir.path()), [cache.path(&key(finger))], "no other file stays");
    // Two other files (sparse, so without disk usage) that fill the cache; the older one is evicted.
    let large = |name: &str, age: u64| {
        let file = std::fs::File::create(dir.path().join(name)).unwrap();
        file.set_len(MOST / 2).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(age)).unwrap();
    };
    large("old.pad", 2000);
    large("new.pad", 1000);
    std::fs::remove_file(cache.path(&key(finger))).unwrap();
    PadGraph::with_cache(finger, LAYOUT, Some(&cache)).unwrap();
    assert_eq!(files(dir.path()), [cache.path(&key(finger)), dir.path().join("new.pad")]);
    let held: u64 = files(dir.path()).iter().map(|f| f.metadata().unwrap().len()).sum();
    assert!(held <= MOST, "{held} bytes are kept, allowed {MOST}");
}

#[test]
fn a_card_with_impossible_numbers_is_refused_with_the_field() {
    let made = made();
    let dir = tempfile::tempdir().unwrap();
    let card = std::fs::read_to_string(made.model.join("card.ron")).unwrap();
    let field = |name: &str| {
        let start = card.find(&format!("        {name}: ")).unwrap_or_else(|| panic!("no {name}")) + 10 + name.len();
        let end = start + card[start..].find(",\n").unwrap();
        card[start..end].to_string()
    };
    let first = |list: &str| list[1..list.find(',').unwrap()].to_string();
    let scale = card.split("scale: ").nth(1).unwrap();
    for (from, to, named) in [
        (format!("displacement: {}", field("displacement")), "displacement: 1e308", "displacement"),
        (format!("displacement: {}", field("displacement")), "displacement: NaN", "displacement"),
        (format!("stress: {}", field("stress")), "stress: -1.0", "stress"),
        (format!("travel: ({}", first(&field("travel"))), "travel: (inf", "travel"),
        (format!("scale: [{}", first(scale)), "scale: [-1.0", "normalisers.node.scale"),
        (format!("scale: [{}, ", first(scale)), "scale: [", "normalisers.node"),
        (format!("force: {}", field("force")), "force: (0.0, 1e308)", "range.force"),
        (format!("friction: {}", field("friction")), "friction: (0.9, 0.1)", "range.friction"),
        ("weight: 0.0".into(), "weight: NaN", "range.weight"),
        // A valid range that differs from that of the training.
        (format!("friction: {}", field("friction")), "friction: (0.0, 1.0)", "changed or damaged"),
    ] {
        assert!(card.contains(&from), "no {from} in the card");
        copy(&made.model, dir.path());
        std::fs::write(dir.path().join("card.ron"), card.replacen(&from, to, 1)).unwrap();
        let error = Predictor::open(dir.path()).expect_err(to).to_string();
        assert!(error.contains("card.ron") && error.contains(named), "{to}: {error}");
    }
    let data = made.tiny.out("data");
    let judged = tactus(dir.path(), dir.path(), &["eval", data.to_str().unwrap(), "--model", "."]);
    assert_eq!(judged.status.code(), Some(2), "eval of a damaged card");
}

#[test]
fn two_commands_never_fill_one_folder() {
    let made = made();
    let out = made.tiny.out("held");
    let lock = FolderLock::exclusive(&out, "tactus train").unwrap();
    let scene = made.tiny.out("held.ron");
    std::fs::write(&scene, ball_scene("8e-3", "").replace("frames: 3", "frames: 1")).unwrap();
    let run = || {
        let mut run = Command::new(env!("CARGO_BIN_EXE_tactus"));
        run.arg("run").arg(&scene).arg("--no-pictures").arg("-o").arg(&out).output().unwrap()
    };
    let number = format!("process {}", std::process::id());
    for refused in [command(made, &out, &[]).output().unwrap(), run(), made.tiny.command(&out).output().unwrap()] {
        let text = errors(&refused);
        assert_eq!(refused.status.code(), Some(2), "{text}");
        assert!(text.contains(&number) && text.contains("held") && text.contains("choose another folder"), "{text}");
    }
    drop(lock);
    assert!(files(&out).is_empty(), "{:?}", files(&out));
    let done = run();
    assert_eq!(done.status.code(), Some(0), "{}", errors(&done));
    assert!(!out.join(".lock").exists() && out.join("run.json").exists());
    // At most one of four competing threads holds the lock.
    let dir = tempfile::tempdir().unwrap();
    let holders = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..200 {
                    if let Ok(_lock) = FolderLock::exclusive(dir.path(), "test") {
                        assert_eq!(holders.fetch_add(1, std::sync::atomic::Ordering::SeqCst), 0, "two hold one folder");
                        holders.fetch_sub(1, std::sync::atomic::Ordering::SeqCst);
                    }
                }
            });
        }
    });
}

/// On file systems without locks (ENOLCK), files named after host and process replace them.
#[cfg(unix)]
#[test]
fn a_file_holds_a_folder_without_locks() {
    let dir = tempfile::tempdir().unwrap();
    let base = dir.path().join(".lock");
    let take = |alone: bool| LockFile::acquire(&base, "tactus run", alone);
    let own = take(true).unwrap();
    let name = own.path().file_name().unwrap().to_str().unwrap().to_string();
    let number = format!(".{}", std::process::id());
    let host = name.strip_prefix(".lock.alone.").and_then(|rest| rest.strip_suffix(&number)).unwrap().to_string();
    drop(own);
    let names = || -> Vec<String> {
        let all = std::fs::read_dir(dir.path()).unwrap();
        all.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    };
    assert!(names().is_empty(), "it goes with its holder: {:?}", names());
    let left = |kind: &str, host: &str, process: u32| {
        let path = dir.path().join(format!(".lock.{kind}.{host}.{process}"));
        std::fs::write(&path, "`tactus dataset`").unwrap();
        path
    };
    let mut child = Command::new("true").spawn().unwrap();
    child.wait().unwrap();
    left("alone", &host, child.id());
    assert_eq!(take(true).map(|own| own.path().to_path_buf()).unwrap(), dir.path().join(&name), "its holder is dead");
    assert!(names().is_empty(), "{:?}", names());
    // Lock files of a live process, and of another host, where this cannot be determined.
    for (host, process, alone) in
        [(host.as_str(), 1, true), ("elsewhere.example", 7, true), ("elsewhere.example", 7, false)]
    {
        let path = left("alone", host, process);
        let said = take(alone).unwrap_err().to_string();
        let holder = format!("`tactus dataset` (process {process} on {host}) is writing here");
        assert!(said.contains(&holder) && said.ends_with(&format!("delete {}", path.display())), "{said}");
        assert_eq!(names().len(), 1, "who gives way leaves nothing: {:?}", names());
        std::fs::remove_file(path).unwrap();
    }
    left("beside", "elsewhere.example", 7);
    assert!(take(false).is_ok(), "beside others of its kind");
    assert!(take(true).is_err(), "not alone with them");
}

#[test]
fn two_that_write_one_file_leave_one_of_the_two_contents() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("file");
    std::thread::scope(|scope| {
        for content in [[1_u8; 5000], [2; 5000], [3; 5000]] {
            let path = &path;
            scope.spawn(move || (0..100).for_each(|_| write_atomic(path, &content).unwrap()));
        }
    });
    let content = std::fs::read(&path).unwrap();
    assert!(content.len() == 5000 && content.iter().all(|b| *b == content[0]));
    assert_eq!(files(dir.path()), [path]);
}

#[test]
fn a_label_changed_inside_a_file_of_a_data_set_is_seen_by_every_reader() {
    let made = made();
    let data = made.tiny.out("changed");
    copy(&made.tiny.out("data"), &data);
    let path = DataSet::open(&data).unwrap().objects[0].path.clone();
    let mut bytes = std::fs::read(&path).unwrap();
    let scene = bytes.windows(13).position(|w| w == b"friction: 0.8");
    let label = bytes.windows(8).position(|w| w == 0.8_f64.to_le_bytes()).expect("the number");
    bytes[label..label + 8].copy_from_slice(&0.1_f64.to_le_bytes());
    if let Some(at) = scene {
        bytes[at + 12] = b'1';
    }
    std::fs::write(&path, bytes).unwrap();
    let set = DataSet::open(&data).unwrap();
    assert!(set.objects.len() == 1 && set.damaged.len() == 1);
    let text = set.damaged[0].to_string();
    assert!(text.contains("ball_") && text.contains("changed or damaged"), "{text}");
    let (data, model) = (data.to_str().unwrap(), made.model.to_str().unwrap());
    let (spec, out) = (made.spec.to_str().unwrap(), made.tiny.out("never"));
    for arguments in
        [vec!["train", data, "--model", spec, "-o", out.to_str().unwrap()], vec!["eval", data, "--model", model]]
    {
        let refused = tactus(made.tiny.dir.path(), made.tiny.dir.path(), &arguments);
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
        assert!(errors(&refused).contains("changed or damaged"), "{}", errors(&refused));
    }
}

#[test]
fn an_unfinished_data_set_goes_on_from_its_plan_whatever_its_files_say() {
    let tiny = &linear().tiny;
    let content = |dir: &Path| -> BTreeMap<PathBuf, Vec<u8>> {
        files(dir).into_iter().map(|p| (p.strip_prefix(dir).unwrap().into(), std::fs::read(&p).unwrap())).collect()
    };
    let whole = content(&linear().folder());
    let part = tiny.out("part");
    let done = tiny.command(&part).args(["--part", "1/2"]).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", errors(&done));
    let manifest: Value = serde_json::from_slice(&std::fs::read(part.join("manifest.json")).unwrap()).unwrap();
    let mut short = manifest.clone();
    short["objects"] = serde_json::json!([]);
    let mut reversed = manifest.clone();
    reversed["objects"].as_array_mut().unwrap().reverse();
    let [short, reversed] = [short, reversed].map(|m| m.to_string());
    type Damage = Box<dyn Fn(&Path)>;
    let damage: [(&str, Damage); 6] = [
        ("no object", Box::new(move |dir| std::fs::write(dir.join("manifest.json"), &short).unwrap())),
        ("reversed", Box::new(move |dir| std::fs::write(dir.join("manifest.json"), &reversed).unwrap())),
        ("a record cut off", Box::new(|dir| std::fs::write(dir.join(".progress/ball/000000.json"), "{\"gr").unwrap())),
        (
            "a record changed",
            Box::new(|dir| {
                let path = dir.join(".progress/ball/000000.json");
                let text = std::fs::read_to_string(&path).unwrap();
                assert!(text.contains("\"frames\":2"));
                std::fs::write(&path, text.replace("\"frames\":2", "\"frames\":1")).unwrap();
            }),
        ),
        (
            "files swapped",
            Box::new(|dir| {
                let open = |name: &str| {
                    let is = |p: &PathBuf| {
                        p.extension().is_some_and(|e| e == "open") && p.display().to_string().contains(name)
                    };
                    files(&dir.join("dgs_output")).into_iter().find(is).unwrap()
                };
                let (ball, brick) = (open("ball_"), open("box_"));
                let other = std::fs::read(&ball).unwrap();
                std::fs::rename(&brick, &ball).unwrap();
                std::fs::write(&brick, other).unwrap();
            }),
        ),
        (
            "a row and the head changed",
            Box::new(|dir| {
                let path = files(&dir.join("dgs_output")).remove(0);
                let mut bytes = std::fs::read(&path).unwrap();
                let end = bytes.len();
                bytes[end / 2..end / 2 + 64].fill(0x33);
                let label = bytes.windows(8).position(|w| w == 0.8_f64.to_le_bytes()).expect("friction");
                bytes[label..label + 8].copy_from_slice(&0.1_f64.to_le_bytes());
                std::fs::write(&path, bytes).unwrap();
            }),
        ),
    ];
    for (what, damage) in damage {
        let out = tiny.out(&what.replace(' ', "_"));
        copy(&part, &out);
        damage(&out);
        tiny.make(&out);
        assert!(content(&out) == whole, "{what}: other bytes than without");
    }
    // A finished data set is not computed again, but its manifest is checked against the objects.
    let finished = linear().copy("finished");
    let manifest = finished.join("manifest.json");
    let text = std::fs::read_to_string(&manifest).unwrap();
    std::fs::write(&manifest, text.replacen("\"reached\": 3", "\"reached\": 2", 1)).unwrap();
    let refused = tiny.command(&finished).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(errors(&refused).contains("changed or damaged"), "{}", errors(&refused));
    let refused = tiny.stronger(&part);
    assert!(errors(&refused).contains("contains another data set"), "{}", errors(&refused));
}

#[test]
fn an_array_that_claims_more_than_its_file_holds_is_refused_unread() {
    let sizes = FileSizes { grasps: 1, frames: 1, pads: 1, nodes: 4, corners: 4, tets: 1, tactile: Vec::new() };
    let mut builder = FileBuilder::new();
    builder.set_attr("format", AttrValue::U64(FORMAT));
    for array in ARRAYS {
        let shape: Vec<u64> = std::iter::once(1).chain(array.row_shape(&sizes)).map(|n| n as u64).collect();
        let kind = match array.kind {
            NumberKind::U8 => hdf5_pure::make_u8_type(),
            NumberKind::U32 => hdf5_pure::make_u32_type(),
            NumberKind::F32 => hdf5_pure::make_f32_type(),
            NumberKind::F64 => hdf5_pure::make_f64_type(),
        };
        let (bytes, count) = (vec![0; array.row_bytes(&sizes)], shape.iter().product());
        builder.create_dataset(array.name).with_raw_data(kind, bytes, count).with_shape(&shape);
    }
    let mut group = builder.create_group("pad");
    let rows = 1 << 20;
    let tets = group.create_dataset("tets").with_u32_data(&vec![0; 4 * rows]).with_shape(&[rows as u64, 4]);
    tets.with_chunks(&[rows as u64, 4]).with_deflate(9);
    builder.add_group(group.finish());
    let mut content = Vec::new();
    builder.finish_to(&mut content).unwrap();
    assert!(content.len() < rows, "{} bytes claim {} bytes", content.len(), 16 * rows);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("claims.h5");
    std::fs::write(&path, content).unwrap();
    let error = ObjectFile::open(&path).unwrap_err().to_string();
    assert!(error.contains("claims.h5") && error.contains("`pad/tets`") && error.contains("is compressed"), "{error}");
}

/// Content of a data set: name, geometry, status, numbers and grasps of each object, and an entry for splits and
/// manifest.
type Told = Vec<(String, String, Vec<u8>, Vec<(String, Vec<f64>)>, Vec<StoredGrasp>)>;

/// Reads the whole content of a data set; None if any part is refused.
fn told(dir: &Path) -> Option<Told> {
    let set = DataSet::open(dir).ok()?;
    if !set.damaged.is_empty() {
        return None;
    }
    let of = |o: &tactus::dataset::ObjectFile| {
        let mut numbers: Vec<_> = o.numbers.clone().into_iter().collect();
        numbers.sort_by(|a, b| a.0.cmp(&b.0));
        let grasps = (0..o.sizes.grasps).map(|g| o.grasp(g).ok()).collect::<Option<Vec<_>>>()?;
        let geometry = format!("{} {:?} {:?} {:?}", o.scene, o.pads, o.object, o.pad_poses);
        Some((o.name.clone(), geometry, o.status.clone(), numbers, grasps))
    };
    let mut all = set.objects.iter().map(of).collect::<Option<Told>>()?;
    let splits = serde_json::to_string(&set.splits).unwrap();
    all.push((splits, format!("{:?}", set.manifest), Vec::new(), Vec::new(), Vec::new()));
    Some(all)
}

/// Damages the content of a file at random, or replaces it by `other`, a file of the same kind. Returns a description
/// and the new content.
fn mutate(bytes: &[u8], other: &[u8], random: &mut Random) -> (String, Vec<u8>) {
    let mut changed = bytes.to_vec();
    let at = random.uniform_below(bytes.len());
    let what = match random.uniform_below(8) {
        0..3 => {
            let bit = random.uniform_below(8);
            changed[at] ^= 1 << bit;
            format!("bit {bit} of byte {at} turned")
        }
        3 => {
            let value = random.uniform_below(256) as u8;
            changed[at] = value;
            format!("byte {at} set to {value}")
        }
        4..6 => {
            let end = (at + 1 + random.uniform_below(4096)).min(bytes.len());
            changed[at..end].fill(0);
            format!("bytes {at} to {end} zero")
        }
        6 => {
            changed.truncate(at);
            format!("cut off at {at}")
        }
        _ => {
            changed = other.to_vec();
            "another file of its kind".into()
        }
    };
    (what, changed)
}

#[test]
fn no_change_of_a_file_changes_an_answer_silently() {
    let number = |name: &str| std::env::var(name).ok().and_then(|v| v.parse::<usize>().ok());
    let count = number("TACTUS_MUTATIONS").unwrap_or(120);
    let mut random = Random::new(number("TACTUS_MUTATIONS_SEED").unwrap_or(1) as u64);
    let made = made();
    let dir = tempfile::tempdir().unwrap();
    // A data set, a model and a checkpoint to damage, and replacements of the same kind.
    let [data, model, begun] = ["data", "model", "begun"].map(|name| dir.path().join(name));
    copy(&made.tiny.out("data"), &data);
    copy(&made.model, &model);
    std::fs::create_dir(&begun).unwrap();
    let spec: Spec = ron(SPEC);
    let other = dir.path().join("other");
    let mut checkpoints = Vec::new();
    let mut trainer =
        Trainer::new(&[set(made)], &ron(&SPEC.replace("seed: 3", "seed: 4")), "poses", &other, None).unwrap();
    trainer.run(|_| checkpoints.push(std::fs::read(other.join("checkpoint.bin")).unwrap())).unwrap();
    let again = dir.path().join("again");
    let mut own = Vec::new();
    let mut trainer = Trainer::new(&[set(made)], &spec, "poses", &again, None).unwrap();
    trainer.run(|_| own.push(std::fs::read(again.join("checkpoint.bin")).unwrap())).unwrap();
    std::fs::write(begun.join("checkpoint.bin"), &own[1]).unwrap();
    let (ball, pose) = ball(made);
    let cache = ComplianceCache::at(dir.path().join("kept"));
    let graph = PadGraph::with_cache(&ball.fingers[0], LAYOUT, Some(&cache)).unwrap();
    let kept = cache.path(&key(&ball.fingers[0]));
    let features =
        GraspFeatures::new(&ball, &std::sync::Arc::new(graph.clone()), &GeometricContact::find(&ball, pose).unwrap());
    let answer = || -> Option<(String, GraspState)> {
        let predictor = Predictor::open(&model).ok()?;
        let states = predictor.at(&predictor.encode(features.clone()), 0.5).ok()?;
        Some((format!("{:?}", predictor.card), states))
    };
    let (expected_told, expected_answer) = (told(&data).unwrap(), answer().unwrap());

    let data_files = files(&data);
    let data_files: Vec<&PathBuf> =
        data_files.iter().filter(|f| f.extension().is_some_and(|e| e == "h5" || e == "json")).collect();
    let data_files: Vec<&PathBuf> =
        data_files.into_iter().filter(|f| !f.display().to_string().contains("_grasps")).collect();
    let (mut refused, mut same) = (0, 0);
    for k in 0..count {
        let (path, kind) = match k % 12 {
            0..5 => (data_files[random.uniform_below(data_files.len())].clone(), "data"),
            5..7 => (model.join("card.ron"), "model"),
            7..9 => (model.join("weights.safetensors"), "model"),
            9 => (begun.join("checkpoint.bin"), "checkpoint"),
            _ => (kept.clone(), "kept"),
        };
        let whole = std::fs::read(&path).unwrap();
        let stranger = match kind {
            "data" => {
                let alike = |f: &&&PathBuf| **f != &path && f.extension() == path.extension();
                std::fs::read(data_files.iter().find(alike).unwrap()).unwrap()
            }
            "model" => std::fs::read(other.join(path.file_name().unwrap())).unwrap(),
            "checkpoint" => checkpoints[1].clone(),
            _ => whole[..whole.len() - 8].to_vec(),
        };
        let (what, changed) = mutate(&whole, &stranger, &mut random);
        std::fs::write(&path, &changed).unwrap();
        let outcome = catch_unwind(AssertUnwindSafe(|| match kind {
            "data" => told(&data).map(|told| told == expected_told),
            "model" => answer().map(|answer| answer == expected_answer),
            "checkpoint" => {
                let trainer = Trainer::new(&[set(made)], &spec, "poses", &begun, None).ok()?;
                // The checkpoint is named as damaged, and the training starts from the beginning.
                let named = trainer.notices.iter().any(|n| n.contains("checkpoint.bin: is damaged"));
                if named && trainer.epochs().is_empty() {
                    None
                } else {
                    Some(trainer.epochs().len() == 2 && changed == whole)
                }
            }
            _ => cache.read(&key(&ball.fingers[0])).map(|c| c.response[..] == graph.compliance.response[..]),
        }));
        std::fs::write(&path, &whole).unwrap();
        let name = path.file_name().unwrap().display();
        match outcome {
            Ok(None) => refused += 1,
            Ok(Some(true)) => same += 1,
            Ok(Some(false)) => panic!("mutation {k}, {name}, {what}: another answer, without a word"),
            Err(_) => panic!("mutation {k}, {name}, {what}: a panic"),
        }
    }
    println!("{count} changes: {refused} refused by name or made anew, {same} without effect");
    assert!(refused * 10 > count * 7, "{refused} of {count} were noticed");
}
