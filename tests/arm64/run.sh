#!/bin/bash
# usage: run.sh AMD64 ARM64 ROOT JOBS PROGRAM...: runs the arm64 test programs under qemu, JOBS beside each other, with the
# libraries of ROOT; then the golden cases; then the same requests by the binaries of the folders AMD64 and
# ARM64. PLY results have to be the same bytes. Draco's are compared by positions, since Debian's arm64 libdraco multiplies
# and adds in one step: a cell is given where they are written, a float32 step where they are read. ONLY=regex takes the
# programs and requests that match.
set -uo pipefail
export LC_ALL=C
amd64=$1 arm64=$2 root=$3 jobs=$4
shift 4
qemu="qemu-aarch64-static -L $root"
data=../shared/data
out=$arm64/compared
bits=11 # of a Draco coordinate
fail=0

# Check's time limits are meant for the machine itself.
tests=()
for program in "$@"; do
    case $program in */voronoid | */decode) continue ;; esac
    [[ $program =~ ${ONLY:-.} ]] && tests+=("$program")
done
export CK_TIMEOUT_MULTIPLIER=20
# qemu takes no list of system calls.
export VT_EMULATED=1 VORONOID_ALLOW_WEAK_SANDBOX=1
[ ${#tests[@]} = 0 ] || prove -j "$jobs" --failures --timer --exec "$qemu" "${tests[@]}" || fail=1

# same NAME COMMAND ARGUMENT...: a request on both machines, to PLY and to Draco.
same()
{
    local name=$1
    shift
    [[ $name =~ ${ONLY:-.} ]] || return 0
    if [ ! -e "$2" ]; then
        echo "$name: skipped, $2 is not there"
        return 0
    fi
    for suffix in ply drc; do
        if ! "$amd64/voronoid" "$@" -f -o "$out/$name-amd64.$suffix" >"$out/log" 2>&1 ||
            ! $qemu "$arm64/voronoid" "$@" -f -o "$out/$name-arm64.$suffix" >>"$out/log" 2>&1; then
            echo "$name to $suffix: FAILED"
            cat "$out/log"
            fail=1
            return 0
        fi
    done
    if cmp "$out/$name-amd64.ply" "$out/$name-arm64.ply"; then
        echo "$name to PLY: the same bytes"
    else
        echo "$name to PLY: OTHER BYTES"
        fail=1
    fi
    written "$name to Draco" "$out/$name-amd64.drc" "$out/$name-arm64.drc"
    read_by_both "$name from Draco" "$out/$name-amd64.drc"
}

# written NAME AMD64 ARM64: what each wrote, read here.
written()
{
    if cmp -s "$2" "$3"; then
        echo "$1: the same bytes"
        return
    fi
    "$amd64/tests/arm64/decode" "$2" >"$out/here"
    "$amd64/tests/arm64/decode" "$3" >"$out/there"
    tests/arm64/apart.pl "$1" "$out/here" "$out/there" "$bits" || fail=1
}

# read_by_both NAME FILE: the same file, read by each.
read_by_both()
{
    [[ $1 =~ ${ONLY:-.} ]] && [ -e "$2" ] || return 0
    "$amd64/tests/arm64/decode" "$2" >"$out/here" && $qemu "$arm64/tests/arm64/decode" "$2" >"$out/there" &&
        tests/arm64/apart.pl "$1" "$out/here" "$out/there" || fail=1
}

rm -rf "$out"
mkdir -p "$out"
[[ ! golden =~ ${ONLY:-.} ]] || ONLY=. VORONOID="$qemu $arm64/voronoid" prove -v tests/golden/golden.t || fail=1
same bunny resample $data/bunny.ply --quantization $bits -n 2000 --iterations 5 --polish 5 --normals fit
same autzen resample $data/autzen.ply --quantization $bits -n 2000 --iterations 3 --polish 3
same fandisk resample $data/fandisk_mesh.ply --quantization $bits -n 1500 --iterations 5 --polish 5 --order progressive
same cow simplify $data/cow_mesh.ply -n 800 --quantization 0
for file in pc_color pc_kd_color redrocks; do
    read_by_both "$file from Draco" "$data/$file.drc"
done
exit "$fail"
