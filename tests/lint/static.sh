#!/bin/bash
# Formatting, static analysis, shell and YAML: no findings, no baseline.
set -euo pipefail
fail=0
mapfile -t c_files < <(git ls-files -co --exclude-standard core proto server tests | grep -E '\.([ch]|cc)$')
mapfile -t sources < <(printf '%s\n' "${c_files[@]}" | grep -E '^(core|proto|server)/.*\.c$')
mapfile -t scripts < <(git ls-files -co --exclude-standard | xargs grep -lE '^#!(/bin/sh|/bin/bash|/usr/bin/env bash)' --)

# check NAME COMMAND...; a COMMAND that begins with `each` runs once for each C source of the product, the largest first.
check()
{
    local name=$1 began=$SECONDS
    shift
    printf '%-14s' "$name"
    if [ "$1" = each ]; then
        shift
        set -- xargs -a build/lint.list -P "$(nproc)" -n 1 "$@"
    fi
    if "$@" >build/lint.log 2>&1; then
        echo "ok, $((SECONDS - began)) s"
    else
        echo FAILED
        grep -E -A 6 '(error|warning|portability|note)(:| )|^In ' build/lint.log | head -n 60 || true # head may end first
        [ -s build/lint.log ] || echo "$name said nothing"
        fail=1
    fi
}

read -ra flags <<<"-std=c11 -D_POSIX_C_SOURCE=200809L -D_DEFAULT_SOURCE -I. -DVOR_VERSION=\"lint\" -DVOR_ENGINE=\"lint\" $(pkg-config --cflags libmicrohttpd libcjson sqlite3 libcurl nettle zlib libseccomp)"

mkdir -p build
ls -S "${sources[@]}" >build/lint.list
check clang-format clang-format --dry-run --Werror "${c_files[@]}"
check cppcheck cppcheck --quiet --std=c11 --error-exitcode=1 --enable=warning,portability --inline-suppr \
    --suppress=missingInclude --suppress=missingIncludeSystem -I. -j "$(nproc)" core proto server
check clang-tidy each clang-tidy --quiet --warnings-as-errors="*" "${flags[@]/#/--extra-arg=}"
check gcc-analyzer each gcc "${flags[@]}" -O1 -fanalyzer -Werror -S -o /dev/null
check shellcheck shellcheck -x "${scripts[@]}"
check yamllint yamllint -d '{extends: default, rules: {line-length: {max: 160}, document-start: disable}}' openapi.yaml docker
exit "$fail"
