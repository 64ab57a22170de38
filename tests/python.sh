#!/usr/bin/env bash
# Runs the Python tests against the wheel in the virtual environment target/python, and a test without the repository in
# target/bare. Prints the reason where they cannot run.
set -euo pipefail
cd "$(dirname "$0")/.."
skip() {
    echo "SKIPPED [1] python/tests: $1"
    exit 0
}
target=$PWD/target
environment=$target/python bare=$target/bare wheels=$target/wheels
install=(install -q --retries 1 --timeout 30)
command -v python3 > /dev/null || skip "there is no python3"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "python3 is older than 3.10"
[ -x "$environment/bin/pip" ] || python3 -m venv "$environment" > /dev/null || skip "python3 makes no environment"
"$environment/bin/pip" "${install[@]}" "maturin>=1.7,<2" "pytest>=9" pytest-timeout "numpy>=1.26" "gymnasium>=1.1" || skip "its packages cannot be fetched"
"$environment/bin/pip" "${install[@]}" mypy matplotlib trimesh meshio ||
    echo "the packages for types, pictures and meshes cannot be fetched"
"$environment/bin/pip" "${install[@]}" mujoco || echo "MuJoCo, for the kinematics of robots, cannot be fetched"
"$environment/bin/pip" install -q --retries 1 --timeout 30 playwright ||
    echo "Playwright, for the viewer in a browser, cannot be fetched"
cargo fetch -q --locked || skip "the crates of its bindings cannot be fetched"
rm -rf "$wheels" "$bare"
# Reuses the compiled crate and dependencies. One wheel (stable ABI) serves all CPython versions from 3.10.
VIRTUAL_ENV=$environment \
    "$environment/bin/maturin" build --release --quiet --strip --manifest-path python/Cargo.toml --out "$wheels" > /dev/null
wheel=$(echo "$wheels"/tactus-*-cp310-abi3-*.whl)
[ -f "$wheel" ] || { echo "no wheel for the stable ABI of CPython 3.10 in $wheels" && exit 1; }
"$environment/bin/pip" "${install[@]}" --force-reinstall --no-deps "$wheel"
# An environment with only the wheel and its requirements, used from an empty folder.
python3 -m venv "$bare"
"$bare/bin/pip" "${install[@]}" "$wheel"
empty=$(mktemp -d)
trap 'rm -rf "$empty"' EXIT
(cd "$empty" && "$bare/bin/python" -I - < "$target/../python/tests/without_repository.py")
cd "$environment" && bin/python -P -m pytest -q -rs -p no:cacheprovider ../../python/tests
