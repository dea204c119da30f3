#!/usr/bin/env python3
"""How a study gains from workers, by the wall clock: tools/scaling.py [--binary build/caltwin]

Runs scenarios/studies/next.yaml with one worker and with two, in turn, and
sixty_touches.yaml (linear) likewise; of `--repeats` runs of each the fastest counts. Prints
seconds by the clock and of CPU, the largest memory of a process, and the gain. The clock
says what it should where nothing else runs: the load before each run is printed, and
"cores" is CPU over wall clock, what the run was given. The gain by the clock is only told
where one worker was given 0.95 of a core and two 1.9. Told always is the gain without what
other work took: Linux counts of every thread how long it ran and how long it was ready and
had no core; the rest it waited for another worker (`waited`). Then a run takes

    what the first thread ran + sum over workers (ran + waited) / number of workers.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent.parent
STUDIES = ["scenarios/studies/next.yaml", "scenarios/studies/sixty_touches.yaml"]


def watch(pid, threads):
    """Of every thread [ns]: when it was seen first and last, what it ran and queued then."""
    now = time.monotonic_ns()
    for thread in os.listdir(f"/proc/{pid}/task"):
        try:
            ran, queued, _ = pathlib.Path(f"/proc/{pid}/task/{thread}/schedstat") \
                .read_text().split()
        except OSError:  # Has just ended.
            continue
        seen = (now, int(ran), int(queued))
        threads[int(thread)] = (threads.get(int(thread), (seen,))[0], seen)


def undisturbed(pid, threads, workers):
    """Seconds that it would have taken on cores of its own, and those its workers waited."""
    spent = {thread: [(last[i] - first[i]) / 1e9 for i in range(3)]
             for thread, (first, last) in threads.items()}
    waited_s = sum(max(0, there - ran - queued)
                   for thread, (there, ran, queued) in spent.items() if thread != pid)
    ran_s = sum(ran for thread, (_, ran, _) in spent.items() if thread != pid)
    return spent[pid][1] + (ran_s + waited_s) / workers, waited_s


def run(binary, study, workers):
    """Seconds by the clock, of CPU, kB of memory at most, and `undisturbed` of one run."""
    folder = tempfile.mkdtemp(prefix="caltwin_scaling_")
    try:
        start = time.monotonic()
        process = subprocess.Popen(
            [binary, "study", study, "--out", folder + "/out", "--workers", str(workers)],
            cwd=HERE, stdout=subprocess.DEVNULL)
        threads = {}
        ended = (0, 0, None)
        while ended[0] == 0:
            watch(process.pid, threads)
            time.sleep(0.02)
            ended = os.wait4(process.pid, os.WNOHANG)
        _, status, usage = ended
        if status != 0:
            raise SystemExit(f"{study} failed")
        wall_s = time.monotonic() - start
        return (wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss,
                *undisturbed(process.pid, threads, workers))
    finally:
        shutil.rmtree(folder)


def measure(binary, study, repeats):
    best, own = {}, {}
    for _ in range(repeats):
        for workers in (1, 2):
            load = os.getloadavg()[0]
            wall_s, cpu_s, memory_kb, own_s, waited_s = run(binary, study, workers)
            print(f"{study} {workers} worker{'s' if workers > 1 else ''}: {wall_s:.2f} s by "
                  f"the clock, {cpu_s:.2f} s of CPU, {cpu_s / wall_s:.2f} cores, "
                  f"{memory_kb / 1024:.0f} MB, load before {load:.1f}; on cores of its own "
                  f"{own_s:.2f} s, waited {waited_s:.2f} s", flush=True)
            if workers not in best or wall_s < best[workers][0]:
                best[workers] = (wall_s, cpu_s)
            own[workers] = min(own_s, own.get(workers, own_s))
    (one_s, one_cpu_s), (two_s, two_cpu_s) = best[1], best[2]
    is_told = one_cpu_s / one_s > 0.95 and two_cpu_s / two_s > 1.9
    print(f"{study}: {one_s / two_s:.2f} times as fast with two workers"
          + ("" if is_told else
             "; NOT TOLD: other work took part of the cores. CPU alone: "
             f"{2 * one_cpu_s / two_cpu_s:.2f}") +
          f"; on cores of its own {own[1] / own[2]:.2f}", flush=True)


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--binary", type=pathlib.Path, default=HERE / "build/caltwin")
    arguments.add_argument("--repeats", type=int, default=3)
    given = arguments.parse_args()
    for study in STUDIES:
        measure(str(given.binary.resolve()), study, given.repeats)


if __name__ == "__main__":
    main()
