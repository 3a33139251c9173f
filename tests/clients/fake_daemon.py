"""fake_daemon.py - just enough of a glintd to see what a client does: it renders nothing.

As a module: `with FakeDaemon() as daemon` serves on a free port; `daemon.on(method, path, answer)`
replaces what is answered there; `daemon.requests` is what came in. As a program it takes glintd's
options and says where it listens, for tests of private daemons.
"""
import argparse
import hashlib
import json
import os
import signal
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import unquote, urlsplit

FRAME = b"the bytes of a frame"
JOB = {"id": "job1", "scene": "scene", "state": "done", "samples": 64, "progress": 1.0,
       "error": 0.0123, "seconds": 2.5, "eta_seconds": 0}


class Request:
    def __init__(self, method, target, headers, body):
        self.method, self.target, self.headers, self.body = method, target, headers, body
        self.path, self.query = urlsplit(target).path, urlsplit(target).query


class Answer:
    """status, body (bytes, or anything that JSON can say), media type, more headers. `cut`: the
    connection is closed after that many bytes of the body."""

    def __init__(self, status, body=b"", media=None, headers=None, cut=None):
        is_bytes = isinstance(body, bytes)
        self.status = status
        self.body = body if is_bytes else json.dumps(body).encode()
        self.media = media or ("application/octet-stream" if is_bytes else "application/json")
        self.headers, self.cut = headers or {}, cut


def problem(status, detail, errors=()):
    return Answer(status, {"type": "/problems/test", "title": "A problem", "status": status,
                           "detail": detail, "errors": list(errors)}, "application/problem+json")


def event(name, data, number=None):
    text = f"id: {number}\n" if number is not None else ""
    return f"{text}event: {name}\ndata: {json.dumps(data)}\n\n".encode()


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *args):
        pass

    def read_body(self):
        return self.rfile.read(int(self.headers.get("Content-Length", 0)))

    def handle_any(self):
        request = Request(self.command, self.path, dict(self.headers), self.read_body())
        answer = self.server.owner.take(request)
        if callable(answer):  # it writes the answer itself
            answer(self)
            return
        self.send_response(answer.status)
        self.send_header("Content-Type", answer.media)
        self.send_header("Content-Length", str(len(answer.body)))
        for name, value in answer.headers.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(answer.body if answer.cut is None else answer.body[:answer.cut])
        if answer.cut is not None:
            self.close_connection = True

    do_GET = do_PUT = do_POST = do_PATCH = do_DELETE = handle_any

    def start_stream(self):
        """For answers that write events: opens a stream that ends with the connection."""
        self.close_connection = True
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Connection", "close")
        self.end_headers()


class FakeDaemon:
    def __init__(self):
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.server.owner = self
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        self.answers, self.requests, self.revision = {}, [], None
        self.changed = threading.Condition()

    def __enter__(self):
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *error):
        self.server.shutdown()
        self.server.server_close()

    def on(self, method, path, answer):
        """`answer`: an Answer, a function of the handler that writes one, or a list of these of
        which each request takes one and the last stays."""
        self.answers[method, path] = answer if isinstance(answer, list) else [answer]

    def take(self, request):
        with self.changed:
            self.requests.append(request)
            self.changed.notify_all()
            given = self.answers.get((request.method, request.path))
            if given:
                return given.pop(0) if len(given) > 1 else given[0]
            return self.usual(request)

    def usual(self, r):
        if r.method == "PUT" and r.path.startswith("/v1/scenes/"):
            self.revision = hashlib.sha256(r.body).hexdigest()
            name = unquote(r.path.removeprefix("/v1/scenes/"))
            return Answer(201, {"name": name, "revision": self.revision, "triangles": 12})
        if r.method == "POST" and r.path == "/v1/jobs":
            return Answer(202, {**JOB, "state": "queued", "revision": self.revision})
        if r.method == "GET" and r.path == "/v1/jobs/job1":
            return Answer(200, JOB)
        if r.method == "GET" and r.path == "/v1/jobs/job1/events":
            return Answer(200, event("progress", {"state": "rendering", "progress": 0.5,
                                                  "samples": 32, "error": 0.02}, 1)
                          + event("done", {"state": "done"}, 2), "text/event-stream")
        if r.method == "GET" and r.path.startswith("/v1/jobs/job1/frame."):
            return Answer(200, FRAME)
        if r.method == "DELETE":
            return Answer(202, {**JOB, "state": "cancelled"})
        if r.path == "/healthz":
            return Answer(200, b"ok\n", "text/plain")
        return problem(404, f"nothing is at {r.path}")

    def wait_for(self, method, path, seconds=20):
        """The first such request; fails if it does not come."""
        def found():
            return [r for r in self.requests if (r.method, r.path) == (method, path)]
        with self.changed:
            assert self.changed.wait_for(found, seconds), f"no {method} {path}: {self.seen()}"
            return found()[0]

    def seen(self):
        return [f"{r.method} {r.target}" for r in self.requests]


def hang(handler):
    """Tells its process id to a FIFO and answers never."""
    with open(os.environ["FAKE_DAEMON_HANGS"], "w", encoding="ascii") as fifo:
        fifo.write(str(os.getpid()))
    handler.rfile.read()


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--listen", required=True)
    options.add_argument("--state", required=True)
    options.parse_args()
    if os.environ.get("FAKE_DAEMON_FAILS"):
        sys.exit("this daemon has no devices")
    with FakeDaemon() as daemon:
        if "FAKE_DAEMON_HANGS" in os.environ:
            daemon.on("PUT", "/v1/scenes/room", hang)
        print(f"glintd: listening on {daemon.url}", flush=True)
        signal.sigwait({signal.SIGTERM})


if __name__ == "__main__":
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    main()
