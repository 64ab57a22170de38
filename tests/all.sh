#!/usr/bin/env bash
# Checks that every change must pass: format, lints, documentation, tests. Needs the Rust toolchain and a C compiler.
# The last lines list what was skipped, with the reason, and count the tests.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --check
cargo clippy --release --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps
printed=$(mktemp) status=0
trap 'rm -f "$printed"' EXIT
for tests in "cargo test --release --no-fail-fast" tests/python.sh; do
    $tests 2>&1 | tee -a "$printed" || status=1
done
awk -f tests/summary.awk "$printed"
exit $status
