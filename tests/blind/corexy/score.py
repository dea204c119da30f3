#!/usr/bin/env python3
"""How often `caltwin diagnose` names what generate.py has hidden in a CoreXY.

    score.py BINARY FOLDER [--cases N] [--seed S] [--jobs J]

A case counts as right where nothing is hidden and nothing is found, or where the hidden cause
is the finding or one of its rivals and nothing else is found. What describes the same rows
(`equivalent` of detail.json) counts as well: of lengths along diagonals alone a racked beam, a
square C0Y and unlike belts are one parallelogram. Exit code 1 where fewer than 95 % are right.
"""
import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys

LEAST_RIGHT = 0.95


def name_of(one):
    return f"{one['cause']}.{one.get('axis', '')}".rstrip(".")


def judge(binary, folder):
    truth = json.loads((folder / "truth.json").read_text())
    same = json.loads((folder / "detail.json").read_text()).get("equivalent", [])
    out = folder / "diagnosis.json"
    out.unlink(missing_ok=True)  # Of a run before.
    run = subprocess.run(
        [binary, "diagnose", folder / "rows.csv", "--machine", folder / "machine.yaml", "--json", out],
        capture_output=True, text=True, check=False)
    if not out.exists():
        return False, name_of(truth), [run.stderr.strip()[:200]]
    findings = json.loads(out.read_text())["findings"]
    names = [[name_of(one) for one in [finding, *finding.get("candidates", [])]] for finding in findings]
    if truth["cause"] == "none":
        return not names, "none", names
    meant = {name_of(truth), *map(name_of, same)}
    return len(names) == 1 and bool(meant & set(names[0])), name_of(truth), names


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("binary")
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--cases", type=int, default=48)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--jobs", type=int, default=2)
    given = arguments.parse_args()
    generator = pathlib.Path(__file__).with_name("generate.py")
    subprocess.run([sys.executable, generator, given.folder, "--cases", str(given.cases), "--seed",
                    str(given.seed)], check=True)
    cases = sorted(given.folder.glob("case_*"))[:given.cases]
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        results = list(pool.map(lambda case: judge(given.binary, case), cases))
    right = {"none": [0, 0], "hidden": [0, 0]}
    for case, (is_right, truth, names) in zip(cases, results):
        counts = right["none" if truth == "none" else "hidden"]
        counts[0] += is_right
        counts[1] += 1
        if not is_right:
            print(f"{case.name}: {truth}, found {[found[:4] for found in names]}")
    for kind, (good, total) in right.items():
        print(f"{kind}: {good} of {total} right")
    share = sum(good for good, _ in right.values()) / max(len(cases), 1)
    sys.exit(0 if share >= LEAST_RIGHT else 1)


if __name__ == "__main__":
    main()
