"""What can be wrong with a gantry, and the campaigns that show it. Sizes in the units of CONTRACT.md."""
import numpy as np


def pick(b, *words):
    return str(b.rng.choice(list(words)))


def wave(b, axis, period, key="amplitude_um"):
    return dict(axis=axis, size=key, period_mm=float(period * (1 + b.rng.uniform(-3e-4, 3e-4))), phase_deg=float(b.rng.uniform(-180, 180)),
                second=float(b.rng.uniform(-0.12, 0.12)))


def drive_axis(b, belt):
    good = [k for k in range(2) if b.mach.belt[k] == belt] + ([2] if not belt else [])
    return "xyz"[int(b.rng.choice(good))] if good else None


def cyclic_lead(b):
    axis = drive_axis(b, False)
    b.iso230(axis)
    if b.rng.uniform() < 0.8:
        b.dense(axis, b.mach.turn_mm["xyz".index(axis)])
    return dict(wave(b, axis, b.mach.turn_mm["xyz".index(axis)]), limits=(1, 25))


def pulley_eccentric(b):
    axis = drive_axis(b, True)
    if axis is None:
        return None
    b.iso230(axis)
    b.dense(axis, b.mach.turn_mm["xyz".index(axis)], 20.3, 2.6)
    return dict(wave(b, axis, b.mach.turn_mm["xyz".index(axis)]), limits=(3, 60))


def microstep(b):
    axis = pick(b, "x", "y", "z")
    period = 4 * b.mach.turn_mm["xyz".index(axis)] / b.mach.full
    b.dense(axis, period, 13.7, 4.0)
    b.dense(axis, period, 11.3, 4.0)
    b.iso230(axis)
    return dict(wave(b, axis, period), period_mm=period, limits=(1, 15))


def pitch_progressive(b):
    axis = pick(b, "x", "y", "z")
    b.iso230(axis)
    if b.rng.uniform() < 0.5:
        b.iso230(axis)
    return dict(axis=axis, size="bow_um", cubic=float(b.rng.uniform(-0.15, 0.15)), limits=(3, 80))


def thermal_screw(b):
    axis = pick(b, "x", "y")
    camp, seat, setup = b.campaign(LASER), b.seat(), b.rows.new_setup()
    q = b.targets(axis, int(b.rng.integers(5, 9)))
    pause = b.rng.uniform(10, 25)
    for run in range(int(b.rng.integers(8, 14))):
        b.line(camp, axis, q, True, 1, seat=seat, setup=setup)
        for row in b.rows.items[-2 * len(q):]:
            row.update(rep=run, dt=pause)
    return dict(axis=axis, size="expansion_um_per_m_k", lag_s=float(b.rng.uniform(0, 300)), limits=(2, 40), needs={"t", "temp"}, warm=True)


def drift(b, top=True):
    faces = [f for f in ("x+", "x-", "y+", "y-") if b.rng.uniform() < 0.6] or ["x+", "x-"]
    b.posts(tuple(faces) + (("z+",) if top else ()), rounds=int(b.rng.integers(20, 36)), pause=b.rng.uniform(60, 200))


def frame_growth(b):
    b.posts(("z+", "x+", "x-") if b.rng.uniform() < 0.5 else ("z+", "y+"), rounds=int(b.rng.integers(22, 36)), pause=b.rng.uniform(60, 200))
    return dict(axis="", size="growth_um", tau_share=float(b.rng.uniform(0.15, 0.5)), limits=(3, 80), needs={"t", "temp"}, warm=True)


def probe_temperature(b):
    drift(b)
    return dict(axis="", size="drift_um_per_k", lag_s=float(b.rng.uniform(0, 200)), limits=(0.3, 8), needs={"t", "temp"}, warm=True)


def frame_temperature(b):
    drift(b)
    axis = pick(b, "frame", "bed")                 # a warm bed rises; a warm frame lifts the tool or lowers it
    return dict(axis=axis, positive=axis == "bed", size="growth_um_per_k", lag_s=float(b.rng.uniform(0, 400)), limits=(0.5, 60),
                needs={"t", "temp"}, warm=True)


def backlash_worn(b):
    axis = pick(b, "x", "y", "z")
    k = "xyz".index(axis)
    b.iso230(axis, int(b.rng.integers(17, 27)), 3)
    if b.rng.uniform() < 0.5:
        b.iso230(axis, int(b.rng.integers(13, 21)), 2)
    span = b.mach.hi[k] - b.mach.lo[k]
    return dict(axis=axis, size="extra_mm", center_mm=float(b.mach.lo[k] + span * b.rng.uniform(0.25, 0.75)),
                width_mm=float(span * b.rng.uniform(0.2, 0.45)), limits=(0.004, 0.12), needs={"dir"})


def windup_load(b):
    axis = pick(b, "x", "y", "z")
    b.loads(axis)
    return dict(axis=axis, size="compliance_um_per_n", limits=(0.03, 3), needs={"dir", "load"})


def reversal_spike(b):
    axis = pick(b, "x", "y", "z")
    b.reversals(axis)
    b.iso230(axis)
    return dict(axis=axis, size="height_um", decay_mm=float(b.rng.uniform(0.3, 2.0)), limits=(1, 30), needs={"dir", "since"})


def missed_steps(b):
    axis = pick(b, "x", "y", "z")
    faces = {"x": ("x+", "x-", "z+"), "y": ("y+", "y-", "z+"), "z": ("z+", "x+", "y+")}[axis]
    b.posts(faces, rounds=int(b.rng.integers(16, 30)), pause=20.0)
    return dict(axis=axis, size="jump_um", jump=float(b.rng.uniform(0.2, 0.8)), limits=(3, 120), needs={"t"}, sign=True)


def homing_scatter(b):
    axis = pick(b, "x", "y", "z")
    faces = {"x": ("x+", "x-", "z+"), "y": ("y+", "y-", "z+"), "z": ("z+", "x+")}[axis]
    homes = int(b.rng.integers(8, 15))
    b.posts(faces, rounds=homes, homes=True, spins=(0.0,), feeds=(None, None))
    draws = b.rng.normal(0, 1, homes + 30)
    return dict(axis=axis, size="sd_um", draws=draws.tolist(), limits=(2, 80), needs={"home"}, positive=True)


def squareness(b):
    axis, pair = [("C0Y", "xy"), ("B0Z", "xz"), ("A0Z", "yz")][int(b.rng.integers(3))]
    b.square(pair[0], pair[1], turned=b.rng.uniform() < 0.7)
    if b.rng.uniform() < 0.4:
        b.plate()
    return dict(axis=axis, size="angle_mrad", limits=(0.005, 0.8))


def straightness(b):
    axis = pick(b, "EYX", "EXY")
    b.straight_edge(axis[2].lower(), axis[1].lower())
    return dict(axis=axis, size="bow_um", fourth=float(b.rng.uniform(-0.3, 0.3)), limits=(2, 80))


def angular(b):
    axis, along, other = [("EBX", "x", "z"), ("EAY", "y", "z"), ("ECY", "y", "x")][int(b.rng.integers(3))]
    b.abbe(along, other)
    return dict(axis=axis, size="slope_urad", limits=(10, 500))


def gantry_sag(b):
    camp, half = b.plate(0.0)
    b.plate(90.0, camp=None if b.rng.uniform() < 0.5 else camp, half=half)
    return dict(axis="", size="sag_um", fourth=float(b.rng.uniform(-0.3, 0.3)), limits=(3, 200))


def axis_twist(b):
    b.plate(0.0, offsets=((0.0, 0.0, 0.0), (0.0, pick_offset(b), 0.0)))
    return dict(axis="", size="twist_mrad", limits=(0.02, 4))


def pick_offset(b):
    return float(b.rng.choice([-50., -40., 40., 60.]))


def bed(b, name):
    camp, half = b.plate(0.0)
    b.plate(90.0, camp=None if b.rng.uniform() < 0.5 else camp, half=half)
    axis = pick(b, "x", "y") if name == "bed_cylinder" else ""
    return dict(axis=axis, size="height_um", fourth=float(b.rng.uniform(-0.3, 0.3)), limits=(3, 300))


def trigger_latency(b):
    feeds = tuple(sorted(b.rng.choice([0.5, 1.0, 2.0, 3.0, 5.0, 8.0], 3, replace=False)))
    faces = [f for f in ("x+", "x-", "y+", "y-", "z+") if b.rng.uniform() < 0.7] or ["z+"]
    b.posts(tuple(faces), rounds=int(b.rng.integers(6, 12)), feeds=feeds, pause=8.0)
    return dict(axis="", size="latency_ms", limits=(0.2, 20), needs={"feed"}, positive=True)


def probe_lobing(b):
    b.ring((0.0, float(b.rng.choice([60., 90., 180.]))), int(b.rng.choice([18, 24, 36])), int(b.rng.integers(1, 3)))
    return dict(axis="", size="amplitude_um", phase_deg=float(b.rng.uniform(-180, 180)), limits=(1, 40), needs={"spin"}, positive=True)


def stylus_anisotropy(b):
    b.ring((0.0, float(b.rng.choice([45., 90.]))), int(b.rng.choice([18, 24, 36])), int(b.rng.integers(1, 3)))
    return dict(axis="", size="amplitude_um", phase_deg=float(b.rng.uniform(-180, 180)), limits=(1, 40), needs={"spin"}, positive=True)


def tip_runout(b):
    if b.rng.uniform() < 0.5:
        b.ring((0.0, 90.0, 180.0, 270.0), 16)
    else:
        b.posts(("x+", "x-", "y+", "y-"), rounds=8, spins=(0.0, 90.0, 180.0, 270.0), pause=8.0)
    return dict(axis="", size="offset_um", phase_deg=float(b.rng.uniform(-180, 180)), limits=(2, 80), needs={"spin"}, positive=True)


def servo_mismatch(b):
    b.ballbar((float(b.rng.choice([10., 20.])), float(b.rng.choice([40., 60.]))))
    return dict(axis="", size="mismatch_ms", limits=(0.02, 3), needs={"feed", "dir"})


def servo_lag(b):
    b.ballbar((float(b.rng.choice([10., 20.])), float(b.rng.choice([50., 80.]))))
    return dict(axis="", size="lag_um_at_50_mm_s", limits=(0.5, 60), needs={"feed", "dir"}, positive=True)


def block_size(b):
    axis = pick(b, "x", "y")
    names = b.blocks(axis, (25.0, 50.0, 76.2) if b.rng.uniform() < 0.5 else (20.0, 40.0, 60.0, 80.0))
    b.iso230(axis)
    return dict(axis=str(b.rng.choice(names)), size="error_um", limits=(4, 150), needs={"header", "feature"})


LASER = dict(kind="laser", sigma=(0.3, 1.0), res=[0.01, 0.1])
CAUSES = dict(cyclic_lead=cyclic_lead, pulley_eccentric=pulley_eccentric, microstep=microstep, pitch_progressive=pitch_progressive,
              thermal_screw=thermal_screw, frame_growth=frame_growth, probe_temperature=probe_temperature,
              frame_temperature=frame_temperature, backlash_worn=backlash_worn, windup_load=windup_load, reversal_spike=reversal_spike,
              missed_steps=missed_steps, homing_scatter=homing_scatter, squareness=squareness, straightness=straightness,
              angular=angular, gantry_sag=gantry_sag, axis_twist=axis_twist, bed_bowl=lambda b: bed(b, "bed_bowl"),
              bed_cylinder=lambda b: bed(b, "bed_cylinder"), bed_twist=lambda b: bed(b, "bed_twist"), trigger_latency=trigger_latency,
              probe_lobing=probe_lobing, stylus_anisotropy=stylus_anisotropy, tip_runout=tip_runout, servo_mismatch=servo_mismatch,
              servo_lag=servo_lag, block_size=block_size)
POSITIVE = {"amplitude_um", "offset_um", "sd_um", "latency_ms", "lag_um_at_50_mm_s", "expansion_um_per_m_k"}


def fillers(b):
    """One or two more campaigns that have nothing to do with the cause."""
    axis = pick(b, "x", "y", "z")
    more = [lambda: b.iso230(axis, 11, 2), lambda: b.posts(("x+", "x-", "y+", "z+"), rounds=5, pause=5.0, name="pin"),
            lambda: b.ring((0.0,), 16), lambda: b.plate(0.0, (5, 5), name="table"), lambda: b.ballbar((20.0,), 24),
            lambda: b.square("x", "y"), lambda: b.straight_edge("x", "y"), lambda: b.blocks("y", (25.0, 50.0))]
    for _ in range(int(b.rng.integers(0, 3))):
        more[int(b.rng.integers(len(more)))]()


def twin_candidates(machine, rows):
    """Every cause of the catalogue with a few shapes each: [(cause, axis, [[params, ...], ...])], a list of column groups."""
    out = []
    laps = float(rows.t[-1])
    waves = lambda p: [[dict(amplitude_um=1.0, phase_deg=a, period_mm=p) for a in (0.0, 90.0)]]
    for k, a in enumerate("xyz"):
        out.append(("pulley_eccentric" if machine.belt[k] else "cyclic_lead", a, waves(machine.turn_mm[k])))
        out.append(("microstep", a, waves(4 * machine.turn_mm[k] / machine.full)))
        out.append(("pitch_progressive", a, [[dict(bow_um=1.0)]]))
        span = machine.hi[k] - machine.lo[k]
        out.append(("backlash_worn", a, [[dict(extra_mm=1e-3, center_mm=machine.lo[k] + c * span, width_mm=w * span)]
                                         for c in (0.15, 0.3, 0.45, 0.6, 0.75, 0.9) for w in (0.2, 0.4)]))
        out.append(("reversal_spike", a, [[dict(height_um=1.0, decay_mm=d)] for d in (0.3, 0.8, 2.0)]))
        if np.isfinite(rows.load).any():
            out.append(("windup_load", a, [[dict(compliance_um_per_n=0.1)]]))
        if "temp" in rows.told:
            out.append(("thermal_screw", a, [[dict(expansion_um_per_m_k=5.0, lag_s=s)] for s in (0, 150, 400)]))
    if "t" in rows.told:
        out.append(("frame_growth", "", [[dict(growth_um=1.0, tau_s=s * laps)] for s in (0.1, 0.25, 0.5, 1.0)]))
    for a in ("C0Y", "B0Z", "A0Z"):
        out.append(("squareness", a, [[dict(angle_mrad=0.01)]]))
    bent = lambda key: [[{key: 1.0, "fourth": 0.0}], [{key: 1.0, "fourth": 0.0}, {key: 1.0, "fourth": 0.2}]]     # no bow is an exact parabola
    for a in ("EYX", "EXY", "EZY", "EXZ", "EYZ"):
        out.append(("straightness", a, bent("bow_um")))
    for a in ("EBX", "ECX", "EAY", "EBY", "ECY"):
        out.append(("angular", a, [[dict(slope_urad=20.0)]]))
    out += [("gantry_sag", "", bent("sag_um")), ("axis_twist", "", [[dict(twist_mrad=0.05)]])]
    if any("half" in a for a in rows.artefacts.values()):
        for name, axes in (("bed_bowl", [""]), ("bed_cylinder", ["x", "y"]), ("bed_twist", [""])):
            out += [(name, a, bent("height_um")) for a in axes]
    if rows.touch.any():
        if "temp" in rows.told:
            out.append(("probe_temperature", "", [[dict(drift_um_per_k=1.0, lag_s=s)] for s in (0, 150, 400)]))
            out += [("frame_temperature", a, [[dict(growth_um_per_k=1.0, lag_s=s)] for s in (0, 150, 400)]) for a in ("frame", "bed")]
        if len(set(rows.feed[rows.touch])) > 1:
            out.append(("trigger_latency", "", [[dict(latency_ms=1.0)]]))
        for name in ("probe_lobing", "stylus_anisotropy"):
            out.append((name, "", [[dict(amplitude_um=1.0, phase_deg=p) for p in (0.0, 90.0)]]))
        out.append(("tip_runout", "", [[dict(offset_um=1.0, phase_deg=p) for p in (0.0, 90.0)]]))
        for name in sorted({a.get("name") for a in rows.artefacts.values() if a.get("kind") == "block"}):
            out.append(("block_size", name, [[dict(error_um=1.0)]]))
    if rows.radial.any():
        out += [("servo_mismatch", "", [[dict(mismatch_ms=0.1)]]), ("servo_lag", "", [[dict(lag_um_at_50_mm_s=1.0)]])]
    return out
