# shellcheck shell=bash
# To be sourced: the daemon of the demo. Wants $voronoid, the binary, and $out, a folder for its log.

# Starts it on a free port and an empty folder; $url is where it listens.
start_daemon()
{
    data=$(mktemp -d)
    : >"$out/daemon.log" # here, not in the child: the log of an earlier demo must not be read
    "$voronoid" serve --listen 127.0.0.1:0 --data "$data" 2>>"$out/daemon.log" &
    daemon=$!
    trap 'stop_daemon || true' EXIT
    url=$(tests/demo/listening.sh "$out/daemon.log" "$daemon")
}

# Ends it and removes its folder; fails when it does not end well.
stop_daemon()
{
    local status=0
    trap - EXIT
    kill "$daemon" 2>/dev/null || true
    wait "$daemon" 2>/dev/null || status=$?
    rm -rf "$data"
    return "$status"
}
