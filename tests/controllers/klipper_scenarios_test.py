"""Klipper's own host in lock-step: klipper_scenarios_test.py CALTWIN HOST

Every scenario of scenarios/klipper meets what it expects; the same run gives the same result to the last digit, on
an idle computer and on a busy one; whoever is killed, nothing of the other is left. Ends with 77 where there is no host.
"""

import contextlib
import csv
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SKIPPED = 77
REPEATS = int(os.environ.get("CALTWIN_REPEATS", "3"))
ROOT = Path(__file__).resolve().parents[2]
faults = []


def claim(holds, what):
    print(("ok  " if holds else "NOT ") + what, flush=True)
    if not holds:
        faults.append(what)


def scenario(caltwin, file):
    done = subprocess.run([caltwin, "run", file], capture_output=True, text=True, timeout=200, check=False)
    return file.stem, done.returncode, done.stdout + done.stderr


def run_all(caltwin):
    files = sorted((ROOT / "scenarios/klipper").glob("*.yaml"))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, code, said in pool.map(lambda file: scenario(caltwin, file), files):
            claim(code == 0, f"{name}: exit {code}")
            if code != 0:
                print(said)


def saved(caltwin, folder, words):
    """What a run printed and saved; its times are the computer's."""
    file = folder / "run.json"
    subprocess.run([caltwin, "klipper", *words, "--json", file], check=True, stdout=subprocess.DEVNULL, timeout=200)
    told = json.loads(file.read_text())
    return json.dumps([[step["line"], step["printed"]] for step in told["steps"]] + told["saved"])


def repeats(caltwin, folder):
    truth = folder / "truth.yaml"
    truth.write_text("effects: {endstop.a: {error_mm: 0.3}, delta_radius: {error_mm: 0.8}}\n")
    words = ["delta_printer", "--fidelity", "fast", "--truth", truth, "-c", "G28", "-c", "DELTA_CALIBRATE",
             "-c", "SAVE_CONFIG"]
    first = saved(caltwin, folder, words)
    claim("delta_radius" in first, "the calibration is saved")
    idle = [saved(caltwin, folder, words) for _ in range(REPEATS)]
    claim(all(one == first for one in idle), f"{REPEATS} runs give the same to the last digit")
    spin = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * os.cpu_count())]
    try:
        busy = [saved(caltwin, folder, words) for _ in range(REPEATS)]
    finally:
        for one in spin:
            one.kill()
            one.wait()
    claim(all(one == first for one in busy), f"{REPEATS} on a busy computer too")


def trials_in(study):
    try:
        with contextlib.closing(sqlite3.connect(f"file:{study}?mode=ro", uri=True)) as kept:
            return kept.execute("select count(*) from trials").fetchone()[0]
    except sqlite3.Error:
        return 0  # Not there yet, or just being written.


def results_of(study):
    """All that was found; not how long it took, which hangs on when the host's answer is heard."""
    with open(study / "trials.csv", encoding="utf-8", newline="") as rows:
        return [{**row, "machine_time_s": None} for row in csv.DictReader(rows)]


def killed_study(caltwin, folder):
    """A study by the shipped engine that was killed goes on, and ends as one that was not."""
    study = folder / "study.yaml"
    text = (ROOT / "scenarios/studies/delta_by_kalico.yaml").read_text()
    study.write_text(text.replace("trials: 200", "trials: 8").replace("..", str(ROOT / "scenarios")))
    whole = [caltwin, "study", study, "--out", folder / "whole"]
    subprocess.run(whole, check=True, stdout=subprocess.DEVNULL, timeout=200)
    parts = [caltwin, "study", study, "--out", folder / "parts", "--resume"]
    child = subprocess.Popen(parts, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + 100
    while not 0 < trials_in(folder / "parts/study.sqlite") < 8 and time.monotonic() < until:
        time.sleep(0.02)
    child.kill()
    child.wait()
    done = trials_in(folder / "parts/study.sqlite")
    claim(0 < done < 8, f"killed after {done} of 8 machines")
    subprocess.run(parts, check=True, stdout=subprocess.DEVNULL, timeout=200)
    claim(results_of(folder / "whole") == results_of(folder / "parts"),
          "a killed study of 8 machines goes on and ends as one that was not killed")


def hosts_of(caltwin_pid):
    """The hosts that it has started."""
    found = subprocess.run(["ps", "--ppid", str(caltwin_pid), "-o", "pid="], capture_output=True, text=True, check=False)
    return [int(pid) for pid in found.stdout.split()]


def long_run(caltwin):
    lines = [word for _ in range(300) for word in ("-c", "DELTA_CALIBRATE")]
    child = subprocess.Popen([caltwin, "klipper", "delta_printer", "--fidelity", "fast", "-c", "G28", *lines],
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 20
    while not hosts_of(child.pid) and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(1)
    return child, hosts_of(child.pid)


def is_gone(pid):
    until = time.monotonic() + 10
    while time.monotonic() < until:
        try:
            os.kill(pid, 0)
            stat = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except (ProcessLookupError, FileNotFoundError):
            return True
        if stat == "Z":
            return True
        time.sleep(0.1)
    return False


def killings(caltwin):
    child, hosts = long_run(caltwin)
    claim(len(hosts) == 1, "a host works")
    os.kill(child.pid, signal.SIGKILL)
    child.wait()
    claim(all(is_gone(host) for host in hosts), "after kill -9 of caltwin its host is gone within ten seconds")

    child, hosts = long_run(caltwin)
    os.kill(hosts[0], signal.SIGKILL)
    _, said = child.communicate(timeout=10)
    claim(child.returncode == 3 and "the host has ended" in said,
          f"after kill -9 of the host: exit {child.returncode}, {said.splitlines()[:1]}")

    child, hosts = long_run(caltwin)
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=10)
    claim(child.returncode == 130 and is_gone(hosts[0]), f"Ctrl-C: exit {child.returncode}, no host left")


def broken_plugin(caltwin, host, folder):
    """A firmware author's regression: a calibration that was broken on purpose turns a scenario red."""
    script = Path(host).read_text()
    packages = folder / "broken"
    packages.mkdir()
    source = next(Path(host).parents[1].glob("lib/python3*/site-packages/klippy"))
    shutil.copytree(source, packages / "klippy")
    tilt = packages / "klippy/extras/z_tilt.py"
    text = tilt.read_text()
    broken = text.replace("x_adjust = new_params", "x_adjust = -new_params", 1)
    claim(broken != text, "there is a place to break Z_TILT_ADJUST at")
    tilt.write_text(broken)
    start = folder / "kalico"
    start.write_text(script.split("\n")[0] + f"\nimport sys\nsys.path.insert(0, {str(packages)!r})\n"
                     "from klippy.printer import main\nsys.exit(main())\n")
    start.chmod(0o755)
    done = subprocess.run([caltwin, "run", ROOT / "scenarios/klipper/z_tilt_adjust.yaml"], capture_output=True, text=True,
                          timeout=100, check=False, env={**os.environ, "CALTWIN_KLIPPER_HOST": str(start)})
    claim(done.returncode == 1, f"the broken Z_TILT_ADJUST fails its scenario: exit {done.returncode}")
    if done.returncode != 1:
        print(done.stdout, done.stderr)


def main(caltwin, host):
    if not Path(host).exists():
        print(f"{host} is not there: tools/setup.sh --controllers installs it")
        return SKIPPED
    os.environ["CALTWIN_KLIPPER_HOST"] = host
    with tempfile.TemporaryDirectory() as name:
        run_all(caltwin)
        repeats(caltwin, Path(name))
        killed_study(caltwin, Path(name))
        killings(caltwin)
        broken_plugin(caltwin, host, Path(name))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
