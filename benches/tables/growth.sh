# How times grow

# Row with the title $1: times of a command with the last argument $2 and with $3, and the exponent of growth.
grows() {
    local what=$1 small=$2 large=$3
    shift 3
    echo "$what|$small|$large|$(seconds "$@" "$small")|$(seconds "$@" "$large")" |
        awk -F'|' '{ printf "| %s | %d | %d | %.2f | %.2f | %.2f |\n", $1, $2, $3, $4, $5, log($5 / $4) / log($3 / $2) }'
}

# Exponents of growth of the time with the number that is varied.
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
