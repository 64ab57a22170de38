#!/usr/bin/env bash
# The Python tests, in an environment of their own in target/python; says why where they cannot run.
set -euo pipefail
cd "$(dirname "$0")/.."
skip() {
    echo "skipped: Python tests ($1)"
    exit 0
}
environment=$PWD/target/python
command -v python3 > /dev/null || skip "there is no python3"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "python3 is older than 3.10"
[ -x "$environment/bin/pip" ] || python3 -m venv "$environment" > /dev/null || skip "python3 makes no environment"
"$environment/bin/pip" install -q --retries 1 --timeout 30 "maturin>=1.7,<2" pytest "numpy>=1.26" "gymnasium>=1.1" ||
    skip "its packages cannot be fetched"
"$environment/bin/pip" install -q --retries 1 --timeout 30 mypy matplotlib trimesh meshio ||
    echo "skipped: Python tests of types, pictures and meshes (their packages cannot be fetched)"
"$environment/bin/pip" install -q --retries 1 --timeout 30 playwright ||
    echo "skipped: Python tests of the viewer in a browser (Playwright cannot be fetched)"
cargo fetch -q --locked --manifest-path python/Cargo.toml || skip "the crates of its bindings cannot be fetched"
# Shares the dependencies that are built already.
export CARGO_TARGET_DIR=$PWD/target VIRTUAL_ENV=$environment
"$environment/bin/maturin" develop --release --quiet --manifest-path python/Cargo.toml > /dev/null
cd "$environment" && bin/python -P -m pytest -q -p no:cacheprovider ../../python/tests
