#!/bin/bash
# The whole product once, on a real scan: starts a daemon, sends a cloud over HTTP, shows how it converges, fetches
# the Draco result, sends that back in, and measures both. usage: demo.sh VORONOID [CLOUD.ply|.drc]
# Results and report: build/demo/.
set -euo pipefail
voronoid=$(realpath "$1")
cloud=${2:-}
out=build/demo
points=${POINTS:-10000}

# shellcheck source=tests/demo/daemon.sh
. tests/demo/daemon.sh

# Prints the events of a resampling as they come; the result's link is in the last one.
show_progress()
{
    awk -F'"' '
        /^data: / { line = $0 }
        /"delta":/ && match(line, /"iteration":[0-9]+/) {
            step = sprintf("iteration %3d", substr(line, RSTART + 12, RLENGTH - 12))
            if (match(line, /"polish":[1-9][0-9]*/))
                step = sprintf("polish %6d", substr(line, RSTART + 9, RLENGTH - 9))
            if (match(line, /"delta":[0-9.e+-]+/) && step != last) {
                delta = substr(line, RSTART + 8, RLENGTH - 8)
                bar = sprintf("%*s", int(delta * 120) > 60 ? 60 : int(delta * 120), "")
                gsub(/ /, "#", bar)
                printf "  %s  delta %.4f  %s\n", step, delta, bar
                fflush()
                last = step
            }
        }'
}

# A member a line.
in_lines()
{
    sed 's/,"/,\n"/g' "$1"
}

report()
{
    {
        echo "# voronoid: $(basename "$cloud") to $points points"
        echo
        echo "| | |"
        echo "|---|---|"
        echo "| sent | $(basename "$cloud"), $(stat -c %s "$cloud") bytes |"
        echo "| received | result.drc, $(stat -c %s "$out/result.drc") bytes |"
        echo
        echo "![before and after](picture.png)"; echo
        echo "The daemon's report:"; echo; echo '```json'; in_lines "$out/report.json"; echo; echo '```'; echo
        echo "The result, compared with the cloud that was sent:"; echo; echo '```json'
        in_lines "$out/measure.json"; echo; echo '```'; echo
        echo "The result, sent again and resampled to half as many points:"; echo; echo '```json'
        in_lines "$out/again.json"; echo; echo '```'
    } >"$out/report.md"
}

mkdir -p "$out"
[ -n "$cloud" ] || cloud=$(tests/demo/scan.sh building.ply)
start_daemon
echo "voronoid listens at $url (log: $out/daemon.log)"
echo "POST /v1/resample?points=$points&format=drc  $(basename "$cloud")"
curl -sSN -T "$cloud" -X POST -H 'Accept: text/event-stream' -H 'Expect:' \
    "$url/v1/resample?points=$points&format=drc" | tee "$out/events.txt" | show_progress
job=$(grep -o '"jobID":"[^"]*"' "$out/events.txt" | head -n 1 | cut -d'"' -f4) ||
    { echo "the daemon refused: $(cat "$out/events.txt")" >&2; exit 1; }
curl -sSf -o "$out/result.drc" "$url/v1/jobs/$job/results/cloud"
curl -sSf -o "$out/report.json" "$url/v1/jobs/$job/results/report"
"$voronoid" measure "$out/result.drc" --reference "$cloud" >"$out/measure.json"
curl -sSf -T "$out/result.drc" -X POST -H 'Expect:' -o "$out/again.ply" \
    "$url/v1/resample?points=$((points / 2))&format=ply"
"$voronoid" measure "$out/again.ply" --reference "$out/result.drc" >"$out/again.json"
"$voronoid" convert "$cloud" -q -f -o "$out/before.ply"
"$voronoid" convert "$out/result.drc" -q -f -o "$out/after.ply"
perl tests/demo/picture.pl "$out/before.ply" "$out/after.ply" "$out/picture.png"
report
echo "Wrote $out/result.drc ($(stat -c %s "$out/result.drc") bytes for $points points; the cloud that was sent has $(stat -c %s "$cloud"))"
echo "  measured: $(grep -oE '"(n|delta|coincident)":[0-9.e-]+' "$out/measure.json" | tr '\n' ' ')"
echo "  sent again: $(grep -oE '"(n|delta|coincident)":[0-9.e-]+' "$out/again.json" | tr '\n' ' ')"
echo "Report:  $out/report.md"
echo "Picture: $out/picture.png, before and after"
echo "Page:    run $voronoid serve, open http://127.0.0.1:8080 and drop $cloud there"
