#!/usr/bin/env python3
"""A LinuxCNC of its own, in real time, on a machine that `caltwin serve --linuxcnc` has.

    linuxcnc_serve_test.py CALTWIN       77: LinuxCNC is not installed

What a user types, but for the namespaces, so that no LinuxCNC that is in use is touched, and
for whoever sits at it: component/caltwin_operator.py.
"""

import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

CALTWIN = str(pathlib.Path(sys.argv.pop(1)).resolve())
ROOT = pathlib.Path(__file__).parent.parent.parent
OPERATOR = ROOT / "sim/controllers/linuxcnc/component/caltwin_operator.py"
SANDBOX = ["unshare", "--user", "--map-user=1000", "--map-group=1000", "--keep-caps", "--ipc",
           "--net", "--pid", "--mount", "--mount-proc", "--fork", "--kill-child"]
START = """
set -e
mount --bind "$1" /tmp && cd /tmp && mkdir shipped modules home && export HOME=/tmp/home
mount --bind /usr/lib/linuxcnc/modules shipped && ln -s /tmp/shipped/* modules
cp caltwin.so modules && mount --bind modules /usr/lib/linuxcnc/modules
linuxcnc -r machine.ini </dev/null
"""


class Serving(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.page = f"caltwin_test_{os.getpid()}"
        self.addCleanup(lambda: pathlib.Path("/dev/shm", self.page).unlink(missing_ok=True))
        made = subprocess.run(
            [CALTWIN, "new", "linuxcnc", "gantry_router", "--out", self.folder, "--page", self.page],
            capture_output=True, text=True, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)
        subprocess.run(["halcompile", "--compile", "caltwin.comp"], cwd=self.folder, check=True,
                       capture_output=True)
        shutil.copy(OPERATOR, self.folder)
        ini = pathlib.Path(self.folder, "machine.ini")
        ini.write_text(re.sub(r"(?m)^DISPLAY = .*", "DISPLAY = /tmp/caltwin_operator.py",
                              ini.read_text()))

    def serve(self):
        twin = subprocess.Popen(
            [CALTWIN, "serve", "--machine", "gantry_router", "--fidelity", "fast", "--linuxcnc",
             self.page],
            stdout=subprocess.PIPE, text=True)
        self.addCleanup(twin.stdout.close)
        self.addCleanup(twin.wait)
        self.addCleanup(twin.kill)
        self.assertIn(f"page={self.page}", twin.stdout.readline())
        return twin

    def begin(self):
        ours, theirs = socket.socketpair()
        os.set_inheritable(theirs.fileno(), True)
        self.log = pathlib.Path(self.folder, "log.txt")
        with self.log.open("w") as log:
            linuxcnc = subprocess.Popen(
                [*SANDBOX, "bash", "-c", START, "bash", self.folder],
                env={**os.environ, "CALTWIN_OPERATOR": str(theirs.fileno())},
                pass_fds=[theirs.fileno()], stdout=log, stderr=log)
        theirs.close()
        self.addCleanup(ours.close)
        self.addCleanup(linuxcnc.wait)
        self.addCleanup(linuxcnc.kill)
        ours.settimeout(120)
        self.line = ours.makefile("rw")
        self.addCleanup(self.line.close)
        return linuxcnc

    def hear(self):
        text = self.line.readline()
        self.assertTrue(text, self.log.read_text())
        return json.loads(text)

    def order(self, **what):
        self.line.write(json.dumps(what) + "\n")
        self.line.flush()
        return self.hear()

    def test_homes_and_probes_in_real_time(self):
        self.serve()
        self.begin()
        self.assertTrue(self.hear()["done"])
        start = time.monotonic()
        self.assertTrue(self.order(do="home")["done"])
        self.assertGreater(time.monotonic() - start, 3)
        self.order(do="mdi", line="G0 X100 Y100")
        self.order(do="mdi", line="G0 Z5")
        at = self.order(do="mdi", line="G38.2 Z-5 F60")["probed"][0]
        self.assertAlmostEqual(at[2], 0.98, delta=0.0015)
        self.line.write('{"do": "end"}\n')
        self.line.flush()

    def test_without_the_machine_linuxcnc_says_what_to_start(self):
        linuxcnc = self.begin()
        self.assertNotEqual(linuxcnc.wait(30), 0)
        self.assertIn("start caltwin serve --linuxcnc first", self.log.read_text())

    def test_a_killed_twin_stops_the_machine_and_the_next_one_goes_on(self):
        twin = self.serve()
        self.begin()
        self.hear()
        self.assertTrue(self.order(do="home")["done"])
        self.line.write(json.dumps({"do": "mdi", "line": "G1 X50 F60"}) + "\n")
        self.line.flush()
        time.sleep(1)
        twin.send_signal(signal.SIGKILL)
        twin.wait()
        start = time.monotonic()
        self.assertFalse(self.hear()["done"])
        self.assertLess(time.monotonic() - start, 10)
        self.assertIn("does not answer", self.log.read_text())
        self.serve()
        self.assertTrue(self.order(do="on")["done"])
        self.assertTrue(self.order(do="home")["done"])

    def test_a_page_is_gone_with_its_twin(self):
        twin = self.serve()
        self.assertTrue(pathlib.Path("/dev/shm", self.page).exists())
        twin.send_signal(signal.SIGINT)
        self.assertEqual(twin.wait(10), 130)
        self.assertFalse(pathlib.Path("/dev/shm", self.page).exists())


if __name__ == "__main__":
    if not pathlib.Path("/usr/bin/linuxcnc").exists():
        print("LinuxCNC is not installed: tools/setup.sh --controllers")
        sys.exit(77)
    if subprocess.run(["unshare", "--user", "--mount", "true"], check=False).returncode != 0:
        print("this system allows no user namespaces")
        sys.exit(77)
    unittest.main(verbosity=2)
