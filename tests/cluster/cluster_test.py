#!/usr/bin/env python3
"""A study on a cluster is the study on one machine, bit for bit, a killed worker included.

A real Dask scheduler and three worker processes on loopback; one of them is killed with
SIGKILL while it runs a part. Usage: cluster_test.py CALTWIN SOURCE_FOLDER
Exits 77 (skipped) where this Python has no dask: tools/cluster/setup.sh makes one.
"""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
PARTS = 9
STUDY = """study:
  about: A few machines.
  scenarios: [SOURCE/scenarios/first_light.yaml]
  vary: {backlash.x.gap_mm: {lognormal: {median: 0.05, factor: 2}}}
  trials: 540
  seed: 3
"""


def wait_for(what, condition, seconds=60):
    end = time.monotonic() + seconds
    while not (found := condition()):
        if time.monotonic() > end:
            sys.exit(f"waited {seconds} s for {what}")
        time.sleep(0.02)
    return found


def csv_of_one_machine(caltwin, study, folder):
    subprocess.run([caltwin, "study", study, "--out", folder, "--workers", "2"],
                   check=True, stdout=subprocess.DEVNULL)
    return (folder / "trials.csv").read_bytes()


def start(*words):
    return subprocess.Popen([sys.executable, "-m", *words], stderr=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL)


def running_part_of(worker):
    """The caltwin process that the worker waits for, if any."""
    path = pathlib.Path(f"/proc/{worker.pid}/task")
    for task in path.glob("*/children"):
        for child in task.read_text().split():
            command = pathlib.Path(f"/proc/{child}/cmdline")
            if command.exists() and b"--shard" in command.read_bytes():
                return int(child)
    return None


def main():
    try:
        import distributed  # noqa: F401
    except ImportError:
        return SKIPPED
    caltwin, source = sys.argv[1:3]
    folder = pathlib.Path(tempfile.mkdtemp())
    study = folder / "few.yaml"
    study.write_text(STUDY.replace("SOURCE", source))
    expected = csv_of_one_machine(caltwin, study, folder / "alone")
    address_file = folder / "scheduler.json"
    processes = [start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0",
                       "--no-dashboard", "--scheduler-file", str(address_file))]
    try:
        wait_for("the scheduler", address_file.exists)
        workers = [start("distributed.cli.dask_worker", "--scheduler-file", str(address_file),
                         "--nthreads", "1", "--no-nanny", "--no-dashboard",
                         "--local-directory", str(folder / f"worker{i}"))
                   for i in range(3)]
        processes += workers
        import json
        address = json.loads(address_file.read_text())["address"]
        driver = subprocess.Popen(
            [sys.executable, f"{source}/tools/cluster/study.py", str(study), "--out",
             str(folder / "cluster"), "--shards", str(PARTS), "--caltwin", caltwin,
             "--scheduler", address], stdout=subprocess.DEVNULL)
        processes.append(driver)
        part = wait_for("a part to run", lambda: running_part_of(workers[1]))
        # Counted before: until its orphan has ended the others may have done the rest.
        done = len(list((folder / "cluster" / "parts").glob("part-*")))
        os.kill(workers[1].pid, signal.SIGKILL)
        if done >= PARTS:
            sys.exit("all parts were done before the worker was killed")
        wait_for("the killed worker's part to end",
                 lambda: not pathlib.Path(f"/proc/{part}").exists())
        if driver.wait(timeout=300) != 0:
            sys.exit("the driver failed")
        found = (folder / "cluster" / "trials.csv").read_bytes()
        summaries = [(folder / name / "summary.json").read_bytes()
                     for name in ("alone", "cluster")]
        if found != expected or summaries[0] != summaries[1]:
            sys.exit("the cluster's results are not those of one machine")
        if lost := list((folder / "cluster" / "parts").glob(".*")):
            sys.exit(f"what the killed worker had begun is still there: {lost}")
    finally:
        for process in processes:
            process.kill()
    print(f"{len(found)} bytes equal, {done} of {PARTS} parts done when the worker died")
    return 0


if __name__ == "__main__":
    sys.exit(main())
