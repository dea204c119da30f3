"""examples/oracle_delta.py, kinematics and fit of its own, scored by `caltwin oracle`.

    oracle_test.py CALTWIN
"""

import json
import pathlib
import subprocess
import sys
import tempfile

example = pathlib.Path(__file__).parents[2] / "examples/oracle_delta.py"
with tempfile.TemporaryDirectory() as folder:
    scores = pathlib.Path(folder, "scores.json")
    subprocess.run([sys.argv[1], "oracle", "--machines", "30", "--json", scores, "--",
                    sys.executable, example], check=True, timeout=100)
    told = json.loads(scores.read_text())
# What RepRapFirmware's least squares reaches on the same touches is 15 um.
assert told["scored"] == 30 and told["left_worse"] == 0, told
assert told["z_rms_um"]["median"] < 20, told["z_rms_um"]
