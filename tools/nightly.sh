#!/usr/bin/env bash
# What takes longer than a landing may: hours on two cores. Prints the time of each part and
# goes on where one fails; exit code 1 then.
#
#   tools/nightly.sh            all of it
#   tools/nightly.sh lint ...   the parts named: lint freeze homings web sanitizers controllers
#                               mutants bench fuzz
set -uo pipefail
cd "$(dirname "$0")/.."

parts=("$@")
[[ ${#parts[@]} -eq 0 ]] && parts=(lint freeze homings web sanitizers controllers mutants bench fuzz)
./tools/setup.sh clang-format-16 libclang-rt-16-dev python3-venv
./tools/build.sh build -DCALTWIN_WERROR=ON || exit 1

lint() { ./tools/lint.sh --all; }           # Every source.
freeze() { ./tools/freeze.sh; }             # Every frozen answer.
homings() {                                 # Ten thousand first homings, not a thousand.
  CALTWIN_ALL_HOMINGS=1 build/tests/scenarios_slow_tests \
    --gtest_filter=MotorFigures.FirstHomingsTakeOneTurn
}
web() { # Ten thousand requests of noise; the server against its document, longer.
  python3 tests/web/rest_test.py build/caltwin 10000 && tests/web/schemathesis.sh build/caltwin 300
}
sanitizers() { # What CI leaves out of its sanitizer run: a quarter of an hour.
  local program only code=0
  only=$(grep -v '^#' tests/long_unoptimised.txt | paste -sd ':')
  ./tools/sanitized.sh unit_tests || return 1
  for program in build-asan/tests/*_unit_tests build-asan/tests/blind/*_unit_tests; do
    "$program" --gtest_brief=1 --gtest_filter="$only" || code=1
  done
  return "$code"
}
controllers() { # Klipper's shipped host and LinuxCNC on the twin: in lock-step, and twelve minutes in real time.
  ./tools/setup.sh --controllers && CALTWIN_REPEATS=20 ctest --test-dir build -L controllers --output-on-failure
}
mutants() { ./tools/mutants.sh; }           # Each planted mistake has to turn a test red.
bench() { ./tools/bench.sh; }               # The figures of docs/performance.md.
fuzz() { ./tools/fuzz.sh 3600; }            # An hour, on from where the last one was.

failed=()
for part in "${parts[@]}"; do
  case $part in
    lint | freeze | homings | web | sanitizers | controllers | mutants | bench | fuzz) ;;
    *) sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0" >&2 && exit 2 ;;
  esac
  start=$SECONDS
  echo "== $part"
  "$part" || failed+=("$part")
  echo "== $part: $((SECONDS - start)) s"
done
[[ ${#failed[@]} -eq 0 ]] || { echo "nightly: failed at ${failed[*]}" && exit 1; }
