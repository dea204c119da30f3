#!/usr/bin/env bash
# Runs the tests against every planted mistake (sim/base/mutant.h) and writes the table
# of docs/mutants.md: each must turn at least one test red.
#
#   tools/mutants.sh             all of them
#   tools/mutants.sh NAME...     only these; the table is not written
set -euo pipefail
cd "$(dirname "$0")/.."
build=${CALTWIN_MUTANTS_BUILD:-build-mutants}
tools/setup.sh
echo "mutants: building the mistakes into $build"
cmake -S . -B "$build" -G Ninja -DCALTWIN_MUTANTS=ON >/dev/null
ninja -C "$build" >/dev/null

# NAME<TAB>FILE of every mutant in the sources, once each.
list() {
  git ls-files sim calibration scenarios | xargs cat | tr '\n' ' ' |
    grep -oE 'Mutant(<[^>]*>)?\(\s*"[a-z0-9_]+"' | sed -E 's/.*"([a-z0-9_]+)".*/\1/' | sort -u
}
where() { git grep -lE "\"$1\"" -- sim calibration scenarios | head -n 1; }

# The first test that fails under the mutant, unit tests first; empty: it survives.
killer() {
  local program out failed
  # A folder each: tests of two mutants at the same time must not meet.
  local -x TEST_TMPDIR
  TEST_TMPDIR=$(mktemp -d)
  for program in "$build"/tests/*_unit_tests "$build"/tests/*_slow_tests; do
    out=$(CALTWIN_MUTANT=$1 timeout 120 "$program" --gtest_fail_fast 2>&1) && continue
    failed=$(sed -nE 's/^\[  FAILED  \] ([^ ,]+).*/\1/p' <<<"$out" | head -n 1)
    echo "${failed:-$(basename "$program") stops}"
    break
  done
  rm -rf "$TEST_TMPDIR"
}
row() {
  local by
  by=$(killer "$1")
  printf '| `%s` | `%s` | %s |\n' "$1" "$(where "$1")" "${by:-**survives**}"
}
export -f killer row where
export build

names=("$@")
[ ${#names[@]} -gt 0 ] || mapfile -t names < <(list)
if [ -n "$(killer '')" ]; then
  echo "mutants: the tests fail without any mutant; mend that first" >&2
  exit 1
fi
table=$(mktemp)
printf '%s\n' "${names[@]}" | xargs -P "$(nproc)" -I{} bash -c 'row {}' | tee "$table"
sort -o "$table" "$table"
survivors=$(grep -c 'survives' "$table" || true)
if [ $# -eq 0 ]; then
  {
    echo '# Mutants'
    echo
    echo 'Mistakes planted in the sources, built only with `-DCALTWIN_MUTANTS=ON`. Each must turn at'
    echo 'least one test red; the last column names the first that does. Made by `tools/mutants.sh`.'
    echo
    echo "${#names[@]} mutants, $survivors survive."
    echo
    echo '| mutant | planted in | killed by |'
    echo '|---|---|---|'
    cat "$table"
  } >docs/mutants.md
fi
rm -f "$table"
echo "mutants: ${#names[@]} planted, $survivors survive"
[ "$survivors" -eq 0 ]
