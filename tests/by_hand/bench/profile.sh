#!/bin/bash
# usage: profile.sh VORONOID OUTDIR: the ten symbols where a run on Igea spends its time, where perf can record. Writes
# OUTDIR/profile.md.
set -euo pipefail
voronoid=$1
out=$2
input=../shared/data/igea_mesh.ply
page=$out/profile.md

[[ profile =~ ${ONLY:-} ]] || exit 0
{
    echo "# Profile"
    echo
    if [ ! -r "$input" ]; then
        echo "profile: not measured, $input is not here"
    elif ! command -v perf >/dev/null; then
        echo "profile: not measured, perf is not here"
    elif ! perf record -q -F 999 -o "$out/perf.data" -- "$voronoid" resample "$input" --points 20000 --threads 1 -q \
        -f -o "$out/profile.ply" >"$out/perf.log" 2>&1; then
        echo "profile: not measured, perf cannot record here"
    else
        echo "igea → 20000 at default quality, one thread."
        echo
        echo '| share | object | symbol |'
        echo '|---|---|---|'
        perf report -i "$out/perf.data" --stdio --no-children -F overhead,dso,sym 2>/dev/null |
            awk '/^ *[0-9.]+%/ && ++n <= 10 { share = $1; object = $2; sub(/^ *[^ ]+ +[^ ]+ +\[.\] +/, ""); sub(/ +$/, "")
                print "| " share " | " object " | `" $0 "` |" }'
    fi
    echo
} >"$page"
rm -f "$out/perf.data" "$out/perf.log" "$out/profile.ply"
cat "$page"
