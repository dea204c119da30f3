"""caltwin as a Klipper microcontroller, and the real host of the Klipper family in front of it.

A `Rig` starts both in a folder of its own and ends both whatever happens; `say` sends G-code as a
web page does, over the host's API socket, and returns what the host printed.
"""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# What is absent: ctest's SKIP_RETURN_CODE.
SKIPPED = 77
# The host asks git for its version: killed in the middle it leaves no lock in the project.
os.environ.setdefault("GIT_OPTIONAL_LOCKS", "0")


class HostError(Exception):
    """The host refused a line, or stopped."""


class Api:
    """The host's API socket: JSON objects, each ended by the byte 3."""

    def __init__(self, path, patience_s):
        self.socket = socket.socket(socket.AF_UNIX)
        self.buffer, self.printed, self.next_id = b"", [], 1
        until = time.monotonic() + patience_s
        while True:
            try:
                self.socket.connect(str(path))
                return
            except OSError:
                if time.monotonic() > until:
                    raise HostError(f"nobody listens at {path}") from None
                time.sleep(0.1)

    def close(self):
        self.socket.close()

    def receive(self, until):
        """The next object; a TimeoutError where none comes before `until`."""
        while b"\x03" not in self.buffer:
            self.socket.settimeout(max(0.01, until - time.monotonic()))
            got = self.socket.recv(65536)
            if not got:
                raise HostError("the host closed its socket")
            self.buffer += got
        one, self.buffer = self.buffer.split(b"\x03", 1)
        return json.loads(one)

    def ask(self, method, params, patience_s):
        number, self.next_id = self.next_id, self.next_id + 1
        text = json.dumps({"id": number, "method": method, "params": params})
        self.socket.sendall(text.encode() + b"\x03")
        until = time.monotonic() + patience_s
        while True:
            answer = self.receive(until)
            if "response" in answer.get("params", {}):
                self.printed.append(answer["params"]["response"])
            if answer.get("id") != number:
                continue
            if "error" in answer:
                raise HostError(answer["error"]["message"])
            return answer["result"]


class Rig:
    def __init__(self, caltwin, host, folder, machine, truth=None, options=()):
        self.folder, self.children, self.api = Path(folder), [], None
        self.host = host
        # The host takes what begins so as it is, without the settings of a serial port.
        self.serial = Path(f"/tmp/klipper_host_caltwin_test_{os.getpid()}")
        self.config = self.folder / "printer.cfg"
        subprocess.run(
            [caltwin, "new", "klipper", machine, "--out", self.config, "--serial", self.serial],
            check=True, stdout=subprocess.DEVNULL)
        with open(self.config, "a", encoding="utf-8") as config:
            # On a busy computer the host itself may be kept waiting: real ones are given 0.25 s.
            config.write("\n[danger_options]\nsingle_mcu_trsync_timeout: 2\n")
        self.words = [caltwin, "serve", "--machine", machine, "--klipper", self.serial, *options]
        if truth is not None:
            file = self.folder / "truth.yaml"
            file.write_text(truth)
            self.words += ["--truth", file]
        self.start_twin()

    def start_twin(self):
        if self.serial.is_symlink():
            self.serial.unlink()
        self.twin = self.start(self.words, "twin.log")
        self.wait_for(self.serial.is_symlink, 20, "caltwin makes no terminal")

    def start(self, words, log):
        with open(self.folder / log, "w", encoding="utf-8") as out:
            child = subprocess.Popen([str(word) for word in words], stdout=out,
                                     stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        self.children.append(child)
        return child

    def wait_for(self, condition, patience_s, complaint):
        until = time.monotonic() + patience_s
        while not condition():
            if time.monotonic() > until:
                raise HostError(complaint + "\n" + self.logs())
            time.sleep(0.05)

    def start_host(self):
        return self.start(
            [self.host, self.config, "-l", self.folder / "klippy.log", "-a", self.folder / "api",
             "-I", self.folder / "tty"], "host.log")

    def connect(self, patience_s=60):
        """Waits until the host says that it is ready."""
        until = time.monotonic() + patience_s
        while True:
            if self.api:
                self.api.close()
            try:
                self.api = Api(self.folder / "api", max(1, until - time.monotonic()))
                info = self.api.ask("info", {}, 10)
                if info["state"] == "ready":
                    self.api.ask("gcode/subscribe_output", {"response_template": {}}, 10)
                    return
                if info["state"] in ("error", "shutdown"):
                    raise HostError(info["state_message"] + self.logs())
            except (TimeoutError, ConnectionError):
                pass
            if time.monotonic() > until:
                raise HostError("the host does not become ready" + self.logs())
            time.sleep(0.2)

    def say(self, line, patience_s=60):
        self.api.printed = []
        try:
            self.api.ask("gcode/script", {"script": line}, patience_s)
        except HostError as error:
            raise HostError(f"{line}: {error}{self.logs()}") from None
        # What it printed may come behind its answer.
        self.api.ask("info", {}, 10)
        return self.api.printed

    def save_config(self):
        """SAVE_CONFIG, behind which the host starts anew."""
        try:
            self.api.ask("gcode/script", {"script": "SAVE_CONFIG"}, 10)
        except (HostError, ConnectionError):
            pass  # It closes its socket as it goes.
        self.wait_for(lambda: self.saved(), 10, "nothing was saved")
        self.connect()

    def touch(self, x_mm, y_mm, clear_mm):
        """The height at which the bed is touched there, as the host believes."""
        self.say(f"G1 Z{clear_mm} F1200")
        self.say(f"G1 X{x_mm} Y{y_mm} F6000")
        text = " ".join(self.say("PROBE"))
        self.say(f"G1 Z{clear_mm} F1200")
        return float(re.search(r"is z=(-?[\d.e-]+)", text).group(1))

    def status(self, name):
        return self.api.ask("objects/query", {"objects": {name: None}}, 10)["status"][name]

    def saved(self):
        """{(section, option): text} of what SAVE_CONFIG wrote."""
        values, section = {}, None
        for line in self.config.read_text().splitlines():
            if not line.startswith("#*#"):
                continue
            line = line[3:].strip()
            if line.startswith("["):
                section = line.strip("[]")
            elif "=" in line and section:
                option, text = line.split("=", 1)
                values[section, option.strip()] = text.strip()
        return values

    def logs(self):
        text = ""
        for name in ("twin.log", "host.log", "klippy.log"):
            file = self.folder / name
            if file.exists():
                text += f"\n--- {name}\n" + file.read_text(errors="replace")[-3000:]
        return text

    def close(self):
        if self.api:
            self.api.close()
        for child in reversed(self.children):
            if child.poll() is None:
                child.send_signal(signal.SIGINT if child is self.twin else signal.SIGTERM)
        for child in self.children:
            try:
                child.wait(10)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
        if self.serial.is_symlink():
            self.serial.unlink()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def main(usage, run):
    """CALTWIN HOST fast|physics: runs `run(caltwin, host, fidelity, folder)`, which returns faults."""
    if len(sys.argv) != 4:
        print(usage)
        return 2
    host = shutil.which(sys.argv[2])
    if host is None:
        print(f"skipped: {sys.argv[2]} is not installed: tools/setup.sh --controllers")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        try:
            faults = run(sys.argv[1], host, sys.argv[3], Path(folder))
        except HostError as error:
            faults = [str(error)]
    print("\n".join(faults))
    return 1 if faults else 0
