# Time of a data set

# Generates four grasps of each object of scenes/paper.ron on all cores; the full data set has a hundred.
data_set() {
    local grasps=4 spent
    rm -rf "$OUT/data_set"
    spent=$(seconds tactus dataset scenes/paper.ron --grasps $grasps -o "$OUT/data_set")
    awk -v s="$spent" -v n=$grasps 'BEGIN { printf "%d grasps of each of ten objects, 50 frames, fifteen newtons: %.0f s. At this rate the data set of a hundred takes %.0f minutes.\n", n, s, s * 100 / n / 60 }'
}
