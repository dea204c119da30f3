#!/usr/bin/env bash
# A Python for the cluster driver, in build/cluster: tools/cluster/setup.sh [FOLDER]
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=${1:-build/cluster}
python3 -m venv "$folder"
"$folder/bin/pip" install --quiet --requirement tools/cluster/requirements.txt
echo "$folder/bin/python tools/cluster/study.py --help"
