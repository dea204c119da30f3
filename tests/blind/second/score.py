#!/usr/bin/env python3
"""Runs `caltwin diagnose` on cases of the second world and counts what it names. See README.md."""
import argparse
import concurrent.futures
import json
import math
import os
import subprocess
import sys
import tempfile

FREE_FORM = {"unknown", "pitch_map"}


def cases(folders):
    found = []
    for folder in folders:
        if os.path.exists(os.path.join(folder, "truth.json")):
            found.append(folder)
        else:
            found += sorted(os.path.join(folder, d) for d in os.listdir(folder) if os.path.exists(os.path.join(folder, d, "truth.json")))
    return found


def diagnose(folder, program, limit_s):
    handle, out = tempfile.mkstemp(suffix=".json")
    os.close(handle)
    os.remove(out)
    command = [program, "diagnose", os.path.join(folder, "DATA.csv"), "--machine", os.path.join(folder, "machine.yaml"), "--json", out]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s, check=False)
        answer = None
        if os.path.exists(out):
            with open(out, encoding="utf-8") as f:
                answer = json.load(f)
        return done.returncode, answer, (done.stderr or done.stdout).strip()
    except subprocess.TimeoutExpired:
        return -1, None, f"over {limit_s} s"
    finally:
        if os.path.exists(out):
            os.remove(out)


def same(truth, finding):
    """Cause and axis; a cause that has no axis may be reported on any."""
    return finding["cause"] == truth["cause"] and (not truth["axis"] or finding.get("axis", "") == truth["axis"])


def shared_words(truth, finding):
    """Is a free-form finding in a variable of the true cause?"""
    words = set(finding.get("covariates") or [])
    axis = truth["axis"]
    axes = {axis} if axis in ("x", "y", "z") else {axis[-1].lower()} if len(axis) == 3 and axis[0] in "EABC" else set("xyz")
    by_cause = {"trigger_latency": {"feed"}, "windup_load": {"load"}, "frame_growth": {"t", "temp"}, "thermal_screw": {"t", "temp"},
                "probe_temperature": {"t", "temp"}, "frame_temperature": {"t", "temp"}, "missed_steps": {"t"},
                "probe_lobing": {"theta", "x", "y"}, "stylus_anisotropy": {"theta", "x", "y"}, "tip_runout": {"theta", "x", "y"},
                "servo_mismatch": {"theta", "x", "y", "feed"}, "servo_lag": {"feed", "theta"}, "reversal_spike": {"since_rev"}}
    motors = {"a": "motor_a", "b": "motor_b", "c": "motor_c", "z1": "motor_a", "z2": "motor_b", "z3": "motor_c"}
    axes |= {motors[axis]} if axis in motors else set()
    if finding["cause"] == "pitch_map":
        return finding.get("axis") in axes
    return bool(words & (by_cause.get(truth["cause"], set()) | axes))


def judge(truth, code, answer, message):
    """(class, what was said). Classes: see README.md."""
    if code != 0 or answer is None:
        lines = message.splitlines()
        return ("refused" if code == 2 else "lost"), (lines[0] if lines else f"exit code {code}")
    findings = answer.get("findings") or []
    said = f"{answer.get('verdict')}: " + ("; ".join(f"{f['cause']} {f.get('axis', '')} {f.get('probability', 0) or 0:.3f}" + (
        " {" + ",".join(f.get("covariates") or []) + "}" if f["cause"] == "unknown" else "") for f in findings) or "nothing")
    others = [c for f in findings for c in (f.get("candidates") or [])[1:]]
    if others:
        said += " | rivals: " + ", ".join(sorted({f"{c['cause']} {c.get('axis', '')}".strip() for c in others}))
    if truth["cause"] is None:
        return ("alarm" if findings else "quiet"), said
    if not findings:
        return "missed", said
    right = [f for f in findings if same(truth, f)]
    in_set = [f for f in findings if any(same(truth, c) for c in (f.get("candidates") or [])) or same(truth, f)]
    extra = len(findings) > 1
    if truth["twins"]:
        if in_set:
            return ("right" if not extra else "right+extra"), said
    elif right:
        return ("right" if not extra else "right+extra"), said
    if in_set:
        return "in set", said
    free = [f for f in findings if f["cause"] in FREE_FORM]
    if free and len(free) == len(findings):
        return ("unknown" if any(shared_words(truth, f) for f in free) else "unknown elsewhere"), said
    return "wrong", said


def covered(truth, answer):
    """[(name, truth, value, sd, inside)] of the parameters of a finding with the right name."""
    out = []
    for f in answer.get("findings") or []:
        if not same(truth, f):
            continue
        for p in f.get("parameters") or []:
            name, sd = p.get("name"), p.get("sd")
            if name not in truth["parameters"] or sd is None or p.get("value") is None:
                continue
            d = p["value"] - truth["parameters"][name]
            if name == "phase_deg":
                d = (d + 180) % 360 - 180
            out.append((name, truth["parameters"][name], truth["parameters"][name] + d, sd, abs(d) <= 1.96 * sd))
        break
    return out


def share(k, n):
    if not n:
        return "-"
    p, half = k / n, 1.96 * math.sqrt(max(k * (n - k), 0.25 * n) / n ** 3)
    return f"{k}/{n} = {100 * p:.1f} % +- {100 * half:.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--caltwin", default="build/caltwin")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json")
    parser.add_argument("--limit-s", type=float, default=120)
    parser.add_argument("--max-alarms", type=float, help="share of null data with a finding, 0..1")
    parser.add_argument("--min-named", type=float, help="share of planted causes named right, 0..1")
    parser.add_argument("--max-refused", type=float, help="share of cases refused or lost, 0..1")
    args = parser.parse_args()
    if not os.path.exists(args.caltwin):
        parser.error(f"{args.caltwin}: no such program")
    folders = cases(args.folders)
    if not folders:
        parser.error("no case in " + " ".join(args.folders))

    def one(folder):
        with open(os.path.join(folder, "truth.json"), encoding="utf-8") as f:
            truth = json.load(f)
        code, answer, message = diagnose(folder, args.caltwin, args.limit_s)
        verdict, said = judge(truth, code, answer, message)
        return dict(case=folder, truth=truth, verdict=verdict, said=said, covered=covered(truth, answer) if answer and truth["cause"] else [])

    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        results = list(pool.map(one, folders))
    tables, worse = {}, False
    for kind in sorted({r["truth"]["kind"] for r in results}):
        mine = [r for r in results if r["truth"]["kind"] == kind]
        nulls, planted = [r for r in mine if r["truth"]["cause"] is None], [r for r in mine if r["truth"]["cause"]]
        count = lambda rows, *classes: sum(r["verdict"] in classes for r in rows)
        lone, twin = [r for r in planted if not r["truth"]["twins"]], [r for r in planted if r["truth"]["twins"]]
        heard = [r for r in planted if r["verdict"] not in ("refused", "lost")]
        intervals = [c for r in planted if r["verdict"].startswith("right") for c in r["covered"]]
        t = tables[kind] = dict(cases=len(mine), refused=count(mine, "refused", "lost"), nulls=len(nulls), alarms=count(nulls, "alarm"),
                                nulls_heard=count(nulls, "alarm", "quiet"),
                                uneasy=sum(r["verdict"] == "quiet" and not r["said"].startswith("none") for r in nulls),
                                planted=len(planted), heard=len(heard), lone=len(lone), lone_right=count(lone, "right"), with_twins=len(twin),
                                twins_right=count(twin, "right"), right=count(planted, "right"), extra=count(planted, "right+extra"),
                                in_set=count(planted, "in set"), unknown=count(planted, "unknown"), wrong=count(planted, "wrong", "unknown elsewhere"),
                                missed=count(planted, "missed"), intervals=len(intervals), inside=sum(c[4] for c in intervals))
        print(f"{kind}: {t['cases']} cases")
        for label, text in (("refused or lost", share(t["refused"], t["cases"])), ("nulls alarmed", share(t["alarms"], t["nulls_heard"])),
                            ("  quiet, but verdict unknown", share(t["uneasy"], t["nulls_heard"])),
                            ("named right", share(t["right"], t["heard"])), ("  without twins", share(t["lone_right"], t["lone"])),
                            ("  with twins: truth in the set", share(t["twins_right"], t["with_twins"])),
                            ("right, and a second name", share(t["extra"], t["heard"])),
                            ("only among the rivals", share(t["in_set"], t["heard"])),
                            ("unknown, right variable", share(t["unknown"], t["heard"])), ("wrong name", share(t["wrong"], t["heard"])),
                            ("missed", share(t["missed"], t["heard"])), ("95 % intervals hold the truth", share(t["inside"], t["intervals"]))):
            print(f"  {label:34s} {text}")
        by_cause = {}
        for r in planted:
            cell = by_cause.setdefault(r["truth"]["cause"], {})
            cell[r["verdict"]] = cell.get(r["verdict"], 0) + 1
        t["by_cause"] = {c: dict(sorted(by_cause[c].items())) for c in sorted(by_cause)}
        for c, cell in t["by_cause"].items():
            print(f"    {c:32s} " + ", ".join(f"{n} {v}" for v, n in cell.items()))
        worse |= args.max_alarms is not None and t["alarms"] > args.max_alarms * t["nulls_heard"]
        worse |= args.min_named is not None and t["right"] < args.min_named * t["planted"]
        worse |= args.max_refused is not None and t["refused"] > args.max_refused * t["cases"]
    print()
    for r in results:
        outside = [c for c in r["covered"] if not c[4] and abs(c[2] - c[1]) > 4 * c[3]]
        if r["verdict"] not in ("right", "quiet"):
            t = r["truth"]
            planted = "nothing"
            if t["cause"]:
                sizes = " ".join(f"{k}={v:.4g}" for k, v in t["parameters"].items())
                twins = ", ".join(f"{w['cause']} {w['axis']}".strip() for w in t["twins"])
                planted = f"{t['cause']} {t['axis']} {t['sigma']:.1f} sigma {sizes}" + (f"; twins {twins}" if twins else "")
            print(f"{r['case']}: {r['verdict'].upper()}\n    planted: {planted} (plan {t['plan']}, {t['rows']} rows)\n    said:    {r['said']}")
        elif outside:
            print(f"{r['case']}: beyond 4 sd: {r['truth']['cause']} " + "; ".join(f"{n} true {a:.5g}, said {v:.5g} +- {s:.2g}" for n, a, v, s, _ in outside))
    if args.json:
        with open(args.json + ".part", "w", encoding="utf-8") as f:
            json.dump({"format": 1, "tables": tables, "cases": results}, f, indent=1)
        os.replace(args.json + ".part", args.json)
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
