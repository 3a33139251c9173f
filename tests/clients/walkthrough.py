#!/usr/bin/python3
"""protocol/examples/walkthrough.sh: what it promises a newcomer comes true against a daemon."""
import json
import os
import re
import subprocess
import sys
import tempfile

import tap

sys.path.insert(0, tap.source("tests", "http"))
from daemon import Daemon  # pylint: disable=wrong-import-position

SCRIPT = tap.source("protocol", "examples", "walkthrough.sh")


class Walk:
    """The folder that the script leaves behind."""

    def __init__(self, folder, output):
        self.folder, self.output = folder, output

    def read(self, name):
        with open(os.path.join(self.folder, "walkthrough", name), "rb") as file:
            return file.read()

    def json(self, name):
        return json.loads(self.read(name))


def walk(check):
    """Runs the script to its end and lets `check` look at what it left."""
    tap.tool("curl")
    with Daemon() as daemon, tempfile.TemporaryDirectory() as folder:
        path = os.path.dirname(tap.build("glint")) + os.pathsep + os.environ["PATH"]
        run = subprocess.run(["sh", SCRIPT, daemon.url], cwd=folder, capture_output=True,
                             text=True, timeout=300, check=False,
                             env={**os.environ, "PATH": path})
        assert run.returncode == 0, run.stdout + run.stderr
        check(Walk(folder, run.stdout), daemon)


def check_steps(walked):
    steps = re.findall(r"^== (.+)$", walked.output, re.M)
    with open(SCRIPT, encoding="utf-8") as script:
        written = re.findall(r"^step '?(.+?)'?$", script.read(), re.M)
    assert steps == written and len(steps) > 12, steps


def check_pictures(walked):
    exr, png = b"\x76\x2f\x31\x01", b"\x89PNG"
    for name, magic in [("frame.exr", exr), ("beauty.exr", exr), ("frame24.exr", exr),
                        ("matte.exr", exr), ("merged.exr", exr), ("frame.png", png), ("matte.png", png),
                        ("live1.png", png), ("live2.png", png)]:
        assert walked.read(name).startswith(magic), name
    assert len(walked.read("beauty.exr")) < len(walked.read("frame.exr"))
    assert walked.read("frame.exr") != walked.read("frame24.exr")
    tiles = walked.read("tiles.multipart")
    covered = sum(int(w) * int(h) for w, h in
                  re.findall(rb"^Glint-Tile: \d+ \d+ (\d+) (\d+)\r$", tiles, re.M))
    assert covered == 160 * 90, covered


def check_answers(walked):
    assert walked.json("submitted.json")["client"] == ""
    assert walked.json("job24.json")["samples"] == 24
    assert walked.json("edited.json")["revision"] != walked.json("scene.json")["revision"]
    assert "bvh" in walked.json("edited.json")["changes"]["kept"]
    assert walked.json("stale.json")["status"] == 412
    names = {n["name"]: n["coverage"] for n in walked.json("mattes.json")["layers"]["object"]["names"]}
    assert names["hero ball"] > 100, names
    assert walked.json("pick.json")["primary"]["object"][0]["name"] == "hero ball"
    assert {e["effect"] for e in walked.json("plan.json")["effects"] if e["on"]}
    samples = [p["samples"] for p in walked.json("convergence.json")["curve"]]
    assert samples and samples == sorted(samples) and samples[-1] == 16, samples
    pointers = sorted(f["pointer"] for f in walked.json("problem.json")["errors"])
    assert pointers == ["/resolution/0", "/smaples"]


def test_every_step_comes_true():
    def check(walked, daemon):
        check_steps(walked)
        check_pictures(walked)
        check_answers(walked)
        assert daemon.get("/v1/scenes").json()["scenes"][0]["name"] == "stage"
    walk(check)


def test_it_stops_at_the_first_answer_that_is_not_as_it_says():
    tap.tool("curl")
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(["sh", SCRIPT, "http://127.0.0.1:9"], cwd=folder, capture_output=True,
                             text=True, timeout=60, check=False)
        assert run.returncode != 0 and run.stdout.count("==") == 1, run.stdout


if __name__ == "__main__":
    tap.main()
