#!/usr/bin/python3
"""Whoever sits at LinuxCNC, for caltwin: the DISPLAY of an INI file.

Reads orders, a JSON object a line, from the descriptor that CALTWIN_OPERATOR names, and
answers each with one. Orders: {"do": "on"}, {"do": "home"}, {"do": "mdi", "line": "G38.2 Z-20 F60"},
{"do": "program", "file": "job.ngc"}, {"do": "end"}. An answer:

    done      whether LinuxCNC did it to its end
    errors    what it printed as errors
    messages  what else it printed: (DEBUG, ...), (MSG, ...)
    probed    where the probe met something, in order, machine coordinates in mm
    position  where LinuxCNC has the tool now, likewise

A program that pauses (M0, M1) goes on: nobody is there to press a button. The first answer comes unasked: LinuxCNC is on.
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
PATIENCE_s = 7
COMMENT = re.compile(r"\([^)]*\)|;.*")
PROBING = re.compile(r"(?<![A-Z#<_])G\s*0*38\s*\.\s*[2-5]", re.IGNORECASE)
END = re.compile(r"(?<![A-Z#<_])M\s*0*(2|30)(?!\s*[0-9.])", re.IGNORECASE)


def task():
    """The process of LinuxCNC that obeys; it lives as long as its INI file is run. It is
    started beside us, and may come later."""
    until = time.monotonic() + PATIENCE_s
    while time.monotonic() < until:
        for pid in filter(str.isdigit, os.listdir("/proc")):
            with contextlib.suppress(OSError), open(f"/proc/{pid}/comm") as name:
                if name.read().strip() == "milltask":
                    return pid
        time.sleep(0.05)
    sys.exit("caltwin_operator: LinuxCNC's milltask is not there")


class Operator:
    def __init__(self, line):
        self.task = task()
        self.line = line
        self.command, self.stat = linuxcnc.command(), linuxcnc.stat()
        self.channel = linuxcnc.error_channel()
        self.errors, self.messages = [], []
        self.probed, self.probed_last = [], None

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

    def in_mm(self, position):
        return [value / self.stat.linear_units for value in position[:3]]

    def look(self):
        """What the probe has met since the last look, if it is elsewhere."""
        self.stat.poll()
        at = tuple(self.stat.probed_position[:3])
        if self.stat.probe_tripped and at != self.probed_last:
            self.probed.append(self.in_mm(at))
            self.probed_last = at

    def go_on(self):
        """Presses the button that a program waits for."""
        if self.stat.interp_state == linuxcnc.INTERP_PAUSED:
            self.messages.append("the program paused, and went on by itself")
            self.command.auto(linuxcnc.AUTO_RESUME)

    def wait(self):
        """Until the last command is done: what LinuxCNC says of it."""
        while (state := self.command.wait_complete(0.02)) == -1:
            self.look()
            self.go_on()
            self.hear()
        # An error may come a moment after the end that it made.
        self.look()
        self.hear()
        return state

    def is_done(self):
        return self.wait() == linuxcnc.RCS_DONE and not self.errors

    def mode(self, mode):
        self.stat.poll()
        if self.stat.task_mode == mode:
            return True
        self.command.mode(mode)
        return self.is_done()

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
        code = COMMENT.sub(" ", line)
        before = len(self.probed)
        self.command.mdi(line)
        state = self.wait()
        is_same_place = PROBING.search(code) and self.stat.probe_tripped
        if is_same_place and len(self.probed) == before:
            self.probed.append(self.in_mm(self.probed_last))
        # The end of a program is no fault, though LinuxCNC reports one.
        return not self.errors and (state == linuxcnc.RCS_DONE or bool(END.search(code)))

    def program(self, file):
        if not self.mode(linuxcnc.MODE_AUTO):
            return False
        self.command.program_open(os.path.abspath(file))
        if not self.is_done():
            return False
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self.wait()
        while True:
            self.look()
            self.go_on()
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

    def answer(self, done):
        self.hear()
        self.stat.poll()
        answer = {
            "done": done,
            "errors": self.errors,
            "messages": self.messages,
            "probed": self.probed,
            "position": self.in_mm(self.stat.position),
        }
        self.errors, self.messages, self.probed = [], [], []
        self.line.write((json.dumps(answer) + "\n").encode())
        self.line.flush()

    def serve(self):
        self.answer(self.switch_on())
        for text in self.line:
            order = json.loads(text)
            if order["do"] == "end":
                return
            try:
                self.answer(self.obey(order))
            except (linuxcnc.error, ValueError) as fault:
                self.errors.append(str(fault))
                self.answer(False)


if __name__ == "__main__":
    with open(int(os.environ["CALTWIN_OPERATOR"]), "r+b", buffering=0) as raw:
        Operator(io.BufferedRWPair(raw, raw)).serve()
    sys.exit(0)
