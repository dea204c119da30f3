"""Whichever side is killed, the other says so and neither hangs: klipper_restart_test.py CALTWIN HOST fast

As klipper_delta_test.py.
"""

import os
import subprocess
import sys
import threading
import time

from klipper_host import HostError, Rig, main


def homes(rig):
    rig.say("G28")
    return rig.status("toolhead")["homed_axes"] == "xyz"


def kill(child):
    child.kill()
    child.wait()


def run(caltwin, host, fidelity, folder):
    faults = []
    with Rig(caltwin, host, folder, "delta_printer", None, ["--fidelity", fidelity]) as rig:
        first = rig.start_host()
        rig.connect()
        if not homes(rig):
            faults.append("it does not home")

        # The host, in the middle of a descent. Another finds the machine, and a chip to reset.
        rig.say("G1 Z100 F6000")
        threading.Timer(1.0, first.kill).start()
        try:
            rig.say("PROBE", patience_s=20)
            faults.append("the descent was over before the host was killed")
        except (HostError, ConnectionError):
            pass
        first.wait()
        time.sleep(3)  # The chip goes on for as long as it was told to wait for its host: 2 s.
        second = rig.start_host()
        rig.connect()
        if not homes(rig):
            faults.append("it does not home under the second host")

        # The twin: its host is to say so, not to hang.
        kill(rig.twin)
        until = time.monotonic() + 30
        while time.monotonic() < until:
            info = rig.api.ask("info", {}, 10)
            if info["state"] == "shutdown":
                break
            time.sleep(0.2)
        if "Lost communication" not in info["state_message"]:
            faults.append(f"the host says {info}")
        second.terminate()
        second.wait(20)

        # Another twin at the same place, over what the killed one left.
        rig.start_twin()
        rig.start_host()
        rig.connect()
        if not homes(rig):
            faults.append("it does not home with the second twin")
        serial = rig.serial
    if os.path.lexists(serial):
        faults.append(f"{serial} was left behind")
    left = [child.pid for child in rig.children if child.poll() is None]
    if left:
        faults.append(f"left running: {left}")

    # A second twin at a place that is taken: one message, exit code 2.
    taken = folder / "taken"
    taken.write_text("")
    refused = subprocess.run(
        [caltwin, "serve", "--machine", "delta_printer", "--klipper", taken],
        capture_output=True, text=True, timeout=20, check=False)
    if refused.returncode != 2 or "must not exist yet" not in refused.stderr:
        faults.append(f"a path that is taken: {refused}")
    return faults


if __name__ == "__main__":
    sys.exit(main(__doc__, run))
