#!/usr/bin/env bash
# Runs the tests against every planted mistake (tests/mutants.yaml) and writes the table
# of docs/mutants.md: each must turn at least one test red. The mistakes are planted into a
# copy of the tree, as choices at run time, and the copy is built once.
#
#   tools/mutants.sh             all of them: a night's work
#   tools/mutants.sh NAME...     only these; the table is not written
#   tools/mutants.sh --check     every entry still fits its file (CI)
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh python3-yaml
export PATH=/usr/bin:$PATH # Debian's python3, which has python3-yaml.
if [[ ${1:-} == --check ]]; then exec python3 tools/mutants.py check; fi
copy=$PWD/${CALTWIN_MUTANTS_BUILD:-build-mutants}
build=$copy/build
python3 tools/mutants.py plant "$copy"
ln -sfn "$PWD/third_party" "$copy/third_party"
echo "mutants: building the mistakes into $build"
(cd "$copy" && tools/build.sh "$build")

# NAME<TAB>FILE of every mutant, once each.
list() { python3 tools/mutants.py list | cut -f 1; }
where() { python3 tools/mutants.py list | sed -nE "s/^$1\t//p"; }

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
    echo 'Mistakes planted into a copy of the sources (tests/mutants.yaml). Each must turn at'
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
