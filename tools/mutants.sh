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

# The first test that fails under the mutant, cheapest tests first; empty: it survives.
killer() {
  local label
  for label in unit slow; do
    CALTWIN_MUTANT=$1 ctest --test-dir "$build" -L "$label" -j2 --stop-on-failure 2>/dev/null |
      sed -nE 's/^[[:space:]]*[0-9]+ - ([^ ]+).*(Failed|Timeout|SEGFAULT|Exception|Subprocess aborted).*/\1/p' |
      head -n 1 | grep . && return 0
  done
  return 0
}

names=("$@")
[ ${#names[@]} -gt 0 ] || mapfile -t names < <(list)
if ! CALTWIN_MUTANT='' ctest --test-dir "$build" -j2 >/dev/null; then
  echo "mutants: the tests fail without any mutant; mend that first" >&2
  exit 1
fi
table=$(mktemp)
survivors=0
for name in "${names[@]}"; do
  by=$(killer "$name")
  if [ -z "$by" ]; then
    survivors=$((survivors + 1))
    by='**survives**'
  fi
  printf '| `%s` | `%s` | %s |\n' "$name" "$(where "$name")" "$by" | tee -a "$table"
done
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
