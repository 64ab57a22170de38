#!/usr/bin/env bash
# Everything a change must pass: format, lints, documentation, tests. Needs the Rust toolchain and a C compiler.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --check
cargo clippy --release --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps
cargo test --release --no-fail-fast
tests/python.sh
