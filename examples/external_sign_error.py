"""The same as external_calibration.py with one planted mistake: the correction of
steps/mm is applied with the wrong sign. Nothing that the program itself prints tells;
the trial in external_sign_error.yaml does.
"""
import re
import sys

import numpy as np


def send(line):
    print(line, flush=True)
    answer = []
    while (text := sys.stdin.readline()) != "ok\n":
        if not text or text.startswith("Error"):
            sys.exit(f"{line}: {text or 'the machine is gone'}")
        answer.append(text)
    return "".join(answer)


def touch_steps(axis, start_mm):
    for line in (f"G0 {axis}{start_mm}", "G0 Z12", f"G38.2 {axis}150 F60"):
        send(line)
    counts = re.search(r"Count (-?\d+) (-?\d+)", send("M114"))
    for line in (f"G0 {axis}{start_mm}", "G0 Z100"):
        send(line)
    return int(counts.group("XY".index(axis) + 1))


def fit_steps_per_mm(axis):
    sizes_mm, spans = [25.4, 50.8, 76.2] * 5, []
    for size_mm in sizes_mm:
        send(f"M118 OPERATOR turn block {size_mm} along {axis.lower()}")
        low, high = (touch_steps(axis, 150 + side * (size_mm / 2 + 10)) for side in (-1, 1))
        spans.append(high - low)
    (steps_per_mm, _), covariance = np.polyfit(sizes_mm, spans, 1, cov=True)
    sd = np.hypot(np.sqrt(covariance[0, 0]), 0.01)  # At least what whole steps leave.
    send(f"M118 ESTIMATE steps_per_mm.{axis.lower()} {steps_per_mm:.4f} {sd:.4f}")
    return steps_per_mm


def reading_mm(axis, start_mm):
    send(f"G0 {axis}{start_mm}")
    send(f"G0 {axis}150")
    return float(send(f"M118 GAUGE laser.{axis.lower()}").split()[2])


send("G28")
for axis in "XY":
    send("G0 X150 Y150 Z100")
    configured = float(re.search(axis + r": ([\d.]+)", send("M92")).group(1))
    correction = fit_steps_per_mm(axis) - configured
    send(f"M92 {axis}{configured - correction:.4f}")  # The mistake: it is a plus.
    send("G0 X150 Y150 Z100")
    gaps_mm = [reading_mm(axis, 160) - reading_mm(axis, 140) for _ in range(5)]
    send(f"M425 {axis}{np.mean(gaps_mm):.4f}")
    sd_mm = max(np.std(gaps_mm, ddof=1) / np.sqrt(5), 1e-4)
    send(f"M118 ESTIMATE backlash.{axis.lower()} {np.mean(gaps_mm):.4f} {sd_mm:.5f}")
