#!/usr/bin/env bash
# Checks that every change must pass: format, lints, documentation, tests. Needs the Rust toolchain and a C compiler.
#
#   tests/all.sh              without the tests marked as thorough: campaigns, walks of all scenes, certified meshes
#   tests/all.sh --thorough   with them
#
# The last lines list what was skipped, with the reason, and count the tests.
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in
    '') which=() ;;
    --thorough) which=(-- --include-ignored) ;;
    *) echo "tests/all.sh: $1: allowed is --thorough" >&2 && exit 2 ;;
esac
cargo fmt --check
cargo clippy --release --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps
printed=$(mktemp) status=0
trap 'rm -f "$printed"' EXIT
cargo test --release --no-fail-fast "${which[@]}" 2>&1 | tee -a "$printed" || status=1
tests/python.sh 2>&1 | tee -a "$printed" || status=1
awk -f tests/summary.awk "$printed"
exit $status
