"""Mills as people have them: linuxcnc_configs_test.py CALTWIN

LinuxCNC comes with the INI files of a hundred machines and simulated axes. Each that moves X, Y and Z by trivkins becomes a
machine and a configuration with caltwin for a card (`caltwin new machine --from`), homes, and goes to the middle of its X.
Ends with 77 where they are not installed.
"""

import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SKIPPED = 77
SAMPLES = Path("/usr/share/doc/linuxcnc/examples/sample-configs")
# Its index pulses are beyond its own limits, as LinuxCNC then says.
BEYOND = {"by_interface_vitalsystems_motenc": "soft limit"}
# What a file lacks, or is, that makes no machine of it.
NO_MACHINE = ("no machine that can be made", "its joints are those of", "has no SCALE", "is neither in",
              "no such machine can be drawn", "takes in other files")
faults = []


def claim(holds, what):
    print(("ok  " if holds else "NOT ") + what, flush=True)
    if not holds:
        faults.append(what)


def middle_of_x(ini):
    """In its own units."""
    section = re.search(r"(?ms)^\[AXIS_X\](.*?)(?=^\[|\Z)", ini)[1]
    limits = [float(re.search(rf"(?m)^{key}\s*=\s*(\S+)", section)[1]) for key in ("MIN_LIMIT", "MAX_LIMIT")]
    return sum(limits) / 2


def mill(caltwin, folder, sample):
    name = re.sub(r"[^A-Za-z0-9]", "_", str(sample.relative_to(SAMPLES))[:-4])
    made = subprocess.run([caltwin, "new", "machine", name, "--from", sample], cwd=folder, capture_output=True, text=True,
                          errors="replace", timeout=60, check=False)
    if made.returncode != 0:
        return name, None, made.stderr.split("\n")[0]
    ini = f"models/{name}/linuxcnc/machine.ini"
    go = f"G53 G0 X{middle_of_x((folder / ini).read_text(errors='replace')):.3f}"
    done = subprocess.run([caltwin, "linuxcnc", name, "--ini", ini, "--fidelity", "fast", "-c", go],
                          cwd=folder, capture_output=True, text=True, errors="replace", timeout=300, check=False)
    return name, done.returncode, done.stdout + done.stderr


def main(caltwin):
    if not SAMPLES.exists():
        print(f"{SAMPLES} is not there: tools/setup.sh --controllers installs it")
        return SKIPPED
    files = sorted({*SAMPLES.glob("by_*/**/*.ini"), *SAMPLES.glob("sim/axis/*.ini")})
    num = num_right = 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, code, said in pool.map(lambda file: mill(caltwin, Path(folder), file), files):
            if code is None:
                claim(any(words in said for words in NO_MACHINE), f"{name}: {said.rsplit(': ', 1)[-1]}")
                continue
            num, num_right = num + 1, num_right + (code == 0)
            claim(code == 0 or (name in BEYOND and BEYOND[name] in said), f"{name}: exit {code}")
            if code != 0:
                print(said[-500:])
    claim(num > 70, f"of {len(files)} files {num} are such machines, {num_right} of them home and move")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
