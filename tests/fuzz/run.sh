#!/bin/bash
# usage: run.sh BUILD SECONDS JOBS TARGET...: each fuzzer replays tests/fuzz/corpus/TARGET, then looks for more in SECONDS,
# JOBS of them beside each other, keeping nothing but what crashes (BUILD/crash-*). Without SECONDS (a minus) only a fuzzer that
# has changed looks for more, for ten seconds: $VORONOID_CACHE/passed remembers those that have not, by their own bytes.
set -euo pipefail
build=$1 seconds=$2 jobs=$3
shift 3
passed=$VORONOID_CACHE/passed
mkdir -p "$passed"

# fuzz TARGET WHAT OPTION...
run()
{
    local target=$1 what=$2
    shift 2
    if ! "$build/tests/fuzz/${target}_fuzz" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
        -artifact_prefix="$build/crash-$target-" "$@" >"$build/$target.log" 2>&1; then
        tail -n 40 "$build/$target.log"
        echo "fuzz $target: FAILED, see $build/$target.log"
        return 1
    fi
    echo "fuzz $target: $what, $(sed -n 's/^stat::number_of_executed_units: *//p' "$build/$target.log") runs," \
        "$(sed -n 's/^stat::peak_rss_mb: *//p' "$build/$target.log") MB"
}

fuzz()
{
    local target=$1 key work options=()
    run "$target" "corpus" -runs=0 "tests/fuzz/corpus/$target"
    key=$(sha256sum <"$build/tests/fuzz/${target}_fuzz" | cut -c-64)
    if [ "$seconds" = - ] && [ -e "$passed/$key" ]; then
        return 0
    fi
    work=$(mktemp -d)
    [ ! -f "tests/fuzz/$target.dict" ] || options+=(-dict="tests/fuzz/$target.dict")
    run "$target" "${seconds/#-/10} s" -max_total_time="${seconds/#-/10}" "${options[@]}" "$work" "tests/fuzz/corpus/$target"
    rm -rf "$work"
    : >"$passed/$key"
}

export -f fuzz run
export build seconds passed
printf '%s\n' "$@" | xargs -P "$jobs" -I{} bash -euc 'fuzz {}'
