# A press beside other systems

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

# README has the systems on the mesh that all of them have.
readme_peers() {
    echo '| system | error of the depth at 2.548 N | ms a step | contact forces of nodes |'
    echo '|---|---|---|---|'
    sed -n 's/^| \([^|]*\), 6 x 8 x 2 cells |[^|]*| \([^|]*\) | \([^|]*\) |$/\1|\2|\3/p' |
        awk -F'|' '{ print "| " $1 " | " $2 " | " $3 " | " ($1 ~ /^tactus/ ? "yes" : "") " |" }'
}
