"""The shipped CALIBRATE_Z is misled by a switch_offset that is not the probe's: klipper_z_station_test.py CALTWIN HOST fast|physics

As klipper_delta_test.py.
"""

import sys

from klipper_host import Rig, main

OFF_mm = 0.08
STEP_mm = 4 / 12800


def offset_found(caltwin, host, fidelity, folder, truth):
    folder.mkdir()
    with Rig(caltwin, host, folder, "z_station", truth, ["--fidelity", fidelity]) as rig:
        rig.start_host()
        rig.connect()
        rig.say("G28")
        rig.say("CALIBRATE_Z", patience_s=200)
        return rig.status("z_calibration")["last_z_offset"]


def run(caltwin, host, fidelity, folder):
    drawn = offset_found(caltwin, host, fidelity, folder / "drawn", "effects: {}\n")
    wrong = offset_found(caltwin, host, fidelity, folder / "wrong",
                         f"effects: {{switch_offset: {{off_um: {1e3 * OFF_mm}}}}}\n")
    print(f"offset of the machine as drawn {drawn}, of the other {wrong} mm")
    # Three readings, each to a step: offset = probe - (body - nozzle + switch_offset).
    faults = []
    if abs(drawn) > 3 * STEP_mm:
        faults.append(f"the machine as drawn needs no offset, found {drawn} mm")
    # The probe triggers so much higher than the host believes; the nozzle would print as much too high.
    if abs(wrong - OFF_mm) > 3 * STEP_mm:
        faults.append(f"built {OFF_mm} mm, found {wrong}")
    return faults


if __name__ == "__main__":
    sys.exit(main(__doc__, run))
