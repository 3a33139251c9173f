#!/usr/bin/python3
"""Who may reach glintd and do what: tokens and scopes, jobs of one's own, HTTPS."""
import contextlib
import hashlib
import json
import os
import signal
import socket
import ssl
import subprocess
import tempfile
import time

import tap
from daemon import GLINTD, PATIENCE, ROOM, Daemon

PEOPLE = {"reader": "read", "alice": "submit", "bob": "submit", "root": "admin"}


def new_token(name, scope):
    """The secret and its line."""
    made = subprocess.run([GLINTD, "--new-token", f"{name}:{scope}"], capture_output=True,
                          text=True, timeout=PATIENCE, check=True)
    return made.stderr.strip(), made.stdout


class Tokens:
    """A token file and the header that each of PEOPLE sends."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = os.path.join(self.folder.name, "tokens")
        made = {name: new_token(name, scope) for name, scope in PEOPLE.items()}
        self.secret = {name: secret for name, (secret, _) in made.items()}
        self.line = {name: line for name, (_, line) in made.items()}
        self.write("# test\n" + "".join(self.line.values()))
        return self

    def __exit__(self, *error):
        self.folder.cleanup()

    def write(self, text):
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(text)

    def of(self, name, **headers):
        return {"Authorization": f"Bearer {self.secret[name]}", **headers}


def put(daemon, headers, name="room"):
    return daemon.ask("PUT", f"/v1/scenes/{name}", json.dumps(ROOM),
                      {"Content-Type": "application/json", **headers})


def submit(daemon, headers, **job):
    return daemon.post({"scene": "room", "resolution": [64, 48], "stop": {"samples": 1}, **job},
                       headers)


def wait_for(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_new_token_is_told_once_and_its_line_holds_only_the_digest():
    secret, line = new_token("farm@site", "submit")
    name, scope, digest = line.split()
    assert (name, scope) == ("farm@site", "submit")
    assert digest == hashlib.sha256(secret.encode()).hexdigest()
    assert len(secret) >= 64 and new_token("farm@site", "submit")[0] != secret
    for bad in ["", "name", "name:", "name:write", ":read", "two words:read", "x" * 65 + ":read"]:
        ended = subprocess.run([GLINTD, "--new-token", bad], capture_output=True, text=True,
                               timeout=PATIENCE)
        assert ended.returncode == 64 and ended.stdout == "", (bad, ended)


def test_without_a_token_only_what_tells_nothing_is_answered():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        for path in ["/", "/calls", "/healthz", "/readyz", "/openapi.yaml",
                     "/problems/unauthorized", "/viewer/page.css"]:
            assert daemon.get(path).status == 200, path
        for path in ["/v1", "/v1/scenes", "/v1/jobs", "/v1/jobs/x/frame.exr", "/metrics"]:
            answer = daemon.get(path)
            assert answer.status == 401, path
            assert answer.headers["WWW-Authenticate"] == 'Bearer realm="glint"'
            assert answer.headers["Content-Type"] == "application/problem+json"
            assert answer.json()["status"] == 401
            assert answer.json()["type"] == "/problems/unauthorized"
        assert put(daemon, {}).status == 401
        assert submit(daemon, {}).status == 401


def test_a_wrong_token_is_refused_and_named_so():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        good = tokens.secret["alice"]
        digest = tokens.line["alice"].split()[2]
        for wrong in ["x", good[:-1], good + "0", good.upper(), digest, f"{good} {good}", ""]:
            answer = daemon.get("/v1", {"Authorization": f"Bearer {wrong}"})
            assert answer.status == 401, wrong
            assert 'error="invalid_token"' in answer.headers["WWW-Authenticate"] or not wrong
        for scheme in [f"Basic {good}", good, f"bearer{good}", f"Bearer\t{good}"]:
            assert daemon.get("/v1", {"Authorization": scheme}).status == 401, scheme
        assert daemon.get("/v1", {"Authorization": f"bearer {good}"}).status == 200  # RFC 9110
        assert daemon.get(f"/v1?access_token={good}").status == 401


def test_each_scope_holds_what_it_says():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        answer = put(daemon, tokens.of("reader"))
        assert answer.status == 403, answer.body
        assert 'error="insufficient_scope", scope="submit"' in answer.headers["WWW-Authenticate"]
        assert daemon.get("/v1/scenes", tokens.of("reader")).json()["scenes"] == []
        assert put(daemon, tokens.of("alice")).status == 201
        assert daemon.get("/v1/scenes/room", tokens.of("reader")).status == 200
        assert daemon.get("/metrics", tokens.of("reader")).status == 200
        for method, path in [("PATCH", "/v1/scenes/room"), ("DELETE", "/v1/scenes/room"),
                             ("POST", "/v1/jobs"), ("PUT", "/v1/assets/" + "0" * 64)]:
            answer = daemon.ask(method, path, "{}", tokens.of(
                "reader", **{"Content-Type": "application/json"}))
            assert answer.status == 403, (method, path, answer.status)
        assert submit(daemon, tokens.of("alice")).status == 202


def test_a_client_sees_changes_and_cancels_only_its_own_jobs():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        put(daemon, tokens.of("alice"))
        jobs = {name: submit(daemon, tokens.of(name), stop={"samples": 100000}).json()["id"]
                for name in ["alice", "bob"]}

        def listed(name):
            return [job["id"] for job in daemon.get("/v1/jobs", tokens.of(name)).json()["jobs"]]

        assert listed("alice") == [jobs["alice"]]
        assert listed("bob") == [jobs["bob"]]
        assert listed("reader") == []
        assert sorted(listed("root")) == sorted(jobs.values())
        answer = daemon.get("/v1/jobs?client=bob", tokens.of("alice"))
        assert answer.status == 422, answer.body

        def working(name):
            return {worker["job"]
                    for worker in daemon.get("/v1/stats", tokens.of(name)).json()["workers"]}

        wait_for(lambda: working("root") == {jobs["alice"]} or working("root") == {jobs["bob"]})
        for name in ["alice", "bob", "reader"]:
            assert working(name) <= {jobs.get(name), None}, name
        other = "/v1/jobs/" + jobs["bob"]
        for path in ["", "/frame.exr", "/frame.png", "/tiles", "/events", "/plan", "/convergence",
                     "/mattes", "/pick?x=1&y=1"]:
            answer = daemon.get(other + path, tokens.of("alice"))
            assert answer.status == 404, path
        # Word for word what a job that does not exist answers, so that its id is not confirmed.
        missing = daemon.get("/v1/jobs/nobody", tokens.of("alice")).json()
        hidden = daemon.get(other, tokens.of("alice")).json()
        assert missing["detail"].replace("nobody", jobs["bob"]) == hidden["detail"]
        patch = {"Content-Type": "application/merge-patch+json"}
        assert daemon.ask("PATCH", other, '{"priority": 9}',
                          tokens.of("alice", **patch)).status == 404
        assert daemon.ask("DELETE", other, None, tokens.of("alice")).status == 404
        assert daemon.get(other, tokens.of("bob")).json()["priority"] == 0
        assert daemon.ask("PATCH", other, '{"priority": 3}',
                          tokens.of("root", **patch)).json()["priority"] == 3
        assert daemon.ask("DELETE", other, None, tokens.of("root")).status == 202
        assert daemon.ask("DELETE", "/v1/jobs/" + jobs["alice"], None,
                          tokens.of("alice")).status == 202


def test_one_clients_idempotency_key_is_not_anothers():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        put(daemon, tokens.of("alice"))
        key = {"Idempotency-Key": "task-1"}
        first = submit(daemon, tokens.of("alice", **key))
        assert submit(daemon, tokens.of("alice", **key)).json()["id"] == first.json()["id"]
        other = submit(daemon, tokens.of("bob", **key), resolution=[32, 32])
        assert other.status == 202 and other.json()["id"] != first.json()["id"], other.body


def test_the_name_of_the_token_counts_and_no_header():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        put(daemon, tokens.of("alice"))
        answer = submit(daemon, tokens.of("alice", **{"Glint-Client": "bob"}))
        assert answer.json()["client"] == "alice", answer.body
    with Daemon("--threads", "1") as daemon:
        daemon.put("room", ROOM)
        assert submit(daemon, {"Glint-Client": "bob"}).json()["client"] == "bob"
        assert submit(daemon, {}).json()["client"] == ""
        for bad in ["", "a b", "x" * 65, 'a"b']:
            assert submit(daemon, {"Glint-Client": bad}).status == 422, bad


def test_tokens_are_read_again_on_sighup_and_a_bad_file_keeps_the_old():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path) as daemon:
        def status(name):
            return daemon.get("/v1", tokens.of(name)).status

        tokens.write(tokens.line["bob"])
        assert status("alice") == 200  # not before it is told
        daemon.process.send_signal(signal.SIGHUP)
        wait_for(lambda: status("alice") == 401)
        assert status("bob") == 200
        tokens.write(tokens.line["alice"] + "what is this\n")
        daemon.process.send_signal(signal.SIGHUP)
        wait_for(lambda: "tokens:2: " in daemon.logged())
        assert status("alice") == 401 and status("bob") == 200


def test_a_token_file_that_is_wrong_keeps_it_from_starting():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "tokens")
        for text, code in [("", 78), ("alice\n", 78), ("alice submit 1234\n", 78)]:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            ended = subprocess.run([GLINTD, "--listen", "127.0.0.1:0", "--token-file", path],
                                   capture_output=True, text=True, timeout=PATIENCE)
            assert ended.returncode == code and path in ended.stderr, ended
        ended = subprocess.run([GLINTD, "--listen", "127.0.0.1:0", "--token-file", folder],
                               capture_output=True, text=True, timeout=PATIENCE)
        assert ended.returncode == 74, ended


def test_no_secret_reaches_the_log():
    with Tokens() as tokens, Daemon("--threads", "1", "--token-file", tokens.path, "--log-level",
                                    "debug") as daemon:
        put(daemon, tokens.of("alice"))
        daemon.get("/v1", {"Authorization": "Bearer guessed-secret"})
        daemon.get("/v1", tokens.of("root"))
        daemon.stop()
        text = daemon.logged()
        assert "client=alice" in text and "GET /v1: 401" in text, text
        for secret in [*tokens.secret.values(), "guessed-secret"]:
            assert secret not in text


# HTTPS

class Certificates:
    """Two self-signed certificates for 127.0.0.1."""

    def __enter__(self):
        openssl = tap.tool("openssl")
        self.folder = tempfile.TemporaryDirectory()
        self.cert, self.key = self.path("tls.crt"), self.path("tls.key")
        for i in range(2):
            subprocess.run(
                [openssl, "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
                 "-nodes", "-days", "2", "-subj", f"/CN=glint {i}", "-addext",
                 "subjectAltName=IP:127.0.0.1", "-keyout", self.path(f"{i}.key"), "-out",
                 self.path(f"{i}.crt")], check=True, capture_output=True, timeout=PATIENCE)
            os.chmod(self.path(f"{i}.key"), 0o600)
        self.use(0)
        return self

    def __exit__(self, *error):
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def use(self, cert, key=None):
        for kind, number in [("crt", cert), ("key", cert if key is None else key)]:
            with open(self.path(f"{number}.{kind}"), "rb") as source, \
                    open(self.path(f"tls.{kind}"), "wb") as target:
                target.write(source.read())
        os.chmod(self.key, 0o600)

    def client(self, *numbers):
        """A context that trusts only these."""
        context = ssl.create_default_context(cafile=self.path(f"{numbers[0]}.crt"))
        for number in numbers[1:]:
            context.load_verify_locations(self.path(f"{number}.crt"))
        return context

    def shown(self, daemon):
        """The common name of the certificate that it shows."""
        context = self.client(0, 1)
        with context.wrap_socket(daemon.dial(), server_hostname="127.0.0.1") as sock:
            return sock.getpeercert()["subject"][0][0][1]


def test_jobs_are_submitted_followed_and_fetched_over_https():
    with Tokens() as tokens, Certificates() as certificates, Daemon(
            "--threads", "1", "--token-file", tokens.path, "--tls-cert", certificates.cert,
            "--tls-key", certificates.key, tls=certificates.client(0),
            headers=tokens.of("alice")) as daemon:
        assert daemon.url.startswith("https://127.0.0.1:")
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 64})
        with daemon.connect(f"/v1/jobs/{job}/tiles") as tiles:
            parts = sum(1 for _ in tiles.parts())
            assert tiles.ended and parts >= 4
        with daemon.connect(f"/v1/jobs/{job}/events") as events:
            assert any(name == "done" for name, _ in events.events())
        assert daemon.frame(job)[:4] == b"\x76\x2f\x31\x01"
        big = daemon.ask("PUT", "/v1/assets/" + "0" * 64, b"x" * (8 << 20))
        assert big.status in (400, 422), big.status


def test_a_stream_over_https_is_cut_when_its_client_leaves():
    with Certificates() as certificates, Daemon(
            "--threads", "1", "--tls-cert", certificates.cert, "--tls-key", certificates.key,
            tls=certificates.client(0)) as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 100000})
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            next(stream.parts())
            daemon.wait_metric("glint_http_streams", 1)
            stream.reset()
        daemon.wait_metric("glint_http_streams", 0)


def test_old_versions_and_plain_requests_get_nothing_over_https():
    with Certificates() as certificates, Daemon(
            "--threads", "1", "--tls-cert", certificates.cert, "--tls-key", certificates.key,
            tls=certificates.client(0)) as daemon:
        with daemon.dial() as plain, contextlib.suppress(ConnectionResetError):
            plain.sendall(b"GET /v1 HTTP/1.1\r\nHost: localhost\r\n\r\n")
            assert b"HTTP/1.1 200" not in plain.recv(4096)
        old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
        old.set_ciphers("ALL:@SECLEVEL=0")
        old.minimum_version, old.maximum_version = ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1
        try:
            old.wrap_socket(daemon.dial(), server_hostname="127.0.0.1").close()
        except (ssl.SSLError, ConnectionError):
            pass
        else:
            raise AssertionError("TLS 1.1 was taken")
        assert daemon.get("/healthz").status == 200


def test_the_certificate_is_exchanged_on_sighup_and_a_bad_one_keeps_the_old():
    with Certificates() as certificates, Daemon(
            "--threads", "1", "--tls-cert", certificates.cert, "--tls-key", certificates.key,
            tls=certificates.client(0, 1)) as daemon:
        assert certificates.shown(daemon) == "glint 0"
        with daemon.tls.wrap_socket(daemon.dial(), server_hostname="127.0.0.1") as before:
            certificates.use(1)
            daemon.process.send_signal(signal.SIGHUP)
            wait_for(lambda: certificates.shown(daemon) == "glint 1")
            # A connection from before goes on.
            before.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
            assert before.recv(12) == b"HTTP/1.1 200"
        certificates.use(0, key=1)
        daemon.process.send_signal(signal.SIGHUP)
        wait_for(lambda: "is not the key of" in daemon.logged())
        assert certificates.shown(daemon) == "glint 1"


def test_a_certificate_that_is_wrong_keeps_it_from_starting():
    with Certificates() as certificates:
        def ended(cert, key, *more):
            options = [*(["--tls-cert", cert] if cert else []), *(["--tls-key", key] if key else [])]
            return subprocess.run([GLINTD, "--listen", "127.0.0.1:0", *options, *more],
                                  capture_output=True, text=True, timeout=PATIENCE)

        assert ended(certificates.cert, None).returncode == 78
        assert ended(None, certificates.key).returncode == 78
        wrong = ended(certificates.cert, certificates.path("1.key"))
        assert wrong.returncode == 78 and "is not the key of" in wrong.stderr, wrong
        wrong = ended(certificates.key, certificates.cert)
        assert wrong.returncode == 78, wrong
        os.chmod(certificates.key, 0o644)
        wrong = ended(certificates.cert, certificates.key)
        assert wrong.returncode == 74 and "everybody may use this key" in wrong.stderr, wrong


def test_another_address_than_loopback_needs_tokens_and_tls():
    with Tokens() as tokens, Certificates() as certificates, \
            tempfile.TemporaryDirectory() as folder:
        guard = ["--token-file", tokens.path]
        cover = ["--tls-cert", certificates.cert, "--tls-key", certificates.key]
        for options, missing in [([], "neither"), (guard, "no certificate"), (cover, "no tokens")]:
            ended = subprocess.run([GLINTD, "--listen", "0.0.0.0:0", "--state",
                                    os.path.join(folder, "none"), *options],
                                   capture_output=True, text=True, timeout=PATIENCE)
            assert ended.returncode == 64 and missing in ended.stderr, ended
        with subprocess.Popen([GLINTD, "--listen", "0.0.0.0:0", "--state", folder, "--threads", "1",
                               *guard, *cover], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              text=True) as process:
            try:
                line = process.stdout.readline()
                assert line.startswith("glintd: listening on https://0.0.0.0:"), line
                with socket.create_connection(("127.0.0.1", int(line.rsplit(":", 1)[1])),
                                              PATIENCE) as raw, \
                        certificates.client(0).wrap_socket(raw, server_hostname="127.0.0.1") as s:
                    # It goes by many names there, so it asks nobody which he used.
                    s.sendall(b"GET /v1 HTTP/1.1\r\nHost: render.example\r\n\r\n")
                    assert s.recv(12) == b"HTTP/1.1 401"
            finally:
                process.terminate()
                assert process.wait(PATIENCE) == 0


def test_credentials_of_the_service_manager_are_found():
    with Tokens() as tokens, Certificates() as certificates:
        os.replace(tokens.path, certificates.path("tokens"))
        with Daemon("--threads", "1", tls=certificates.client(0),
                    environment={"CREDENTIALS_DIRECTORY": certificates.folder.name}) as daemon:
            assert daemon.url.startswith("https:")
            assert daemon.get("/v1").status == 401
            assert daemon.get("/v1", tokens.of("reader")).status == 200


if __name__ == "__main__":
    tap.main()
