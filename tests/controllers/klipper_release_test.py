"""Klipper's own release 0.12 in lock-step: klipper_release_test.py CALTWIN HOST

Every scenario of scenarios/klipper meets what it expects under it too, but those whose sections only Kalico has: they
are refused by that. Ends with 77 where there is no host.
"""

import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SKIPPED = 77
ROOT = Path(__file__).resolve().parents[2]
ONLY_KALICO = ("z_calibration", "z_tilt_ng")
# Of the descent, which ends within some last steps of 1e-5 (tests/scenarios/delta_shipped_test.cc).
BOTH_MM = 1e-4
faults = []


def claim(holds, what):
    print(("ok  " if holds else "NOT ") + what, flush=True)
    if not holds:
        faults.append(what)


def needs_kalico(file):
    text = file.read_text()
    texts = [text] + [part.read_text() for part in (file.parent / "files").glob("*.cfg") if part.name in text]
    return "machine: z_station" in text or any("[z_tilt_ng]" in one for one in texts)


def scenario(caltwin, host, file):
    done = subprocess.run([caltwin, "run", file], capture_output=True, text=True, timeout=200, check=False,
                          env={**os.environ, "CALTWIN_KLIPPER_HOST": host})
    return file, done.returncode, done.stdout + done.stderr


def run_all(caltwin, host):
    files = sorted((ROOT / "scenarios/klipper").glob("*.yaml"))
    num = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for file, code, said in pool.map(lambda one: scenario(caltwin, host, one), files):
            if needs_kalico(file):
                refused = any(f"Section '{name}' is not a valid config section" in said for name in ONLY_KALICO)
                claim(code == 2 and refused, f"{file.stem}: refused, exit {code}")
            else:
                num += 1
                claim(code == 0, f"{file.stem}: exit {code}")
            if code not in (0, 2):
                print(said)
    claim(num > 40, f"{num} scenarios under Klipper's own release")


def saved_by(caltwin, host, folder):
    truth, file = folder / "truth.yaml", folder / "run.json"
    truth.write_text("effects: {endstop.a: {error_mm: 0.3}, delta_radius: {error_mm: 0.8}}\n")
    subprocess.run([caltwin, "klipper", "delta_printer", "--fidelity", "fast", "--truth", truth, "--host", host,
                    "-c", "G28", "-c", "DELTA_CALIBRATE", "-c", "SAVE_CONFIG", "--json", file],
                   check=True, stdout=subprocess.DEVNULL, timeout=200)
    told = json.loads(file.read_text())
    touches = [line for step in told["steps"] for line in step["printed"] if "probe at" in line]
    return touches, told["saved"]


def both_alike(caltwin, host, kalico):
    """The fork measures the same; its descent ends within its last step of the other's."""
    with tempfile.TemporaryDirectory() as name:
        touches, saved = saved_by(caltwin, host, Path(name))
        of_kalico, saved_by_kalico = saved_by(caltwin, kalico, Path(name))
    claim(len(touches) == 7 and touches == of_kalico, "Klipper and Kalico touch at the same heights to the last digit")
    numbers = [(float(one["value"]), float(other["value"])) for one, other in zip(saved, saved_by_kalico, strict=True)
               if one["option"] in ("delta_radius", "position_endstop", "angle")]
    apart = max(abs(one - other) for one, other in numbers)
    claim(len(numbers) >= 6 and apart < BOTH_MM, f"and save {len(numbers)} settings that are {apart:.1e} apart at most")


def main(caltwin, host, kalico):
    if not Path(host).exists():
        print(f"{host} is not there: tools/setup.sh --controllers installs it")
        return SKIPPED
    run_all(caltwin, host)
    if Path(kalico).exists():
        both_alike(caltwin, host, kalico)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:4]))
