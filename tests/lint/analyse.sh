#!/bin/bash
# usage: analyse.sh SOURCE: clang-tidy, gcc -fanalyzer and cppcheck read one C source; says what they find, and fails then.
# Called by static.sh, which sets RULES (what else a finding depends on) and PACKAGE_FLAGS. A tool that found nothing in this text, with
# these flags and rules, is not asked again: $VORONOID_CACHE/passed has a file for each such answer.
set -uo pipefail
source=$1
read -ra flags <<<"-std=c11 -D_POSIX_C_SOURCE=200809L -D_DEFAULT_SOURCE -I. -isystem build/headers $PACKAGE_FLAGS"
flags+=('-DVOR_VERSION="lint"' '-DVOR_ENGINE="lint"')
passed=$VORONOID_CACHE/passed
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail=0

# Comments hold what suppresses a finding, and cppcheck reads what the preprocessor leaves out: the text of each file counts too.
text=$( (gcc "${flags[@]}" -E -C -MMD -MF "$work/d" "$source" && grep -oE '[^ ]+\.[ch]\b' "$work/d" | xargs cat) | sha256sum) ||
    { echo "error: $source cannot be preprocessed"; exit 1; }

tool()
{
    local name=$1 key
    shift
    key=$(printf '%s\n' "$text" "$RULES" "$*" | sha256sum | cut -c-64)
    [ ! -e "$passed/$key" ] || return 0
    if "$@" >"$work/log" 2>&1; then
        : >"$passed/$key"
    else
        echo "$name of $source:"
        grep -E -A 6 '(error|warning|portability|note)(:| )|^In ' "$work/log" | head -n 60
        [ -s "$work/log" ] || echo "error: it said nothing"
        fail=1
    fi
}

tool clang-tidy clang-tidy --quiet --warnings-as-errors="*" "${flags[@]/#/--extra-arg=}" "$source"
tool gcc-analyzer gcc "${flags[@]}" -O1 -fanalyzer -Werror -S -o /dev/null "$source"
tool cppcheck cppcheck --quiet --std=c11 --error-exitcode=1 --enable=warning,portability --inline-suppr \
    --suppress=missingInclude --suppress=missingIncludeSystem -I. "$source"
exit "$fail"
