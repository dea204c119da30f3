#!/usr/bin/env bash
# A small set of one kind, drawn and judged: check.sh PYTHON PROGRAM KIND MOST_ALARMS LEAST_NAMED
set -euo pipefail
python=$1 program=$2 kind=$3 alarms=$4 named=$5
here=$(dirname "$0")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$python" "$here/generate.py" --kind "$kind" --nulls 20 --causes 20 --seed 31 --out "$folder"
"$python" "$here/score.py" "$folder" --caltwin "$program" --jobs 2 \
  --max-refused 0 --max-alarms "$alarms" --min-named "$named"
