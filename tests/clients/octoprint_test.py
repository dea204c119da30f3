"""OctoPrint, as it ships and headless, on a delta in the machine's own time: it connects, is
patient with a long silent command because it hears busy, prints a job to its end, and its
serial log holds no fault.

    octoprint_test.py CALTWIN OCTOPRINT
"""

import contextlib
import http.client
import json
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request

from served import Served, wait_for

CONFIG = """
accessControl: {{salt: caltwin}}
api: {{key: {key}}}
server: {{firstRun: false, onlineCheck: {{enabled: false}}, pluginBlacklist: {{enabled: false}}}}
plugins:
  _disabled: [softwareupdate, tracking, announcements, pluginmanager, backup, discovery, gcodeviewer]
serial:
  additionalPorts: [{port}]
  log: true
  port: {port}
  baudrate: 115200
  autoconnect: false
  timeout: {{communicationBusy: 3, communication: 5}}
"""
KEY = "0123456789ABCDEF0123456789ABCDEF"


class OctoPrint:
    def __init__(self, program, folder, terminal):
        self.folder = pathlib.Path(folder)
        (self.folder / "config.yaml").write_text(CONFIG.format(key=KEY, port=terminal))
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.out = (self.folder / "out").open("w")
        self.process = subprocess.Popen(
            [program, "serve", "--iknowwhatimdoing", "--host", "127.0.0.1", "--port",
             str(self.port), "--basedir", folder], stdout=self.out, stderr=subprocess.STDOUT)
        self.terminal = terminal

    def is_up(self):
        with contextlib.suppress(OSError, http.client.HTTPException):
            return self.ask("GET", "/api/version")
        return None

    def ask(self, method, path, body=None, kind="application/json"):
        data = json.dumps(body).encode() if isinstance(body, dict) else body
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", data, {
            "X-Api-Key": KEY, "Content-Type": kind}, method=method)
        with urllib.request.urlopen(request, timeout=20) as answer:
            text = answer.read()
        return json.loads(text) if text else {}

    def state(self):
        return self.ask("GET", "/api/connection")["current"]["state"]

    def log(self):
        return (self.folder / "logs" / "serial.log").read_text()

    def print(self, name, text):
        mark = "----caltwin"
        body = (f'--{mark}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\n'
                f'{text}\r\n--{mark}\r\nContent-Disposition: form-data; name="print"\r\n\r\n'
                f"true\r\n--{mark}--\r\n")
        self.ask("POST", "/api/files/local", body.encode(), f"multipart/form-data; boundary={mark}")

    def end(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(30)


def job():
    lines = ["G90", "G28", "G92 E0"]
    for k in range(100):
        lines.append(f"G1 X{(k % 2) * 20 - 10} Y{k / 10 - 10:.2f} Z20 E{k / 100:.3f} F6000")
    return "\n".join([*lines, "M400"]) + "\n"


def main(program, octoprint):
    with tempfile.TemporaryDirectory() as folder, Served(
            program, "--machine", "delta_printer", "--fidelity", "fast", "--speed", "2") as served:
        client = OctoPrint(octoprint, folder, served.terminal)
        try:
            wait_for("OctoPrint's server", client.is_up, 60)
            client.ask("POST", "/api/connection", {
                "command": "connect", "port": served.terminal, "baudrate": 115200})
            wait_for("Operational", lambda: client.state() == "Operational", 20)
            # Six seconds without an answer, by the clock.
            client.ask("POST", "/api/printer/command", {"commands": ["G28", "M503", "M114"]})
            wait_for("the place", lambda: re.search(r"Recv: X:0\.00 Y:0\.00 Z:", client.log()), 20)
            busy = client.log().count("busy: processing")
            assert busy >= 2, f"{busy} times busy in the six seconds of G28"
            client.print("job.gcode", job())
            wait_for("the print", lambda: client.state().startswith("Printing"), 20)
            wait_for("its end", lambda: client.state() == "Operational" and
                     "Recv: ok" in client.log().split("M400")[-1], 60)
        except BaseException:
            print((client.folder / "out").read_text()[-3000:])
            with contextlib.suppress(OSError, http.client.HTTPException):
                print(client.log()[-3000:])
            raise
        finally:
            client.end()
        said = client.log()
        for fault in ("Resend", "Error:", "Communication timeout", "Unknown command"):
            found = [line for line in said.splitlines() if fault.lower() in line.lower()]
            assert not found, f"{fault} in OctoPrint's serial log: {found[:5]}"
        print(f"connected, {busy} times busy while it homed, a job of 104 lines: done")


if __name__ == "__main__":
    main(*sys.argv[1:])
