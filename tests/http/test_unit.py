#!/usr/bin/python3
"""The units of glintd for systemd: they are well formed, closed, and the daemon works under them."""
import os
import re
import subprocess
import sys
import tempfile

import tap
from daemon import GLINTD, PATIENCE, ROOM, Daemon, triangle_glb

THRESHOLD = 20  # tenths of systemd's exposure level


def unit_text(binary=GLINTD):
    with open(tap.source("deploy", "systemd", "glintd.service.in"), encoding="utf-8") as file:
        return file.read().replace("@bindir@/glintd", binary)


def unit_file(folder, *more, binary=GLINTD):
    """The service with drop-ins behind it, and its socket beside it."""
    text = unit_text(binary)
    for name in more:
        with open(tap.source("deploy", "systemd", name), encoding="utf-8") as file:
            text += file.read()
    path = os.path.join(folder, "glintd.service")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    with open(tap.source("deploy", "systemd", "glintd.socket"), "rb") as source, \
            open(os.path.join(folder, "glintd.socket"), "wb") as target:
        target.write(source.read())
    return path


def analyze(*arguments):
    return subprocess.run([tap.tool("systemd-analyze"), "--no-pager", *arguments],
                          capture_output=True, text=True, timeout=PATIENCE,
                          env={**os.environ, "SYSTEMD_LOG_LEVEL": "warning"})


def exposure(path):
    told = analyze("security", "--offline=true", f"--threshold={THRESHOLD}", path)
    assert told.returncode == 0, told.stdout + told.stderr
    return float(re.search(r"Overall exposure level for glintd.service: ([\d.]+)", told.stdout)[1])


def test_systemd_finds_no_fault_in_the_units():
    with tempfile.TemporaryDirectory() as folder:
        service = unit_file(folder)
        told = analyze("verify", "--man=no", service, os.path.join(folder, "glintd.socket"))
        assert told.returncode == 0 and told.stderr == "", told.stderr


def test_the_service_is_closed_and_graphics_cards_open_little():
    with tempfile.TemporaryDirectory() as folder:
        plain = exposure(unit_file(folder))
        cards = exposure(unit_file(folder, "glintd-gpu.conf"))
        print(f"exposure {plain}, with graphics cards {cards}")
        assert plain < cards <= THRESHOLD / 10


def test_the_service_manager_is_told_what_the_unit_waits_for():
    text = unit_text()
    for line in ["Type=notify", "WatchdogSec=30", "ExecReload=/bin/kill -HUP $MAINPID"]:
        assert f"\n{line}\n" in text, line
    # It asks for more time in steps that are shorter than what it is given.
    assert int(re.search(r"\nTimeoutStopSec=(\d+)\n", text)[1]) >= 20


class Sandbox:
    """Starts programs as the unit has them run. Skips where the machine does not let it."""

    def __enter__(self):
        tap.tool("systemd-analyze")
        self.folder = tempfile.TemporaryDirectory()
        self.unit = unit_file(self.folder.name)
        self.cache = os.path.join(self.folder.name, "cache")
        os.mkdir(self.cache)
        tried = self.run("/bin/true")
        if tried.returncode:
            raise tap.Skip(tried.stderr.strip())
        return self

    def __exit__(self, *error):
        self.folder.cleanup()

    def command(self, writable, *command):
        return [sys.executable, tap.source("tests", "http", "sandbox.py"), self.unit, *writable,
                "--", *command]

    def run(self, *command):
        return subprocess.run(self.command([self.cache], *command), capture_output=True, text=True,
                              timeout=PATIENCE)

    def launch(self, command, env=None, **options):
        state = command[command.index("--state") + 1]
        # A build with a sanitizer may look for leaks only where it may trace, which is closed here.
        asan = env.get("ASAN_OPTIONS", "") + ":detect_leaks=0"
        return subprocess.Popen(self.command([state, self.cache], *command),
                                env={**env, "CACHE_DIRECTORY": self.cache, "HOME": "/nowhere",
                                     "ASAN_OPTIONS": asan}, **options)


def test_the_sandbox_holds():
    writes_and_executes = ("import mmap; mmap.mmap(-1, 4096, prot=mmap.PROT_READ | "
                           "mmap.PROT_WRITE | mmap.PROT_EXEC)")
    with Sandbox() as sandbox:
        python = "/usr/bin/python3"
        for text, fault in [("open('/usr/x', 'w')", "Read-only file system"),
                            ("open('/var/tmp/x', 'w')", "Read-only file system"),
                            (writes_and_executes, "Operation not permitted"),
                            ("import socket; socket.socket(socket.AF_PACKET)", "not supported"),
                            ("import os; os.nice(-1)", "not permitted"),
                            ("import os; os.chown('/', 1, 1)", "not permitted"),
                            ("import ctypes, os\nif ctypes.CDLL(None, use_errno=True)"
                             ".unshare(0x10000000): raise OSError(os.strerror(ctypes.get_errno()))",
                             "not permitted")]:
            ended = sandbox.run(python, "-c", text)
            assert ended.returncode == 1 and fault in ended.stderr, (text, ended)
        ended = sandbox.run(python, "-c", f"open('{sandbox.cache}/x', 'w')")
        assert ended.returncode == 0, ended


def test_it_imports_compiles_and_renders_under_the_unit():
    with Sandbox() as sandbox, Daemon("--threads", "2", launch=sandbox.launch) as daemon:
        daemon.put("room", ROOM)
        daemon.put("sail", triangle_glb())
        for scene in ["room", "sail"]:
            job = daemon.submit(scene=scene, stop={"samples": 2})
            assert daemon.frame(job)[:4] == b"\x76\x2f\x31\x01"
            assert daemon.job(job)["state"] == "done"
        assert os.listdir(sandbox.cache), "kernels were compiled elsewhere"
        with open(f"/proc/{daemon.process.pid}/status", encoding="ascii") as file:
            status = file.read()
        for line in ["NoNewPrivs:\t1", "Seccomp:\t2", "CapEff:\t0000000000000000",
                     "CapBnd:\t0000000000000000"]:
            assert line in status, (line, status)


if __name__ == "__main__":
    tap.main()
