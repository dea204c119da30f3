#!/usr/bin/env bash
# Runs the test of a client: run.sh NEEDS SCRIPT ARGUMENT... Exit code 77 where what it needs is
# not installed; where that is a Python, it runs the script.
set -euo pipefail
needs=$1
shift
[[ -e $needs ]] || { echo "$needs is not installed: tools/setup.sh --clients" && exit 77; }
case $needs in
  */python) exec "$needs" "$@" ;;
  *) exec /usr/bin/python3 "$@" ;;
esac
