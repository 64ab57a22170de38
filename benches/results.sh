#!/usr/bin/env bash
# Measures the tables of docs/results.md, writes them there with command, commit, date and processor, and updates the
# tables in README.md.
#
#   benches/results.sh                  all tables not yet measured at this commit; hours on two cores, most for `rules`
#   benches/results.sh press squeeze    only these tables, even if measured already
#
# The tables `peers` and `inference` run other systems and `objects` compares arrays: PYTHON names a Python interpreter
# with mujoco, drake, torch, safetensors, onnx, onnxscript, onnxruntime and numpy. Missing packages are skipped.
#
# After an interruption it resumes with the next table. No other load should run on the machine.
set -euo pipefail
cd "$(dirname "$0")/.."
readonly RESULTS=docs/results.md OUT=out/results TABLES=(press peers squeeze objects scans network autodiff slip size predictions stages inference growth environments data_set sensitivity hard_cases rules)
commit=$(git rev-parse --short HEAD)
git diff --quiet HEAD -- src Cargo.toml Cargo.lock || commit="$commit and uncommitted changes"
processor=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1 || true)
mechanics=$(git log -1 --format=%h -- src/mech src/backend/fem src/geometry src/model scenes 'tests/network/*.ron')
made="Commit $commit, $(date +%F), ${processor:-processor unknown}, $(getconf _NPROCESSORS_ONLN) cores."
python=${PYTHON:-python3}
tactus() { ./target/release/tactus "$@"; }

# Replaces the text between the markers of table $1 in file $2 by stdin; a new table is appended.
put() {
    local name=$1 file=$2 fresh
    fresh=$(mktemp)
    cat > "$fresh"
    grep -q "^<!-- table $name " "$file" || printf '\n<!-- table %s -->\n<!-- end -->\n' "$name" >> "$file"
    awk -v name="$name" -v fresh="$fresh" -v commit="$commit" '
        $0 ~ "^<!-- table " name " " { print "<!-- table " name " at " commit " -->"; while ((getline line < fresh) > 0) print line; skip = 1; next }
        $0 == "<!-- end -->" { skip = 0 }
        !skip { print }' "$file" > "$file.part"
    mv "$file.part" "$file"
    rm "$fresh"
}

# Prints the title $1 and the command $2 of a table, then stdin.
page() {
    printf '## %s\n\n    %s\n' "$1" "$2"
    { echo; sed 's/   */ /g'; } | cat -s
    printf '\n%s\n' "$made"
}

# Prints the processor time of a command, s.
processor_seconds() {
    local TIMEFORMAT='%U %S'
    { time "$@" > /dev/null 2>&1; } 2>&1 | awk '{ print $1 + $2 }'
}

# Prints the force, N, and the travel of the first finger, m, of each frame in the table $1.
force_and_travel() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) { if ($i ~ /^force_n/) force = i; if ($i ~ /^travel/ && !travel) travel = i } next }
        { print $force, $travel }' "$1"
}

# Prints the wall time of a command, s; exit status 1, a violated expectation of a scene, is accepted.
seconds() {
    local TIMEFORMAT=%R
    { time "$@" > /dev/null 2>&1; } 2>&1 || [ $? -eq 1 ]
}

for table in "${TABLES[@]}"; do source "benches/tables/$table.sh"; done
cargo build --release
mkdir -p "$OUT"
[ -f "$RESULTS" ] || printf '# Results\n\nTables that `benches/results.sh` measures; no figure here is typed by hand.\n' > "$RESULTS"
wanted=("$@")
for table in "${wanted[@]:-${TABLES[@]}}"; do
    [[ " ${TABLES[*]} " == *" $table "* ]] || { echo "there is no table $table; allowed: ${TABLES[*]}" >&2; exit 2; }
    if [ $# -eq 0 ] && grep -q "^<!-- table $table at $commit -->" "$RESULTS"; then continue; fi
    echo "measuring $table" >&2
    "$table" > "$OUT/$table.md"
    page "$(sed -n '1s/^# //p' "benches/tables/$table.sh")" "benches/results.sh $table" < "$OUT/$table.md" | put "$table" "$RESULTS"
    if declare -F "readme_$table" > /dev/null; then { "readme_$table" < "$OUT/$table.md"; printf '\n%s\n' "$made"; } | put "$table" README.md; fi
done
