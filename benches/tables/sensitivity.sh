# How well posed squeezes are

sensitivity() {
    echo '```text'
    # A grasp that does not reach its force is a row of the table, not a failure of the measurement.
    { tactus dataset scenes/paper.ron --grasps 2 --frames 10 --sensitivity 2 -o "$OUT/sensitivity_$commit" || [ $? -eq 1 ]; } | tail -n 4
    echo '```'
}
