# Sensitivity to each constant of the solver

# Scenes of scenes/torture that end within seconds, and four grasps of each of four scans that rotate and slide; a case
# that takes longer than LIMIT seconds counts as lost. Takes some hours on two cores; after an interruption it resumes.
rules() {
    local data=${DATA:-../shared/data/objects} file name cases=(scenes/torture/*.ron scenes/lemon.ron scenes/push.ron)
    for name in sphere01 cylinder02 lemon01 rectangle; do
        for file in "$data"/*/$name/*_grasps.h5; do
            [ -f "$file" ] || continue
            scan_scene "$file" > "$OUT/rule_$name.ron"
            cases+=("$OUT/rule_$name.ron##"{0..3})
        done
    done
    LIMIT=${LIMIT:-20} "$python" benches/rules.py "$OUT/rules" "${cases[@]}"
}
