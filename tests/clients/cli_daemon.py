#!/usr/bin/python3
"""glint with a real daemon: what the fake one of the other tests only pretends."""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import cli
import tap

sys.path.insert(0, tap.source("tests", "http"))
from daemon import ROOM, Daemon  # pylint: disable=wrong-import-position

SMALL = ["--resolution", "48x32", "--samples", "4"]


class House:
    """A daemon, and a folder with the room in a file."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.daemon = Daemon()
        self.server = self.daemon.__enter__().url
        with open(self / "room.json", "w", encoding="utf-8") as file:
            json.dump(ROOM, file)
        return self

    def __exit__(self, *error):
        self.daemon.__exit__(*error)
        self.folder.cleanup()

    def __truediv__(self, name):
        return os.path.join(self.folder.name, name)

    def glint(self, *arguments, expect=0):
        run = cli.glint(*arguments, server=self.server)
        assert run.returncode == expect, (arguments, run.returncode, run.stderr)
        return run

    def document(self, *arguments):
        return json.loads(self.glint(*arguments, "--json").stdout)


def magic(path, size=4):
    with open(path, "rb") as file:
        return file.read(size)


def test_every_command_works_on_a_scene_and_its_job():
    with House() as house:
        assert house.document("put", house / "room.json")["name"] == "room"
        assert [s["name"] for s in house.document("scenes")["scenes"]] == ["room"]
        assert house.document("scenes", "room")["instances"] == len(ROOM["instances"])
        job = house.document("render", "room", *SMALL, "-o", house / "f.exr", "-o", house / "f.png")
        assert job["state"] == "done" and job["samples"] == 4
        assert magic(house / "f.exr") == b"\x76\x2f\x31\x01" and magic(house / "f.png") == b"\x89PNG"
        assert [j["id"] for j in house.document("jobs")["jobs"]] == [job["id"]]
        assert house.document("jobs", job["id"])["id"] == job["id"]
        assert house.document("watch", job["id"])["state"] == "done"
        house.glint("get", job["id"], "--outputs", "beauty", "-o", house / "g.exr")
        assert os.path.getsize(house / "g.exr") < os.path.getsize(house / "f.exr")
        names = house.document("mattes", job["id"])["layers"]["object"]["names"]
        seen = {n["name"]: n["coverage"] for n in names}
        assert seen["ball"] > 0 and seen["wall"] > 0
        house.glint("matte", job["id"], "--name", "ball", "--name", "cube", "-o", house / "m.exr")
        assert magic(house / "m.exr") == b"\x76\x2f\x31\x01"
        assert "PASS" in house.glint("plan", job["id"]).stdout
        assert house.document("plan", job["id"])["effects"]
        assert house.document("cancel", job["id"])["outcome"] == "forgotten"
        assert house.document("jobs") == {"jobs": [], "next": None}


def test_an_update_rebuilds_what_it_touches_and_no_more():
    with House() as house:
        first = house.document("put", house / "room.json")["revision"]
        with open(house / "patch.json", "w", encoding="utf-8") as file:
            json.dump({"materials": {name: {"roughness": 0.5} for name in ROOM["materials"]}}, file)
        after = house.document("update", "room", house / "patch.json", "--if-match", first)
        changes = after["changes"]
        assert after["revision"] != first and "materials" not in changes["kept"]
        assert {"meshes", "bvh", "placement"} <= set(changes["kept"]), changes
        assert changes["milliseconds"]["total"] > 0
        stale = house.glint("update", "room", house / "patch.json", "--if-match", first, expect=75)
        assert after["revision"] in stale.stderr
        told = house.glint("update", "room", house / "patch.json").stdout  # changes nothing
        assert f"revision: {after['revision']}\n" in told and "rebuilt" not in told
        with open(house / "patch.json", "w", encoding="utf-8") as file:
            json.dump({"materials": {"wall": {"roughness": 2}}, "lamps": {}}, file)
        run = house.glint("update", "room", house / "patch.json", expect=1)
        assert "/materials/wall/roughness" in run.stderr and "/lamps" in run.stderr


def until(true, seconds=60):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.05)


def test_a_live_job_follows_an_update():
    with House() as house:
        house.glint("put", house / "room.json")
        job = house.glint("render", "room", *SMALL, "--live").stdout.strip()
        until(lambda: house.document("jobs", job)["samples"] == 4)
        with open(house / "patch.json", "w", encoding="utf-8") as file:
            json.dump({"materials": {name: {"roughness": 0.5} for name in ROOM["materials"]}}, file)
        revision = house.document("update", "room", house / "patch.json")["revision"]
        until(lambda: house.document("jobs", job)["revision"] == revision)
        house.glint("get", job, "-o", house / "f.exr")
        assert magic(house / "f.exr") == b"\x76\x2f\x31\x01"
        assert house.document("cancel", job)["outcome"] == "cancelled"


def test_every_fault_of_a_job_is_told_with_its_pointer():
    with House() as house:
        house.glint("put", house / "room.json")
        with open(house / "job.json", "w", encoding="utf-8") as file:
            json.dump({"scene": "room", "colour": 1, "stop": {"samples": 0}}, file)
        run = house.glint("render", "--job", house / "job.json", "--resolution", "0x5", "-o",
                          house / "f.exr", expect=1)
        told = sorted(line.split(": ")[1] for line in run.stderr.splitlines())
        assert told == ["/colour", "/resolution/0", "/stop/samples"]
        assert not os.path.exists(house / "f.exr")


def test_what_does_not_exist_is_said_so():
    with House() as house:
        for arguments in [["jobs", "x"], ["scenes", "x"], ["watch", "x"], ["cancel", "x"],
                          ["mattes", "x"], ["plan", "x"], ["get", "x", "-o", house / "f.exr"],
                          ["matte", "x", "--name", "a", "-o", house / "m.png"],
                          ["render", "x", "-o", house / "f.exr"]]:
            assert '"x"' in house.glint(*arguments, expect=1).stderr, arguments
        assert os.listdir(house.folder.name) == ["room.json"]


def test_a_gltf_with_files_beside_it_is_rendered():
    path = tap.scenes("khronos", "Box With Spaces", "Box With Spaces.gltf")
    with House() as house:
        house.glint("render", path, *SMALL, "-o", house / "f.exr")
        assert house.document("scenes")["scenes"][0]["name"] == "Box-With-Spaces"


def test_a_broken_scene_is_refused_and_the_daemon_serves_on():
    with House() as house:
        with open(house / "cut.glb", "wb") as file:
            file.write(b"glTF\x02\x00\x00\x00\xff\x00\x00\x00")
        assert house.glint("put", house / "cut.glb", expect=1).stderr
        house.glint("put", house / "room.json")


def test_an_interrupted_render_is_cancelled_on_the_daemon():
    with House() as house:
        house.glint("put", house / "room.json")
        process = cli.start("render", "room", "--samples", 1000000, "--progress", "plain", "-o",
                            house / "f.exr", server=house.server)
        assert process.stdout.readline() == "Progress: 0%\n"
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        assert process.returncode == 130
        (job,) = house.document("jobs")["jobs"]
        house.glint("watch", job["id"], expect=130)
        assert house.document("jobs", job["id"])["state"] == "cancelled"


def test_a_private_daemon_renders_and_leaves_nothing():
    with House() as house, cli.Silence() as silent:
        os.mkdir(house / "tmp")
        run = cli.glint("render", house / "room.json", *SMALL, "-o", house / "f.exr", server=silent,
                        TMPDIR=house / "tmp")
        assert run.returncode == 0, run.stderr
        assert magic(house / "f.exr") == b"\x76\x2f\x31\x01"
        assert os.listdir(house / "tmp") == []


def test_the_demo_scene_is_taken_without_a_warning():
    program = os.path.join(os.environ.get("GLINT_BUILD", tap.build()), "glint-demo-scene")
    if not os.access(program, os.X_OK):
        raise tap.Skip("no glint-demo-scene")
    with House() as house:
        with open(house / "demo.json", "wb") as file:
            subprocess.run([program], stdout=file, check=True)
        scene = house.document("put", house / "demo.json")
        assert scene["warnings"] == [] and scene["dropped_triangles"] == 0
        assert scene["objects"] > 700 and scene["instanced_triangles"] < 450_000


if __name__ == "__main__":
    tap.main()
