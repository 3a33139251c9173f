#!/usr/bin/python3
"""glintd as a program: its command line, where it listens, how it ends."""
import json
import os
import resource
import select
import signal
import socket
import subprocess
import tempfile
import time

import tap
from daemon import GLINTD, PATIENCE, ROOM, Daemon


def run(*options, **environment):
    return subprocess.run([GLINTD, *options], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=PATIENCE, env={**os.environ, **environment})


def test_help_and_version_exit_0_and_start_nothing():
    text = run("--help")
    assert text.returncode == 0 and text.stderr == ""
    for option in ["--listen", "--state", "--threads", "--log-format", "--help", "--version"]:
        assert option in text.stdout
    version = run("--version")
    assert version.returncode == 0 and version.stdout.startswith("glintd ")


def test_wrong_usage_exits_64_and_names_the_fault():
    for options in [["--colour"], ["file.glb"], ["--threads", "0"], ["--threads", "257"],
                    ["--threads", "-1"], ["--threads", "2x"], ["--threads", ""], ["--threads"],
                    ["--log-format", "xml"], ["--state", ""], ["--listen", "7745"],
                    ["--listen", "127.0.0.1"], ["--listen", "127.0.0.1:"],
                    ["--listen", "127.0.0.1:70000"], ["--listen", "127.0.0.1:1x"],
                    ["--listen", "::1:7745"], ["--listen", ":7745"]]:
        ended = run(*options)
        assert ended.returncode == 64, (options, ended)
        assert ended.stdout == ""
        assert options[-1].strip("-") in ended.stderr, (options, ended.stderr)


def test_other_addresses_than_loopback_are_refused():
    with tempfile.TemporaryDirectory() as folder:
        state = os.path.join(folder, "state")
        for address in ["0.0.0.0:0", "[::]:0", "192.0.2.1:0", "[2001:db8::1]:0"]:
            ended = run("--listen", address, "--state", state)
            assert ended.returncode == 64, (address, ended)
            assert "loopback" in ended.stderr
            assert not os.path.exists(state), address


def test_a_port_in_use_exits_69():
    with socket.create_server(("127.0.0.1", 0)) as server, \
            tempfile.TemporaryDirectory() as state:
        port = server.getsockname()[1]
        ended = run("--listen", f"127.0.0.1:{port}", "--state", state)
        assert ended.returncode == 69 and str(port) in ended.stderr, ended


def test_a_state_folder_that_cannot_be_exits_74():
    with tempfile.NamedTemporaryFile() as file:
        ended = run("--listen", "127.0.0.1:0", "--state", os.path.join(file.name, "below"))
        assert ended.returncode == 74 and file.name in ended.stderr, ended


def test_it_serves_ipv6_loopback():
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError as error:
        raise tap.Skip("no IPv6") from error
    with tempfile.TemporaryDirectory() as state, subprocess.Popen(
            [GLINTD, "--listen", "[::1]:0", "--state", state], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            line = process.stdout.readline()
            assert line.startswith("glintd: listening on http://[::1]:"), line
            port = int(line.rsplit(":", 1)[1])
            with socket.create_connection(("::1", port), PATIENCE) as client:
                client.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                assert client.recv(64).startswith(b"HTTP/1.1 200 ")
        finally:
            process.terminate()
        assert process.wait(PATIENCE) == 0


def test_standard_output_is_one_line():
    with Daemon() as daemon:
        daemon.process.send_signal(signal.SIGTERM)
        ready, _, _ = select.select([daemon.process.stdout], [], [], PATIENCE)
        assert ready and daemon.process.stdout.read() == ""


def test_both_signals_end_it_with_0_while_a_job_renders():
    for number in [signal.SIGTERM, signal.SIGINT]:
        with Daemon("--threads", "2") as daemon:
            daemon.put("room", ROOM)
            job = daemon.submit(scene="room", stop={"samples": 1000000})
            daemon.until(job, lambda j: j["state"] == "rendering")
            daemon.process.send_signal(number)
            assert daemon.process.wait(PATIENCE) == 0


def test_a_second_signal_ends_it_at_once_with_1():
    with Daemon() as daemon:
        body = socket.create_connection(("127.0.0.1", daemon.port), PATIENCE)
        body.sendall(b"PUT /v1/scenes/a HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                     b"Content-Length: 1000\r\n\r\n{")  # under way: the drain waits for the rest
        daemon.wait_metric("glint_http_received_bytes_total", 1)
        daemon.process.send_signal(signal.SIGTERM)
        end = time.monotonic() + PATIENCE
        while "ending" not in daemon.logged():
            assert time.monotonic() < end
        daemon.process.send_signal(signal.SIGTERM)
        assert daemon.process.wait(PATIENCE) == 1
        body.close()
        daemon.process.returncode = 0  # it ended as it should


def test_json_logs_are_one_object_a_line():
    with Daemon("--log-format", "json") as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 1})
        daemon.frame(job)
        lines = [json.loads(line) for line in daemon.logged().splitlines()]
        assert {"time", "level", "category", "message"} <= set(lines[0])
        assert any(line.get("job_id") == job for line in lines)


def test_it_renders_on_as_many_threads_as_asked():
    with Daemon("--threads", "3") as daemon:
        assert daemon.metric("glint_workers") == 3
        names = set()
        for task in os.listdir(f"/proc/{daemon.process.pid}/task"):
            with open(f"/proc/{daemon.process.pid}/task/{task}/comm", encoding="utf-8") as file:
                names.add(file.read().strip())
        assert {"worker 0", "worker 1", "worker 2", "scheduler", "prepare"} <= names
        assert "worker 3" not in names


def test_compiled_kernels_are_cached_where_the_user_keeps_caches():
    with tempfile.TemporaryDirectory() as cache:
        before = os.environ.get("XDG_CACHE_HOME")
        os.environ["XDG_CACHE_HOME"] = cache
        try:
            with Daemon() as daemon:
                daemon.put("room", ROOM)
                daemon.frame(daemon.submit(scene="room", stop={"samples": 1}))
        finally:
            del os.environ["XDG_CACHE_HOME"]
            if before:
                os.environ["XDG_CACHE_HOME"] = before
        assert any(files for _, _, files in os.walk(os.path.join(cache, "glint")))


def test_clients_that_find_no_descriptor_wait_for_one():
    with Daemon() as daemon:
        room = len(os.listdir(f"/proc/{daemon.process.pid}/fd")) + 6
        resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE, (room, room))
        clients = [socket.create_connection(("127.0.0.1", daemon.port)) for _ in range(12)]
        for client in clients:
            client.sendall(b"GET /v1 HTTP/1.1\r\nHost: localhost\r\n\r\n")
        while clients:
            served = select.select(clients, [], [], PATIENCE)[0]
            assert served, len(clients)
            for client in served:
                assert client.recv(15) == b"HTTP/1.1 200 OK"
                client.close()
                clients.remove(client)


if __name__ == "__main__":
    tap.main()
