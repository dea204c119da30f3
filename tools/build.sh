#!/usr/bin/env bash
# Builds into a folder: build.sh FOLDER [CMAKE_OPTION...]. One line, unless it fails or
# takes long enough for a progress line to be of use.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$1
shift
options=("$@")
command -v ccache >/dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

echo "build: $folder"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! cmake -S . -B "$folder" -G Ninja "${options[@]}" >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
if [[ -t 1 ]]; then
  ninja -C "$folder"
elif ! ninja -C "$folder" >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
