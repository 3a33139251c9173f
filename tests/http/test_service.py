#!/usr/bin/python3
"""glintd under a service manager, whose part the test plays: what it is told and when, sockets that
it hands over, signals, settings that are read again, the watchdog."""
import contextlib
import ctypes
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

import tap
from daemon import GLINTD, PATIENCE, ROOM, Daemon


class Manager:
    """The end of $NOTIFY_SOCKET that a service manager holds."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = os.path.join(self.folder.name, "notify")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.path)
        self.socket.settimeout(PATIENCE)
        return self

    def __exit__(self, *error):
        self.socket.close()
        self.folder.cleanup()

    def message(self):
        text = self.socket.recv(65536).decode()
        return dict(line.split("=", 1) for line in text.splitlines())

    def until(self, name):
        """The next message that has this variable."""
        while name not in (message := self.message()):
            pass
        return message

    def rest(self):
        """What has been sent and not read."""
        self.socket.setblocking(False)
        messages = []
        with contextlib.suppress(BlockingIOError):
            while True:
                messages.append(self.message())
        self.socket.settimeout(PATIENCE)
        return messages


def wait_log(daemon, words):
    end = time.monotonic() + PATIENCE
    while words not in daemon.logged():
        assert time.monotonic() < end, f"no {words!r} in {daemon.logged()}"
        time.sleep(0.01)


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def test_it_is_ready_once_it_can_serve_and_says_when_it_stops():
    with Manager() as manager:
        with Daemon("--threads", "1", environment={"NOTIFY_SOCKET": manager.path}) as daemon:
            ready = manager.message()
            assert ready["READY"] == "1" and daemon.url in ready["STATUS"]
            assert daemon.get("/readyz").status == 200
            daemon.process.send_signal(signal.SIGTERM)
            assert manager.until("STOPPING")["STOPPING"] == "1"
            extended = manager.until("EXTEND_TIMEOUT_USEC")
            assert int(extended["EXTEND_TIMEOUT_USEC"]) >= 10**7
            assert daemon.process.wait(PATIENCE) == 0
        assert not any("READY" in message for message in manager.rest())


def test_a_start_that_fails_says_why_and_is_never_ready():
    with Manager() as manager, socket.create_server(("127.0.0.1", 0)) as server, \
            tempfile.TemporaryDirectory() as state:
        ended = subprocess.run(
            [GLINTD, "--listen", f"127.0.0.1:{server.getsockname()[1]}", "--state", state],
            capture_output=True, timeout=PATIENCE,
            env={**os.environ, "NOTIFY_SOCKET": manager.path})
        assert ended.returncode == 69
        messages = manager.rest()
        assert "in use" in messages[-1]["STATUS"], messages
        assert not any("READY" in message for message in messages)


def passing(*sockets, names=None, pid=None):
    """Starts a program as a service manager does that has opened its sockets."""
    def prepare():
        spare = [os.dup(s.fileno()) for s in sockets]  # out of the way of 3, 4, ...
        high = [os.dup2(fd, 100 + i) for i, fd in enumerate(spare)]
        for i, fd in enumerate(high):
            os.dup2(fd, 3 + i, inheritable=True)

    def launch(command, env=None, **options):
        env = {**env, "LISTEN_FDS": str(len(sockets))}
        if names:
            env["LISTEN_FDNAMES"] = ":".join(names)
        script = f'LISTEN_PID={pid or "$$"}; export LISTEN_PID; exec "$@"'
        return subprocess.Popen(["/bin/sh", "-c", script, "sh", *command], env=env,
                                preexec_fn=prepare, close_fds=False, **options)
    return launch


def test_it_serves_the_socket_that_is_handed_over():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        # Who comes before it serves waits in the socket's queue and is not refused.
        early = socket.create_connection(("127.0.0.1", port), PATIENCE)
        early.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        with Daemon("--threads", "1", launch=passing(server, names=["anything"])) as daemon:
            assert daemon.port == port
            assert early.recv(12) == b"HTTP/1.1 200"
            early.close()
            listening = os.readlink(f"/proc/{daemon.process.pid}/fd/3")
            assert listening.startswith("socket:"), listening
            with open(f"/proc/{daemon.process.pid}/environ", "rb") as file:
                assert b"LISTEN_FDS" in file.read()  # it was not merely lucky


def test_of_several_sockets_it_serves_the_one_named_http():
    with socket.create_server(("127.0.0.1", 0)) as other, \
            socket.create_server(("127.0.0.1", 0)) as server:
        with Daemon("--threads", "1", launch=passing(other, server, names=["x", "http"])) as daemon:
            assert daemon.port == server.getsockname()[1]


def test_sockets_of_another_process_are_left_alone():
    with socket.create_server(("127.0.0.1", 0)) as server:
        with Daemon("--threads", "1", launch=passing(server, pid=1)) as daemon:
            assert daemon.port != server.getsockname()[1]


def refuses(launch):
    with tempfile.TemporaryDirectory() as state:
        process = launch([GLINTD, "--state", state], env=dict(os.environ), text=True,
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        _, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 64, (process.returncode, said)
        assert not os.listdir(state)
        return said


def test_what_is_no_listening_tcp_socket_on_loopback_is_refused():
    with socket.socket() as deaf, socket.socket(type=socket.SOCK_DGRAM) as datagram, \
            socket.socket(socket.AF_UNIX) as local, open(os.devnull, "rb") as file, \
            socket.create_server(("127.0.0.1", 0)) as one, \
            socket.create_server(("0.0.0.0", 0)) as everywhere:
        deaf.bind(("127.0.0.1", 0))
        datagram.bind(("127.0.0.1", 0))
        for thing in [deaf, datagram, local, file]:
            assert "no listening TCP socket" in refuses(passing(thing)), thing
        assert "loopback" in refuses(passing(everywhere))
        assert "named http" in refuses(passing(one, everywhere, names=["a", "b"]))


def test_settings_come_from_a_file_and_the_command_line_counts_more():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "glintd.conf")
        write(path, "# two\nthreads = 2\nstreams = 7\nscene_bytes = 3M\n")
        with Daemon("--config", path, "--threads", "1") as daemon:
            told = daemon.get("/v1").json()
            assert told["devices"][0]["workers"] == 1
            assert told["limits"]["streams"] == 7
            assert told["limits"]["scene_bytes"] == 3 << 20
        with Daemon(environment={"CONFIGURATION_DIRECTORY": folder}) as daemon:
            assert daemon.get("/v1").json()["devices"][0]["workers"] == 2


def test_every_fault_of_a_settings_file_is_named_and_it_exits_78():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "glintd.conf")
        write(path, "threads = 0\n\nstreems = 7\nscene_bytes = many\nlog_level\n")
        for options in [["--config", path], ["--config", os.path.join(folder, "none")]]:
            ended = subprocess.run([GLINTD, *options, "--listen", "127.0.0.1:0"],
                                   capture_output=True, text=True, timeout=PATIENCE)
            assert ended.returncode in (74, 78), ended
            assert ended.stdout == ""
        write(path, "threads = 0\n\nstreems = 7\nscene_bytes = many\n")
        ended = subprocess.run([GLINTD, "--config", path], capture_output=True, text=True,
                               timeout=PATIENCE)
        assert ended.returncode == 78, ended
        for line, word in [(1, "threads"), (3, "streems"), (4, "scene_bytes")]:
            assert f"glintd.conf:{line}: {word}" in ended.stderr, ended.stderr


def test_sighup_reads_settings_again_and_a_bad_file_changes_nothing():
    with tempfile.TemporaryDirectory() as folder, Manager() as manager:
        path = os.path.join(folder, "glintd.conf")
        write(path, "streams = 7\n")

        def reload():
            before = time.clock_gettime_ns(time.CLOCK_MONOTONIC) // 1000
            daemon.process.send_signal(signal.SIGHUP)
            began = manager.until("RELOADING")
            assert before <= int(began["MONOTONIC_USEC"]) <= before + PATIENCE * 10**6
            return manager.until("READY")["STATUS"]

        with Daemon("--config", path, "--threads", "1",
                    environment={"NOTIFY_SOCKET": manager.path}) as daemon:
            write(path, "streams = 9\nthreads = 2\nlog_level = debug\n")
            assert "serving" in reload()
            limits = daemon.get("/v1").json()["limits"]
            assert limits["streams"] == 9
            # The command line counts more than the file: it has not changed.
            assert "threads cannot change" not in daemon.logged()
            wait_log(daemon, "GET /v1: 200")  # the new level

            write(path, "streams = 11\nlisten = 127.0.0.1:1\nconnections = none\n")
            status = reload()
            assert "glintd.conf:3: connections" in status, status
            assert "glintd.conf:3: connections" in daemon.logged()
            assert daemon.get("/v1").json()["limits"]["streams"] == 9

            write(path, "streams = 11\nstate = /nowhere\n")
            reload()
            assert daemon.get("/v1").json()["limits"]["streams"] == 11


def test_what_cannot_change_while_it_runs_is_named():
    with tempfile.TemporaryDirectory() as folder, Manager() as manager:
        path = os.path.join(folder, "glintd.conf")
        write(path, "threads = 1\n")
        with Daemon("--config", path, environment={"NOTIFY_SOCKET": manager.path}) as daemon:
            write(path, "threads = 2\nlog_format = json\ntoken_file = /dev/null\n")
            daemon.process.send_signal(signal.SIGHUP)
            manager.until("RELOADING")
            manager.until("READY")
            for name in ["threads", "log_format", "token_file"]:
                assert f"{name} cannot change while the daemon runs" in daemon.logged()
            assert daemon.get("/v1").json()["devices"][0]["workers"] == 1


def test_limits_that_are_lowered_hold_from_the_next_request_on():
    with tempfile.TemporaryDirectory() as folder, Manager() as manager:
        path = os.path.join(folder, "glintd.conf")
        write(path, "")
        with Daemon("--config", path, "--threads", "1",
                    environment={"NOTIFY_SOCKET": manager.path}) as daemon:
            daemon.put("room", ROOM)
            write(path, "scene_bytes = 1K\n")
            daemon.process.send_signal(signal.SIGHUP)
            manager.until("RELOADING")
            manager.until("READY")
            answer = daemon.ask("PUT", "/v1/scenes/room", json.dumps(ROOM),
                                {"Content-Type": "application/json"})
            assert answer.status == 413, answer.body


def test_the_watchdog_is_told_in_time_while_everything_comes_round():
    period = 0.4
    with Manager() as manager:
        environment = {"NOTIFY_SOCKET": manager.path, "WATCHDOG_USEC": str(int(period * 1e6))}
        with Daemon("--threads", "1", environment=environment) as daemon:
            daemon.put("room", ROOM)
            daemon.submit(scene="room", stop={"samples": 100000})
            for _ in range(6):
                manager.until("WATCHDOG")
            while "jobs: 1 rendering" not in manager.until("STATUS")["STATUS"]:
                pass
            daemon.process.send_signal(signal.SIGTERM)
            manager.until("STOPPING")
            assert daemon.process.wait(PATIENCE) == 0
        assert not any("WATCHDOG" in message for message in manager.rest())


def threads(process, name):
    """Ids of the threads of this name."""
    tasks = f"/proc/{process.pid}/task"
    for tid in os.listdir(tasks):
        with open(f"{tasks}/{tid}/comm", encoding="utf-8") as file:
            if file.read().strip() == name:
                yield int(tid)


PTRACE_SEIZE, PTRACE_INTERRUPT, PTRACE_DETACH = 0x4206, 0x4207, 17


@contextlib.contextmanager
def halted(tid):
    """One thread that runs no more, as if it were in an endless wait."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    if libc.ptrace(PTRACE_SEIZE, tid, None, None):
        raise tap.Skip(f"no ptrace: {os.strerror(ctypes.get_errno())}")
    libc.ptrace(PTRACE_INTERRUPT, tid, None, None)
    os.waitpid(tid, 0x40000000)  # __WALL
    try:
        yield
    finally:
        libc.ptrace(PTRACE_DETACH, tid, None, None)


def wait_silence(manager, period, periods):
    """Until the watchdog was told nothing in so many periods on end: what was answered before may
    still be on its way."""
    end, silent = time.monotonic() + PATIENCE, 0
    while silent < periods:
        assert time.monotonic() < end, "it is told all the time"
        manager.rest()
        time.sleep(period)
        told = any("WATCHDOG" in message for message in manager.rest())
        silent = 0 if told else silent + 1


def silenced_by(tid, manager, period, periods):
    manager.until("WATCHDOG")
    with halted(tid):
        wait_silence(manager, period, periods)
    manager.until("WATCHDOG")  # it goes on


def test_the_watchdog_is_not_told_while_one_of_them_hangs():
    period = 0.4
    with Manager() as manager:
        environment = {"NOTIFY_SOCKET": manager.path, "WATCHDOG_USEC": str(int(period * 1e6))}
        with Daemon("--threads", "1", environment=environment) as daemon:
            for name in ["scheduler", "journal"]:
                tid = next(threads(daemon.process, name))
                silenced_by(tid, manager, period, 3)
            clients = [socket.create_connection(("127.0.0.1", daemon.port)) for _ in range(32)]
            for client in clients[::2]:  # descriptors that are free are even, or odd
                client.close()
            for tid in threads(daemon.process, "MHD-worker"):  # two: each is asked every other time
                silenced_by(tid, manager, period, 1)
            for client in clients[1::2]:
                client.close()


def test_without_a_watchdog_nothing_is_told():
    with Manager() as manager:
        with Daemon("--threads", "1", environment={"NOTIFY_SOCKET": manager.path}):
            pass
        assert not any("WATCHDOG" in message for message in manager.rest())


def films(daemon):
    """Files of films in the state folder that are whole."""
    folder = os.path.join(daemon.state, "films")
    return [name for name in os.listdir(folder) if re.fullmatch(r"[0-9a-f]+\.\d+", name)]


def test_sigusr1_has_films_written_now():
    with Daemon("--threads", "1", "--checkpoint-seconds", "86400") as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 100000})
        daemon.until(job, lambda data: data["samples"] > 0)
        assert films(daemon) == []
        daemon.process.send_signal(signal.SIGUSR1)
        end = time.monotonic() + PATIENCE
        while not films(daemon):
            assert time.monotonic() < end, "no film"
            time.sleep(0.01)
        assert films(daemon)[0].startswith(job)
        assert daemon.job(job)["state"] == "rendering"


def test_what_renders_when_it_is_told_to_end_goes_on_when_it_is_started_again():
    with tempfile.TemporaryDirectory() as state:
        def start():
            return Daemon("--threads", "1", "--state", state, "--checkpoint-seconds", "86400")
        with start() as daemon:
            daemon.put("room", ROOM)
            job = daemon.submit(scene="room", stop={"samples": 100000})
            reached = daemon.until(job, lambda data: data["samples"] > 3)["samples"]
        with start() as daemon:
            found = daemon.job(job)
            assert found["state"] in ("queued", "rendering"), found
            daemon.until(job, lambda data: data["samples"] >= reached)
            assert daemon.ask("DELETE", f"/v1/jobs/{job}").status == 202


def test_a_stream_that_is_open_ends_well_when_it_drains():
    with Daemon("--threads", "1") as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 100000})
        with daemon.connect(f"/v1/jobs/{job}/events") as events, \
                daemon.connect(f"/v1/jobs/{job}/tiles") as tiles:
            next(events.events())
            next(tiles.parts())
            daemon.process.send_signal(signal.SIGTERM)
            # To the end of the chunked body: one that is cut raises IncompleteRead.
            tiles.response.read()
            events.response.read()
            assert daemon.process.wait(PATIENCE) == 0
            with contextlib.suppress(ConnectionError):
                daemon.dial().close()
                raise AssertionError("it still listens")


def accepts(daemon):
    try:
        daemon.dial().close()
    except ConnectionError:
        return False
    return True


def test_it_is_not_ready_while_it_drains_and_a_second_signal_exits_1_at_once():
    with Daemon("--threads", "1", "--drain-seconds", "600") as daemon:
        daemon.put("room", ROOM)
        # A request that is never complete, so that draining waits for it.
        with daemon.dial() as half, daemon.dial() as open_before:
            open_before.sendall(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            assert open_before.recv(65536).startswith(b"HTTP/1.1 200")
            half.sendall(b"PUT /v1/scenes/x HTTP/1.1\r\nHost: localhost\r\n"
                         b"Content-Type: application/json\r\nContent-Length: 100\r\n\r\n{")
            daemon.wait_metric("glint_http_received_bytes_total",
                               len(json.dumps(ROOM)) + 1)
            daemon.process.send_signal(signal.SIGTERM)
            wait_log(daemon, "signal 15: ending")
            assert daemon.process.poll() is None
            end = time.monotonic() + PATIENCE
            while accepts(daemon):
                assert time.monotonic() < end
            # Who is connected already is told that it takes no more.
            open_before.sendall(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            assert open_before.recv(65536).startswith(b"HTTP/1.1 503")
            daemon.process.send_signal(signal.SIGINT)
            assert daemon.process.wait(PATIENCE) == 1
        raise_nothing(daemon)


def raise_nothing(daemon):
    """Its exit code has been checked: that is not 0."""
    daemon.stop = lambda: 0
    daemon.process.stdout.close()


def test_log_lines_follow_a_job_from_its_request_to_its_end():
    trace = "4bf92f3577b34da6a3ce929d0e0e4736"
    with Daemon("--threads", "1", "--log-format", "json", "--log-level", "debug") as daemon:
        daemon.put("room", ROOM)
        answer = daemon.post({"scene": "room", "resolution": [64, 48], "stop": {"samples": 1}},
                             {"X-Request-Id": "follow-me", "Glint-Client": "alice",
                              "traceparent": f"00-{trace}-00f067aa0ba902b7-01"})
        job = answer.json()["id"]
        daemon.frame(job)
        assert daemon.get("/v1/jobs/none?x=1").status in (404, 422)
        daemon.stop()
        lines = [json.loads(line) for line in daemon.logged().splitlines()]
    posted = [line for line in lines if line.get("request_id") == "follow-me"
              and line["category"] == "http"]
    assert len(posted) == 1, posted
    line = posted[0]
    assert line["level"] == "info"
    assert line["method"] == "POST" and line["path"] == "/v1/jobs" and line["status"] == 202
    assert line["client"] == "alice" and line["trace_id"] == trace and line["job_id"] == job
    assert line["bytes"] == len(answer.body) and 0 < line["seconds"] < PATIENCE
    frame = [line for line in lines if line.get("path", "").endswith("/frame.exr")]
    assert frame[0]["level"] == "debug" and frame[0]["status"] == 200 and frame[0]["job_id"] == job
    of_job = [line for line in lines if line.get("job_id") == job and line["category"] == "jobs"]
    assert of_job and all(line.get("request_id") == "follow-me" for line in of_job), of_job
    assert any(line["message"].startswith("done after") for line in of_job), of_job
    assert all(re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", line["time"]) for line in lines)


def test_lines_have_a_priority_and_only_those_wanted_are_written():
    with Daemon("--threads", "1", "--log-level", "warning") as daemon:
        daemon.put("room", ROOM)
        daemon.stop()
        assert daemon.logged() == "", daemon.logged()
    with Daemon("--threads", "1") as daemon:
        daemon.put("room", ROOM)
        daemon.get("/v1")
        # What stands in a path is no field of the line.
        daemon.delete("/v1/jobs/x%20client=root%0a%3C3%3Eforged")
        daemon.stop()
        text = daemon.logged()
    assert re.search(r"^<6>http request=[0-9a-f]+ trace=[0-9a-f]{32}: PUT /v1/scenes/room: 201, ",
                     text, re.M), text
    assert "GET /v1" not in text
    assert not re.search(r"client=root[^:]*: DELETE|^<3>", text, re.M), text


# Stands in for systemd: a /run of its own where the journal's socket is the test's.
JOURNAL = """
import ctypes, os, sys
libc = ctypes.CDLL(None, use_errno=True)
if libc.unshare(0x20000) or libc.mount(b"none", b"/", None, 0x44000, None) or \\
        libc.mount(b"tmpfs", b"/run", b"tmpfs", 0, None):
    sys.exit(77)
os.makedirs("/run/systemd/journal")
os.symlink(sys.argv[1], "/run/systemd/journal/socket")
at = os.fstat(2)
os.environ["JOURNAL_STREAM"] = f"{at.st_dev}:{at.st_ino}"
os.execv(sys.argv[2], sys.argv[2:])
"""


def entry(datagram):
    """The fields of an entry in the journal's native format, short values only."""
    return dict(line.split("=", 1) for line in datagram.decode().splitlines())


def test_lines_are_entries_with_fields_where_standard_error_is_the_journals():
    with tempfile.TemporaryDirectory() as folder, \
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as journal:
        path = os.path.join(folder, "journal")
        journal.bind(path)
        journal.settimeout(PATIENCE)
        launched = [sys.executable, "-c", JOURNAL, path]
        if subprocess.run([*launched, "/bin/true"], timeout=PATIENCE).returncode:
            raise tap.Skip("no mount namespace")

        def launch(command, **options):
            return subprocess.Popen([*launched, *command], **options)

        with Daemon("--threads", "1", launch=launch) as daemon:
            daemon.put("room", ROOM, **{"X-Request-Id": "r1", "Glint-Client": "alice"})
            job = daemon.submit(scene="room", stop={"samples": 1})
            daemon.frame(job)
            daemon.stop()
            assert daemon.logged() == ""
        journal.setblocking(False)
        entries = []
        with contextlib.suppress(BlockingIOError):
            while True:
                entries.append(entry(journal.recv(65536)))
    put = next(e for e in entries if e.get("GLINT_PATH") == "/v1/scenes/room")
    assert put["REQUEST_ID"] == "r1" and put["PRIORITY"] == "6" and put["GLINT_STATUS"] == "201"
    assert put["GLINT_CLIENT"] == "alice" and len(put["TRACE_ID"]) == 32
    assert put["SYSLOG_IDENTIFIER"] == "glintd" and put["MESSAGE"].startswith("PUT /v1/scenes/room")
    assert any(e.get("JOB_ID") == job and e["GLINT_CATEGORY"] == "jobs" for e in entries)


if __name__ == "__main__":
    tap.main()
