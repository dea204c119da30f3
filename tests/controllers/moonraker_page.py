"""Moonraker as a web page meets it: HTTP, and JSON-RPC over a websocket, with Python's own library alone."""

import base64
import http.client
import json
import os
import socket
import struct
import time

from klipper_host import HostError


class Refused(Exception):
    """Moonraker answered with an error."""


class Socket:
    """A websocket, as far as JSON in frames of text needs."""

    def __init__(self, port, path):
        self.socket = socket.create_connection(("127.0.0.1", port), 10)
        self.buffer = b""
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        while b"\r\n\r\n" not in self.buffer:
            self.more(10)
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise Refused(head.decode())

    def more(self, patience_s):
        self.socket.settimeout(max(0.01, patience_s))
        got = self.socket.recv(65536)
        if not got:
            raise HostError("Moonraker closed the websocket")
        self.buffer += got

    def take(self, size, until):
        while len(self.buffer) < size:
            self.more(until - time.monotonic())
        taken, self.buffer = self.buffer[:size], self.buffer[size:]
        return taken

    def send(self, payload, kind=1):
        size, mask = len(payload), os.urandom(4)
        head = bytes([0x80 | kind])
        head += bytes([0x80 | size]) if size < 126 else struct.pack(">BH", 0x80 | 126, size)
        self.socket.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def receive(self, until):
        """The next text; a TimeoutError where none comes before `until`."""
        text = b""
        while True:
            first, size = self.take(2, until)
            if size >= 126:
                wide = {126: ">H", 127: ">Q"}[size]
                size = struct.unpack(wide, self.take(struct.calcsize(wide), until))[0]
            payload, kind = self.take(size, until), first & 15
            if kind == 9:
                self.send(payload, 10)
            if kind > 2:
                continue
            text += payload
            if first & 0x80:
                return text.decode()


class Page:
    """A page that is connected: JSON-RPC, and what Moonraker says by itself."""

    def __init__(self, port, token):
        self.socket, self.said, self.asked = Socket(port, f"/websocket?token={token}"), [], 0

    def receive(self, until):
        message = json.loads(self.socket.receive(until))
        if "method" in message:
            self.said.append((message["method"], message.get("params", [])))
        return message

    def ask(self, method, patience_s=20, **params):
        self.asked += 1
        request = {"jsonrpc": "2.0", "method": method, "params": params, "id": self.asked}
        self.socket.send(json.dumps(request).encode())
        until = time.monotonic() + patience_s
        while True:
            try:
                answer = self.receive(until)
            except TimeoutError:
                raise HostError(f"{method} {params}: no answer in {patience_s} s") from None
            if answer.get("id") == self.asked:
                if "error" in answer:
                    raise Refused(answer["error"]["message"])
                return answer["result"]

    def wait(self, method, patience_s=30, fits=lambda params: True):
        """The parameters of the next notification that fits; those before it are forgotten."""
        until = time.monotonic() + patience_s
        while True:
            while self.said:
                name, params = self.said.pop(0)
                if name == method and fits(params):
                    return params
            try:
                self.receive(until)
            except TimeoutError:
                raise HostError(f"{method} does not come in {patience_s} s") from None

    def refusal(self, method, **params):
        try:
            return f"not refused: {self.ask(method, 60, **params)}"
        except Refused as error:
            return str(error)


def call(port, method, path, body=None, headers=None):
    """(status, headers, JSON) of a request over HTTP."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    try:
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        return answer.status, answer.headers, json.loads(answer.read() or b"null")
    finally:
        connection.close()


def wait_until_ready(port, patience_s=60):
    until, info = time.monotonic() + patience_s, None
    while time.monotonic() < until:
        try:
            info = call(port, "GET", "/server/info")[2]["result"]
            if info["klippy_state"] == "ready":
                return info
        except OSError:
            pass
        time.sleep(0.2)
    raise HostError(f"Moonraker is not ready: {info}")
