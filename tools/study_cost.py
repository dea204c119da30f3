#!/usr/bin/env python3
"""What studies cost: tools/study_cost.py [--binary build/caltwin] [--quick]

CPU seconds (of all threads) and the largest memory of a process: over the number of
trials, over the size of the machine, of linear studies without and with every trial kept,
and, where build/cluster holds a Python with Dask (tools/cluster/setup.sh), of what a part
costs beside its trials. CPU does not depend on what else runs, beyond shared caches.
--quick takes a tenth of the trials.
"""

import argparse
import os
import pathlib
import resource
import shutil
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent.parent
NEXT = HERE / "scenarios/studies/next.yaml"
LINEAR = HERE / "scenarios/studies/sixty_touches.yaml"


def changed(study, folder, trials, keep=None, axes=None):
    """The study in `folder`, its paths made absolute, with so many trials."""
    lines = []
    for line in study.read_text().splitlines():
        key = line.strip().split(":")[0]
        if key == "trials":
            line = f"  trials: {trials}"
        elif key == "scenarios":
            line = f"  scenarios: [{HERE}/scenarios/first_light.yaml]"
            if axes:
                tilt = "true" if len(axes) == 3 else "false"
                line += ("\n  compare:\n    - next_all: {axes: [" + ", ".join(axes) +
                         f"], variant: corrected, repeats: 10, tilt: {tilt}}}")
        elif key == "plan":
            line = f"  plan: {HERE}/examples/plans/sixty_touches.yaml"
        lines.append(line)
    if keep:
        lines.append(f"  keep: {keep}")
    file = folder / f"{study.stem}_{trials}.yaml"
    file.write_text("\n".join(lines) + "\n")
    return file


def cost(command):
    """CPU seconds and MB of a command and all it started."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen([str(part) for part in command], cwd=HERE,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"failed: {' '.join(str(part) for part in command)}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu_s, usage.ru_maxrss / 1024


def size_of(folder):
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / 1e6


def told(binary, folder, what, trials, *args, **changes):
    out = folder / "out"
    study = changed(*args, folder, trials, **changes)
    cpu_s, memory_mb = cost([binary, "study", study, "--out", out, "--workers", "1"])
    print(f"{what:<44} {trials:>10} trials: {1e6 * cpu_s / trials:>8.1f} us of CPU each, "
          f"{memory_mb:.0f} MB, {size_of(out):.2f} MB on disk", flush=True)
    shutil.rmtree(out)


def parts(binary, folder, num_parts):
    python = HERE / "build/cluster/bin/python"
    out = folder / "parts"
    cpu_s, _ = cost([python, "tools/cluster/study.py", changed(NEXT, folder, num_parts),
                     "--out", out, "--shards", num_parts, "--local", 2, "--caltwin", binary])
    shutil.rmtree(out)
    return cpu_s


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", default="build/caltwin")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    binary = pathlib.Path(HERE, options.binary).resolve()
    less = 10 if options.quick else 1
    folder = pathlib.Path(tempfile.mkdtemp(prefix="caltwin_cost_"))
    try:
        for trials in (200, 2000, 20000):
            told(binary, folder, "NeXT on all axes", trials // less, NEXT)
        for axes in (["x"], ["x", "y"], ["x", "y", "z"]):
            told(binary, folder, f"NeXT on {', '.join(axes)}", 1000 // less, NEXT, axes=axes)
        for trials in (10**6, 10**7):
            told(binary, folder, "linear, 60 rows, none kept", trials // less, LINEAR)
        told(binary, folder, "linear, 60 rows, every trial kept", 10**5 // less, LINEAR,
             keep="all")
        if (HERE / "build/cluster/bin/python").exists():
            few, many = parts(binary, folder, 20), parts(binary, folder, 60)
            print(f"a part beside its trials: {1000 * (many - few) / 40:.0f} ms of CPU")
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
