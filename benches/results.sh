#!/usr/bin/env bash
# Measures the tables of docs/results.md, writes them there with command, commit, date and processor, and fills in the figures that
# README.md quotes.
#
#   benches/results.sh                  every table that was not measured at this commit yet; about an hour on two cores
#   benches/results.sh press squeeze    these tables alone, once more
#
# The tables `peers` and `inference` run other systems, `objects` compares arrays: PYTHON names a Python that has mujoco, drake, torch,
# safetensors, onnx, onnxscript, onnxruntime and numpy. What it has not is left out and said.
#
# Stopped at any moment it goes on with the next table. Nothing else should run beside it.
set -euo pipefail
cd "$(dirname "$0")/.."
readonly RESULTS=docs/results.md OUT=out/results TABLES=(press peers squeeze objects network slip size predictions stages inference growth environments data_set sensitivity hard_cases)
commit=$(git rev-parse --short HEAD)
git diff --quiet HEAD -- src Cargo.toml Cargo.lock || commit="$commit and uncommitted changes"
processor=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1 || true)
mechanics=$(git log -1 --format=%h -- src/mech src/backend/fem src/geometry src/grasp src/model scenes 'tests/network/*.ron')
made="Commit $commit, $(date +%F), ${processor:-processor unknown}, $(getconf _NPROCESSORS_ONLN) cores."
python=${PYTHON:-python3}
tactus() { ./target/release/tactus "$@"; }

# The text between the markers of table $1 in file $2 becomes stdin; a table that is not there yet goes to the end.
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

# Title $1 and command $2 of a table, then stdin.
page() {
    printf '## %s\n\n    %s\n' "$1" "$2"
    { echo; sed 's/   */ /g'; } | cat -s
    printf '\n%s\n' "$made"
}

# Processor time of a command, s.
processor_seconds() {
    local TIMEFORMAT='%U %S'
    { time "$@" > /dev/null 2>&1; } 2>&1 | awk '{ print $1 + $2 }'
}

# Force, N, and travel of the first finger, m, of each frame in the table $1.
force_and_travel() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) { if ($i ~ /^force_n/) force = i; if ($i ~ /^travel/ && !travel) travel = i } next }
        { print $force, $travel }' "$1"
}

# A ball of 6 mm radius pressed 1 mm into a pad of E = 0.3 MPa, nu = 0.45, without friction: 2.548 N on converged meshes.
press() {
    local scene seconds
    echo '| setting | nodes | force at 1 mm, N | error | s |'
    echo '|---|---|---|---|---|'
    for scene in linear quadratic_coarse quadratic_fine; do
        seconds=$(processor_seconds tactus run "scenes/press/$scene.ron" --threads 1 -o "$OUT/$scene" --overwrite --no-pictures)
        force_and_travel "$OUT/$scene/grasp_000/frames.csv" | awk -v scene="$scene" -v seconds="$seconds" \
            -v nodes="$(sed -n 's/.*"nodes": *\([0-9]*\).*/\1/p' "$OUT/$scene/run.json" | head -n 1)" '
            { gap = $2 - 1e-3; if (gap < 0) gap = -gap; if (gap < 1e-7) at = $1 }
            END { printf "| %s | %s | %.3f | %+.1f %% | %.1f |\n", scene, nodes, at, 100 * (at / 2.548 - 1), seconds }'
    done
}

# The ball pressed into one pad by a force that rises to 10 N, in 50 steps, one thread each; 1 mm at 2.548 N on converged meshes.
peers() {
    local cells solver scene turn spent peer root=$PWD
    echo '| system | depth at 2.548 N, mm | error | processor ms a step, best of three |'
    echo '|---|---|---|---|'
    for turn in 1 2 3; do
        for cells in "6, 8, 2" "8, 10, 2"; do
            for solver in full condensed; do
                scene=$OUT/peers_${cells//, /x}_$solver
                sed -e "s/cells: (6, 8, 2)/cells: ($cells)/" -e '/^ *expect: \[/,/^ *\],/d' scenes/press/ramp.ron > "$scene.ron"
                spent=$(processor_seconds tactus run "$scene.ron" $([ $solver = full ] || echo --backend condensed) --threads 1 -o "$scene" --overwrite)
                force_and_travel "$scene/grasp_000/frames.csv" | awk -v s="$spent" -v name="tactus, $solver pad, ${cells//, / x } cells" '
                    $1 >= 2.548 && !depth { depth = before + (2.548 - least) / ($1 - least) * ($2 - before) }
                    { before = $2; least = $1 }
                    END { printf "%s|%.4f|%.1f\n", name, 1e3 * depth, 1e3 * s / NR }'
            done
        done
        for peer in mujoco drake; do
            # They write logs where they run.
            [ -d ../shared/bench ] && (cd "$OUT" && OMP_NUM_THREADS=1 "$python" "$root/../shared/bench/${peer}_press.py" pad_1k 2> /dev/null) |
                sed -n 's/^\([a-z]*\) .*cpu\/step \([0-9.]*\) ms depth mm at [^ ]* N \([0-9.-]*\) .*/\1, linear pad, 6 x 8 x 2 cells|\3|\2/p'
        done || true
    done | sort -t'|' -k1,1 -k3,3g | awk -F'|' '!seen[$1]++ { printf "| %s | %.3f | %+.1f %% | %s |\n", $1, $2, 100 * ($2 - 1), $3 }'
    printf '\nFor tactus the time of the whole program, start and meshing included; for the others that of their step calls alone, with settings tuned by hand until they pressed at all.\n'
}

squeeze() {
    tactus bench scenes/lemon.ron --frames 10 --grasps 1 --repeat 1 --model universe -o "$OUT/squeeze" > /dev/null
    cp "$OUT/squeeze/bench.png" docs/network.png
    tactus report "$OUT/squeeze" -o "$OUT/squeeze.html" | sed '1d; /^'"${OUT//\//\\/}"'/d'
}

# Row $1: errors of the network on the split $3 of the data set $2 that the rest makes; it is made again only when mechanics or scenes change.
judged() {
    local what=$1 set=$OUT/$2_$mechanics split=$3
    shift 3
    # A grasp that does not reach its force is not a failure of the measurement.
    tactus dataset "$@" -o "$set" > /dev/null || [ $? -eq 1 ]
    tactus eval "$set" --split "$split" --extrapolate --model universe | tee "$set.txt" | awk -v what="$what" '
        NR == 1 { grasps = $1 }
        /^all +(displacement|stress|travel) / { error[$2] = sprintf("%.1f / %.1f", $3, $4); within[$2] = $7; interval[$2] = $9 }
        /^Kendall/ { tau = $8 + 0 }
        END { printf "| %s | %s | %s | %s | %s | %s / %s / %s | %.1f | %.2f |\n", what, grasps, error["displacement"], error["stress"],
            error["travel"], within["displacement"], within["stress"], within["travel"], interval["displacement"], tau }'
}

network() {
    echo '| grasps that it never saw | number | displacement, median / 90 %, % | stress | travel | within its interval, %: displacement / stress / travel | median interval, displacement, % | tau |'
    echo '|---|---|---|---|---|---|---|---|'
    judged "the objects of scenes/paper.ron, other poses" paper poses scenes/paper.ron --grasps 32 --frames 10
    judged "another seed of scenes/universe.ron" unseen all tests/network/unseen.ron
    judged "other pads: scenes/second_sensor.ron" sensor all scenes/second_sensor.ron --grasps 3
    judged "with weight: scenes/gravity.ron" gravity all scenes/gravity.ron --grasps 3
    judged "balls of 5 to 32 mm radius" balls all tests/network/balls.ron
    [ -d ../shared/data ] || return 0
    judged "GelSight Mini pads meshed by gmsh, outside the range" own_pads all tests/network/own_pads.ron
    judged "skin of a BioTac, outside the range" biotac all tests/network/biotac.ron
    judged "sixteen scanned objects" scans all tests/network/scans.ron
    printf '\nThe scanned objects with `error_at_most`:\n\n```text\n'
    grep '^error_at_most' "$OUT/scans_$mechanics.txt"
    echo '```'
}

# Frames that each grasp of tests/network/slip.ron holds: three of squeeze, then thirty of push.
slip() {
    local backend
    for backend in condensed "gnn --extrapolate"; do
        { tactus run tests/network/slip.ron --backend $backend 2> /dev/null || [ $? -eq 1 ]; } |
            awk '/^object/ { name = $2 } /^ +[0-9]+ +(dropped|reached|fault) / { print name, $1, $2, $3 - 3, $NF }' > "$OUT/slip_${backend%% *}.txt"
    done
    paste -d' ' "$OUT/slip_condensed.txt" "$OUT/slip_gnn.txt" | awk '
        { off = $4 > $9 ? $4 - $9 : $9 - $4; near += off <= 0.1 * ($4 + 1); count++; fem += $5; net += $10 }
        { rows = rows sprintf("| %s %s | %s, %d | %s, %d |\n", $1, $2, $3, $4, $8, $9) }
        END {
            print "| grasp | condensed finite elements: end, steps of the push held, of thirty | network |"
            print "|---|---|---|"
            printf "%s\n%d of %d grasps slip within a tenth of the load of finite elements; %.1f s a grasp against %.3f s.\n", rows, near, count, fem / count, net / count
        }'
}

size() {
    tactus bench scenes/press/quadratic_coarse.ron --sizes 500,1000,2000,5000,10000 --threads 1 --repeat 1 -o "$OUT/size" > /dev/null
    tactus report "$OUT/size" -o "$OUT/size.html" | sed '1d; /^'"${OUT//\//\\/}"'/d'
}

# The first grasp of each object of scenes/paper.ron to 15 N in 50 frames, on the pads that are recorded.
objects() {
    local object solver whole condensed column command
    sed 's/, mesh: (finer: [^)]*)//' scenes/paper.ron > "$OUT/objects.ron"
    echo '| object | whole pads, s | condensed, s | differ in displacement at 15 N, % |'
    echo '|---|---|---|---|'
    for object in $(sed -n 's/.*(name: "\([^"]*\)".*/\1/p' scenes/paper.ron); do
        for solver in fem condensed; do
            command=(tactus run "$OUT/objects.ron" --object "$object" --grasp 0 --backend $solver --threads 2 --no-pictures -o "$OUT/objects_$solver" --overwrite)
            if [ $solver = fem ]; then whole=$(seconds "${command[@]}"); else condensed=$(seconds "${command[@]}"); fi
        done
        echo "$object $whole $condensed $("$python" -c '
import sys, numpy
whole, condensed = (numpy.load(f"{folder}/grasp_000/arrays.npz")["displacement_m"][-1] for folder in sys.argv[1:])
print(100 * numpy.linalg.norm(condensed - whole) / numpy.linalg.norm(whole))' "$OUT/objects_fem" "$OUT/objects_condensed" 2> /dev/null || echo nan)"
    done | tee "$OUT/objects.txt" | awk '{ printf "| %s | %.2f | %.2f | %s |\n", $1, $2, $3, $4 == "nan" ? "not reached" : sprintf("%.1f", $4) }'
    for column in 2 3; do cut -d' ' -f$column "$OUT/objects.txt" | sort -g | awk '{ s[NR] = $1 } END { print (s[NR / 2] + s[NR / 2 + 1]) / 2 }'; done |
        awk '{ printf "%s%.2f s", NR == 1 ? "\nMedians: whole " : ", condensed ", $1 } END { print ", start, meshing and recording included." }'
}

# Message passing and all 50 loads of a grasp by the engine, PyTorch and ONNX Runtime: the same weights, graphs of the same size.
inference() {
    local set=$OUT/inference_$commit
    tactus dataset scenes/lemon.ron --grasps 1 --frames 50 -o "$set" > /dev/null || [ $? -eq 1 ]
    tactus eval "$set" --split all --extrapolate --model universe --dump "$set.npz" > /dev/null
    echo '```text'
    TACTUS_MODEL=models/universe cargo bench -q --bench inference | sed -n 1,3p
    "$python" benches/torch_inference.py models/universe "$set.npz"
    echo '```'
}

# Grasps a second of `tactus predict` on lemons, with the options that follow.
a_second() { tactus predict tests/network/lemons.ron "$@" 2> /dev/null | sed -n 's/.* on [0-9]* threads, \([0-9]*\) a second.*/\1/p'; }

predictions() {
    local frames
    echo '| loads of a grasp | grasps a second on one thread | on two |'
    echo '|---|---|---|'
    for frames in 1 12 50; do
        echo "| $frames | $(a_second --frames "$frames" --grasps 100 --threads 1) | $(a_second --frames "$frames" --threads 2) |"
    done
    printf '\nFour hundred grasps of a lemon on pads of 1,785 nodes; their error is that of the rows of the network under "Error of the network".\n'
}

stages() { cargo bench -q --bench prediction; }

# Wall time of a command, s; a promise of a scene that is not kept is not a failure of the measurement.
seconds() {
    local TIMEFORMAT=%R
    { time "$@" > /dev/null 2>&1; } 2>&1 || [ $? -eq 1 ]
}

# Row $1: the time of the rest with its last number $2, and with $3 in place of it.
grows() {
    local what=$1 small=$2 large=$3
    shift 3
    echo "$what|$small|$large|$(seconds "$@" "$small")|$(seconds "$@" "$large")" |
        awk -F'|' '{ printf "| %s | %d | %d | %.2f | %.2f | %.2f |\n", $1, $2, $3, $4, $5, log($5 / $4) / log($3 / $2) }'
}

# How times grow: exponents of the number that is varied.
growth() {
    local lemons=tests/network/lemons.ron
    echo '| number of | from | to | s | s | exponent |'
    echo '|---|---|---|---|---|---|'
    grows "loads of a grasp, all decoded" 3 12 tactus predict $lemons --grasps 200 --frames
    grows "frames of a grasp, some decoded" 12 50 tactus predict $lemons --grasps 200 --frames
    grows "grasps" 100 400 tactus predict $lemons --grasps
    grows "threads, predictions" 1 2 tactus predict $lemons --threads
    grows "threads, grasps by finite elements" 1 2 tactus run scenes/lemon.ron --backend condensed --frames 50 --threads
    grows "frames by finite elements" 10 40 tactus run scenes/lemon.ron --backend condensed --threads 1 --frames
    printf '\n'
    tactus bench scenes/press/quadratic_coarse.ron --sizes 1000,4000 --threads 1 --repeat 1 -o "$OUT/growth" > /dev/null
    tactus report "$OUT/growth" -o "$OUT/growth.html" | awk -F'|' '/^\| [0-9]/ { nodes[++n] = $3; s[n] = $7; mb[n] = $9 }
        END {
            by = log(nodes[2] / nodes[1])
            printf "Nodes of a pad, from %d to %d: a frame of a press takes time with the exponent %.2f, memory with %.2f.\n",
                nodes[1], nodes[2], log(s[2] / s[1]) / by, log(mb[2] / mb[1]) / by
        }'
}

# Beside finite elements the network of the tasks, made as docs/rl.md says; its picture goes to docs.
environments() {
    local model=out/tasks_model
    if [ ! -d $model ]; then
        tactus dataset scenes/tasks/data.ron -o out/tasks > /dev/null || [ $? -eq 1 ]
        tactus train out/tasks --model models/small.ron -o $model > /dev/null
    fi
    echo '```text'
    tactus bench scenes/tasks/hold.ron --envs 1,4,16,64,256,1024 --model $model --repeat 1 -o "$OUT/environments"
    echo '```'
    cp "$OUT/environments/envs.png" docs/envs.png
}

# Some grasps of each object of scenes/paper.ron on all cores; the whole data set has a hundred.
data_set() {
    local grasps=4 spent
    rm -rf "$OUT/data_set"
    spent=$(seconds tactus dataset scenes/paper.ron --grasps $grasps -o "$OUT/data_set")
    awk -v s="$spent" -v n=$grasps 'BEGIN { printf "%d grasps of each of ten objects, 50 frames, fifteen newtons: %.0f s. At this rate the data set of a hundred takes %.0f minutes.\n", n, s, s * 100 / n / 60 }'
}

sensitivity() {
    echo '```text'
    # A grasp that does not reach its force is a row of the table, not a failure of the measurement.
    { tactus dataset scenes/paper.ron --grasps 2 --frames 10 --sensitivity 2 -o "$OUT/sensitivity_$commit" || [ $? -eq 1 ]; } | tail -n 4
    echo '```'
}

# Every scene of scenes/torture and scenes/dynamic with the methods that it took.
hard_cases() {
    local scene name
    echo '| scene | outcome | iterations | methods |'
    echo '|---|---|---|---|'
    for scene in scenes/torture/*.ron scenes/dynamic/*.ron; do
        name=$(basename "$scene" .ron)
        tactus run "$scene" > "$OUT/$name.txt" 2> /dev/null || true
        awk -v name="$name" '
            /^ +0 / { outcome = $2 }
            / Newton iterations: / { iterations = $4 }
            / increments?(,|$)/ { methods = $0 }
            END { printf "| %s | %s | %s | %s |\n", name, outcome ? outcome : "refused", iterations, methods }' "$OUT/$name.txt"
    done
}

title() {
    case $1 in
        press) echo "A press against a converged force" ;;
        peers) echo "A press beside other systems" ;;
        objects) echo "Ten objects, whole pads and condensed ones" ;;
        inference) echo "A pass of the network beside PyTorch and ONNX Runtime" ;;
        squeeze) echo "Speed against error: a lemon that the network never saw" ;;
        network) echo "Error of the network that ships, against a mesh 1.4 times as fine" ;;
        slip) echo "Load at which the object slips" ;;
        size) echo "Cost against the size of the pad" ;;
        predictions) echo "Grasps a second by the network" ;;
        stages) echo "A prediction by stage, beside the least time of its arithmetic" ;;
        growth) echo "How times grow" ;;
        environments) echo "Environments" ;;
        data_set) echo "Time of a data set" ;;
        sensitivity) echo "How well posed squeezes are" ;;
        hard_cases) echo "Hard cases and the methods they take" ;;
    esac
}

# README quotes three columns of the squeeze, for the settings that a reader chooses between.
readme() {
    awk -F'|' '
        /^\| setting/ { print "| setting | s a grasp | displacement, median / 90 % / worst, % |"; print "|---|---|---|" }
        /^\| (network|condensed (2.60|1.84) mm|quadratic (2.60|1.84) mm)/ { printf "|%s|%s|%s|\n", $2, $4, $6 }' |
        { cat; printf '\n%s\n' "$made"; } | put squeeze README.md
}

cargo build --release
mkdir -p "$OUT"
[ -f "$RESULTS" ] || printf '# Results\n\nTables that `benches/results.sh` measures; no figure here is typed by hand.\n' > "$RESULTS"
wanted=("$@")
for table in "${wanted[@]:-${TABLES[@]}}"; do
    [[ " ${TABLES[*]} " == *" $table "* ]] || { echo "there is no table $table; allowed: ${TABLES[*]}" >&2; exit 2; }
    if [ $# -eq 0 ] && grep -q "^<!-- table $table at $commit -->" "$RESULTS"; then continue; fi
    echo "measuring $table" >&2
    "$table" > "$OUT/$table.md"
    page "$(title "$table")" "benches/results.sh $table" < "$OUT/$table.md" | put "$table" "$RESULTS"
    if [ "$table" = squeeze ]; then readme < "$OUT/$table.md"; fi
done
