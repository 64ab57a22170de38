# Hard cases and the methods they take

# Runs every scene of scenes/torture and scenes/dynamic and lists the continuation methods used.
hard_cases() {
    local scene name
    echo '| scene | outcome | iterations | methods |'
    echo '|---|---|---|---|'
    for scene in scenes/torture/*.ron scenes/dynamic/*.ron; do
        name=$(basename "$scene" .ron)
        tactus run "$scene" > "$OUT/$name.txt" 2> /dev/null || true
        awk -v name="$name" '
            /^ +0 / { outcome = $2 }
            / Newton iterations: / { iterations = $4 }
            / increments?(,|$)/ { methods = $0 }
            END { printf "| %s | %s | %s | %s |\n", name, outcome ? outcome : "refused", iterations, methods }' "$OUT/$name.txt"
    done
}
