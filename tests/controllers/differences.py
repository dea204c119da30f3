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


@dataclasses.dataclass(frozen=True)
class Case:
    line: str                    # Lines of one case: one behind another, `;;` between.
    why: str = ""                # Why they differ, for the table.
    twin: str = ""               # What the emulation is told in its place.
    before: tuple = None         # In place of the group's: as it was switched on, ().
    twin_before: tuple = None
    program: bool = False        # LinuxCNC: a .ngc file.

    def real_lines(self):
        return [line.strip() for line in self.line.split(";;")]

    def emulated_lines(self):
        return [line.strip() for line in (self.twin or self.line).split(";;")]

    def before_real(self, group):
        return group.before if self.before is None else self.before

    def before_emulated(self, group):
        other = self.before if self.twin_before is None else self.twin_before
        return group.twin_before if other is None else other

    def is_homed(self):
        return self.before is None

    def shown(self):
        both = self.line.replace(";;", "⏎") + (f" / {self.twin.replace(';;', '⏎')}" if self.twin else "")
        return ("as switched on: " if self.before == () else "") + both


@dataclasses.dataclass(frozen=True)
class Group:
    title: str
    machine: str
    real: str                    # klipper, linuxcnc
    emulated: str                # rrf, marlin, klipper
    truth: str
    before: tuple                # What both hear first.
    twin_before: tuple
    cases: tuple

    @property
    def same_dialect(self):
        return self.real == self.emulated

    @property
    def real_name(self):
        return "Klipper's host" if self.real == "klipper" else "LinuxCNC"


def numbered(number, line):
    sum_ = 0
    for byte in f"N{number} {line}".encode():
        sum_ ^= byte
    return f"N{number} {line}*{sum_}"


OFF = ()                         # As it was switched on.
# Why they differ. Those that begin with DEFECT ought to be mended in the emulation.
HOP = "the host homes at [safe_z_home] and hops to 12; the emulation stays over the middle, 10 over the switch"
BACK_OFF = "Kalico ends 5 mm off each switch, the emulation on it"
FLAT = "the station's emulation has one axis: X and Y are always there"
WORDS = "one refusal, other words"
REMARK = "the emulation passes over words that it does not read; Klipper's remarks begin with ;"
ON_WIRE = "DEFECT: the wire counts lines as Marlin does, whatever the dialect"
ELSEWHERE = "DEFECT: not known, and the move behind it goes elsewhere"
NOT_KNOWN = "not in the emulation; the next line is then another one"
FEED = "DEFECT: the emulation reads no F"
DUPLICATE = "DEFECT: the emulation takes the first of two, Klipper the last"
STRICTER = "stricter than Klipper, which reads Xabc as a word of its own"
POSITION = "documented as missing: lines mcu: and stepper:"
UNHOMED = "one refusal, other words"
OFFSET_XY = "refused: no offsets in X and Y here"
RESTS = "the real one tells each touch; both end on the trigger"
SPEED = "DEFECT: PROBE's own words are passed over in silence"
ACCURACY = "each touch is told, and a delta more; the figures agree"
SITE = "printer.cfg says where, and 5 mm, 4 mm/s; the emulation stays where it is"
CALIBRATE = ("other words, of which `caltwin calibrate` reads both; the offset agrees. "
             "It ends over the bed, the emulation at the dock")
MESH = "printer.cfg has no [bed_mesh]"
REACH = "DEFECT: a delta's emulation knows no lowest Z"
STEP = "one step of all towers: Klipper stops in the step behind the trigger, the emulation rounds"
SAVES = "DELTA_CALIBRATE is in force after SAVE_CONFIG, G33 at once"
G92 = "RepRapFirmware moves the machine's zero, Klipper and LinuxCNC shift the work"
INCHES = "refused: no inches here"
NAMES = "commands of several letters are no G-code to RepRapFirmware"
MEAN = "Klipper levels to [probe] z_offset (-0.02), G30 S to where the probe acts"
G28_GOES = "LinuxCNC's G28 goes to a stored place, from the start 0 0 0, in rapid; RepRapFirmware's homes"
G28_WORD = "LinuxCNC wants a number, RepRapFirmware the bare letter"
BLANKS = "LinuxCNC takes blanks away first"
NO_FEED = "LinuxCNC wants F before the first G1; RepRapFirmware has one from the start"
STRICT = "LinuxCNC is stricter"
NO_MOVE = "DEFECT: words behind G53, G90 and G54 without G0 or G1 are lost in silence"
P_WANTED = "LinuxCNC wants P; RepRapFirmware takes the one in force"
ARC = "refused: no arcs here"
TOOL_OFFSET = "DEFECT: a warning alone, and later moves go elsewhere; no tool offsets here"
LANGUAGE = "another language: # and [] are LinuxCNC's, {} RepRapFirmware's"
CYCLE = "DEFECT: a warning alone, and no hole is drilled"
M_CODES = "a printer's M code"
TRAVEL = "the INI file is written with 5 mm under the drawing's Z, the emulation keeps to the drawing"
OVERSHOOT = "LinuxCNC slows down behind the trigger: #5063 is the place, not where it stands"
PROBE_FEED = "LinuxCNC wants F; RepRapFirmware has a speed of its own"
PARAMETER = "RepRapFirmware has no #5063: M114 or move.axes[].userPosition"
ENDS = "M2 is not known, with a warning; lines on a wire have no end"
G_UNKNOWN = "LinuxCNC refuses, the emulation warns and goes on"
MODELESS = "only LinuxCNC and the gantry's emulation know it"
OVER_BED = ("G28", "G1 X117.5 Y100 F6000", "G1 Z15 F600")
STATION = Group(
    "A printer's Z station: Klipper against Klipper's dialect", "z_station", "klipper", "klipper",
    "{switch_offset: {off_um: 80}}", OVER_BED, (*OVER_BED, "ATTACH_PROBE", "G1 X117.5 Y100 F6000", "G1 Z15 F600"),
    (
        Case("G28", HOP, before=OFF),
        Case("G28 X", FLAT, before=OFF),
        Case("G28 Z", FLAT, before=OFF),
        Case("G1 Z20 F600", WORDS, before=OFF),
        Case("G28 X Y ;; G1 X50 F3000", FLAT, before=OFF),
        Case("G1 Z20 F600"),
        Case("g1 z20 f600"),
        Case("G1X50Y50F3000", "DEFECT: words without blanks are one word to the emulation"),
        Case("G0 X50 (to the left) Y60", REMARK),
        Case("G1 X50 ; to the left"),
        Case("; a remark alone"),
        Case(numbered(3, "G1 X50"), ON_WIRE),
        Case("N3 G1 X50*1", ON_WIRE),
        Case("G90 G1 X50"),
        Case("G1 X500", WORDS),
        Case("G1 Z-6", WORDS),
        Case("G1 X50 F0", FEED),
        Case("G1 X50 F-100", FEED),
        Case("G1 Xabc", STRICTER),
        Case("G1 X", WORDS),
        Case("G1 Z20 Z30", DUPLICATE),
        Case("G91 ;; G1 X5", ELSEWHERE),
        Case("G92 X0 ;; G1 X5", ELSEWHERE),
        Case("G20", WORDS),
        Case("G21"),
        Case("G4 P100"),
        Case("G2 X50 Y50 I10 J0"),
        Case("G29"),
        Case("M18 ;; G1 X50", NOT_KNOWN),
        Case("M82"),
        Case("M105"),
        Case("M112", "DEFECT: not in the emulation: it goes on"),
        Case("M114"),
        Case("M115"),
        Case("M117 hello"),
        Case("M118 hello"),
        Case("M400"),
        Case("T0"),
        Case("FROBNICATE"),
        Case("GET_POSITION", POSITION),
        Case("STATUS"),
        Case("QUERY_PROBE"),
        Case("QUERY_ENDSTOPS"),
        Case("SAVE_GCODE_STATE NAME=a ;; G1 X50 ;; RESTORE_GCODE_STATE NAME=a MOVE=1", ELSEWHERE),
        Case("SET_GCODE_VARIABLE MACRO=m VARIABLE=v VALUE=1"),
        Case("SET_KINEMATIC_POSITION Z=20"),
        Case("SET_GCODE_OFFSET Z=0.1 ;; GET_POSITION", POSITION),
        Case("SET_GCODE_OFFSET Z=0.1 ;; G1 Z10 F600"),
        Case("SET_GCODE_OFFSET Z_ADJUST=0.1 MOVE=1"),
        Case("SET_GCODE_OFFSET Z=0.1 MOVE=1", UNHOMED, before=OFF),
        Case("SET_GCODE_OFFSET X=1 ;; G1 X50", OFFSET_XY),
        Case("SET_GCODE_OFFSET Z=abc"),
        Case("PROBE", RESTS),
        Case("PROBE", WORDS, before=OFF),
        Case("PROBE SAMPLES=5 SAMPLES_RESULT=median", RESTS),
        Case("PROBE PROBE_SPEED=-1", SPEED),
        Case("PROBE_ACCURACY", ACCURACY),
        Case("PROBE_ACCURACY SAMPLES=3", ACCURACY),
        Case("PROBE_ACCURACY SAMPLES=0", WORDS),
        Case("G1 X20 Y150 ;; PROBE", RESTS),
        Case("PROBE ;; PROBE", RESTS),
        Case("PROBE ;; PROBE_ACCURACY", RESTS),
        Case("PROBE ;; G1 Z15 ;; PROBE", RESTS),
        Case("PROBE_CALIBRATE"),
        Case("PROBE_Z_ACCURACY", SITE),
        Case("CALIBRATE_Z", CALIBRATE, before=OFF),
        Case("CALIBRATE_Z", CALIBRATE),
        Case("CALIBRATE_Z ;; GET_POSITION", CALIBRATE),
        Case("CALIBRATE_Z ;; CALIBRATE_Z", CALIBRATE),
        Case("SET_GCODE_OFFSET Z=0.3 ;; CALIBRATE_Z", CALIBRATE),
        Case("BED_MESH_CALIBRATE"),
        Case("BED_MESH_CLEAR", MESH),
        Case("SAVE_CONFIG"),
        Case("FIRMWARE_RESTART ;; G1 Z20", NOT_KNOWN),
    ))

DELTA = Group(
    "A delta: Klipper against Marlin's dialect", "delta_printer", "klipper", "marlin",
    "{endstop.a: {error_mm: 0.3}, delta_radius: {error_mm: 0.8}}",
    ("G28", "G1 X0 Y0 Z20 F6000"), ("G28", "G1 X0 Y0 Z20 F6000"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G28 X", BACK_OFF, before=OFF),
        Case("G1 X5", before=OFF),
        Case("G1 X30 Y20 F6000"),
        Case("g1 x30 y20"),
        Case("G1X30Y20F6000"),
        Case("G1 X30 (right) Y20", "the emulation takes remarks in brackets, Klipper none"),
        Case("G1 X30 F0", FEED),
        Case("G1 X300"),
        Case("G1 Z-40", REACH),
        Case("G1 Z320", REACH),
        Case("G91 ;; G1 X5 Z-5", ELSEWHERE),
        Case("G92 X10 ;; G1 X15", ELSEWHERE),
        Case("G20 ;; G1 X1", INCHES),
        Case("G4 P10"),
        Case("G2 X10 Y0 I5 J0"),
        Case("G29"),
        Case("M84 ;; G1 X5", NOT_KNOWN),
        Case("M112", "DEFECT: not in the emulation: it goes on"),
        Case("M114"),
        Case("M117 hello"),
        Case("M400"),
        Case("FROBNICATE"),
        Case("PROBE", STEP, twin="G30"),
        Case("G1 X60 Y-30 ;; PROBE", twin="G30 X60 Y-30"),
        Case("PROBE", twin="G30", before=OFF),
        Case("DELTA_CALIBRATE ;; G28 ;; G1 X0 Y0 Z20 F6000 ;; PROBE", SAVES, twin="G33 P2 ;; G28 ;; G30 X0 Y0"),
        Case("DELTA_CALIBRATE ;; SAVE_CONFIG ;; G28 ;; G1 X0 Y0 Z20 F6000 ;; PROBE",
             "both within a step of 12.5 um", twin="G33 P2 ;; M500 ;; G28 ;; G30 X0 Y0"),
        Case("DELTA_CALIBRATE ;; G28 ;; G1 X60 Y-30 Z20 F6000 ;; PROBE", SAVES, twin="G33 P2 ;; G28 ;; G30 X60 Y-30"),
    ))

SCREWS = Group(
    "A bed on three screws: Klipper against RepRapFirmware's dialect", "triple_z_printer", "klipper", "rrf",
    "{bed_tilt: {slope_x_mrad: 2, slope_y_mrad: -1}}", ("G28", "G1 Z10 F600", "G1 X100 Y100 F6000"),
    ("G28", "G1 Z10 F600", "G1 X100 Y100 F6000"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G1 X5", before=OFF),
        Case("G28 X Y", BACK_OFF, before=OFF),
        Case("G1 X50 Y60 F6000"),
        Case("G91 ;; G1 X5"),
        Case("G1 X500"),
        Case("G92 X10 ;; G1 X15", G92),
        Case("G20 ;; G1 X1", INCHES),
        Case("M84 ;; G1 X5"),
        Case("M112"),
        Case("FROBNICATE", NAMES),
        Case("G29"),
        Case("G32"),
        Case("PROBE", twin="G30 S-1"),
        Case("G1 X30 Y30 ;; PROBE", twin="G1 X30 Y30 ;; G30 S-1"),
        Case("Z_TILT_ADJUST ;; G1 X200 Y30 ;; PROBE", MEAN,
             twin="M671 X20:215:20 Y20:20:215 S10 ;; G30 P0 X20 Y20 Z-99999 ;; G30 P1 X215 Y20 Z-99999 ;;"
                  " G30 P2 X20 Y215 Z-99999 S3 ;; G1 X200 Y30 ;; G30 S-1"),
        Case("Z_TILT_ADJUST", before=OFF, twin="G30 P0 X20 Y20 Z-99999"),
    ))

ROUTER = Group(
    "A gantry: LinuxCNC against RepRapFirmware's dialect", "gantry_router", "linuxcnc", "rrf",
    "{backlash.z: {gap_mm: 0.1}}", ("G0 X100 Y100", "G0 Z20"), ("G28", "G0 X100 Y100", "G0 Z20"),
    (
        Case("G28", G28_GOES),
        Case("G28 X", G28_WORD),
        Case("G28 X10"),
        Case("G0 X50", before=OFF),
        Case("G38.2 Z-5 F60", TRAVEL, before=OFF),
        Case("G0 X50 Y60"),
        Case("g0x50y60"),
        Case("G0 X 5 0 Y60", BLANKS),
        Case("G1 X50", NO_FEED),
        Case("G1 X50 F600"),
        Case("G1 X50 F0"),
        Case("G1 X50 F-100"),
        Case("G0 X50 ;; Y60"),
        Case("G1 F600 ;; X50"),
        Case("G0 X50 (left) Y60 ; a remark"),
        Case("N10 G0 X50", ON_WIRE),
        Case(numbered(3, "G0 X50")),
        Case("G0 X500"),
        Case("G0 Z-6"),
        Case("G0 X"),
        Case("G0 X50 X60", STRICT),
        Case("G0 G1 X50 F600", STRICT),
        Case("G90 G0 X50"),
        Case("G91 G0 X5"),
        Case("G91 ;; G0 X5 ;; G90 ;; G0 Y50"),
        Case("G53 G0 X50"),
        Case("G53 X50", NO_MOVE),
        Case("G90 X50", NO_MOVE),
        Case("G54 X50", NO_MOVE),
        Case("G10 L2 P1 X10 ;; G0 X50"),
        Case("G10 L20 P1 X0 ;; G0 X5"),
        Case("G10 L2 P2 X10 ;; G55 ;; G0 X50"),
        Case("G10 L2 X10 ;; G0 X50", P_WANTED),
        Case("G59.3 G0 X50"),
        Case("G92 X0 ;; G0 X5", G92),
        Case("G92 X0 ;; G92.1 ;; G0 X50", G92),
        Case("G92 X0 ;; G53 G0 X50"),
        Case("G20 ;; G0 X1", INCHES),
        Case("G2 X120 Y100 I10 J0 F600", ARC),
        Case("G18"),
        Case("G4 P0.1 ;; G0 X50"),
        Case("G43 H1"),
        Case("G43.1 Z5 ;; G0 Z20", TOOL_OFFSET),
        Case("G54 G17 G40 G49 G80 G94 ;; G0 X50"),
        Case("G64 P0.01"),
        Case("G81 X50 Y50 Z10 R20 F600", CYCLE),
        Case("#1=50 ;; G0 X#1", LANGUAGE),
        Case("#<_left>=50 ;; G0 X#<_left>", LANGUAGE),
        Case("G0 X[40+10]", LANGUAGE),
        Case("G0 X{40+10}", LANGUAGE),
        Case("M3 S1000"),
        Case("M0"),
        Case("M6 T1"),
        Case("T1", "no tools in the emulation but the probe, T0"),
        Case("M400", M_CODES),
        Case("M114", M_CODES),
        Case("M112", M_CODES),
        Case("M2"),
        Case("M999", M_CODES),
        Case("G200", G_UNKNOWN),
        Case("FROBNICATE"),
        Case("%"),
        Case("G38.2 Z-5 F60", TRAVEL),
        Case("G38.2 Z0 F60", OVERSHOOT),
        Case("G38.2 Z0 F600", OVERSHOOT),
        Case("G38.2 Z0", PROBE_FEED),
        Case("G38.2 Z10 F60"),
        Case("G38.3 Z10 F60"),
        Case("G38.3 Z0 F60", OVERSHOOT),
        Case("G38.4 Z20 F60"),
        Case("G38.2 Z0 F60 ;; G38.4 Z10 F60", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G38.5 Z10 F60", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G38.2 Z0 F60"),
        Case("G38.2 F60"),
        Case("G38.2 X100 Y100 Z20 F60"),
        Case("G38.6 Z0 F60", G_UNKNOWN),
        Case("G38.2 Z0 F60 ;; G10 L20 P1 Z0 ;; G0 Z5", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G92 Z0 ;; G0 Z5", OVERSHOOT),
        Case("G38.2 Z0 F60 ;; G10 L2 P1 Z#5063 ;; G0 Z5", PARAMETER),
        Case("o100 repeat [3] ;; G91 G0 X5 ;; o100 endrepeat ;; G90 ;; M2", LANGUAGE, program=True),
        Case("G21 G90 G17 ;; G0 X50 Y50 ;; G1 X60 F600 ;; M2", "M2 is not known, with a warning", program=True),
        Case("G10 L2 P1 X10 ;; G54 ;; G0 X50 ;; M2 ;; G0 X60", ENDS, program=True),
        Case("G0 X50 ;; M30", "M30 is not known, with a warning", program=True),
    ))

MESH = Group(
    "A gantry: Klipper against RepRapFirmware's dialect", "gantry_router", "klipper", "rrf",
    "{backlash.z: {gap_mm: 0.1}}", ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G1 X50", before=OFF),
        Case("G1 X50 Y60 F3000"),
        Case("G1 X500"),
        Case("G92 X0 ;; G1 X5", G92),
        Case("G20 ;; G1 X1", INCHES),
        Case("G53 G1 X50", MODELESS),
        Case("G10 L2 P1 X10", MODELESS),
        Case("G38.2 Z-5 F60", MODELESS),
        Case("G2 X120 Y100 I10 J0 F600"),
        Case("PROBE", twin="G30 S-1"),
        Case("PROBE_ACCURACY", twin="G30 S-1"),
        Case("G29"),
        Case("BED_MESH_CALIBRATE", NAMES),
        Case("M84 ;; G1 X50"),
    ))

COREXY = Group(
    "A CoreXY: Klipper against RepRapFirmware's dialect", "corexy_printer", "klipper", "rrf",
    "{backlash.z: {gap_mm: 0.1}}", ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    ("G28", "G1 X100 Y100 F6000", "G1 Z20 F600"),
    (
        Case("G28", BACK_OFF, before=OFF),
        Case("G1 X50 Y60 F3000"),
        Case("G1 X500"),
        Case("G92 X0 ;; G1 X5", G92),
        Case("PROBE", twin="G30 S-1"),
    ))

GROUPS = (STATION, DELTA, SCREWS, ROUTER, MESH, COREXY)


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
