#!/usr/bin/python3
"""glint submit, update JOB, pick, recolor JOB and top, against a real daemon."""
import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time

import cli
import tap

sys.path.insert(0, tap.source("tests", "http"))
from daemon import ROOM, Daemon  # pylint: disable=wrong-import-position

SMALL = ["--resolution", "48x32", "--samples", "4"]


class House:
    """A daemon with the room, and a folder."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.daemon = Daemon()
        self.server = self.daemon.__enter__().url
        self.daemon.put("room", ROOM)
        return self

    def __exit__(self, *error):
        self.daemon.__exit__(*error)
        self.folder.cleanup()

    def __truediv__(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, value):
        with open(self / name, "w", encoding="utf-8") as file:
            json.dump(value, file)
        return self / name

    def glint(self, *arguments, expect=0):
        run = cli.glint(*arguments, server=self.server)
        assert run.returncode == expect, (arguments, run.returncode, run.stdout, run.stderr)
        return run

    def document(self, *arguments):
        return json.loads(self.glint(*arguments, "--json").stdout)

    def submit(self, *arguments):
        return self.glint("submit", "room", *arguments).stdout.strip()


def test_a_submission_prints_the_job_and_returns():
    with House() as house:
        job = house.submit("--resolution", "48x32", "--samples", "1000000")
        assert house.document("jobs", job)["state"] in ("queued", "rendering")
        house.glint("cancel", job)
        whole = house.document("submit", "room", *SMALL, "--name", "one")
        assert whole["name"] == "one" and whole["job"]["stop"]["samples"] == 4
        assert house.document("watch", whole["id"])["state"] == "done"
        house.glint("get", whole["id"], "-o", house / "f.png")
        room = house.write("other.json", ROOM)
        job = house.glint("submit", room, *SMALL, "--idempotency-key", "k1").stdout
        assert house.glint("submit", room, *SMALL, "--idempotency-key", "k1").stdout == job
        assert {"room", "other"} == {s["name"] for s in house.document("scenes")["scenes"]}


def test_a_job_that_is_not_sound_says_so_wherever_it_is_told_of():
    """Nine glasses, one in the other, are one more than a sample knows of."""
    balls = {str(n): {"mesh": "b", "material": "g", "transform": {"scale": [n, n, n]}}
             for n in range(1, 10)}
    with House() as house:
        house.daemon.put("nine", {
            "environment": {"radiance": [1, 1, 1]}, "meshes": {"b": {"primitive": "sphere"}},
            "materials": {"g": {"transmission": 1, "roughness": 0, "priority": 1}}, "instances": balls,
            "cameras": {"eye": {"yfov": 0.8, "transform": {"translation": [0, 0, 30]}}}})
        sound, job = (house.glint("submit", scene, *SMALL).stdout.strip() for scene in ("room", "nine"))
        watched = house.glint("watch", job).stdout
        assert "sound: no" in watched and "in too many nested solids" in watched, watched
        assert "sound: no" in house.glint("jobs", job).stdout
        assert "sound: yes" in house.glint("watch", sound).stdout
        head, *lines = house.glint("jobs").stdout.splitlines()
        told = {line.split()[0]: line.split()[head.split().index("SOUND")] for line in lines}
        assert told == {sound: "yes", job: "no"}, told


def said(text):
    """{beginning of a line: the rest}"""
    return dict(line.split(": ", 1) for line in text.splitlines() if ": " in line)


def test_a_job_tells_its_error_its_forecast_and_what_neither_sees():
    with House() as house:
        exact = {"accuracy": {"preset": "reference"}, "max_bounces": 2}
        point = {"settings": exact, "seconds": 1e-5, "rays": 3, "variance": 1, "bias": 0.04,
                 "row": ""}
        house.daemon.ask("PUT", "/v1/scenes/room/front", json.dumps({"points": [point]}),
                         {"Content-Type": "application/json"})
        short = house.write("short.json", {**exact, "scene": "room", "resolution": [32, 16],
                                           "outputs": ["beauty"],
                                           "stop": {"error": 1e-3, "samples": 1000000}})
        job = house.glint("submit", "--job", short).stdout.strip()
        house.daemon.until(job, lambda j: j["samples"] >= 16)
        told = said(house.glint("jobs", job).stdout)
        house.glint("cancel", job)
        low, high = map(float, told["error between"].split(" and "))
        assert low < float(told["error"]) < high and float(told["tone-mapped"]) > 0
        assert told["not in the error"] == "max_bounces 2"
        known, total = map(float, told["known bias"].split(", with the error "))
        assert known == 0.04 and abs(total ** 2 - known ** 2 - float(told["error"]) ** 2) < 1e-5
        assert told["forecast"] == "0.001 is unreachable with these settings"


def test_a_forecast_has_an_end_or_says_that_it_has_none():
    with House() as house:
        job = house.submit("--resolution", "32x16", "--outputs", "beauty", "--error", "0.001")
        house.daemon.until(job, lambda j: j["samples"] >= 32)
        told = said(house.glint("jobs", job).stdout)
        house.glint("cancel", job)
        assert re.match(r"0\.001 at \d+ samples( or more| \(\d+ to \d+\)), in ", told["forecast"])
        assert "accuracy.traversal fast" in told["not in the error"] and "known bias" not in told


def test_a_submission_starts_no_daemon_of_its_own():
    with House() as house, cli.Silence() as silent:
        run = cli.glint("submit", house.write("other.json", ROOM), server=silent)
        assert run.returncode == 69 and silent in run.stderr


def test_an_interrupted_submission_cancels_nothing():
    with House() as house:
        process = cli.start("submit", "room", "--samples", "1000000", server=house.server)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)
        if process.returncode == 0:
            assert house.document("jobs", out.strip())["state"] in ("queued", "rendering")
        for job in house.document("jobs")["jobs"]:
            assert job["state"] != "cancelled"
            house.glint("cancel", job["id"])


def test_a_job_is_paused_resumed_and_given_another_priority():
    with House() as house:
        job = house.submit("--resolution", "48x32", "--samples", "1000000")
        told = house.glint("update", job, "--pause", "--priority", "7").stdout
        assert "state: paused\n" in told and "priority: 7\n" in told
        assert house.document("jobs", job)["state"] == "paused"
        assert house.document("update", job, "--resume")["state"] in ("queued", "rendering")
        run = house.glint("update", job, "--priority", "1000", expect=1)
        assert "/priority" in run.stderr
        house.glint("cancel", job)


def test_more_samples_continue_a_finished_job():
    with House() as house:
        job = house.submit(*SMALL)
        house.glint("watch", job)
        assert house.document("update", job, "--samples", "12")["target_samples"] == 12
        assert house.document("watch", job)["samples"] == 12
        run = house.glint("update", job, "--samples", "2", expect=1)
        assert "/stop/samples" in run.stderr
        assert house.document("jobs", job)["samples"] == 12


def test_the_camera_of_a_live_job_moves():
    with House() as house:
        job = house.submit(*SMALL, "--live")
        camera = {"yfov": 0.4, "transform": {"translation": [1, 1, 4]}}
        moved = house.document("update", job, "--camera", house.write("camera.json", camera))
        assert moved["job"]["camera"]["yfov"] == 0.4
        assert house.document("update", job, "--camera", "main")["job"]["camera"] == "main"
        run = house.glint("update", job, "--camera", "attic", expect=1)
        assert "/camera" in run.stderr and "attic" in run.stderr
        with open(house / "bad.json", "w", encoding="utf-8") as file:
            file.write("[1, 2")
        assert "bad.json" in house.glint("update", job, "-c", house / "bad.json", expect=64).stderr
        assert house.glint("update", job, "-c", house / "none.json", expect=1).stderr
        house.glint("cancel", job)


def test_a_pixel_is_named_by_layer():
    with House() as house:
        job = house.submit("--resolution", "48x32", "--samples", "16")
        house.glint("watch", job)
        told = house.glint("pick", job, "24", "28").stdout
        assert "object:\n" in told and "floor" in told and "material:\n" in told
        pick = house.document("pick", job, "24", "28", "--layer", "material")
        assert list(pick["primary"]) == ["material"] and pick["x"] == 24
        assert pick["primary"]["material"][0]["name"] == "white"
        assert "object: nothing\n" in house.glint("pick", job, "0", "0").stdout
        assert "not in the region" in house.glint("pick", job, "48", "0", expect=1).stderr
        assert '"x"' in house.glint("pick", "x", "1", "1", expect=1).stderr


def test_a_jobs_frame_is_recoloured_as_if_it_were_rendered_so():
    try:
        import numpy
        import OpenImageIO as oiio
    except ImportError:
        raise tap.Skip("no OpenImageIO for Python") from None

    def render(house, scene, path):
        house.daemon.put("room", scene)
        # Direct light only: what the wall throws on others keeps its old colour.
        job = {"scene": "room", "resolution": [96, 64], "stop": {"samples": 64},
               "accuracy": {"gi": "none"}, "outputs": ["beauty", "crypto_object", "albedo"]}
        job = house.document("submit", "--job", house.write("job.json", job))["id"]
        house.glint("watch", job)
        house.glint("get", job, "-o", house / path)
        return job

    def read(path):
        image = oiio.ImageInput.open(path)
        names = list(image.spec().channelnames)
        return image.read_image(oiio.FLOAT)[:, :, [names.index(c) for c in "RGB"]]

    room = json.loads(json.dumps(ROOM))
    room["materials"]["lamp"]["emission"] = [11, 11, 11]  # what red hardly has is taken for white
    with House() as house:
        job = render(house, room, "red.exr")
        house.glint("recolor", job, "-n", "wall", "-c", "0.1,0.2,0.7", "-o", house / "made.exr")
        house.glint("recolor", job, "-n", "wall", "-c", "0.1,0.2,0.7", "-o", house / "made.png")
        blue = json.loads(json.dumps(room))
        blue["materials"]["red"]["base_color"] = [0.1, 0.2, 0.7]
        render(house, blue, "blue.exr")
        red, made, blue = (read(house / f"{n}.exr") for n in ("red", "made", "blue"))
        changed = numpy.abs(red - blue).max(2) > 0.02
        assert changed.sum() > 500
        far, near = numpy.abs(red - blue)[changed].mean(), numpy.abs(made - blue)[changed].mean()
        assert near < 0.05 * far, (near, far)
        assert '"x"' in house.glint("recolor", "x", "-n", "a", "-c", "#fff", "-o",
                                    house / "n.exr", expect=1).stderr


def test_top_is_one_table_where_nobody_watches():
    with House() as house:
        job = house.submit("--resolution", "48x32", "--samples", "1000000", "--name", "long")
        told = house.glint("top").stdout
        assert "workers at work" in told and "\033" not in told
        titles, row = (told.splitlines()[-2:][i].split() for i in (0, 1))
        assert row[0] == job and float(row[titles.index("WORKERS")]) >= 0  # of one look too
        assert "RESIDENT" in told and job in told and "long" in told
        looks = house.glint("top", "--times", "2", "--delay", "0.5").stdout
        assert looks.count("workers at work") == 2
        whole = house.document("top")
        assert whole["stats"]["workers"] and whole["jobs"][0]["id"] == job
        house.glint("cancel", job)
        end = time.monotonic() + 60  # it ends once its slices are back
        while "1 cancelled" not in house.glint("top").stdout:
            assert time.monotonic() < end


def read_until(terminal, wanted):
    got, end = b"", time.monotonic() + 60
    while wanted not in got:
        assert time.monotonic() < end, got
        if select.select([terminal], [], [], 1)[0]:
            got += os.read(terminal, 65536)
    return got


def test_top_draws_on_a_terminal_until_q_and_gives_it_back():
    for keys, code in [(b"q", 0), (b"\x03", 130)]:
        with House() as house:
            terminal, other = pty.openpty()
            fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", 12, 60, 0, 0))
            before = termios.tcgetattr(other)
            process = subprocess.Popen(
                [cli.PROGRAM, "top", "-d", "0.2", "-s", house.server], stdin=other, stdout=other,
                stderr=other, env=cli.environment(TERM="xterm"), start_new_session=True,
                preexec_fn=lambda fd=other: fcntl.ioctl(fd, termios.TIOCSCTTY, 0))
            read_until(terminal, b"\033[H\033[J")
            read_until(terminal, b"\033[H\033[J")  # and again
            os.write(terminal, keys)
            rest = read_until(terminal, b"\033[?1049l")
            assert b"\033[?25h" in rest and b"\033[?7h" in rest
            assert process.wait(60) == code
            assert termios.tcgetattr(other) == before
            os.close(terminal)
            os.close(other)


def test_top_says_when_the_daemon_has_gone():
    with House() as house:
        process = cli.start("top", "-n", "1000", "-d", "0.2", server=house.server)
        assert "workers" in process.stdout.readline()
        house.daemon.stop()
        _, told = process.communicate(timeout=60)
        # 75: it answered once more that it stops.
        assert process.returncode in (69, 75) and told.startswith("glint: "), (process, told)


if __name__ == "__main__":
    tap.main()
