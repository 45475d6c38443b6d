#!/bin/sh
# usage: rootfs.sh BINARY FOLDER: makes FOLDER a root file system that holds the binary, the libraries it loads and
# nothing else but the user it runs as, an empty state folder and /tmp. No certificates: the daemon calls nobody. The binary is
# stripped; FOLDER.debug/voronoid.debug has its symbols, for a debugger.
set -eu
binary=$1
root=$2
rm -rf "$root" "$root.debug"
mkdir -p "$root/usr/bin" "$root/etc" "$root/tmp" "$root/var/lib/voronoid" "$root.debug"
# libcurl is loaded by `voronoid health` and --server alone.
curl=$(/sbin/ldconfig -p | awk '$1 == "libcurl-gnutls.so.4" { print $NF; exit }')
mkdir -p "$root$(dirname "$curl")"
cp -L "$curl" "$root$curl"
{ ldd "$binary" && ldd "$curl"; } | awk '$2 == "=>" && $3 ~ /^\// { print $3 } $1 ~ /^\// { print $1 }' | while read -r library; do
    mkdir -p "$root$(dirname "$library")"
    cp -L "$library" "$root$library"
done
objcopy --only-keep-debug "$binary" "$root.debug/voronoid.debug"
chmod 0644 "$root.debug/voronoid.debug"
objcopy --strip-unneeded --add-gnu-debuglink="$root.debug/voronoid.debug" "$binary" "$root/usr/bin/voronoid"
printf 'voronoid:x:65532:65532::/var/lib/voronoid:/sbin/nologin\n' >"$root/etc/passwd"
printf 'voronoid:x:65532:\n' >"$root/etc/group"
chmod 1777 "$root/tmp"
if [ "$(id -u)" = 0 ]; then
    chown 65532:65532 "$root/var/lib/voronoid"
fi
