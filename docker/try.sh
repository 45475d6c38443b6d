#!/bin/bash
# usage: try.sh ROOTFS: runs the image's root file system as its own user, read-only and without capabilities where
# this machine allows that, and resamples a small cloud through it. Needs root; says so and succeeds where it is not.
set -euo pipefail
root=$(realpath "$1")
if [ "$(id -u)" != 0 ]; then
    echo "try.sh: skipped, not root"
    exit 0
fi
megabytes=$(($(du -sb "$root" | cut -f1) / 1000000)) # before the daemon keeps its reserve of the disk there
stated=$(sed -n 's/^[^0-9]* \([0-9]*\) MB.*/\1/p' server/cli/help/container.txt)
if [ $((megabytes - stated)) -gt 2 ] || [ $((stated - megabytes)) -gt 2 ]; then
    echo "try.sh: the image has $megabytes MB, and help container says $stated" >&2
    exit 1
fi
work=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$work"' EXIT
awk 'BEGIN { srand(3); print "ply\nformat ascii 1.0\nelement vertex 3000\nproperty float x\nproperty float y\nproperty float z\nend_header"
    for (i = 0; i < 3000; i++) { z = 2 * rand() - 1; a = 6.2831853 * rand(); r = sqrt(1 - z * z); print r * cos(a), r * sin(a), z } }' \
    >"$work/sphere.ply"
: >"$work/log"
setpriv --no-new-privs chroot --userspec=65532:65532 "$root" /usr/bin/voronoid serve \
    --listen 127.0.0.1:0 --data /var/lib/voronoid 2>>"$work/log" &
url=$(tests/demo/listening.sh "$work/log" $!)
chroot --userspec=65532:65532 "$root" /usr/bin/voronoid health --server "$url"
curl -sSf -X POST -T "$work/sphere.ply" -o "$work/out.drc" "$url/v1/resample?points=500&format=drc"
head -c 5 "$work/out.drc" | grep -q DRACO
readelf --string-dump=.gnu_debuglink "$root/usr/bin/voronoid" | grep -q 'voronoid\.debug' || { echo "try.sh: the binary names no symbols" >&2; exit 1; }
readelf --sections "$root.debug/voronoid.debug" 2>/dev/null | grep -q ' \.symtab ' || { echo "try.sh: there are no symbols" >&2; exit 1; }

# A folder that the host mounts belongs to root as a rule: the daemon says so, and what to do.
install -d -m 0755 "$root/var/lib/mounted"
if said=$(setpriv --no-new-privs chroot --userspec=65532:65532 "$root" /usr/bin/voronoid serve \
    --listen 127.0.0.1:0 --data /var/lib/mounted 2>&1); then
    echo "try.sh: a folder that the daemon must not write is no hindrance" >&2
    exit 1
fi
rmdir "$root/var/lib/mounted"
grep -qx 'voronoid: /var/lib/mounted belongs to user 0, .* chown -R 65532:65532 /var/lib/mounted .*' <<<"$said" || {
    echo "try.sh: a folder of the wrong owner is not named: $said" >&2
    exit 1
}

# As the image is started when nobody says more: it listens beyond its own loopback, and says what is missing.
status=0
said=$(VORONOID_LISTEN=0.0.0.0:0 chroot --userspec=65532:65532 "$root" /usr/bin/voronoid serve --data /var/lib/voronoid 2>&1) || status=$?
if [ "$status" != 2 ] || ! grep -q -- '--api-keys FILE .*--no-auth' <<<"$said"; then
    echo "try.sh: the image starts without keys, or does not say how it would ($status): $said" >&2
    exit 1
fi
echo "try.sh: the image's file system serves as uid 65532 ($megabytes MB)"
