#!/usr/bin/env python3
"""Klipper's host and LinuxCNC, started and killed again and again for half an hour each.

    soak.py CALTWIN HOST [--minutes 30] [--seed 1] [--only klipper|linuxcnc]

Each run is a whole one, or ends by a kill -9 at any moment: of caltwin, of the host (LinuxCNC's
milltask or rtapi_app), or by Ctrl-C. No run may hang; a whole one gives the first one's answers to the
last digit; ten seconds after a kill no process, page, shared memory, lock or terminal is left.
Exit code 1: something of that did not hold. 77: the controllers are not installed.
"""

import argparse
import collections
import contextlib
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

from processes import with_tmpdir

SKIPPED = 77
ROOT = pathlib.Path(__file__).resolve().parents[2]
PATIENCE_S = 120
LEFT_S = 10

KLIPPER = ["klipper", "delta_printer", "--fidelity", "fast"]
KLIPPER_LINES = ["G28", "DELTA_CALIBRATE", "SAVE_CONFIG", "G28", "PROBE"]
KLIPPER_TRUTH = "effects: {endstop.a: {error_mm: 0.3}, delta_radius: {error_mm: 0.8}}\n"
LINUXCNC = ["linuxcnc", "gantry_router"]
LINUXCNC_LINES = ["G0 X100 Y100", "G0 Z5", "G38.2 Z-5 F60", "G0 Z5", "G38.2 Z-5 F600"]
LINUXCNC_TRUTH = "effects: {backlash.z: {gap_mm: 0.1}}\n"


class Soak:
    def __init__(self, name, words, lines, truth, victims, folder, seed):
        self.name, self.victims, self.folder = name, victims, pathlib.Path(folder)
        self.random = random.Random(f"{seed} {name}")
        self.counts, self.faults, self.longest_s, self.first = collections.Counter(), [], 0.0, None
        file = self.folder / f"{name}.yaml"
        file.write_text(truth)
        self.temporary = self.folder / name
        self.temporary.mkdir()
        self.out = self.folder / f"{name}.json"
        self.words = [*words, "--truth", file, "--json", self.out]
        for line in lines:
            self.words += ["-c", line]

    def processes(self):
        return with_tmpdir(self.temporary)

    def fault(self, text):
        self.faults.append(text)
        print(f"{self.name}: NOT {text}", flush=True)

    def begin(self):
        self.out.unlink(missing_ok=True)
        return subprocess.Popen([str(word) for word in self.words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True, env={**os.environ, "TMPDIR": str(self.temporary)})

    def end(self, run, how):
        start = time.monotonic()
        try:
            said, _ = run.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.fault(f"a run hangs for {PATIENCE_S} s ({how})")
            run.kill()
            said, _ = run.communicate()
        self.longest_s = max(self.longest_s, time.monotonic() - start)
        return said

    def whole(self):
        run = self.begin()
        said = self.end(run, "whole")
        self.counts["whole"] += 1
        if run.returncode != 0:
            self.fault(f"a whole run ends with {run.returncode}: {said[-2000:]}")
            return
        told = json.loads(self.out.read_text())
        answers = [told.get("saved"), [[s["line"], s.get("printed"), s.get("probed_mm")] for s in told["steps"]]]
        self.first = self.first or answers
        if answers != self.first:
            self.fault(f"other answers than the first run's: {answers}")

    def killed(self, victim):
        run = self.begin()
        time.sleep(self.random.uniform(0, 1.2 if self.name == "klipper" else 3.5))
        is_hit = True
        if victim == "caltwin":
            run.kill()
        elif victim == "Ctrl-C":
            run.send_signal(signal.SIGINT)
        else:
            pids = [pid for pid, name in self.processes().items() if name == victim]
            is_hit = False
            for pid in pids[:1]:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                    is_hit = True
        start = time.monotonic()
        said = self.end(run, victim)
        # One that was not there yet, or no more, leaves a whole run to be waited for.
        if is_hit and time.monotonic() - start > LEFT_S:
            self.fault(f"a run ends {time.monotonic() - start:.1f} s after a kill of {victim}: {said[-2000:]}")
        self.counts[victim if is_hit else "nobody there"] += 1
        wanted = {"caltwin": (0, -9), "Ctrl-C": (0, 130, -2)}.get(victim, (0, 3))
        if run.returncode not in wanted:
            self.fault(f"after a kill of {victim}: exit {run.returncode}: {said[-2000:]}")

    def nothing_left(self, how):
        until = time.monotonic() + LEFT_S
        while (left := self.processes()) and time.monotonic() < until:
            time.sleep(0.05)
        if left:
            self.fault(f"ten seconds after {how} there are {left}")
            for pid in left:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)

    def go_on(self, until):
        try:
            self.round_after_round(until)
        except Exception as error:  # It would end this thread alone, and pass.
            self.fault(repr(error))
        for victim in {"caltwin", "Ctrl-C", *self.victims} - set(self.counts):
            print(f"{self.name}: {victim} was never hit", flush=True)

    def round_after_round(self, until):
        while time.monotonic() < until:
            how = self.random.choice(["whole", "whole", "caltwin", "Ctrl-C", *self.victims])
            self.whole() if how == "whole" else self.killed(how)
            self.nothing_left(how)
        # What a killed run leaves in its folder the next one sweeps; the last may have been a killed one.
        self.whole()
        if litter := sorted(path.name for path in self.temporary.iterdir()):
            self.fault(f"left in its temporary folder: {litter[:5]}")


def shared():
    """What would outlive every process: pages, memory of System V, LinuxCNC's lock, terminals."""
    segments = pathlib.Path("/proc/sysvipc/shm").read_text().splitlines()[1:]
    return {*os.listdir("/dev/shm"), *(line.split()[0] for line in segments),
            *(path.name for path in pathlib.Path("/tmp").glob("linuxcnc*.lock")),
            *(path.name for path in pathlib.Path("/tmp").glob("klipper_host_*")),
            *(str(path) for path in ROOT.glob(".git/*.lock"))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("caltwin")
    parser.add_argument("host")
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=["klipper", "linuxcnc"])
    asked = parser.parse_args()
    if not pathlib.Path(asked.host).exists() or not pathlib.Path("/usr/bin/linuxcnc").exists():
        print("the controllers are not installed: tools/setup.sh --controllers")
        return SKIPPED
    os.environ["CALTWIN_KLIPPER_HOST"] = asked.host
    before = shared()
    with tempfile.TemporaryDirectory() as folder:
        soaks = [
            Soak("klipper", [asked.caltwin, *KLIPPER], KLIPPER_LINES, KLIPPER_TRUTH, [pathlib.Path(asked.host).name],
                 folder, asked.seed),
            Soak("linuxcnc", [asked.caltwin, *LINUXCNC], LINUXCNC_LINES, LINUXCNC_TRUTH, ["milltask", "rtapi_app"],
                 folder, asked.seed)]
        soaks = [soak for soak in soaks if asked.only in (None, soak.name)]
        until = time.monotonic() + 60 * asked.minutes
        threads = [threading.Thread(target=soak.go_on, args=[until]) for soak in soaks]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    left = shared() - before
    if left:
        print(f"NOT: left behind {sorted(left)}")
    for soak in soaks:
        print(f"{soak.name}: {dict(soak.counts)}, longest {soak.longest_s:.1f} s, faults {len(soak.faults)}")
    return 1 if left or any(soak.faults for soak in soaks) else 0


if __name__ == "__main__":
    sys.exit(main())
