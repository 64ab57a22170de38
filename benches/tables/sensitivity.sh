# How well posed squeezes are

sensitivity() {
    echo '```text'
    # Exit status 1 means that a grasp did not reach its force; the table lists it.
    { tactus dataset scenes/paper.ron --grasps 2 --frames 10 --sensitivity 2 -o "$OUT/sensitivity_$commit" || [ $? -eq 1 ]; } | tail -n 4
    echo '```'
}
