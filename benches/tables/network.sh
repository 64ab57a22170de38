# Error of the network that ships, against finer finite elements

# Row with the title $1: errors of the network on split $3 of data set $2, generated with the remaining arguments. It is
# generated again only after changes of the mechanics or the scenes.
judged() {
    local what=$1 set=$OUT/$2_$mechanics split=$3
    shift 3
    # Exit status 1 means that a grasp did not reach its force; this does not invalidate the measurement.
    tactus dataset "$@" -o "$set" > /dev/null || [ $? -eq 1 ]
    tactus eval "$set" --split "$split" --extrapolate --model universe | tee "$set.txt" | awk -v what="$what" '
        NR == 1 { grasps = $1 }
        /^all +(displacement|stress|travel) / { error[$2] = sprintf("%.1f / %.1f", $3, $4); within[$2] = $7; interval[$2] = $9 }
        /^Kendall/ { tau = $8 + 0 }
        END { printf "| %s | %s | %s | %s | %s | %s / %s / %s | %.1f | %.2f |\n", what, grasps, error["displacement"], error["stress"],
            error["travel"], within["displacement"], within["stress"], within["travel"], interval["displacement"], tau }'
}

network() {
    echo '| grasps that it never saw | number | displacement, median / 90 %, % | stress | travel | within its interval, %: displacement / stress / travel | median interval, displacement, % | tau |'
    echo '|---|---|---|---|---|---|---|---|'
    judged "the objects of scenes/paper.ron, other poses" paper poses scenes/paper.ron --grasps 14 --frames 10
    judged "another seed of scenes/universe.ron" unseen all tests/network/unseen.ron
    judged "other pads: scenes/second_sensor.ron" sensor all scenes/second_sensor.ron --grasps 3
    judged "with weight: scenes/gravity.ron" gravity all scenes/gravity.ron --grasps 3
    judged "balls of 5 to 32 mm radius" balls all tests/network/balls.ron
    [ -d ../shared/data ] || return 0
    judged "GelSight Mini pads meshed by gmsh, against finite elements on finer meshes of their shape" own_pads all tests/network/own_pads.ron
    judged "sixteen scanned objects" scans all tests/network/scans.ron
    printf '\nThe scanned objects with `error_at_most`:\n\n```text\n'
    grep '^error_at_most' "$OUT/scans_$mechanics.txt"
    echo '```'
}
