"""Streams of tiles and events, with readers that are fast, slow, gone or late."""
import contextlib
import http.client
import json
import os
import re
import signal
import socket
import struct
import time

import tap
from daemon import PATIENCE, ROOM, Daemon
from lasting import Lasting

SIZE = (256, 192)


def submit(daemon, samples):
    return daemon.submit(scene="room", resolution=SIZE, stop={"samples": samples})


def rectangle(headers):
    return tuple(map(int, headers["Glint-Tile"].split()))


def windows(exr):
    """dataWindow and displayWindow of a scanline EXR."""
    found = {}
    for name in (b"dataWindow", b"displayWindow"):
        at = exr.index(name + b"\0box2i\0") + len(name) + 7
        found[name] = struct.unpack("<4i", exr[at + 4:at + 20])
    return found[b"dataWindow"], found[b"displayWindow"]


def without_complete(exr):
    """The file but for whether the whole frame was complete when the tile was sent."""
    head, name, rest = exr.partition(b"glint/complete\0int\0")
    assert name
    return head + rest[8:]


def contents(tiles):
    return {rectangle: without_complete(body) for rectangle, (_, body) in tiles.items()}


def read_tiles(stream):
    """{rectangle: (headers, body)} of the newest tiles, how many came, and the last's sequence."""
    newest, count, last = {}, 0, 0
    for headers, body in stream.parts():
        sequence = int(headers["Glint-Seq"])
        assert sequence > last
        newest[rectangle(headers)], count, last = (headers, body), count + 1, sequence
    assert stream.ended
    return newest, count, last


def logged_streams(daemon, count):
    """What the log says of so many streams that are over."""
    end = time.monotonic() + PATIENCE
    while True:
        lines = [line for line in daemon.logged().splitlines() if "/tiles: 200, " in line]
        if len(lines) == count:
            return lines
        assert time.monotonic() < end, lines


def test_a_finished_job_streams_all_its_tiles_once():
    with Daemon(environment={"GLINT_DEBUG": "http"}) as daemon:
        revision = daemon.put("room", ROOM).json()["revision"]
        job = submit(daemon, 4)
        daemon.frame(job)
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            newest, count, last = read_tiles(stream)
        assert count == len(newest)
        assert sum(w * h for _, _, w, h in newest) == SIZE[0] * SIZE[1]
        for (x, y, w, h), (headers, body) in newest.items():
            assert headers["Content-Type"] == "image/x-exr"
            assert headers["Glint-Revision"] == revision and headers["Glint-Samples"] == "4"
            assert windows(body) == ((x, y, x + w - 1, y + h - 1),
                                     (0, 0, SIZE[0] - 1, SIZE[1] - 1))
        with daemon.connect(f"/v1/jobs/{job}/tiles?since={last}") as stream:
            assert not list(stream.parts()) and stream.ended
        assert not [line for line in logged_streams(daemon, 2) if "connection lost" in line]


def test_a_stream_from_the_start_ends_with_what_the_finished_job_has():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 32)
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            live, _, _ = read_tiles(stream)
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            final, _, _ = read_tiles(stream)
        assert contents(live) == contents(final)


def test_a_slow_reader_misses_versions_and_ends_with_the_newest():
    with Daemon("--idle-seconds", str(round(10 * PATIENCE))) as daemon:  # it stands still all the while
        daemon.put("room", ROOM)
        job = submit(daemon, 128)
        with daemon.connect(f"/v1/jobs/{job}/tiles", receive_buffer=4096) as slow, \
                daemon.connect(f"/v1/jobs/{job}/tiles") as fast:
            quick, many, _ = read_tiles(fast)  # meanwhile nobody reads the slow one
            late, few, _ = read_tiles(slow)
        assert few < many, (few, many)
        assert contents(late) == contents(quick)


def test_readers_that_leave_are_noticed():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 1000000)
        daemon.until(job, lambda j: j["samples"] > 0)
        streams = [daemon.connect(f"/v1/jobs/{job}/{kind}") for kind in ("tiles", "events") * 4]
        for number, stream in enumerate(streams):
            if number % 3:
                stream.line()
            if number % 2:
                stream.reset()
            else:
                stream.close()
        daemon.wait_metric("glint_http_streams", 0)
        daemon.delete(f"/v1/jobs/{job}")


def test_events_tell_state_progress_and_the_end():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 512)
        with daemon.connect(f"/v1/jobs/{job}/events") as stream:
            assert stream.response.headers["Content-Type"] == "text/event-stream"
            events, ids = [], []
            for event in stream.events():
                events.append(event)
                ids.append(int(stream.last_id))
            last = stream.last_id
        assert ids == sorted(set(ids))
        names = [name for name, _ in events]
        assert names[0] == "state" and names[-1] == "done" and "progress" in names
        progress = [data["progress"] for name, data in events if name == "progress"]
        assert progress == sorted(progress) and 0 <= progress[0] <= progress[-1] <= 1
        assert events[-1][1]["state"] == "done" and events[-1][1]["id"] == job
        path = f"/v1/jobs/{job}/events"
        assert daemon.get(path, {"Last-Event-ID": last}).status == 204
        with daemon.connect(path, {"Last-Event-ID": str(int(last) - 1)}) as stream:
            assert [name for name, _ in stream.events()] == ["done"]
        with daemon.connect(path, {"Last-Event-ID": "1"}) as stream:
            assert [name for name, _ in stream.events()] == ["reset", "done"]


def test_the_end_is_told_to_who_was_cut_off_before_it():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 1)
        daemon.frame(job)
        path = f"/v1/jobs/{job}/events"
        for start, first in (({}, "state"), ({"Last-Event-ID": "1"}, "reset")):
            with daemon.connect(path, start) as stream:
                name, _ = next(stream.events())
                before = stream.last_id
            assert name == first
            with daemon.connect(path, {"Last-Event-ID": before}) as stream:
                assert [(name, data["state"]) for name, data in stream.events()] \
                    == [("done", "done")]
                assert int(stream.last_id) > int(before)


def switches(daemon, thread):
    """How often a thread of the daemon has waited."""
    tasks = f"/proc/{daemon.process.pid}/task"
    for task in os.listdir(tasks):
        with open(f"{tasks}/{task}/comm", encoding="ascii") as comm:
            if comm.read().strip() != thread:
                continue
        with open(f"{tasks}/{task}/status", encoding="ascii") as status:
            return int(re.search(r"^voluntary_ctxt_switches:\s+(\d+)", status.read(), re.M)[1])
    raise AssertionError(f"there is no thread {thread}")


def rate_of_watch(daemon, job):
    """Times a second that the watcher wakes over a second of rendering."""
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", daemon.port)) as connection:
        def samples():
            connection.request("GET", f"/v1/jobs/{job}")
            return json.load(connection.getresponse())["samples"]
        while not samples():
            pass
        start, before, first = time.monotonic(), switches(daemon, "http-watch"), samples()
        while time.monotonic() < start + 1 or samples() == first:
            pass
        return (switches(daemon, "http-watch") - before) / (time.monotonic() - start)


def test_a_job_that_nobody_watches_does_not_wake_the_watcher():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", resolution=[64, 64], stop={"samples": 1000000})
        assert rate_of_watch(daemon, job) < 10  # its own rounds are 4 a second
        daemon.delete(f"/v1/jobs/{job}")


def resident(daemon):
    """Megabytes of memory of its own."""
    with open(f"/proc/{daemon.process.pid}/status", encoding="ascii") as status:
        return int(re.search(r"^RssAnon:\s+(\d+)", status.read(), re.M)[1]) / 1024


def instrumented(daemon):
    """A sanitizer keeps memory of its own, more than what is measured here."""
    with open(f"/proc/{daemon.process.pid}/maps", encoding="utf-8") as maps:
        return re.search(r"lib[at]san\.so", maps.read())


def descriptors(daemon):
    return len(os.listdir(f"/proc/{daemon.process.pid}/fd"))


def threads(daemon):
    return len(os.listdir(f"/proc/{daemon.process.pid}/task"))


def test_clients_that_read_nothing_cost_little_and_hold_nobody_up():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 1000000)
        with daemon.connect(f"/v1/jobs/{job}/tiles") as fast, contextlib.ExitStack() as stalled:
            parts = fast.parts()
            for _ in range(24):
                next(parts)
            before = resident(daemon)
            for _ in range(100):
                stalled.enter_context(daemon.connect(f"/v1/jobs/{job}/tiles", receive_buffer=4096))
            received = sum(len(body) for _, (_, body) in zip(range(120), parts))
            daemon.wait_metric("glint_http_streams", 101)
            # A copy of what the fast one was sent for each of them would be hundreds.
            if not instrumented(daemon):
                assert resident(daemon) - before < 12, (before, resident(daemon), received)
            assert received > 1 << 19
        daemon.wait_metric("glint_http_streams", 0)
        daemon.delete(f"/v1/jobs/{job}")


def come_and_go(daemon, job, number):
    """Opens a stream, perhaps reads a little, and leaves in one of several ways."""
    stream = daemon.dial()
    kind = ("tiles", "events")[number % 2]
    stream.sendall(f"GET /v1/jobs/{job}/{kind} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    if number % 3:
        stream.recv(1 << number % 16)
    if number % 5 < 2:
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    stream.close()


def test_clients_that_come_and_go_leave_nothing_behind():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 1000000)
        daemon.until(job, lambda j: j["samples"] > 0)
        used = []
        for _ in range(3):
            for number in range(600):
                come_and_go(daemon, job, number)
            daemon.wait_metric("glint_http_streams", 0)
            daemon.wait_metric("glint_http_connections", 1)
            used.append((descriptors(daemon), resident(daemon)))
        assert used[2][0] <= used[1][0] + 4, used  # of 1200 connections since
        if not instrumented(daemon):
            assert used[2][1] < used[1][1] + 4, used
        daemon.delete(f"/v1/jobs/{job}")


def wait_for_frame(daemon, job):
    waiting = daemon.dial()
    waiting.sendall(f"GET /v1/jobs/{job}/frame.exr?wait=done&outputs=beauty HTTP/1.1\r\n"
                    "Host: localhost\r\nConnection: close\r\n\r\n".encode())
    return waiting


def read_answer(waiting):
    answer = http.client.HTTPResponse(waiting)
    answer.begin()
    return answer.status, answer.read()


def test_two_hundred_wait_for_a_frame_without_a_thread_each():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 64)
        pause = {"Content-Type": "application/merge-patch+json"}
        assert daemon.ask("PATCH", f"/v1/jobs/{job}", '{"paused": true}', pause).status == 200
        before = threads(daemon)
        with contextlib.ExitStack() as stack:
            waiting = [stack.enter_context(wait_for_frame(daemon, job)) for _ in range(200)]
            daemon.wait_metric("glint_http_connections", 201)
            assert threads(daemon) < before + 50  # preparing a job takes some of its own
            assert daemon.ask("PATCH", f"/v1/jobs/{job}", '{"paused": false}', pause).status == 200
            answers = {read_answer(one) for one in waiting}
        assert answers == {(200, daemon.frame(job, "&outputs=beauty"))}


def test_waiting_ends_when_the_job_is_forgotten_or_the_daemon_stops():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        jobs = [submit(daemon, 1000000) for _ in range(2)]
        with wait_for_frame(daemon, jobs[0]) as first, wait_for_frame(daemon, jobs[1]) as second:
            daemon.wait_metric("glint_http_connections", 3)
            daemon.delete(f"/v1/jobs/{jobs[0]}")
            assert read_answer(first)[0] in (404, 409)
            daemon.process.send_signal(signal.SIGTERM)
            assert read_answer(second)[0] == 503
        assert daemon.process.wait(PATIENCE) == 0


def test_after_a_restart_events_and_tiles_are_newer_than_all_before():
    with Lasting() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 2)
        daemon.frame(job)
        events, tiles = f"/v1/jobs/{job}/events", f"/v1/jobs/{job}/tiles"
        with daemon.connect(events) as stream:
            list(stream.events())
            last_event = stream.last_id
        with daemon.connect(tiles) as stream:
            before, _, last_tile = read_tiles(stream)
        daemon.restart()
        with daemon.connect(events, {"Last-Event-ID": last_event}) as stream:
            assert [name for name, _ in stream.events()] == ["reset", "done"]
            assert int(stream.last_id) > int(last_event) + 1
        with daemon.connect(f"{tiles}?since={last_tile}") as stream:
            after, _, last = read_tiles(stream)
        assert last > last_tile and contents(after) == contents(before)


def test_a_forgotten_job_ends_its_streams():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 1000000)
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            daemon.delete(f"/v1/jobs/{job}")
            list(stream.parts())
        assert daemon.get(f"/v1/jobs/{job}").json()["state"] == "cancelled"


def test_a_daemon_that_is_told_to_stop_ends_its_streams_and_leaves():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = submit(daemon, 1000000)
        daemon.until(job, lambda j: j["samples"] > 0)
        streams = [daemon.connect(f"/v1/jobs/{job}/{kind}") for kind in ("tiles", "events")]
        daemon.process.send_signal(signal.SIGTERM)
        for stream in streams:
            while stream.response.read(65536):
                pass
            stream.close()
        assert daemon.process.wait(60) == 0


if __name__ == "__main__":
    tap.main()
