"""What a plan can see: the effect with the baseline projected out, in sigmas of one reading; and which causes imitate it."""
import numpy as np


class Projector:
    """Projects columns out, each with an optional prior (standard uncertainty in its own unit)."""

    def __init__(self, columns, sigma, priors=None):
        self.sigma = sigma
        b = np.array(columns).T / sigma[:, None] if len(columns) else np.zeros((len(sigma), 0))
        self.rows = len(sigma)
        known = [] if priors is None else [(i, p) for i, p in enumerate(priors) if p]
        self.extra = len(known)
        if known:
            tail = np.zeros((len(known), b.shape[1]))
            for r, (i, p) in enumerate(known):
                tail[r, i] = 1.0 / p
            b = np.vstack([b, tail])
        norm = np.linalg.norm(b, axis=0)
        b = b[:, norm > 1e-12] / norm[norm > 1e-12]
        u, s, _ = np.linalg.svd(b, full_matrices=False)
        self.q = u[:, s > 1e-9 * (s[0] if len(s) else 1)]

    def __call__(self, effect):
        """Whitened, projected effect(s): (rows + priors,) or (rows + priors, k)."""
        e = np.asarray(effect, float)
        e = (e.T / self.sigma).T
        tail = np.zeros((self.extra,) + e.shape[1:])
        e = np.concatenate([e, tail])
        return e - self.q @ (self.q.T @ e)


def placement_columns(rows, table):
    """Offsets and rotations of each setup, a free place of each face without a drawing, per reading direction."""
    columns, priors = [], []
    sign = np.where(rows.touch, 1.0, -1.0)
    for setup in np.unique(rows.setup):
        mine = (rows.setup == setup) * 1.0
        here = rows.setup == setup
        for k in range(3):
            if np.abs(rows.n[here, k]).max() > 1e-3:
                columns.append(mine * rows.n[:, k])
        if rows.radial[here].any():
            columns.append(mine)
        art = rows.artefacts.get(int(setup), {})
        if rows.touch[here].any():
            c = rows.cmd[here].mean(0)
            lever = np.cross(rows.cmd - c, rows.n) * mine[:, None]
            columns += [lever[:, k] for k in range(3) if np.abs(lever[:, k]).max() > 1e-6]
            drawn = art.get("sizes") and "header" in rows.told and "feature" in rows.told
            faces = np.unique(rows.feature[here].astype(str))
            if art.get("kind") == "ring":
                columns.append(mine)
            elif not drawn or art.get("kind") in ("post", "datums", "square"):
                columns += [mine * (rows.feature == f) for f in faces]
            elif art.get("kind") == "block":
                columns.append(mine)
                priors_at = len(columns) - 1
                priors.append((priors_at, table.get("u_mm", 1e-3)))
    return columns, priors, sign


def gantry_baseline(machine, rows):
    columns, known, sign = placement_columns(rows, {})
    for k in range(3):
        if np.abs(rows.n[:, k]).max() > 1e-3:
            q = rows.cmd[:, k] - np.where(rows.touch, rows.off[:, k], 0.0)
            columns.append(sign * q * rows.n[:, k])
            columns.append(sign * rows.dir[:, k] * rows.n[:, k])
            columns.append(rows.touch * rows.n[:, k] ** 2)
    priors = [None] * len(columns)
    for i, p in known:
        priors[i] = p
    return columns, priors


def near_peak(projected, rows, sigma):
    """95th percentile of the visible effect over the rows of the campaigns that show it; and the sum of squares."""
    e = projected[: rows.N]
    energy = (e * e).sum()
    show = np.zeros(rows.N, bool)
    for camp in np.unique(rows.camp.astype(str)):
        mine = rows.camp == camp
        if (e[mine] ** 2).sum() >= 0.1 * energy:
            show |= mine
    return float(np.percentile(np.abs(e[show]), 95)), float(energy)


def event_columns(rows, axis, n_component):
    """Jumps at any row and scatter by homing, straight from the rows: the effect of one unit of motion along an axis."""
    out = []
    if "t" in rows.told and rows.N > 8:
        cuts = np.unique(np.linspace(2, rows.N - 2, 60).astype(int))
        groups = []
        for c in cuts:
            until = np.flatnonzero((np.arange(rows.N) >= c) & (rows.home != rows.home[c]))
            end = until[0] if len(until) else rows.N
            step = ((np.arange(rows.N) >= c) & (np.arange(rows.N) < end)) * 1.0
            groups.append([n_component * step])
        out.append(("missed_steps", axis, groups))
    homes = np.unique(rows.home)
    if len(homes) > 2:
        out.append(("homing_scatter", axis, [[n_component * (rows.home == h) for h in homes]]))
    return out


def twins(projector, effect, candidates, skip):
    """Causes that imitate the effect: what is left of it (sigma squared) after the best of their shapes is below 9."""
    f = projector(effect)
    total = (f * f).sum()
    found = []
    for cause, axis, groups in candidates:
        if (cause, axis) == skip:
            continue
        best = total
        for group in groups:
            raw = np.array(group).T
            if np.abs(raw).max() < 2e-5:              # mm: a second-order whiff of a cause that these rows do not move
                continue
            phi = projector(raw)
            norm = np.linalg.norm(phi, axis=0)
            keep = norm > 0.01 * np.linalg.norm(raw.T / projector.sigma, axis=1)      # the plan must see it at all
            if not keep.any():
                continue
            u, s, vt = np.linalg.svd(phi[:, keep] / norm[keep], full_matrices=False)
            good = s > 1e-4
            part = u[:, good].T @ f
            amplitude = (vt[good].T @ (part / s[good])) / norm[keep]
            if np.abs(raw[:, keep] @ amplitude).max() > 30 * np.abs(effect).max():    # no such monster imitates anything
                continue
            left = f - u[:, good] @ part
            best = min(best, (left * left).sum())
        if best < 9 and best < 0.5 * total:
            found.append({"cause": cause, "axis": axis, "lambda_sep": round(float(best), 2)})
    return found
