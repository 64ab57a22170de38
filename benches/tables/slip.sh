# Load at which the object slips

# Number of frames that each grasp of tests/network/slip.ron holds: three of squeeze, then thirty of push.
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
