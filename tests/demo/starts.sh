#!/bin/bash
# usage: starts.sh VORONOID N: starts the daemon of the demo N times, one after another, asks it whether it takes jobs, and
# ends it. Says how many failed and how long the slowest took; fails when one did.
set -uo pipefail
voronoid=$(realpath "$1")
times=$2
out=$(mktemp -d)
# shellcheck source=tests/demo/daemon.sh
. tests/demo/daemon.sh

# One start in a shell of its own, where the first thing that fails ends it.
start_once()
(
    set -e
    start_daemon
    curl -sSf --max-time 20 -o "$out/ready" "$url/readyz"
    stop_daemon
)

failed=0 slowest=0
for _ in $(seq "$times"); do
    began=$(date +%s%N)
    start_once
    status=$?
    took=$((($(date +%s%N) - began) / 1000000))
    [ "$took" -le "$slowest" ] || slowest=$took
    if [ "$status" != 0 ]; then
        failed=$((failed + 1))
        cat "$out/daemon.log" >&2
    fi
done
rm -rf "$out"
echo "$times starts of the demo's daemon, $failed failures, the slowest $slowest ms from start to end"
[ "$failed" = 0 ]
