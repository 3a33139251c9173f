#!/usr/bin/python3
"""glint's command line: help, usage faults, exit codes."""
import json
import os
import re
import shlex
import subprocess
import tempfile

import cli
import tap
from fake_daemon import Answer, FakeDaemon, problem

COMMANDS = {"put": ["x.glb"], "scenes": [], "update": ["s", "patch.json"], "render": ["x"],
            "submit": ["x"], "jobs": [], "watch": ["j"], "top": [], "get": ["j"], "cancel": ["j"],
            "mattes": ["j"], "matte": ["j"], "pick": ["j", "1", "2"], "recolor": ["j"],
            "plan": ["j"]}


def test_each_command_explains_itself():
    overview = cli.glint("--help")
    assert overview.returncode == 0
    for command in COMMANDS:
        assert f"\n  {command} " in overview.stdout
        run = cli.glint(command, "--help")
        assert run.returncode == 0 and run.stderr == ""
        assert run.stdout.startswith(f"Usage: glint {command} ")
        assert "--json" in run.stdout


def test_help_fits_into_80_columns():
    for command in [[], *([command] for command in COMMANDS)]:
        for line in cli.glint(*command, "--help").stdout.splitlines():
            assert len(line) < 80, (command, line)


def test_what_the_quickstart_proposes_is_a_command():
    with open(tap.source("deploy", "quickstart"), encoding="utf-8") as script:
        proposed = re.search(r"^Try +\$build/glint (.*)$", script.read(), re.M)[1]
    with cli.Silence() as server:
        words = shlex.split(proposed.replace("$url", server).replace("$(job)", "j1"))
        run = cli.glint(*words)
        assert run.returncode == 69 and server in run.stderr, run  # asked, and nobody answered


def test_version_is_told_by_each_command():
    version = cli.glint("--version").stdout
    assert version.startswith("glint ")
    for command in COMMANDS:
        assert cli.glint(command, "--version").stdout == version


def test_wrong_usage_exits_64_and_names_the_fault():
    for arguments, named in [
            ([], "Usage"), (["paint"], "paint"), (["jobs", "--colour"], "--colour"),
            (["watch"], "JOB"), (["plan", "a", "b"], "'b'"), (["render", "x", "-o"], "FILE"),
            (["jobs", "--json=yes"], "--json"), (["jobs", "-x"], "-x"),
            (["render", "x", "-o", "frame.gif"], "frame.gif"), (["get", "j"], "-o FILE"),
            (["matte", "j", "-o", "m.png"], "--name"),
            (["matte", "j", "-o", "m.png", "--name", "a", "--layer", "light"], "--layer"),
            (["watch", "j", "--progress", "loud"], "--progress"),
            (["submit"], "SCENE"), (["submit", "x", "-o", "f.exr"], "-o"),
            (["update", "j"], "--priority"), (["update", "j", "--pause", "--resume"], "--resume"),
            (["update", "j", "--samples", "1.5"], "1.5"), (["update", "j", "--error", "x"], "'x'"),
            (["update", "s", "p.json", "--pause"], "PATCH"),
            (["update", "j", "--pause", "--if-match", "a"], "--if-match"),
            (["pick", "j", "1"], "JOB X Y"), (["pick", "j", "1", "-2"], "-2"),
            (["pick", "j", "x", "1"], "'x'"), (["pick", "j", "1", "2", "-l", "light"], "--layer"),
            (["top", "-d", "0"], "--delay"), (["top", "-n", "0"], "--times"),
            (["top", "j"], "'j'"),
            (["recolor", "j", "-o", "a.exr", "-n", "a"], "--color"),
            (["recolor", "j", "-o", "a.exr", "-c", "red", "-n", "a"], "'red'"),
            (["recolor", "j", "-o", "a.exr", "-c", "#12345", "-n", "a"], "#12345"),
            (["recolor", "j", "-o", "a.exr", "-c", "1,2", "-n", "a"], "1,2"),
            (["recolor", "j", "-o", "a.exr", "-c", "1,2,-3", "-n", "a"], "-3"),
            (["recolor", "j", "-o", "a.tif", "-c", "1,2,3", "-n", "a"], "a.tif"),
            (["recolor", "j", "-o", "a.png", "-c", "#fff", "-n", "a", "--exposure", "99"], "99"),
            (["get", "j", "-o", "x.png", "--exposure", "bright"], "bright")]:
        run = cli.glint(*arguments)
        assert run.returncode == 64, (arguments, run)
        assert named in run.stderr, (arguments, run.stderr)
        assert run.stdout == ""


def test_every_malformed_value_is_named_at_once():
    run = cli.glint("render", "x", "-o", "f.exr", "--samples", "-1", "--resolution", "64",
                    "--region", "1,2,3", "--error", "small", "--outputs", "a,,b")
    assert run.returncode == 64
    for option in ["samples", "resolution", "region", "error", "outputs"]:
        assert f"--{option} wants" in run.stderr


def test_a_document_is_no_series_of_looks():
    run = cli.glint("top", "--json", "-n", "2")
    assert run.returncode == 64 and "--times" in json.loads(run.stdout)["detail"]


def test_usage_faults_are_a_document_with_json():
    run = cli.glint("render", "--json", "--samples", "x")
    assert run.returncode == 64
    details = [fault["detail"] for fault in json.loads(run.stdout)["errors"]]
    assert any("--samples" in detail for detail in details) and len(details) == 3


def test_silence_at_the_server_exits_69():
    more = {"put": ["scene.glb"], "render": ["scene.glb", "-o", "f.exr", "--no-spawn"],
            "submit": ["scene.glb"],
            "recolor": ["j", "-o", "f.exr", "--name", "a", "--color", "#fff"],
            "get": ["j", "-o", "f.exr"], "matte": ["j", "-o", "m.exr", "--name", "a"]}
    with cli.Silence() as server, tempfile.TemporaryDirectory() as folder:
        for name in ["scene.glb", "patch.json"]:
            with open(os.path.join(folder, name), "wb") as file:
                file.write(b"glTF")
        for command, operands in COMMANDS.items():
            run = cli.glint(command, *more.get(command, operands), server=server, cwd=folder)
            assert run.returncode == 69, (command, run)
            assert server in run.stderr
        assert sorted(os.listdir(folder)) == ["patch.json", "scene.glb"]


def test_the_option_wins_over_the_environment():
    with FakeDaemon() as daemon, cli.Silence() as silent:
        daemon.on("GET", "/v1/jobs", Answer(200, {"jobs": []}))
        assert cli.glint("jobs", "--server", daemon.url + "/", server=silent).returncode == 0
        assert cli.glint("jobs", "-s", silent, server=daemon.url).returncode == 69
        bare = daemon.url.removeprefix("http://")
        assert cli.glint("jobs", "-s", bare).returncode == 0


def test_every_fault_of_a_problem_is_a_line_with_its_pointer():
    faults = [{"pointer": "/camera/yfov", "detail": "4 is not below pi"},
              {"pointer": "/stop/samples", "detail": "0 is too few"},
              {"pointer": "/colour", "detail": "unknown member"}]
    with FakeDaemon() as daemon, tempfile.TemporaryDirectory() as folder:
        daemon.on("POST", "/v1/jobs", problem(422, "3 faults", faults))
        out = os.path.join(folder, "f.exr")
        run = cli.glint("render", "scene", "-o", out, server=daemon.url)
        assert run.returncode == 1
        for fault in faults:
            assert f"glint: {fault['pointer']}: {fault['detail']}\n" in run.stderr
        assert os.listdir(folder) == []
        run = cli.glint("render", "--json", "scene", "-o", out, server=daemon.url)
        assert run.returncode == 1 and json.loads(run.stdout)["errors"] == faults
        assert json.loads(run.stdout)["status"] == 422


def test_answers_of_each_kind_have_their_exit_code():
    for status, code in [(400, 1), (404, 1), (413, 1), (422, 1), (429, 75), (503, 75), (507, 75),
                         (500, 1), (418, 1), (599, 1)]:
        with FakeDaemon() as daemon:
            daemon.on("GET", "/v1/jobs", problem(status, f"because of {status}"))
            run = cli.glint("jobs", server=daemon.url)
            assert run.returncode == code, (status, run)
            assert f"because of {status}" in run.stderr


def test_an_answer_that_is_no_json_is_an_error():
    with FakeDaemon() as daemon:
        for body in [b"", b"<html>", b"[1]", b'{"jobs": [', b"\xff\xfe"]:
            daemon.on("GET", "/v1/jobs", Answer(200, body))
            run = cli.glint("jobs", server=daemon.url)
            assert run.returncode == 1 and "no JSON object" in run.stderr, body
        daemon.on("GET", "/v1/jobs", Answer(500, b"<html>oops</html>"))
        assert "500" in cli.glint("jobs", server=daemon.url).stderr


def test_names_cannot_steer_the_terminal():
    with FakeDaemon() as daemon:
        evil = "a\x1b[2Jb\u009b2J\nc"
        daemon.on("GET", "/v1/jobs", Answer(200, {"jobs": [{"id": evil, "state": "done"}]}))
        run = cli.glint("jobs", server=daemon.url)
        assert run.returncode == 0 and "a?[2Jb?2J?c" in run.stdout
        assert "\x1b" not in run.stdout and "\u009b" not in run.stdout
        daemon.on("GET", "/v1/jobs", problem(422, evil))
        assert "\x1b" not in cli.glint("jobs", server=daemon.url).stderr


def test_names_in_paths_are_escaped():
    with FakeDaemon() as daemon:
        cli.glint("jobs", "../a b/\u00e9?x", server=daemon.url)
        cli.glint("scenes", "..", server=daemon.url)
        assert daemon.requests[0].target == "/v1/jobs/..%2Fa%20b%2F%C3%A9%3Fx"
        assert daemon.requests[1].target == "/v1/scenes/.."


def test_lists_are_tables_and_with_json_what_the_daemon_said():
    jobs = {"jobs": [{"id": "j1", "state": "rendering", "progress": 0.25, "samples": 16,
                      "error": 0.5, "seconds": 1.5, "scene": "a", "name": "shot",
                      "invariants": {"sound": True}},
                     {"id": "j2", "state": "queued"}]}
    with FakeDaemon() as daemon:
        daemon.on("GET", "/v1/jobs", Answer(200, jobs))
        lines = cli.glint("jobs", server=daemon.url).stdout.splitlines()
        assert lines[0].split() == ["JOB", "STATE", "DONE", "SAMPLES", "ERROR", "SOUND", "TIME", "SCENE",
                                    "NAME"]
        assert lines[1].split() == ["j1", "rendering", "25.0%", "16", "0.5", "yes", "1.5", "s", "a",
                                    "shot"]
        assert lines[2].split() == ["j2", "queued"] + ["-"] * 7
        assert json.loads(cli.glint("jobs", "--json", server=daemon.url).stdout) == jobs


def test_mattes_lists_what_is_seen_the_largest_first():
    names = [{"name": "small", "hash": "00000001", "coverage": 2.5},
             {"name": "hidden", "hash": "00000002", "coverage": 0},
             {"name": "two words", "hash": "00000003", "coverage": 1000}]
    mattes = {"layers": {"object": {"names": names, "lost": 0}, "asset": {"names": []}}}
    with FakeDaemon() as daemon:
        daemon.on("GET", "/v1/jobs/j/mattes", Answer(200, mattes))
        run = cli.glint("mattes", "--layer", "object", "j", server=daemon.url)
        assert run.stdout == ("object:\n"
                              "NAME       HASH      PIXELS\n"
                              "two words  00000003  1000\n"
                              "small      00000001  2.5\n")
        assert cli.glint("mattes", "j", server=daemon.url).stdout == (
            run.stdout + "asset:\nNAME  HASH  PIXELS\n")
        assert json.loads(cli.glint("mattes", "--json", "j", server=daemon.url).stdout) == mattes


def test_what_bounces_bring_of_a_name_has_a_column_for_each_class_of_the_job():
    names = [{"name": "pane", "hash": "00000001", "coverage": 9, "reflection": 0, "refraction": 0.5},
             {"name": "behind", "hash": "00000002", "coverage": 0, "reflection": 0, "refraction": 12.25},
             {"name": "hidden", "hash": "00000003", "coverage": 0, "reflection": 0, "refraction": 0}]
    bins = [{"name": "far", "hash": "00000004", "coverage": 1, **{f"depth{i}": i for i in range(10)}}]
    with FakeDaemon() as daemon:
        daemon.on("GET", "/v1/jobs/j/mattes", Answer(200, {"layers": {"object": {"names": names}}}))
        assert cli.glint("mattes", "j", server=daemon.url).stdout == (
            "object:\n"
            "NAME    HASH      PIXELS  REFLECTION  REFRACTION\n"
            "behind  00000002  0       0           12.25\n"
            "pane    00000001  9       0           0.5\n")
        daemon.on("GET", "/v1/jobs/d/mattes", Answer(200, {"layers": {"object": {"names": bins}}}))
        assert cli.glint("mattes", "d", server=daemon.url).stdout.split() == [
            "object:", "NAME", "HASH", "PIXELS", *(f"DEPTH{i}" for i in range(10)),
            "far", "00000004", "1", *(str(i) for i in range(10))]


def test_a_matte_is_the_union_of_the_names_given():
    with FakeDaemon() as daemon, tempfile.TemporaryDirectory() as folder:
        daemon.on("GET", "/v1/jobs/j/matte.png", Answer(200, b"a matte"))
        out = os.path.join(folder, "m.png")
        run = cli.glint("matte", "j", "--name", "a b", "--name", "c&d", "-o", out, server=daemon.url)
        assert run.returncode == 0, run.stderr
        assert daemon.requests[0].query == "layer=object&name=a%20b&name=c%26d"
        with open(out, "rb") as file:
            assert file.read() == b"a matte"


def test_a_plan_shows_effects_and_passes():
    plan = {"effects": [{"effect": "alpha mask", "on": False, "reason": "no material is masked",
                         "bytes": 0}],
            "passes": [{"pass": "shade", "seconds": 1.5, "share": 0.25}], "film_bytes": 2048}
    with FakeDaemon() as daemon:
        daemon.on("GET", "/v1/jobs/j/plan", Answer(200, plan))
        shown = cli.glint("plan", "j", server=daemon.url).stdout
        assert "alpha mask  no  -     0 B     no material is masked\n" in shown
        assert "shade  25.0%  1.5 s\n" in shown and "film: 2.0 KiB\n" in shown


def test_a_full_disk_behind_stdout_is_a_failure():
    with open("/dev/full", "w", encoding="ascii") as full:
        run = subprocess.run([cli.PROGRAM, "--help"], stdout=full, stderr=subprocess.PIPE,
                             check=False)
    assert run.returncode == 1


if __name__ == "__main__":
    tap.main()
