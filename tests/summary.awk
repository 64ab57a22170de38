# Summarises the output of `cargo test` and `pytest -rs`: each reason for skipping with its count, and in the last line
# the numbers of tests that passed, failed, or skipped at least a part of themselves.
function skip(reason, count) {
    if (!(reason in counts)) reasons[++kinds] = reason
    counts[reason] += count
}

/^test result: / { passed += $4; failed += $6; if ($8) { skip("thorough tests, which `tests/all.sh --thorough` runs", $8); skipped += $8 }; next }

# A Rust test that skips at least a part of itself; the test harness counts it as passed.
match($0, /skipped: [^ ]+: /) {
    test = substr($0, RSTART + 9, RLENGTH - 11)
    reason = substr($0, RSTART + RLENGTH)
    if (!seen[test]++) { skipped++; passed-- }
    if (!seen[test, reason]++) skip(reason, 1)
}

/^SKIPPED \[[0-9]+\] / {
    count = substr($2, 2) + 0
    sub(/^SKIPPED \[[0-9]+\] [^ ]+: /, "")
    skip($0, count)
    skipped += count
}

# The summary line of pytest.
/^=* ?[0-9]+ (passed|failed|skipped|errors?|deselected|warnings?).* in [0-9.]+s/ {
    for (i = 2; i <= NF; i++) {
        if ($i ~ /^passed/) passed += $(i - 1)
        if ($i ~ /^(failed|errors?)/) failed += $(i - 1)
    }
}

END {
    for (i = 1; i <= kinds; i++) printf "skipped: %s (%d)\n", reasons[i], counts[reasons[i]]
    printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped
}
