#!/usr/bin/env bash
# Asks the program everything again and holds the answers against the frozen ones
# (tests/freeze): a change of the inside changes none of them. Four minutes on two cores.
#
#   tools/freeze.sh                      what differs, exit code 1 where something does
#   tools/freeze.sh --accept REASON      what differs is meant: tests/freeze/changes.txt
#   tools/freeze.sh --only scenarios,refusals,calibrations,imports,plans,studies,said
#   tools/freeze.sh --match WORD         only questions about that, a regular expression
#   tools/freeze.sh --keep FOLDER        keeps the answers themselves, to be compared
set -euo pipefail
cd "$(dirname "$0")/.."
exec python3 tools/freeze.py "${CALTWIN_BINARY:-build/caltwin}" "$@"
