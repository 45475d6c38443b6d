#!/bin/bash
# usage: listening.sh LOG PID: waits until the daemon of that process says in its log where it listens, and prints the
# URL. Fails with the log when the daemon ends before that, or does not say so within a minute.
# LOG must be there, and empty, before the daemon starts: else an old one, or none, would be read.
set -euo pipefail
log=$1
pid=$2
for _ in $(seq 600); do
    url=$(sed -n 's/.*"msg":"listening","address":"\([^"]*\)".*/http:\/\/\1/p' "$log" | head -n 1)
    if [ -n "$url" ]; then
        echo "$url"
        exit 0
    fi
    kill -0 "$pid" 2>/dev/null || break
    sleep 0.1
done
echo "the daemon did not start:" >&2
cat "$log" >&2
exit 1
