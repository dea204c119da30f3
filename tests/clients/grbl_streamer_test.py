"""grbl-streamer, as it ships, on `caltwin serve --dialect grbl`: it boots, homes, probes the
block, streams a job by counting characters, and hears of an alarm.

    grbl_streamer_test.py CALTWIN
"""

import collections
import os
import sys
import traceback

from grbl_streamer import GrblStreamer
from served import Served, near, wait_for

Z_TOP = 25.4  # Of the 1-2-3 block that lies in the middle, and the machine's drawing:
Z_MAX = 120.0
BALL, PRETRAVEL = 1.0, 0.02


class Session:
    def __init__(self, terminal):
        self.heard = collections.defaultdict(list)
        self.grbl = GrblStreamer(lambda event, *data: self.heard[event].append(data))
        self.grbl.cnect(terminal, 115200)
        wait_for("the greeting", lambda: self.heard["on_boot"])
        self.grbl.poll_start()

    def send(self, line):
        before = len(self.heard["on_read"])
        self.grbl.send_immediately(line)
        return before

    def idle(self):
        wait_for("Idle", lambda: self.grbl.cmode == "Idle")


def job(side_mm, lines):
    """A meander of short moves, in machine coordinates."""
    out = ["G90", "G53 G0 Z-10", "F3000"]
    for k in range(lines):
        x = -150 + side_mm * (k % 2)
        out.append(f"G1 X{x:.3f} Y{-200 + side_mm * k / lines:.3f}")
    return [*out, "G2 X-140 I-15 J0", "M2"]


def main(program):
    with Served(program, "--machine", "gantry_router", "--dialect", "grbl",
                "--fidelity", "fast") as served:
        session = Session(served.terminal)
        grbl = session.grbl
        wait_for("settings", lambda: session.heard["on_settings_downloaded"] or
                 len([1 for (line,) in session.heard["on_read"] if line.startswith("$132")]))
        grbl.homing()
        session.idle()
        wait_for("home", lambda: abs(grbl.cmpos[2] + 2) < 1e-6)

        grbl.send_immediately("G53 G0 X-150 Y-150")
        grbl.send_immediately("G38.2 Z-110 F60")
        # It tells of the parameters of $# as of probing.
        probed = wait_for("the probe", lambda: [
            place for (place,) in session.heard["on_probe"] if place[2] != 0])[-1]
        wanted = Z_TOP + BALL - PRETRAVEL - Z_MAX
        near("block's top by G38.2, machine z [mm]", probed[2], wanted, 0.0013)

        lines = job(side_mm=40, lines=400)
        grbl.job_new()
        session.heard["on_job_completed"].clear()  # It says so at each start too.
        grbl.incremental_streaming = False
        grbl.write("\n".join(lines))
        grbl.job_run()
        wait_for("the end of the job", lambda: session.heard["on_job_completed"], 60)
        session.idle()
        assert not session.heard["on_error"], session.heard["on_error"]
        wait_for("the arc's end", lambda: abs(grbl.cmpos[0] + 140) < 2e-3 and
                 abs(grbl.cmpos[1] + 160.1) < 2e-3)
        print(f"job of {len(lines)} lines by counting characters: done")

        session.heard["on_alarm"].clear()
        grbl.send_immediately("G53 G0 X10")
        alarm = wait_for("an alarm", lambda: session.heard["on_alarm"])[-1][0]
        assert alarm == "ALARM:2", alarm
        session.heard["on_boot"].clear()
        grbl.softreset()
        wait_for("the greeting again", lambda: session.heard["on_boot"])
        grbl.killalarm()
        session.idle()
        print("soft limit, reset, unlock: done")
        grbl.disconnect()


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except BaseException:  # The client's threads would keep a failed test alive.
        traceback.print_exc()
        os._exit(1)
