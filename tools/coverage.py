#!/usr/bin/env python3
"""Whether stated uncertainties are honest: runs the coverage studies, prints a table.

    tools/coverage.py --out DIR [--binary build/caltwin] [--workers N] [STUDY.yaml...]

Without a study: scenarios/studies/next.yaml and scenarios/studies/coverage/*.yaml, 2000
machines each. What DIR holds already is gone on with. A line a quantity: the standard
deviation of its errors, root mean square error over stated sd, the scatter over the
Cramer-Rao bound of its touches (scenarios/studies/coverage/bounds.csv; in brackets: over
the u that is stated, where no bound stands there), and how often the 95 % interval holds
the truth, with Wilson's 95 % interval. Marked: `*` where that lies outside 93 to 97 %, or
the scatter beyond 1.10 of the bound. What was never told or states no uncertainty is listed
below. Exit code 1 where a line is marked.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys

LEAST, MOST = 0.93, 0.97
MOST_OVER_BOUND = 1.10
NORMAL = 1.959963984540054
HERE = pathlib.Path(__file__).resolve().parent.parent


def run(binary, study, folder, workers):
    command = [binary, "study", study, "--out", folder]
    if workers:
        command += ["--workers", str(workers)]
    if folder.exists():
        command.append("--resume")
    subprocess.run([str(part) for part in command], check=True, cwd=HERE,
                   stdout=subprocess.DEVNULL)
    return json.loads((folder / "summary.json").read_text())


def factors(binary, scenario):
    """k / 1.96 of each parameter: how much wider few degrees of freedom make its sd.
    None where a rounding alone is the uncertainty: u is no scatter then."""
    found = subprocess.run([str(binary), "run", scenario, "--fidelity", "fast", "--json", "-"],
                           cwd=HERE, capture_output=True, text=True)
    if not found.stdout:
        return {}
    result = json.loads(found.stdout)
    told = {}
    for parameter in result["parameters"]:
        uncertainty = parameter.get("uncertainty") or {"k": NORMAL, "budget": []}
        k = uncertainty["k"]
        told[parameter["name"]] = k / NORMAL if k >= NORMAL - 1e-3 else None
    return told


def kept_bounds():
    """Least standard deviation by contender and quantity."""
    with open(HERE / "scenarios/studies/coverage/bounds.csv", newline="") as file:
        return {(row["contender"], row["quantity"]): float(row["bound"])
                for row in csv.DictReader(file)}


def over_bound(case, parameter, bounds, widened):
    """The scatter over the bound, whether that is as small as is asked, and as text. With
    no bound over the u that is stated, which is one where it is least squares of all that
    was read, with its true noise; none of a rounding."""
    bound = bounds.get((case, parameter["name"]))
    if bound is not None:
        ratio = parameter["error"]["sd"] / bound
        return ratio <= MOST_OVER_BOUND, f"{ratio:.2f}"
    if widened is None:
        return True, "none"
    return True, f"({parameter['rms_over_sd'] * widened:.2f})"


def line(case, parameter, bounds, widened):
    """The row of the table, and whether it is within the limits."""
    coverage = parameter["coverage95"]
    is_covered = LEAST <= coverage["rate"] <= MOST
    is_tight, scatter = over_bound(case, parameter, bounds, widened)
    low, high = (100 * end for end in coverage["ci95"])
    return (f"| {case} | {parameter['name']} | {parameter['error']['sd']:.3g} "
            f"{parameter['unit']} | {parameter['rms_over_sd']:.2f} | "
            f"{scatter}{'' if is_tight else ' *'} | "
            f"{100 * coverage['rate']:.1f} % ({low:.1f}-{high:.1f})"
            f"{'' if is_covered else ' *'} | "
            f"{coverage['of']} |"), is_covered and is_tight


def table(binary, summary, folder):
    rows, apart, is_good = [], [], True
    bounds = kept_bounds()
    for case in summary["cases"]:
        widened = factors(binary, folder / case["scenario"])
        for parameter in case["parameters"]:
            if parameter.get("coverage95"):
                row, row_is_good = line(
                    case["name"], parameter, bounds, widened.get(parameter["name"], 1))
                rows.append(row)
                is_good = is_good and row_is_good
            elif parameter["identified"]["hits"] > 0:
                apart.append(f"{case['name']}: {parameter['name']} (states no uncertainty)")
    return rows, apart, is_good


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("studies", nargs="*", type=pathlib.Path)
    arguments.add_argument("--out", type=pathlib.Path, required=True)
    arguments.add_argument("--binary", type=pathlib.Path, default=HERE / "build/caltwin")
    arguments.add_argument("--workers", type=int)
    given = arguments.parse_args()
    studies = [study.resolve() for study in given.studies] or [
        HERE / "scenarios/studies/next.yaml",
        *sorted((HERE / "scenarios/studies/coverage").glob("*.yaml"))]
    out = given.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    all_apart, is_good = [], True
    print("| procedure | quantity | sd of errors | rms/sd | over bound | "
          "95 % intervals hold | machines |")
    print("|---|---|---|---|---|---|---|")
    for study in studies:
        summary = run(given.binary.resolve(), study, out / study.stem, given.workers)
        rows, apart, study_is_good = table(given.binary.resolve(), summary, study.parent)
        print("\n".join(rows), flush=True)
        all_apart += apart
        is_good = is_good and study_is_good
    if all_apart:
        print("\nApart: " + "; ".join(all_apart) + ".")
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
