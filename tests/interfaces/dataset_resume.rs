//! An interrupted data set resumes without loss or repetition, and ends with the same bytes. `TACTUS_ALL_KILLS=1` kills
//! thirty times.

use crate::dataset_tiny::linear;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, SystemTime};
use tactus::base::random::Random;

/// Paths of all files below `dir`, with their bytes.
fn files(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
        if entry.is_dir() {
            all.extend(files(&entry));
        } else {
            all.insert(entry.clone(), std::fs::read(&entry).unwrap());
        }
    }
    all
}

/// As [`files`], with paths relative to `dir`.
fn content(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    files(dir).into_iter().map(|(p, b)| (p.strip_prefix(dir).unwrap().into(), b)).collect()
}

/// Records of finished grasps, with their modification times.
fn records(out: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let progress = out.join(".progress");
    let Ok(objects) = std::fs::read_dir(&progress) else { return BTreeMap::new() };
    let entries = objects.flatten().flat_map(|o| std::fs::read_dir(o.path()).into_iter().flatten().flatten());
    let finished = entries.filter(|e| e.path().extension().is_some_and(|x| x == "json"));
    finished.filter_map(|e| Some((e.path(), e.metadata().ok()?.modified().ok()?))).collect()
}

#[test]
fn killed_at_any_moment_it_goes_on_and_ends_with_the_same_bytes() {
    let whole = linear();
    let (tiny, whole_run) = (&whole.tiny, whole.took);
    let expected = content(&whole.folder());
    let kills = if std::env::var_os("TACTUS_ALL_KILLS").is_some() { 30 } else { 6 };
    let (mut random, mut killed, mut runs, mut kept) = (Random::new(1), 0, 0, 0);
    while killed < kills {
        let out = tiny.out(&format!("run{runs}"));
        loop {
            let before = records(&out);
            kept += before.len();
            let mut child = tiny.command(&out).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            std::thread::sleep(Duration::from_secs_f64(whole_run.as_secs_f64() * 0.6 * random.uniform()));
            // SIGKILL, so the process cannot clean up.
            let ended = child.try_wait().unwrap().is_some();
            child.kill().unwrap();
            child.wait().unwrap();
            let after = records(&out);
            // Records are deleted one by one after the manifest is marked as finished.
            if ended
                || std::fs::read_to_string(out.join("manifest.json")).is_ok_and(|m| m.contains("\"finished\": true"))
            {
                break;
            }
            killed += 1;
            for (record, written) in &before {
                assert_eq!(after.get(record), Some(written), "{} was made again", record.display());
            }
        }
        let report = tiny.make(&out);
        assert_eq!(report["manifest"]["finished"], true);
        let got = content(&out);
        let names = |c: &BTreeMap<PathBuf, Vec<u8>>| c.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&got), names(&expected));
        for (name, bytes) in &expected {
            assert!(got[name] == *bytes, "{} differs after {killed} kills", name.display());
        }
        runs += 1;
    }
    println!(
        "{killed} kills in {runs} data sets, {kept} records found again; all bytes are those of a run without a kill"
    );
}

#[test]
fn threads_do_not_change_bytes_and_the_size_is_announced() {
    let whole = linear();
    let tiny = &whole.tiny;
    let announced = whole.report["announced_bytes"].as_u64().unwrap();
    let one = tiny.command(&tiny.out("one")).args(["--threads", "1"]).output().unwrap();
    assert_eq!(one.status.code(), Some(1));
    let (one, two) = (content(&tiny.out("one")), content(&whole.folder()));
    assert!(one == two, "1 and 2 threads give the same files");
    let bytes: usize = two.values().map(Vec::len).sum();
    assert!(bytes as u64 <= announced, "{bytes} bytes on disk, {announced} announced");
    let copy = whole.copy("two");
    let again = tiny.make(&copy);
    assert_eq!((again["computed"].as_u64(), again["resumed"].as_u64()), (Some(0), Some(6)), "nothing runs again");
    let other = tiny.stronger(&copy);
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&other.stderr).contains("contains another data set"));
}

/// Parts run concurrently, one of them is killed and restarted, and a last run finishes the data set.
#[test]
fn parts_end_with_the_same_bytes_and_no_grasp_is_made_twice() {
    let tiny = &linear().tiny;
    let out = tiny.out("parts");
    let part = |text: &str| {
        let mut command = tiny.command(&out);
        command.args(["--part", text]).stdout(Stdio::piped()).stderr(Stdio::null());
        command
    };
    let mut killed = part("1/3").spawn().unwrap();
    let others = ["2/3", "3/3"].map(|text| part(text).spawn().unwrap());
    std::thread::sleep(Duration::from_millis(100));
    killed.kill().unwrap();
    killed.wait().unwrap();
    let computed = |child: std::process::Child| {
        let done = child.wait_with_output().unwrap();
        assert_eq!(done.status.code(), Some(0));
        serde_json::from_slice::<serde_json::Value>(&done.stdout).unwrap()["computed"].as_u64().unwrap()
    };
    assert_eq!(others.map(computed), [2, 2], "two grasps of six each");
    assert!(computed(part("1/3").spawn().unwrap()) <= 2);
    assert_eq!(computed(part("1/3").spawn().unwrap()), 0, "nothing is left of the part");
    assert_eq!(tiny.make(&out)["computed"], 0, "all parts are there");
    assert_eq!(computed(part("2/3").spawn().unwrap()), 0, "a closed data set stays closed");
    assert!(content(&out) == content(&linear().folder()), "the bytes of a run at once");
    let refused = part("4/3").stderr(Stdio::piped()).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("allowed: I/N with I from 1 to N"));
}
