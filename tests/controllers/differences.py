#!/usr/bin/env python3
"""The same lines to caltwin's emulated controllers and to the real programs: where they differ.

    differences.py CALTWIN HOST [--out FILE] [--only WORD] [--jobs 3] [--all]

Every case has two machines of its own with the same hidden errors, in closed form: one behind
`caltwin serve`, one under the unmodified host of the Klipper family or LinuxCNC. Each is homed and
brought to a place first, then hears the case's lines, and is asked where it stands. A case is alike
where both obey, both refuse or both do not know, and where what they touched and where they stand agree.
Of the z_station, whose emulation speaks Klipper's own dialect, words count too.

Prints a table in markdown; --out writes it too; --only keeps the cases that contain a word; --all puts
those alike into the table. Five minutes on two busy cores. Exit code 0 whatever is found, 1: a case could
not be run, 77: the controllers are not installed.
"""

import argparse
import concurrent.futures
import dataclasses
import itertools
import json
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time

from differences_cases import GROUPS

SKIPPED = 77
ATTEMPTS = 3            # A busy computer may lose a real controller: exit code 3.
PLACE_mm = 0.02         # Marlin prints two decimals.
HEIGHT_mm = 0.003       # A servo cycle of LinuxCNC, a microstep of each tower.
WORDS_mm = 0.0005       # Numbers in words: half a microstep.
NUMBER = re.compile(r"-?\d+\.\d+|-?\d+")
HEIGHTS = (r"Result is z=(-?[\d.]+)", r"^Bed X.* Z: (-?[\d.]+)", r"Stopped at height (-?[\d.]+)")
UNKNOWN = ("Unknown command:", "Command is not supported")


class Lost(Exception):
    """A controller that did not start or went away: nothing about the line."""


@dataclasses.dataclass
class Answer:
    outcome: str                 # done, refused, unknown, stopped
    words: list                  # What was printed to the case's own lines.
    place: tuple = None          # Of the machine [mm], where it could be asked.
    height: float = None         # What was touched last [mm].

    def brief(self, length=120):
        lines = [line.removeprefix("// ").strip() for line in self.words if line.strip()]
        probed = sum(line.startswith("probe at") for line in lines)
        lines = [line for line in lines if not line.startswith("probe at")]
        said = "; ".join(([f"{probed} x probe at ..."] if probed else []) + lines)
        said = said if len(said) <= length else said[:length - 3] + "..."
        parts = [self.outcome + (f": `{said}`" if said else "")]
        if self.height is not None and f"{self.height:.6f}" not in said:
            parts.append(f"touched at {self.height:.4f}")
        if self.place and self.outcome in ("done", "unknown"):
            parts.append("at " + " ".join(f"{mm:.3f}".replace("-0.000", "0.000") for mm in self.place))
        return ", ".join(parts).replace("|", "\\|").replace("<", "&lt;")


def height_in(lines):
    found = None
    for line in lines:
        for pattern in HEIGHTS:
            if match := re.search(pattern, line):
                found = float(match.group(1))
    return found


def place_in(text, pattern):
    match = re.search(pattern, text)
    return tuple(float(one) for one in match.groups()) if match else None


# What each says of where the machine is. Without work offsets: those of RepRapFirmware's `Machine`.
N = r"(-?[\d.]+)"
WHERE = {
    "rrf": ("M114", rf"Machine {N} {N} {N}"),
    "marlin": ("M114", rf"X:{N} Y:{N} Z:{N}"),
    "klipper": ("GET_POSITION", rf"toolhead: X:{N} Y:{N} Z:{N}"),
}


class Wire:
    """`caltwin serve`, and a terminal program in front of it."""

    def __init__(self, caltwin, machine, truth):
        self.twin = subprocess.Popen(
            [caltwin, "serve", "--machine", machine, "--fidelity", "fast", "--truth", truth, "--tcp", "0"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True)
        said = ""
        for line in self.twin.stdout:
            said += line
            if match := re.search(r"listening on 127\.0\.0\.1:(\d+)", line):
                self.socket = socket.create_connection(("127.0.0.1", int(match.group(1))))
                self.socket.settimeout(60)
                self.lines = self.socket.makefile("r", encoding="utf-8", errors="replace", newline="\n")
                return
        self.twin.wait()
        raise Lost(said)

    def say(self, line):
        self.socket.sendall(line.encode() + b"\n")
        said = []
        for answer in self.lines:
            if answer.strip() == "ok":
                return said
            said.append(answer.rstrip("\n"))
        raise Lost("the emulation closed the connection")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if hasattr(self, "socket"):
            self.lines.close()
            self.socket.close()
        self.twin.terminate()
        self.twin.wait()
        self.twin.stdout.close()


def readable(line):
    """Without a version of the day, and what a fault adds behind its first line."""
    return re.sub(r"FIRMWARE_VERSION:\S+", "FIRMWARE_VERSION:...", line.split("\\x0a")[0])


def emulated_outcome(lines):
    for line in lines:
        if line.lower().startswith("emergency stop"):
            return "stopped"
    for line in lines:
        if any(word in line for word in UNKNOWN):
            return "unknown"
        if line.startswith(("Error:", "!!", "?")):
            return "refused"
    return "done"


def emulated(asked, group, case, truth):
    ask, pattern = WHERE[group.emulated]
    with Wire(asked.caltwin, group.machine, truth) as wire:
        for line in case.before_emulated(group):
            wire.say(line)
        said, outcome = [], "done"
        for line in case.emulated_lines():
            now = wire.say(line)
            said += [readable(line) for line in now]
            outcome = emulated_outcome(now) if outcome == "done" else outcome
            if outcome in ("refused", "stopped"):
                break
        place = place_in(" ".join(wire.say(ask)), pattern)
    return Answer(outcome, said, place, height_in(said))


def run_real(words, out, attempts=ATTEMPTS):
    """The JSON that caltwin wrote. A refusal is exit code 1, a controller that got lost 3."""
    for _ in range(attempts):
        run = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, timeout=300)
        if run.returncode in (0, 1):
            return json.loads(out.read_text())
        time.sleep(1)
    raise Lost(f"exit {run.returncode}: {run.stdout[-500:]}{run.stderr[-500:]}")


def real_klipper(asked, group, case, truth, out):
    before, own = case.before_real(group), case.real_lines()
    words = [asked.caltwin, "klipper", group.machine, "--host", asked.host, "--fidelity", "fast", "--truth", truth,
             "--json", out]
    for line in [*before, *own, WHERE["klipper"][0]]:
        words += ["-c", line]
    told = run_real(words, out)["steps"]
    if len(told) <= len(before) and any("refusal" in step for step in told):
        raise Lost(f"refused before its own lines: {told[-1]}")
    mine = told[len(before):len(before) + len(own)]
    said = [readable(line) for step in mine for text in step["printed"] for line in text.splitlines()]
    outcome, place = "done", None
    if refusal := mine[-1].get("refusal"):
        outcome = "unknown" if any(word in refusal for word in UNKNOWN) else "refused"
        if outcome == "refused":
            said = [line for line in said if not line.startswith("!!")] + ["!! " + refusal.splitlines()[0]]
    elif len(told) > len(before) + len(own):
        place = place_in(" ".join(told[-1]["printed"]), WHERE["klipper"][1])
    if any("Klipper state: Shutdown" in line for line in said):
        outcome = "stopped"
    return Answer(outcome, said, place, height_in(said))


def real_linuxcnc(asked, group, case, truth, out):
    before, own = case.before_real(group), case.real_lines()
    words = [asked.caltwin, "linuxcnc", group.machine, "--fidelity", "fast", "--truth", truth, "--json", out]
    if not case.is_homed():
        words.append("--unhomed")
    for line in before:
        words += ["-c", line]
    if case.program:
        job = out.with_suffix(".ngc")
        job.write_text("\n".join(own) + "\n")
        words += ["--program", job]
    else:
        for line in own:
            words += ["-c", line]
    told = run_real(words, out)["steps"]
    if case.is_homed():
        told = told[1:]
    mine = told[len(before):]
    if not mine:
        raise Lost(f"refused before its own lines: {told}")
    last = mine[-1]
    said = [line for step in mine for line in (*step["messages"], *step["errors"])]
    probed = [at for step in mine for at in step["probed_mm"]]
    done = last["done"] and not last["errors"]
    return Answer("done" if done else "refused", said, tuple(last["position_mm"]), probed[-1][2] if probed else None)


def template(words):
    return [NUMBER.sub("#", line.removeprefix("// ").strip()) for line in words if line.strip()]


def numbers(words):
    return [float(one) for line in words for one in NUMBER.findall(line)]


def far(a, b, limit):
    return bool(a and b) and any(abs(x - y) > limit for x, y in zip(a, b))


def words_differ(real, twin):
    """Of one dialect: lines that only one of them says, numbers of those that both say."""
    said, heard = template(real.words), template(twin.words)
    lacking = [line for line in said if line not in heard]
    added = [line for line in heard if line not in said]
    found = [f"lacks `{lacking[0][:60]}`"] if lacking else []
    found += [f"says `{added[0][:60]}`"] if added else []
    both = [(numbers([line]), numbers([other])) for line in real.words for other in twin.words
            if template([line]) == template([other])]
    off = [b - a for pair in both for a, b in zip(*pair)] if len(both) == 1 else []
    if off and max(map(abs, off)) > WORDS_mm:
        found.append(f"numbers differ by up to {max(off, key=abs):.4f}")
    return found


def differences(group, case, real, twin):
    """What differs, in words; empty: alike."""
    found = []
    if real.outcome != twin.outcome:
        found.append(f"{real.outcome}, emulated {twin.outcome}")
    elif real.outcome == "done" and not case.twin and far(real.place, twin.place, PLACE_mm):
        off = [b - a for a, b in zip(real.place, twin.place)]
        found.append("stands elsewhere by " + " ".join(f"{mm:.3f}".replace("-0.000", "0.000") for mm in off) + " mm")
    if real.height is not None and twin.height is not None and abs(real.height - twin.height) > HEIGHT_mm:
        found.append(f"touched elsewhere by {twin.height - real.height:.4f} mm")
    return found + (words_differ(real, twin) if group.same_dialect and not found else [])


def compare(asked, folder, number, group, case):
    truth = folder / f"{group.machine}.yaml"
    out = folder / f"{number}.json"
    run = real_linuxcnc if group.real == "linuxcnc" else real_klipper
    return run(asked, group, case, truth, out), emulated(asked, group, case, truth)


def is_unknown_alone(case, twin):
    """The emulation says that it does not know it, and nothing comes behind that would go elsewhere."""
    return twin.outcome == "unknown" and len(case.emulated_lines()) == 1 and not case.why.startswith("DEFECT")


def names(rows):
    return ", ".join(f"`{row[1].shown()}`" for row in rows) + "."


def table(rows, everything):
    """[(group, case, real, twin, faults)] as markdown."""
    lines = []
    for group, of_group in itertools.groupby(rows, key=lambda row: row[0]):
        of_group = list(of_group)
        unlike = [row for row in of_group if row[4]]
        alike = [row for row in of_group if not row[4]]
        neither = [row for row in unlike if is_unknown_alone(row[1], row[3]) and row[2].outcome == "unknown"]
        unknown = [row for row in unlike if is_unknown_alone(row[1], row[3]) and row[2].outcome == "done"]
        shown = of_group if everything else [row for row in unlike if row not in unknown and row not in neither]
        lines += ["", f"### {group.title}", "",
                  f"{len(of_group)} compared, {len(alike)} alike, {len(unlike)} different. Hidden: `{group.truth}`."]
        if alike:
            lines += ["", f"Alike ({len(alike)}): " + names(alike)]
        if unknown:
            lines += ["", f"{group.real_name} obeys, the emulation says that it does not know them ({len(unknown)}): "
                      + names(unknown)]
        if neither:
            lines += ["", f"Neither knows, in other words ({len(neither)}; real: `{neither[0][2].words[-1]}`, emulated: "
                      f"`{neither[0][3].words[-1]}`): " + names(neither)]
        if not shown:
            continue
        lines += ["", f"| line | {group.real_name} | emulated ({group.emulated}) | differs | why |",
                  "|---|---|---|---|---|"]
        for _, case, real, twin, faults in shown:
            lines.append(f"| `{case.shown()}` | {real.brief()} | {twin.brief()} | {'; '.join(faults) or 'alike'} | "
                         f"{case.why if faults else ''} |")
    compared, unlike = len(rows), sum(1 for row in rows if row[4])
    head = f"{compared} compared, {compared - unlike} alike, {unlike} different."
    return "\n".join([head, *lines]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("caltwin")
    parser.add_argument("host")
    parser.add_argument("--out")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=3)
    parser.add_argument("--all", action="store_true")
    asked = parser.parse_args()
    asked.host = shutil.which(asked.host)
    if asked.host is None or shutil.which("linuxcnc") is None:
        print("skipped: Klipper's host and LinuxCNC are wanted: tools/setup.sh --controllers")
        return SKIPPED
    asked.caltwin = os.path.abspath(asked.caltwin)
    todo = [(group, case) for group in GROUPS for case in group.cases
            if asked.only in f"{group.title} {case.shown()}"]
    rows, lost = [], []
    with tempfile.TemporaryDirectory() as name, concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        folder = pathlib.Path(name)
        for group in GROUPS:
            (folder / f"{group.machine}.yaml").write_text(f"effects: {group.truth}\n")
        tasks = [pool.submit(compare, asked, folder, number, group, case)
                 for number, (group, case) in enumerate(todo)]
        for task, (group, case) in zip(tasks, todo):
            try:
                real, twin = task.result()
            except (Lost, OSError, ValueError, subprocess.TimeoutExpired) as error:
                lost.append(f"{group.title}: {case.shown()}: {error}")
                continue
            rows.append((group, case, real, twin, differences(group, case, real, twin)))
    text = table(rows, asked.all)
    print(text)
    if asked.out:
        pathlib.Path(asked.out).write_text(text)
    print("\n".join("could not be run: " + one for one in lost))
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
