#!/usr/bin/env bash
# Builds into a folder: build.sh FOLDER [CMAKE_OPTION...] [-- TARGET...]. One line, unless
# it fails or takes long enough for a progress line to be of use.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$1
shift
options=() targets=()
while [[ $# -gt 0 && $1 != -- ]]; do
  options+=("$1")
  shift
done
[[ $# -gt 0 ]] && targets=("${@:2}")
command -v ccache >/dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

echo "build: $folder"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! cmake -S . -B "$folder" -G Ninja "${options[@]}" >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
if [[ -t 1 ]]; then
  ninja -C "$folder" "${targets[@]}"
elif ! ninja -C "$folder" "${targets[@]}" >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
