"""A daemon whose state outlives its process: it can be killed, and started again on what it left."""
import os
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
from urllib.parse import urlsplit

import daemon


class Lasting(daemon.Daemon):
    """with Lasting() as d: ... d.kill(); d.start() ..."""

    def __init__(self, *options, environment=None, state=None):
        super().__init__(*options, environment=environment)
        self.given = state

    def __enter__(self):
        self.state = self.given or tempfile.mkdtemp(prefix="glint-test-")
        self.log = open(os.path.join(self.state, "log"), "a+", encoding="utf-8")
        self.process = None
        try:
            self.start()
        except BaseException:
            self.__exit__(True)
            raise
        return self

    def spawn(self, limits=None):
        return subprocess.Popen(
            [daemon.GLINTD, "--listen", "127.0.0.1:0", "--state", self.state, *self.options],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.log, text=True,
            env=self.environment, preexec_fn=limits)

    def start(self, limits=None):
        self.process = self.spawn(limits)
        self.url = self.read_url()
        self.port = urlsplit(self.url).port

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.process.stdout.close()

    def restart(self):
        """As an administrator does it."""
        code = self.stop()
        assert code == 0, f"it ended with {code}: {self.logged()[-4000:]}"
        self.start()

    def __exit__(self, *error):
        code = self.stop() if self.process and self.process.poll() is None else 0
        text = self.logged()
        self.log.close()
        if not self.given:
            shutil.rmtree(self.state, ignore_errors=True)
        if not any(error):
            assert code == 0, f"it ended with {code}: {text[-4000:]}"

    def refusal(self):
        """Starts it where it must not start: (exit code, what it said)."""
        before = len(self.logged())
        process = self.spawn()
        said = process.stdout.read()
        code = process.wait(daemon.PATIENCE)
        process.stdout.close()
        assert not said, said
        return code, self.logged()[before:]

    def path(self, *parts):
        return os.path.join(self.state, *parts)

    def films(self):
        return sorted(os.listdir(self.path("films")))

    def rows(self, query):
        """Of the journal, while nobody writes to it or whoever does lets others read."""
        connection = sqlite3.connect(f"file:{self.path('journal.db')}?mode=ro", uri=True)
        try:
            return connection.execute(query).fetchall()
        finally:
            connection.close()

    def wait(self, condition, what):
        end = time.monotonic() + daemon.PATIENCE
        while not condition():
            assert time.monotonic() < end, f"{what}: {self.logged()[-2000:]}"
            time.sleep(0.02)

    def patch(self, path, change):
        answer = self.ask("PATCH", path, daemon.json.dumps(change),
                          {"Content-Type": "application/merge-patch+json"})
        assert answer.status == 200, answer.body
        return answer
