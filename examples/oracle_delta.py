"""Calibrates deltas with SciPy: caltwin oracle -- python3 examples/oracle_delta.py

Sixteen touches of each; endstops, radius and the angles of two towers are fitted to them.
"""
import json
import sys

import numpy as np
from scipy.optimize import least_squares


def ask(**words):
    print(json.dumps(words), flush=True)
    return json.loads(sys.stdin.readline())


def towers(endstop, radius, angle, arm, at):
    """How far down each carriage has come with the nozzle at `at`, an (n, 3) array."""
    joint = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    beside = np.linalg.norm(joint[None] - at[:, None, :2], axis=2)
    carriage = at[:, 2:] + np.sqrt(arm**2 - beside**2)
    return endstop + np.sqrt(arm**2 - radius**2) - carriage


def calibrate(machine):
    g = {key: np.array(value, float) for key, value in machine["geometry"].items()}
    drawn = (g["endstop_mm"], g["radius_mm"], np.radians(g["angle_deg"]), g["arm_mm"])
    rings = [(0, 1), (0.45 * machine["radius_mm"], 6), (0.95 * machine["radius_mm"], 9)]
    places = [(r * np.cos(2 * np.pi * k / n), r * np.sin(2 * np.pi * k / n)) for r, n in rings for k in range(n)]
    touched = np.array([(x, y, ask(ask="probe", x=x, y=y)["z"]) for x, y in places])
    moved = towers(*drawn, touched)  # What the motors did, whatever the geometry is.

    def geometry(p):
        return drawn[0] + p[:3], drawn[1] + p[3], drawn[2] + np.array([p[4], p[5], 0]), drawn[3]

    def heights(p):  # A flat bed at 0: in the right geometry those motors stand on it.
        at, model = touched.copy(), geometry(p)
        for _ in range(6):  # Newton: where the nozzle is with these motors.
            wrong, slope = towers(*model, at) - moved, np.empty((len(at), 3, 3))
            for k in range(3):
                step = at + 1e-4 * np.eye(3)[k]
                slope[:, :, k] = (towers(*model, step) - moved - wrong) / 1e-4
            at = at - np.linalg.solve(slope, wrong[:, :, None])[:, :, 0]
        return at[:, 2]

    endstop, radius, angle, arm = geometry(least_squares(heights, np.zeros(6), x_scale=[1, 1, 1, 1, 0.01, 0.01]).x)
    return {"endstop_mm": list(endstop), "radius_mm": list(radius), "angle_deg": list(np.degrees(angle)), "arm_mm": list(arm)}


while "machine" in (machine := ask(ask="machine")):
    ask(ask="done", geometry=calibrate(machine))
