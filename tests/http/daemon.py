"""daemon.py - a real glintd on a free port with a state folder of its own, and what tests ask it.

    with Daemon("--threads", "2") as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 4})
        frame = daemon.get(f"/v1/jobs/{job}/frame.exr?wait=done").body

Where $GLINTD names no program every test is skipped, on import.
"""
import contextlib
import http.client
import json
import os
import re
import select
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
from urllib.parse import urlsplit

import tap

# Seconds until a condition that must come counts as missing. Sanitizers on a loaded machine want more.
PATIENCE = float(os.environ.get("GLINT_PATIENCE", 120))

# A box that is open to the camera: a floor, a back wall, a lamp, two objects.
ROOM = {
    "materials": {
        "white": {"base_color": [0.7, 0.7, 0.7]},
        "red": {"base_color": [0.7, 0.1, 0.1]},
        "metal": {"base_color": [0.9, 0.8, 0.6], "metallic": 1, "roughness": 0.3},
        "lamp": {"base_color": [0, 0, 0], "emission": [12, 11, 9]},
    },
    "meshes": {
        "box": {"primitive": "box"},
        "sphere": {"primitive": "sphere"},
    },
    "objects": {"floor": {}, "wall": {}, "ball": {"asset": "toys"}, "cube": {"asset": "toys"},
                "light": {}},
    "instances": {
        "floor": {"mesh": "box", "material": "white", "object": "floor",
                  "transform": {"translation": [0, -0.05, 0], "scale": [6, 0.1, 6]}},
        "wall": {"mesh": "box", "material": "red", "object": "wall",
                 "transform": {"translation": [0, 1.5, -2], "scale": [6, 3, 0.1]}},
        "ball": {"mesh": "sphere", "material": "metal", "object": "ball",
                 "transform": {"translation": [-0.7, 0.5, 0], "scale": [0.5, 0.5, 0.5]}},
        "cube": {"mesh": "box", "material": "white", "object": "cube",
                 "transform": {"translation": [0.8, 0.35, 0.2], "scale": [0.7, 0.7, 0.7]}},
        "light": {"mesh": "box", "material": "lamp", "object": "light",
                  "transform": {"translation": [0, 3, 0], "scale": [1, 0.05, 1]}},
    },
    "cameras": {"main": {"yfov": 0.8, "transform": {"translation": [0, 1, 5]}}},
}


GLINTD = os.environ.get("GLINTD") or tap.build("glintd")
if not os.access(GLINTD, os.X_OK):
    tap.skip_all("no glintd")


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body)

    def pointers(self):
        """Of a problem's faults."""
        return sorted(fault["pointer"] for fault in self.json()["errors"])


class Daemon:
    """`launch` starts the program in a way of its own: it takes the command and what Popen takes.
    `tls` is a client's ssl.SSLContext; `headers` go with every request."""

    def __init__(self, *options, environment=None, launch=subprocess.Popen, tls=None, headers=None):
        self.options = options
        self.environment = {**os.environ, **(environment or {})}
        self.launch = launch
        self.tls = tls
        self.headers = headers or {}

    def __enter__(self):
        self.state = tempfile.mkdtemp(prefix="glint-test-")
        self.log = open(os.path.join(self.state, "log"), "a+", encoding="utf-8")
        self.process = self.launch(
            [GLINTD, "--listen", "127.0.0.1:0", "--state", self.state, *self.options],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.log, text=True,
            env=self.environment)
        try:
            self.url = self.read_url()
            self.port = urlsplit(self.url).port
        except BaseException:
            self.__exit__()
            raise
        return self

    def read_url(self):
        ready, _, _ = select.select([self.process.stdout], [], [], PATIENCE)
        line = self.process.stdout.readline() if ready else ""
        found = re.match(r"glintd: listening on (https?://127\.0\.0\.1:\d+)$", line)
        assert found, f"it says {line!r}, and: {self.logged()}"
        return found[1]

    def __exit__(self, *error):
        code = self.stop()
        text = self.logged()
        self.log.close()
        shutil.rmtree(self.state, ignore_errors=True)
        if not any(error):
            assert code == 0, f"it ended with {code}: {text[-4000:]}"

    def stop(self):
        """Asks it to end; returns the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()
        finally:
            self.process.stdout.close()

    def logged(self):
        self.log.seek(0)
        return self.log.read()

    # Requests

    def ask(self, method, path, body=None, headers=None):
        if self.tls:
            connection = http.client.HTTPSConnection("127.0.0.1", self.port, timeout=PATIENCE,
                                                     context=self.tls)
        else:
            connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        with contextlib.closing(connection):
            connection.request(method, path, body, {**self.headers, **(headers or {})})
            answer = connection.getresponse()
            return Answer(answer.status, answer.headers, answer.read())

    def get(self, path, headers=None):
        return self.ask("GET", path, None, headers)

    def delete(self, path):
        return self.ask("DELETE", path)

    def put(self, name, scene, **headers):
        """A native scene, or the bytes of a GLB; expects that it is taken."""
        is_glb = isinstance(scene, bytes)
        answer = self.ask("PUT", f"/v1/scenes/{name}", scene if is_glb else json.dumps(scene),
                          {"Content-Type": "model/gltf-binary" if is_glb else "application/json",
                           **headers})
        assert answer.status in (200, 201), answer.body
        return answer

    def post(self, job, headers=None):
        text = job if isinstance(job, (str, bytes)) else json.dumps(job)
        return self.ask("POST", "/v1/jobs", text,
                        {"Content-Type": "application/json", **(headers or {})})

    def submit(self, **job):
        """Returns the id; expects that the job is taken."""
        answer = self.post({"resolution": [128, 96], **job})
        assert answer.status == 202, answer.body
        return answer.json()["id"]

    def job(self, job):
        return self.get(f"/v1/jobs/{job}").json()

    def frame(self, job, query=""):
        answer = self.get(f"/v1/jobs/{job}/frame.exr?wait=done{query}")
        assert answer.status == 200, answer.body
        return answer.body

    def follow(self, job):
        """The job's description after each change, until it ends."""
        with self.connect(f"/v1/jobs/{job}/events") as stream:
            for name, data in stream.events():
                if name in ("state", "reset", "progress"):
                    yield data

    def until(self, job, condition):
        """The first state of the job for which the condition holds."""
        for data in self.follow(job):
            if condition(data):
                return data
        raise AssertionError(f"it ended as {self.job(job)}")

    def metric(self, name):
        text = self.get("/metrics").body.decode()
        return float(re.search(rf"^{re.escape(name)} (.+)$", text, re.M)[1])

    def wait_metric(self, name, value):
        end = time.monotonic() + PATIENCE
        while self.metric(name) != value:
            assert time.monotonic() < end, f"{name} is {self.metric(name)}"

    # Sockets

    def dial(self, receive_buffer=None):
        s = socket.socket()
        if receive_buffer:
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        s.settimeout(PATIENCE)
        s.connect(("127.0.0.1", self.port))
        return s

    def raw(self, request):
        """Sends bytes, closes its side never, returns what came until the daemon closed."""
        with self.dial() as s:
            with contextlib.suppress(OSError):  # refused before all was sent
                s.sendall(request)
            got = b""
            with contextlib.suppress(ConnectionResetError):
                while more := s.recv(65536):
                    got += more
            return got

    def connect(self, path, headers=None, receive_buffer=None):
        sock = self.dial(receive_buffer)
        if self.tls:
            sock = self.tls.wrap_socket(sock, server_hostname="127.0.0.1")
        return Stream(sock, path, {**self.headers, **(headers or {})})


class Stream:
    """An answer that is read as it comes."""

    def __init__(self, sock, path, headers):
        self.socket = sock
        lines = [f"GET {path} HTTP/1.1", "Host: localhost", *map(": ".join, headers.items())]
        sock.sendall("\r\n".join([*lines, "", ""]).encode())
        self.response = http.client.HTTPResponse(sock)
        self.response.begin()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()

    def close(self):
        self.response.close()
        self.socket.close()

    def reset(self):
        """Leaves without a goodbye."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.close()

    def line(self):
        return self.response.readline().decode().rstrip("\r\n")

    def events(self):
        """(name, data) of server-sent events until the end."""
        fields = {}
        while raw := self.response.readline():
            line = raw.decode().rstrip("\n")
            if line.startswith(":"):
                continue
            if line:
                name, _, value = line.partition(": ")
                fields[name] = value
            elif "data" in fields:
                self.last_id = fields.get("id")
                yield fields["event"], json.loads(fields["data"])
                fields = {}

    def parts(self):
        """(headers, body) of a multipart stream until its closing delimiter."""
        boundary = re.search("boundary=([^;]+)", self.response.headers["Content-Type"])[1]
        while True:
            line = self.line()
            while not line and not self.response.isclosed():
                line = self.line()
            if line == f"--{boundary}--" or not line:
                self.ended = line != ""
                return
            assert line == f"--{boundary}", line
            headers = http.client.parse_headers(self.response)
            yield headers, self.read(int(headers["Content-Length"]))

    def read(self, size):
        data = b""
        while len(data) < size:
            more = self.response.read(size - len(data))
            assert more, "the stream was cut"
            data += more
        return data


def glb(scene, blob=b""):
    """A GLB from glTF JSON and one buffer."""
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if blob:
        chunks += struct.pack("<I4s", len(blob), b"BIN\0") + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def form(files):
    """{name: bytes} as the body of multipart/form-data, and its Content-Type."""
    boundary = "glint-test-4f9d"
    body = b"".join(
        f'--{boundary}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n\r\n'
        .encode() + content + b"\r\n" for name, content in files.items())
    return body + f"--{boundary}--\r\n".encode(), f"multipart/form-data; boundary={boundary}"


def triangle_glb():
    """One lit triangle and a camera."""
    positions = struct.pack("<9f", -1, -1, 0, 1, -1, 0, 0, 1, 0)
    return glb({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "sail"}, {"camera": 0, "translation": [0, 0, 4]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "cloth", "emissiveFactor": [1, 0.5, 0.25]}],
        "cameras": [{"type": "perspective", "name": "eye",
                     "perspective": {"yfov": 0.8, "aspectRatio": 1.0, "znear": 0.1}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [-1, -1, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
    }, positions)
