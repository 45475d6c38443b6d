#!/bin/bash
# usage: check.sh BUILD JOBS TEST...: runs the tests, as many beside each other as JOBS says, and names the ten that took
# most. V=1 shows every line they print. A program that fails runs once more, alone: if it passes then it is told as FLAKY, and
# the third such program fails the run.
set -uo pipefail
build=$1 jobs=$2
shift 2
times=$build/times flaky=$build/flaky
options=(--timer --exec "tests/support/clocked.pl $times")
[ -z "${V:-}" ] || options+=(-v)

# Scripts wait for two fifths of their time: two tests more than there are cores keep these busy.
[ "$jobs" = 1 ] || jobs=$((jobs + 2))

: >"$times"
: >"$flaky"
rm -f "$build/state"
prove -j "$jobs" --failures --state=save --statefile "$build/state" "${options[@]}" "$@"
result=$?
echo "The ten that took most, in seconds of CPU and by the clock, of $(awk '{ cpu += $1 } END { printf "%d s of CPU in all:", cpu }' "$times")"
sort -rn "$times" | head -n 10

mapfile -t failed < <(prove --dry --state=failed --statefile "$build/state")
[ "${#failed[@]}" -gt 0 ] || exit "$result"
if [ "${#failed[@]}" -gt 2 ]; then
    echo "${#failed[@]} programs failed: too many to be chance."
    exit 1
fi
status=0
for test in "${failed[@]}"; do
    echo "Once more, alone: $test"
    if prove "${options[@]}" "$test"; then
        echo "FLAKY $test" | tee -a "$flaky"
    else
        status=1
    fi
done
exit "$status"
