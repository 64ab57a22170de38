# Ten objects, whole pads and condensed ones

# The first grasp of each object of scenes/paper.ron to 15 N in 50 frames, solved directly on the recorded mesh.
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
