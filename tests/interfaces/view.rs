//! `tactus view` and `--watch`: a page served to this machine only, which is updated with the results.

use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Time limit of every wait, more than ten times what any of them takes.
const LIMIT: Duration = Duration::from_secs(120);

/// Six presses of 0.1 s of computing time each.
const SCENE: &str = "(object: (shape: Sphere(radius: 6e-3), motion: Fixed),
    grasps: List([
        (position: (0, 0, -0.1)), (position: (0, 0.001, -0.1)), (position: (0, 0.002, -0.1)),
        (position: (0, -0.001, -0.1)), (position: (0, -0.002, -0.1)), (position: (0, 0, -0.101)),
    ]),
    gripper: (pads: Box(size: (0.016, 0.016, 0.0045), cells: (4, 4, 2)), opening: 0.02, friction: 0.0,
              fingers: One, material: NeoHookean(young: 3e5, poisson: 0.45)),
    loading: Press(depths: [0.1e-3, 0.2e-3]), record: (pictures: false))";
/// Replaces the loading of [`SCENE`] and adds an expectation that every grasp violates.
const BROKEN: &str = "loading: Press(depths: [0.1e-3, 0.2e-3]), expect: [Penetration(at_most: 1e-15)],";

/// A running viewer.
struct Viewing {
    child: Child,
    stdout: BufReader<ChildStdout>,
    stderr: BufReader<ChildStderr>,
    address: String,
}

impl Viewing {
    /// Starts a command and reads its address from the first line on stdout (`view`) or stderr (`--watch`).
    fn start(arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
        let mut child = command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut stdout = BufReader::new(child.stdout.take().unwrap());
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        let from: &mut dyn BufRead = if arguments[0] == "view" { &mut stdout } else { &mut stderr };
        from.read_line(&mut line).unwrap();
        let at = line.find("127.0.0.1:").unwrap_or_else(|| panic!("no address in {line:?}"));
        let address = line[at..].split('/').next().unwrap().to_string();
        Self { child, stdout, stderr, address }
    }

    /// Sends a request with these lines; returns its status and the whole answer.
    fn ask(&self, lines: &[&str]) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        stream.write_all(format!("{}\r\n\r\n", lines.join("\r\n")).as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        (answer.split(' ').nth(1).unwrap().parse().unwrap(), answer)
    }

    fn get(&self, path: &str) -> String {
        let (status, answer) = self.ask(&[&format!("GET {path} HTTP/1.1"), &format!("Host: {}", self.address)]);
        assert_eq!(status, 200, "{path}: {answer}");
        answer.split_once("\r\n\r\n").unwrap().1.to_string()
    }

    fn state(&self) -> String {
        let answer: Value = serde_json::from_str(&self.get("/state")).unwrap();
        answer["state"].as_str().unwrap().to_string()
    }

    /// Sends SIGINT (Ctrl-C); returns the exit code and the rest of stdout and stderr.
    fn end(mut self) -> (Option<i32>, String, String) {
        assert!(self.child.try_wait().unwrap().is_none(), "it stays until Ctrl-C");
        assert!(Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap().success());
        let mut texts = [String::new(), String::new()];
        self.stdout.read_to_string(&mut texts[0]).unwrap();
        self.stderr.read_to_string(&mut texts[1]).unwrap();
        let [stdout, stderr] = texts;
        (self.child.wait().unwrap().code(), stdout, stderr)
    }
}

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let clock = Instant::now();
    while !holds() {
        assert!(clock.elapsed() < LIMIT, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A folder with a scene, and the run of its first grasp.
fn made() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let (scene, run) = (dir.path().join("press.ron"), dir.path().join("run"));
    std::fs::write(&scene, SCENE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    let ended = command.args(["run", text(&scene), "-o", text(&run), "--grasp", "0"]).output().unwrap();
    assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
    dir
}

/// As [`made`], shared by tests that only look at it.
static MADE: LazyLock<tempfile::TempDir> = LazyLock::new(made);

#[test]
fn only_this_machine_and_its_own_names_are_answered() {
    let dir = &*MADE;
    let viewing = Viewing::start(&["view", text(&dir.path().join("run"))]);
    let own = format!("Host: {}", viewing.address);
    let status = |lines: &[&str]| viewing.ask(lines).0;
    assert_eq!(status(&["GET / HTTP/1.1", &own]), 200);
    assert_eq!(status(&["GET /?anything HTTP/1.1", "Host: localhost"]), 200);
    for foreign in ["example.org", "127.0.0.1.example.org:80", "localhost.example.org", "[::1]:80", "0.0.0.0", ""] {
        assert_eq!(status(&["GET / HTTP/1.1", &format!("Host: {foreign}")]), 403, "{foreign}");
    }
    assert_eq!(status(&["GET / HTTP/1.1"]), 400, "without a host");
    assert_eq!(status(&["GET / HTTP/1.1", &own, "Host: example.org"]), 400, "two hosts");
    assert_eq!(status(&["nonsense"]), 400);
    assert_eq!(status(&["GET / HTTP/1.1", &own, &format!("X: {}", "x".repeat(100_000))]), 431);
    for path in ["/run.json", "/../press.ron", "/state/", "//", "/%2e%2e/"] {
        assert_eq!(status(&[&format!("GET {path} HTTP/1.1"), &own]), 404, "{path}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "HEAD"] {
        let (status, answer) = viewing.ask(&[&format!("{method} / HTTP/1.1"), &own, "Content-Length: 3", "", "abc"]);
        assert!(status == 405 && answer.contains("Allow: GET"), "{method}: {answer}");
    }
    let page = viewing.get("/");
    assert!(page.contains("default-src 'none'") && page.contains("connect-src 'self'"), "no origin but its own");
    if let Ok(sockets) = std::fs::read_to_string("/proc/net/tcp") {
        let port: u16 = viewing.address.rsplit(':').next().unwrap().parse().unwrap();
        let listens = |line: &&str| line.contains(&format!(":{port:04X} 00000000:0000 0A"));
        let local: Vec<&str> = sockets.lines().filter(listens).collect();
        assert!(local.len() == 1 && local[0].contains("0100007F:"), "127.0.0.1 alone: {local:?}");
    }
    assert_eq!(viewing.end().0, Some(0));
}

/// Clients that send their requests byte by byte occupy connections of the server only for the time limit of a request.
#[test]
fn slow_requests_do_not_shut_others_out() {
    let dir = &*MADE;
    let viewing = Viewing::start(&["view", text(&dir.path().join("run"))]);
    let open = |_| {
        let mut stream = TcpStream::connect(&viewing.address).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nX: ").unwrap();
        stream
    };
    let mut slow: Vec<TcpStream> = (0..40).map(open).collect();
    let is_answered = || {
        // A client that is refused finds its connection closed.
        let mut stream = TcpStream::connect(&viewing.address).unwrap();
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        let mut answer = String::new();
        let asked = stream.write_all(format!("GET /state HTTP/1.1\r\nHost: {}\r\n\r\n", viewing.address).as_bytes());
        asked.is_ok() && stream.read_to_string(&mut answer).is_ok() && answer.starts_with("HTTP/1.1 200")
    };
    wait_until("an answer beside clients that send on", || {
        slow.iter_mut().for_each(|stream| drop(stream.write_all(b"x")));
        is_answered()
    });
    assert_eq!(viewing.end().0, Some(0));
}

#[test]
fn state_and_page_change_with_the_grasps() {
    let dir = made();
    let (scene, run) = (dir.path().join("press.ron"), dir.path().join("run"));
    let viewing = Viewing::start(&["view", text(&run)]);
    let (before, page) = (viewing.state(), viewing.get("/"));
    assert_eq!(viewing.state(), before, "nothing has changed");
    assert!(page.contains(&format!("\"state\":\"{before}\"")), "the page knows its state");
    assert!(page.contains("grasp 0") && !page.contains("grasp 1"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    let arguments = ["run", text(&scene), "-o", text(&run), "--overwrite", "--grasp", "0", "--grasp", "1"];
    assert!(command.args(arguments).output().unwrap().status.success());
    assert_ne!(viewing.state(), before);
    assert!(viewing.get("/").contains("grasp 1"));
    std::fs::write(run.join("run.json"), "{").unwrap();
    assert!(viewing.get("/").contains("is not a report of a run"), "what cannot be read is named on the page");
    assert_eq!(viewing.end().0, Some(0));
}

#[test]
fn a_scene_runs_while_it_is_viewed_and_its_verdict_is_the_exit_code() {
    let dir = tempfile::tempdir().unwrap();
    let (scene, out) = (dir.path().join("press.ron"), dir.path().join("out"));
    std::fs::write(&scene, SCENE.replace("loading: Press(depths: [0.1e-3, 0.2e-3]),", BROKEN)).unwrap();
    let finished = || std::fs::read_to_string(out.join("run.json")).is_ok_and(|t| t.contains("\"finished\": true"));
    let viewing = Viewing::start(&["view", text(&scene), "-o", text(&out), "--format", "json"]);
    wait_until("the run ends", finished);
    wait_until("the last grasp is shown", || viewing.get("/").contains("grasp 5"));
    let (code, stdout, _) = viewing.end();
    let report: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((code, report["grasps"].as_array().unwrap().len()), (Some(1), 6), "an expectation is not held");
    let watching = Viewing::start(&["run", text(&scene), "-o", text(&out), "--overwrite", "--watch"]);
    let mut line = String::new();
    let mut watching = watching;
    watching.stderr.read_line(&mut line).unwrap();
    assert!(line.contains("is available until Ctrl-C"), "{line}");
    assert_eq!(watching.end().0, Some(1));
}

#[test]
fn a_run_without_a_folder_is_shown_and_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let (scene, temporary) = (dir.path().join("press.ron"), dir.path().join("tmp"));
    std::fs::create_dir(&temporary).unwrap();
    std::fs::write(&scene, SCENE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.args(["run", text(&scene), "--watch"]).env("TMPDIR", &temporary);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(std::fs::read_dir(&temporary).unwrap().count(), 1, "its report is printed, and the folder is there");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(std::fs::read_dir(&temporary).unwrap().count(), 0);
}

#[test]
fn an_unfinished_data_set_shows_what_has_ended() {
    let dir = tempfile::tempdir().unwrap();
    let (scene, out) = (dir.path().join("press.ron"), dir.path().join("data"));
    std::fs::write(&scene, SCENE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    let part = command.args(["dataset", text(&scene), "-o", text(&out), "--part", "1/2"]).output().unwrap();
    assert_eq!(part.status.code(), Some(0), "{}", String::from_utf8_lossy(&part.stderr));
    let viewing = Viewing::start(&["view", text(&out)]);
    let page = viewing.get("/");
    assert!(page.contains("The data set is not finished: so far 3 of 6 grasps ended."), "counts");
    assert!(page.contains("grasp 0\"") && page.contains("grasp 4\"") && !page.contains("grasp 1\""), "in 3-D");
    assert_eq!(viewing.end().0, Some(0));
}

#[test]
fn what_cannot_be_viewed_is_refused() {
    let dir = &*MADE;
    let refusal = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refusal(&["view", text(dir.path()), "-o", "x"]).contains("-o DIR is the folder of the results of a scene"));
    let empty = tempfile::tempdir().unwrap();
    assert!(refusal(&["view", text(empty.path())]).contains("contains no results to show"));
    assert!(refusal(&["view", "no/such/scene.ron"]).contains("no such file"));
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    assert!(refusal(&["view", text(&dir.path().join("run")), "--port", &port]).contains("--port selects another port"));
    let scene = dir.path().join("press.ron");
    assert!(refusal(&["run", text(&scene), "--port", "0"]).contains("--watch"));
}
