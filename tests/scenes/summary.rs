//! The last lines of `tests/all.sh`: reasons for skipping, and numbers of tests.

use std::io::Write;
use std::process::{Command, Stdio};

const PRINTED: &str = "\
test mesh_files::real_surface_files_are_solids ... ok
skipped: mesh_files::real_surface_files_are_solids: ../shared/data is not here
skipped: mesh_files::real_surface_files_are_solids: ../shared/data is not here
test pad_place::real_pads ... skipped: pad_place::real_pads: ../shared/data is not here
ok
skipped: record_vtu::python_readers_agree: python3 has no meshio
skipped: record_vtu::python_readers_agree: python3 has no vtkmodules
test result: ok. 20 passed; 0 failed; 0 ignored; 0 measured; 3 filtered out; finished in 0.50s
test result: FAILED. 5 passed; 1 failed; 2 ignored; 0 measured; 0 filtered out; finished in 12.34s
SKIPPED [3] ../../python/tests/test_torch.py:10: PyTorch is not installed
SKIPPED [1] ../../python/tests/test_viewer.py:18: no Chromium: none on the path
2 failed, 30 passed, 4 skipped, 1 error in 33.04s
";

/// A test that skips a part of itself counts once as skipped and not as passed; the count of a reason is the number of
/// tests that give it.
#[test]
fn the_last_lines_count_what_was_skipped_and_why() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/summary.awk");
    let mut awk =
        Command::new("awk").args(["-f", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    awk.stdin.take().unwrap().write_all(PRINTED.as_bytes()).unwrap();
    let said = String::from_utf8(awk.wait_with_output().unwrap().stdout).unwrap();
    assert_eq!(
        said,
        "skipped: ../shared/data is not here (2)\n\
         skipped: python3 has no meshio (1)\n\
         skipped: python3 has no vtkmodules (1)\n\
         skipped: thorough tests, which `tests/all.sh --thorough` runs (2)\n\
         skipped: PyTorch is not installed (3)\n\
         skipped: no Chromium: none on the path (1)\n\
         52 passed, 4 failed, 9 skipped\n"
    );
}
