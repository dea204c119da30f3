#!/usr/bin/python3
"""Whoever sits at LinuxCNC, for caltwin: the DISPLAY of an INI file.

Reads orders, a JSON object a line, from the descriptor that CALTWIN_OPERATOR names, and
answers each with one. Orders: {"do": "on"}, {"do": "home"}, {"do": "mdi", "line": "G38.2 Z-20 F60"},
{"do": "program", "file": "/tmp/job.ngc"}, {"do": "end"}. An answer:

    done      whether LinuxCNC did it to its end
    errors    what it printed as errors
    messages  what else it printed: (DEBUG, ...), (MSG, ...)
    probed    where the probe met something, machine coordinates; missing: no probing
    position  where LinuxCNC has the tool now

The first answer comes unasked: LinuxCNC is on.
"""

import contextlib
import io
import json
import os
import re
import sys
import time

import linuxcnc

GLANCE_s = 0.002
PROBING = re.compile(r"\bG\s*38\s*\.\s*[2-5]", re.IGNORECASE)


def task():
    """The process of LinuxCNC that obeys; it lives as long as its INI file is run."""
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError), open(f"/proc/{pid}/comm") as name:
            if name.read().strip() == "milltask":
                return pid
    sys.exit("caltwin_operator: LinuxCNC's milltask is not there")


class Operator:
    def __init__(self, line):
        self.task = task()
        self.line = line
        self.command, self.stat = linuxcnc.command(), linuxcnc.stat()
        self.channel = linuxcnc.error_channel()
        self.errors, self.messages = [], []

    def require_task(self):
        """Ends all where nobody obeys any more: no message would ever say so."""
        state = "X"
        with contextlib.suppress(OSError), open(f"/proc/{self.task}/stat") as said:
            state = said.read().rpartition(")")[2].split()[0]
        if state in "XZT":
            sys.exit("caltwin_operator: LinuxCNC's milltask has ended or was stopped")

    def hear(self):
        self.require_task()
        while said := self.channel.poll():
            kind, text = said
            is_error = kind in (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR)
            (self.errors if is_error else self.messages).append(text)

    def wait(self):
        """Until the last command is done; whether it was done without an error."""
        while (state := self.command.wait_complete(1)) == -1:
            self.hear()
        # An error may come a moment after the end that it made.
        self.stat.poll()
        self.hear()
        return state == linuxcnc.RCS_DONE and not self.errors

    def mode(self, mode):
        self.stat.poll()
        if self.stat.task_mode == mode:
            return True
        self.command.mode(mode)
        return self.wait()

    def switch_on(self):
        for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
            self.command.state(state)
            self.wait()
        self.stat.poll()
        return self.stat.task_state == linuxcnc.STATE_ON

    def is_homed(self):
        self.stat.poll()
        return all(self.stat.homed[: self.stat.joints])

    def home(self):
        self.mode(linuxcnc.MODE_MANUAL)
        self.command.teleop_enable(0)
        self.wait()
        self.command.home(-1)
        self.wait()
        while not self.is_homed():
            self.hear()
            self.stat.poll()
            is_off = self.stat.task_state != linuxcnc.STATE_ON
            if self.errors or is_off:
                return False
            time.sleep(GLANCE_s)
        return True

    def mdi(self, line):
        if not self.mode(linuxcnc.MODE_MDI):
            return False
        self.command.mdi(line)
        return self.wait()

    def program(self, file):
        if not self.mode(linuxcnc.MODE_AUTO):
            return False
        self.command.program_open(file)
        if not self.wait():
            return False
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self.wait()
        while True:
            self.stat.poll()
            self.hear()
            if self.errors:
                self.command.abort()
                self.command.wait_complete(1)
                return False
            if self.stat.interp_state == linuxcnc.INTERP_IDLE and self.stat.inpos:
                return True
            time.sleep(GLANCE_s)

    def obey(self, order):
        what = order["do"]
        if what == "on":
            return self.switch_on()
        if what == "home":
            return self.home()
        if what == "mdi":
            return self.mdi(order["line"])
        return self.program(order["file"])

    def answer(self, done, order):
        self.hear()
        self.stat.poll()
        answer = {
            "done": done,
            "errors": self.errors,
            "messages": self.messages,
            "position": list(self.stat.position[:3]),
        }
        if PROBING.search(order.get("line", "")) and self.stat.probe_tripped:
            answer["probed"] = list(self.stat.probed_position[:3])
        self.errors, self.messages = [], []
        self.line.write((json.dumps(answer) + "\n").encode())
        self.line.flush()

    def serve(self):
        self.answer(self.switch_on(), {})
        for text in self.line:
            order = json.loads(text)
            if order["do"] == "end":
                return
            self.answer(self.obey(order), order)


if __name__ == "__main__":
    with open(int(os.environ["CALTWIN_OPERATOR"]), "r+b", buffering=0) as raw:
        Operator(io.BufferedRWPair(raw, raw)).serve()
    sys.exit(0)
