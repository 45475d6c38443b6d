#!/bin/sh
# usage: rootfs.sh BINARY FOLDER [scale]: makes FOLDER a root file system that holds the binary, the libraries it loads and
# nothing else but the user it runs as, an empty state folder and /tmp. With "scale" also libpq and certificates, for a database
# and a bucket on other machines; else the daemon calls nobody. The binary is stripped; FOLDER.debug/voronoid.debug has its
# symbols, for a debugger.
set -eu
binary=$1
root=$2
rm -rf "$root" "$root.debug"
mkdir -p "$root/usr/bin" "$root/etc" "$root/tmp" "$root/var/lib/voronoid" "$root.debug"
# Loaded at run time: libmicrohttpd and FLANN by the daemon, libcurl by `voronoid health`, --server and --blobs s3:, libpq by
# --store postgresql:.
loaded="libmicrohttpd.so.12 libflann.so.1.9 libcurl-gnutls.so.4"
if [ "${3:-}" = scale ]; then
    loaded="$loaded libpq.so.5"
    mkdir -p "$root/etc/ssl/certs"
    cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs"
fi
for name in $loaded; do
    library=$(/sbin/ldconfig -p | awk -v name="$name" '$1 == name { print $NF; exit }')
    mkdir -p "$root$(dirname "$library")"
    cp -L "$library" "$root$library"
    ldd "$library"
done >"$root.ldd"
ldd "$binary" >>"$root.ldd"
awk '$2 == "=>" && $3 ~ /^\// { print $3 } $1 ~ /^\// { print $1 }' "$root.ldd" | while read -r library; do
    mkdir -p "$root$(dirname "$library")"
    cp -L "$library" "$root$library"
done
rm "$root.ldd"
objcopy --only-keep-debug "$binary" "$root.debug/voronoid.debug"
chmod 0644 "$root.debug/voronoid.debug"
objcopy --strip-unneeded --add-gnu-debuglink="$root.debug/voronoid.debug" "$binary" "$root/usr/bin/voronoid"
printf 'voronoid:x:65532:65532::/var/lib/voronoid:/sbin/nologin\n' >"$root/etc/passwd"
printf 'voronoid:x:65532:\n' >"$root/etc/group"
chmod 1777 "$root/tmp"
if [ "$(id -u)" = 0 ]; then
    chown 65532:65532 "$root/var/lib/voronoid"
fi
