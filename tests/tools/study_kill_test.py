#!/usr/bin/env python3
"""A study that is killed with SIGKILL and resumed leaves the bytes of an undisturbed one.

One that keeps its trials, one that keeps none, a linear one; each is killed twice, with
unlike numbers of workers. Usage: study_kill_test.py CALTWIN SOURCE_FOLDER
"""

import contextlib
import pathlib
import sqlite3
import subprocess
import sys
import tempfile
import time

ROUTERS = """study:
  scenarios: [SOURCE/scenarios/first_light.yaml]
  vary: {backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 2}}}
  compare: [next_cluster_backlash, trigger_release_backlash]
  trials: 2000
"""
PLAN = """study:
  plan: SOURCE/examples/plans/sixty_touches.yaml
  vary:
    backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 1.2}}
    probe_pretravel.x.pretravel_mm: {normal: {mean: 0.02, sd: 0.003}}
  fidelity: linear
  trials: 10000000
"""
STUDIES = {
    "kept": (ROUTERS, "study.sqlite", ("trials.csv", "summary.json")),
    "unkept": (ROUTERS + "  keep: none\n", "unfinished.sqlite", ("summary.json",)),
    "linear": (PLAN, "unfinished.sqlite", ("summary.json",)),
}


def progress(store):
    """Something that grows while the study does: rows kept, or the state that was folded."""
    try:
        with contextlib.closing(sqlite3.connect(f"file:{store}?mode=ro", uri=True)) as db:
            rows = db.execute("SELECT count(*) FROM trials").fetchone()[0]
            state = db.execute("SELECT value FROM study WHERE key = 'state'").fetchone()
            return rows, state
    except sqlite3.Error:  # Not made yet.
        return 0, None


def kill_midway(command, store):
    """Runs it until more is kept than was before, then kills it. False: it had ended."""
    before = progress(store)
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    while process.poll() is None:
        if progress(store) != before:
            time.sleep(0.3)
            process.kill()
            process.wait()
            return process.returncode < 0
        time.sleep(0.02)
    return False


def read_only_fault(command, folder):
    """Half done, in a folder where nothing can be written: told at once, nothing run."""
    mounted = ["unshare", "--mount", "sh", "-c",
               'mount --bind "$0" "$0" && mount -o remount,bind,ro "$0" || exit 77; exec "$@"',
               str(folder)]
    if subprocess.run(mounted + ["true"], capture_output=True, check=False).returncode:
        return ""  # No right to mount.
    found = subprocess.run(mounted + command, capture_output=True, text=True, check=False)
    is_told = found.returncode == 2 and "cannot be written to" in found.stderr
    return "" if is_told else f"read-only: {found.returncode} {found.stderr[-300:]}"


def check(name, caltwin, folder, source):
    text, store, results = STUDIES[name]
    study = folder / f"{name}.yaml"
    study.write_text(text.replace("SOURCE", source))
    whole, killed = folder / f"{name}_whole", folder / f"{name}_killed"
    command = [caltwin, "study", str(study), "--out"]
    subprocess.run(command + [str(whole), "--workers", "2"], check=True,
                   stdout=subprocess.DEVNULL)
    for workers in ("2", "1"):
        words = [str(killed), "--resume", "--workers", workers]
        if not kill_midway(command + words, killed / store):
            return f"{name}: had ended before it was killed"
    refused = subprocess.run(command + [str(killed)], capture_output=True, text=True,
                             check=False)
    if refused.returncode != 2 or "--resume" not in refused.stderr:
        return f"{name}: is begun anew over what is there: {refused.stderr}"
    if fault := read_only_fault(command + [str(killed), "--resume"], killed):
        return f"{name}: {fault}"
    subprocess.run(command + [str(killed), "--resume"], check=True,
                   stdout=subprocess.DEVNULL)
    for result in results:
        if (whole / result).read_bytes() != (killed / result).read_bytes():
            return f"{name}: {result} is another"
    left = sorted(path.name for path in killed.iterdir())
    if left != sorted(path.name for path in whole.iterdir()):
        return f"{name}: left behind {left}"
    return ""


def main():
    caltwin, source = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as folder:
        faults = [check(name, caltwin, pathlib.Path(folder), source) for name in STUDIES]
    print("\n".join(fault for fault in faults if fault) or "all the same")
    return 1 if any(faults) else 0


if __name__ == "__main__":
    sys.exit(main())
