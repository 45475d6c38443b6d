#!/bin/bash
# usage: picture.sh VORONOID BUNNY.ply OUT.png: makes the picture of README: the head of the Stanford bunny's scan of 35,947
# points, and the same with 12,000 that voronoid spread.
set -euo pipefail
voronoid=$1
cloud=$2
out=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$voronoid" resample "$cloud" -n 12000 --normals fit -q -o "$folder/after.ply"
# Filters alone keep the points in their order: these have the normals of the scan's.
"$voronoid" denoise "$cloud" --filters mls --normals fit -q -o "$folder/normals.ply"
/usr/bin/python3 "$(dirname "$0")/picture.py" "$cloud" "$folder/normals.ply" "$folder/after.ply" -0.097 0.092 0.085 "$out"
