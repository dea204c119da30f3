"""The shipped DELTA_CALIBRATE calibrates a delta with hidden errors: klipper_delta_test.py CALTWIN HOST fast|physics

The host is the real program, unmodified: `tools/setup.sh --controllers` installs it. What it saved is
compared with what was hidden. Without it: skipped.
"""

import re
import sys
from pathlib import Path

from klipper_host import Rig, main

DRAWN = {"delta_radius": 130.0, "angle_a": 210.0, "angle_b": 330.0,
         "endstop_a": 300.0, "endstop_b": 300.0, "endstop_c": 300.0}
HIDDEN = {"delta_radius": 0.8, "angle_a": 0.3, "angle_b": -0.25, "endstop_a": 0.3, "endstop_b": -0.4}
TRUTH = """effects:
  endstop.a: {error_mm: 0.3}
  endstop.b: {error_mm: -0.4}
  delta_radius: {error_mm: 0.8}
  tower_angle.a: {angle_deg: 0.3}
  tower_angle.b: {angle_deg: -0.25}
"""
MICROSTEPS = 64
STEP_mm = 40 / 200 / MICROSTEPS
# What seven touches of DELTA_CALIBRATE at a radius of 90 mm, each rounded by up to half a step in the
# worst way, do to each value: the sums of magnitudes of the pseudo-inverse of their Jacobian, in mm or
# deg per mm. An endstop is itself found to a step.
WORST_PER_mm = {"delta_radius": 6.3, "angle_a": 6.5, "angle_b": 6.5,
                "endstop_a": 3.4, "endstop_b": 3.4, "endstop_c": 3.4}
PLACES_mm = ((0, 0), (70, 0), (-35, 60), (-35, -60))


def machine_of(folder):
    """The delta printer with finer steps, and with an effector whose joints stand as its towers do: the
    angle of a tower is then what Klipper's formula means by it (docs/delta.md)."""
    root = Path(__file__).parent.parent.parent
    text = (root / "models/delta_printer/machine.yaml").read_text()
    text = text.replace("microsteps: 16", f"microsteps: {MICROSTEPS}")
    text = re.sub(r"^(effector_radius_mm|model):.*\n", "", text, flags=re.MULTILINE)
    file = folder / "machine.yaml"
    file.write_text(text)
    return file


def saved_by(rig):
    saved = rig.saved()
    options = {"delta_radius": ("printer", "delta_radius")}
    for tower in "ab":
        options[f"angle_{tower}"] = (f"stepper_{tower}", "angle")
    for tower in "abc":
        options[f"endstop_{tower}"] = (f"stepper_{tower}", "position_endstop")
    return {name: float(saved[place]) for name, place in options.items()}


def compare(saved):
    faults = []
    print(f"{'':14}{'built':>12}{'saved':>12}{'off by':>10}{'at most':>10}")
    for name, drawn in DRAWN.items():
        built = drawn + HIDDEN.get(name, 0)
        off = saved[name] - built
        limit = WORST_PER_mm[name] * STEP_mm / 2 + (STEP_mm if "endstop" in name else 0)
        print(f"{name:14}{built:12.4f}{saved[name]:12.4f}{off:10.4f}{limit:10.4f}")
        if abs(off) > limit:
            faults.append(f"{name}: saved {saved[name]}, built {built}")
    return faults


def run(caltwin, host, fidelity, folder):
    faults = []
    with Rig(caltwin, host, folder, machine_of(folder), TRUTH, ["--fidelity", fidelity]) as rig:
        rig.start_host()
        rig.connect()
        rig.say("G28")
        before = [rig.touch(x, y, 5) for x, y in PLACES_mm]
        spread = float(re.search(r"range ([\d.]+)", " ".join(rig.say("PROBE_ACCURACY"))).group(1))
        rig.say("DELTA_CALIBRATE", patience_s=200)
        rig.save_config()
        rig.say("G28")
        after = [rig.touch(x, y, 5) for x, y in PLACES_mm]
        faults += compare(saved_by(rig))
    print("the bed was met at", before, "and is at", after, "mm; ten touches differ by", spread)
    # Ten touches without scatter are one, but for where within a step the descent began.
    if spread > 2 * STEP_mm:
        faults.append(f"ten touches without scatter differ by {spread} mm")
    if max(map(abs, before)) < 0.2:
        faults.append("what was hidden did not act")
    if max(map(abs, after)) > 3 * STEP_mm:
        faults.append(f"the bed is met at {after} mm after calibrating")
    return faults


if __name__ == "__main__":
    sys.exit(main(__doc__, run))
