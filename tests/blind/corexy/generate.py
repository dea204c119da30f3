#!/usr/bin/env python3
"""Independent truth generator for blind tests: CoreXY machines measured by laser or tracker.

    generate.py OUT_FOLDER [--cases N] [--seed S]

writes OUT_FOLDER/case_000 ...: rows.csv, rows.yaml, machine.yaml (what a diagnosis may see), truth.json (the one hidden
cause) and detail.json (all that was drawn, and `equivalent`: other answers that describe the same rows). Standard library
only. Case i depends on the seed and i alone. Written from CONTRACT.md and nothing else. Sentences it rests on:

- "`position`: (actual - commanded) . n" (Measured row, `value_mm`); `motor_*_mm`: "the motors' commanded travel for the
  `cmd_` pose"; `dir_*`: "+1 or -1: sense of each axis or motor in the last approach; 0: did not move in it".
- "CoreXY: motor_a_mm = x + y, motor_b_mm = x - y; axes a b for what a motor, belt or screw does; cause `racking`
  (`angle_mrad`, the beam against the square of its rails)" (Made precise). So x = (a + b) / 2, y = (a - b) / 2.
- "Periodic: A sin(2 pi q / period + phase), q the commanded position"; "amplitudes are half peak-to-peak"; "signs as the
  error moves the tool"; "on a tower or screw, q and + are those of its motor_ column" (here: of the motor).
- "A belt, on any axis, has pulley_mm_per_rev in place of lead_mm": period of `pulley_eccentric`. `microstep`: 4 full steps.
- "scale is moved / commanded - 1 in ppm (+: moves too far)", taken for `belt_pitch` `error_ppm` too, from the homed place.
- "Sign check: backlash b touched in the sense the machine moves -b/2": the motor stands at -dir gap / 2.
- "Rotations are right-handed about their letter. Squareness turns the axis the same way: C0Y dx = -angle y."
- "`jump_um` +: the tool, carriage or bed ends further to +" (here: the motor's coordinate), for t_s >= at_t_s.

Choices where the contract is silent:
- Racking turns the beam right-handed about z (counter-clockwise from above) about its middle: dy = +sin(angle) (x - middle),
  dx = (cos(angle) - 1) (x - middle). C0Y exactly: dx = -sin(angle) y, dy = (cos(angle) - 1) y.
- Scale and belt pitch of a motor add: moved = (1 + scale + pitch) (commanded - homed). Home is x min, y min: a = b = 0.
- Every campaign is one line with its own `setup`, whose offset is a vector (x, y), the same for its along and across rows.
- Reference frame: in odd cases ONE real rotation about z of up to 2 mrad about the machine's origin, common to all
  rows of the case (instrument kind `tracker`); in even cases none (kind `laser`). Never one of its own for each setup.
- At least one line along x and one along y are read across too, in every case, whatever the cause.
- Nobody homes again during a case (`home` is 1), so a jump stays. It falls inside a campaign that shows it.
- In a third of the cases the motors stand on whole microsteps (nearest to the commanded place) and the rows keep the
  commanded place: up to half a step of error that repeats exactly. detail.json `whole_steps` tells.
"""
import argparse
import csv
import json
import math
import random
from pathlib import Path

FULL_STEPS = 200
CAUSES = ["pulley_eccentric", "belt_pitch", "racking", "squareness", "microstep", "missed_steps"]
COLUMNS = ["row", "campaign", "kind", "setup", "home", "rep", "t_s", "cmd_x_mm", "cmd_y_mm", "cmd_z_mm", "motor_a_mm",
           "motor_b_mm", "dir_x", "dir_y", "dir_z", "dir_a", "dir_b", "nx", "ny", "nz", "value_mm"]


def signed(rng, low, high):
    return round(rng.choice([-1, 1]) * rng.uniform(low, high), 4)


def sign(v):
    return (v > 0) - (v < 0)


def draw_machine(rng):
    return {"x": rng.choice([200, 250, 300, 350, 400]), "y": rng.choice([200, 250, 300, 350, 400]),
            "pulley": rng.choice([32, 40]), "microsteps": rng.choice([16, 32, 64, 128])}


def draw_truth(rng, machine):
    """The hidden cause as truth.json has it; `at_t_s` of missed steps is set when the times are known."""
    if rng.random() < 0.3:
        return {"cause": "none"}
    cause, motor = rng.choice(CAUSES), rng.choice("ab")
    phase = round(rng.uniform(0, 360), 2)
    axis, parameters = {
        "pulley_eccentric": (motor, {"amplitude_um": round(rng.uniform(8, 60), 3), "phase_deg": phase,
                                     "period_mm": machine["pulley"]}),
        "belt_pitch": (motor, {"error_ppm": signed(rng, 200, 1500)}),
        "racking": ("", {"angle_mrad": signed(rng, 0.3, 2.5)}),
        "squareness": ("C0Y", {"angle_mrad": signed(rng, 0.3, 2.5)}),
        "microstep": (motor, {"amplitude_um": round(rng.uniform(4, 15), 3), "phase_deg": phase}),
        "missed_steps": (motor, {"jump_um": signed(rng, 30, 150), "at_t_s": None}),
    }[cause]
    return {"cause": cause, "axis": axis, "parameters": parameters}


def equivalent(truth, rotated):
    """Other single causes that describe the same rows to first order, once the baseline (common scale) and, in a turned
    frame, its unknown rotation are free. All of them are one shear g: dx = (g / 2) y, dy = (g / 2) x."""
    if truth["cause"] not in ("belt_pitch", "racking", "squareness"):
        return []
    value = next(iter(truth["parameters"].values()))
    g = {("belt_pitch", "a"): value / 1000, ("belt_pitch", "b"): -value / 1000,
         ("racking", ""): value, ("squareness", "C0Y"): -value}[truth["cause"], truth["axis"]]      # mrad
    all_four = [{"cause": "belt_pitch", "axis": "a", "parameters": {"error_ppm": round(1000 * g, 4)}},
                {"cause": "belt_pitch", "axis": "b", "parameters": {"error_ppm": round(-1000 * g, 4)}},
                {"cause": "racking", "axis": "", "parameters": {"angle_mrad": round(g, 7)}},
                {"cause": "squareness", "axis": "C0Y", "parameters": {"angle_mrad": round(-g, 7)}}]
    return [e for e in all_four if (e["cause"], e["axis"]) != (truth["cause"], truth["axis"])
            and (rotated or e["cause"] == truth["cause"])]


def irregular(rng, length, n):
    """n increasing targets from 0 to `length`, one at random in each of n equal parts, whole micrometres."""
    return [round((i + rng.uniform(0.05, 0.95)) * length / n, 3) for i in range(n)]


def draw_lines(rng, machine, dense):
    """Campaigns: name, origin, direction of one unit of target (dx, dy), targets, repeats, across (0 or sign of n)."""
    lines, margin = [], 6.0
    size = {"x": machine["x"], "y": machine["y"]}

    def add(name, origin, step, length, n):
        lines.append({"name": name, "origin": origin, "step": step, "targets": irregular(rng, length, n),
                      "repeats": rng.choice([2, 3]), "across": rng.choice([-1, 1]) if rng.random() < 0.5 else 0})

    for axis, other in ("xy", "yx"):
        count = rng.choice([2, 3])
        group = len(lines)
        for k in range(count):                                   # spread over the other axis
            at = round((k + rng.uniform(0.2, 0.8)) * size[other] / count, 1)
            origin = (margin, at) if axis == "x" else (at, margin)
            step = (1, 0) if axis == "x" else (0, 1)
            add(f"line_{axis}_{k + 1}", origin, step, size[axis] - 2 * margin, rng.randint(15, 30))
        if not any(line["across"] for line in lines[group:]):
            rng.choice(lines[group:])["across"] = rng.choice([-1, 1])
    room = min(size.values())
    for motor, sy in (("a", 1), ("b", -1)):                      # motor a alone: (1, 1); motor b alone: (1, -1)
        x0 = margin + round(rng.uniform(0, size["x"] - room), 1)
        y0 = margin + round(rng.uniform(0, size["y"] - room), 1)
        origin = (x0, y0) if sy > 0 else (x0, y0 + room - 2 * margin)
        add(f"diagonal_{motor}", origin, (1, sy), room - 2 * margin, rng.randint(15, 30))
        if dense:                                                # a few microstep periods, one motor alone
            periods = rng.uniform(3.2, 5.7)                      # in the motor's travel, which is twice the target
            at = round(rng.uniform(0.2, 0.7) * room, 1)
            start = (origin[0] + at, origin[1] + sy * at)
            add(f"dense_{motor}", start, (1, sy), periods * 4 * machine["pulley"] / FULL_STEPS / 2, rng.randint(24, 30))
    rng.shuffle(lines)
    return lines


def actual(pose, dirs, t, m):
    """Where the tool truly is, in the machine's own frame. m: everything that is wrong with this machine."""
    truth, machine = m["truth"], m["machine"]
    cause, axis, p = truth["cause"], truth.get("axis", ""), truth.get("parameters", {})
    x, y = pose
    moved = {}
    for motor, q in (("a", x + y), ("b", x - y)):
        at = q
        if m["whole_steps"]:
            steps_per_mm = FULL_STEPS * machine["microsteps"] / machine["pulley"]
            at = round(q * steps_per_mm) / steps_per_mm
        scale, error = m["scale_ppm"] * 1e-6, -dirs[motor] * m["gap_um"][motor] * 1e-3 / 2
        if axis == motor:
            if cause == "belt_pitch":
                scale += p["error_ppm"] * 1e-6
            elif cause in ("pulley_eccentric", "microstep"):
                period = p.get("period_mm", 4 * machine["pulley"] / FULL_STEPS)
                error += p["amplitude_um"] * 1e-3 * math.sin(2 * math.pi * q / period + math.radians(p["phase_deg"]))
            elif cause == "missed_steps" and t >= p["at_t_s"]:
                error += p["jump_um"] * 1e-3
        moved[motor] = (1 + scale) * at + error                  # homed at a = b = 0
    x, y = (moved["a"] + moved["b"]) / 2, (moved["a"] - moved["b"]) / 2
    if cause == "squareness":
        angle = p["angle_mrad"] * 1e-3
        x, y = x - math.sin(angle) * y, math.cos(angle) * y
    elif cause == "racking":
        angle, middle = p["angle_mrad"] * 1e-3, machine["x"] / 2
        x, y = middle + math.cos(angle) * (x - middle), y + math.sin(angle) * (x - middle)
    return x, y


def visits(rng, lines):
    """Every standstill in the order measured: line, repetition, sense, commanded pose, time."""
    t, out = rng.uniform(10, 60), []
    for line in lines:
        (ox, oy), (sx, sy) = line["origin"], line["step"]
        for rep in range(1, line["repeats"] + 1):
            for sense in (1, -1):                                # there and back, turning beyond the ends
                for s in line["targets"][::sense]:
                    t += rng.uniform(3, 5)
                    out.append((line, rep, sense, (round(ox + s * sx, 3), round(oy + s * sy, 3)), round(t, 1)))
                t += rng.uniform(5, 10)
        t += rng.uniform(300, 900)                               # the instrument is set up anew
    return out


def place_jump(rng, truth, stops):
    """A time within the middle of a campaign along which the jump can be read (not the other motor's diagonal)."""
    blind = {"a": "_b", "b": "_a"}[truth["axis"]]
    name = rng.choice(sorted({s[0]["name"] for s in stops if not s[0]["name"].endswith(blind)}))
    times = [s[4] for s in stops if s[0]["name"] == name]
    k = rng.randint(len(times) // 5, 4 * len(times) // 5)
    truth["parameters"]["at_t_s"] = round((times[k - 1] + times[k]) / 2, 2)


def measure(rng, m, stops):
    offset = {line["name"]: (rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2)) for line in (s[0] for s in stops)}
    setup = {name: k for k, name in enumerate(dict.fromkeys(s[0]["name"] for s in stops), 1)}
    turn, rows = m["frame_rotation_mrad"] * 1e-3, []
    for line, rep, sense, (cx, cy), t in stops:
        sx, sy = (sense * c for c in line["step"])
        dirs = {"x": sx, "y": sy, "a": sign(sx + sy), "b": sign(sx - sy)}
        x, y = actual((cx, cy), dirs, t, m)
        ox, oy = offset[line["name"]]
        ex = math.cos(turn) * x - math.sin(turn) * y + ox - cx   # as the instrument's frame has it
        ey = math.sin(turn) * x + math.cos(turn) * y + oy - cy
        length = math.hypot(*line["step"])
        ux, uy = (c / length for c in line["step"])
        normals = [(ux, uy)] + ([(-uy * line["across"], ux * line["across"])] if line["across"] else [])
        for nx, ny in normals:
            value = ex * nx + ey * ny + rng.gauss(0, m["sigma_um"] * 1e-3)
            rows.append([len(rows) + 1, line["name"], "position", f"s{setup[line['name']]}", 1, rep, f"{t:.1f}",
                         f"{cx:.3f}", f"{cy:.3f}", f"{m['z_mm']:.3f}", f"{cx + cy:.3f}", f"{cx - cy:.3f}", dirs["x"],
                         dirs["y"], 0, dirs["a"], dirs["b"], f"{nx + 0.0:.9g}", f"{ny + 0.0:.9g}", 0,
                         f"{round(value, 4) + 0.0:.4f}"])
    return rows, offset


def machine_yaml(machine):
    def belt(size):
        return (f"{{min_mm: 0, max_mm: {size}, home: min, pulley_mm_per_rev: {machine['pulley']}, "
                f"full_steps_per_rev: {FULL_STEPS}, microsteps: {machine['microsteps']}}}")
    return ("format: 1\nname: corexy_blind\nkinematics: corexy\naxes:\n"
            f"  x: {belt(machine['x'])}\n  y: {belt(machine['y'])}\n"
            f"  z: {{min_mm: 0, max_mm: 250, home: max, lead_mm: 8, full_steps_per_rev: {FULL_STEPS}, microsteps: 16}}\n")


def header_yaml(m, names):
    kind = "tracker" if m["frame_rotation_mrad"] else "laser"
    text = (f"format: 1\nmachine: machine.yaml\ninstruments:\n"
            f"  {kind}: {{kind: {kind}, resolution_um: 0.1, sigma_um: {m['sigma_um']}}}\ncampaigns:\n")
    text += "".join(f"  {name}: {{instrument: {kind}}}\n" for name in names)
    if m["header_transmission"]:
        pulley = m["machine"]["pulley"]
        text += "transmission:\n" + "".join(
            f"  {motor}: {{pulley_mm_per_rev: {pulley}, full_steps_per_mm: {FULL_STEPS / pulley}}}\n" for motor in "ab")
    return text


def write_case(folder, seed, index):
    rng = random.Random(f"corexy {seed} {index}")
    machine = draw_machine(rng)
    truth = draw_truth(rng, machine)
    m = {"machine": machine, "truth": truth, "scale_ppm": round(rng.uniform(-500, 500), 2),
         "gap_um": {motor: round(rng.uniform(0, 30), 2) for motor in "ab"},
         "frame_rotation_mrad": signed(rng, 0.05, 2) if index % 2 else 0.0, "sigma_um": round(rng.uniform(1, 3), 2),
         "whole_steps": rng.random() < 1 / 3, "z_mm": round(rng.uniform(20, 200), 1),
         "header_transmission": rng.random() < 0.5}
    dense = rng.random() < 0.4 or truth["cause"] == "microstep"
    stops = visits(rng, draw_lines(rng, machine, dense))
    if truth["cause"] == "missed_steps":
        place_jump(rng, truth, stops)
    rows, offset = measure(rng, m, stops)

    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "rows.csv", "w", newline="", encoding="utf-8") as f:
        csv.writer(f, lineterminator="\n").writerows([COLUMNS] + rows)
    (folder / "rows.yaml").write_text(header_yaml(m, list(offset)), encoding="utf-8")
    (folder / "machine.yaml").write_text(machine_yaml(machine), encoding="utf-8")
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    m.update(seed=seed, case=index, rows=len(rows), setup_offset_mm=offset,
             equivalent=equivalent(truth, bool(m["frame_rotation_mrad"])))
    (folder / "detail.json").write_text(json.dumps(m, indent=1) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description="Blind CoreXY cases for a diagnosis program.")
    parser.add_argument("out", type=Path)
    parser.add_argument("--cases", type=int, default=48)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    for index in range(args.cases):
        write_case(args.out / f"case_{index:03d}", args.seed, index)


if __name__ == "__main__":
    main()
