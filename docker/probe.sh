#!/bin/sh
# usage: probe.sh FILE CC CXX NAME='FLAG...'...: writes FILE for make: each NAME with those of its flags that both compilers
# take, to compile and to link a program of nothing. Writes none where they cannot do even that without flags.
set -eu
file=$1 cc=$2 cxx=$3
shift 3
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
echo 'int main(void) { return 0; }' >"$dir/none.c"
echo 'int main() { return 0; }' >"$dir/none.cc"

# A flag that is ignored with a warning is not taken either.
takes()
{
    # shellcheck disable=SC2086 # CC may hold options
    $cc -Werror "$@" "$dir/none.c" -o "$dir/none" 2>/dev/null && $cxx -Werror "$@" "$dir/none.cc" -o "$dir/none" 2>/dev/null
}

if ! takes; then
    ! command -v "${cc%% *}" >/dev/null || echo "$cc and $cxx cannot compile and link a program of nothing" >&2
    exit 0
fi
for set in "$@"; do
    printf '%s :=' "${set%%=*}"
    for flag in ${set#*=}; do
        ! takes "$flag" || printf ' %s' "$flag"
    done
    echo
done >"$dir/probed"
mkdir -p "$(dirname "$file")"
mv "$dir/probed" "$file"
