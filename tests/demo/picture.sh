#!/bin/bash
# usage: picture.sh VORONOID OUT.png: makes the picture of README: the head of a hippopotamus of 6,104 points, one of the
# demo's scans, and the same with as many that voronoid spread.
set -euo pipefail
voronoid=$1
out=$2
cloud=$(tests/demo/scan.sh hippo1.ply)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$voronoid" resample "$cloud" --ratio 1 --normals fit -q -o "$folder/after.ply"
# Filters alone keep the points in their order: these have the normals of the scan's.
"$voronoid" denoise "$cloud" --filters mls --normals fit -q -o "$folder/normals.ply"
/usr/bin/python3 tests/demo/picture.py "$cloud" "$folder/normals.ply" "$folder/after.ply" -0.5 -0.27 0.55 "$out"
