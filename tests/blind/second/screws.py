"""A bed on three screws as it really is: a rigid body on three nuts at their true pivots (ball, groove, flat), a gantry above.
`cmd_z` is the tool over the bed; the motors' columns are heights, so they grow where cmd_z falls."""
import math
import numpy as np
import chain

Z, MM = ("z1", "z2", "z3"), 1e-3


class TripleZ:
    kind = "triple_z"
    homing_share = 1.0            # counterfactual: 0 makes every homing leave the bed on the same plane

    def __init__(self, rng):
        self.name = str(rng.choice(["trident", "three_screws", "vcore", "bed3z"]))
        side = float(rng.choice([235., 300., 350.]))
        self.hi, self.lo = np.array([side, side, float(rng.choice([200., 250., 300.]))]), np.zeros(3)
        layouts = [[(20, 20), (side - 20, 20), (20, side - 20)], [(30, 10), (side - 30, 10), (side / 2, side - 10)],
                   [(-20, side * 0.2), (side + 20, side * 0.2), (side / 2, side + 15)]]
        self.at = np.array(layouts[int(rng.integers(3))], float)
        self.lead, self.full, self.micro = float(rng.choice([2., 4., 8.])), 200, int(rng.choice([16, 32]))
        self.steps, self.tip_cfg, self.belt = self.full * self.micro / self.lead, 0.5, [False] * 3
        # as built
        self.scale = float(rng.choice([-1, 1]) * rng.uniform(50e-6, 300e-6))
        self.gap, self.pretravel = rng.uniform(0.004, 0.04), rng.uniform(0.005, 0.05)
        self.under = rng.uniform(5, 30)                     # the pivots lie that far under the touched face
        self.gantry_plane = rng.normal(0, 0.5e-3, 2)
        self.tip_true = self.tip_cfg + rng.normal(0, 0.003)
        self.rng_homes = rng.normal(0, rng.uniform(0.008, 0.06), (40, 3))       # where each homing leaves the three screws
        self.dust = rng.normal(0, 0.02)

    def place(self, rows, setup, rng, **_):
        speck = rng.normal(0, 0.2e-3, 2) if setup else np.zeros(2)
        rows.artefacts[setup] = dict(slope=speck, height=rng.normal(0, 0.05) if setup else 0.0)

    def level(self, pattern, xy):
        """Heights of the drawn screws, this pattern apart, with which the bed's point at (x, y) is at the tool (cmd_z 0)."""
        a = np.column_stack([self.at, np.ones(3)])
        weights = np.linalg.solve(a.T, np.append(xy, 1.0))
        return self.hi[2] + np.asarray(pattern) - weights @ pattern

    # -- drives ----------------------------------------------------------------------------------------------------
    def _heights(self, m, rows, causes):
        gap, own = np.full((1, 3), self.gap), [c for c in causes if c["cause"] == "screw_backlash"]
        for c in own:
            gap[0, Z.index(c["axis"])] += c["gap_mm"]
        swap = [c for c in causes if c["cause"] == "motors_swapped"]
        order = [0, 1, 2]
        for c in swap:
            i, j = Z.index(c["axis"][:2]), Z.index(c["axis"][2:])
            order[i], order[j] = order[j], order[i]
        key = repr((own, order))
        if key not in rows.plays:
            wide = np.tile(gap, (rows.N, 1))
            rows.plays[key] = chain.play(rows.motor_start[:, order], rows.motor[:, order], wide, wide)[0]
        m = m[:, order]
        s = m * (1 + self.scale) + rows.plays[key] + rows.home_error
        for c in causes:
            name, axis = c["cause"], c["axis"]
            if name == "built":
                s = s + m * c["by"]
            if axis not in Z:
                continue
            k = Z.index(axis)
            q = m[:, k]
            if name == "screw_pitch":
                s[:, k] += q * c["error_ppm"] * 1e-6
            elif name == "screw_cyclic":
                w = 2 * math.pi * q / c["period_mm"] + math.radians(c["phase_deg"])
                s[:, k] += c["amplitude_um"] * MM * (np.sin(w) + c.get("second", 0.0) * np.sin(2 * w + 1.0))
            elif name == "pitch_progressive":
                s[:, k] += c["bow_um"] * MM * chain.bow(q, 0.0, self.hi[2])
            elif name == "missed_steps":
                home0 = rows.home[np.searchsorted(rows.t, c["at_t_s"]).clip(0, rows.N - 1)]
                s[:, k] += c["jump_um"] * MM * ((rows.t >= c["at_t_s"]) & (rows.home == home0))
            elif name == "offset":
                s[:, k] += c["um"] * MM
        return s

    def _bed(self, h, causes):
        """Pose of the bed: rotation (N,3,3) and place of its origin, three pivots at heights h - under."""
        at = self.at.copy()
        for c in causes:
            if c["cause"] == "pivot_position":
                at[Z.index(c["axis"])] += [c["dx_mm"], c["dy_mm"]]
        p = np.column_stack([at, np.full(3, -self.under)])
        n = len(h)
        turn, move = np.zeros((n, 3)), np.column_stack([np.zeros((n, 2)), h.mean(1)])
        side = p[1, :2] - p[0, :2]
        perp = np.array([-side[1], side[0]]) / np.linalg.norm(side)
        for _ in range(6):
            R = chain.rotation(turn)
            q = np.einsum("nij,kj->nki", R, p)
            f = np.empty((n, 6))
            f[:, :3] = q[:, :, 2] + move[:, 2:3] - (h - self.under)
            f[:, 3:5] = q[:, 0, :2] + move[:, :2] - p[0, :2]
            f[:, 5] = (q[:, 1, :2] + move[:, :2] - p[1, :2]) @ perp
            jac = np.zeros((n, 6, 6))
            jac[:, :3, 2] = 1.0
            jac[:, :3, 3], jac[:, :3, 4] = q[:, :, 1], -q[:, :, 0]              # (w x q)_z
            jac[:, 3, 0] = jac[:, 4, 1] = 1.0
            jac[:, 3, 4], jac[:, 3, 5] = q[:, 0, 2], -q[:, 0, 1]
            jac[:, 4, 3], jac[:, 4, 5] = -q[:, 0, 2], q[:, 0, 0]
            jac[:, 5, :2] = perp
            jac[:, 5, 3] = -q[:, 1, 2] * perp[1]
            jac[:, 5, 4] = q[:, 1, 2] * perp[0]
            jac[:, 5, 5] = -q[:, 1, 1] * perp[0] + q[:, 1, 0] * perp[1]
            step = np.linalg.solve(jac, -f[:, :, None])[:, :, 0]
            move, turn = move + step[:, :3], turn + step[:, 3:]
            if np.abs(step).max() < 1e-10:
                break
        return chain.rotation(turn), move

    def _surface(self, q, rows, causes):
        """Height of the touched face over the bed's own plane at q (bed's frame)."""
        h = rows.face_h + rows.face_s[:, 0] * q[:, 0] + rows.face_s[:, 1] * q[:, 1] + rows.stack
        mid = self.hi[:2] / 2
        u, v = (q[:, 0] - mid[0]) / mid[0], (q[:, 1] - mid[1]) / mid[1]
        for c in causes:
            if c["cause"].startswith("bed_"):
                f = {"bed_bowl": (u * u + v * v) / 2, "bed_twist": u * v, "bed_cylinder": u * u if c["axis"] == "x" else v * v}[c["cause"]]
                h = h + c["height_um"] * MM * (f + c.get("fourth", 0.0) * (f * f - f))
            elif c["cause"] == "frame_temperature" and c["axis"] == "bed":
                h = h + c["growth_um_per_k"] * MM * rows.weather.rise("bed", rows.t, c["lag_s"])
        return h

    def _tool(self, rows, causes):
        """Height of the ball's centre (its nominal is the travel's top) and what the probe adds."""
        x, y = rows.cmd[:, 0], rows.cmd[:, 1]
        z = self.hi[2] + self.gantry_plane[0] * x + self.gantry_plane[1] * y
        for c in causes:
            if c["cause"] == "gantry_sag":
                u = chain.bow(x, self.lo[0], self.hi[0])
                z = z + c["sag_um"] * MM * (u + c.get("fourth", 0.0) * (u * u - u))
            elif c["cause"] == "straightness":                                     # EZY: twins only
                u = chain.bow(y, self.lo[1], self.hi[1])
                z = z + c["bow_um"] * MM * (u + c.get("fourth", 0.0) * (u * u - u))
            elif c["cause"] == "angular":                                          # EBY, EBZ: dz = -beta x; EAZ: dz = alpha y
                along = y if c["axis"][2] == "Y" else rows.cmd[:, 2]
                k = 1 if c["axis"][2] == "Y" else 2
                turn = c["slope_urad"] * 1e-6 * chain.middle(along, self.lo[k], self.hi[k])
                z = z + (turn * y if c["axis"][1] == "A" else -turn * x)
            elif c["cause"] == "frame_temperature" and c["axis"] == "frame":
                z = z + c["growth_um_per_k"] * MM * rows.weather.rise("frame", rows.t, c["lag_s"])
        return z

    # -- readings --------------------------------------------------------------------------------------------------
    def settle(self, rows, rng):
        n = rows.N
        rows.plays, rows.zero, rows.face_h, rows.face_s = {}, np.zeros(n), np.zeros(n), np.zeros((n, 2))
        level = np.repeat((self.hi[2] - rows.cmd[:, 2])[:, None], 3, 1)
        rows.motor = np.array([level[i] if r["motor"] is None else r["motor"] for i, r in enumerate(rows.items)], float)
        down = np.array([r.get("down", 3.0) for r in rows.items])
        rows.motor_start = rows.motor - down[:, None]
        for i, r in enumerate(rows.items):
            if r.get("from_motor") is not None:
                rows.motor_start[i] = r["from_motor"]
        rows.dir_motor = np.sign(np.where(np.abs(rows.motor - rows.motor_start) > 1e-6, rows.motor - rows.motor_start, 0))
        rows.dir[:, 2] = -np.sign(np.round((rows.motor - rows.motor_start).mean(1), 6))
        rows.stack = np.where(rows.touch, rows.cmd[:, 2], 0.0)       # gauge blocks on the bed, carried from place to place
        rows.home_error = self.homing_share * self.rng_homes[rows.home % 40]
        for setup in np.unique(rows.setup):
            here = rows.setup == setup
            a = rows.artefacts.get(int(setup))
            if a:
                rows.face_h[here], rows.face_s[here] = a["height"] + self.dust, a["slope"]
            rows.zero[here & ~rows.touch] = rng.normal(0, 0.03)

    def measure(self, rows, causes=(), passes=5, counts=False):
        w, t = np.zeros(rows.N), rows.touch
        latency = sum(c["latency_ms"] * 1e-3 for c in causes if c["cause"] == "trigger_latency")
        delta = np.full(rows.N, self.pretravel)
        for c in causes:
            if c["cause"] == "probe_temperature":
                delta += c["drift_um_per_k"] * MM * rows.weather.rise("screw", rows.t, c["lag_s"])
        tool = self._tool(rows, causes)
        for _ in range(passes if t.any() else 1):
            m = rows.motor - np.where(t, self.tip_cfg + w, 0.0)[:, None]        # the bed lower: the tip higher over it
            if counts:
                m = np.where(t[:, None], m, np.round(m * self.steps) / self.steps)
            R, move = self._bed(self._heights(m, rows, causes), causes)
            point = np.column_stack([rows.cmd[:, :2], tool])
            q = np.einsum("nji,nj->ni", R, point - move)
            d = q[:, 2] - self._surface(q, rows, causes)
            w = np.where(t, w - (d - (self.tip_true - delta)), 0.0)
        w = np.where(t, w - np.nan_to_num(rows.feed) * latency, 0.0)
        if counts:
            stand = rows.motor - (self.tip_cfg + w)[:, None]
            w = np.where(t, w - (np.round(stand * self.steps) / self.steps - stand).mean(1), w)
        # an indicator on a fixed post: the bed's face along the vertical at (x, y), as the axis position it stands for
        top = move[:, 2] + (R[:, 2, 0] * q[:, 0] + R[:, 2, 1] * q[:, 1]) + R[:, 2, 2] * self._surface(q, rows, causes)
        nominal = self.hi[2] - rows.cmd[:, 2]
        return np.where(t, w, -(top - nominal) * rows.n[:, 2] + rows.zero)

    def effect(self, rows, cause):
        if not hasattr(rows, "two"):
            rows.two = self.measure(rows, [], passes=2)
        return self.measure(rows, [cause], passes=2) - rows.two

    def event_axes(self, _):
        return Z

    def unit_motion(self, rows, axis):
        return self.effect(rows, dict(cause="offset", axis=axis, um=1.0)) / MM

    def reading_sigma(self, rows):
        return np.sqrt(rows.sigma ** 2 + (1.0 / self.steps ** 2 + rows.res ** 2) / 12)

    def header_settings(self):
        return []


def baseline(machine, rows):
    """A plane for each homing and setup, the common scale and the common gap."""
    columns = [machine.effect(rows, dict(cause="built", axis="", by=1e-5))]
    columns.append(np.where(rows.touch, 0.0, 1.0) * rows.dir[:, 2])
    key = rows.home * 1000 + rows.setup
    for k in np.unique(key):
        here = (key == k) & rows.touch
        if here.any():
            columns += [here * 1.0, here * rows.cmd[:, 0], here * rows.cmd[:, 1]]
    for setup in np.unique(rows.setup):
        free = (rows.setup == setup) & ~rows.touch
        if free.any():
            columns.append(free * 1.0)
    return columns, None


def machine_yaml(m, rng):
    same = f"lead_mm: {m.lead:g}, full_steps_per_rev: 200, microsteps: {m.micro}"
    out = ["format: 1", f"name: {m.name}", "kinematics: triple_z", "axes:"]
    out += [f"  {a}: {{min_mm: 0, max_mm: {m.hi[k]:g}}}" for k, a in enumerate("xyz")] if rng.uniform() < 0.5 else [
        f"  x: {{min_mm: 0, max_mm: {m.hi[0]:g}, pulley_mm_per_rev: 40}}", f"  y: {{min_mm: 0, max_mm: {m.hi[1]:g}, pulley_mm_per_rev: 40}}",
        f"  z: {{min_mm: 0, max_mm: {m.hi[2]:g}}}"]
    out.append("screws:")
    out += [f"  {z}: {{at_mm: [{m.at[k, 0]:g}, {m.at[k, 1]:g}], {same}}}" for k, z in enumerate(Z)]
    out += [f"probe: {{tip_radius_mm: {m.tip_cfg:g}}}", f"settings: {{steps_per_mm: {{z: {m.steps:g}}}, tip_radius_mm: {m.tip_cfg:g}}}"]
    return "\n".join(out) + "\n"
