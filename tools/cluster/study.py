#!/usr/bin/env python3
"""Runs a study on the workers of a Dask cluster, a part (`--shard I/N`) a task.

    study.py scenarios/studies/next.yaml --out DIR --shards 20 --scheduler tcp://HOST:8786
    study.py scenarios/studies/next.yaml --out DIR --shards 20 --local 2

Every worker must see the same files: the study, its scenarios and machines, `caltwin`,
and DIR. A part is run in a folder of its own that gets its name when the part is done,
so a worker may be killed at any time: Dask gives its parts to another. Parts that are
there already are not run again, so the same command goes on after anything. At the end
`caltwin study --merge` puts the parts together: the same bytes as on one machine.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

try:
    import dask
    from dask.distributed import Client, LocalCluster, as_completed
except ImportError:
    print("study.py: this Python has no Dask; tools/cluster/setup.sh makes one that has",
          file=sys.stderr)
    sys.exit(2)


def run_part(binary, study, part, parts, folder):
    """One part, on a worker. Returns its folder and the seconds it took here."""
    import ctypes
    import os
    import pathlib
    import shutil
    import signal
    import subprocess
    import time
    import uuid

    done = pathlib.Path(folder) / f"part-{part}-of-{parts}"
    if done.exists():
        return str(done), 0.0
    begun = time.monotonic()
    work = pathlib.Path(folder) / f".part-{part}-of-{parts}-{uuid.uuid4().hex}"

    def die_with_worker():
        set_parent_death_signal = 1
        ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGKILL)

    answer = subprocess.run(
        [binary, "study", study, "--shard", f"{part}/{parts}", "--workers", "1",
         "--out", str(work)],
        preexec_fn=die_with_worker, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, check=False)
    if answer.returncode != 0:
        shutil.rmtree(work, ignore_errors=True)
        raise RuntimeError(f"part {part}/{parts}: {answer.stderr.strip()}")
    try:
        os.rename(work, done)
    except OSError:  # Another worker was thought dead and was not: the bytes are equal.
        shutil.rmtree(work, ignore_errors=True)
    return str(done), time.monotonic() - begun


def options():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--shards", type=int, required=True, help="parts to divide it into")
    parser.add_argument("--caltwin", default="build/caltwin", help="the program")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scheduler", help="address of a Dask scheduler")
    where.add_argument("--local", type=int, metavar="N", help="N workers on this machine")
    chosen = parser.parse_args()
    for said, wrong in (
            (f"{chosen.study} is not there", not chosen.study.is_file()),
            (f"{chosen.caltwin} is no program: name it with --caltwin",
             not os.access(chosen.caltwin, os.X_OK) or os.path.isdir(chosen.caltwin)),
            ("--shards must be 1 to 1000000", not 1 <= chosen.shards <= 1_000_000),
            ("--local must be 1 to 1024",
             chosen.local is not None and not 1 <= chosen.local <= 1024)):
        if wrong:
            parser.error(said)  # One message, exit code 2.
    return chosen


def run_all(client, chosen, parts_folder):
    """Every part, in whatever order; says how far it is."""
    binary = str(pathlib.Path(chosen.caltwin).resolve())
    futures = [
        client.submit(run_part, binary, str(chosen.study.resolve()), part, chosen.shards,
                      str(parts_folder), pure=False)
        for part in range(1, chosen.shards + 1)
    ]
    folders, spent_s = [], 0.0
    for future in as_completed(futures):
        folder, part_s = future.result()
        folders.append(folder)
        spent_s += part_s
        print(f"{len(folders)} of {chosen.shards} parts", file=sys.stderr, flush=True)
    return folders, spent_s


def main():
    chosen = options()
    try:
        return run(chosen)
    except (RuntimeError, OSError, ValueError) as fault:  # A part, a folder, a scheduler.
        print(f"study.py: {fault}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("study.py: interrupted; the same command goes on with the parts done",
              file=sys.stderr)
        return 130


def run(chosen):
    """All parts, then the whole of them; returns the exit code."""
    parts_folder = (chosen.out / "parts").resolve()
    parts_folder.mkdir(parents=True, exist_ok=True)
    # A lost worker says nothing against the part it was at.
    dask.config.set({"distributed.scheduler.allowed-failures": 100})
    cluster = None
    if chosen.local:
        cluster = LocalCluster(n_workers=chosen.local, threads_per_worker=1,
                               dashboard_address=None)
    begun = time.monotonic()
    with Client(cluster or chosen.scheduler) as client:
        folders, spent_s = run_all(client, chosen, parts_folder)
    wall_s = time.monotonic() - begun
    if cluster:
        cluster.close()
    print(f"{chosen.shards} parts: {spent_s:.1f} s on the workers, {wall_s:.1f} s here",
          file=sys.stderr)
    merge = [chosen.caltwin, "study", str(chosen.study), "--out", str(chosen.out),
             "--resume", "--merge", *sorted(folders)]
    code = subprocess.run(merge, check=False).returncode
    for lost in parts_folder.glob(".part-*"):  # Of workers that were killed.
        shutil.rmtree(lost, ignore_errors=True)
    return code


if __name__ == "__main__":
    sys.exit(main())
