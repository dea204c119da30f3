#!/usr/bin/env bash
# Builds and runs all tests; arguments go to ctest (test.sh -L unit, test.sh -R Rows).
# CALTWIN_BUILD_OPTIONS: further options for cmake.
set -euo pipefail
cd "$(dirname "$0")/.."

./tools/setup.sh
# shellcheck disable=SC2086  # Several options are meant to be split.
./tools/build.sh build ${CALTWIN_BUILD_OPTIONS:-}
exec ctest --test-dir build --output-on-failure -j "$(nproc)" "$@"
