#!/usr/bin/env python3
"""Klipper's host 0.12, started from its source, which lies in `source` beside the folder of this file.

Its package does not say where two of its modules are: "from . import stepper" in kinematics/cartesian.py, "import
chelper" in kinematics/idex_modes.py. They are named here; nothing of Klipper is changed. tools/setup.sh installs this.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "source"))

from klippy import chelper, kinematics, stepper  # noqa: E402
from klippy.klippy import main  # noqa: E402

sys.modules["chelper"] = chelper
kinematics.stepper = stepper
main()
