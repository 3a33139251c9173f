#!/usr/bin/python3
"""glint render, get and watch: files that appear whole, progress, interruption, private daemons."""
import json
import os
import pty
import select
import shutil
import signal
import subprocess
import tempfile

import cli
import tap
from fake_daemon import FRAME, JOB, Answer, FakeDaemon, event, problem

EVENTS, FRAME_PATH = "/v1/jobs/job1/events", "/v1/jobs/job1/frame.exr"


class Folder(tempfile.TemporaryDirectory):
    """A folder with a scene in it."""

    def __enter__(self):
        self.path = super().__enter__()
        with open(self / "room.glb", "wb") as scene:
            scene.write(b"glTF of a room")
        return self

    def __truediv__(self, name):
        return os.path.join(self.path, name)

    def names(self):
        return sorted(os.listdir(self.path))


def read(path):
    with open(path, "rb") as file:
        return file.read()


def body_of_job(daemon):
    return json.loads(daemon.wait_for("POST", "/v1/jobs").body)


def test_a_file_is_uploaded_rendered_and_downloaded():
    with FakeDaemon() as daemon, Folder() as folder:
        run = cli.glint("render", folder / "room.glb", "-o", folder / "f.exr", "--samples", 64,
                        server=daemon.url)
        assert run.returncode == 0, run.stderr
        put = daemon.wait_for("PUT", "/v1/scenes/room")
        assert put.body == b"glTF of a room" and put.headers["Content-Type"] == "model/gltf-binary"
        assert body_of_job(daemon) == {"scene": "room", "stop": {"samples": 64}}
        assert read(folder / "f.exr") == FRAME
        assert folder.names() == ["f.exr", "room.glb"]
        assert "Progress: 50%\n" in run.stdout and "64 samples" in run.stderr


def test_options_become_members_of_the_job_and_override_its_file():
    with FakeDaemon() as daemon, Folder() as folder:
        with open(folder / "job.json", "w", encoding="utf-8") as file:
            json.dump({"scene": "old", "stop": {"samples": 9, "error": 0.5}, "seed": 3,
                       "mattes": {"levels": 4}}, file)
        run = cli.glint("render", "resident", "--job", folder / "job.json", "-o", folder / "f.png",
                        "--resolution", "64x32", "--camera", "left", "--outputs", "beauty,depth",
                        "--max-bounces", 2, "--error", "0.25", "--seconds", "1.5", "--region",
                        "1,2,30,20", "--levels", "auto", "--name", "shot", "--frame", 7, "--idempotency-key", "k1",
                        server=daemon.url)
        assert run.returncode == 0, run.stderr
        assert body_of_job(daemon) == {
            "scene": "resident", "stop": {"samples": 9, "error": 0.25, "seconds": 1.5}, "seed": 3,
            "mattes": {"levels": "auto"}, "resolution": [64, 32], "camera": "left",
            "outputs": ["beauty", "depth"], "max_bounces": 2, "region": [1, 2, 30, 20],
            "name": "shot", "frame": 7}
        assert daemon.wait_for("POST", "/v1/jobs").headers["Idempotency-Key"] == "k1"
        daemon.wait_for("GET", "/v1/jobs/job1/frame.png")
        assert not [r for r in daemon.requests if r.method == "PUT"]


def test_hashes_in_the_output_are_the_frame_number():
    with FakeDaemon() as daemon, Folder() as folder:
        cli.glint("render", "r", "--frame", 7, "-o", folder / "a.####.exr", "-o", folder / "b.#.png",
                  server=daemon.url)
        assert folder.names() == ["a.0007.exr", "b.7.png", "room.glb"]


def test_json_is_one_document_with_the_job_and_its_files():
    with FakeDaemon() as daemon, Folder() as folder:
        run = cli.glint("render", "r", "--json", "-o", folder / "f.exr", server=daemon.url)
        assert json.loads(run.stdout) == {**JOB, "files": [folder / "f.exr"]}
        run = cli.glint("get", "job1", "--json", "-o", folder / "f.exr", server=daemon.url)
        assert json.loads(run.stdout) == {"file": folder / "f.exr", "bytes": len(FRAME)}
        run = cli.glint("cancel", "job1", "--json", server=daemon.url)
        assert json.loads(run.stdout) == {"id": "job1", "outcome": "cancelled"}
        run = cli.glint("watch", "job1", "--json", server=daemon.url)
        assert json.loads(run.stdout) == JOB


def test_several_jobs_are_watched_each_to_its_end():
    failed = {**JOB, "id": "job2", "state": "failed",
              "problem": {"type": "/problems/test", "title": "A problem", "status": 500,
                          "detail": "it broke", "errors": []}}
    third = {**JOB, "id": "job3"}
    with FakeDaemon() as daemon:
        for job in failed, third:
            daemon.on("GET", f"/v1/jobs/{job['id']}", Answer(200, job))
            daemon.on("GET", f"/v1/jobs/{job['id']}/events",
                      Answer(200, event("done", job, 1), "text/event-stream"))
        run = cli.glint("watch", "job1", "job2", "job3", "--progress", "plain", server=daemon.url)
        assert run.returncode == 1 and "it broke" in run.stderr, run
        assert run.stdout.count("Progress: 100%") == 3
        run = cli.glint("watch", "job1", "job3", "--json", server=daemon.url)
        assert run.returncode == 0 and json.loads(run.stdout) == {"jobs": [JOB, third]}


def test_a_download_that_breaks_off_leaves_the_old_file():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("GET", FRAME_PATH, Answer(200, FRAME, cut=5))
        with open(folder / "f.exr", "wb") as file:
            file.write(b"old")
        run = cli.glint("render", "r", "-o", folder / "f.exr", server=daemon.url)
        assert run.returncode == 69, run
        assert read(folder / "f.exr") == b"old"
        assert folder.names() == ["f.exr", "room.glb"]


def test_an_output_that_cannot_be_made_is_told_before_anything_is_sent():
    with FakeDaemon() as daemon, Folder() as folder:
        os.mkdir(folder / "d.exr")
        for bad in ["no/f.exr", "d.exr", "room.glb/f.exr"]:
            run = cli.glint("render", folder / "room.glb", "-o", folder / bad, server=daemon.url)
            assert run.returncode == 1 and bad in run.stderr, run
        assert daemon.requests == []


def test_a_link_goes_on_pointing_at_the_file():
    with FakeDaemon() as daemon, Folder() as folder:
        with open(folder / "real.exr", "wb"):
            pass
        os.symlink("real.exr", folder / "link.exr")
        assert cli.glint("get", "job1", "-o", folder / "link.exr", server=daemon.url).returncode == 0
        assert os.readlink(folder / "link.exr") == "real.exr"
        assert read(folder / "real.exr") == FRAME


def test_a_missing_scene_file_is_not_taken_for_a_resident_scene():
    with FakeDaemon() as daemon, Folder() as folder:
        run = cli.glint("render", "nowhere.glb", "-o", folder / "f.exr", server=daemon.url)
        assert run.returncode == 1 and "nowhere.glb: no such file" in run.stderr
        assert daemon.requests == []


def test_a_failed_job_tells_its_problem_and_writes_nothing():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("GET", EVENTS, Answer(200, event("state", {"state": "failed"}), "text/event-stream"))
        daemon.on("GET", "/v1/jobs/job1", Answer(200, {**JOB, "state": "failed", "problem": {
            "detail": "two faults", "errors": [{"pointer": "/camera", "detail": "no such camera"}]}}))
        run = cli.glint("render", "r", "-o", folder / "f.exr", server=daemon.url)
        assert run.returncode == 1 and "/camera: no such camera" in run.stderr
        assert folder.names() == ["room.glb"]


def test_a_job_cancelled_by_another_exits_130():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("GET", EVENTS, Answer(200, event("state", {"state": "cancelled"}), "text/event-stream"))
        daemon.on("GET", "/v1/jobs/job1", Answer(200, {**JOB, "state": "cancelled"}))
        run = cli.glint("render", "r", "-o", folder / "f.exr", server=daemon.url)
        assert run.returncode == 130 and "cancelled" in run.stderr
        assert not [r for r in daemon.requests if r.method == "DELETE"]


def test_events_that_break_off_are_taken_up_after_the_last_one():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("GET", EVENTS, [
            Answer(200, event("progress", {"progress": 0.25}, 41) + b"id: 42\nevent: prog", cut=60),
            Answer(200, event("done", {"state": "done"}, 43), "text/event-stream")])
        daemon.on("GET", "/v1/jobs/job1", [Answer(200, {**JOB, "state": "rendering", "progress": 0.3}),
                                           Answer(200, JOB)])
        run = cli.glint("render", "r", "-o", folder / "f.exr", server=daemon.url)
        assert run.returncode == 0, run.stderr
        streams = [r for r in daemon.requests if r.path == EVENTS]
        assert "Last-Event-ID" not in streams[0].headers
        assert streams[1].headers["Last-Event-ID"] == "41"


def test_warnings_of_scene_and_job_are_shown():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("PUT", "/v1/scenes/room", Answer(201, {"name": "room", "revision": "",
                                                         "warnings": ["no camera"]}))
        daemon.on("GET", EVENTS, Answer(200, event("warning", {"detail": "a clash of names"})
                                        + event("done", {"state": "done"}), "text/event-stream"))
        run = cli.glint("render", folder / "room.glb", "-o", folder / "f.exr", server=daemon.url)
        assert "glint: warning: no camera\n" in run.stderr
        assert "glint: warning: a clash of names\n" in run.stderr


def test_a_scene_replaced_before_the_job_used_it_is_not_rendered():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("POST", "/v1/jobs", Answer(202, {**JOB, "revision": "0" * 64}))
        run = cli.glint("render", folder / "room.glb", "-o", folder / "f.exr", server=daemon.url)
        assert run.returncode == 1 and "replaced" in run.stderr
        daemon.wait_for("DELETE", "/v1/jobs/job1")
        assert folder.names() == ["room.glb"]


def endless(handler):
    handler.start_stream()
    handler.wfile.write(event("progress", {"state": "rendering", "progress": 0.1}))
    handler.rfile.read()  # until the client goes away


def interrupt(number, *arguments, server):
    """Sends the signal once progress is shown; the exit code."""
    process = cli.start("render", *arguments, server=server)
    assert process.stdout.readline() == "Progress: 10%\n"
    process.send_signal(number)
    process.communicate(timeout=30)
    return process.returncode


def test_an_interrupt_cancels_the_job_and_exits_130():
    for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]:
        with FakeDaemon() as daemon, Folder() as folder:
            daemon.on("GET", EVENTS, endless)
            assert interrupt(number, "r", "-o", folder / "f.exr", server=daemon.url) == 130
            daemon.wait_for("DELETE", "/v1/jobs/job1")
            assert folder.names() == ["room.glb"]


def test_an_interrupted_watch_leaves_the_job_alone():
    with FakeDaemon() as daemon:
        daemon.on("GET", EVENTS, endless)
        process = cli.start("watch", "job1", server=daemon.url)
        assert process.stdout.readline() == "Progress: 10%\n"
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        assert process.returncode == 130
        assert not [r for r in daemon.requests if r.method == "DELETE"]


def test_openjd_progress_has_its_own_words():
    with FakeDaemon() as daemon, Folder() as folder:
        run = cli.glint("render", "r", "-o", folder / "f.exr", "--wait", "--progress=openjd",
                        server=daemon.url)
        assert run.stdout == "openjd_progress: 50.0\nopenjd_progress: 100.0\n"


def test_a_terminal_shows_a_bar_with_samples_error_and_time_left():
    with FakeDaemon() as daemon, Folder() as folder:
        daemon.on("GET", EVENTS, Answer(200, event("progress", {
            "state": "rendering", "progress": 0.5, "samples": 32, "error": 0.0456,
            "eta_seconds": 75, "target_samples": 64}) + event("done", {"state": "done"}), "text/event-stream"))
        master, slave = pty.openpty()
        run = subprocess.run([cli.PROGRAM, "render", "r", "-o", folder / "f.exr"], stderr=slave,
                             stdout=subprocess.PIPE, env=cli.environment(GLINT_SERVER=daemon.url),
                             timeout=30, check=True)
        os.close(slave)
        shown = os.read(master, 65536).decode()
        os.close(master)
        assert "[=" in shown and "50%  32/64 samples  error 0.0456  ETA 1:15" in shown
        assert run.stdout == b""


def private(folder, **more):
    """A copy of the client with a fake glintd beside it, rendering without any other daemon."""
    binary, daemon = folder / "glint", folder / "glintd"
    shutil.copy(cli.PROGRAM, binary)
    with open(daemon, "w", encoding="utf-8") as script:
        script.write(f'#!/bin/sh\nexec python3 {tap.source("tests/clients/fake_daemon.py")} "$@"\n')
    os.chmod(daemon, 0o755)
    os.mkdir(folder / "tmp")
    return lambda *arguments, server: cli.start(
        "render", folder / "room.glb", "-o", folder / "f.exr", *arguments, server=server,
        binary=binary, TMPDIR=folder / "tmp", **more)


def test_a_private_daemon_serves_the_render_and_leaves_nothing():
    with cli.Silence() as silent, Folder() as folder:
        process = private(folder)(server=silent)
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
        assert "starting a private one" in errors
        assert read(folder / "f.exr") == FRAME
        assert os.listdir(folder / "tmp") == []


def test_a_private_daemon_that_cannot_start_is_quoted():
    with cli.Silence() as silent, Folder() as folder:
        process = private(folder, FAKE_DAEMON_FAILS="1")(server=silent)
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 69 and "this daemon has no devices" in errors
        assert os.listdir(folder / "tmp") == []


def test_no_private_daemon_is_started_when_forbidden_or_when_one_answers():
    with cli.Silence() as silent, Folder() as folder, FakeDaemon() as daemon:
        start = private(folder)
        process = start("--no-spawn", server=silent)
        process.communicate(timeout=60)
        assert process.returncode == 69
        process = start(server=daemon.url)
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0 and "private" not in errors


def test_a_private_daemon_dies_with_a_client_that_is_killed():
    with cli.Silence() as silent, Folder() as folder:
        os.mkfifo(folder / "pid")
        process = private(folder, FAKE_DAEMON_HANGS=folder / "pid")(server=silent)
        daemon = os.pidfd_open(int(read(folder / "pid")))
        process.kill()
        process.communicate(timeout=30)
        ended, _, _ = select.select([daemon], [], [], 30)
        os.close(daemon)
        assert ended


if __name__ == "__main__":
    tap.main()
