"""A `caltwin serve` of its own, and what its clients send: for rest_test.py."""

import atexit
import http.client
import json
import signal
import subprocess
import threading

JSON = {"Content-Type": "application/json"}


class Server:
    def __init__(self, program, state, *options):
        words = [program, "serve", "--http", "0", "--fidelity", "fast", "--state", state, *options]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        atexit.register(self.process.kill)  # Nothing stays behind where a claim fails.
        self.port = None
        for line in self.process.stdout:
            if line.startswith("open http://"):
                self.port = int(line.split(":")[2].split("/")[0])
                break
        threading.Thread(target=self.process.stdout.read, daemon=True).start()

    def ask(self, method, path, body=None, headers=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        sent = dict(headers or {})
        if isinstance(body, (dict, list)):
            body = json.dumps(body)
            sent = {**JSON, **sent}
        connection.request(method, path, body, sent)
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        if text and (answer.getheader("Content-Type") or "").split(";")[0].endswith("json"):
            return answer.status, json.loads(text)
        return answer.status, text.decode("utf-8", "replace")

    def done(self, method, path, body=None, headers=None):
        status, answer = self.ask(method, path, body, headers)
        assert status in (200, 202), (method, path, status, answer)
        return answer

    def end(self, how=signal.SIGINT):
        self.process.send_signal(how)
        return self.process.wait(20)


def file_form(name, text, **fields):
    mark = "----caltwin"
    parts = [f'--{mark}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\n{text}\r\n']
    for key, value in fields.items():
        parts.append(f'--{mark}\r\nContent-Disposition: form-data; name="{key}"\r\n\r\n{value}\r\n')
    body = "".join(parts) + f"--{mark}--\r\n"
    return body.encode(), {"Content-Type": f"multipart/form-data; boundary={mark}"}


def files_form(files):
    mark = "----caltwin"
    body = "".join(f'--{mark}\r\nContent-Disposition: form-data; name="file"; filename="{name}"'
                   f"\r\n\r\n{text}\r\n" for name, text in files.items()) + f"--{mark}--\r\n"
    return body.encode(), {"Content-Type": f"multipart/form-data; boundary={mark}"}
