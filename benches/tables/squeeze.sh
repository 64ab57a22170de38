# Speed against error: a lemon that the network never saw

squeeze() {
    tactus bench scenes/lemon.ron --frames 50 --grasps 1 --repeat 1 --model universe -o "$OUT/squeeze" > /dev/null
    cp "$OUT/squeeze/bench.png" docs/network.png
    tactus report "$OUT/squeeze" -o "$OUT/squeeze.html" | sed '1d; /^'"${OUT//\//\\/}"'/d'
}

# README has three columns of the squeeze, for the settings that a reader chooses between.
readme_squeeze() {
    awk -F'|' '
        /^\| setting/ { print "| setting | s a grasp | displacement, median / 90 % / worst, % |"; print "|---|---|---|" }
        /^\| (network|condensed (2.60|1.84) mm|quadratic (2.60|1.84) mm)/ { printf "|%s|%s|%s|\n", $2, $4, $6 }'
}
