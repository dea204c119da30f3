"""The library that gives a host its time, in a process of Python in place of the host: host_time_test.py LIBRARY"""

import os
import socket
import struct
import subprocess
import sys
import time
import unittest

LIBRARY = ""
START_ns = 1000 * 10**9
MS = 10**6
NEVER = 2**63 - 1

HOST = """
import os, select, sys, threading, time
raw = lambda: time.clock_gettime(time.CLOCK_MONOTONIC_RAW)
ends = [os.pipe() for _ in range(2)]
def wait(ms, descriptor):
    polled = select.poll()
    polled.register(descriptor, select.POLLIN)
    return [fd for fd, _ in polled.poll(ms)]
"""


class Twin:
    """The microcontroller's side of the clock."""

    def __init__(self, script, *more):
        self.ours, theirs = socket.socketpair()
        self.ours.settimeout(10)
        os.set_inheritable(theirs.fileno(), True)
        environment = {**os.environ, "LD_PRELOAD": LIBRARY, "CALTWIN_HOST_TIME": str(theirs.fileno())}
        self.host = subprocess.Popen(["/usr/bin/python3", "-c", HOST + script, *more], env=environment, close_fds=False,
                                     stdout=subprocess.PIPE, text=True)
        theirs.close()

    def asked(self):
        deadline, written, now = struct.unpack("<qqq", self.ours.recv(24, socket.MSG_WAITALL))
        return deadline, written, now

    def grant(self, now, parked=0):
        self.ours.sendall(struct.pack("<qqq", parked, now, 0))

    def ends(self):
        said, _ = self.host.communicate(timeout=10)
        self.ours.close()
        return said.split(), self.host.returncode


class HostTime(unittest.TestCase):
    def test_time_is_the_twins(self):
        twin = Twin("print(raw()); wait(250, ends[0][0]); print(raw())")
        self.assertEqual(twin.asked(), (START_ns + 250 * MS, 0, START_ns))
        time.sleep(0.1)  # However long the twin takes.
        twin.grant(START_ns + 100 * MS)  # Too early: the host waits on.
        self.assertEqual(twin.asked(), (START_ns + 250 * MS, 0, START_ns + 100 * MS))
        twin.grant(START_ns + 250 * MS)
        self.assertEqual(twin.ends(), (["1000.0", "1000.25"], 0))

    def test_computing_takes_no_time(self):
        twin = Twin("a = raw(); sum(i * i for i in range(10**6)); print(raw() - a)")
        self.assertEqual(twin.ends(), (["0.0"], 0))

    def test_a_sleep_is_a_wait_of_whole_milliseconds(self):
        twin = Twin("time.sleep(0.015); print(raw())")
        self.assertEqual(twin.asked()[0], START_ns + 15 * MS)
        twin.grant(START_ns + 15 * MS)
        self.assertEqual(twin.ends(), (["1000.015"], 0))

    def test_what_can_be_read_comes_before_time(self):
        twin = Twin("""
os.write(ends[0][1], b'x'); print(wait(1000, ends[0][0]) == [ends[0][0]], raw())
threading.Thread(target=lambda: (wait(50, ends[0][0]) or True) and os.read(ends[0][0], 1) and
                 wait(30, ends[1][0]) == [] and os.write(ends[1][1], b'y')).start()
print(wait(1000, ends[1][0]) == [ends[1][0]], raw())""")
        deadline, _, now = twin.asked()
        self.assertEqual((deadline, now), (START_ns + 30 * MS, START_ns))  # The first of two threads.
        twin.grant(START_ns + 30 * MS)
        self.assertEqual(twin.ends(), (["True", "1000.0", "True", "1000.03"], 0))

    def test_parked_it_wakes_for_what_comes(self):
        twin = Twin("""
print(wait(1000, int(sys.argv[1])) == [int(sys.argv[1])], raw())""", *self.inherited())
        twin.asked()
        twin.grant(0, parked=1)
        twin.ours.settimeout(0.3)
        with self.assertRaises(TimeoutError):  # It asks for nothing.
            twin.asked()
        twin.ours.settimeout(10)
        os.write(self.write_end, b"now")
        twin.grant(0)
        said, code = twin.ends()
        self.assertEqual((said, code), (["True", "1000.0"], 0))

    def inherited(self):
        read_end, self.write_end = os.pipe()
        os.set_inheritable(read_end, True)
        self.addCleanup(os.close, read_end)
        return [str(read_end)]

    def test_a_forked_process_is_waited_for(self):
        twin = Twin("""
child = os.fork()
if child == 0:
    time.sleep(0.5); os._exit(0)
wait(10, ends[0][0])
print(os.waitpid(child, os.WNOHANG)[0] == child)""")
        self.assertEqual(twin.asked()[0], START_ns + 10 * MS)
        twin.grant(START_ns + 10 * MS)
        self.assertEqual(twin.ends(), (["True"], 0))

    def test_without_a_twin_it_ends(self):
        twin = Twin("wait(250, ends[0][0]); print('never')")
        twin.asked()
        twin.ours.close()
        self.assertEqual(twin.ends(), ([], 9))

    def test_without_a_twin_it_ends_while_it_computes(self):
        twin = Twin("""
while True: pass""")
        twin.ours.close()
        self.assertEqual(twin.host.wait(timeout=10), 9)
        twin.host.stdout.close()

    def test_programs_that_the_host_runs_have_the_computers_time(self):
        twin = Twin("""
import subprocess
print(subprocess.run([sys.executable, "-c", "import os; print(os.environ.get('LD_PRELOAD'))"],
                     capture_output=True, text=True).stdout.strip())""")
        self.assertEqual(twin.ends(), (["None"], 0))


if __name__ == "__main__":
    LIBRARY = sys.argv.pop(1)
    unittest.main(verbosity=2)
