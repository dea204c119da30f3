"""Printers as people have them: klipper_configs_test.py CALTWIN HOST

Klipper 0.12 comes with the printer.cfg of more than a hundred printers. Each of a kind that caltwin has becomes a
machine and a printer.cfg on its pins (`caltwin new machine --from`), homes, and calibrates with what it has: a delta
finds its hidden radius. Ends with 77 where there is no host.
"""

import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SKIPPED = 77
KINDS = ("cartesian", "corexy", "delta")
# A belt without end: 20 km of Z.
NO_MACHINE = {"printer-creality-cr30-2021"}
# 256 microsteps: at the end of homing it stands a step beyond position_min, as the host then says.
BEYOND = {"printer-modix-big60-2020": "Move out of range"}
# A Z that has homed by its probe stands on it.
LIFTED = "G1 Z10 F600"
RADIUS_OFF_MM, RADIUS_WITHIN_MM = 0.8, 0.06
faults = []


def claim(holds, what):
    print(("ok  " if holds else "NOT ") + what, flush=True)
    if not holds:
        faults.append(what)


def has(text, section):
    return re.search(rf"(?m)^\[{section}\b", text) is not None


def line_for(text):
    levels = {"delta_calibrate": "DELTA_CALIBRATE", "quad_gantry_level": "QUAD_GANTRY_LEVEL",
              "z_tilt": "Z_TILT_ADJUST", "bed_mesh": "BED_MESH_CALIBRATE"}
    if not has(text, "probe"):
        return None
    return next((line for section, line in levels.items() if has(text, section)), "PROBE_ACCURACY")


def is_right(config, kind, line, said, code):
    if any(words in said for name, words in BEYOND.items() if name == config.stem):
        return True
    if code != 0 or kind != "delta" or line is None:
        return code == 0
    found = float(re.search(r"delta_radius: ([\d.]+)", said)[1])
    drawn = float(re.search(r"(?m)^delta_radius: *([\d.]+)", config.read_text())[1])
    return abs(found - drawn - RADIUS_OFF_MM) < RADIUS_WITHIN_MM


def printer(caltwin, host, folder, config):
    name = re.sub(r"[^a-z0-9]", "_", config.stem)
    made = subprocess.run([caltwin, "new", "machine", name, "--from", config], cwd=folder, capture_output=True, text=True,
                          timeout=60, check=False)
    if made.returncode != 0:
        return config, None, made.stderr.split("\n")[0], False
    text = (folder / f"models/{name}/printer.cfg").read_text()
    kind = re.search(r"kinematics: (\w+)", (folder / f"models/{name}/machine.yaml").read_text())[1]
    line = line_for(text)
    words = [caltwin, "klipper", name, "--config", f"models/{name}/printer.cfg", "--fidelity", "fast", "--host", host,
             "-c", "G28"]
    for one in (LIFTED, line) if line else ():
        words += ["-c", one]
    words += ["--truth", "hidden.yaml"] if kind == "delta" else []
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    said = done.stdout + done.stderr
    return config, is_right(config, kind, line, said, done.returncode), said[-300:], line is not None


def main(caltwin, host):
    configs = Path(host).parents[1] / "source/klippy/config"
    if not configs.exists():
        print(f"{configs} is not there: tools/setup.sh --controllers installs it")
        return SKIPPED
    files = sorted(file for pattern in ("printer-*.cfg", "kit-*.cfg", "example-*.cfg") for file in configs.glob(pattern))
    num = num_probed = 0
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(os.cpu_count()) as pool:
        folder = Path(name)
        (folder / "hidden.yaml").write_text(f"effects: {{delta_radius: {{error_mm: {RADIUS_OFF_MM}}}}}\n")
        for config, right, said, is_probed in pool.map(lambda file: printer(caltwin, host, folder, file), files):
            kinematics = re.search(r"(?m)^kinematics: *(\w+)", config.read_text())
            if not kinematics or kinematics[1] not in KINDS or config.stem in NO_MACHINE:
                claim(right is None, f"{config.stem}: refused")
                continue
            num += 1
            num_probed += is_probed
            claim(right is True, config.stem)
            if right is not True:
                print(said)
    claim(num > 100, f"{num} printers that Klipper comes with, {num_probed} with a probe")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
