#!/bin/bash
# usage: fetch.sh FOLDER: unpacks nginx, haproxy and caddy under FOLDER/root, with the libraries that they load and this
# machine may lack, from Debian's packages of today. Nothing is installed and nothing is started.
set -euo pipefail
packages=(nginx haproxy liblua5.3-0 libopentracing-c-wrapper0 libopentracing1 caddy)
folder=$1
root=$folder/root
[ ! -e "$root/complete" ] || exit 0

# The lists of packages may be missing or old.
download()
{
    (cd "$folder/debs" && apt-get download -q "${packages[@]}") && return 0
    if [ "$(id -u)" = 0 ]; then apt-get update -q; else sudo -n apt-get update -q; fi
    (cd "$folder/debs" && apt-get download -q "${packages[@]}")
}

rm -rf "$root" "$folder/debs"
mkdir -p "$root" "$folder/debs"
echo "Fetching nginx, haproxy and caddy, to be unpacked in $root ..." >&2
download >"$folder/apt.log" 2>&1 || { cat "$folder/apt.log" >&2; exit 1; }
for deb in "$folder"/debs/*.deb; do
    dpkg-deb -x "$deb" "$root"
done
rm -rf "$folder/debs"
: >"$root/complete"
