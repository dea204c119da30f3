#!/usr/bin/env bash
# The main job, from an empty clone: a simulated CNC router with hidden errors is
# calibrated over G-code until the engine has recovered what was injected; then a real
# axis is diagnosed. Builds the program alone: tools/test.sh builds the tests.
set -euo pipefail
cd "$(dirname "$0")/.."

./tools/setup.sh
echo "The program is built once, which takes about four minutes on two cores."
./tools/build.sh build -- caltwin
echo "run: build/caltwin run scenarios/first_light.yaml --report out/first_light"
build/caltwin run scenarios/first_light.yaml --report out/first_light
report=$(find out/first_light -name '*.html' | sort | head -n 1)
echo "The report is ${report:-out/first_light}: open it in a browser."

echo
echo "The same question on a real machine: a linear axis of a test stand, measured by others."
echo "run: build/caltwin diagnose tests/data/iso230/ess_target_x_2022-04.csv --report out/real_axis"
build/caltwin diagnose tests/data/iso230/ess_target_x_2022-04.csv --report out/real_axis
echo
echo "In a browser: tools/pages.sh, then build/caltwin serve --http 8080"
echo "This took $((SECONDS / 60)) min $((SECONDS % 60)) s."
