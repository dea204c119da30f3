"""A delta as it really is: three carriages on turned, leaning towers, six rods of their own lengths, a rigid effector.
The pose is solved from the six lengths (Newton, true rotations); touches are found by iteration."""
import math
import numpy as np
import chain

ABC, MM = "abc", 1e-3
RODS = ("a1", "a2", "b1", "b2", "c1", "c2")


class Delta:
    kind = "delta"
    effector_turns = False        # counterfactual: True is Klipper's tower angle, not CONTRACT.md's

    def __init__(self, rng):
        self.name = str(rng.choice(["kossel", "delta_one", "rostock", "tall-delta"]))
        self.belt = [True] * 3
        self.radius = float(rng.choice([90., 100., 115., 130., 150.]))
        self.arm = round(self.radius * rng.uniform(2.0, 2.4), 1)
        self.endstop = float(rng.choice([220., 260., 300., 350.]))
        self.spacing, self.eff = float(rng.choice([40., 44., 50., 60.])), float(rng.choice([22., 25., 30., 35.]))
        self.joint = float(rng.choice([10., 15., 20.]))
        self.angles = np.array([210., 330., 90.])
        self.turn_mm, self.full, self.micro = float(rng.choice([32., 40.])), 200, int(rng.choice([32, 64]))
        self.steps = np.full(3, self.full * self.micro / self.turn_mm)
        self.print_radius = 0.8 * self.radius
        self.tip_cfg = 0.0
        self.head = self.endstop + self.joint + math.sqrt(self.arm ** 2 - self.radius ** 2)
        self.lo, self.hi = np.zeros(3), np.full(3, float(round(self.endstop + 120)))
        # as built
        self.stop_error = rng.normal(0, 0.15, 3)
        self.radius_error, self.arm_error = rng.normal(0, 0.3), rng.normal(0, 0.2)
        self.angle_error = np.append(rng.uniform(0.01, 0.09, 2) * rng.choice([-1, 1], 2), 0.0)
        self.scale = float(rng.choice([-1, 1]) * rng.uniform(50e-6, 300e-6))
        self.rail = float(rng.uniform(0, 20))                 # the rail stands that far behind the joints
        self.foot = float(-rng.uniform(20, 80))               # the towers are screwed down there
        self.pretravel, self.plane = rng.uniform(0.005, 0.06), rng.normal(0, 0.8e-3, 2)
        self.base = rng.normal(0, 0.05)

    def motors(self, pose, arm=None):
        """The firmware's inverse: carriage travel down from its endstop, of the drawing."""
        a = np.radians(self.angles)
        dx, dy = self.radius * np.cos(a) - pose[:, :1], self.radius * np.sin(a) - pose[:, 1:2]
        return self.head - (pose[:, 2:3] + self.joint + np.sqrt((arm or self.arm) ** 2 - dx * dx - dy * dy))

    def place(self, rows, setup, rng, **_):
        speck = rng.normal(0, 0.2e-3, 2) if setup else np.zeros(2)
        rows.artefacts[setup] = dict(slope=self.plane + speck, height=self.base + (rng.normal(0, 0.05) if setup else 0.0))

    # -- drives ----------------------------------------------------------------------------------------------------
    def _moved(self, m, rows, causes):
        own = [c for c in causes if c["cause"] == "carriage_backlash"]
        gap = np.zeros((1, 3))
        for c in own:
            gap[0, ABC.index(c["axis"])] += c["gap_mm"]
        s = m * (1 + self.scale)
        if own:
            key = repr(own)
            if key not in rows.plays:
                wide = np.tile(gap, (rows.N, 1))
                rows.plays[key] = chain.play(rows.motor_start, rows.motor, wide, wide)[0]
            s = s + rows.plays[key]
        else:
            s = s + 0.0
        for c in causes:
            name, axis = c["cause"], c["axis"]
            if axis not in ("a", "b", "c"):
                continue
            k = ABC.index(axis)
            q = m[:, k]
            if name == "belt_pitch":
                s[:, k] += q * c["error_ppm"] * 1e-6
            elif name == "pulley_eccentric":
                w = 2 * math.pi * q / c["period_mm"] + math.radians(c["phase_deg"])
                s[:, k] += c["amplitude_um"] * MM * (np.sin(w) + c.get("second", 0.0) * np.sin(2 * w + 1.0))
            elif name == "pitch_progressive":
                s[:, k] += c["bow_um"] * MM * chain.bow(q, self.lo[k], self.hi[k])
            elif name == "missed_steps":
                home0 = rows.home[np.searchsorted(rows.t, c["at_t_s"]).clip(0, rows.N - 1)]
                s[:, k] += c["jump_um"] * MM * ((rows.t >= c["at_t_s"]) & (rows.home == home0))
            elif name == "homing_scatter":
                s[:, k] += np.array([c["draws"][h % len(c["draws"])] for h in rows.home]) * c["sd_um"] * MM
            elif name == "offset":
                s[:, k] += c["um"] * MM
        return s

    # -- geometry --------------------------------------------------------------------------------------------------
    def _joints(self, m, rows, causes):
        """Carriage joints (N,6,3), effector joints in its own frame (6,3), rod lengths (6)."""
        b = dict(radius=self.radius_error, arm=self.arm_error, angle=self.angle_error.copy(), stop=self.stop_error.copy(), scale=0.0)
        lean, twist, rods = np.zeros((3, 2)), np.zeros(3), np.zeros(6)
        for c in causes:
            name, axis = c["cause"], c["axis"]
            if name == "rod_mismatch":
                for r in range(6):
                    if RODS[r].startswith(axis):
                        rods[r] += c["length_error_mm"]
            elif name == "tower_lean":
                lean[ABC.index(axis)] += np.array([c["radial_mrad"], c["tangential_mrad"]]) * 1e-3
            elif name == "tower_twist":
                twist[ABC.index(axis)] += math.radians(c["angle_deg"])
            elif name == "built":                                  # steps of the baseline, for the projection
                if axis in ABC and c["what"] in ("stop", "angle"):
                    b[c["what"]][ABC.index(axis)] += c["by"]
                else:
                    b[c["what"]] += c["by"]
        s = self._moved(m, rows, causes) + m * b["scale"]
        h = self.head + b["stop"] - s
        joints, effector = np.empty((len(m), 6, 3)), np.empty((6, 3))
        for t in range(3):
            true, drawn = math.radians(self.angles[t] + b["angle"][t]), math.radians(self.angles[t])
            u, w = np.array([math.cos(true), math.sin(true), 0]), np.array([-math.sin(true), math.cos(true), 0])
            along = lean[t, 0] * u + lean[t, 1] * w + np.array([0, 0, 1.0])
            along /= np.linalg.norm(along)
            stand = (self.radius + b["radius"] + self.eff + self.rail) * u + np.array([0, 0, self.foot])
            rail = stand + along * (h[:, t] - self.foot)[:, None]
            c, sn = math.cos(twist[t]), math.sin(twist[t])
            ud, wd = np.array([math.cos(drawn), math.sin(drawn), 0]), np.array([-math.sin(drawn), math.cos(drawn), 0])
            for k, side in enumerate((-0.5, 0.5)):                  # the first is the clockwise one from above
                x, y = -self.rail, side * self.spacing
                joints[:, 2 * t + k] = rail + (c * x - sn * y) * u + (sn * x + c * y) * w
                eu, ew = (u, w) if self.effector_turns else (ud, wd)
                effector[2 * t + k] = self.eff * eu + side * self.spacing * ew + np.array([0, 0, self.joint])
        return joints, effector, self.arm + b["arm"] + rods

    @staticmethod
    def _lengths(p, turn, joints, effector, arms):
        e = np.einsum("nij,kj->nki", chain.rotation(turn), effector)
        d = joints - p[:, None] - e
        return (d * d).sum(2) - arms ** 2, d, e

    def solve(self, joints, effector, arms, p, turn, passes=12):
        """Newton on the six rod lengths; returns the nozzle, the effector's rotation and the last Jacobian."""
        for _ in range(passes):
            f, d, e = self._lengths(p, turn, joints, effector, arms)
            jac = np.concatenate([-2 * d, -2 * np.cross(e, d)], 2)
            step = np.linalg.solve(jac, -f[:, :, None])[:, :, 0]
            p, turn = p + step[:, :3], turn + step[:, 3:]
            if np.abs(step).max() < 1e-10:
                break
        return p, turn, jac

    # -- readings --------------------------------------------------------------------------------------------------
    def _shape(self, p, rows, causes):
        h = rows.bed_h + rows.bed_s[:, 0] * p[:, 0] + rows.bed_s[:, 1] * p[:, 1]
        for c in causes:
            if c["cause"].startswith("bed_"):
                u, v = p[:, 0] / rows.rim, p[:, 1] / rows.rim
                f = {"bed_bowl": u * u + v * v, "bed_twist": 2 * u * v, "bed_cylinder": u * u if c["axis"] == "x" else v * v}[c["cause"]]
                h = h + c["height_um"] * MM * (f + c.get("fourth", 0.0) * (f * f - f))
            elif c["cause"] == "frame_temperature":
                sign = 1 if c["axis"] == "bed" else -1
                h = h + sign * c["growth_um_per_k"] * MM * rows.weather.rise(c["axis"], rows.t, c["lag_s"])
        return h

    def _reach(self, rows, causes):
        delta = np.full(rows.N, self.pretravel)
        for c in causes:
            if c["cause"] == "probe_temperature":
                delta += c["drift_um_per_k"] * MM * rows.weather.rise("screw", rows.t, c["lag_s"])
        return -delta

    def settle(self, rows, rng):
        n = rows.N
        rows.motor = self.motors(rows.cmd)
        rows.motor_start = self.motors(rows.start)
        rows.dir_motor = np.sign(np.where(np.abs(rows.motor - rows.motor_start) > 1e-4, rows.motor - rows.motor_start, 0))
        rows.rim = float(np.hypot(rows.cmd[rows.touch, 0], rows.cmd[rows.touch, 1]).max()) if rows.touch.any() else 1.0
        rows.bed_h, rows.bed_s, rows.zero, rows.plays = np.zeros(n), np.zeros((n, 2)), np.zeros(n), {}
        rows.gauge_turn = np.zeros(n)
        for setup in np.unique(rows.setup):
            here = rows.setup == setup
            a = rows.artefacts.get(int(setup))
            if a:
                rows.bed_h[here], rows.bed_s[here] = a["height"], a["slope"]
            turn = rng.uniform(-2e-3, 2e-3)
            for n_of in {tuple(v) for v in rows.n[here & ~rows.touch].tolist()}:
                mine = here & ~rows.touch & (rows.n == n_of).all(1)
                rows.zero[mine] = rng.normal(0, 0.03)
                rows.gauge_turn[mine] = turn if abs(n_of[2]) < 0.5 else 0.0

    def measure(self, rows, causes=(), passes=4, counts=False):
        w, t = np.zeros(rows.N), rows.touch
        latency = sum(c["latency_ms"] * 1e-3 for c in causes if c["cause"] == "trigger_latency")
        reach = self._reach(rows, causes)
        p, turn = getattr(rows, "warm", (rows.cmd.copy(), np.zeros((rows.N, 3))))
        for i in range(passes if t.any() else 1):
            aim = rows.cmd + np.where(t[:, None], rows.n * w[:, None], 0.0)
            m = self.motors(aim)
            if counts and not t.all():
                m = np.where(t[:, None], m, np.round(m * self.steps) / self.steps)
            p, turn, jac = self.solve(*self._joints(m, rows, causes), p, turn)
            w = np.where(t, w - (p[:, 2] - self._shape(p, rows, causes) - reach), 0.0)
        if not causes:
            rows.warm, rows.jac, rows.at = (p, turn), jac, m
        w = np.where(t, w - np.nan_to_num(rows.feed) * latency, 0.0)
        if counts:                                     # the controller reports where its step counters stood
            stand = self.motors(rows.cmd + rows.n * w[:, None])
            part = np.round(stand * self.steps) / self.steps - stand
            w = np.where(t, w - part.mean(1), w)
        away = p - rows.cmd
        turned = np.column_stack([-rows.cmd[:, 1], rows.cmd[:, 0], np.zeros(rows.N)]) * rows.gauge_turn[:, None]
        return np.where(t, w, ((away - turned) * rows.n).sum(1) + rows.zero)

    def effect(self, rows, cause):
        """First order, from the built machine's own Jacobian."""
        p, turn = rows.warm
        f0 = self._lengths(p, turn, *self._joints(rows.at, rows, []))[0]
        f1 = self._lengths(p, turn, *self._joints(rows.at, rows, [cause]))[0]
        step = np.linalg.solve(rows.jac, -(f1 - f0)[:, :, None])[:, :3, 0]
        value = np.where(rows.touch, -1.0, 1.0) * (step * rows.n).sum(1)
        bed = self._shape(p, rows, [cause]) - self._shape(p, rows, []) + self._reach(rows, [cause]) - self._reach(rows, [])
        late = np.nan_to_num(rows.feed) * cause.get("latency_ms", 0.0) * 1e-3
        return value + rows.touch * (bed - late)

    def event_axes(self, _):
        return ABC

    def unit_motion(self, rows, axis):
        return self.effect(rows, dict(cause="offset", axis=axis, um=1.0)) / MM

    def reading_sigma(self, rows):
        return np.sqrt(rows.sigma ** 2 + (1.0 / self.steps[0] ** 2 / 3 + rows.res ** 2) / 12)

    def header_settings(self):
        return []


def baseline(machine, rows):
    """Columns of the always fitted: endstops, radius, angles, arm, scale, a plane and a place for each setup."""
    columns = []
    for what, axis, by in (("stop", "a", 1e-3), ("stop", "b", 1e-3), ("stop", "c", 1e-3), ("radius", "", 1e-3), ("angle", "a", 1e-3),
                           ("angle", "b", 1e-3), ("arm", "", 1e-3), ("scale", "", 1e-6)):
        columns.append(machine.effect(rows, dict(cause="built", axis=axis, what=what, by=by)))
    for setup in np.unique(rows.setup):
        here = (rows.setup == setup) & rows.touch
        if here.any():
            columns += [here * 1.0, here * rows.cmd[:, 0], here * rows.cmd[:, 1]]
        free = (rows.setup == setup) & ~rows.touch
        for k in range(3):
            if (np.abs(rows.n[free, k]) > 0.5).any():
                columns.append(free * rows.n[:, k])
        if free.any():
            columns.append(free * (rows.cmd[:, 0] * rows.n[:, 1] - rows.cmd[:, 1] * rows.n[:, 0]))
    return columns, None


def machine_yaml(m, rng):
    out = ["format: 1", f"name: {m.name}", "kinematics: delta",
           "towers: {" + ", ".join(f"{a}: {{angle_deg: {g:g}}}" for a, g in zip(ABC, m.angles)) + "}",
           f"delta_radius_mm: {m.radius:g}", f"arm_length_mm: {m.arm:g}",
           f"endstop_mm: {m.endstop:g}" if rng.uniform() < 0.6 else f"endstop_mm: {{a: {m.endstop:g}, b: {m.endstop:g}, c: {m.endstop:g}}}",
           f"rod_spacing_mm: {m.spacing:g}", f"effector_radius_mm: {m.eff:g}", f"joint_height_mm: {m.joint:g}", "axes:"]
    out += [f"  {a}: {{min_mm: 0, max_mm: {m.hi[0]:g}, pulley_mm_per_rev: {m.turn_mm:g}, full_steps_per_rev: 200, microsteps: {m.micro}}}" for a in ABC]
    return "\n".join(out) + "\n"
