"""Parts that all machines of the second world share: rotations, play, thermal lag, weather, rows in the order measured."""
import numpy as np


def rotation(v):
    """True rotation matrices (N,3,3) of rotation vectors (N,3), right-handed."""
    v = np.atleast_2d(np.asarray(v, float))
    angle = np.linalg.norm(v, axis=1)
    k = v / np.where(angle > 0, angle, 1.0)[:, None]
    zero = np.zeros(len(v))
    cross = np.stack([np.stack([zero, -k[:, 2], k[:, 1]], 1), np.stack([k[:, 2], zero, -k[:, 0]], 1),
                      np.stack([-k[:, 1], k[:, 0], zero], 1)], 1)
    s, c = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    return np.eye(3)[None] + s * cross + c * (cross @ cross)


def apply(matrices, vectors):
    return np.einsum("nij,nj->ni", matrices, vectors)


def play(start, target, gap_start, gap_target):
    """The play operator along the path start[0], target[0], start[1], ... of each axis: the carriage stays while
    |carriage - motor| <= gap / 2. Returns (carriage - motor at the targets, travel since the last reversal, its sense)."""
    n, axes = target.shape
    lag, since, sense = np.zeros((n, axes)), np.zeros((n, axes)), np.zeros((n, axes))
    for k in range(axes):
        path = np.column_stack([start[:, k], target[:, k]]).ravel().tolist()
        gaps = np.column_stack([gap_start[:, k], gap_target[:, k]]).ravel().tolist()
        m = path[0] - 1.0                       # homed long ago, then moved to + by a millimetre
        x, s, d = m - gaps[0] / 2, 1.0, 1.0
        for i, (q, g) in enumerate(zip(path, gaps)):
            step = q - m
            if step * s < -1e-9:
                s, d = -s, 0.0
            if abs(step) > 1e-9:
                d += abs(step)
            m = q
            x = min(max(x, m - g / 2), m + g / 2)
            if i % 2:
                lag[i // 2, k], since[i // 2, k], sense[i // 2, k] = x - m, d, s
    return lag, since, sense


def lagged(t, signal, lag_s, at):
    """First-order lag of a signal on an even grid t, read at the times `at`."""
    if lag_s <= 0:
        return np.interp(at, t, signal)
    a = np.exp(-(t[1] - t[0]) / lag_s)
    out = np.empty_like(signal)
    y = signal[0]
    for i, u in enumerate(signal.tolist()):
        y = a * y + (1 - a) * u
        out[i] = y
    return np.interp(at, t, out)


class Weather:
    """Temperatures of a session as time series on a grid of seconds; 0 is the first reading."""
    NAMES = ("screw", "frame", "bed", "chamber", "ambient")

    def __init__(self, rng, duration_s, warm):
        n = 400
        self.t = np.linspace(0.0, max(duration_s, 60.0) * 1.001, n)
        u = self.t / self.t[-1]
        base = rng.uniform(18.5, 24.0)
        room = rng.uniform(0.1, 0.5) * np.sin(2 * np.pi * (u * rng.uniform(0.4, 1.6) + rng.uniform()))
        if warm:
            room = room * 3
        self.series = {"ambient": base + room}
        # each part is heated in its own spells (drive current, lamp, heater, sun) and follows with its own inertia
        for name, tau_share, size in (("screw", 0.10, 6.0), ("frame", 0.22, 3.0), ("bed", 0.12, 8.0), ("chamber", 0.3, 4.0)):
            power = np.zeros(n)
            if warm:
                edges = np.sort(rng.uniform(0.03, 0.95, 4))
                power = ((u > edges[0]) & (u < edges[1])) * 1.0 + ((u > edges[2]) & (u < edges[3])) * rng.uniform(0.3, 0.9)
                power *= size * rng.uniform(0.6, 1.6)
            tau = tau_share * rng.uniform(0.6, 1.5) * self.t[-1]
            self.series[name] = base + room * rng.uniform(0.3, 0.8) + lagged(self.t, power, tau, self.t)
        if not warm:
            for name in self.NAMES[:4]:
                self.series[name] = self.series[name] + rng.uniform(-0.4, 0.4)

    def read(self, name, at):
        return np.interp(at, self.t, self.series[name])

    def rise(self, name, at, lag_s=0.0):
        """T - T0 behind a first-order lag, T0 the session's first reading."""
        s = self.series[name]
        return lagged(self.t, s - s[0], lag_s, at)


class Rows:
    """Rows in the order measured. After `close` every field is an array over rows."""
    DEFAULTS = dict(kind="position", setup=0, home=0, rep=0, feed=np.nan, load=np.nan, feature="", turn=0.0, spin=0.0,
                    off=(0.0, 0.0, 0.0), dt=6.0, sigma=1e-3, res=1e-4, surface="plane", turning=0.0, note="", motor=None,
                    dir=None, start=None)

    def __init__(self):
        self.items, self.setups, self.artefacts, self.instruments = [], 0, {}, {}

    def new_setup(self):
        self.setups += 1
        return self.setups - 1

    def add(self, camp, cmd, n, **more):
        row = dict(self.DEFAULTS, camp=camp, cmd=np.round(np.asarray(cmd, float), 4), n=np.asarray(n, float), **more)
        self.items.append(row)
        return row

    def close(self, rng):
        items = self.items
        self.N = len(items)
        for key in ("camp", "kind", "feature", "surface", "note"):
            setattr(self, key, np.array([r[key] for r in items], dtype=object))
        for key in ("setup", "home", "rep"):
            setattr(self, key, np.array([r[key] for r in items], int))
        for key in ("feed", "load", "turn", "spin", "sigma", "res", "turning"):
            setattr(self, key, np.array([r[key] for r in items], float))
        for key in ("cmd", "n", "off"):
            setattr(self, key, np.array([r[key] for r in items], float))
        self.motor = None                                        # machines that are not cartesian fill it in
        self.start = np.array([r["cmd"] if r["start"] is None else r["start"] for r in items], float)
        sense = np.sign(np.where(np.abs(self.cmd - self.start) > 1e-6, self.cmd - self.start, 0.0))
        given = [r["dir"] for r in items]
        self.dir = np.array([s if g is None else g for s, g in zip(sense, given)], float)
        pause = np.array([r["dt"] for r in items]) * rng.uniform(0.85, 1.15, self.N)
        self.t = np.cumsum(pause) - pause[0]
        self.touch = self.kind == "touch"
        self.radial = self.kind == "radial"
        return self


def bow(q, lo, hi):
    """1 at both ends, 0 in the middle: U squared."""
    u = (2 * np.asarray(q) - lo - hi) / (hi - lo)
    return u * u


def middle(q, lo, hi):
    """-1/2 .. 1/2 over the travel."""
    return (np.asarray(q) - (lo + hi) / 2) / (hi - lo)
