# A press against a converged force

# A ball of radius 6 mm pressed 1 mm into a frictionless pad, E = 0.3 MPa, nu = 0.45: 2.548 N on converged meshes.
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
