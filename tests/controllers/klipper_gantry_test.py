"""The shipped BED_MESH_CALIBRATE finds a table that leans and a gap in Z: klipper_gantry_test.py CALTWIN HOST fast

As klipper_delta_test.py.
"""

import sys

from klipper_host import Rig, main

TRUTH = "effects: {bed_tilt: {slope_x_mrad: 2, slope_y_mrad: -1}, backlash.z: {gap_mm: 0.05}}\n"
STEP_mm = 4 / 3200


def run(caltwin, host, fidelity, folder):
    with Rig(caltwin, host, folder, "gantry_router", TRUTH, ["--fidelity", fidelity]) as rig:
        rig.start_host()
        rig.connect()
        rig.say("G28", patience_s=200)
        rig.say("BED_MESH_CALIBRATE", patience_s=250)
        mesh = rig.status("bed_mesh")
    heights = mesh["probed_matrix"]
    print(mesh["mesh_min"], mesh["mesh_max"], *heights, sep="\n")
    faults = []
    # The axes' ends are at 0 and 300, the mesh from 30 to 270. It homes upwards and touches downwards, so
    # the gap of Z has the host believe it lower by as much; the table turns about its middle.
    for row, y_mm in enumerate((30, 90, 150, 210, 270)):
        for column, x_mm in enumerate((30, 90, 150, 210, 270)):
            built_mm = 2e-3 * (x_mm - 150) - 1e-3 * (y_mm - 150) - 0.05
            if abs(heights[row][column] - built_mm) > 2 * STEP_mm:
                faults.append(f"({x_mm}, {y_mm}): met at {heights[row][column]}, built {built_mm:.4f} mm")
    return faults


if __name__ == "__main__":
    sys.exit(main(__doc__, run))
