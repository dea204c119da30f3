"""The shipped Z_TILT_ADJUST levels a bed on three screws: klipper_triple_z_test.py CALTWIN HOST fast|physics

As klipper_delta_test.py.
"""

import sys

from klipper_host import Rig, main

TRUTH = "effects: {bed_tilt: {slope_x_mrad: 6, slope_y_mrad: -3}}\n"
STEP_mm = 4 / 3200
PLACES_mm = ((30, 30), (200, 30), (30, 200), (200, 200))


def run(caltwin, host, fidelity, folder):
    with Rig(caltwin, host, folder, "triple_z_printer", TRUTH, ["--fidelity", fidelity]) as rig:
        rig.start_host()
        rig.connect()
        rig.say("G28")
        before = [rig.touch(x, y, 8) for x, y in PLACES_mm]
        rig.say("Z_TILT_ADJUST", patience_s=200)
        after = [rig.touch(x, y, 8) for x, y in PLACES_mm]
    print("the bed was met at", before, "and is at", after, "mm")
    faults = []
    # 6 mrad over 170 mm, -3 mrad over 170 mm: as drawn, the screws' switches alike.
    tilt_mm = ((before[1] - before[0]) / 170 * 1e3, (before[2] - before[0]) / 170 * 1e3)
    if abs(tilt_mm[0] - 6) > 0.05 or abs(tilt_mm[1] + 3) > 0.05:
        faults.append(f"the bed was met with slopes of {tilt_mm} mrad")
    # Each screw to a step; between and a little beyond them three times as much at most.
    if max(after) - min(after) > 3 * STEP_mm:
        faults.append(f"the bed is met at {after} mm after levelling")
    return faults


if __name__ == "__main__":
    sys.exit(main(__doc__, run))
