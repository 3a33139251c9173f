#!/usr/bin/python3
"""glint update, and the options of time and of live jobs, against a daemon that only listens."""
import json
import os
import signal
import subprocess
import tempfile

import cli
import tap
from fake_daemon import Answer, FakeDaemon, problem

PATCH = {"materials": {"gold": {"roughness": 0.4}}, "lights": {"sun": None}}
CHANGES = {"rebuilt": ["materials", "lights"], "uploaded": [], "later": ["placement"],
           "kept": ["meshes", "textures"],
           "milliseconds": {"materials": 0.21, "lights": 1.0, "placement": 0, "meshes": 0,
                            "textures": 0, "parse": 1.4, "total": 3.14159}}
SCENE = {"name": "room", "revision": "ab" * 32, "triangles": 12, "changes": CHANGES}


def update(daemon, *arguments, text=None):
    """glint update room, of a file that has the text."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "patch.json")
        with open(path, "w", encoding="utf-8") as file:
            file.write(json.dumps(PATCH) if text is None else text)
        return cli.glint("update", "room", path, *arguments, server=daemon.url)


def test_an_update_says_what_was_rebuilt_and_kept():
    with FakeDaemon() as daemon:
        daemon.on("PATCH", "/v1/scenes/room", Answer(200, SCENE))
        run = update(daemon)
        assert run.returncode == 0, run.stderr
        assert run.stdout == (f"revision: {'ab' * 32}\n"
                              "rebuilt: materials 0.2 ms, lights 1.0 ms\n"
                              "later: placement\n"
                              "kept: meshes, textures\n"
                              "total: 3.1 ms\n")
        request = daemon.requests[-1]
        assert request.headers["Content-Type"] == "application/merge-patch+json"
        assert "If-Match" not in request.headers and json.loads(request.body) == PATCH
        assert json.loads(update(daemon, "--json").stdout) == SCENE


def test_a_patch_may_come_from_standard_input():
    with FakeDaemon() as daemon:
        daemon.on("PATCH", "/v1/scenes/a%2Fb", Answer(200, SCENE))
        text = json.dumps({"materials": {str(i): {} for i in range(20000)}})
        run = subprocess.run([cli.PROGRAM, "update", "a/b", "-", "-s", daemon.url], text=True,
                             input=text, capture_output=True, timeout=60, check=False)
        assert run.returncode == 0, run.stderr
        assert daemon.requests[-1].body.decode() == text


def test_if_match_sends_the_revision_as_an_entity_tag():
    with FakeDaemon() as daemon:
        daemon.on("PATCH", "/v1/scenes/room", problem(412, "the scene's revision is another"))
        for given, sent in [("abc", '"abc"'), ('"abc"', '"abc"'), ("*", "*")]:
            run = update(daemon, "--if-match", given)
            assert run.returncode == 75 and "revision is another" in run.stderr
            assert daemon.requests[-1].headers["If-Match"] == sent


def test_what_cannot_be_sent_is_told():
    with FakeDaemon() as daemon:
        run = cli.glint("update", "room", "/nowhere/patch.json", server=daemon.url)
        assert run.returncode == 1 and "/nowhere/patch.json" in run.stderr
        assert daemon.requests == []
        assert cli.glint("update", "room", server=daemon.url).returncode == 64


def test_every_fault_of_an_edit_has_its_pointer():
    faults = [{"pointer": "/materials/gold/roughness", "detail": "2 is outside of 0 to 1"},
              {"pointer": "/lights/sun/node", "detail": "no node has the id \"x\""}]
    with FakeDaemon() as daemon:
        daemon.on("PATCH", "/v1/scenes/room", problem(422, "2 faults", faults))
        run = update(daemon)
        assert run.returncode == 1
        for fault in faults:
            assert f"glint: {fault['pointer']}: {fault['detail']}\n" in run.stderr


def test_an_answer_without_changes_is_still_an_answer():
    with FakeDaemon() as daemon:
        for changes in [{}, {"changes": None}, {"changes": {"rebuilt": [7, None], "kept": "all",
                                                            "milliseconds": []}}]:
            daemon.on("PATCH", "/v1/scenes/room", Answer(200, {"revision": 5, **changes}))
            assert update(daemon).returncode == 0


def test_an_interrupt_while_a_patch_is_typed_exits_130():
    with cli.Silence() as server:
        run = subprocess.Popen([cli.PROGRAM, "update", "room", "-", "-s", server], text=True,
                               stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        run.stdin.write("{")
        run.stdin.flush()
        try:
            run.wait(0.5)
        except subprocess.TimeoutExpired:
            run.send_signal(signal.SIGINT)
        assert run.wait(20) == 130, run.stderr.read()


def posted(daemon):
    return json.loads([r for r in daemon.requests if r.method == "POST"][-1].body)


def test_options_of_time_become_members_of_the_job():
    with FakeDaemon() as daemon, tempfile.TemporaryDirectory() as folder:
        run = cli.glint("render", "room", "-o", os.path.join(folder, "f.exr"), "--frame", 12,
                        "--fps", 23.976, "--shutter=-0.25,0.5", "--animation", "walk",
                        server=daemon.url)
        assert run.returncode == 0, run.stderr
        assert posted(daemon) == {"scene": "room", "frame": 12, "fps": 23.976,
                                  "shutter": [-0.25, 0.5], "animation": "walk"}
        for bad in ["0.5", "0,", ",1", "0,1,2", "a,b", "0;1"]:
            run = cli.glint("render", "room", "-o", "f.exr", "--shutter", bad, server=daemon.url)
            assert run.returncode == 64 and "--shutter wants OPEN,CLOSE" in run.stderr, bad


def test_a_live_job_is_submitted_and_left_alone():
    with FakeDaemon() as daemon:
        run = cli.glint("render", "room", "--live", server=daemon.url)
        assert run.returncode == 0 and run.stdout == "job1\n", run.stderr
        assert posted(daemon) == {"scene": "room", "live": True}
        assert daemon.seen() == ["POST /v1/jobs"]
        assert json.loads(cli.glint("render", "room", "--live", "--json",
                                    server=daemon.url).stdout)["id"] == "job1"
        run = cli.glint("render", "room", "--live", "-o", "f.exr", server=daemon.url)
        assert run.returncode == 64 and "f.exr" in run.stderr and "glint get" in run.stderr
    with cli.Silence() as server, tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "room.json")
        with open(path, "w", encoding="utf-8") as file:
            file.write("{}")
        run = cli.glint("render", path, "--live", server=server)  # a private one would end with it
        assert run.returncode == 69, run


if __name__ == "__main__":
    tap.main()
