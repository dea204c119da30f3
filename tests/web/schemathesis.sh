#!/usr/bin/env bash
# Holds the server against docs/openapi.json: schemathesis.sh CALTWIN [EXAMPLES], stateful too.
# Its packages come from the Python index, by hash, into build/schemathesis.
set -euo pipefail
program=$(realpath "$1")
examples=${2:-20}
cd "$(dirname "$0")/../.."

venv=build/schemathesis
if [[ ! -x $venv/bin/schemathesis ]]; then
  python3 -m venv "$venv"
  "$venv/bin/pip" install --quiet --disable-pip-version-check --require-hashes \
    -r tests/web/schemathesis_requirements.txt
fi
state=$(mktemp -d)
log=$(mktemp)
"$program" serve --http 0 --fidelity fast --state "$state" >"$log" &
server=$!
trap 'kill -INT "$server" 2>/dev/null; wait "$server" || true; rm -rf "$state" "$log"' EXIT
for _ in $(seq 100); do
  url=$(sed -n 's/^open \(http[^ ]*\) .*/\1/p' "$log")
  [[ -n $url ]] && break
  sleep 0.1
done
cd tests/web
"../../$venv/bin/schemathesis" --config-file schemathesis.toml run "${url}api/openapi.json" \
  --exclude-path /api/events --max-examples "$examples" --request-timeout 60 --workers 1 --seed 1 \
  --generation-database none --no-color
