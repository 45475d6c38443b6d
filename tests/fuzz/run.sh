#!/bin/bash
# usage: run.sh BUILD SECONDS TARGET...: each fuzzer for SECONDS, from tests/fuzz/corpus/TARGET, keeping nothing but
# what crashes (build/fuzz/crash-*).
set -euo pipefail
build=$1 seconds=$2
shift 2
for target in "$@"; do
    work=$(mktemp -d)
    options=(-max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1
        -artifact_prefix="$build/crash-$target-")
    [ ! -f "tests/fuzz/$target.dict" ] || options+=(-dict="tests/fuzz/$target.dict")
    echo "fuzz $target: $seconds s"
    if ! "$build/tests/fuzz/${target}_fuzz" "${options[@]}" "$work" "tests/fuzz/corpus/$target" \
        >"$build/$target.log" 2>&1; then
        tail -n 40 "$build/$target.log"
        echo "fuzz $target: FAILED, see $build/$target.log"
        exit 1
    fi
    grep -E '^stat::(number_of_executed_units|peak_rss_mb)' "$build/$target.log" | sed 's/^/  /'
    rm -rf "$work"
done
