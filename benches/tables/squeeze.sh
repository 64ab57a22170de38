# Speed against error: a lemon that the network never saw

squeeze() {
    tactus bench scenes/lemon.ron --frames 50 --grasps 1 --repeat 1 --model universe -o "$OUT/squeeze" > /dev/null
    cp "$OUT/squeeze/bench.png" docs/network.png
    tactus report "$OUT/squeeze" -o "$OUT/squeeze.html" | sed '1d; /^'"${OUT//\//\\/}"'/d'
}

# Rows for the README: three columns of the table, for the recommended settings.
readme_squeeze() {
    awk -F'|' '
        /^\| setting/ { print "| setting | s a grasp | displacement, median / 90 % / worst, % |"; print "|---|---|---|" }
        /^\| (network|condensed (2.60|1.84) mm|quadratic (2.60|1.84) mm)/ { printf "|%s|%s|%s|\n", $2, $4, $6 }'
}
