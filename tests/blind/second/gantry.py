"""A gantry as it really is: motor counts -> screw -> play -> rails -> tool -> ball on a true face. Solved forward."""
import math
import numpy as np
import chain

XYZ = "xyz"
MM = 1e-3            # micrometres to millimetres


class Gantry:
    kind = "gantry"
    whole_steps = True            # counterfactual: False lets motors stand between micro-steps

    def __init__(self, rng):
        self.name = str(rng.choice(["router_one", "bench_mill", "gantry", "kreuz_2", "mill-north", "cnc6040"]))
        self.lo = np.zeros(3)
        self.hi = np.array([rng.choice([240., 300., 420., 600.]), rng.choice([240., 300., 400., 600.]), rng.choice([100., 120., 160.])])
        self.belt = [bool(rng.uniform() < 0.25), bool(rng.uniform() < 0.25), False]
        self.turn_mm = np.array([float(rng.choice([32., 40.])) if b else float(rng.choice([2., 4., 5., 5., 8., 10.])) for b in self.belt])
        self.turn_mm[2] = float(rng.choice([2., 4., 5.]))
        self.full = 200
        self.micro = [int(rng.choice([16, 32])) if not b else 64 for b in self.belt]
        self.steps = self.full * np.array(self.micro) / self.turn_mm                  # as configured
        self.tip_cfg = float(rng.choice([0.5, 1.0, 1.5, 2.0]))
        # baseline troubles, always there
        self.scale = rng.choice([-1, 1], 3) * rng.uniform(50e-6, 300e-6, 3)
        self.gap = rng.uniform(0.003, 0.04, 3)
        self.pretravel = np.append(np.full(2, rng.uniform(0.004, 0.03)), rng.uniform(0.004, 0.03))
        self.tip_true = self.tip_cfg + rng.normal(0, 0.002)
        self.table = rng.uniform(0.1e-3, 1.5e-3, 2) * rng.choice([-1, 1], 2)           # the table's slopes
        # where the rails' own turning points are: nobody has measured that either
        self.pivot = np.array([rng.uniform(-60, 60), rng.uniform(-60, 60), rng.uniform(-120, 150)])
        self.bearing = self.lo - rng.uniform(5, 40, 3)                                  # the screws' fixed bearings
        self.speck = (0.1e-3, 0.4e-3)

    # -- artefacts -------------------------------------------------------------------------------------------------
    def place(self, rows, setup, rng, flat=True, yaw=5e-3, centre=(0, 0, 0), speck=True):
        """Puts an artefact down: on the leaning table, perhaps on a speck of dust, turned a little, beside its place."""
        lean = np.array([self.table[1], -self.table[0]])
        if speck and rng.uniform() < 0.7:
            direction = rng.uniform(0, 2 * math.pi)
            lean = lean + rng.uniform(*self.speck) * np.array([math.cos(direction), math.sin(direction)])
        turn = np.array([lean[0], lean[1], rng.uniform(-yaw, yaw)])
        rows.artefacts[setup] = dict(turn=turn, shift=rng.normal(0, 0.03, 3), centre=np.asarray(centre, float), faces={}, bore=0.0)

    def _surfaces(self, rows):
        """Arrays of the touched faces' places, once for each plan."""
        n = rows.N
        turn, shift, centre, face, bore = (np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros(n))
        for i in range(n):
            a = rows.artefacts.get(int(rows.setup[i]))
            if a is None:
                continue
            turn[i], shift[i], centre[i], bore[i] = a["turn"], a["shift"], a["centre"], a["bore"]
            face[i] = a["faces"].get(rows.feature[i], 0.0)
        rows.true_turn = chain.rotation(turn)
        rows.true_shift, rows.true_centre, rows.true_face, rows.bore = shift, centre, face, bore
        rows.ring = rows.surface == "ring"
        rows.plays = {}

    # -- drives ----------------------------------------------------------------------------------------------------
    def _gaps(self, m, rows, causes):
        gap = np.tile(self.gap, (len(m), 1))
        for c in causes:
            if c["cause"] == "backlash_worn":
                k = XYZ.index(c["axis"])
                u = (m[:, k] - c["center_mm"]) / (c["width_mm"] / 2)
                gap[:, k] += c["extra_mm"] * np.exp(-math.log(2) * u * u)
            elif c["cause"] == "windup_load":
                k = XYZ.index(c["axis"])
                gap[:, k] += np.nan_to_num(rows.load) * c["compliance_um_per_n"] * MM
        return gap

    def _play(self, rows, causes):
        own = [c for c in causes if c["cause"] in ("backlash_worn", "windup_load")]
        key = repr([sorted(c.items()) for c in own])
        if key not in rows.plays:
            back = rows.off if rows.touch.any() else 0.0
            start, end = rows.start - back, rows.cmd - back
            rows.plays[key] = chain.play(start, end, self._gaps(start, rows, own), self._gaps(end, rows, own))
        return rows.plays[key]

    def drives(self, m, rows, causes):
        """Where the three carriages are when the motors stand at m (mm as the firmware counts)."""
        lag, since, sense = self._play(rows, causes)
        s = m * (1 + self.scale) + lag
        for c in causes:
            name, axis = c["cause"], c["axis"]
            k = XYZ.index(axis) if axis in ("x", "y", "z") else None
            if k is None:
                continue
            q, lo, hi = m[:, k], self.lo[k], self.hi[k]
            if name in ("cyclic_lead", "pulley_eccentric", "microstep"):
                wave = 2 * math.pi * q / c["period_mm"] + math.radians(c["phase_deg"])
                second = c.get("second", 0.0)
                s[:, k] += c["amplitude_um"] * MM * (np.sin(wave) + second * np.sin(2 * wave + 1.0))
            elif name == "pitch_progressive":
                u = chain.bow(q, lo, hi)
                s[:, k] += c["bow_um"] * MM * (u + c.get("cubic", 0.0) * 2 * chain.middle(q, lo, hi) * (u - 1))
            elif name == "thermal_screw":
                rise = rows.weather.rise("screw", rows.t, c["lag_s"])
                s[:, k] += c["expansion_um_per_m_k"] * 1e-6 * (q - self.bearing[k]) * rise
            elif name == "reversal_spike":
                s[:, k] -= sense[:, k] * c["height_um"] * MM * np.exp(-since[:, k] / c["decay_mm"])
            elif name == "missed_steps":
                home0 = rows.home[np.searchsorted(rows.t, c["at_t_s"]).clip(0, rows.N - 1)]
                s[:, k] += c["jump_um"] * MM * ((rows.t >= c["at_t_s"]) & (rows.home == home0))
            elif name == "homing_scatter":
                s[:, k] += np.array([c["draws"][h % len(c["draws"])] for h in rows.home]) * c["sd_um"] * MM
        return s

    # -- rails, tool -----------------------------------------------------------------------------------------------
    def tip(self, m, rows, causes):
        """True place of the ball (or of the gauge's target) in the machine's frame."""
        s = self.drives(m, rows, causes)
        x, y, z = s[:, 0], s[:, 1], s[:, 2]
        n = len(m)
        tool = rows.off.copy()
        along_y, along_x, along_z = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        turn_y, turn_x = np.zeros((n, 3)), np.zeros((n, 3))
        along_y[:, 1], along_x[:, 0], along_z[:, 2] = y, x, z
        used = False
        for c in causes:
            name, axis = c["cause"], c["axis"]
            if name == "squareness":
                a = c["angle_mrad"] * 1e-3
                if axis == "C0Y":
                    along_y[:, 0] -= math.sin(a) * y
                    along_y[:, 1] += (math.cos(a) - 1) * y
                elif axis == "B0Z":
                    along_z[:, 0] += math.sin(a) * z
                    along_z[:, 2] += (math.cos(a) - 1) * z
                else:
                    along_z[:, 1] -= math.sin(a) * z
                    along_z[:, 2] += (math.cos(a) - 1) * z
            elif name in ("straightness", "gantry_sag"):
                if name == "gantry_sag":
                    axis, size = "EZX", c["sag_um"]
                else:
                    size = c["bow_um"]
                k, j = XYZ.index(axis[2].lower()), XYZ.index(axis[1].lower())
                u = chain.bow(m[:, k], self.lo[k], self.hi[k])
                curve = u + c.get("fourth", 0.0) * (u * u - u)          # a rail on supports is no exact parabola
                (along_x, along_y, along_z)[k][:, j] += size * MM * curve
            elif name in ("angular", "axis_twist"):
                if name == "axis_twist":
                    axis, size = "EAX", c["twist_mrad"] * 1e-3
                else:
                    size = c["slope_urad"] * 1e-6
                k, j = XYZ.index(axis[2].lower()), "ABC".index(axis[1])
                (turn_x, turn_y)[k][:, j] += size * chain.middle(m[:, k], self.lo[k], self.hi[k])
                used = True
            elif name == "tip_runout":
                way = np.radians(rows.spin + c["phase_deg"])
                tool[:, 0] += c["offset_um"] * MM * np.cos(way) * rows.touch
                tool[:, 1] += c["offset_um"] * MM * np.sin(way) * rows.touch
            elif name == "frame_temperature" and axis == "frame":
                along_z[:, 2] += c["growth_um_per_k"] * MM * rows.weather.rise("frame", rows.t, c["lag_s"])
            elif name == "frame_growth":
                along_z[:, 2] += c["growth_um"] * MM * (1 - np.exp(-rows.t / c["tau_s"]))
            elif name == "servo_lag":
                along_x, along_y = self._servo(rows, along_x, along_y, c["lag_um_at_50_mm_s"], None)
            elif name == "servo_mismatch":
                along_x, along_y = self._servo(rows, along_x, along_y, None, c["mismatch_ms"])
        if not used:
            return along_y + along_x + along_z + tool
        # Y carries the beam, the beam the X slide, the slide the Z ram; each turns about its own guide, not about the tool
        arm_z = along_z + tool - np.array([0, 0, self.pivot[2]])
        ram = chain.apply(chain.rotation(turn_x), arm_z) + np.array([0, 0, self.pivot[2]])
        reach = along_x - np.array([(self.lo[0] + self.hi[0]) / 2 + self.pivot[0], 0, 0]) + ram - np.array([0, 0, self.pivot[2]])
        return along_y + chain.apply(chain.rotation(turn_y), reach) + np.array([(self.lo[0] + self.hi[0]) / 2 + self.pivot[0], 0, self.pivot[2]])

    def _servo(self, rows, along_x, along_y, lag_um, mismatch_ms):
        """First-order followers on a circle: amplitude 1/sqrt(1 + (w tau)^2), phase -atan(w tau)."""
        r = rows.radial
        if not r.any():
            return along_x, along_y
        R, way = rows.circle_r[r], rows.circle_a[r]
        w = rows.feed[r] * rows.circle_s[r] / R
        if lag_um is not None:
            k = 1 - lag_um * MM / 100.0
            tau = np.full(len(w), math.sqrt(1 / (k * k) - 1) / 0.5)
            tx = ty = tau
        else:
            tx, ty = np.zeros(len(w)) - mismatch_ms * 5e-4, np.zeros(len(w)) + mismatch_ms * 5e-4
        along_x[r, 0] += R * (np.cos(way - np.arctan(w * tx)) / np.sqrt(1 + (w * tx) ** 2) - np.cos(way))
        along_y[r, 1] += R * (np.sin(way - np.arctan(w * ty)) / np.sqrt(1 + (w * ty) ** 2) - np.sin(way))
        return along_x, along_y

    # -- faces -----------------------------------------------------------------------------------------------------
    def _shape(self, p, rows, causes, n):
        """Height of the touched face over its drawing at p (artefact's frame)."""
        h = rows.true_face.copy()
        for c in causes:
            if c["cause"] in ("bed_bowl", "bed_cylinder", "bed_twist"):
                mid = (self.lo[:2] + self.hi[:2]) / 2
                a = -np.radians(rows.turn)
                d = p[:, :2] - mid
                u = (np.cos(a) * d[:, 0] - np.sin(a) * d[:, 1]) / (self.hi[0] - mid[0])     # U of the travel, in the bed's frame
                v = (np.sin(a) * d[:, 0] + np.cos(a) * d[:, 1]) / (self.hi[1] - mid[1])
                if c["cause"] == "bed_twist":
                    f = u * v
                elif c["cause"] == "bed_cylinder":
                    f = u * u if c["axis"] == "x" else v * v
                    f = f + c.get("fourth", 0.0) * (f * f - f)
                else:
                    f = (u * u + v * v) / 2
                h += c["height_um"] * MM * f * (rows.surface == "plate")
            elif c["cause"] == "block_size":
                mine = np.array([f.split(".")[0] == c["axis"] for f in rows.feature])
                h += mine * c["error_um"] * MM / 2
            elif c["cause"] == "frame_temperature" and c["axis"] == "bed":
                h += c["growth_um_per_k"] * MM * rows.weather.rise("bed", rows.t, c["lag_s"]) * n[:, 2]
        return h

    def _reach(self, rows, causes):
        """Distance of the ball's centre from the face when the probe speaks, were the stylus stiff."""
        n = rows.n
        delta = np.sqrt((self.pretravel[None] ** 2 * n * n).sum(1))
        theta = np.arctan2(n[:, 1], n[:, 0]) - np.radians(rows.spin)
        side = np.hypot(n[:, 0], n[:, 1])
        for c in causes:
            if c["cause"] == "probe_lobing":
                delta += side * c["amplitude_um"] * MM * np.cos(3 * theta + math.radians(c["phase_deg"]))
            elif c["cause"] == "stylus_anisotropy":
                delta += side * c["amplitude_um"] * MM * np.cos(2 * theta + math.radians(c["phase_deg"]))
            elif c["cause"] == "probe_temperature":
                delta += c["drift_um_per_k"] * MM * rows.weather.rise("screw", rows.t, c["lag_s"])
        return self.tip_true - delta

    def distance(self, p, rows, causes):
        """From the ball's centre to the true face, along its true normal."""
        q = np.einsum("nji,nj->ni", rows.true_turn, p - rows.true_centre - rows.true_shift) + rows.true_centre
        d = ((q - rows.cmd) * rows.n).sum(1) - self._shape(q, rows, causes, rows.n)
        if rows.ring.any():
            r = rows.ring
            radius = np.hypot(q[r, 0] - rows.true_centre[r, 0], q[r, 1] - rows.true_centre[r, 1])
            nominal = np.hypot(rows.cmd[r, 0] - rows.true_centre[r, 0], rows.cmd[r, 1] - rows.true_centre[r, 1])
            d[r] = nominal + rows.bore[r] / 2 - radius
        return d

    # -- readings --------------------------------------------------------------------------------------------------
    def measure(self, rows, causes=(), passes=5, counts=False):
        """Noise-free value_mm of every row. counts: motors stand on whole micro-steps."""
        if not hasattr(rows, "ring"):
            self._surfaces(rows)
        back = np.where(rows.touch[:, None], rows.off, 0.0)
        w = np.zeros(rows.N)
        t = rows.touch
        reach = self._reach(rows, causes)
        latency = sum(c["latency_ms"] * 1e-3 for c in causes if c["cause"] == "trigger_latency")
        for _ in range(passes if t.any() else 0):
            m = rows.cmd - back + np.where(t[:, None], rows.n * (self.tip_cfg + w)[:, None], 0.0)
            w = np.where(t, w - (self.distance(self.tip(m, rows, causes), rows, causes) - reach), 0.0)
        w = np.where(t, w - np.nan_to_num(rows.feed) * latency, 0.0)
        m = rows.cmd - back + np.where(t[:, None], rows.n * (self.tip_cfg + w)[:, None], 0.0)
        if counts and self.whole_steps:
            stood = np.round(m * self.steps) / self.steps
            w = np.where(t, w + ((stood - m) * rows.n).sum(1), w)
            m = np.where(t[:, None], m, stood)
        tip = self.tip(m, rows, causes)
        away = tip - np.where(t[:, None], m, rows.cmd)
        value = np.where(t, w, (away * rows.n).sum(1))
        r = rows.radial
        if r.any():
            middle = rows.circle_c[r]
            value[r] = np.hypot(tip[r, 0] - middle[:, 0], tip[r, 1] - middle[:, 1]) - rows.circle_r[r]
        return value + rows.zero

    # -- what the files and the judge need ---------------------------------------------------------------------------
    def settle(self, rows, rng):
        """Gauges are zeroed anywhere; a ball-bar has a length and a centre of its own."""
        rows.zero = np.zeros(rows.N)
        for setup in np.unique(rows.setup):
            here = (rows.setup == setup) & ~rows.touch
            rows.zero[here] = rng.normal(0, 0.02)
        rows.circle_r, rows.circle_a, rows.circle_s, rows.circle_c = (np.ones(rows.N), np.zeros(rows.N), np.ones(rows.N), np.zeros((rows.N, 3)))
        shifts = {}
        for i, item in enumerate(rows.items):
            if "circle" in item:
                r, a, s, c = item["circle"]
                shift = shifts.setdefault(item["setup"], np.append(rng.normal(0, 0.02, 2), 0.0))
                rows.circle_r[i], rows.circle_a[i], rows.circle_s[i], rows.circle_c[i] = r, a, s, np.asarray(c) + shift

    def reading_sigma(self, rows):
        step = (np.abs(rows.n) / self.steps).max(1)
        return np.sqrt(rows.sigma ** 2 + (step ** 2 + rows.res ** 2) / 12)

    def unit_motion(self, rows, axis):
        """Effect on the readings of one unit of motion error along an axis."""
        return np.where(rows.touch, -1.0, 1.0) * rows.n[:, XYZ.index(axis)]

    def effect(self, rows, cause):
        return self.measure(rows, [cause], passes=2) - rows.plain

    def header_settings(self):
        words = ", ".join(f"{a}: {s:g}" for a, s in zip(XYZ, self.steps))
        return ["settings:", f"  asdrawn: {{steps_per_mm: {{{words}}}, tip_radius_mm: {self.tip_cfg:g}}}"]
