#!/usr/bin/python3
"""Completion for bash: it offers what --help lists and what the daemon has."""
import os
import subprocess
import tempfile

import cli
import tap
from fake_daemon import Answer, FakeDaemon


def complete(*words, server="http://127.0.0.1:9"):
    """What is offered for the last of the words."""
    tap.tool("bash")
    script = (f'source {tap.source("deploy", "completion", "glint")}; COMP_WORDS=("$@"); '
              'COMP_CWORD=$(($# - 1)); _glint; printf "%s\\n" "${COMPREPLY[@]}"')
    path = os.path.dirname(os.path.abspath(cli.PROGRAM)) + os.pathsep + os.environ["PATH"]
    with tempfile.TemporaryDirectory() as empty:
        run = subprocess.run(["bash", "-c", script, "bash", "glint", *words], text=True,
                             env=cli.environment(PATH=path, GLINT_SERVER=server), cwd=empty,
                             timeout=60, capture_output=True, check=False)
    assert run.stderr == "", run.stderr
    return set(run.stdout.split())


def test_commands_are_those_of_the_help():
    listed = {line.split()[0] for line in cli.glint("--help").stdout.splitlines()
              if line.startswith("  ")}
    assert complete("") == listed and len(listed) > 14
    assert complete("re") == {"render", "recolor"}


def test_options_are_those_of_the_command():
    assert "--color" in complete("recolor", "--") and "--color" not in complete("pick", "--")
    assert complete("get", "--exp") == {"--exposure"}
    assert complete("matte", "--layer", "m") == {"material"}


def test_jobs_and_scenes_are_those_of_the_daemon():
    with FakeDaemon() as daemon:
        daemon.on("GET", "/v1/jobs", Answer(200, {"jobs": [{"id": "abc1"}, {"id": "bcd2"}]}))
        daemon.on("GET", "/v1/scenes", Answer(200, {"scenes": [{"name": "attic"}]}))
        assert complete("watch", "", server=daemon.url) >= {"abc1", "bcd2"}
        assert complete("update", "a", server=daemon.url) == {"abc1", "attic"}


if __name__ == "__main__":
    tap.main()
