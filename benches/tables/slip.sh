# Load at which the object slips

# Sixty grasps of tests/network/slip.ron, each pushed in thirty frames until finite elements drop the object: error of the
# load predicted by the network. $mechanics is set by results.sh.
slip() {
    local set=$OUT/slip_$mechanics
    tactus dataset tests/network/slip.ron -o "$set" > "$set.txt" || [ $? -eq 1 ]
    tactus eval "$set" --split all --extrapolate --model universe > "$set.eval.txt"
    echo '| grasps dropped under a push | predicted load within a tenth of that of finite elements, % | median error, % | within its interval, % |'
    echo '|---|---|---|---|'
    awk '/^slip: / { gsub(/[;,]/, ""); for (i = 1; i <= NF; i++) if ($i == "%") { v[++n] = $(i - 1) } printf "| %s | %s | %s | %s |\n", $2, v[1], v[2], v[3] }' "$set.eval.txt"
}
