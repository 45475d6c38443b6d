#!/bin/bash
# usage: gate.sh [long]: what every submission must pass, from a bare Debian 12; `long` is everything, for before a release.
# What costs least and says most comes first, and the first failure ends it. The seconds of each step are kept in
# build/gate/steps and stand in the last lines, as do the programs that failed and then passed by themselves.
set -euo pipefail
long=${1:-}
export DEBIAN_FRONTEND=noninteractive
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1"
mkdir -p build/gate
: >build/gate/steps
rm -f build/*/flaky
name=
began=$SECONDS

finish()
{
    local status=$?
    [ "$status" = 0 ] || printf '%6d  %s: FAILED\n' $((SECONDS - began)) "$name" >>build/gate/steps
    printf '\n== seconds of each step\n'
    cat build/gate/steps
    printf '%6d  in all\n' "$SECONDS"
    cat build/*/flaky 2>/dev/null || true
    [ "$status" = 0 ] || echo "gate: FAILED at: $name"
}
trap finish EXIT

step()
{
    name=$1
    began=$SECONDS
    shift
    printf '\n== %s (%s s so far)\n' "$name" "$SECONDS"
    "$@"
    printf '%6d  %s\n' $((SECONDS - began)) "$name" >>build/gate/steps
}

# Node and npm may come from elsewhere than Debian, whose npm then cannot be installed.
packages()
{
    local stages=(gate build demo test page lint cross scale)
    { command -v node && command -v npm; } >/dev/null || stages+=(contract)
    [ -z "$long" ] || stages+=(arm64 torture)
    docker/install.sh "${stages[@]}"
}

# Three programs that fail and then pass, in all runs together, are no chance.
few_flaky()
{
    local count
    count=$(cat build/*/flaky 2>/dev/null | wc -l)
    [ "$count" -lt 3 ] || { echo "$count programs failed and then passed: mend them"; return 1; }
}

# The tests of the release build run every claim; `long` with more seeds, larger clouds and all sanitizer runs.
step "packages" packages
step "formatting, include law, shapes" make quick
step "make test" make ${long:+VT_SOAK=1} test
step "make demo" make demo
step "shapes with random parameters" make zoo SHORT=1
if [ -n "$long" ]; then
    step "static analysis, nothing remembered" env VORONOID_CACHE="$PWD/build/gate/cache" make static
else
    step "static analysis" make static
fi
step "jobs in PostgreSQL" make scale
step "openapi.yaml in other programs" make contract
step "core and proto for arm64" make cross
step "the image's file system" make image
step "AddressSanitizer and UndefinedBehaviorSanitizer" make config=asan ${long:+SANITIZE=all} check
step "ThreadSanitizer" make config=tsan ${long:+SANITIZE=all} check
step "fuzzing" make fuzz ${long:+FUZZ_SECONDS=60}
if [ -n "$long" ]; then
    step "arm64" make arm64
    step "torture" make torture
fi
step "flaky programs" few_flaky
