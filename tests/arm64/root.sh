#!/bin/bash
# usage: root.sh FOLDER: unpacks under FOLDER the arm64 libraries and headers that the build and its tests need, from the
# Debian mirror that apt uses here. Nothing of it is configured or run. About 220 MB are fetched, 750 MB unpacked.
set -euo pipefail
root=$1
[ ! -e "$root/complete" ] || exit 0
# shellcheck source=/dev/null
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
packages=$(awk '$1 ~ /^(build|test)$/ && $2 ~ /-dev$|^check$/ { print $2 }' docker/packages.txt | paste -sd,)
proxy=$(apt-config dump --format '%v' Acquire::http::Proxy)
rm -rf "$root"
mkdir -p "$root"
echo "Unpacking Debian's arm64 libraries in $root ..." >&2
# shellcheck disable=SC2016 # apt's own variables
apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian' |
    mmdebstrap --quiet --architectures=arm64 --variant=extract --include="$packages" \
        ${proxy:+--aptopt="Acquire::http::Proxy \"$proxy\""} "$suite" "$root" -
: >"$root/complete"
