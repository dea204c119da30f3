#!/usr/bin/env python3
"""How LinuxCNC's probing scatters with feed and servo period, against the plant's truth.

    probing_scatter.py CALTWIN [--touches 25]

A gantry as drawn is touched from ever other heights; the truth is 0.98 mm. What G38 records is the place in the
servo cycle that sees the probe, so between 0 and v T behind the trigger: -v T / 2 on average, and v T / sqrt(12)
its standard deviation. With a latch both are 0. Homing touches a switch likewise, at 0.5 mm/s: the mean of a whole run
is off by up to 0.5 um more at a period of 1 ms.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import tempfile

TRUTH_MM = 0.98
GOLDEN = (math.sqrt(5) - 1) / 2
FEEDS = (60, 300, 600, 1200)
PERIODS_NS = (250_000, 500_000, 1_000_000, 2_000_000)


def heights(caltwin, touches, feed, period_ns, is_latched):
    """Of each touch [mm]."""
    words = [caltwin, "linuxcnc", "gantry_router", "--set", f"EMCMOT.SERVO_PERIOD={period_ns}", "-c", "G0 X100 Y100"]
    for i in range(touches):
        # The place within the cycle at which the trigger falls goes round evenly.
        words += ["-c", f"G0 Z{4 + (i * GOLDEN) % 1:.5f}", "-c", f"G38.2 Z-4 F{feed}"]
    if is_latched:
        words.append("--latch")
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "out.json")
        subprocess.run([*words, "--json", out], check=True, stdout=subprocess.DEVNULL)
        return [at[2] for step in json.loads(out.read_text())["steps"] for at in step["probed_mm"]]


def row(caltwin, touches, feed, period_ns, is_latched):
    off_um = [1000 * (mm - TRUTH_MM) for mm in heights(caltwin, touches, feed, period_ns, is_latched)]
    way_um = 0 if is_latched else feed / 60 * period_ns * 1e-6
    return (f"| {feed} | {period_ns / 1e6:g} | {'yes' if is_latched else 'no'} | {statistics.mean(off_um):+.2f} | "
            f"{statistics.stdev(off_um):.2f} | {-way_um / 2:.2f} | {way_um / math.sqrt(12):.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("caltwin")
    parser.add_argument("--touches", type=int, default=25)
    asked = parser.parse_args()
    print("| feed, mm/min | servo period, ms | latch | mean error, um | sd, um | -v T / 2 | v T / sqrt(12) |")
    print("|---|---|---|---|---|---|---|")
    for period_ns in PERIODS_NS:
        for feed in FEEDS:
            print(row(asked.caltwin, asked.touches, feed, period_ns, False), flush=True)
    for feed in FEEDS:
        print(row(asked.caltwin, asked.touches, feed, 1_000_000, True), flush=True)


if __name__ == "__main__":
    main()
