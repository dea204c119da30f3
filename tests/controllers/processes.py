"""The processes that a test has started, in whatever namespace they are."""

import contextlib
import os
import pathlib


def with_tmpdir(folder):
    """Those that were given that folder as TMPDIR: their names by number."""
    found = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            if f"TMPDIR={folder}\0".encode() in pathlib.Path("/proc", pid, "environ").read_bytes():
                found[int(pid)] = pathlib.Path("/proc", pid, "comm").read_text().strip()
    return found
