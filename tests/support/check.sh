#!/bin/bash
# usage: check.sh BUILD JOBS TEST... -- TEST...: runs the tests before the --, JOBS of them beside each other, then those
# after it one by one, and names the ten that took most. V=1 shows every line they print.
set -uo pipefail
build=$1 jobs=$2
shift 2
times=$build/times
together=()
while [ "$1" != -- ]; do
    together+=("$1")
    shift
done
shift
options=(--failures --timer --exec "tests/support/clocked.pl $times")
[ -z "${V:-}" ] || options+=(-v)
fail=0

: >"$times"
prove -j "$jobs" "${options[@]}" "${together[@]}" || fail=1
[ $# = 0 ] || prove "${options[@]}" "$@" || fail=1
echo "The ten that took most, in seconds of CPU and by the clock, of $(awk '{ cpu += $1 } END { printf "%d s of CPU in all:", cpu }' "$times")"
sort -rn "$times" | head -n 10
exit "$fail"
