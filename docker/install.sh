#!/bin/sh
# Installs the Debian packages of the stages named (build, demo, test, bench, lint) that docker/packages.txt lists and
# this machine lacks. Root or passwordless sudo does it; else prints the one line to type and fails.
set -eu
here=$(dirname "$0")
missing=
for stage in "$@"; do
    while read -r of package; do
        [ "$of" = "$stage" ] || continue
        state=$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null || true)
        case $state in ii*) ;; *) missing="$missing $package" ;; esac
    done <"$here/packages.txt"
done
[ -n "$missing" ] || exit 0
export DEBIAN_FRONTEND=noninteractive
if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root="sudo -n"
else
    echo "These packages are missing; install them, then try again:" >&2
    echo "apt-get install -y --no-install-recommends$missing" >&2
    exit 1
fi
# shellcheck disable=SC2086 # lists of words
{
    $as_root apt-get update -q
    $as_root apt-get install -y -q --no-install-recommends $missing
}
