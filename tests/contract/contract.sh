#!/bin/bash
# usage: contract.sh VORONOID FOLDER: openapi.yaml before other people's programs, which npm installs into FOLDER.
# redocly and spectral have neither errors nor warnings to tell; the types that openapi-typescript makes compile with
# client.ts, which then talks to a daemon of its own; the page's own scripts keep to the types they say. Only npm needs the
# network, the first time.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
voronoid=$(realpath "$1")
contract=$(realpath "$here/../../openapi.yaml")
mkdir -p "$2"
cd "$2"
find "$here" -maxdepth 1 -type f -exec cp -p {} . \;

if grep -q '"resolved"' package-lock.json; then
    echo "make contract: package-lock.json has addresses of a registry; make it with --omit-lockfile-registry-resolved" >&2
    exit 1
fi
if ! cmp -s package-lock.json node_modules/.installed; then
    if ! npm ci --ignore-scripts --no-audit --no-fund --no-update-notifier --prefer-offline --fetch-retries=1 \
        --fetch-retry-mintimeout=2000 --loglevel=error >npm.log 2>&1; then
        echo "make contract: npm cannot install what tests/contract/package-lock.json lists:" \
            "$(grep -m 1 -E 'npm (ERR!|error)' npm.log || tail -n 1 npm.log)" >&2
        exit 1
    fi
    cp package-lock.json node_modules/.installed
fi
export REDOCLY_TELEMETRY=off REDOCLY_SUPPRESS_UPDATE_NOTICE=true NO_UPDATE_NOTIFIER=1
bin=node_modules/.bin

echo "== redocly"
"$bin/redocly" lint --config redocly.yaml --format stylish --max-problems 1000 "$contract" 2>&1 | tee redocly.log
if grep -qE '[1-9][0-9]* (error|warning)' redocly.log; then # a warning alone leaves the status 0
    exit 1
fi

echo "== spectral, with OWASP's rules"
exceptions=$(grep -c ': "off"$' spectral.yaml)
if [ "$exceptions" -gt 12 ]; then
    echo "make contract: spectral.yaml has $exceptions exceptions, want at most 12" >&2
    exit 1
fi
"$bin/spectral" lint --ruleset spectral.yaml --fail-severity hint "$contract"

echo "== openapi-typescript, and its types by tsc"
"$bin/openapi-typescript" "$contract" --output openapi.d.ts
"$bin/tsc" --project .

echo "== tsc over the page"
"$bin/tsc" --project page.json

echo "== client.ts and a daemon"
rm -rf data
: >daemon.log
"$voronoid" serve --listen 127.0.0.1:0 --data data >daemon.out 2>daemon.log &
daemon=$!
trap 'kill "$daemon"' EXIT
url=$("$here/../demo/listening.sh" daemon.log "$daemon")
node client.js "$url"

# Tests of our results with packages that stand in package.json.
mapfile -t tests < <(find "$here" -maxdepth 1 -name '*.t')
if [ "${#tests[@]}" -gt 0 ]; then
    folder=$PWD
    cd "$here/../.."
    CONTRACT=$folder VORONOID=$voronoid prove "${tests[@]}"
fi
