#!/bin/bash
# usage: scan.sh NAME: prints the path of one of the scans below, in build/scan/, fetching it first where it is not there.
# They come from a Debian package that is looked into, not installed; its version and every checksum are verified.
set -euo pipefail
name=$1
package=libcgal-demo
version=5.5.1-2
package_sha256=78b09b23d4d6d1bf15552a1060b419ab3fc09918486462faed197e5fc6ac3735
case $name in
building.ply) sha256=8604fd5448ed716f58df787a7696481f26b3c69587f88048fc48223467ac71f7 ;;
b9_training.ply) sha256=94c05829a78b1ebbb6882dda0e5e263f30331ff10820a0beb61843001ad0b46d ;;
hippo1.ply) sha256=74e38ebd5a8fd25340be46bca0543fc40224b2966ec6880305609da2b32c173f ;;
*)
    echo "scan.sh: no scan $name; there are building.ply, b9_training.ply, hippo1.ply" >&2
    exit 2
    ;;
esac
folder=build/scan
deb=$folder/${package}_${version}_all.deb

holds()
{
    echo "$1  $2" | sha256sum --check --status 2>/dev/null
}

# The lists of packages may be missing or old.
download()
{
    apt-get download -q "$package=$version" && return 0
    if [ "$(id -u)" = 0 ]; then apt-get update -q; else sudo -n apt-get update -q; fi
    apt-get download -q "$package=$version"
}

mkdir -p "$folder"
if ! holds "$sha256" "$folder/$name"; then
    if ! holds "$package_sha256" "$deb"; then
        echo "Fetching $package $version for its scans ..." >&2
        (cd "$folder" && download) >"$folder/apt.log" 2>&1 || { cat "$folder/apt.log" >&2; exit 1; }
        holds "$package_sha256" "$deb" || { echo "scan.sh: $deb is not what it should be" >&2; exit 1; }
    fi
    dpkg-deb --fsys-tarfile "$deb" | tar -xO ./usr/share/doc/libcgal-dev/data.tar.gz |
        tar -xz -O "data/points_3/$name" >"$folder/$name.new"
    holds "$sha256" "$folder/$name.new" || { echo "scan.sh: $name is not what it should be" >&2; exit 1; }
    mv "$folder/$name.new" "$folder/$name"
fi
echo "$folder/$name"
