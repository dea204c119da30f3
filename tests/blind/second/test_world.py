#!/usr/bin/env python3
"""Closed-form checks of the second world's physics and signs (CONTRACT.md), and that a seed gives the same bytes."""
import math
import os
import sys
import unittest
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import chain                                                   # noqa: E402
import delta                                                   # noqa: E402
import delta_runs                                              # noqa: E402
import gantry                                                  # noqa: E402
import gantry_runs                                             # noqa: E402
import generate                                                # noqa: E402
import screws                                                  # noqa: E402
import screws_runs                                             # noqa: E402
import visibility                                              # noqa: E402

UM = 1e-3


def perfect_gantry():
    m = gantry.Gantry(np.random.default_rng(5))
    m.lo, m.hi = np.zeros(3), np.array([300.0, 300.0, 100.0])
    m.scale, m.gap, m.pretravel, m.table = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(2)
    m.tip_true, m.speck, m.pivot = m.tip_cfg, (0.0, 0.0), np.zeros(3)
    return m


def gantry_rows(machine, points):
    """[(kind, cmd, n, more)] as rows on perfect artefacts."""
    rng, rows = np.random.default_rng(1), chain.Rows()
    for kind, cmd, n, more in points:
        row = rows.add("c", cmd, n, kind=kind, **more)
        if kind == "touch":
            row["start"] = row["cmd"] + np.asarray(n, float) * 4.0
    rows.artefacts[0] = dict(turn=np.zeros(3), shift=np.zeros(3), centre=np.zeros(3), faces={}, bore=0.0, half=100.0)
    rows.close(rng)
    rows.weather = chain.Weather(rng, rows.t[-1] + 1, False)
    rows.told = {"t"}
    machine.settle(rows, rng)
    rows.zero[:] = 0
    return rows


class Gantry(unittest.TestCase):
    def setUp(self):
        self.m = perfect_gantry()

    def read(self, points, causes=()):
        return self.m.measure(gantry_rows(self.m, points), causes)

    def test_perfect_machine_reads_nothing(self):
        v = self.read([("touch", (10, 20, 30), (1, 0, 0), {}), ("touch", (10, 20, 5), (0, 0, 1), {}), ("position", (200, 20, 30), (0, 1, 0), {})])
        self.assertLess(np.abs(v).max(), 1e-12)

    def test_scale(self):
        self.m.scale[0] = 0.01
        v = self.read([("position", (100, 0, 0), (1, 0, 0), {}), ("touch", (100, 0, 0), (1, 0, 0), {}), ("touch", (100, 0, 0), (-1, 0, 0), {})])
        self.assertAlmostEqual(v[0], 1.0, 9)
        self.assertAlmostEqual(v[1], -(100 + self.m.tip_cfg) * 0.01 / 1.01, 3)
        self.assertAlmostEqual(v[1], -1.0, 1)
        self.assertAlmostEqual(v[2], 1.0, 1)

    def test_pretravel_is_negative_on_every_face(self):
        self.m.pretravel[:] = 0.02
        v = self.read([("touch", (10, 20, 30), n, {}) for n in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, 0, 1))])
        np.testing.assert_allclose(v, -0.02, atol=1e-9)

    def test_backlash(self):
        self.m.gap[0] = 0.04
        v = self.read([("touch", (50, 0, 0), (1, 0, 0), {}), ("touch", (50, 0, 0), (-1, 0, 0), {}),
                       ("position", (60, 0, 0), (1, 0, 0), dict(start=(50, 0, 0))), ("position", (55, 0, 0), (1, 0, 0), dict(start=(60, 0, 0)))])
        np.testing.assert_allclose(v, [-0.02, -0.02, -0.02, 0.02], atol=1e-9)

    def test_tip_radius(self):
        self.m.tip_true = self.m.tip_cfg + 0.01
        np.testing.assert_allclose(self.read([("touch", (50, 0, 0), (1, 0, 0), {})]), 0.01, atol=1e-9)

    def test_squareness_signs(self):
        a = lambda axis: [dict(cause="squareness", axis=axis, angle_mrad=1.0)]
        self.assertAlmostEqual(self.read([("position", (0, 200, 0), (1, 0, 0), {})], a("C0Y"))[0], -0.2, 6)
        self.assertAlmostEqual(self.read([("position", (0, 0, 100), (1, 0, 0), {})], a("B0Z"))[0], 0.1, 6)
        self.assertAlmostEqual(self.read([("position", (0, 0, 100), (0, 1, 0), {})], a("A0Z"))[0], -0.1, 6)
        self.assertAlmostEqual(self.read([("touch", (0, 200, 0), (1, 0, 0), {})], a("C0Y"))[0], 0.2, 6)

    def test_bows_and_sags(self):
        bow = [dict(cause="pitch_progressive", axis="x", bow_um=10.0)]
        v = self.read([("position", (q, 0, 0), (1, 0, 0), {}) for q in (0, 150, 300)], bow)
        np.testing.assert_allclose(v - v[1], [10 * UM, 0, 10 * UM], atol=1e-9)
        sag = [dict(cause="gantry_sag", axis="", sag_um=10.0)]
        v = self.read([("position", (q, 0, 0), (0, 0, 1), {}) for q in (0, 150, 300)], sag)
        np.testing.assert_allclose(v[1] - v, [-10 * UM, 0, -10 * UM], atol=1e-9)      # the middle hangs lower
        v = self.read([("touch", (q, 0, 0), (0, 0, 1), {}) for q in (0, 150, 300)], sag)
        np.testing.assert_allclose(v[1] - v, [10 * UM, 0, 10 * UM], atol=1e-8)

    def test_rotations(self):
        v = self.read([("position", (q, 0, z), (1, 0, 0), {}) for q in (0, 300) for z in (0, 100)], [dict(cause="angular", axis="EBX", slope_urad=100.0)])
        self.assertAlmostEqual((v[3] - v[2]) - (v[1] - v[0]), 100e-6 * 100, 7)         # dx = beta z
        v = self.read([("touch", (q, 100, 0), (0, 0, 1), dict(off=(0, o, 0))) for q in (0, 300) for o in (0, 40)],
                      [dict(cause="axis_twist", axis="", twist_mrad=1.0)])
        self.assertAlmostEqual((v[3] - v[2]) - (v[1] - v[0]), -1e-3 * 40, 6)           # dz = alpha r_y, touch the other sign
        v = self.read([("position", (x, q, 0), (0, 1, 0), {}) for q in (0, 300) for x in (0, 200)], [dict(cause="angular", axis="ECY", slope_urad=100.0)])
        self.assertAlmostEqual((v[3] - v[2]) - (v[1] - v[0]), 100e-6 * 200, 7)         # dy = gamma x

    def test_drift_signs(self):
        points = [("touch", (50, 50, 0), (0, 0, 1), dict(dt=500.0)) for _ in range(6)] + [("touch", (50, 50, 0), (1, 0, 0), dict(dt=500.0))]
        rows = gantry_rows(self.m, points)
        for series in rows.weather.series.values():
            series[:] = 20.0 + 5.0 * (rows.weather.t > 100)
        late = lambda cause, axis, **p: self.m.measure(rows, [dict(cause=cause, axis=axis, **p)])[[4, 6]]
        np.testing.assert_allclose(late("frame_temperature", "frame", growth_um_per_k=2.0, lag_s=0), [-10 * UM, 0], atol=1e-9)
        np.testing.assert_allclose(late("frame_temperature", "bed", growth_um_per_k=2.0, lag_s=0), [10 * UM, 0], atol=1e-9)
        np.testing.assert_allclose(late("probe_temperature", "", drift_um_per_k=2.0, lag_s=0), [-10 * UM, -10 * UM], atol=1e-9)
        self.assertLess(late("frame_growth", "", growth_um=10.0, tau_s=100.0)[0], -9 * UM)

    def test_jump_sign(self):
        points = [("touch", (50, 50, 0), (1, 0, 0), {}) for _ in range(4)]
        v = self.read(points, [dict(cause="missed_steps", axis="x", jump_um=20.0, at_t_s=9.0)])
        self.assertAlmostEqual(v[3] - v[0], -20 * UM, 9)

    def test_probe(self):
        v = self.read([("touch", (50, 50, 0), (1, 0, 0), dict(feed=f)) for f in (1.0, 5.0)], [dict(cause="trigger_latency", axis="", latency_ms=2.0)])
        self.assertAlmostEqual(v[1] - v[0], -4 * 2e-3, 9)
        lob = [dict(cause="probe_lobing", axis="", amplitude_um=3.0, phase_deg=0.0)]
        v = self.read([("touch", (50, 50, 0), (1, 0, 0), {}), ("touch", (50, 50, 0), (1, 0, 0), dict(spin=60.0))], lob)
        np.testing.assert_allclose(v, [-3 * UM, 3 * UM], atol=1e-9)                    # pre-travel grows: the touch reads less
        run = [dict(cause="tip_runout", axis="", offset_um=10.0, phase_deg=0.0)]
        v = self.read([("touch", (50, 50, 0), (1, 0, 0), dict(spin=s)) for s in (0.0, 90.0, 180.0)], run)
        np.testing.assert_allclose(v, [-10 * UM, 0, 10 * UM], atol=1e-9)               # tip further to +x: the face is met early

    def test_spike_and_load(self):
        m, k = self.m, dict(cause="reversal_spike", axis="x", height_um=10.0, decay_mm=1.0)
        v = self.read([("position", (60, 0, 0), (1, 0, 0), dict(start=(50, 0, 0))), ("position", (59, 0, 0), (1, 0, 0), dict(start=(60, 0, 0)))], [k])
        self.assertAlmostEqual(v[1], 10 * UM * math.exp(-1), 9)                        # -s height exp(-d / decay), s = -1
        v = self.read([("position", (60, 0, 0), (1, 0, 0), dict(start=(50, 0, 0), load=50.0))], [dict(cause="windup_load", axis="x", compliance_um_per_n=0.2)])
        self.assertAlmostEqual(v[0], -50 * 0.2 / 2 * UM, 9)
        self.assertEqual(m.gap[0], 0)

    def test_servo(self):
        rows = chain.Rows()
        b = gantry_runs.Builder(np.random.default_rng(2), self.m, rows)
        b.ballbar((50.0,), 72)
        rows.close(np.random.default_rng(3))
        rows.weather = chain.Weather(np.random.default_rng(3), 100, False)
        self.m.settle(rows, np.random.default_rng(4))
        rows.zero[:], rows.circle_c[:] = 0, np.round((self.m.lo + self.m.hi) / 2)
        lag = self.m.measure(rows, [dict(cause="servo_lag", axis="", lag_um_at_50_mm_s=10.0)])
        np.testing.assert_allclose(lag, -10 * UM, atol=1e-4)                        # commanded points are written to 0.1 um
        tau = self.m.measure(rows, [dict(cause="servo_mismatch", axis="", mismatch_ms=1.0)])
        theta = np.arctan2(rows.n[:, 1], rows.n[:, 0])
        np.testing.assert_allclose(tau, -rows.circle_s * 50 * 1e-3 * np.sin(2 * theta) / 2, atol=1e-4)

    def test_play_operator(self):
        start, end = np.array([[0.0], [1.0], [0.99]]), np.array([[1.0], [0.99], [2.0]])
        lag, since, sense = chain.play(start, end, np.full((3, 1), 0.04), np.full((3, 1), 0.04))
        np.testing.assert_allclose(lag[:, 0], [-0.02, -0.01, -0.02], atol=1e-12)       # inside the gap the carriage stays
        self.assertAlmostEqual(since[1, 0], 0.01)
        np.testing.assert_allclose(sense[:, 0], [1, -1, 1])


class Delta(unittest.TestCase):
    def setUp(self):
        rng = np.random.default_rng(7)
        self.m, self.rows = delta.Delta(rng), chain.Rows()
        m = self.m
        m.stop_error, m.radius_error, m.arm_error, m.angle_error, m.scale = np.zeros(3), 0.0, 0.0, np.zeros(3), 0.0
        m.plane, m.base, m.pretravel = np.zeros(2), 0.0, 0.0
        b = delta_runs.Builder(rng, m, self.rows)
        b.grid(30, 1)
        b.xy(12, both=False, z=0.0)
        b.columns(3, 6)
        self.rows.close(rng)
        self.rows.weather = chain.Weather(rng, self.rows.t[-1], False)
        m.settle(self.rows, rng)
        self.rows.zero[:], self.rows.gauge_turn[:], self.rows.bed_h[:], self.rows.bed_s[:] = 0, 0, 0, 0
        self.plain = m.measure(self.rows)

    def test_forward_of_inverse(self):
        self.assertLess(np.abs(self.plain).max(), 1e-9)

    def test_first_order_agrees_with_the_solved(self):
        for cause in (dict(cause="rod_mismatch", axis="a1", length_error_mm=0.01), dict(cause="tower_lean", axis="b", radial_mrad=0.1, tangential_mrad=0.05),
                      dict(cause="tower_twist", axis="c", angle_deg=0.02), dict(cause="belt_pitch", axis="a", error_ppm=50.0)):
            solved = self.m.measure(self.rows, [cause]) - self.plain
            self.assertLess(np.abs(self.m.effect(self.rows, cause) - solved).max(), 0.02 * np.abs(solved).max(), cause["cause"])

    def test_signs(self):
        centre = np.flatnonzero(self.rows.touch)[np.hypot(*self.rows.cmd[self.rows.touch][:, :2].T).argmin()]
        longer = self.m.measure(self.rows, [dict(cause="rod_mismatch", axis=a, length_error_mm=0.1) for a in "abc"])
        self.assertGreater(longer[centre], 0.05)            # longer rods: the nozzle hangs lower, the bed is met early
        one, two = (self.m.measure(self.rows, [dict(cause="rod_mismatch", axis=a, length_error_mm=0.05)]) for a in ("a1", "a2"))
        touched = self.rows.touch
        far = np.abs(one - two)[touched].max()
        np.testing.assert_allclose((one - two)[touched] / 2, (one - (one + two) / 2)[touched], atol=1e-6 + 0.1 * far)
        down = self.m.measure(self.rows, [dict(cause="belt_pitch", axis=a, error_ppm=1000.0) for a in "abc"])
        self.assertGreater(down[centre], 0)                 # the carriages go further down than told
        self.m.scale = 1e-3
        self.assertAlmostEqual(self.m.measure(self.rows)[centre], down[centre], 6)

    def test_twist_of_the_pair(self):
        # a1 is the clockwise one from above: of the tower at 90 degrees it is the one at larger x
        joints = self.m._joints(self.rows.motor, self.rows, [])[0]
        self.assertGreater(joints[0, 4, 0], joints[0, 5, 0])
        turned = self.m._joints(self.rows.motor, self.rows, [dict(cause="tower_twist", axis="c", angle_deg=1.0)])[0]
        self.assertGreater(turned[0, 4, 1], joints[0, 4, 1])     # counter-clockwise: the one at +x goes to +y
        lean = self.m._joints(self.rows.motor, self.rows, [dict(cause="tower_lean", axis="c", radial_mrad=1.0, tangential_mrad=0.0)])[0]
        self.assertGreater(lean[0, 4, 1], joints[0, 4, 1])       # the top goes outward

    def test_bed_and_backlash(self):
        v = self.m.measure(self.rows, [dict(cause="bed_bowl", axis="", height_um=100.0)])
        r = np.hypot(self.rows.cmd[:, 0], self.rows.cmd[:, 1])
        np.testing.assert_allclose(v[self.rows.touch], 0.1 * (r[self.rows.touch] / self.rows.rim) ** 2, atol=1e-5)
        v = self.m.measure(self.rows, [dict(cause="carriage_backlash", axis=a, gap_mm=0.02) for a in "abc"])
        up = ~self.rows.touch & (self.rows.n[:, 2] > 0.5)
        np.testing.assert_allclose(v[up], -self.rows.dir[up, 2] * 0.01, atol=5e-4)


class TripleZ(unittest.TestCase):
    def setUp(self):
        rng = np.random.default_rng(8)
        self.m, self.rows = screws.TripleZ(rng), chain.Rows()
        m = self.m
        m.scale, m.gap, m.pretravel, m.gantry_plane, m.tip_true, m.dust = 0.0, 0.0, 0.0, np.zeros(2), m.tip_cfg, 0.0
        m.rng_homes = np.zeros((40, 3))
        b = screws_runs.Builder(rng, m, self.rows)
        b.grid((0.0, 100.0), 4, 4)
        b.posts(np.array([20.0, 60.0, 100.0]))
        b.one_by_one(0.5)
        self.rows.close(rng)
        self.rows.weather = chain.Weather(rng, self.rows.t[-1], False)
        m.settle(self.rows, rng)
        self.rows.zero[:], self.rows.face_h[:], self.rows.face_s[:] = 0, 0, 0

    def read(self, *causes):
        return self.m.measure(self.rows, list(causes))

    def test_perfect(self):
        # a bed tilted by one screw turns about the groove and slides by the cosine and by the pivots' depth: nothing else is left
        self.assertLess(np.abs(self.read()).max(), 2e-4)

    def test_scale_both_ways(self):
        plain = self.read()
        self.m.scale = 1e-4
        v, t, up = self.read() - plain, self.rows.touch, ~self.rows.touch
        height = self.m.hi[2] - self.rows.cmd[:, 2]
        np.testing.assert_allclose(v[up], -1e-4 * height[up], atol=1e-6)         # bed too high: the axis stands at a smaller cmd_z
        flat = t & (np.ptp(self.rows.motor, axis=1) < 1e-9)
        np.testing.assert_allclose(v[flat], 1e-4 * height[flat], atol=1e-4)

    def test_one_screw(self):
        v = self.read(dict(cause="offset", axis="z1", um=100.0)) - self.read()
        a = np.column_stack([self.m.at, np.ones(3)])
        weight = np.linalg.solve(a.T, np.column_stack([self.rows.cmd[:, :2], np.ones(self.rows.N)]).T).T[:, 0]
        t = self.rows.touch
        np.testing.assert_allclose(v[t], 0.1 * weight[t], atol=2e-4)
        np.testing.assert_allclose(v[~t], -0.1 * weight[~t], atol=2e-4)

    def test_swapped_motors_show_with_one_screw_moved(self):
        v = self.read(dict(cause="motors_swapped", axis="z1z2")) - self.read()
        flat = np.ptp(self.rows.motor, axis=1) < 1e-9
        self.assertLess(np.abs(v[flat]).max(), 1e-9)
        self.assertGreater(np.abs(v[~flat]).max(), 0.2)


class World(unittest.TestCase):
    def test_determinism_and_streams(self):
        for kind in ("gantry", "delta", "triple_z"):
            first = [generate.case(kind, c, s) for _, c, s in generate.streams(kind, 1, 2, 11)]
            again = [generate.case(kind, c, s) for _, c, s in generate.streams(kind, 1, 2, 11)]
            self.assertEqual(first, again)
            self.assertNotEqual(first[1]["DATA.csv"], first[2]["DATA.csv"])

    def test_projection(self):
        rng, n = np.random.default_rng(1), 40
        q = np.linspace(-1, 1, n)
        project = visibility.Projector([np.ones(n), q], np.full(n, 2.0))
        self.assertLess(np.abs(project(3 + 5 * q)).max(), 1e-9)
        p = project(q * q)
        self.assertAlmostEqual(np.abs(p).max(), abs(1 - (q * q).mean()) / 2, 6)
        found = visibility.twins(project, 100 * q * q, [("same", "x", [[q * q + 7 * q]]), ("other", "x", [[q ** 3]]), ("blind", "x", [[q]]),
                                                        ("whiff", "x", [[1e-6 * q * q]])],
                                 ("me", "x"))
        self.assertEqual([f["cause"] for f in found], ["same"])
        del rng

    def test_planted_cases_can_be_seen(self):
        for _, cause, stream in generate.streams("gantry", 0, 4, 3):
            c = generate.draw_case("gantry", cause, stream)
            self.assertGreaterEqual(c["truth"]["sigma"], 3)
            self.assertGreaterEqual(c["truth"]["energy"], 100)


if __name__ == "__main__":
    unittest.main()
