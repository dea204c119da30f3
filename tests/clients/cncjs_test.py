"""Starts the twin for cncjs_test.mjs: cncjs_test.py CALTWIN FOLDER_OF_NODE_MODULES"""

import pathlib
import subprocess
import sys

from served import Served

own = pathlib.Path(__file__).parents[2] / "third_party/node/bin/node"  # tools/pages.sh fetches it.
with Served(sys.argv[1], "--machine", "gantry_router", "--dialect", "grbl", "--fidelity",
            "fast", "--speed", "60") as served:
    script = pathlib.Path(__file__).with_suffix(".mjs")
    subprocess.run([own if own.exists() else "node", script,
                    pathlib.Path(sys.argv[2]).resolve(), served.terminal], check=True, timeout=120)
