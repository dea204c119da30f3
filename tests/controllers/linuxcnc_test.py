#!/usr/bin/env python3
"""LinuxCNC homes and probes a gantry with errors that it cannot see, in lock-step.

    linuxcnc_test.py CALTWIN       77: LinuxCNC is not installed

What is expected stands in closed form. The ball (radius 1 mm) triggers with its pre-travel of
0.02 mm under contact; LinuxCNC reads its place in the servo cycle that sees it, so up to v T
late (60 mm/min, 1 ms: 1 um), and its home likewise (0.5 mm/s: 0.5 um).
"""

import concurrent.futures
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from processes import with_tmpdir

CALTWIN = sys.argv.pop(1)
ROOT = pathlib.Path(__file__).resolve().parents[2]
REPEATS = int(os.environ.get("CALTWIN_REPEATS", "2"))
TRIGGER_MM = 1.0 - 0.02
CYCLE_MM = 0.0015
HOME_Z_MM = 120
DOWN = ["-c", "G0 X100 Y100", "-c", "G0 Z5", "-c", "G38.2 Z-5 F60"]


class Base(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return str(pathlib.Path(self.folder.name) / name)

    def write(self, name, text):
        pathlib.Path(self.path(name)).write_text(text)
        return self.path(name)

    def drive(self, *words, code=0):
        out = self.path("out.json")
        run = subprocess.run(
            [CALTWIN, "linuxcnc", "gantry_router", *words, "--json", out],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        self.printed = run.stdout + run.stderr
        return json.loads(pathlib.Path(out).read_text())["steps"] if code < 2 else []

    def probed(self, *words):
        return [at for step in self.drive(*words) for at in step["probed_mm"]]

    def assert_z(self, at, wanted):
        self.assertLessEqual(at[2], wanted + CYCLE_MM)
        self.assertGreaterEqual(at[2], wanted - CYCLE_MM)


class Probing(Base):
    def test_a_machine_as_drawn_is_probed_where_it_triggers(self):
        (at,) = self.probed(*DOWN)
        self.assert_z(at, TRIGGER_MM)
        self.assertAlmostEqual(at[0], 100, places=6)

    def test_a_screw_that_moves_less_shows_the_table_too_low(self):
        truth = self.write("t.yaml", "effects:\n  steps_per_mm.z: {true_steps_per_mm: 800.32}\n")
        (at,) = self.probed("--truth", truth, *DOWN)
        self.assert_z(at, HOME_Z_MM - (HOME_Z_MM - TRIGGER_MM) * 800.32 / 800)

    def test_scale_in_the_ini_mends_it(self):
        truth = self.write("t.yaml", "effects:\n  steps_per_mm.z: {true_steps_per_mm: 800.32}\n")
        (at,) = self.probed("--truth", truth, "--set", "JOINT_2.SCALE=800.32", *DOWN)
        self.assert_z(at, TRIGGER_MM)

    def test_backlash_shows_and_BACKLASH_takes_it_away(self):
        truth = self.write("t.yaml", "effects:\n  backlash.z: {gap_mm: 0.1}\n")
        (bare,) = self.probed("--truth", truth, *DOWN)
        self.assert_z(bare, TRIGGER_MM - 0.1)
        (mended,) = self.probed("--truth", truth, "--set", "JOINT_2.BACKLASH=0.1", *DOWN)
        self.assert_z(mended, TRIGGER_MM)

    # A table that LinuxCNC's manual calls type 1: nominal, what to add going up, down.
    def test_a_comp_file_of_the_users_takes_a_scale_away(self):
        truth = self.write("t.yaml", "effects:\n  steps_per_mm.z: {true_steps_per_mm: 800.32}\n")
        made = subprocess.run(
            [CALTWIN, "new", "linuxcnc", "gantry_router", "--out", self.path("config")],
            capture_output=True, text=True, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)
        rows = []
        for nominal in (-5, 120):
            by = (nominal - HOME_Z_MM) * (800.32 / 800 - 1)
            rows.append(f"{nominal} {by:.6f} {by:.6f}\n")
        self.write("config/z.comp", "".join(rows))
        (at,) = self.probed(
            "--truth", truth, "--ini", self.path("config/machine.ini"),
            "--set", "JOINT_2.COMP_FILE=z.comp", "--set", "JOINT_2.COMP_FILE_TYPE=1", *DOWN)
        self.assert_z(at, TRIGGER_MM)

    def test_the_same_lines_give_the_same_coordinates_to_the_last_digit(self):
        truth = self.write("t.yaml", "effects:\n  steps_per_mm.z: {true_steps_per_mm: 800.32}\n")
        words = ["--truth", truth, *DOWN, "-c", "G0 Z5", "-c", "G38.2 Z-5 F120"]
        first = self.probed(*words)
        self.assertEqual(len(first), 2)
        for _ in range(REPEATS):
            self.assertEqual(self.probed(*words), first)
        spin = [subprocess.Popen([sys.executable, "-c", "while True: pass"])
                for _ in range(2 * os.cpu_count())]
        try:
            for _ in range(REPEATS):
                self.assertEqual(self.probed(*words), first, "on a busy computer")
        finally:
            for one in spin:
                one.kill()
                one.wait()

    def test_a_program_runs_to_its_end(self):
        job = self.write(
            "job.ngc",
            "G21 G90\nG0 X50 Y50\nG38.2 Z-5 F60\n(DEBUG, table at #5063)\nG0 Z5\nM2\n")
        steps = self.drive("--program", job)
        self.assertTrue(steps[-1]["done"])
        (said,) = [m for m in steps[-1]["messages"] if "table at" in m]
        self.assert_z([0, 0, float(said.split()[-1])], TRIGGER_MM)


    def test_what_a_program_and_a_subroutine_touch_is_told(self):
        self.write("touch.ngc", "o<touch> sub\nG0 Z5\nG38.2 Z-5 F#1\nG0 Z5\no<touch> endsub\nM2\n")
        job = self.write(
            "job.ngc", "G0 X50 Y50\no<touch> call [120]\nM0\no<touch> call [60]\nM2\n")
        steps = self.drive("--program", job)
        self.assertEqual(len(steps[-1]["probed_mm"]), 2)
        self.assertIn("the program paused, and went on by itself", steps[-1]["messages"])
        self.assert_z(steps[-1]["probed_mm"][1], TRIGGER_MM)

    def test_a_probing_move_is_known_however_it_is_written(self):
        steps = self.drive("-c", "G0 X100 Y100 Z5 (is G38.2 old)", "-c", "n10g91g38.2z-8f60",
                           "-c", "M2", "-c", "G90 G0 Z5")
        self.assertEqual([len(s["probed_mm"]) for s in steps], [0, 0, 1, 0, 0])

    def test_an_inch_machine_is_told_in_mm(self):
        made = subprocess.run(
            [CALTWIN, "new", "linuxcnc", "gantry_router", "--out", self.path("config")],
            capture_output=True, text=True, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)
        ini = pathlib.Path(self.path("config/machine.ini"))
        inches = ("MIN_LIMIT", "MAX_LIMIT", "MAX_VELOCITY", "MAX_ACCELERATION", "HOME", "HOME_OFFSET",
                  "HOME_SEARCH_VEL", "HOME_LATCH_VEL", "HOME_FINAL_VEL", "MAX_LINEAR_VELOCITY",
                  "MAX_LINEAR_ACCELERATION", "FERROR", "MIN_FERROR")
        lines = []
        for line in ini.read_text().replace("LINEAR_UNITS = mm", "LINEAR_UNITS = inch").splitlines():
            key, _, value = line.partition(" = ")
            if key in inches:
                line = f"{key} = {float(value) / 25.4:.9g}"
            elif key == "SCALE":
                line = f"SCALE = {float(value) * 25.4:.9g}"
            lines.append(line)
        ini.write_text("\n".join(lines) + "\n")
        (at,) = self.probed("--ini", str(ini), "-c", "G21 G0 X100 Y100 Z5", "-c", "G38.2 Z-5 F60")
        self.assert_z(at, TRIGGER_MM)
        self.assertAlmostEqual(at[0], 100, places=4)


class Refusals(Base):
    def refused(self, *words):
        steps = self.drive(*words, code=1)
        self.assertFalse(steps[-1]["done"])
        return " ".join(steps[-1]["errors"])

    def test_a_probe_that_meets_nothing(self):
        self.assertIn("without making contact", self.refused("-c", "G38.2 Z100 F600"))

    def test_a_table_that_a_rapid_move_meets(self):
        self.assertIn("during non-probe move", self.refused("-c", "G0 X100 Y100", "-c", "G0 Z0"))

    def test_a_place_beyond_the_travel(self):
        self.assertIn("would exceed", self.refused("-c", "G1 X1000 F100"))

    def test_a_line_that_is_no_gcode(self):
        self.refused("-c", "nonsense")

    def test_what_comes_after_a_refused_line_is_not_done(self):
        steps = self.drive("-c", "G38.2 Z100 F600", "-c", "G0 X10", code=1)
        self.assertEqual([s["line"] for s in steps], ["home", "G38.2 Z100 F600"])

    def test_an_ini_file_that_linuxcnc_does_not_take(self):
        self.drive("--set", "KINS.KINEMATICS=nokins", code=3)
        self.assertIn("nokins", self.printed)

    def test_settings_that_nobody_can_mean(self):
        for setting, said in (("BACKLASH=1", "a section, a key and a value"),
                              (".X=5", "a section, a key and a value"),
                              ("JOINT_O.BACKLASH=0.1", "did you mean 'JOINT_0'"),
                              ("JOINT_0.BAKLASH=0.1", "did you mean 'BACKLASH'")):
            self.drive("--set", setting, code=2)
            self.assertIn(said, self.printed)

    def test_what_linuxcnc_cannot_take_is_refused_before_it_is_started(self):
        self.drive("-c", "(" + "x" * 300 + ")", code=2)
        self.assertIn("302 bytes", self.printed)
        job = pathlib.Path(self.path("job.ngc"))
        job.write_bytes(b"(gr\xfcn)\nM2\n")
        self.drive("--program", str(job), code=2)
        self.drive("--ini", self.write("my.ini", "SCALE = 1\n"), code=2)
        self.assertIn("no section [EMC]", self.printed)

    def test_a_program_that_never_ends(self):
        job = self.write("job.ngc", "o1 while [1]\nG4 P1\no1 endwhile\nM2\n")
        self.drive("--program", job, "--longest", "30", code=3)
        self.assertIn("is not done after 30 s", self.printed)

    def test_the_language_of_the_user_changes_no_outcome(self):
        run = subprocess.run([CALTWIN, "run", ROOT / "scenarios/linuxcnc/no_contact.yaml"],
                             capture_output=True, text=True, check=False, timeout=120,
                             env={**os.environ, "LANGUAGE": "de", "LC_ALL": "C.UTF-8"})
        self.assertEqual(run.returncode, 0, run.stdout)


class Scenarios(unittest.TestCase):
    def test_each_meets_what_it_expects(self):
        files = sorted(pathlib.Path(ROOT, "scenarios/linuxcnc").glob("*.yaml"))
        self.assertGreater(len(files), 20)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            runs = pool.map(
                lambda file: subprocess.run([CALTWIN, "run", file], capture_output=True, text=True,
                                            timeout=120, check=False), files)
        for file, run in zip(files, runs):
            with self.subTest(file.stem):
                self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


class NothingIsLeft(Base):
    def processes(self):
        return with_tmpdir(self.folder.name)

    def begun(self):
        run = subprocess.Popen(
            [CALTWIN, "linuxcnc", "gantry_router", "-c", "G4 P7000"],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "TMPDIR": self.folder.name})
        self.addCleanup(run.stdout.close)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        self.assertEqual(run.stdout.readline(), "> home\n")
        self.assertIn("milltask", self.processes().values())
        return run

    def gone(self):
        until = time.monotonic() + 10
        while self.processes() and time.monotonic() < until:
            time.sleep(0.1)
        self.assertEqual(self.processes(), {})

    def test_after_a_kill(self):
        run = self.begun()
        run.kill()
        run.wait()
        self.gone()

    def test_after_ctrl_c(self):
        run = self.begun()
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(20), 130)
        self.gone()

    def test_after_linuxcnc_was_killed(self):
        run = self.begun()
        (task,) = [pid for pid, name in self.processes().items() if name == "milltask"]
        os.kill(task, signal.SIGKILL)
        self.assertEqual(run.wait(10), 3)
        self.assertIn("milltask has ended", run.stdout.read())
        self.gone()


if __name__ == "__main__":
    if not pathlib.Path("/usr/bin/linuxcnc").exists():
        print("LinuxCNC is not installed: tools/setup.sh --controllers")
        sys.exit(77)
    if subprocess.run(["unshare", "--user", "--mount", "true"], check=False).returncode != 0:
        print("this system allows no user namespaces")
        sys.exit(77)
    unittest.main(verbosity=2)
