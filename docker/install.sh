#!/bin/sh
# Installs the Debian packages of the stages named (build, demo, test, page, bench, peers, lint, contract, cross, arm64, torture, image, scale, gate)
# that docker/packages.txt lists and this machine lacks. Root or passwordless sudo does it; else prints the one line to type and
# fails. Headers of packages that would bring many others with them are unpacked under build/headers, which needs no root.
set -eu
here=$(dirname "$0")
headers=$here/../build/headers
missing=
unpacked=
for stage in "$@"; do
    while read -r of package what; do
        [ "$of" = "$stage" ] || continue
        state=$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null || true)
        case $state in
            ii*) ;;
            *) if [ -z "$what" ]; then
                   missing="$missing $package"
               elif [ ! -e "$headers/$package" ]; then
                   unpacked="$unpacked $package"
               fi ;;
        esac
    done <"$here/packages.txt"
done
[ -n "$missing$unpacked" ] || exit 0
export DEBIAN_FRONTEND=noninteractive LC_ALL=C
as_root=
if [ "$(id -u)" != 0 ]; then
    if command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        as_root="sudo -n"
    elif [ -n "$missing" ]; then
        echo "These packages are missing; install them, then try again:" >&2
        echo "apt-get install -y --no-install-recommends$missing" >&2
        exit 1
    fi
fi

# apt-get, which fails at once while another apt holds a lock: waits up to five minutes for that one to end.
apt_get()
{
    errors=$(mktemp)
    waited=0
    # shellcheck disable=SC2086 # "sudo -n" is two words
    until $as_root apt-get "$@" 2>"$errors"; do
        if [ "$waited" -ge "${VORONOID_APT_WAIT:-300}" ] || ! grep -qE 'Could not get lock|Unable to (lock|acquire)' "$errors"; then
            cat "$errors" >&2
            rm -f "$errors"
            return 1
        fi
        [ "$waited" -gt 0 ] || echo "Another apt-get is running: waiting for it, up to five minutes." >&2
        sleep 2
        waited=$((waited + 2))
    done
    cat "$errors" >&2
    rm -f "$errors"
}

if [ -n "$missing" ]; then
    apt_get update -q
    # shellcheck disable=SC2086 # a list of words
    apt_get install -y -q --no-install-recommends $missing
fi
for package in $unpacked; do
    fetched=$(mktemp -d)
    if ! (cd "$fetched" && apt-get download -q "$package"); then
        echo "The headers of $package cannot be fetched; install it, or run apt-get update, then try again." >&2
        exit 1
    fi
    mkdir -p "$headers"
    dpkg-deb -x "$fetched"/*.deb "$fetched/root"
    cp -R "$fetched/root/usr/include/." "$headers"
    rm -rf "$fetched"
    : >"$headers/$package"
done
