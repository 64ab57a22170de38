# A press beside other systems

# A ball pressed into one pad by a force that rises to 10 N in 50 steps, on one thread. On converged meshes the depth is
# 1 mm at 2.548 N.
peers() {
    local pad elements cells solver scene nodes spent peer root=$PWD
    echo '| system | elements | nodes | depth at 2.548 N, mm | error | processor ms a step, best of three |'
    echo '|---|---|---|---|---|---|'
    for _ in 1 2 3; do
        for pad in "Quadratic (6, 8, 2)" "Quadratic (8, 10, 2)" "Linear (12, 16, 4)"; do
            elements=${pad%% *} cells=${pad#* }
            for solver in full condensed; do
                scene=$OUT/peers_${elements}_${cells//[^0-9]/_}_$solver
                sed -e "s/cells: (6, 8, 2)/cells: $cells/" -e "s/record: (/stepper: Fem(element: $elements), &/" -e '/^ *expect: \[/,/^ *\],/d' scenes/press/ramp.ron > "$scene.ron"
                spent=$(processor_seconds tactus run "$scene.ron" $([ $solver = full ] || echo --backend condensed) --threads 1 -o "$scene" --overwrite)
                nodes=$(sed -n 's/.*"nodes": *\([0-9]*\).*/\1/p' "$scene/run.json" | head -n 1)
                force_and_travel "$scene/grasp_000/frames.csv" | awk -v s="$spent" -v name="tactus, $solver pad|${elements,}|$nodes" '
                    $1 >= 2.548 && !depth { depth = before + (2.548 - least) / ($1 - least) * ($2 - before) }
                    { before = $2; least = $1 }
                    END { printf "%s|%.4f|%.1f\n", name, 1e3 * depth, 1e3 * s / NR }'
            done
        done
        for peer in mujoco drake; do
            # These programs write logs to the working directory. Their mesh is that of the linear pad.
            [ -d ../shared/bench ] && (cd "$OUT" && OMP_NUM_THREADS=1 "$python" "$root/../shared/bench/${peer}_press.py" pad_1k 2> /dev/null) |
                sed -n 's/^\([a-z]*\) .*cpu\/step \([0-9.]*\) ms depth mm at [^ ]* N \([0-9.-]*\) .*/\1|linear|1105|\3|\2/p'
        done || true
    done | sort -t'|' -k1,3 -k5,5g | awk -F'|' '!seen[$1, $2, $3]++ { printf "| %s | %s | %s | %.3f | %+.1f %% | %s |\n", $1, $2, $3, $4, 100 * ($4 - 1), $5 }'
    printf '\nFor tactus the time of the whole program, start and meshing included; for the others that of their step calls alone, with settings tuned by hand until they pressed at all.\n'
}

# Rows for the README: the systems with pads of the same number of nodes.
readme_peers() {
    echo '| system | elements | error of the depth at 2.548 N | ms a step | contact forces of nodes |'
    echo '|---|---|---|---|---|'
    awk -F' *[|] *' '$4 == 1105 { printf "| %s | %s | %s | %s | %s |\n", $2, $3, $6, $7, $2 ~ /^tactus/ ? "yes" : "" }'
}
