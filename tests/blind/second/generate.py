#!/usr/bin/env python3
"""Writes cases of the second world: null data and planted causes. See README.md."""
import argparse
import json
import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np                                             # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import chain                                                   # noqa: E402
import delta                                                   # noqa: E402
import delta_runs                                              # noqa: E402
import gantry                                                  # noqa: E402
import gantry_causes                                           # noqa: E402
import gantry_runs                                             # noqa: E402
import screws                                                  # noqa: E402
import screws_runs                                             # noqa: E402
import visibility                                              # noqa: E402
import writers                                                 # noqa: E402

HIDDEN = {"second", "cubic", "fourth", "draws", "half_mm", "cause", "axis", "nuts"}
POSITIVE = gantry_causes.POSITIVE


class Kind:
    """The parts of a world that differ by kind of machine."""

    def __init__(self, machine, builder, causes, fillers, candidates, baseline, machine_yaml):
        self.machine, self.builder, self.causes, self.fillers = machine, builder, causes, fillers
        self.candidates, self.baseline, self.machine_yaml = candidates, baseline, machine_yaml


def kinds():
    out = {"gantry": Kind(gantry.Gantry, gantry_runs.Builder, gantry_causes.CAUSES, gantry_causes.fillers,
                          gantry_causes.twin_candidates, visibility.gantry_baseline, writers.gantry_machine)}
    out["delta"] = Kind(delta.Delta, delta_runs.Builder, delta_runs.CAUSES, delta_runs.fillers, delta_runs.twin_candidates,
                        delta.baseline, delta.machine_yaml)
    out["triple_z"] = Kind(screws.TripleZ, screws_runs.Builder, screws_runs.CAUSES, screws_runs.fillers,
                           screws_runs.twin_candidates, screws.baseline, screws.machine_yaml)
    return out


def prepare(kind, plan_of, rng):
    """Draws a machine and the campaigns that show `plan_of`, in the order measured; None where the draw does not suit."""
    machine, rows = kind.machine(rng), chain.Rows()
    b = kind.builder(rng, machine, rows)
    fill_first = rng.uniform() < 0.4
    if fill_first:
        kind.fillers(b)
    before = len(rows.items)
    recipe = kind.causes[plan_of](b)
    if recipe is None:
        return None
    after = len(rows.items)
    if not fill_first:
        kind.fillers(b)
    if not 50 <= len(rows.items) <= 650:
        return None
    rows.close(rng)
    rows.weather = chain.Weather(rng, rows.t[-1], recipe.get("warm", False))
    machine.settle(rows, rng)
    writer = writers.Writer(rng, recipe.get("needs", set()), rows, machine.kind)
    if machine.kind != "gantry":
        writer.told |= recipe.get("needs", set())
    if "tau_share" in recipe:
        recipe["tau_s"] = recipe.pop("tau_share") * float(rows.t[-1])
    if "jump" in recipe:
        i = before + int(recipe.pop("jump") * (after - before))
        recipe["at_t_s"] = float((rows.t[i - 1] + rows.t[i]) / 2)
    rows.plain = machine.measure(rows, [])
    return machine, rows, b, recipe, writer


def sized(cause, recipe, size):
    c = {k: v for k, v in recipe.items() if k not in ("limits", "needs", "warm", "sign", "positive", "size", "fixed")}
    c["cause"] = cause
    if recipe["size"]:
        c[recipe["size"]] = size
        for other, share in recipe.get("fixed", {}).items():
            c[other] = size * share
    return c


def plant(kind, cause, machine, rows, recipe, rng):
    """Chooses the size of a cause by what the plan sees of it. None where it cannot be shown."""
    sigma = machine.reading_sigma(rows)
    columns, priors = kind.baseline(machine, rows)
    project = visibility.Projector(columns, sigma, priors)
    lo, hi = recipe["limits"]
    target = float(np.exp(rng.uniform(np.log(3.3), np.log(20))))
    sign = 1.0 if recipe["size"] in POSITIVE or recipe.get("positive") else float(rng.choice([-1, 1]))
    if recipe["size"] in ("extra_mm", "compliance_um_per_n", "height_um") and cause in ("backlash_worn", "windup_load", "reversal_spike"):
        sign = 1.0
    size = (lo * hi) ** 0.5 * sign
    for _ in range(3 if recipe["size"] else 1):
        size = float(f"{size:.9g}")                    # so that the last bit of a sum does not show
        truth = sized(cause, recipe, size)
        effect = machine.measure(rows, [truth]) - rows.plain
        seen, energy = visibility.near_peak(project(effect), rows, sigma)
        if not recipe["size"]:
            break
        if seen < 1e-3 * abs(size) / hi:
            return None
        if abs(seen / target - 1) < 0.02:
            break
        size *= target / seen
        if not lo <= abs(size) <= hi:
            return None
    if seen < 3 or energy < 100:
        return None
    return truth, effect, seen, energy, project


def find_twins(kind, machine, rows, truth, effect, project):
    candidates = []
    for name, axis, groups in kind.candidates(machine, rows):
        candidates.append((name, axis, [[machine.effect(rows, dict(p, cause=name, axis=axis)) for p in g] for g in groups]))
    for axis in machine.event_axes(rows) if hasattr(machine, "event_axes") else "xyz":
        candidates += visibility.event_columns(rows, axis, machine.unit_motion(rows, axis))
    return visibility.twins(project, effect, candidates, (truth["cause"], truth["axis"]))


def readings(machine, rows, causes, rng):
    """The gauges' own readings: noise, sometimes slow wander, resolution, the odd outlier."""
    value = machine.measure(rows, causes, counts=True) + rng.normal(0, 1, rows.N) * rows.sigma
    if rng.uniform() < 0.15:
        steps = np.sqrt(np.maximum(np.diff(rows.t, prepend=0.0), 0)[:, None] / 3600.0) * rng.normal(0, 1, (rows.N, 3))
        walk = np.cumsum(steps, 0) * rng.uniform(0.2, 1.0) * 1e-3
        value += np.where(rows.touch, -1.0, 1.0) * (walk * rows.n).sum(1)
    wrong = []
    if rng.uniform() < 0.4:
        wrong = sorted(int(i) for i in rng.choice(rows.N, int(rng.integers(1, 4)), replace=False))
        value[wrong] += rows.sigma[wrong] * rng.uniform(8, 60, len(wrong)) * rng.choice([-1, 1], len(wrong))
    return np.round(value / rows.res) * rows.res, wrong


def draw_case(kind_name, cause, seed):
    """One case from its own stream, as objects. `cause` None: null data, of a plan that would show some cause."""
    kind = kinds()[kind_name]
    rng = np.random.default_rng(seed)
    names = list(kind.causes)
    for attempt in range(400):
        wanted = cause if cause and attempt < 40 else str(rng.choice(names))
        made = prepare(kind, wanted, rng)
        if made is None:
            continue
        machine, rows, b, recipe, writer = made
        truth = dict(kind=kind_name, cause=None, axis="", parameters={}, sigma=0.0, energy=0.0, twins=[], plan=wanted)
        causes = []
        if cause:
            planted = plant(kind, wanted, machine, rows, recipe, rng)
            if planted is None:
                continue
            c, effect, seen, energy, project = planted
            causes = [c]
            told = {k: v for k, v in c.items() if k not in HIDDEN}
            truth.update(cause=wanted, axis=c["axis"], parameters=told, sigma=round(seen, 3), energy=round(energy, 1),
                         twins=find_twins(kind, machine, rows, c, effect, project))
        value, wrong = readings(machine, rows, causes, rng)
        truth.update(rows=rows.N, outliers=[i + writer.base["row"] if "row" in rows.told else i + 1 for i in wrong])
        return dict(machine=machine, rows=rows, builder=b, writer=writer, causes=causes, value=value, truth=truth, kind=kind, rng=rng)
    raise RuntimeError(f"no plan shows {cause} on {kind_name}")


def case(kind_name, cause, seed):
    """The files of one case."""
    c = draw_case(kind_name, cause, seed)
    files = {"DATA.csv": c["writer"].csv(c["rows"], c["value"]), "machine.yaml": c["kind"].machine_yaml(c["machine"], c["rng"])}
    header = c["writer"].header(c["rows"], c["machine"], c["builder"].kinds)
    if header:
        files["DATA.yaml"] = header
    files["truth.json"] = json.dumps(c["truth"], indent=1, default=float) + "\n"
    return files


def streams(kind_name, nulls, causes, seed, only=None):
    """(number, cause or None, stream) of every case."""
    names = list(kinds()[kind_name].causes)
    root = np.random.SeedSequence([seed, ["gantry", "delta", "triple_z"].index(kind_name)])
    for i, stream in enumerate(root.spawn(nulls + causes)):
        draw, own = stream.spawn(2)
        yield i + 1, None if i < nulls else only or str(np.random.default_rng(draw).choice(names)), own


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=["gantry", "delta", "triple_z"], required=True)
    parser.add_argument("--nulls", type=int, default=0)
    parser.add_argument("--causes", type=int, default=0)
    parser.add_argument("--cause", help="plant this cause only")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--counterfactual", choices=["no_steps", "klipper_angle", "one_plane"],
                        help="the same cases in a world with one trouble less, to see what a difference comes from")
    parser.add_argument("--out", required=True)
    args = parser.parse_args()
    gantry.Gantry.whole_steps = args.counterfactual != "no_steps"
    delta.Delta.effector_turns = args.counterfactual == "klipper_angle"
    screws.TripleZ.homing_share = 0.0 if args.counterfactual == "one_plane" else 1.0
    names = list(kinds()[args.kind].causes)
    if args.cause and args.cause not in names:
        parser.error(f"{args.cause}: not a cause of {args.kind}; there are {' '.join(names)}")
    for i, cause, own in streams(args.kind, args.nulls, args.causes, args.seed, args.cause):
        folder = os.path.join(args.out, f"case_{i:04d}")
        os.makedirs(folder, exist_ok=True)
        stale = os.path.join(folder, "DATA.yaml")
        if os.path.exists(stale):
            os.remove(stale)
        for name, text in case(args.kind, cause, own).items():
            with open(os.path.join(folder, name), "w", encoding="utf-8") as f:
                f.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
