#!/usr/bin/env bash
# Fuzzes the readers: fuzz.sh [SECONDS], shared among the targets of tests/fuzz. A
# finding is written to build-fuzz/findings and fails; run it alone with
# build-fuzz/NAME_fuzz FILE.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-60}
options=(-DCMAKE_CXX_COMPILER=clang++-16)
command -v ccache >/dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { cmake -S tests/fuzz -B build-fuzz -G Ninja "${options[@]}" &&
  ninja -C build-fuzz; } >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi

targets=(tests/fuzz/*_fuzz.cc)
each=$(((seconds + ${#targets[@]} - 1) / ${#targets[@]}))
mkdir -p build-fuzz/findings
failed=0
for source in "${targets[@]}"; do
  name=$(basename "$source" _fuzz.cc)
  mkdir -p "build-fuzz/corpus/$name"
  if "build-fuzz/${name}_fuzz" -max_total_time="$each" -timeout=10 -rss_limit_mb=2048 \
    -max_len=8192 -print_final_stats=1 -artifact_prefix=build-fuzz/findings/ \
    "build-fuzz/corpus/$name" "tests/fuzz/corpus/$name" >"$log" 2>&1; then
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    echo "fuzz: $name: $runs inputs in $each s, nothing found"
  else
    failed=$((failed + 1))
    tail -n 60 "$log" >&2
    echo "fuzz: $name: FOUND something, see build-fuzz/findings" >&2
  fi
done
[[ $failed -eq 0 ]]
