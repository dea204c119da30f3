"""Measuring campaigns on a gantry, as a metrologist would run them. Each adds rows in the order measured."""
import math
import numpy as np

XYZ = "xyz"
LASERS = dict(kind="laser", sigma=(0.3, 1.0), res=[0.01, 0.1])
PROBES = dict(kind="probe", sigma=(0.8, 3.0), res=[0.1, 1.0])
BALLBARS = dict(kind="ballbar", sigma=(0.3, 0.8), res=[0.1])
WORDS = {"dial": ["dial_{}", "uhr{}", "gauge-{}", "indicator_{}"],
         "laser": ["laser_{}", "iso_{}", "pos_{}", "lin-{}", "run{}", "messung_{}"], "probe": ["touch_{}", "probe_{}", "Tast{}", "c{}", "probing-{}"],
         "ballbar": ["bb_{}", "kreisform_{}", "circle_{}"]}


class Builder:
    def __init__(self, rng, machine, rows):
        self.rng, self.mach, self.rows = rng, machine, rows
        self.count, self.kinds, self.home = 0, {}, 0

    def campaign(self, family):
        """A new campaign name with an instrument of its own noise."""
        self.count += 1
        name = str(self.rng.choice(WORDS[family["kind"]])).format(self.count)
        self.kinds[name] = dict(kind=family["kind"], sigma=self.rng.uniform(*family["sigma"]) * 1e-3,
                                res=float(self.rng.choice(family["res"])) * 1e-3)
        return name

    def seat(self, axis=None):
        """A pose somewhere inside the travel, whole millimetres as people type them."""
        m = self.mach
        p = np.round(m.lo + (m.hi - m.lo) * self.rng.uniform(0.25, 0.75, 3))
        return p

    def add(self, camp, cmd, n, **more):
        k = self.kinds[camp]
        return self.rows.add(camp, cmd, n, sigma=k["sigma"], res=k["res"], home=self.home, **more)

    def touch(self, camp, point, n, standoff=3.0, **more):
        point, n = np.round(point, 4), np.asarray(n, float)
        kw = dict(kind="touch", feed=self.feed, dt=self.rng.uniform(3, 8))
        kw.update(more)
        r = self.mach.tip_cfg
        row = self.add(camp, point, n, **kw)
        row["start"] = row["cmd"] + n * (standoff + r)
        return row

    feed = 2.0

    # -- positioning -----------------------------------------------------------------------------------------------
    def targets(self, axis, m, regular=False):
        k = XYZ.index(axis)
        lo, hi = self.mach.lo[k] + 5, self.mach.hi[k] - 5
        q = np.linspace(lo, hi, m)
        if not regular:
            q = q + self.rng.uniform(-0.45, 0.45, m) * (hi - lo) / (m - 1) * 0.8
        return np.round(np.clip(q, lo, hi), 3)

    def line(self, camp, axis, q, both=True, runs=2, seat=None, setup=None, **more):
        """Runs there and back along one axis; a gauge zeroed somewhere reads the moving part."""
        k = XYZ.index(axis)
        seat = self.seat() if seat is None else seat
        setup = self.rows.new_setup() if setup is None else setup
        n = np.eye(3)[k]
        last = None
        for run in range(runs):
            for sense in ((1, -1) if both else (1,)):
                order = q if sense > 0 else q[::-1]
                first = True
                for target in order:
                    cmd = seat.copy()
                    cmd[k] = target
                    start = cmd.copy()
                    start[k] = target - sense * 3.0 if first else last
                    self.add(camp, cmd, n, setup=setup, rep=run, start=start, dt=self.rng.uniform(4, 9), **more)
                    first, last = False, target
        return setup

    def iso230(self, axis, m=None, runs=None, **more):
        camp = self.campaign(LASERS)
        q = self.targets(axis, m or int(self.rng.integers(11, 26)), self.rng.uniform() < 0.15)
        self.line(camp, axis, q, True, runs or int(self.rng.integers(2, 5)), **more)
        return camp

    def dense(self, axis, period, steps=24.7, turns=3.0):
        camp = self.campaign(LASERS)
        k = XYZ.index(axis)
        q0 = self.rng.uniform(self.mach.lo[k] + 5, self.mach.hi[k] - 6 - turns * period)
        n = int(turns * steps)
        q = q0 + period / steps * (np.arange(n) + self.rng.uniform(-0.3, 0.3, n))
        self.line(camp, axis, np.round(q, 4), bool(self.rng.uniform() < 0.6), 1)
        return camp

    def abbe(self, axis, other, m=13):
        """The same line at two or three places of another axis."""
        k, j = XYZ.index(axis), XYZ.index(other)
        seat, q, camp = self.seat(), self.targets(axis, m), self.campaign(LASERS)
        for share in (0.1, 0.9) if self.rng.uniform() < 0.6 else (0.1, 0.5, 0.9):
            place = seat.copy()
            place[j] = round(self.mach.lo[j] + share * (self.mach.hi[j] - self.mach.lo[j]))
            self.line(camp, axis, q, True, 2, seat=place)
        del k

    def loads(self, axis):
        camp, q, seat = self.campaign(LASERS), self.targets(axis, 11), self.seat()
        setup = self.rows.new_setup()
        for load in sorted(self.rng.choice([5., 20., 40., 60., 80., 120.], 2 if self.rng.uniform() < 0.6 else 3, replace=False)):
            self.line(camp, axis, q, True, 2, seat=seat, setup=setup, load=load)

    def reversals(self, axis):
        """From 12 mm beyond, back by small steps: the first tenths after the reversal. Both senses."""
        camp, k, setup = self.campaign(LASERS), XYZ.index(axis), self.rows.new_setup()
        n, seat = np.eye(3)[k], self.seat()
        steps = np.round(np.geomspace(0.08, 9.0, 14), 3)
        for place in np.round(self.rng.uniform(self.mach.lo[k] + 30, self.mach.hi[k] - 30, int(self.rng.integers(3, 6))), 1):
            for sense in (1, -1):
                last = place + sense * 12.0            # comes from the other sense, reads, turns round
                for d in np.append(0.0, steps):
                    cmd, start = seat.copy(), seat.copy()
                    cmd[k], start[k] = place + sense * d, last
                    self.add(camp, cmd, n, setup=setup, start=start, dt=5.0)
                    last = cmd[k]

    # -- touching --------------------------------------------------------------------------------------------------
    def plate(self, turn=0.0, grid=None, repeats=1, offsets=((0, 0, 0),), camp=None, half=None, name="plate", place=True):
        m, rng = self.mach, self.rng
        mid = (m.lo[:2] + m.hi[:2]) / 2
        half = half or float(np.floor(0.42 * min(m.hi[:2] - m.lo[:2])))
        camp = camp or self.campaign(PROBES)
        nx, ny = grid or (int(rng.integers(5, 8)), int(rng.integers(5, 8)))
        setup = self.rows.new_setup()
        z = self.plate_z = getattr(self, "plate_z", float(rng.choice([0., 10., 20., 30.])))
        m.place(self.rows, setup, rng, centre=(*mid, z))
        u, v = np.meshgrid(np.linspace(-half, half, nx), np.linspace(-half, half, ny))
        v[:, 1::2] = v[::-1, 1::2]
        a = math.radians(turn)
        for rep in range(repeats):
            for off in offsets:
                for s, w in zip(u.T.ravel(), v.T.ravel()):
                    point = (mid[0] + math.cos(a) * s - math.sin(a) * w, mid[1] + math.sin(a) * s + math.cos(a) * w, z)
                    self.touch(camp, point, (0, 0, 1), setup=setup, rep=rep, off=off, turn=turn, surface="plate", feature=f"{name}.top")
        self.rows.artefacts[setup].update(kind="plate", sizes=[2 * half + 10, 2 * half + 10], half=half)
        return camp, half

    def straight_edge(self, along, across, camp=None):
        """One long face touched along an axis; then the edge turned round and its face touched from the other side."""
        m, k, j = self.mach, XYZ.index(along), XYZ.index(across)
        camp = camp or self.campaign(PROBES)
        q = np.round(np.linspace(m.lo[k] + 8, m.hi[k] - 8, int(self.rng.integers(15, 26))), 2)
        base = self.seat()
        if across != "z" and along != "z":
            base[2] = float(self.rng.choice([20., 30.]))
        signs = (1, -1) if across != "z" else (1,)
        for sign in signs:
            setup = self.rows.new_setup()
            place = base.copy()
            place[j] += sign * 8.0
            m.place(self.rows, setup, self.rng, centre=place)
            n = np.zeros(3)
            n[j] = sign
            for rep in range(2):
                for target in q if rep % 2 == 0 else q[::-1]:
                    point = place.copy()
                    point[k] = target
                    self.touch(camp, point, n, setup=setup, rep=rep, turn=0.0 if sign > 0 else 180.0, feature="edge.face")
            self.rows.artefacts[setup].update(kind="straight_edge", sizes=[float(m.hi[k] - m.lo[k])])
        return camp

    def square(self, first, second, camp=None, turned=False):
        """A square, leg along `first`, blade along `second`: flat on the table (xy) or upright on it. Turned: the same square
        once more, turned about the vertical by 90 degrees (flat) or 180 (upright), which swaps the sign of its own error."""
        m, k, j = self.mach, XYZ.index(first), XYZ.index(second)
        camp = camp or self.campaign(PROBES)
        flat = "z" not in (first, second)
        mid = (m.lo + m.hi) / 2
        span = np.round(0.7 * (m.hi - m.lo))
        if flat and turned:
            span[:2] = span[:2].min()
        corner = np.round(mid - span / 2)
        if flat:
            corner[2] = 20.0
        count, repeats = int(self.rng.integers(9, 14)), int(self.rng.integers(1, 3))
        for turn in ((0.0, 90.0 if flat else 180.0) if turned else (0.0,)):
            a = math.radians(turn)
            R = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
            setup = self.rows.new_setup()
            m.place(self.rows, setup, self.rng, centre=R @ (corner - mid) + mid, speck=False)       # leans with the table
            for rep in range(repeats):
                for along, across, face in ((k, j, f"{first}_leg"), (j, k, f"{second}_leg")):
                    n = np.eye(3)[across]
                    for share in np.linspace(0.08, 1.0, count):
                        point = corner.copy()
                        point[along] += round(share * span[along], 2)
                        self.touch(camp, R @ (point - mid) + mid, np.round(R @ n, 9) + 0.0, setup=setup, rep=rep, turn=turn, feature=f"square.{face}")
            self.rows.artefacts[setup].update(kind="square", sizes=[float(span[k])])
        return camp

    def blocks(self, axis="x", sizes=(25.0, 50.0, 76.2), camp=None):
        """Blocks in a row, both faces of each touched at several heights and places."""
        m, k = self.mach, XYZ.index(axis)
        j = 1 - k
        camp = camp or self.campaign(PROBES)
        for i, size in enumerate(sizes):
            setup = self.rows.new_setup()
            centre = self.seat()
            centre[2] = 12.0
            centre[k] = round(m.lo[k] + (m.hi[k] - m.lo[k]) * (0.2 + 0.6 * i / max(1, len(sizes) - 1)))
            m.place(self.rows, setup, self.rng, centre=centre)
            name = (f"block{size:g}" if axis == "x" else f"gb{size:g}").replace(".", "_")
            for rep in range(2):
                for sign, face in ((-1, "left" if axis == "x" else "front"), (1, "right" if axis == "x" else "back")):
                    for dy in (-8.0, 0.0, 8.0):
                        point, n = centre.copy(), np.zeros(3)
                        point[k] += sign * size / 2
                        point[j] += dy
                        n[k] = sign
                        self.touch(camp, point, n, setup=setup, rep=rep, feature=f"{name}.{face}")
            three = [25.0, 25.0, 25.0]
            three[k] = size
            self.rows.artefacts[setup].update(kind="block", sizes=three, name=name)
        return [(f"block{s:g}" if axis == "x" else f"gb{s:g}").replace(".", "_") for s in sizes]

    def ring(self, spins=(0.0, 90.0), angles=24, repeats=1, camp=None):
        m, rng = self.mach, self.rng
        camp = camp or self.campaign(PROBES)
        bore = float(rng.choice([30., 40., 50., 60.]))
        centre = self.seat()
        centre[2] = 10.0
        setup = self.rows.new_setup()
        m.place(self.rows, setup, rng, centre=centre)
        self.rows.artefacts[setup].update(kind="ring", sizes=[bore], bore=rng.normal(0, 0.0005))
        for spin in spins:
            for rep in range(repeats):
                for a in np.arange(angles) * 2 * math.pi / angles + 0.05:
                    n = -np.round(np.array([math.cos(a), math.sin(a), 0.0]), 7)
                    self.touch(camp, centre - n * bore / 2, n, standoff=4.0, setup=setup, rep=rep, spin=spin, surface="ring", feature="ring.bore")
        return camp

    def posts(self, faces=("x+", "x-", "z+"), rounds=12, pause=30.0, spins=(0.0,), feeds=(None,), camp=None, homes=False, name="post"):
        """Faces that nobody measured, touched again and again."""
        camp = camp or self.campaign(PROBES)
        setup = self.rows.new_setup()
        centre = self.seat()
        centre[2] = 15.0
        self.mach.place(self.rows, setup, self.rng, centre=centre)
        normals = {f: np.sign(float(f[1] + "1")) * np.eye(3)[XYZ.index(f[0])] for f in faces}
        self.rows.artefacts[setup].update(kind=str(self.rng.choice(["post", "datums"])), sizes=None,
                                          faces={f"{name}.{f}": self.rng.normal(0, 0.05) for f in faces})
        for i in range(rounds):
            if homes and i:
                self.home += 1
            fresh = True
            for spin in spins:
                for feed in feeds:
                    for f in faces:
                        more = {} if feed is None else dict(feed=feed)
                        if fresh and i:
                            more["dt"] = pause
                        fresh = False
                        self.touch(camp, centre + normals[f] * 10.0, normals[f], setup=setup, rep=i, spin=spin, feature=f"{name}.{f}", **more)
        return camp

    def ballbar(self, feeds=(20.0, 50.0), points=36):
        m, rng = self.mach, self.rng
        camp = self.campaign(BALLBARS)
        R = 100.0 if min(m.hi[:2]) > 240 else 80.0
        mid = np.round((m.lo + m.hi) / 2)
        mid[2] = 40.0
        setup = self.rows.new_setup()
        for feed in feeds:
            for sense in (1, -1):
                angles = np.deg2rad(np.arange(points) * 360.0 / points + 3.0)[::sense]
                for a in angles:
                    n = np.array([math.cos(a), math.sin(a), 0.0])
                    b = a - sense * math.radians(2.0)
                    row = self.add(camp, mid + R * n, np.round(n, 7), kind="radial", setup=setup, feed=feed, dt=R * 2 * math.pi / points / feed)
                    row["start"] = mid + R * np.array([math.cos(b), math.sin(b), 0.0])
                    row["circle"] = (R, a, float(sense), mid)
        self.rows.artefacts[setup] = dict(turn=np.zeros(3), shift=np.zeros(3), centre=mid, faces={}, bore=0.0, kind="ballbar", sizes=[R])
        return camp
