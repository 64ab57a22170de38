# Grasps per second by the network

# Grasps per second of `tactus predict` on lemons, with the given options.
a_second() { tactus predict tests/network/lemons.ron "$@" 2> /dev/null | sed -n 's/.* on [0-9]* threads\{0,1\}, \([0-9]*\) per second.*/\1/p'; }

predictions() {
    local frames
    echo '| loads of a grasp | grasps per second on one thread | on two |'
    echo '|---|---|---|'
    for frames in 1 12 50; do
        echo "| $frames | $(a_second --frames "$frames" --grasps 100 --threads 1) | $(a_second --frames "$frames" --threads 2) |"
    done
    printf '\nFour hundred grasps of a lemon on pads of 1,785 nodes; their error is that of the rows of the network under "Error of the network".\n'
}
