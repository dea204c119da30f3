#!/usr/bin/env bash
# Fuzzes the readers, every target of tests/fuzz. A finding is written to
# build-asan/findings and fails; run it alone with build-asan/tests/fuzz/NAME_fuzz FILE.
#
#   tools/fuzz.sh [SECONDS]     searches on from where it was, SECONDS (60) for all targets
#   tools/fuzz.sh --runs N      N inputs a target, the same every time: whether something
#                               lands does not hang on chance (CI)
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=60 runs=0
if [[ ${1:-} == --runs ]]; then
  runs=$2
else
  seconds=${1:-$seconds}
fi
./tools/sanitized.sh fuzzers
jobs=$(nproc)
targets=(tests/fuzz/*_fuzz.cc)
each=$(((seconds * jobs + ${#targets[@]} - 1) / ${#targets[@]}))
budget="-max_total_time=$each"
corpus=build-asan/corpus
if [[ $runs -gt 0 ]]; then
  # Without the corpus weighed, which takes half of the time.
  budget="-runs=$runs -seed=1 -entropic=0"
  corpus=$(mktemp -d)
  trap 'rm -rf "$corpus"' EXIT
fi
mkdir -p build-asan/findings

# fuzz_one NAME: one target; what it printed where something was found.
fuzz_one() {
  local name=$1 start=$SECONDS log inputs code=0
  log=$(mktemp)
  mkdir -p "$corpus/$name"
  # shellcheck disable=SC2086  # Two options are meant to be split.
  if "build-asan/tests/fuzz/${name}_fuzz" $budget -timeout=10 -rss_limit_mb=2048 \
    -max_len=8192 -print_final_stats=1 -artifact_prefix=build-asan/findings/ \
    "$corpus/$name" "tests/fuzz/corpus/$name" >"$log" 2>&1; then
    inputs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    echo "fuzz: $name: $inputs inputs in $((SECONDS - start)) s, nothing found"
  else
    code=1
    tail -n 60 "$log" >&2
    echo "fuzz: $name: FOUND something, see build-asan/findings" >&2
  fi
  rm "$log"
  return "$code"
}
export -f fuzz_one
export budget corpus
printf '%s\n' "${targets[@]}" | sed 's|.*/||; s|_fuzz\.cc$||' |
  xargs -P "$jobs" -I {} bash -c 'fuzz_one {}'
