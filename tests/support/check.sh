#!/bin/bash
# usage: check.sh BUILD JOBS TEST...: runs the tests, as many beside each other as JOBS says, and names the ten that took
# most. V=1 shows every line they print.
set -uo pipefail
build=$1 jobs=$2
shift 2
times=$build/times
options=(--failures --timer --exec "tests/support/clocked.pl $times")
[ -z "${V:-}" ] || options+=(-v)
fail=0

# Scripts wait for two fifths of their time: one test more than there are cores keeps these busy.
[ "$jobs" = 1 ] || jobs=$((jobs + 1))

# A program in which nothing that starts a thread is linked has no race for ThreadSanitizer to find. It needs no mark, and
# a new one is run as soon as it calls what can start one.
starts_threads()
{
    local symbols
    [[ $1 != *.t ]] || return 0
    symbols=$(nm -D --undefined-only "$1") || return 0
    grep -qE ' (pthread_create|thrd_create|_ZNSt6thread|GOMP_|MHD_|curl_)' <<<"$symbols"
}

tests=()
spared=0
for test in "$@"; do
    if [ "$(basename "$build")" = tsan ] && ! starts_threads "$test"; then
        spared=$((spared + 1))
    else
        tests+=("$test")
    fi
done
[ "$spared" = 0 ] || echo "$spared programs start no thread: the other runs have them"

: >"$times"
prove -j "$jobs" "${options[@]}" "${tests[@]}" || fail=1
echo "The ten that took most, in seconds of CPU and by the clock, of $(awk '{ cpu += $1 } END { printf "%d s of CPU in all:", cpu }' "$times")"
sort -rn "$times" | head -n 10
exit "$fail"
