#!/usr/bin/env bash
# Measures speed: tools/bench.sh [options of Google Benchmark, e.g. --benchmark_filter=Touch]
set -euo pipefail
cd "$(dirname "$0")/.."
tools/setup.sh
cmake -S . -B build -G Ninja >/dev/null
ninja -C build twin_bench >/dev/null
exec build/tests/twin_bench "$@"
