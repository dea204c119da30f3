"""The hands that write the files: each drawn writer has columns, counting and headers of his own."""
import math
import numpy as np

XYZ = "xyz"


class Writer:
    def __init__(self, rng, needs, rows, kind):
        """Draws what this writer tells; `needs` is what the plan's purpose cannot do without."""
        u = rng.uniform
        self.rng, self.kind = rng, kind
        told = set(needs) | {"dir"}
        artefact = rows.touch.any()
        for word, chance in (("t", 0.5), ("temp", 0.15), ("sigma", 0.4), ("feature", 0.8), ("since", 0.15), ("header", 0.7),
                             ("row", 0.6), ("rep", 0.7), ("home", 0.4), ("setup", 1.0), ("dir_motor", 0.6), ("feed", 0.5), ("spin", 0.3)):
            if u() < chance:
                told.add(word)
        if "temp" in told:
            told.add("t")
        several = len({(c, s) for c, s in zip(rows.camp, rows.setup)}) > 1
        if not several and u() < 0.5:
            told.discard("setup")
        if len(set(rows.home)) > 1:
            told.add("home")
        if len(set(rows.feed[~np.isnan(rows.feed)])) > 1:
            told.add("feed")
        if np.isfinite(rows.load).any():
            told.add("load")
        if len(set(rows.spin)) > 1:
            told.add("spin")
        faces = {}
        for s, f, n in zip(rows.setup, rows.feature, rows.n):
            faces.setdefault((s, tuple(np.round(np.abs(n)).tolist())), set()).add(f)
        undrawn = any(a.get("sizes") is None or a.get("kind") in ("block", "ring") for a in rows.artefacts.values())
        if artefact and (undrawn or any(len(f) > 1 for f in faces.values())):
            told.add("feature")
        if any(a.get("kind") in ("square", "straight_edge", "block", "ring") for a in rows.artefacts.values()):
            told |= {"feature", "header"}          # whoever touches these must say what they are, or nobody can know
        if (rows.feature == "glass.grid").any():
            told |= {"feature", "header"}          # that a gauge looks at a plate: it lies there turned
        if not (rows.feature != "").any():
            told.discard("feature")
        rows.told = self.told = told
        self.base = {w: int(rng.choice([0, 1, 1, 7])) for w in ("row", "rep", "home", "setup")}
        self.decimals = int(rng.choice([4, 5, 6]))
        self.stated = float(rng.uniform(0.85, 1.2)) if u() < 0.5 else 1.0
        self.setup_words = bool(u() < 0.3)

    def temp_names(self, needs_all):
        names = ["screw", "frame", "bed"]
        if self.rng.uniform() < 0.5:
            names.append(str(self.rng.choice(["chamber", "ambient"])))
        return names

    def table(self, rows, value):
        told, rng, n = self.told, self.rng, rows.N
        columns = {}
        num = lambda a, d: [("" if not np.isfinite(v) else (f"{v:.{d}f}".rstrip("0").rstrip(".") or "0")) for v in a]
        fixed = lambda a, d: [f"{v:.{d}f}" for v in a]
        columns["campaign"] = list(rows.camp)
        if "row" in told:
            columns["row"] = [str(i + self.base["row"]) for i in range(n)]
        if (rows.kind != "position").any() or rng.uniform() < 0.5:
            columns["kind"] = list(rows.kind)
        for word in ("setup", "home", "rep"):
            if word in told:
                array = getattr(rows, word)
                columns[word] = [str(v + self.base[word]) for v in array]
        if "setup" in told and self.setup_words:
            columns["setup"] = [chr(97 + v % 26) + "_" + str(v) for v in rows.setup]
        if "t" in told:
            columns["t_s"] = fixed(rows.t, 1)
        if "temp" in told:
            for name in self.temp_names(True):
                columns[f"temp_{name}_c"] = fixed(rows.weather.read(name, rows.t) + rng.normal(0, 0.01, n), 2)
        moved = [k for k in range(3) if np.ptp(rows.cmd[:, k]) > 0 or np.abs(rows.n[:, k]).max() > 0]
        bare = len(moved) == 1 and not rows.touch.any() and self.kind == "gantry" and rng.uniform() < 0.7
        for k in range(3):
            if not bare or k in moved:
                columns[f"cmd_{XYZ[k]}_mm"] = num(rows.cmd[:, k], 4)
        if rows.motor is not None:
            for k, a in enumerate("abc"):
                columns[f"motor_{a}_mm"] = fixed(rows.motor[:, k], 5)
                if "dir_motor" in told:
                    columns[f"dir_{a}"] = [str(int(v)) for v in rows.dir_motor[:, k]]
        for k in range(3):
            if np.abs(rows.dir[:, k]).max() > 0 or (not bare and rng.uniform() < 0.5):
                if self.kind == "gantry" or k in moved:
                    columns[f"dir_{XYZ[k]}"] = [str(int(v)) for v in rows.dir[:, k]]
        if "since" in told and self.kind == "gantry":
            since = rows.plays["[]"][1]
            for k in range(3):
                if np.abs(rows.dir[:, k]).max() > 0:
                    columns[f"since_rev_{XYZ[k]}_mm"] = [f"{v:.4f}" if abs(d) > 0 else "" for v, d in zip(since[:, k], rows.dir[:, k])]
        if "feed" in told and np.isfinite(rows.feed).any():
            columns["feed_mm_s"] = num(rows.feed, 3)
        if "load" in told:
            columns["load_n"] = num(rows.load, 2)
        if not bare:
            for k in range(3):
                columns[f"n{XYZ[k]}"] = num(rows.n[:, k] + 0.0, 7)
        if "feature" in told:
            columns["feature"] = list(rows.feature)
        if np.ptp(rows.turn) > 0:
            columns["artefact_turn_deg"] = num(rows.turn, 3)
        if "spin" in told and rows.touch.any():
            columns["probe_angle_deg"] = num(rows.spin, 2)
        for k in range(3):
            if np.ptp(rows.off[:, k]) > 0:
                columns[f"probe_off_{XYZ[k]}_mm"] = num(rows.off[:, k], 3)
        columns["value_mm"] = fixed(value, self.decimals)
        if "sigma" in told:
            columns["sigma_mm"] = num(rows.sigma * self.stated, 6)
        if rng.uniform() < 0.1:
            columns["flag"] = ["" if u > 0.01 else "chip?" for u in rng.uniform(0, 1, n)]
        if rng.uniform() < 0.25:
            columns["operator"] = [str(rng.choice(["mk", "jr", "Anna"]))] * n
        if rng.uniform() < 0.2:
            columns["humidity_pct"] = fixed(45 + 2 * np.sin(rows.t / 900.0), 1)
        return columns

    def csv(self, rows, value):
        rng, columns = self.rng, self.table(rows, value)
        names = list(columns)
        if rng.uniform() < 0.5:
            names = [names[i] for i in rng.permutation(len(names))]
        order = np.arange(rows.N)
        if "row" in self.told and rng.uniform() < 0.12:
            order = rng.permutation(rows.N)
        lines = []
        if rng.uniform() < 0.4:
            lines.append(f"# measured with care, {rows.N} rows")
        lines.append(",".join(names))
        note = int(rng.integers(0, rows.N)) if rng.uniform() < 0.2 else -1
        for i, r in enumerate(order):
            if i == note:
                lines.append("# coffee")
            lines.append(",".join(columns[c][r] for c in names))
        return "\n".join(lines) + "\n"

    def header(self, rows, machine, kinds):
        """DATA.yaml, much or little of it; None where this writer writes none."""
        if "header" not in self.told:
            return None
        rng, out = self.rng, ["format: 1"]
        wordy = rng.uniform() < 0.6
        if wordy:
            out.append(f"machine: {machine.name}")
            out += machine.header_settings()
            out.append("instruments:")
            for name, k in kinds.items():
                out.append(f"  i_{name}: {{kind: {k['kind']}, resolution_um: {k['res'] * 1e3:g}, sigma_um: {k['sigma'] * self.stated * 1e3:.2f}}}")
            out.append("campaigns:")
            out += [f"  {name}: {{instrument: i_{name}}}" for name in kinds]
        arts = {}
        if "feature" in self.told:
            for setup, a in rows.artefacts.items():
                mine = np.flatnonzero(rows.setup == setup)
                if len(mine) and rows.feature[mine[0]] and a.get("kind"):
                    name = rows.feature[mine[0]].split(".")[0]
                    more = ""
                    if a.get("sizes") and (wordy or a["kind"] in ("block", "ring")):
                        sizes = [round(s, 4) for s in a["sizes"]]
                        more = f", sizes_mm: {sizes}"
                        if a["kind"] in ("block", "ring", "square", "straight_edge"):
                            more += f", u_um: {1.0 if a['kind'] != 'ring' else 0.5}"
                    arts[name] = f"  {name}: {{type: {a['kind']}{more}}}"
        if arts:
            out += ["artefacts:"] + list(arts.values())
        return "\n".join(out) + "\n"


def yaml_list(values):
    return "{" + ", ".join(f"{k}: {v:g}" for k, v in values) + "}"


def gantry_machine(m, rng):
    full = rng.uniform() < 0.6
    out = ["format: 1", f"name: {m.name}", "kinematics: cartesian", "axes:"]
    for k, a in enumerate(XYZ):
        lead = f"{'pulley_mm_per_rev' if m.belt[k] else 'lead_mm'}: {m.turn_mm[k]:g}, full_steps_per_rev: {m.full}"
        more = f", microsteps: {m.micro[k]}" + (", max_feed_mm_s: 100" if full else "")
        out.append(f"  {a}: {{min_mm: {m.lo[k]:g}, max_mm: {m.hi[k]:g}, home: min, {lead}{more}}}")
    out.append(f"probe: {{tip_radius_mm: {m.tip_cfg:g}}}")
    if full or any(m.belt):
        out.append(f"settings: {{steps_per_mm: {yaml_list(zip(XYZ, m.steps))}, tip_radius_mm: {m.tip_cfg:g}}}")
    return "\n".join(out) + "\n"


def clean(v):
    if isinstance(v, float):
        return None if math.isnan(v) else v
    return v
