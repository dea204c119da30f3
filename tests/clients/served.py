"""A `caltwin serve` on a pseudo-terminal and a port, for the tests of clients."""

import os
import signal
import subprocess
import tempfile
import threading
import time


class Served:
    """Started with these options; ends at the end of the block."""

    def __init__(self, program, *options):
        self.folder = tempfile.TemporaryDirectory()
        self.terminal = os.path.join(self.folder.name, "machine")
        self.process = subprocess.Popen(
            [program, "serve", "--pty", self.terminal, "--tcp", "0", *options],
            stdout=subprocess.PIPE, text=True)
        self.port = None
        said, has_terminal = [], False
        for line in self.process.stdout:
            said.append(line)
            if line.startswith("listening on"):
                self.port = int(line.rsplit(":", 1)[1])
            has_terminal = any(text.startswith("terminal at") for text in said)
            if self.port and has_terminal:
                break
        assert self.port and has_terminal, f"caltwin serve said {said}"
        threading.Thread(target=self.process.stdout.read, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(20)
        self.folder.cleanup()
        assert code == 130, f"caltwin serve ended with {code}"


def wait_for(what, is_so, patience_s=10):
    """Asks until `is_so()` is true and answers it; fails by name after that time."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        answer = is_so()
        if answer:
            return answer
        time.sleep(0.02)
    raise AssertionError(f"waited {patience_s} s for {what}")


def near(what, got, wanted, by):
    assert abs(got - wanted) <= by, f"{what}: {got} where {wanted} +- {by} is right"
    print(f"{what}: {got:.4f}")
