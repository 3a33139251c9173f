#!/usr/bin/python3
"""Who a glint command says that it is: its user, and the token that a daemon knows it by."""
import os
import pwd
import re
import tempfile

import cli
import tap
from fake_daemon import Answer, FakeDaemon


def asked(daemon, *arguments, **more):
    """The headers that `glint jobs` sends."""
    daemon.on("GET", "/v1/jobs", Answer(200, {"jobs": []}))
    run = cli.glint("jobs", *arguments, server=daemon.url, **more)
    assert run.returncode == 0, run.stderr
    return daemon.requests[-1].headers


def test_each_request_names_its_user():
    name = pwd.getpwuid(os.geteuid()).pw_name
    with FakeDaemon() as daemon:
        assert asked(daemon)["Glint-Client"] == re.sub(r"[^A-Za-z0-9._@-]", "", name)[:64]


def test_a_token_comes_from_a_file_else_from_the_environment():
    with FakeDaemon() as daemon, tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "token")
        with open(path, "w", encoding="ascii") as file:
            file.write("of-the-file\r\nsecond line\n")
        assert "Authorization" not in asked(daemon)
        assert "Authorization" not in asked(daemon, GLINT_TOKEN="")
        assert asked(daemon, GLINT_TOKEN="spoken")["Authorization"] == "Bearer spoken"
        headers = asked(daemon, "--token-file", path, GLINT_TOKEN="spoken")
        assert headers["Authorization"] == "Bearer of-the-file"


def test_a_token_that_no_header_can_carry_is_refused_unsent():
    with FakeDaemon() as daemon:
        for token in ["two words", "tab\there", "caf\u00e9", "line\nX-Other: 1", "x" * 5000]:
            run = cli.glint("jobs", server=daemon.url, GLINT_TOKEN=token)
            assert run.returncode == 64 and "token" in run.stderr, run
            assert token not in run.stderr
        run = cli.glint("jobs", "--token-file", "/nowhere/token", server=daemon.url)
        assert run.returncode == 1 and "/nowhere/token" in run.stderr
        assert daemon.requests == []


def test_a_token_crosses_no_network_in_the_clear():
    for server in ["http://render.example:7745", "render.example", "http://192.0.2.1",
                   "http://localhost.example", "ftp://127.0.0.1"]:
        run = cli.glint("jobs", "-s", server, GLINT_TOKEN="secret")
        assert run.returncode == 64 and "https://" in run.stderr, (server, run)


def test_certificates_are_read_from_the_named_file():
    for given in [{"GLINT_CA_FILE": "/nowhere/ca.pem"}, {}]:
        arguments = [] if given else ["--ca-file", "/nowhere/ca.pem"]
        with FakeDaemon() as daemon:  # it speaks no TLS: the file is missed before that shows
            server = daemon.url.replace("http:", "https:")
            run = cli.glint("jobs", *arguments, "-s", server, **given)
            assert run.returncode == 69 and "CA cert" in run.stderr, run


if __name__ == "__main__":
    tap.main()
