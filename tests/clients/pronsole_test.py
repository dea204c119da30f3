"""pronsole, as Debian ships it, on a delta: it goes online, calibrates by G33, and runs a job
to its end.

    pronsole_test.py CALTWIN
"""

import atexit
import pathlib
import re
import subprocess
import sys
import tempfile

from served import Served, near, wait_for

TRUTH = "effects: {delta_radius: {error_mm: 0.8}, endstop.a: {error_mm: 0.3}}\n"


class Pronsole:
    def __init__(self, folder, terminal):
        self.log = pathlib.Path(folder, "said")
        self.out = self.log.open("w")
        self.process = subprocess.Popen(
            ["pronsole"], stdin=subprocess.PIPE, stdout=self.out, stderr=subprocess.STDOUT,
            text=True, env={"HOME": folder, "PATH": "/usr/bin:/bin", "TERM": "dumb"})
        self.tell(f"connect {terminal} 115200")
        self.hears("Printer is now online|now online")

    def tell(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def hears(self, pattern, behind=0):
        return wait_for(pattern, lambda: list(re.finditer(pattern, self.log.read_text()[behind:])))

    def so_far(self):
        return len(self.log.read_text())

    def end(self):
        self.tell("exit")
        self.process.wait(10)


def job():
    lines = ["G28", "M104 S0", "G90", "G92 E0"]
    for k in range(300):
        lines.append(f"G1 X{(k % 2) * 40 - 20} Y{k / 10 - 15:.2f} Z20 E{k / 100:.3f} F6000")
    return "\n".join([*lines, "M400", "M114"]) + "\n"


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        truth = pathlib.Path(folder, "truth.yaml")
        truth.write_text(TRUTH)
        with Served(program, "--machine", "delta_printer", "--truth", str(truth),
                    "--fidelity", "fast") as served:
            client = Pronsole(folder, served.terminal)
            atexit.register(client.process.kill)  # Nothing stays behind a claim that fails.
            client.tell("G28")
            client.tell("G33 P4 V1")
            deviations = client.hears(r"std dev:\s*([0-9.]+)")
            client.hears("Save with M500")
            last = float(client.hears(r"std dev:\s*([0-9.]+)")[-1].group(1))
            assert last < 0.02, f"G33 ends at {last} mm after {len(deviations)} passes"
            client.tell("M503")
            radius = float(client.hears(r"M665 L[0-9.]+ R([0-9.]+)")[-1].group(1))
            near("delta radius that G33 found [mm]", radius, 130.8, 0.05)

            file = pathlib.Path(folder, "job.gcode")
            file.write_text(job())
            before = client.so_far()
            client.tell(f"load {file}")
            client.tell("print")
            client.hears("Print ended", before)
            client.tell("M114")
            client.hears(r"X:20\.00 Y:14\.90 Z:20\.00", before)
            said = client.log.read_text()
            assert "Resend" not in said and "Error:" not in said, said[-2000:]
            print("job of 306 numbered lines: done")
            client.end()


if __name__ == "__main__":
    main(sys.argv[1])
