#!/bin/bash
# usage: static.sh: what analyzers say of each C source of the product, the largest first: nothing, and there is no baseline.
set -euo pipefail
began=$SECONDS
: "${VORONOID_CACHE:=${XDG_CACHE_HOME:-$HOME/.cache}/voronoid}"
mkdir -p "$VORONOID_CACHE/passed"
find "$VORONOID_CACHE/passed" -type f -mtime +30 -delete
mapfile -t sources < <(git ls-files -co --exclude-standard core proto server docker/pages | grep -E '\.c$' | xargs ls -S)
PACKAGE_FLAGS=$(pkg-config --cflags libcjson sqlite3 libcurl nettle zlib libseccomp)
RULES=$(cat .clang-tidy tests/lint/analyse.sh && gcc --version && clang-tidy --version && cppcheck --version)
export VORONOID_CACHE PACKAGE_FLAGS RULES
if ! printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -n 1 tests/lint/analyse.sh; then
    echo "static analysis FAILED"
    exit 1
fi
echo "static analysis of ${#sources[@]} files: ok, $((SECONDS - began)) s"
