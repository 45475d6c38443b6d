#!/bin/bash
# usage: bench.sh VORONOID: what was asked of speed, memory and quality, measured. RUNS (5) runs of each row after a
# warm-up; ONLY (a regular expression) picks rows by name. Clouds: those of ../shared where present, and a torus made
# here; a row without its cloud says so. Tables and plots: build/bench.
set -euo pipefail
voronoid=$1
here=$(dirname "$0")
out=build/bench
yardstick=../shared/yardstick
export RUNS=${RUNS:-5} ONLY=${ONLY:-}

mkdir -p "$out/clouds"
if [[ peers =~ $ONLY ]]; then
    "$here/peers.py" "$voronoid" "$out"
fi
[ "$ONLY" != peers ] || exit 0
if [ -r "$yardstick/makeclouds.py" ] && [ ! -r "$out/clouds/armadillo5m_uneven.ply" ]; then
    /usr/bin/python3 "$yardstick/makeclouds.py" "$out/clouds" --large
fi
for part in engine density acceleration index scaling real order sheets edges ear loops wlop orient mesh codec anisotropy waiting; do
    "$here/$part.pl" "$voronoid" "$out"
done
"$here/profile.sh" "$voronoid" "$out"
if [[ register =~ $ONLY ]]; then
    "$here/register.py" "$voronoid" "$out"
fi
if [[ daemon =~ $ONLY ]]; then
    "$here/daemon.pl" "$voronoid" "$out"
    cat "$out/daemon.md"
fi
if [[ page =~ $ONLY ]]; then
    "$here/page.py" "$voronoid" "$out"
fi
