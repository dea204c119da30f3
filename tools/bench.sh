#!/usr/bin/env bash
# Measures speed, all of it: tools/bench.sh
# Or some: tools/bench.sh [options of Google Benchmark, e.g. --benchmark_filter=Touch]
# Without options, after the benchmarks: studies with one worker and two by the wall clock
# (tools/scaling.py), what studies cost (tools/study_cost.py), and memory of a run and of one
# with its report.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh
cmake -S . -B build -G Ninja >/dev/null
ninja -C build twin_bench caltwin >/dev/null
build/tests/twin_bench "$@"
if [ $# -gt 0 ]; then exit; fi
tools/scaling.py
tools/study_cost.py
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for options in "" "--report $out/report"; do
  # shellcheck disable=SC2086
  python3 - $options <<'PY'
import os, subprocess, sys
run = subprocess.Popen(["build/caltwin", "run", "scenarios/first_light.yaml", *sys.argv[1:]],
                       stdout=subprocess.DEVNULL)
usage = os.wait4(run.pid, 0)[2]
print(f"run {' '.join(sys.argv[1:2])}: {usage.ru_utime + usage.ru_stime:.2f} s of CPU, "
      f"{usage.ru_maxrss / 1024:.0f} MB at most")
PY
done
