"""Clients that mean no good, and the others, who are answered all the same: for rest_test.py."""

import http.client
import json
import socket
import threading
import time


class SlowClients:
    """Many connections that send a byte of a request now and then, for as long as it lives."""

    def __init__(self, port, count, every_s=0.2):
        self.port, self.count, self.every_s = port, count, every_s
        self.ends = threading.Event()
        self.all_there = threading.Event()
        self.thread = threading.Thread(target=self.work, daemon=True)

    def __enter__(self):
        self.thread.start()
        assert self.all_there.wait(60), "the attack did not begin"
        return self

    def __exit__(self, *_):
        self.ends.set()
        self.thread.join()

    def begun(self):
        raw = socket.create_connection(("127.0.0.1", self.port), 10)
        raw.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: ")
        raw.setblocking(False)
        return raw

    def trickled(self, raw):
        """The connection, or another where the server has closed it."""
        try:
            raw.send(b"a")
            if raw.recv(4096) != b"":
                return raw
        except BlockingIOError:
            return raw
        except OSError:
            pass
        raw.close()
        return self.begun()

    def work(self):
        held = [self.begun() for _ in range(self.count)]
        self.all_there.set()
        while not self.ends.wait(self.every_s):
            held = [self.trickled(raw) for raw in held]
        for raw in held:
            raw.close()


def slow_clients_lock_nobody_out(server):
    listener = socket.create_connection(("127.0.0.1", server.port), 30)
    listener.sendall(b"GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
    assert b"200 OK" in listener.recv(4096)
    with SlowClients(server.port, 600):
        for _ in range(10):
            assert server.ask("GET", "/api")[0] == 200
            assert server.ask("POST", "/api/bench/emergency-stop")[0] == 202
            assert server.ask("POST", "/api/bench/abort")[0] == 202
            time.sleep(0.1)
    server.done("POST", "/api/bench/procedures", {"procedure": "home"})
    while b"event: bench" not in listener.recv(65536):
        pass
    listener.close()
    while server.done("GET", "/api/bench")["state"] != "idle":
        time.sleep(0.01)


def begun_upload(port, length, sent):
    raw = socket.create_connection(("127.0.0.1", port), 30)
    raw.sendall(b"POST /api/diagnose HTTP/1.1\r\nHost: localhost\r\n"
                b"Content-Type: multipart/form-data; boundary=x\r\n"
                + f"Content-Length: {length}\r\n\r\n".encode() + b"a" * sent)
    return raw


def memory_bytes(server):
    with open(f"/proc/{server.process.pid}/status", encoding="ascii") as status:
        for line in status:
            if line.startswith("VmRSS:"):
                return 1024 * int(line.split()[1])
    raise AssertionError("no VmRSS")


def uploads_together_are_bounded(server):
    before = memory_bytes(server)
    length = 55_000_000
    held = [begun_upload(server.port, length, length - 1) for _ in range(3)]
    refused = [begun_upload(server.port, length, length - 1) for _ in range(20)]
    for raw in refused:
        answer = http.client.HTTPResponse(raw)
        answer.begin()
        assert answer.status == 503 and answer.getheader("Retry-After"), answer.status
        assert json.loads(answer.read())["status"] == 503
        raw.close()
    grown = memory_bytes(server) - before
    assert grown < 250_000_000, grown
    assert server.ask("POST", "/api/bench/answer", {"id": 1})[0] == 409, "small bodies are read"
    for raw in held:
        raw.close()
