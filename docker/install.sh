#!/bin/sh
# Installs the Debian packages of the stages named (build, demo, test, page, bench, lint, contract, cross, arm64, torture) that
# docker/packages.txt lists and this machine lacks. Root or passwordless sudo does it; else prints the one line to type and fails.
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
export DEBIAN_FRONTEND=noninteractive LC_ALL=C
if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root="sudo -n"
else
    echo "These packages are missing; install them, then try again:" >&2
    echo "apt-get install -y --no-install-recommends$missing" >&2
    exit 1
fi

# apt-get, which fails at once while another apt holds a lock: waits up to five minutes for that one to end.
apt_get()
{
    errors=$(mktemp)
    waited=0
    # shellcheck disable=SC2086 # "sudo -n" is two words
    until $as_root apt-get "$@" 2>"$errors"; do
        if [ "$waited" -ge 300 ] || ! grep -qE 'Could not get lock|Unable to (lock|acquire)' "$errors"; then
            cat "$errors" >&2
            rm -f "$errors"
            return 1
        fi
        [ "$waited" -gt 0 ] || echo "Another apt is at work: waiting for it, up to five minutes." >&2
        sleep 2
        waited=$((waited + 2))
    done
    cat "$errors" >&2
    rm -f "$errors"
}

apt_get update -q
# shellcheck disable=SC2086 # a list of words
apt_get install -y -q --no-install-recommends $missing
