"""Campaigns on a bed on three screws, and what can be wrong with one."""
import numpy as np
from gantry_runs import Builder as Common

PROBES = dict(kind="probe", sigma=(1.0, 4.0), res=[0.1, 1.0])
DIALS = dict(kind="dial", sigma=(0.8, 2.5), res=[0.1, 1.0])
Z = ("z1", "z2", "z3")


class Builder(Common):
    bed_setup = None

    def bed(self):
        if self.bed_setup is None:
            self.bed_setup = self.rows.new_setup()
            self.mach.place(self.rows, self.bed_setup, self.rng)
            self.rows.artefacts[self.bed_setup].update(kind="plate", sizes=None)
        return self.bed_setup

    def spots(self, nx, ny, share=0.9):
        s = self.mach.hi[0]
        u, v = np.linspace(s * (1 - share) / 2, s * (1 + share) / 2, nx), np.linspace(s * (1 - share) / 2, s * (1 + share) / 2, ny)
        return [(round(x, 2), round(y, 2)) for i, x in enumerate(u) for y in (v if i % 2 == 0 else v[::-1])]

    def probe(self, camp, xy, z=0.0, motor=None, **more):
        kw = dict(kind="touch", setup=self.bed(), feed=3.0, feature="bed.top", dt=self.rng.uniform(3, 7))
        kw.update(more)
        return self.add(camp, (xy[0], xy[1], z), (0, 0, 1), motor=motor, **kw)

    def grid(self, heights=(0.0,), nx=None, ny=None, repeats=1, feeds=(3.0,), camp=None, spots=None, pause=None):
        camp = camp or self.campaign(PROBES)
        spots = spots or self.spots(nx or int(self.rng.integers(5, 8)), ny or int(self.rng.integers(5, 8)))
        for rep in range(repeats):
            for z in heights:
                for feed in feeds:
                    for i, xy in enumerate(spots):
                        more = dict(dt=pause) if pause and i == 0 else {}
                        self.probe(camp, xy, z, rep=rep, feed=feed, **more)
        return camp

    def posts(self, q=None, places=3, both=True):
        """Indicators on fixed posts under or over the bed near its screws; the bed goes up and down."""
        camp, m = self.campaign(DIALS), self.mach
        q = np.sort(np.round(self.rng.uniform(5, m.hi[2] - 5, int(self.rng.integers(9, 15))), 3)) if q is None else q
        for k in range(places):
            setup = self.rows.new_setup()
            x, y = np.clip(np.round(m.at[k] + self.rng.uniform(-12, 12, 2)), 0, m.hi[:2])
            for sense in (1, -1) if both else (1,):
                for z in q if sense > 0 else q[::-1]:
                    row = self.add(camp, (x, y, z), (0, 0, 1), setup=setup, dt=self.rng.uniform(4, 8))
                    h = m.hi[2] - z
                    row["from_motor"] = [h + sense * 2.0] * 3          # cmd_z grows: the bed goes down
        return camp

    def one_by_one(self, by):
        """One screw is moved at a time, the bed touched at some places with it up and with it down."""
        camp, m = self.campaign(PROBES), self.mach
        spots = self.spots(3, 3, 0.85) if self.rng.uniform() < 0.7 else self.spots(4, 3, 0.85)
        for move in (None, (0, by), (0, -by), (1, by), (1, -by), (2, by), (2, -by)):
            pattern = np.zeros(3)
            if move:
                pattern[move[0]] = move[1]
            for xy in spots:
                self.probe(camp, xy, motor=np.round(m.level(pattern, xy), 5))
        return camp


def pick(b, *words):
    return str(b.rng.choice(list(words)))


def heights(b, n=None):
    return tuple(np.round(np.linspace(0, b.mach.hi[2] * b.rng.uniform(0.5, 0.9), n or int(b.rng.integers(3, 6))), 1).tolist())


def screw_pitch(b):
    b.grid(heights(b), 5, 4)
    if b.rng.uniform() < 0.7:
        b.posts()
    return dict(axis=pick(b, *Z), size="error_ppm", limits=(5, 4000))


def screw_cyclic(b):
    base = b.rng.uniform(20, b.mach.hi[2] - 40)
    if b.rng.uniform() < 0.5:
        q = base + b.mach.lead / 11.7 * (np.arange(34) + b.rng.uniform(-0.3, 0.3, 34))
        b.posts(np.round(q, 4), both=False)
    else:
        q = base + b.mach.lead / 7.3 * (np.arange(20) + b.rng.uniform(-0.3, 0.3, 20))
        b.grid(tuple(np.round(q, 4).tolist()), 3, 3)
    b.grid()
    return dict(axis=pick(b, *Z), size="amplitude_um", period_mm=float(b.mach.lead * (1 + b.rng.uniform(-3e-4, 3e-4))),
                phase_deg=float(b.rng.uniform(-180, 180)), second=float(b.rng.uniform(-0.12, 0.12)), limits=(2, 80), positive=True)


def screw_backlash(b):
    b.posts()
    b.grid()
    return dict(axis=pick(b, *Z), size="gap_mm", limits=(0.004, 0.2), needs={"dir_motor"}, positive=True)


def pivot_position(b):
    b.one_by_one(float(b.rng.choice([0.5, 1.0, 2.0])))
    share = float(b.rng.choice([0.0, 1.0, -0.6]))
    return dict(axis=pick(b, *Z), size="dx_mm", fixed={"dy_mm": share}, limits=(0.1, 12))


def motors_swapped(b):
    b.one_by_one(float(b.rng.choice([0.05, 0.1, 0.3, 0.5])))
    return dict(axis=pick(b, "z1z2", "z1z3", "z2z3"), size=None, limits=(0, 1))


def bed_shape(b, name):
    b.grid(heights(b, 2) if b.rng.uniform() < 0.3 else (0.0,), repeats=2)
    return dict(axis=pick(b, "x", "y") if name == "bed_cylinder" else "", size="height_um", fourth=float(b.rng.uniform(-0.2, 0.2)), limits=(4, 500))


def gantry_sag(b):
    b.grid(heights(b, 2) if b.rng.uniform() < 0.3 else (0.0,), repeats=2)
    return dict(axis="", size="sag_um", fourth=float(b.rng.uniform(-0.2, 0.2)), limits=(4, 300))


def trigger_latency(b):
    feeds = tuple(sorted(b.rng.choice([0.5, 1.0, 2.0, 4.0, 6.0], 3, replace=False).tolist()))
    b.grid((0.0,), 4, 4, 2, feeds)
    return dict(axis="", size="latency_ms", limits=(0.3, 30), needs={"feed"}, positive=True)


def slow(b):
    b.grid((0.0,), spots=b.spots(2, 2) + [(round(b.mach.hi[0] / 2, 1), round(b.mach.hi[1] / 2, 1))],
           repeats=int(b.rng.integers(18, 32)), pause=b.rng.uniform(60, 200))


def probe_temperature(b):
    slow(b)
    return dict(axis="", size="drift_um_per_k", lag_s=float(b.rng.uniform(0, 200)), limits=(0.5, 20), needs={"t", "temp"}, warm=True)


def frame_temperature(b):
    slow(b)
    axis = pick(b, "frame", "bed")                 # a warm bed rises; a warm frame lifts the tool or lowers it
    return dict(axis=axis, positive=axis == "bed", size="growth_um_per_k", lag_s=float(b.rng.uniform(0, 300)), limits=(0.5, 80), needs={"t", "temp"}, warm=True)


def missed_steps(b):
    b.grid((0.0,), spots=b.spots(3, 3), repeats=int(b.rng.integers(9, 16)))
    return dict(axis=pick(b, *Z), size="jump_um", jump=float(b.rng.uniform(0.25, 0.75)), limits=(4, 300), needs={"t"})


def pitch_progressive(b):
    b.grid(heights(b, 6), 4, 4)
    b.posts()
    return dict(axis=pick(b, *Z), size="bow_um", limits=(4, 400))


CAUSES = dict(screw_pitch=screw_pitch, screw_cyclic=screw_cyclic, screw_backlash=screw_backlash, pivot_position=pivot_position,
              motors_swapped=motors_swapped, bed_bowl=lambda b: bed_shape(b, "bed_bowl"), bed_cylinder=lambda b: bed_shape(b, "bed_cylinder"),
              bed_twist=lambda b: bed_shape(b, "bed_twist"), gantry_sag=gantry_sag, trigger_latency=trigger_latency,
              probe_temperature=probe_temperature, frame_temperature=frame_temperature, missed_steps=missed_steps,
              pitch_progressive=pitch_progressive)


def fillers(b):
    if b.rng.uniform() < 0.3:
        b.grid((0.0,), 5, 4)
    if b.rng.uniform() < 0.2:
        b.posts()
    if b.rng.uniform() < 0.15:                     # each homing leaves the bed on another plane: baseline
        camp, spots = b.campaign(PROBES), b.spots(4, 4)
        for _ in range(int(b.rng.integers(3, 6))):
            b.home += 1
            b.grid((0.0,), camp=camp, spots=spots)


def twin_candidates(machine, rows):
    waves = lambda p: [[dict(amplitude_um=1.0, phase_deg=a, period_mm=p) for a in (0.0, 90.0)]]
    bent = lambda key: [[{key: 1.0, "fourth": 0.0}], [{key: 1.0, "fourth": 0.0}, {key: 1.0, "fourth": 0.2}]]     # no bow is an exact parabola
    out = []
    for z in Z:
        out += [("screw_pitch", z, [[dict(error_ppm=10.0)]]), ("screw_cyclic", z, waves(machine.lead)), ("screw_backlash", z, [[dict(gap_mm=1e-3)]]),
                ("pivot_position", z, [[dict(dx_mm=0.1, dy_mm=0.0), dict(dx_mm=0.0, dy_mm=0.1)]]), ("pitch_progressive", z, [[dict(bow_um=1.0)]])]
    out += [("motors_swapped", a, [[dict()]]) for a in ("z1z2", "z1z3", "z2z3")]
    if rows.touch.any():
        out += [("bed_bowl", "", bent("height_um")), ("bed_twist", "", bent("height_um")), ("gantry_sag", "", bent("sag_um"))]
        out += [("bed_cylinder", a, bent("height_um")) for a in "xy"]
        out += [("straightness", "EZY", bent("bow_um")), *(("angular", a, [[dict(slope_urad=20.0)]]) for a in ("EBY", "EAZ", "EBZ"))]
        if "temp" in rows.told:
            out.append(("probe_temperature", "", [[dict(drift_um_per_k=1.0, lag_s=s)] for s in (0, 150, 400)]))
            out += [("frame_temperature", a, [[dict(growth_um_per_k=1.0, lag_s=s)] for s in (0, 150, 400)]) for a in ("frame", "bed")]
        if len(set(rows.feed[rows.touch])) > 1:
            out.append(("trigger_latency", "", [[dict(latency_ms=1.0)]]))
    return out
