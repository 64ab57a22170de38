//! `tactus report`: the page shows the data, loads nothing from a network, and works in a browser.

use crate::bench_cli::BENCH;
use crate::dataset_tiny::copy;
use crate::gnn_made::{made, set};
use crate::skipped::skipped;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;
use tactus::report::ReportOptions;
use tactus::report::view::Viewer;

pub fn tactus(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).output().unwrap()
}

pub fn good(arguments: &[&str]) -> String {
    let output = tactus(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

pub fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Page with both test grasps and the predictions of the network, shared by tests.
static JUDGED: LazyLock<PathBuf> = LazyLock::new(|| {
    let (data, model, page) = (made().tiny.out("data"), &made().model, made().tiny.out("judged.html"));
    good(&["report", text(&data), "--model", text(model), "--grasps", "2", "--frames", "2", "-o", text(&page)]);
    page
});

fn judged() -> String {
    std::fs::read_to_string(&*JUDGED).unwrap()
}

/// The JSON data of a page.
pub fn data_of(html: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"data\">";
    let own = html.split_once(start).unwrap().1.split_once("</script>").unwrap().0;
    serde_json::from_str(own).unwrap()
}

fn base64(text: &str) -> Vec<u8> {
    let digit =
        |c: u8| b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/".iter().position(|d| *d == c);
    let decode = |four: &[u8]| {
        let bits = four.iter().fold(0, |bits, c| bits << 6 | digit(*c).unwrap_or(0));
        let kept = four.iter().filter(|c| **c != b'=').count() - 1;
        [bits >> 16, bits >> 8, bits].map(|b| b as u8)[..kept].to_vec()
    };
    text.as_bytes().chunks(4).flat_map(decode).collect()
}

/// Numbers of an array of the page, and their rounding error: half a quantisation step.
pub fn numbers(packed: &Value) -> (Vec<f64>, f64) {
    let scale = packed["scale"].as_f64().unwrap_or(1.0);
    let bytes = base64(packed["base64"].as_str().unwrap());
    let values: Vec<f64> = match packed["type"].as_str().unwrap() {
        "i16" => bytes.as_chunks::<2>().0.iter().map(|b| scale * f64::from(i16::from_le_bytes(*b))).collect(),
        "u16" => bytes.as_chunks::<2>().0.iter().map(|b| f64::from(u16::from_le_bytes(*b))).collect(),
        other => panic!("type {other}"),
    };
    let shape = packed["shape"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as usize);
    assert_eq!(values.len(), shape.product::<usize>(), "the array has the length of its shape");
    (values, 0.5 * scale)
}

#[test]
fn the_page_asks_for_nothing_from_elsewhere() {
    let html = judged();
    // The SVG name space is only a name: nothing is loaded from its address.
    let rest = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!rest.contains("http:") && !rest.contains("https:") && !rest.contains("//cdn"), "an address of a network");
    for load in [" src=", "@import", "url(", "fetch(", "XMLHttpRequest", "import(", "WebSocket", "{{"] {
        assert!(!html.contains(load), "{load}");
    }
    let links: Vec<&str> = html.split("href=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
    assert_eq!(links, ["data:,"], "no link but the empty icon");
    assert!(html.contains("default-src 'none'"), "the browser is told to load nothing");
    for tag in ["section", "table", "figure", "script", "style", "fieldset", "div"] {
        let count = |mark: &str| html.matches(mark).count();
        assert_eq!(count(&format!("<{tag}>")) + count(&format!("<{tag} ")), count(&format!("</{tag}>")), "<{tag}>");
    }
}

#[test]
fn the_page_holds_the_truth_to_the_last_step_of_its_scale() {
    let data = data_of(&judged());
    let set = set(made());
    let grasps = data["grasps"].as_array().unwrap();
    assert!(!grasps.is_empty());
    for shown in grasps {
        let (name, number) = shown["name"].as_str().unwrap().split_once(", grasp ").unwrap();
        let file = set.objects.iter().find(|f| f.name == name).unwrap();
        let grasp = file.grasp(number.parse().unwrap()).unwrap();
        let (mesh, object) =
            (&data["meshes"][shown["pads"][0].as_u64().unwrap() as usize], shown["object"].as_u64().unwrap());
        let (rest, step) = numbers(&mesh["rest"]);
        // Pad node of each node of the page.
        let of: Vec<usize> = rest
            .as_chunks::<3>()
            .0
            .iter()
            .map(|x| {
                let near = |n: &usize| {
                    x.iter().zip(file.pads[0].rest[*n].to_array()).all(|(a, b)| (a - b).abs() <= 1.01 * step)
                };
                (0..file.pads[0].rest.len()).find(near).unwrap()
            })
            .collect();
        for triangle in numbers(&mesh["sensing"]).0.as_chunks::<3>().0.iter().zip(&file.pads[0].sensing) {
            assert_eq!(triangle.0.map(|i| of[i as usize] as u32), *triangle.1, "a triangle of the sensing face");
        }
        let vertices = numbers(&data["meshes"][object as usize]["vertices"]).0.len() / 3;
        assert_eq!(vertices, file.object.vertices.len());

        let states = shown["states"].as_array().unwrap();
        let labels: Vec<_> = states.iter().map(|s| s["label"].as_str().unwrap()).collect();
        assert_eq!(labels, ["finite elements", "network"]);
        let (frames, pads, n) = (grasp.frames, file.sizes.pads, file.sizes.nodes);
        let ((u, du), (s, ds)) = (numbers(&states[0]["displacement"]), numbers(&states[0]["stress"]));
        assert_eq!(u.len(), frames * pads * of.len() * 3);
        for (at, own) in u.chunks(of.len() * 3).enumerate() {
            for (x, node) in own.as_chunks::<3>().0.iter().zip(&of) {
                let true_u = &grasp.displacement[3 * (at * n + node)..][..3];
                let off = x.iter().zip(true_u).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max);
                assert!(off <= 1.01 * du + 1e-12, "node {node}: off by {off} m, the step is {du} m");
            }
        }
        for (at, own) in s.chunks(of.len()).enumerate() {
            for (x, node) in own.iter().zip(&of) {
                let off = (x - f64::from(grasp.von_mises[at * n + node])).abs();
                assert!(off <= 1.01 * ds + 1e-6, "node {node}: off by {off} Pa, the step is {ds} Pa");
            }
        }
        // The page has all nodes in contact: their forces add up to the wrench, N.
        let (places, (force, df)) =
            (numbers(&states[0]["contact_force"]["nodes"]).0, numbers(&states[0]["contact_force"]["values"]));
        for (k, own) in force.chunks(3 * places.len()).enumerate() {
            for pad in 0..pads {
                let on_pad = own.as_chunks::<3>().0.iter().zip(&places).filter(|(_, i)| **i as usize / of.len() == pad);
                let (count, z) = on_pad.fold((0.0, 0.0), |(c, z), (f, _)| (c + 1.0, z + f[2]));
                let wrench = grasp.wrench[6 * (k * pads + pad) + 2];
                assert!((z - wrench).abs() <= 1.1 * df * count + 1e-5, "{z} N on the page, {wrench} N in the data");
            }
        }
        assert_eq!(shown["errors"]["displacement"].as_array().unwrap().len(), frames);
    }
    let charts = data["charts"].as_array().unwrap();
    assert_eq!(charts.len(), 2, "by object and by force");
    assert_eq!(charts[1]["over"]["axis"]["at"], serde_json::json!([1.0, 2.0]), "force, N");
}

#[test]
fn the_surface_of_a_pad_that_is_shown_has_no_gap() {
    let set = set(made());
    let pad = &set.objects[0].pads[0];
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for t in pad.sensing.iter().chain(&pad.outer_triangles()) {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let open = edges.iter().filter(|(_, count)| **count != 2).count();
    assert_eq!(open, 0, "of {} edges so many have not two triangles", edges.len());
}

#[test]
fn a_page_of_a_run_and_a_bench_has_their_tables_the_chart_and_the_truth() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let scene = "(object: (shape: Sphere(radius: 6e-3), motion: Fixed),
          gripper: (pads: Box(size: (0.016, 0.016, 0.0045), cells: (4, 4, 2)), opening: 0.02, friction: 0.0,
                    fingers: One, material: NeoHookean(young: 3e5, poisson: 0.45)),
          loading: Press(depths: [0.3e-3]))";
    std::fs::write(at("press.ron"), scene).unwrap();
    let (press, run, bench, page) = (at("press.ron"), at("run"), at("bench"), at("page.html"));
    good(&["run", text(&press), "-o", text(&run), "--no-pictures"]);
    // The bench of a press into the same pad.
    copy(&BENCH.0.path().join("out"), &bench);
    let markdown = good(&["report", text(&bench), text(&run), "-o", text(&page)]);
    let html = std::fs::read_to_string(&page).unwrap();
    let picture = |html: &str| {
        let (_, rest) = html.split_once("<img src=\"data:image/svg+xml;base64,").expect("the chart");
        String::from_utf8(base64(rest.split_once('"').unwrap().0)).unwrap()
    };
    assert!(
        html.contains("Speed against error") && picture(&html).contains("<svg") && picture(&html).contains("Pareto")
    );
    assert!(html.contains("quadratic 4x4x2") && html.contains("0 reached"));
    assert!(markdown.contains("| setting | nodes | s per grasp |") && markdown.contains("| quadratic 4x4x2 |"));
    let data = data_of(&html);
    let shown = &data["grasps"][0];
    assert_eq!(shown["states"].as_array().unwrap().len(), 1, "a run knows no second state");
    assert_eq!(shown["pads"].as_array().unwrap().len(), 1);
    let (u, _) = numbers(&shown["states"][0]["displacement"]);
    let deepest = u.as_chunks::<3>().0.iter().map(|v| v[2]).fold(0.0, f64::min);
    assert!((-4e-4..-2e-4).contains(&deepest), "a press of 0.3 mm goes as deep: {deepest} m");
    assert_eq!(html, {
        good(&["report", text(&bench), text(&run), "-o", text(&page)]);
        std::fs::read_to_string(&page).unwrap()
    });
    // An SVG file of the folder is embedded as an image, in which no script runs, and not as markup.
    let svg = std::fs::read_to_string(bench.join("bench.svg")).unwrap();
    let altered = svg.replace("<rect", "<script>alert(5)</script><image href=\"x\" onerror=\"alert(5)\"/><rect");
    assert_ne!(altered, svg);
    std::fs::write(bench.join("bench.svg"), &altered).unwrap();
    good(&["report", text(&bench), "-o", text(&page)]);
    let viewer = Viewer::start(bench, ReportOptions { model: None, split: None, grasps: 1, frames: 1 }, 0).unwrap();
    let host = viewer.address().trim_start_matches("http://").trim_end_matches('/').to_string();
    let mut connection = TcpStream::connect(&host).unwrap();
    write!(connection, "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    let mut viewed = String::new();
    connection.read_to_string(&mut viewed).unwrap();
    for html in [std::fs::read_to_string(&page).unwrap(), viewed] {
        assert_eq!(picture(&html), altered);
        assert!(!html.contains("alert(5)") && !html.contains("onerror"), "a script of the folder stands in the page");
    }
}

#[test]
fn a_run_of_an_own_mesh_is_whole_wherever_its_folder_goes() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    std::fs::create_dir(at("work")).unwrap();
    let corner = |k: usize, bit: usize| if k >> bit & 1 == 1 { "0.006" } else { "-0.006" };
    let vertices: String = (0..8).map(|k| format!("v {} {} {}\n", corner(k, 0), corner(k, 1), corner(k, 2))).collect();
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"].map(|f| format!("f {f}\n")).concat();
    std::fs::write(at("work/block.obj"), vertices + &faces).unwrap();
    let scene = "(object: (shape: Mesh(\"block.obj\"), motion: Fixed),
          gripper: (pads: Box(size: (0.016, 0.016, 0.0045), cells: (4, 4, 2)), opening: 0.02, friction: 0.0,
                    fingers: One, material: NeoHookean(young: 3e5, poisson: 0.45)),
          loading: Press(depths: [0.1e-3]))";
    std::fs::write(at("work/block.ron"), scene).unwrap();
    let (run, page) = (at("work/run"), at("page.html"));
    good(&["run", text(&at("work/block.ron")), "-o", text(&run), "--no-pictures"]);
    let moved = at("moved");
    std::fs::rename(&run, &moved).unwrap();
    std::fs::remove_dir_all(at("work")).unwrap();
    good(&["report", text(&moved), "-o", text(&page)]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(!html.contains("No grasp in 3-D"), "the run keeps the surface that it used");
    let data = data_of(&html);
    let object = &data["meshes"][data["grasps"][0]["object"].as_u64().unwrap() as usize];
    let (vertices, step) = numbers(&object["vertices"]);
    assert_eq!(vertices.len(), 3 * 8, "the corners of the block");
    assert!(vertices.iter().all(|x| (x.abs() - 0.006).abs() <= step.max(1e-9)), "{vertices:?}");
}

#[test]
fn what_holds_no_results_is_refused_by_name() {
    let made = made();
    let dir = tempfile::tempdir().unwrap();
    let refusal = |arguments: &[&str]| {
        let output = tactus(arguments);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    let empty = refusal(&["report", text(dir.path())]);
    assert!(empty.contains("contains no results") && empty.contains("run.json"), "{empty}");
    std::fs::write(dir.path().join("bench.json"), "{}").unwrap();
    let wrong = refusal(&["report", text(dir.path())]);
    assert!(wrong.contains("bench.json") && wrong.contains("not what `tactus bench` writes"), "{wrong}");
    let (data, model) = (made.tiny.out("data"), text(&made.model));
    let split = refusal(&["report", text(&data), "--model", model, "--split", "single:moon"]);
    assert!(split.contains("single:moon") && split.contains("ball, box"), "{split}");
    std::fs::write(dir.path().join("bench.json"), "").unwrap();
    let lonely = refusal(&["report", text(dir.path()), "--model", model]);
    assert!(lonely.contains("data set"), "{lonely}");
}

/// Path of a Chromium-based browser, which can print the DOM of a page after its script has run.
fn browser() -> Option<PathBuf> {
    let given = std::env::var_os("TACTUS_BROWSER").map(PathBuf::from);
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = || std::env::split_paths(&path).flat_map(|d| names.map(|n| d.join(n))).find(|p| p.is_file());
    given.or_else(found)
}

/// Result of the self-check of a page in a browser, and its DOM. Without a browser it reports a skipped test and
/// returns None.
pub fn checked(page: &Path) -> Option<(Value, String)> {
    let Some(browser) = browser() else {
        skipped("no chromium or chrome on the path (TACTUS_BROWSER names one)");
        return None;
    };
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(&browser)
        .args(["--headless", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader"])
        .args(["--enable-unsafe-swiftshader", "--virtual-time-budget=20000", "--window-size=900,700", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}#check", page.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout).into_owned();
    let body = dom.split_once("<body").map_or("", |(_, body)| body.split('>').next().unwrap_or(""));
    let attribute = |name: &str| {
        let value = body.split_once(&format!(" data-{name}=\"")).and_then(|(_, v)| v.split('"').next());
        value.map(|v| v.replace("&quot;", "\"").replace("&amp;", "&"))
    };
    assert_eq!(attribute("ready").as_deref(), Some("true"), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(attribute("errors"), None, "errors of the script");
    let found: Value = serde_json::from_str(&attribute("check").unwrap()).unwrap();
    println!("{found}");
    Some((found, dom))
}

#[test]
fn in_a_browser_the_pads_are_drawn_and_every_control_changes_the_picture() {
    let Some((found, dom)) = checked(&JUDGED) else { return };
    assert!(found["drawn"].as_f64().unwrap() > 0.05, "part of the picture that is not empty");
    assert_eq!(found["glError"], 0);
    assert_eq!(found["colors"], serde_json::json!([true]), "every grasp is drawn");
    assert_eq!(found["tip"], true, "a value under the pointer");
    let changes = found["changes"].as_object().unwrap();
    let controls = "frame turn zoom stress contact_force prediction difference all object mesh gain open";
    for control in controls.split(' ') {
        assert_eq!(changes.get(control), Some(&Value::Bool(true)), "{control} changes the picture");
    }
    assert_eq!(dom.matches("class=\"series").count(), 6, "lines: a chart by force and the course of the grasp");
    assert!(dom.contains("class=\"whisker\""), "bars by object");
}
