//! A PyTorch implementation (`tests/network/torch_check.py`) with the same weights agrees to a relative 1e-5.
//!
//! Requires a `python3`, or the interpreter named by TACTUS_PYTHON, with torch, safetensors and numpy; otherwise
//! reported as skipped.

use crate::gnn_made::{PAPER, SPEC, made};
use crate::skipped::skipped;
use std::process::Command;

#[test]
fn pytorch_gives_the_same_answers() {
    let python = std::env::var("TACTUS_PYTHON").unwrap_or_else(|_| "python3".into());
    let there = Command::new(&python).args(["-c", "import torch, safetensors, numpy"]).output();
    if !there.is_ok_and(|o| o.status.success()) {
        skipped("python3 has no torch, safetensors and numpy (TACTUS_PYTHON names another)");
        return;
    }
    let made = made();
    for (name, spec) in [("face", SPEC), ("paper", PAPER)] {
        let (file, model, dump) =
            (made.tiny.out(name), made.tiny.out(&format!("{name}_model")), made.tiny.out(&format!("{name}.npz")));
        std::fs::write(&file, spec).unwrap();
        let data = made.tiny.out("data");
        let run = |command: &mut Command| {
            let done = command.output().unwrap();
            let text = String::from_utf8_lossy(&done.stdout).into_owned();
            assert!(done.status.success(), "{name}: {text}{}", String::from_utf8_lossy(&done.stderr));
            text
        };
        let tactus = || Command::new(env!("CARGO_BIN_EXE_tactus"));
        run(tactus().arg("train").arg(&data).arg("--model").arg(&file).arg("-o").arg(&model));
        run(tactus().arg("eval").arg(&data).arg("--model").arg(&model).arg("--dump").arg(&dump));
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/network/torch_check.py");
        println!("{name}\n{}", run(Command::new(&python).arg(script).arg(&model).arg(&dump)));
    }
}
