#!/bin/bash
# usage: bench.sh VORONOID: quality, time and memory in one row for each case, beside the figure asked for.
# RUNS (5) runs after a warm-up, median and spread. Clouds: ../shared where present, else a sphere made here. Tables:
# build/bench/engine.md and daemon.md.
set -euo pipefail
voronoid=$1
runs=${RUNS:-5}
out=build/bench
shared=../shared
mkdir -p "$out/clouds"
yardstick=$shared/yardstick/metrics.py
python=/usr/bin/python3

have_yardstick()
{
    [ -r "$yardstick" ] && "$python" -c 'import numpy, scipy' 2>/dev/null
}

number()
{
    grep -oE "\"$1\": ?[0-9.e+-]+" | head -n 1 | grep -oE '[0-9.e+-]+$' || echo -
}

# Median and half the range of the numbers on standard input.
spread()
{
    sort -g | awk '{ v[NR] = $1 } END { m = v[int((NR + 1) / 2)]; printf "%.2f ± %.2f", m, (v[NR] - v[1]) / 2 }'
}

# row NAME INPUT TRUTH|- ASKED POINTS ARGUMENTS...
row()
{
    local name=$1 input=$2 truth=$3 asked=$4 points=$5 result report measured i
    shift 5
    if [ ! -r "$input" ]; then
        echo "| $name | not measured: $input is not here | | | | | | | | $asked |" >>"$table"
        return
    fi
    result=$out/$name.ply
    for i in $(seq 0 "$runs"); do
        report=$("$voronoid" resample "$input" --points "$points" "$@" --threads 1 --json -o "$result" | tail -n 1)
        [ "$i" -gt 0 ] || continue
        printf '%s\n' "$report" >>"$out/$name.ndjson"
    done
    if have_yardstick; then
        if [ "$truth" != - ]; then
            measured=$("$python" "$yardstick" "$result" --input "$input" --mesh "$truth")
        else
            measured=$("$python" "$yardstick" "$result" --input "$input")
        fi
    else
        measured=$("$voronoid" measure "$result" --reference "$input")
    fi
    printf '| %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n' "$name" \
        "$(number n <<<"$measured")" "$(number coincident <<<"$measured")" "$(number delta <<<"$measured")" \
        "$(number hex <<<"$measured")" "$(number gap_max <<<"$measured")" "$(number off_surface_rms <<<"$measured")" \
        "$(jq -r '.seconds.iterate / .iterations / .points.out * 1e6' "$out/$name.ndjson" | spread)" \
        "$(jq -r '.seconds | .index + .init + .iterate' "$out/$name.ndjson" | spread) s, $(jq -r '.memory_peak_bytes / 1e6 | floor' <<<"$report") MB" \
        "$asked" >>"$table"
    rm -f "$out/$name.ndjson"
}

header()
{
    {
        echo "# Engine, one thread"
        echo
        echo "| case | n | coincident | delta | hex | gap_max | off_surface_rms | µs a point and iteration | engine time, peak | asked |"
        echo "|---|---|---|---|---|---|---|---|---|---|"
    } >"$table"
}

footer()
{
    {
        echo
        echo "$(git rev-parse --short HEAD 2>/dev/null || echo 'no commit'), $(gcc --version | head -n 1), -O2 -ffp-contract=off," \
            "$(grep -m 1 'model name' /proc/cpuinfo | cut -d: -f2 | xargs), $(nproc) cores, $(date -u +%F), $runs runs after a warm-up:" \
            "median ± half the range."
        echo "hex, gap_max and off_surface_rms are measured by the yardstick against the true mesh, over its diagonal."
    } >>"$1"
}

clouds=$out/clouds
if have_yardstick && [ ! -r "$clouds/igea34k_oct7.ply" ]; then
    "$python" "$shared/yardstick/makeclouds.py" "$clouds"
fi
table=$out/engine.md
header
data=$shared/data
row bunny "$data/bunny.ply" "$data/bun_zipper.ply" "delta <= 0.075" 5000 --iterations 50
row igea "$data/igea_tristrips.ply" "$data/igea_mesh.ply" "<= 8 µs" 20000 --iterations 50
row cow110k "$clouds/cow110k.ply" "$data/cow_mesh.ply" "delta <= 0.08" 5000 --iterations 35
row armadillo_half "$clouds/armadillo_half.ply" - "reported" 8000 --iterations 50
row igea34k_oct7 "$clouds/igea34k_oct7.ply" "$data/igea_mesh.ply" "off_surface_rms <= 8.3e-4" 34000 --iterations 20
row igea655k_noisy "$clouds/igea655k_noisy.ply" "$data/igea_mesh.ply" "delta <= 0.08, off_surface_rms <= 4.5e-4" 100000 \
    --neighbors 150 --iterations 20
footer "$table"
cat "$table"
tests/bench/daemon.pl "$voronoid" "$out"
cat "$out/daemon.md"
