#!/bin/bash
# usage: run.sh BUILD SECONDS JOBS TARGET...: each fuzzer for SECONDS, JOBS of them beside each other, from
# tests/fuzz/corpus/TARGET, keeping nothing but what crashes (build/fuzz/crash-*).
set -euo pipefail
build=$1 seconds=$2 jobs=$3
shift 3

fuzz()
{
    local target=$1 work options
    work=$(mktemp -d)
    options=(-max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1
        -artifact_prefix="$build/crash-$target-")
    [ ! -f "tests/fuzz/$target.dict" ] || options+=(-dict="tests/fuzz/$target.dict")
    if ! "$build/tests/fuzz/${target}_fuzz" "${options[@]}" "$work" "tests/fuzz/corpus/$target" \
        >"$build/$target.log" 2>&1; then
        tail -n 40 "$build/$target.log"
        echo "fuzz $target: FAILED, see $build/$target.log"
        return 1
    fi
    echo "fuzz $target: $seconds s, $(sed -n 's/^stat::number_of_executed_units: *//p' "$build/$target.log") runs," \
        "$(sed -n 's/^stat::peak_rss_mb: *//p' "$build/$target.log") MB"
    rm -rf "$work"
}

export -f fuzz
export build seconds
printf '%s\n' "$@" | xargs -P "$jobs" -I{} bash -euc 'fuzz {}'
