"""What a stranger may send: each request gets its status, and the daemon serves on."""
import hashlib
import re

import tap
from daemon import Daemon

END = b"Host: localhost\r\nConnection: close\r\n\r\n"

# (statuses that will do, request). An empty answer (0) is a connection closed without a word.
RAW = [
    ({200}, b"GET /healthz HTTP/1.1\r\n" + END),
    ({200}, b"GET /healthz HTTP/1.0\r\n\r\n"),
    ({200}, b"GET / HTTP/1.1\r\n" + END),
    ({404}, b"GET /../etc/passwd HTTP/1.1\r\n" + END),
    ({404}, b"GET /v1/scenes/..%2f..%2fetc HTTP/1.1\r\n" + END),
    ({404}, b"GET /v1/jobs/%F0%9F%8C%9E HTTP/1.1\r\n" + END),
    ({400}, b"GET /v1/jobs/%80 HTTP/1.1\r\n" + END),
    ({400}, b"GET /v1/jobs/a%00 HTTP/1.1\r\n" + END),
    ({405}, b"POST /healthz HTTP/1.1\r\nContent-Length: 0\r\n" + END),
    ({405}, b"OPTIONS /v1/jobs HTTP/1.1\r\n" + END),
    ({400}, b"POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\n"
            b"Transfer-Encoding: gzip\r\n" + END + b"{}"),
    ({400}, b"POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 2\r\n"
            b"Transfer-Encoding: chunked\r\n" + END + b"2\r\n{}\r\n0\r\n\r\n"),
    ({400}, b"POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\n" + END),
    ({400, 413, 0}, b"POST /v1/jobs HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n" + END),
    ({400, 413, 0}, b"POST /v1/jobs HTTP/1.1\r\nContent-Length: 5, 5\r\n" + END),
    ({413}, b"POST /v1/jobs HTTP/1.1\r\nContent-Type: application/json\r\n"
            b"Content-Length: 1048577\r\n" + END),
    ({413}, b"PUT /v1/scenes/a HTTP/1.1\r\nContent-Length: 3000000000\r\n" + END),
    ({413}, b"PUT /v1/scenes/a HTTP/1.1\r\nContent-Length: 3000000000\r\n"
            b"Expect: 100-continue\r\n" + END),
    ({415}, b"POST /v1/jobs HTTP/1.1\r\nContent-Type: text/plain\r\nContent-Length: 2\r\n" + END
     + b"{}"),
    ({421}, b"GET /v1/jobs HTTP/1.1\r\nHost: attacker.example\r\nConnection: close\r\n\r\n"),
    ({400, 0}, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n"),
    ({400, 0}, b"NONSENSE\r\n\r\n"),
    ({400, 413, 431, 0}, b"GET /healthz HTTP/1.1\r\nA: " + b"x" * 200000 + b"\r\n" + END),
    ({400, 414, 413, 431, 0}, b"GET /" + b"x" * 200000 + b" HTTP/1.1\r\n" + END),
]


def status(answer):
    return int(answer.split(b" ", 2)[1]) if answer else 0


def test_raw_requests_get_their_status_and_the_daemon_serves_on():
    with Daemon() as daemon:
        for allowed, request in RAW:
            answer = daemon.raw(request)
            assert status(answer) in allowed, (request[:80], answer[:300])
        assert daemon.get("/healthz").status == 200


def test_a_type_that_is_not_taken_is_answered_with_all_that_are():
    wanted = {
        ("PUT", "/v1/scenes/a"): "model/gltf-binary, model/gltf+json, model/obj, model/stl, "
                                 "application/ply, application/json, multipart/form-data, "
                                 "application/octet-stream",
        ("PATCH", "/v1/scenes/a"): "application/merge-patch+json, application/json",
        ("POST", "/v1/jobs"): "application/json",
        ("PATCH", "/v1/jobs/a"): "application/merge-patch+json, application/json",
    }
    with Daemon() as daemon:
        for (method, path), types in wanted.items():
            answer = daemon.ask(method, path, b"{}", {"Content-Type": "text/plain"})
            assert answer.status == 415 and answer.headers["Accept"] == types, answer.body
            assert types in answer.json()["detail"]


def faulty_parameters(answer):
    return sorted(fault["detail"].partition(":")[0] for fault in answer.json()["errors"])


def test_every_fault_of_a_query_is_named_in_one_answer():
    job = "/v1/jobs/none"
    faults = {
        f"{job}/frame.exr?layout=x&pixels=y&wait=y&z=1&outputs=smell":
            ["layout", "outputs", "pixels", "wait", "z"],
        f"{job}/frame.png?exposure=loud&exposure=1&q=1": ["exposure", "exposure", "q"],
        f"{job}/matte.png?through=wall&layer=skin&z=": ["layer", "name", "through", "z"],
        f"{job}/pick?x=-1&y=a&z=1": ["x", "y", "z"],
        f"{job}/tiles?since=then&z=1": ["since", "z"],
        "/v1/scenes/none?format=usd&z=1": ["format", "z"],
        "/v1?a=1&b=2": ["a", "b"],
    }
    with Daemon() as daemon:
        for path, names in faults.items():
            answer = daemon.get(path)
            assert answer.status == 422, (path, answer.body)
            assert faulty_parameters(answer) == names, (path, answer.body)


def test_no_call_takes_a_parameter_that_it_does_not_know():
    with Daemon() as daemon:
        for method, path in calls_of_contract(daemon.get("/openapi.yaml").body.decode()):
            answer = daemon.ask(method, path.replace("{}", "none") + "?smell=1")
            assert answer.status == 422, (method, path, answer.status)
            assert "smell" in faulty_parameters(answer), (method, path, answer.body)


TRACE, SPAN = "4bf92f3577b34da6a3ce929d0e0e4736", "00f067aa0ba902b7"
NO_TRACES = [
    None, "", "00", f"01-{TRACE}-{SPAN}-01", f"ff-{TRACE}-{SPAN}-01", f"00-{TRACE}-{SPAN}",
    f"00-{TRACE}-{SPAN}-01-x", f"00-{TRACE}-{SPAN}-0g", f"00-{TRACE}-{SPAN}-001",
    f"00-{TRACE.upper()}-{SPAN}-01", f"00-{'0' * 32}-{SPAN}-01", f"00-{TRACE}-{'0' * 16}-01",
    f"00-{TRACE[1:]}-{SPAN}-01", f"00-{TRACE}0-{SPAN}-01", f"00-{TRACE}-{SPAN}0-01",
    f"00_{TRACE}_{SPAN}_01", f"00-{TRACE}-{SPAN}-01" + "0" * 5000, "00-%s%n-\t",
]


def trace_of(answer):
    """trace-id, parent-id and flags, of which neither ID is zero."""
    found = re.fullmatch(r"00-([0-9a-f]{32})-([0-9a-f]{16})-(0[01])",
                         answer.headers["traceparent"])
    assert found and int(found[1], 16) and int(found[2], 16), answer.headers["traceparent"]
    return found.groups()


def test_a_trace_is_continued_in_the_answer_and_the_log():
    with Daemon(environment={"GLINT_DEBUG": "http"}) as daemon:
        for flags, kept in (("01", "01"), ("00", "00"), ("fe", "00"), ("ff", "01")):
            answer = daemon.get("/v1/jobs/none", {"traceparent": f"00-{TRACE}-{SPAN}-{flags}"})
            trace, span, sampled = trace_of(answer)
            assert (trace, sampled) == (TRACE, kept) and span != SPAN
        assert daemon.stop() == 0
        lines = [line for line in daemon.logged().splitlines() if f"trace={TRACE}" in line]
        assert len(lines) == 4 and all(": 404, " in line for line in lines), daemon.logged()


def test_a_trace_that_is_missing_or_malformed_begins_anew():
    with Daemon() as daemon:
        made = set()
        for given in NO_TRACES:
            answer = daemon.get("/healthz", {} if given is None else {"traceparent": given})
            trace, _, sampled = trace_of(answer)
            assert answer.status == 200 and sampled == "00" and trace != TRACE, given
            made.add(trace)
        assert len(made) == len(NO_TRACES)
        line = f"traceparent: 00-{TRACE}-{SPAN}-01\r\n".encode()
        answer = daemon.raw(b"GET /healthz HTTP/1.1\r\n" + line + line + END)
        assert status(answer) == 200 and TRACE.encode() not in answer


def test_every_problem_names_itself_and_its_request():
    with Daemon() as daemon:
        answer = daemon.get("/v1/jobs/none", {"X-Request-Id": "shot-7"})
        problem = answer.json()
        assert answer.status == problem["status"] == 404
        assert answer.headers["Content-Type"] == "application/problem+json"
        assert answer.headers["X-Request-Id"] == problem["request_id"] == "shot-7"
        assert problem["type"].startswith("/problems/") and problem["title"] and problem["detail"]
        assert daemon.get("/v1/jobs/none").json()["request_id"] != "shot-7"


def test_the_type_of_a_problem_leads_to_what_it_means():
    with Daemon() as daemon:
        types = {daemon.ask(method, path, body, {"Content-Type": kind}).json()["type"]
                 for method, path, body, kind in [
                     ("GET", "/nothing", None, ""), ("POST", "/healthz", None, ""),
                     ("POST", "/v1/jobs", b"{", "application/json"),
                     ("POST", "/v1/jobs", b"{}", "application/json"),
                     ("POST", "/v1/jobs", b"{}", "text/plain")]}
        assert len(types) == 5, types
        for path in sorted(types):
            page = daemon.get(path)
            assert page.status == 200 and b"Status 4" in page.body, path
            assert page.headers["Content-Type"] == "text/html; charset=utf-8"
        assert daemon.get("/problems/none").status == 404


def test_pages_bring_no_style_and_no_script_of_their_own():
    with Daemon() as daemon:
        for path in ["/calls", "/problems/busy"]:
            page = daemon.get(path)
            policy = page.headers["Content-Security-Policy"]
            assert policy.startswith("default-src 'none'; style-src 'self'"), policy
            assert b"<style" not in page.body and b"<script" not in page.body
            sheet = re.search(rb'href="(/viewer/[a-z.]+)"', page.body)[1].decode()
            assert daemon.get(sheet).headers["Content-Type"].startswith("text/css")


def test_a_bad_name_of_a_client_is_told_with_the_faults_of_his_job():
    with Daemon() as daemon:
        answer = daemon.post({"scene": "none", "colour": 1}, {"Glint-Client": "a b",
                                                              "Idempotency-Key": "two words"})
        assert answer.status == 422
        told = [fault["detail"] for fault in answer.json()["errors"]]
        for word in ("Glint-Client", "Idempotency-Key", "colour", "no scene"):
            assert any(word in detail for detail in told), (word, told)
        answer = daemon.ask("GET", "/v1/jobs", None, {"Glint-Client": "a b"})
        assert answer.status == 422 and "Glint-Client" in answer.json()["detail"]


def test_what_has_one_entity_tag_is_not_sent_again():
    with Daemon() as daemon:
        data = b"bytes of an asset"
        asset = "/v1/assets/" + hashlib.sha256(data).hexdigest()
        assert daemon.ask("PUT", asset, data, {}).status == 201
        for path in ["/healthz", "/readyz", asset]:
            first = daemon.get(path)
            tags = first.headers.get_all("ETag")
            assert first.status == 200 and len(tags) == 1, (path, tags)
            again = daemon.get(path, {"If-None-Match": tags[0]})
            assert again.status == 304 and not again.body, path
            assert again.headers.get_all("ETag") == tags, path


def test_two_requests_in_one_packet_are_both_answered():
    with Daemon() as daemon:
        answer = daemon.raw(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
                            b"GET /v1 HTTP/1.1\r\n" + END)
        assert answer.count(b"HTTP/1.1 200 OK") == 2, answer


def test_a_refused_body_is_not_taken_for_a_request():
    with Daemon() as daemon:
        hidden = b"GET /v1 HTTP/1.1\r\n" + END
        for method in (b"POST /v1/jobs", b"PATCH /v1/jobs/x", b"DELETE /v1/jobs/x", b"GET /v1"):
            answer = daemon.raw(method + b" HTTP/1.1\r\nHost: localhost\r\n"
                                b"Content-Type: text/plain\r\nContent-Length: %d\r\n\r\n"
                                % len(hidden) + hidden)
            assert answer.count(b"HTTP/1.1 ") == 1, answer


def test_the_service_pages_tell_what_they_should():
    with Daemon() as daemon:
        about = daemon.get("/v1").json()
        assert about["devices"][0]["workers"] >= 1
        assert {"beauty", "crypto_object"} <= set(about["outputs"])
        types = daemon.ask("PUT", "/v1/scenes/s", b"x", {"Content-Type": "text/x-c"}).json()["detail"]
        assert types.endswith(" is not one of " + ", ".join(about["scene_types"])), types
        assert [d["name"] for d in about["dials"]] and about["presets"][0]["name"] == "production"
        assert daemon.get("/readyz").status == 200
        head = daemon.ask("HEAD", "/openapi.yaml")
        assert head.status == 200 and not head.body and int(head.headers["Content-Length"]) > 0


def calls_of_contract(text):
    """(method, path) of an OpenAPI document with {} for parameters."""
    calls, path = set(), None
    for line in text.partition("\npaths:\n")[2].partition("\ncomponents:\n")[0].splitlines():
        if found := re.match(r"  (/\S*):$", line):
            path = re.sub(r"{\w+}", "{}", found[1])
        elif found := re.match(r"    (get|put|post|patch|delete):$", line):
            calls.add((found[1].upper(), path))
    return calls


def test_the_contract_names_every_call_and_no_other():
    with Daemon() as daemon:
        contract = daemon.get("/openapi.yaml")
        assert contract.headers["Content-Type"] == "application/yaml"
        assert contract.body.startswith(b"openapi: 3.1.")
        row = r"<tr><td><code>(\w+)</code><td><code>([^<]+)</code>"
        served = set(re.findall(row, daemon.get("/calls").body.decode()))
        assert len(served) > 20 and calls_of_contract(contract.body.decode()) == served


def test_metrics_are_well_formed():
    with Daemon() as daemon:
        lines = daemon.get("/metrics").body.decode().splitlines()
        kinds = [line.split()[2] for line in lines if line.startswith("# TYPE ")]
        assert len(kinds) == len(set(kinds)) and all(k.startswith("glint_") for k in kinds)
        for line in lines:
            if not line.startswith("#"):
                name, value = line.rsplit(" ", 1)
                assert name.startswith("glint_") and float(value) >= 0, line


if __name__ == "__main__":
    tap.main()
