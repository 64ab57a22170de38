//! Seeded mutations of the shipped scenes: for any scene text, the program exits with one of its codes in bounded time
//! and memory, and an error message gives the place in the file.
//!
//! `TACTUS_MUTATIONS=3000 cargo test --release --test scenes mutations::` runs 3000 of them; the default is [`QUICK`].

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use tactus::base::random::Random;

/// Default number of mutations.
const QUICK: usize = 100;
/// Address space limit of a child, MB.
const MEMORY: u64 = 6000;
/// Processor time limit of a child, s, which does not depend on the load of the machine.
const SECONDS: u64 = 20;
/// Signal that ends a process beyond its processor time limit.
const SIGXCPU: i32 = 24;
/// Wall time limit of a child, for hangs that use no processor time.
const HANG: Duration = Duration::from_secs(600);
/// Scenes with too many grasps to check all of them here.
const LARGE: [&str; 4] = ["paper.ron", "paper_small.ron", "second_sensor.ron", "shapes.ron"];

/// Draws one of `choices`.
fn of<'a>(random: &mut Random, choices: &[&'a str]) -> &'a str {
    choices[random.uniform_below(choices.len())]
}

/// Splits a text into words, numbers, strings and punctuation; white space and comments belong to the token before
/// them.
fn tokens(text: &str) -> Vec<String> {
    let mut found: Vec<String> = vec![String::new()];
    let mut chars = text.chars().peekable();
    let word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '-' | '+');
    while let Some(c) = chars.next() {
        let mut token = c.to_string();
        match c {
            c if c.is_whitespace() => {
                found.last_mut().unwrap().push(c);
                continue;
            }
            '/' if chars.peek() == Some(&'/') => {
                let comment: String = std::iter::from_fn(|| chars.next_if(|c| *c != '\n')).collect();
                found.last_mut().unwrap().push_str(&(token + &comment));
                continue;
            }
            '"' => {
                token.extend(std::iter::from_fn(|| chars.next_if(|c| *c != '"')));
                token.extend(chars.next());
            }
            c if word(c) => token.extend(std::iter::from_fn(|| chars.next_if(|c| word(*c)))),
            _ => {}
        }
        found.push(token);
    }
    found
}

fn is_number(token: &str) -> bool {
    token.trim().parse::<f64>().is_ok()
}

/// Applies one random change to the text of a scene.
fn mutate(text: &str, random: &mut Random) -> Vec<u8> {
    let mut parts = tokens(text);
    if text.is_empty() || parts.is_empty() {
        return Vec::new();
    }
    let at = random.uniform_below(parts.len());
    match random.uniform_below(12) {
        0..=4 => {
            let numbers: Vec<usize> = (0..parts.len()).filter(|i| is_number(&parts[*i])).collect();
            let extremes = [
                "0",
                "-1",
                "1e300",
                "1e-300",
                "NaN",
                "inf",
                "-0.0",
                "1e-7",
                "1e7",
                "3",
                "0.5",
                "1000000",
                "4294967296",
                "-1e300",
                "1e20",
                "170",
                "18446744073709551616",
            ];
            if let Some(number) = numbers.get(random.uniform_below(numbers.len())) {
                parts[*number] = of(random, &extremes).into();
            }
        }
        5 => drop(parts.remove(at)),
        6 => parts.insert(at, parts[at].clone()),
        7 => {
            let other = random.uniform_below(parts.len());
            parts.swap(at, other);
        }
        8 => {
            // Removes or duplicates a field.
            let fields: Vec<usize> = (1..parts.len()).filter(|i| parts[*i].trim() == ":").collect();
            if let Some(colon) = fields.get(random.uniform_below(fields.len())) {
                let end = (*colon..parts.len()).find(|i| parts[*i].trim() == ",").unwrap_or(parts.len() - 1);
                let field: Vec<String> = parts.drain(colon - 1..=end).collect();
                if random.uniform_below(2) == 0 {
                    let twice: Vec<_> = field.iter().chain(&field).cloned().collect();
                    drop(parts.splice(colon - 1..colon - 1, twice));
                }
            }
        }
        9 => {
            let (open, close) = [("[", "]"), ("(", ")"), ("Some(", ")"), ("[[[[", "]]]]")][random.uniform_below(4)];
            parts[at] = format!("{open}{}{close}", parts[at]);
        }
        10 => {
            let whole = parts.concat().into_bytes();
            return whole[..random.uniform_below(whole.len())].to_vec();
        }
        _ => {
            let mut whole = parts.concat().into_bytes();
            for _ in 0..=random.uniform_below(4) {
                let place = random.uniform_below(whole.len());
                whole[place] = random.uniform_below(256) as u8;
            }
            return whole;
        }
    }
    parts.concat().into_bytes()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(|e| e.unwrap().path()) {
        let target = to.join(entry.file_name().unwrap());
        if entry.is_dir() {
            copy(&entry, &target);
        } else {
            std::fs::copy(&entry, &target).unwrap();
        }
    }
}

/// Waits for the end of a child; kills it after [`HANG`] and returns None.
fn wait(mut child: Child) -> Option<std::process::Output> {
    let clock = Instant::now();
    while clock.elapsed() < HANG {
        if child.try_wait().unwrap().is_some() {
            return child.wait_with_output().ok();
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    None
}

/// True if a text contains a place in a scene file, `name.ron:line:column`.
fn has_place(text: &str) -> bool {
    let number = |part: Option<&str>| part.is_some_and(|p| p.starts_with(|c: char| c.is_ascii_digit()));
    text.match_indices(".ron:").any(|(at, found)| {
        let mut parts = text[at + found.len()..].splitn(3, ':');
        number(parts.next()) && number(parts.next())
    })
}

/// Returns how the program violates its contract on a scene, if it does. Unless `bounded`, it may exceed its processor
/// time limit.
fn complaint(scene: &Path, command: &[&str], bounded: bool) -> Option<String> {
    let limits = format!("ulimit -v {}; ulimit -S -t {SECONDS}; exec \"$0\" \"$@\"", MEMORY << 10);
    let out = scene.with_extension("out");
    let output = || std::fs::File::create(&out).unwrap();
    let child = Command::new("sh")
        .args(["-c", &limits, env!("CARGO_BIN_EXE_tactus"), command[0]])
        .arg(scene)
        .args(&command[1..])
        .env("RUST_BACKTRACE", "0")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .stdin(Stdio::null())
        .stdout(output())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let Some(done) = wait(child) else { return Some("hangs".into()) };
    let error = String::from_utf8_lossy(&done.stderr);
    let said = std::fs::read(&out).unwrap_or_default();
    let said = String::from_utf8_lossy(&said);
    match done.status.code() {
        _ if error.contains("panicked") => Some(format!("panics: {error}")),
        Some(0 | 1) => None,
        // Starts that are refused are findings of the check.
        Some(2) if said.contains("problem: ") => None,
        Some(2) if has_place(&error) => None,
        // An option that is incompatible with the scene is named instead of a place.
        Some(2) if error.starts_with("error: --") => None,
        // An error that concerns the whole file has no line.
        Some(2) if error.starts_with("error: ") && error.contains("mutant") => None,
        Some(2) => Some(format!("no place: {error}")),
        None if !bounded && done.status.signal() == Some(SIGXCPU) => None,
        _ => Some(format!("ends with {:?}: {error}", done.status)),
    }
}

#[test]
fn mutated_scenes_end_by_themselves_and_say_where() {
    let count =
        std::env::var("TACTUS_MUTATIONS").ok().map_or(QUICK, |n| n.parse().expect("TACTUS_MUTATIONS: a number"));
    let first =
        std::env::var("TACTUS_MUTATIONS_FROM").ok().map_or(0, |n| n.parse().expect("TACTUS_MUTATIONS_FROM: a number"));
    let dir = tempfile::tempdir().unwrap();
    copy(&crate::promises::shipped(), &dir.path().join("scenes"));
    let scenes: Vec<PathBuf> = crate::promises::scenes(&dir.path().join("scenes"), &["slow", "meshes"])
        .into_iter()
        .filter(|path| !LARGE.iter().any(|large| path.ends_with(large)))
        .collect();
    let mut run = vec!["run", "--frames", "1", "--grasp", "0", "--no-pictures", "--threads", "1"];
    let help = Command::new(env!("CARGO_BIN_EXE_tactus")).args(["run", "--help"]).output().unwrap();
    let timed = String::from_utf8_lossy(&help.stdout).contains("--max-time");
    run.extend(if timed { &["--max-time", "5"][..] } else { &[] });
    let (next, found) = (AtomicUsize::new(first), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= first + count {
                        return;
                    }
                    let mut random = Random::new(seed as u64);
                    let origin = &scenes[random.uniform_below(scenes.len())];
                    let mut text = std::fs::read(origin).unwrap();
                    for _ in 0..=random.uniform_below(2) {
                        text = mutate(&String::from_utf8_lossy(&text), &mut random);
                    }
                    let scene = origin.with_file_name(format!("mutant_{seed}.ron"));
                    std::fs::write(&scene, text).unwrap();
                    let check = random.uniform_below(5) > 0;
                    let command: &[&str] = if check { &["check"] } else { &run };
                    if let Some(what) = complaint(&scene, command, check || timed) {
                        let text = std::fs::read(&scene).unwrap();
                        let name = origin.strip_prefix(dir.path()).unwrap().display();
                        let report =
                            format!("{seed} ({} of {name}): {what}\n{}", command[0], String::from_utf8_lossy(&text));
                        println!("{report}");
                        found.lock().unwrap().push(report);
                    }
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    assert!(found.is_empty(), "{} of {count}:\n{}", found.len(), found.join("\n\n"));
}
