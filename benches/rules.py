"""Sensitivity of hard cases to each constant of the solver: doubled, halved and disabled.

    python3 benches/rules.py OUT [SCENE[#[OBJECT][#GRASP]] ...]

copies the sources to OUT/tree, where the environment variable RULE replaces a constant, builds them once, and runs the
scenes with each constant changed. Rows are stored in OUT/rows.json, so that an interrupted run resumes. The table is
printed to stdout. A case is lost if its outcome differs from that without a change, or if it takes longer than LIMIT
seconds (60). RULES is a regular expression that selects constants by name.
"""

import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

FOLDERS = ["src/mech/newton", "src/mech/path", "src/mech/contact", "src/backend/fem"]
SCALES = "src/base/scales.rs"
# Scales used by the solver; the others determine the samples of the object.
OF_SOLVER = """NEGLIGIBLE_FRICTION DISPLACEMENT_TOLERANCE COMPLETE_HESSIAN_MOTION LARGEST_MOTION FIRST_PSEUDO_STEP
LARGEST_PSEUDO_STEP LOST_CONTACT_MOTION DROP_DISTANCE LARGEST_PREDICTED_MOTION FIRST_PATCH_PENETRATION PATCH_MARGIN
SMALL_PATCH_MARGIN VERTEX_MOVE_PENETRATION SUB_FACE_PENETRATION EXACT_GAP_RADIUS POINT_LIST_RADIUS FACE_HYSTERESIS
DISTANCE_UPDATE_MOTION VERTEX_LIST_RADIUS LARGEST_PENETRATION""".split()
# Constants determined by geometry and rounding, which are not varied.
FACTS = """QUADRATIC_MOTION_RATIO QUADRATIC_BULGE_RATIO DISTANCE_ROUNDING NO_EDGE EDGE_STARTS ARC_LENGTH_RATIO ROUNDING
START_INCREMENTS INCREMENTS_PER_STEP SMALLEST_COORDINATE_CHANGE""".split()
# Value that disables a rule.
OFF = {
    "step_size.HARD_INCREMENT_ITERATIONS": "1000000", "lagging.STALLED_ITERATIONS": "1000000",
    "solve.RIGID_STEP_FRACTION": "1e9", "solve.RESIDUAL_DECREASE": "-1e9", "solve.FULL_STEP_FRACTION": "0",
    "direction.KRYLOV_VECTORS": "0", "continuation.FORCE_GROWTH": "1e9", "path_error.SHORTEST_RATED_INCREMENT": "0;0",
    "pseudo_time.LOOSE_TOLERANCE_FACTOR": "1", "pseudo_time.STIFFNESS_BOUND_RATIO": "0",
    "pseudo_time.LOAD_HOLD_FORCE_RATIO": "1e9", "law.STIFFER_BRANCH_RATIO": "1", "law.SMALLEST_GAP": "-1e9",
    "law.REDUCED_OFFSET": "1", "solver.CONDENSED_TOLERANCE": "0", "scales.COMPLETE_HESSIAN_MOTION": "0",
    "scales.SUB_FACE_PENETRATION": "1e9", "scales.FACE_HYSTERESIS": "0",
}
PROGRAM = "tactus-rules"
KIND = r"f64|u32|u64|usize|\[f64; ?\d+\]"
CONSTANT = re.compile(rf"^(?:pub(?:\([a-z]+\))? )?const ([A-Z_0-9]+): ({KIND}) = (.*);$", re.M)
LOOKUP = """
/// A constant that the environment may replace.
pub trait Rule: Copy { fn parse(text: &str) -> Self; }
impl Rule for f64 { fn parse(text: &str) -> Self { text.parse().unwrap() } }
impl Rule for u32 { fn parse(text: &str) -> Self { text.parse().unwrap() } }
impl Rule for u64 { fn parse(text: &str) -> Self { text.parse().unwrap() } }
impl Rule for usize { fn parse(text: &str) -> Self { text.parse().unwrap() } }
impl<const N: usize> Rule for [f64; N] {
    fn parse(text: &str) -> Self { let mut all = text.split(';'); std::array::from_fn(|_| all.next().unwrap().parse().unwrap()) }
}
pub fn of<T: Rule>(name: &str, usual: T) -> T {
    static CHANGED: std::sync::LazyLock<Option<(String, String)>> =
        std::sync::LazyLock::new(|| std::env::var("RULE").ok()?.split_once('=').map(|(a, b)| (a.into(), b.into())));
    match &*CHANGED { Some((rule, value)) if rule == name => T::parse(value), _ => usual }
}
"""


def files(root):
    for folder in FOLDERS:
        yield from sorted((root / folder).rglob("*.rs"))
    yield root / SCALES


def room(path):
    """Prefix of a rule's name: the name of its file or module."""
    return path.parent.name if path.stem == "mod" else path.stem


def rules(root):
    """Type and value of each constant, by name."""
    found = {}
    for path in files(root):
        for name, kind, value in CONSTANT.findall(path.read_text()):
            if name not in FACTS and (path.name != "scales.rs" or name in OF_SOLVER):
                found[f"{room(path)}.{name}"] = (kind, value)
    # Otherwise a renamed constant would silently not be varied.
    if unknown := {f"scales.{name}" for name in OF_SOLVER}.union(OFF) - found.keys():
        sys.exit(f"benches/rules.py names constants that the sources lack: {', '.join(sorted(unknown))}")
    return found


def changed(kind, value, factor):
    numbers = [eval(part) for part in value.strip("[]").split(",")]
    change = lambda number: number * factor if "f64" in kind else max(1, int(number * factor))
    return ";".join(str(change(number)) for number in numbers)


def rewrite(root):
    """Replaces each use of a constant by a lookup."""
    owners = {}
    for rule in rules(root):
        owners.setdefault(rule.split(".")[1], []).append(rule)
    for path in files(root):
        text = path.read_text()
        own = {name: f"{room(path)}.{name}" for name, *_ in CONSTANT.findall(text)}
        imported = set(re.findall(r"[A-Z][A-Z_0-9]+", "".join(re.findall(r"^use [^;]*;", text, re.M))))
        crate = "crate" if path == root / SCALES else "base"
        body, *tests = text.split("#[cfg(test)]")
        lines = []
        for line in body.splitlines(True):
            if not re.match(r"\s*(//|use |pub use |(pub(\([a-z]+\))? )?const )", line):
                for name in owners:
                    rule = own.get(name) or (owners[name][0] if name in imported else None)
                    if rule in owners[name]:
                        line = re.sub(rf"(?<![\w:.`\[{{]){name}\b", f'{crate}::rules::of("{rule}", {name})', line)
            lines.append(line)
        path.write_text("#[cfg(test)]".join(["".join(lines), *tests]))
    lib = root / "src/base/lib.rs"
    lib.write_text(lib.read_text() + "\n#[doc(hidden)]\npub mod rules {" + LOOKUP + "}\n")


def build(out):
    """Builds the rewritten sources and returns the path of the program."""
    tree = out / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    for name in subprocess.run(["git", "ls-files"], capture_output=True, text=True, check=True).stdout.split():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(name, tree / name)
    rewrite(tree)
    manifest = re.sub("^default-run.*\n", "", (tree / "Cargo.toml").read_text(), flags=re.M)
    (tree / "Cargo.toml").write_text(f'{manifest}\n[[bin]]\nname = "{PROGRAM}"\npath = "src/main.rs"\n')
    # The usual target folder, so that compiled dependencies are reused.
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target")).resolve()
    own = dict(os.environ, CARGO_TARGET_DIR=str(target))
    subprocess.run(["cargo", "build", "--release", "--bin", PROGRAM], cwd=tree, env=own, check=True)
    return target / "release" / PROGRAM


def run(program, case, rule):
    """Runs one case with `rule` and returns its outcome and number of iterations."""
    scene, *which = case.split("#")
    flags = [part for pair in zip(("--object", "--grasp"), which) if pair[1] for part in pair]
    command = [program, "run", scene, *flags, "-q", "--no-pictures", "--threads", "1", "--max-time", os.environ.get("LIMIT", "60"), "--format", "json"]
    done = subprocess.run(command, env=dict(os.environ, RULE=rule), capture_output=True, text=True)
    try:
        grasps = json.loads(done.stdout)["grasps"]
        return [done.returncode, [g["status"] for g in grasps]], sum(g["newton_iterations"] for g in grasps)
    except (ValueError, KeyError):
        return [done.returncode, [done.stderr[-200:]]], 0


def main():
    out, cases = pathlib.Path(sys.argv[1]), sys.argv[2:]
    out.mkdir(parents=True, exist_ok=True)
    sources = hashlib.sha256(b"".join(path.read_bytes() for path in files(pathlib.Path(".")))).hexdigest()[:12]
    program = out / f"{PROGRAM}-{sources}"
    program.exists() or shutil.copy(build(out), program)
    rows = json.loads((out / "rows.json").read_text()) if (out / "rows.json").exists() else {}

    def row(rule):
        key = json.dumps([sources, rule, cases])
        if key not in rows:
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                rows[key] = list(pool.map(lambda case: run(program, case, rule), cases))
            part = out / "rows.json.part"
            part.write_text(json.dumps(rows))
            part.replace(out / "rows.json")
        return rows[key]

    usual = row("")
    whole = sum(iterations for _, iterations in usual)
    print(f"{len(cases)} cases, {whole} iterations as it is.\n")
    print("| constant | value | doubled: lost, iterations | halved | off |\n|---|---|---|---|---|")
    only = re.compile(os.environ.get("RULES", ""))
    for name, (kind, value) in rules(pathlib.Path(".")).items():
        if not only.search(name):
            continue
        cells = []
        for to in [changed(kind, value, 2), changed(kind, value, 0.5), OFF.get(name)]:
            if to is None:
                cells.append("")
                continue
            now = row(f"{name}={to}")
            lost = sum(a[0] != b[0] for a, b in zip(now, usual))
            # Iterations of the cases with the same outcome.
            both = [(a[1], b[1]) for a, b in zip(now, usual) if a[0] == b[0]]
            change = sum(a for a, _ in both) / max(sum(b for _, b in both), 1) - 1
            cells.append(f"{lost}, {change:+.0%}" if lost or change else "same")
        print(f"| {name} | {value} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
