#!/usr/bin/env bash
# Builds TARGET... with clang's sanitizers of addresses and undefined behaviour into
# build-asan: sanitized.sh unit_tests, sanitized.sh fuzzers. Unoptimised, which compiles
# faster, but for the readers, which both share.
set -euo pipefail
cd "$(dirname "$0")/.."

exec ./tools/build.sh build-asan -DCMAKE_CXX_COMPILER=clang++-16 \
  -DCALTWIN_SANITIZE=address,undefined -DCALTWIN_FUZZ=ON -DCMAKE_BUILD_TYPE=None \
  -DCMAKE_CXX_FLAGS=-O0 -- "$@"
