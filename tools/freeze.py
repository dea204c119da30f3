"""The answers of one build, held against the frozen ones: tools/freeze.sh says how.

An answer is what a person gets: JSON, rows, transcript and diagnosis of every scenario in
both fidelities, the text of every refusal, every import of tests/data, every plan of
examples/, the result of every study with few trials. Times of this computer and the
version are taken out, nothing else. Each is kept as a hash:

    tests/freeze/answers.txt   as they were when they were frozen
    tests/freeze/changes.txt   those that have changed since: a line `# REASON`, then the
                               answers that changed for it last (earlier ones: git log)
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIDELITIES = ("physics", "fast")
FROZEN, CHANGES = ROOT / "tests/freeze/answers.txt", ROOT / "tests/freeze/changes.txt"
GONE = "-" * 24
TRIALS = 12  # Of each study.
TIMEOUT_S = 1200
IMPORT_KINDS = ("iso230-dat", "klipper-thermal", "cmm-plate", "probe-accuracy", "marlin-log",
                "klipper-delta", "klipper-mesh", "rrf-config", "rrf-heightmap")
CONTROLLERS = ("rrf", "klipper", "marlin", "linuxcnc")
CALIBRATIONS = {
    "twin:gantry_router": ("next_rough_steps", "next_dual_dimension", "dial_backlash", "joint_estimate"),
    "twin:delta_printer": ("g33", "rrf_least_squares", "klipper_descent", "delta_joint"),
    "twin:triple_z_printer": ("plane_tilt", "bed_tilt", "bed_tilt_iterated", "rrf_levelling", "pivots_and_wiring"),
    "twin:z_station": ("z_calibration", "probe_accuracy", "switch_offset"),
    "twin:motor_stage": ("servo_home", "index_verify", "travel_limits", "axis_sync", "emergency_stop", "motor_backlash"),
}
# Of this computer, or of this version, and no answer.
LEFT_OUT = {"cpu_s", "version", "program_sha256"}


def run(words, folder=ROOT):
    """Exit code and both streams, the tree's own place taken out."""
    done = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, errors="replace",
        timeout=TIMEOUT_S, env={**os.environ, "LC_ALL": "C", "NO_COLOR": "1"})
    return f"exit {done.returncode}\n{done.stdout}\n--\n{done.stderr}".replace(str(ROOT), "ROOT")


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in LEFT_OUT}
    if isinstance(value, list):
        return [without_times(item) for item in value]
    return value


def json_text(path):
    if not path.exists():
        return "none"
    return json.dumps(without_times(json.loads(path.read_text())), indent=1).replace(str(ROOT), "ROOT")


def file_text(path):
    return path.read_text(errors="replace").replace(str(ROOT), "ROOT") if path.exists() else "none"


class Freezer:
    def __init__(self, binary, keep):
        self.binary, self.keep = str(binary), keep

    def answer(self, name, text):
        """(name, hash); the text itself under --keep, to be read where hashes differ."""
        if self.keep:
            kept = self.keep / re.sub(r"[^\w.=-]", "_", name)
            kept.write_text(text)
        return name, hashlib.sha256(text.encode()).hexdigest()[:24]

    def scenario(self, file, fidelity):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            words = [self.binary, "run", file, "--fidelity", fidelity, "--json", f"{out}/r.json",
                     "--transcript", f"{out}/t.txt"]
            said = run(words + ["--record", f"{out}/rows.csv"])
            if "have no rows" in said:
                said = run(words)
            said = re.sub(r"[\d.]+ s here", "", said).replace(folder, "OUT")
            name = f"scenario {file} {fidelity}"
            answers = [self.answer(f"{name} {what}", text) for what, text in (
                ("text", said), ("json", json_text(out / "r.json")),
                ("transcript", file_text(out / "t.txt")),
                ("rows", file_text(out / "rows.csv") + file_text(out / "rows.yaml")))]
            if fidelity == "fast" and (out / "rows.csv").exists():
                answers += self.diagnosed(name, out, "rows.csv")
            return answers

    def diagnosed(self, name, out, rows):
        """The diagnosis of rows in the folder `out`, with a correction for each controller."""
        said = run([self.binary, "diagnose", f"{out}/{rows}", "--json", f"{out}/d.json"])
        answers = [self.answer(f"{name} diagnosis", said.replace(str(out), "OUT")),
                   self.answer(f"{name} diagnosis json",
                               json_text(out / "d.json").replace(str(out), "OUT"))]
        for controller in CONTROLLERS:
            written = out / "correction"
            written.unlink(missing_ok=True)
            said = run([self.binary, "diagnose", f"{out}/{rows}", "--correction", str(written),
                        "--for", controller])
            text = said + file_text(written)
            answers.append(self.answer(f"{name} correction {controller}", text.replace(str(out), "OUT")))
        return answers

    def refusals(self, stem, texts):
        """Of many bad texts in place of one file: a hash of all that is said."""
        said = []
        with tempfile.TemporaryDirectory(dir=ROOT / "scenarios", prefix=".freeze") as folder:
            for i, text in enumerate(texts):
                file = pathlib.Path(folder) / f"{i:04d}.yaml"
                file.write_text(text)
                said.append(run([self.binary, "validate", str(file)]))
        text = re.sub(r"ROOT/scenarios/\.freeze\w+", "IN", "\n".join(said))
        return [self.answer(f"refusals {stem}", text)]

    def bad_input(self, file):
        words = ["run"] if "scenario" in str(file) else ["validate"]
        return [self.answer(f"refusal {file}", run([self.binary, *words, file]))]

    def calibration(self, link, procedure, more):
        with tempfile.TemporaryDirectory() as folder:
            words = [self.binary, "calibrate", "--link", link, "--procedure", procedure, *more,
                     "--transcript", f"{folder}/t.txt"]
            text = run(words) + file_text(pathlib.Path(folder) / "t.txt")
            return [self.answer(" ".join(["calibrate", link, procedure, *more]), text.replace(folder, "OUT"))]

    def simulated(self, plan, truth=None):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            words = [self.binary, "simulate", plan, "--out", f"{out}/d.csv"]
            if truth:
                words += ["--truth", truth]
            said = run(words).replace(folder, "OUT")
            name = f"plan {plan}"
            answers = [self.answer(f"{name} text", said),
                       self.answer(f"{name} rows", file_text(out / "d.csv") + file_text(out / "d.yaml")),
                       self.answer(f"{name} atlas", run([self.binary, "plan", plan]))]
            return answers + self.diagnosed(name, out, "d.csv")

    def imported(self, kind, file):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            said = run([self.binary, "import", kind, file, "--out", f"{out}/d.csv",
                        "--machine-out", f"{out}/m.yaml"]).replace(folder, "OUT")
            if "--machine-out" in said and "exit 2" in said:
                said = run([self.binary, "import", kind, file, "--out", f"{out}/d.csv"]).replace(folder, "OUT")
            text = said + file_text(out / "d.csv") + file_text(out / "d.yaml") + file_text(out / "m.yaml")
            name = f"import {kind} {file}"
            answers = [self.answer(name, text.replace(folder, "OUT"))]
            if (out / "d.csv").exists():
                answers += self.diagnosed(name, out, "d.csv")
            return answers

    def study(self, file):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            few = re.sub(r"trials: *\d+", f"trials: {TRIALS}", (ROOT / file).read_text())
            few = re.sub(r"adaptive: *\{[^}]*\}", f"trials: {TRIALS}", few)
            copy = ROOT / pathlib.Path(file).parent / f".freeze_{pathlib.Path(file).name}"
            copy.write_text(few)
            try:
                run([self.binary, "study", str(copy), "--workers", "1", "--out", f"{out}/s"])
            finally:
                copy.unlink()
            return [self.answer(f"study {file} {what}", text.replace(".freeze_", "")) for what, text in (
                ("trials", file_text(out / "s/trials.csv")),
                ("summary", json_text(out / "s/summary.json")))]

    def said(self, *words):
        text = re.sub(r" *[\d.e-]+ s$", "", run([self.binary, *words]), flags=re.MULTILINE)
        return [self.answer("said " + " ".join(words), text)]


NUMBER = re.compile(r"(?<=[\s:\[{,])-?\d+(\.\d+)?(e-?\d+)?(?=[\s,\]}]|$)")
KEY = re.compile(r"([A-Za-z_]\w*)(?=:(\s|$))")


def spoilt(text):
    """One mistake each: a number that is a word, a key misspelt, a number far too large."""
    for pattern, bad in ((NUMBER, "abc"), (KEY, None), (NUMBER, "-1e30")):
        for match in pattern.finditer(text):
            line = text[text.rfind("\n", 0, match.start()) + 1:match.start()]
            if "#" in line or line.startswith("about"):
                continue
            word = bad or match[0][:-1] + "zq"
            yield text[:match.start()] + word + text[match.end():]


def shortened(texts, most):
    texts = list(texts)
    step = max(1, len(texts) // most)
    return texts[::step][:most]


def tracked(*patterns):
    out = subprocess.run(["git", "ls-files", "--", *patterns], cwd=ROOT, capture_output=True, text=True)
    return sorted(out.stdout.split())


def jobs_of(freezer):
    """(part, function, arguments) of everything there is to ask."""
    # Those under a real controller need it: tests/controllers runs them.
    studies = [f for f in tracked("scenarios/studies/*.yaml")
               if "\nstudy:" in "\n" + (ROOT / f).read_text() and "klipper/" not in (ROOT / f).read_text()]
    scenarios = [f for f in tracked("scenarios/*.yaml")
                 if f not in studies and not f.startswith(("scenarios/klipper/", "scenarios/linuxcnc/"))]
    for file in scenarios:
        for fidelity in FIDELITIES:
            yield "scenarios", freezer.scenario, (file, fidelity)
        texts = shortened(spoilt((ROOT / file).read_text()), 24)
        yield "refusals", freezer.refusals, (pathlib.Path(file).stem, texts)
    for file in [*tracked("models/*/machine.yaml", "examples/plans/*.yaml"), *studies]:
        texts = shortened(spoilt((ROOT / file).read_text()), 40)
        yield "refusals", freezer.refusals, (file, texts)
    for file in tracked("tests/data/scenarios_bad/*.yaml", "tests/fuzz/corpus/*"):
        yield "refusals", freezer.bad_input, (file,)
    for link, procedures in CALIBRATIONS.items():
        for procedure in procedures:
            for more in ([], ["--apply", "--yes"], ["--axis", "x"], ["--axis", "x", "--apply", "--yes"]):
                yield "calibrations", freezer.calibration, (link, procedure, more)
    for file in tracked("tests/data/imports/*", "tests/data/iso230/*", "tests/fuzz/corpus/import*"):
        for kind in IMPORT_KINDS:
            yield "imports", freezer.imported, (kind, file)
    for file in tracked("examples/plans/*.yaml"):
        if file.endswith("_truth.yaml"):
            continue
        truth = file.replace(".yaml", "_truth.yaml")
        yield "plans", freezer.simulated, (file, truth if (ROOT / truth).exists() else None)
    for file in studies:
        yield "studies", freezer.study, (file,)
    for words in (["explain"], ["compare", "delta", "--machines", "3"],
                  ["compare", "levelling", "--machines", "3"], ["compare", "backlash", "--machines", "3"]):
        yield "said", freezer.said, tuple(words)
    for word in sorted(set(re.findall(r"^  (\S+)", run([freezer.binary, "explain"]), re.MULTILINE))):
        yield "said", freezer.said, ("explain", word)


def read_answers(path):
    """{name: hash} of a file; remarks are passed over, a later line counts."""
    lines = path.read_text().splitlines() if path.exists() else []
    pairs = [line.split("  ", 1) for line in lines if line and not line.startswith("#")]
    return {name: hashed for hashed, name in pairs}


def compare(found, is_whole):
    """What differs from the frozen answers, as (what, name) pairs."""
    expected = read_answers(FROZEN) | read_answers(CHANGES)
    differing = [("new", n) for n in found if n not in expected]
    differing += [("changed", n) for n in found if n in expected and expected[n] not in (found[n], GONE)]
    if is_whole:
        differing += [("gone", n) for n in expected if n not in found and expected[n] != GONE]
    return sorted(differing, key=lambda pair: pair[1])


def accept(found, differing, reason):
    """Adds the reason and its answers; an earlier change of the same answer is no longer told."""
    again = {name for _, name in differing}
    kept = [line for line in CHANGES.read_text().splitlines()
            if line.startswith("#") or line.split("  ", 1)[1] not in again]
    kept += [f"# {reason}"]
    kept += [f"{GONE if what == 'gone' else found[name]}  {name}" for what, name in differing]
    CHANGES.write_text("\n".join(kept) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", type=pathlib.Path)
    parser.add_argument("--accept", metavar="REASON", help="write what differs into tests/freeze/changes.txt")
    parser.add_argument("--only", default="", help="scenarios, refusals, calibrations, imports, plans, studies, said")
    parser.add_argument("--match", default="", help="a regular expression that a job's arguments must match")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for the answers themselves")
    options = parser.parse_args()
    if options.keep:
        shutil.rmtree(options.keep, ignore_errors=True)
        options.keep.mkdir(parents=True)
    freezer = Freezer(options.binary.resolve(), options.keep)
    only = set(filter(None, options.only.split(",")))
    jobs = [job for job in jobs_of(freezer) if (not only or job[0] in only) and
            re.search(options.match, str(job[2]))]
    answers = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for done in concurrent.futures.as_completed([pool.submit(f, *a) for _, f, a in jobs]):
            answers.update(done.result())
    differing = compare(answers, not only and not options.match)
    for what, name in differing:
        print(f"{what}: {name}")
    print(f"freeze: {len(answers)} answers of {len(jobs)} questions, {len(differing)} differ from the frozen ones")
    if options.accept and differing:
        accept(answers, differing, options.accept)
        print(f"freeze: accepted in {CHANGES.relative_to(ROOT)}: {options.accept}")
        return 0
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
