#!/usr/bin/env bash
# install_test.sh BUILD: what `cmake --install` leaves runs from another folder and finds
# what it comes with beside it, not in the source tree.
set -euo pipefail
build=$(realpath "$1")
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix" >"$prefix/log"
cd /
share=$prefix/share/caltwin
"$prefix/bin/caltwin" validate "$share/models/delta_printer/machine.yaml" \
  "$share/scenarios/first_light.yaml"
"$prefix/bin/caltwin" run "$share/scenarios/z_offset_after_nozzle_and_plate_change.yaml" || {
  echo "the installed program does not pass a scenario that it comes with"
  exit 1
}
said=$("$prefix/bin/caltwin" calibrate --link twin:nowhere --procedure g33 2>&1) && exit 1
[[ $said == *"$share/models/nowhere/machine.yaml"* ]] || {
  echo "it looked elsewhere: $said"
  exit 1
}
[[ ! -e $share/scenarios/runner.cc && -e $prefix/share/doc/caltwin/README.md ]]
