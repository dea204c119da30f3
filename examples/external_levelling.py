"""Levels a bed on three screws by its own plane: touch, fit, raise each screw, touch again."""

import sys

import numpy as np

SCREWS = np.array([[20, 20], [215, 20], [20, 215]])
POINTS = [(x, y) for y in (20, 117.5, 215) for x in (20, 117.5, 215)]


def send(line):
    print(line, flush=True)
    answer = []
    while (text := sys.stdin.readline()) != "ok\n":
        if not text or text.startswith("Error"):
            sys.exit(f"{line}: {text or 'the machine is gone'}")
        answer.append(text)
    return "".join(answer)


def plane():
    """a, b, c of z = a x + b y + c over the points."""
    heights = [float(send(f"G30 X{x} Y{y} S-1").split("height")[1].split("mm")[0]) for x, y in POINTS]
    design = np.array([[x, y, 1] for x, y in POINTS])
    return np.linalg.lstsq(design, np.array(heights), rcond=None)[0]


send("G28")
before = plane()
for _ in range(2):
    raise_mm = -(SCREWS @ plane()[:2] + plane()[2])
    z = float(send("M114").split("Z:")[1].split()[0])
    send("M584 Z0 U1 V2 P5")
    send(f"G92 U{z:.4f} V{z:.4f}")  # New axes are not homed, and stand anywhere.
    send("G1 Z{:.4f} U{:.4f} V{:.4f}".format(*(z - raise_mm)))
    send("M400")
    send(f"G92 Z{z:.4f} U{z:.4f} V{z:.4f}")
    send("M584 Z0:1:2 P3")
for name, slope in (("x", before[0]), ("y", before[1])):
    print(f"M118 ESTIMATE bed_tilt.slope_{name}_mrad {1e3 * slope:.4f} 0.05", flush=True)
    sys.stdin.readline()
