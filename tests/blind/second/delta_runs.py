"""Campaigns on a delta, and what can be wrong with one."""
import math
import numpy as np
from gantry_runs import Builder as Common

PROBES = dict(kind="probe", sigma=(1.5, 6.0), res=[0.1, 1.0])
GAUGES = dict(kind="dial", sigma=(1.0, 4.0), res=[0.1, 1.0])


class Builder(Common):
    bed_setup = None

    def spots(self, count, share=1.0):
        """Points over the round bed: rings, or a square grid cut to the circle."""
        r = self.mach.print_radius * share
        if self.rng.uniform() < 0.5:
            side = max(4, int(round(math.sqrt(count * 4 / math.pi))))
            u = np.linspace(-r, r, side)
            return [(round(x, 2), round(y, 2)) for i, x in enumerate(u) for y in (u if i % 2 == 0 else u[::-1]) if math.hypot(x, y) <= r * 1.001]
        points, rings = [(0.0, 0.0)], max(2, int(round(math.sqrt(count / math.pi))))
        for i in range(1, rings + 1):
            n = int(round(count * 2 * i / (rings * (rings + 1))))
            points += [(round(r * i / rings * math.cos(a), 2), round(r * i / rings * math.sin(a), 2)) for a in (np.arange(n) + 0.3 * i) * 2 * math.pi / n]
        return points

    def bed(self):
        if self.bed_setup is None:
            self.bed_setup = self.rows.new_setup()
            self.mach.place(self.rows, self.bed_setup, self.rng)
            self.rows.artefacts[self.bed_setup].update(kind="plate", sizes=None)
        return self.bed_setup

    def grid(self, count=None, repeats=None, feeds=(None,), spots=None, camp=None, pause=None):
        camp, setup = camp or self.campaign(PROBES), self.bed()
        spots = spots or self.spots(count or int(self.rng.integers(35, 80)))
        for rep in range(repeats or int(self.rng.integers(1, 3))):
            for feed in feeds:
                for i, (x, y) in enumerate(spots):
                    row = self.add(camp, (x, y, 0.0), (0, 0, 1), kind="touch", setup=setup, rep=rep, feed=feed or 5.0, feature="bed.top",
                                   dt=pause if pause and i == 0 else self.rng.uniform(2, 6))
                    row["start"] = row["cmd"] + np.array([0, 0, 5.0])
        return camp

    def xy(self, count=None, both=None, z=None):
        """A gauge that reads the nozzle over a scale plate along x and along y."""
        camp, setup = self.campaign(GAUGES), self.rows.new_setup()
        both = self.rng.uniform() < 0.7 if both is None else both
        z = z if z is not None else float(self.rng.choice([0., 5., 20.]))
        self.rows.artefacts[setup] = dict(slope=np.zeros(2), height=0.0, kind="plate", sizes=[2 * self.mach.radius, 2 * self.mach.radius])
        for x, y in self.spots(count or int(self.rng.integers(25, 50))):
            for k in range(2):
                for sense in (1, -1) if both else (1,):
                    n = np.eye(3)[k]
                    row = self.add(camp, (x, y, z), n, setup=setup, dt=self.rng.uniform(3, 7), feature="glass.grid")
                    row["start"] = row["cmd"] - sense * 4.0 * n
        return camp

    def columns(self, places=None, steps=None, span=None, both=True):
        """A scale along z at several places, up and down."""
        camp, r = self.campaign(GAUGES), self.mach.print_radius * 0.8
        angles = self.rng.uniform(0, 2 * math.pi) + np.arange(places or int(self.rng.integers(3, 7))) * 2.4
        top = span or 0.5 * self.mach.endstop
        q = np.round(np.linspace(2.0, top, steps or int(self.rng.integers(9, 16))), 2)
        q = np.round(q + np.append(0, self.rng.uniform(-0.3, 0.3, len(q) - 1)) * (q[1] - q[0]), 2)
        setup = None
        for i, a in enumerate(angles):
            x, y = (0.0, 0.0) if i == 0 else (round(r * math.cos(a), 1), round(r * math.sin(a), 1))
            setup = self.rows.new_setup()                 # the scale is set up anew at every place
            for sense in (1, -1) if both else (-1,):
                for z in q if sense > 0 else q[::-1]:
                    row = self.add(camp, (x, y, z), (0, 0, 1), setup=setup, dt=self.rng.uniform(3, 7))
                    row["start"] = row["cmd"] - sense * np.array([0, 0, 2.0])
        return camp


def pick(b, *words):
    return str(b.rng.choice(list(words)))


def shape(b):
    """Enough to tell rods, towers and belts: the bed, a scale plate, mostly columns."""
    b.grid()
    b.xy()
    if b.rng.uniform() < 0.6:
        b.columns()


def rod_mismatch(b):
    shape(b)
    return dict(axis=pick(b, "a", "b", "c", "a1", "a2", "b1", "b2", "c1", "c2"), size="length_error_mm", limits=(0.01, 1.0))


def tower_lean(b):
    b.grid()
    b.xy()
    b.columns()
    share = float(b.rng.choice([0.0, 1.0, -0.5, 0.7]))
    return dict(axis=pick(b, *"abc"), size="radial_mrad", fixed={"tangential_mrad": share}, limits=(0.03, 8))


def tower_twist(b):
    shape(b)
    return dict(axis=pick(b, *"abc"), size="angle_deg", limits=(0.01, 3))


def belt_pitch(b):
    shape(b)
    return dict(axis=pick(b, *"abc"), size="error_ppm", limits=(20, 4000))


def carriage_backlash(b):
    b.xy(both=True)
    b.columns(both=True)
    if b.rng.uniform() < 0.6:
        b.grid()
    return dict(axis=pick(b, *"abc"), size="gap_mm", limits=(0.005, 0.4), needs={"dir_motor"}, positive=True)


def pulley_eccentric(b):
    b.grid()
    b.columns(4, 28, 2.6 * b.mach.turn_mm)
    b.xy()
    period = b.mach.turn_mm * (1 + b.rng.uniform(-3e-4, 3e-4))
    return dict(axis=pick(b, *"abc"), size="amplitude_um", period_mm=float(period), phase_deg=float(b.rng.uniform(-180, 180)),
                second=float(b.rng.uniform(-0.12, 0.12)), limits=(3, 120), positive=True)


def pitch_progressive(b):
    b.grid()
    b.xy()
    b.columns(5, 14, 0.75 * b.mach.endstop)
    return dict(axis=pick(b, *"abc"), size="bow_um", limits=(10, 2000))


def bed_shape(b, name):
    b.grid(int(b.rng.integers(45, 80)))
    b.xy()
    return dict(axis=pick(b, "x", "y") if name == "bed_cylinder" else "", size="height_um", fourth=float(b.rng.uniform(-0.2, 0.2)), limits=(5, 600))


def trigger_latency(b):
    feeds = tuple(sorted(b.rng.choice([1.0, 2.0, 3.0, 5.0, 8.0, 10.0], 3, replace=False)))
    b.grid(20, 2, feeds)
    return dict(axis="", size="latency_ms", limits=(0.3, 30), needs={"feed"}, positive=True)


def slow(b):
    b.grid(spots=[(0.0, 0.0)] + b.spots(6, 0.8)[:5], repeats=int(b.rng.integers(18, 30)), pause=b.rng.uniform(60, 200))


def probe_temperature(b):
    slow(b)
    return dict(axis="", size="drift_um_per_k", lag_s=float(b.rng.uniform(0, 200)), limits=(0.5, 20), needs={"t", "temp"}, warm=True)


def frame_temperature(b):
    slow(b)
    axis = pick(b, "frame", "bed")                 # a warm bed rises; a warm frame lifts the tool or lowers it
    return dict(axis=axis, positive=axis == "bed", size="growth_um_per_k", lag_s=float(b.rng.uniform(0, 300)), limits=(0.5, 80), needs={"t", "temp"}, warm=True)


def missed_steps(b):
    b.grid(spots=b.spots(14, 0.9)[:14], repeats=int(b.rng.integers(6, 12)))
    return dict(axis=pick(b, *"abc"), size="jump_um", jump=float(b.rng.uniform(0.25, 0.75)), limits=(5, 400), needs={"t"})


def homing_scatter(b):
    camp, spots = b.campaign(PROBES), b.spots(7, 0.9)[:7]
    homes = int(b.rng.integers(9, 14))
    for _ in range(homes):
        b.grid(spots=spots, repeats=1, camp=camp)
        b.home += 1
    return dict(axis=pick(b, *"abc"), size="sd_um", draws=b.rng.normal(0, 1, homes + 20).tolist(), limits=(3, 200), needs={"home"}, positive=True)


CAUSES = dict(rod_mismatch=rod_mismatch, tower_lean=tower_lean, tower_twist=tower_twist, belt_pitch=belt_pitch,
              carriage_backlash=carriage_backlash, pulley_eccentric=pulley_eccentric, pitch_progressive=pitch_progressive,
              bed_bowl=lambda b: bed_shape(b, "bed_bowl"), bed_cylinder=lambda b: bed_shape(b, "bed_cylinder"),
              bed_twist=lambda b: bed_shape(b, "bed_twist"), trigger_latency=trigger_latency, probe_temperature=probe_temperature,
              frame_temperature=frame_temperature, missed_steps=missed_steps, homing_scatter=homing_scatter)


def fillers(b):
    if b.rng.uniform() < 0.3:
        b.grid(20, 1)


def twin_candidates(machine, rows):
    waves = lambda p: [[dict(amplitude_um=1.0, phase_deg=a, period_mm=p) for a in (0.0, 90.0)]]
    out = [("rod_mismatch", r, [[dict(length_error_mm=1e-3)]]) for r in ("a", "b", "c", "a1", "a2", "b1", "b2", "c1", "c2")]
    for a in "abc":
        out += [("tower_lean", a, [[dict(radial_mrad=0.01, tangential_mrad=0.0), dict(radial_mrad=0.0, tangential_mrad=0.01)]]),
                ("tower_twist", a, [[dict(angle_deg=0.001)]]), ("belt_pitch", a, [[dict(error_ppm=10.0)]]),
                ("carriage_backlash", a, [[dict(gap_mm=1e-3)]]), ("pulley_eccentric", a, waves(machine.turn_mm)),
                ("pitch_progressive", a, [[dict(bow_um=1.0)]])]
    if rows.touch.any():
        out += [("bed_bowl", "", [[dict(height_um=1.0)]]), ("bed_twist", "", [[dict(height_um=1.0)]])]
        out += [("bed_cylinder", a, [[dict(height_um=1.0)]]) for a in "xy"]
        if "temp" in rows.told:
            out.append(("probe_temperature", "", [[dict(drift_um_per_k=1.0, lag_s=s)] for s in (0, 150, 400)]))
            out += [("frame_temperature", a, [[dict(growth_um_per_k=1.0, lag_s=s)] for s in (0, 150, 400)]) for a in ("frame", "bed")]
        if len(set(rows.feed[rows.touch])) > 1:
            out.append(("trigger_latency", "", [[dict(latency_ms=1.0)]]))
    return out
