#!/usr/bin/python3
"""protocol/openapi.yaml: valid, complete, and what the daemon does.

The tools are those of deploy/tools/python-tools; without them their tests are skipped.
$CONTRACT_EXAMPLES: how many requests schemathesis makes up for each call, beside those for each
bound of each schema; $CONTRACT_SEED: from which number.
"""
import os
import re
import subprocess
import tempfile

import yaml

import tap
from daemon import PATIENCE, ROOM, Daemon

METHODS = ("get", "put", "post", "patch", "delete")
PROBLEM = "#/components/schemas/Problem"


def tool(name):
    """A program of deploy/tools/python-tools, or Skip."""
    home = os.environ.get("GLINT_TOOLS") or os.path.expanduser("~/.cache/glint-tools")
    path = os.path.join(home, "bin", name)
    if not os.access(path, os.X_OK):
        raise tap.Skip(f"no {name}: deploy/tools/python-tools makes it")
    return path


def contract_of(daemon):
    return yaml.safe_load(daemon.get("/openapi.yaml").body)


def operations(contract):
    for path, item in contract["paths"].items():
        for method in METHODS:
            if method in item:
                yield path, method, item[method], item.get("parameters", [])


def resolve(contract, node):
    while "$ref" in node and node["$ref"].startswith("#/"):
        target = contract
        for part in node["$ref"][2:].split("/"):
            target = target[part.replace("~1", "/").replace("~0", "~")]
        node = {**target, **{k: v for k, v in node.items() if k != "$ref"}}
    return node


def test_the_contract_is_valid_openapi():
    validator = tool("openapi-spec-validator")
    with Daemon() as daemon, tempfile.NamedTemporaryFile(suffix=".yaml") as file:
        file.write(daemon.get("/openapi.yaml").body)
        file.flush()
        run = subprocess.run([validator, "--schema", "3.1", "--errors", "all", file.name],
                             capture_output=True, text=True, timeout=PATIENCE, check=False)
        assert run.returncode == 0, run.stdout + run.stderr


def test_every_operation_says_what_it_is_and_every_answer_that_it_may_get():
    with Daemon() as daemon:
        contract = contract_of(daemon)
    tags, ids = {tag["name"] for tag in contract["tags"]}, set()
    for path, method, operation, _ in operations(contract):
        where = (method, path)
        assert re.fullmatch("[a-z][A-Za-z]+", operation["operationId"]), where
        assert operation["operationId"] not in ids, where
        ids.add(operation["operationId"])
        assert operation["summary"].endswith("."), where
        assert set(operation["tags"]) <= tags and operation["tags"], where
        wanted = {"400", "421", "422", "503"}
        if "{" in path:
            wanted.add("404")
        if "requestBody" in operation:
            wanted |= {"413", "415", "507"}
        assert wanted <= set(operation["responses"]), (where, wanted - set(operation["responses"]))
        for status, answer in operation["responses"].items():
            answer = resolve(contract, answer)
            assert answer["description"].endswith("."), (where, status)
            if status >= "400":
                (media, body), = answer["content"].items()
                assert media == "application/problem+json", (where, status)
                assert body["schema"]["$ref"] == PROBLEM, (where, status)


def test_the_contract_has_every_call_and_no_other():
    with Daemon() as daemon:
        contract, page = contract_of(daemon), daemon.get("/calls").body.decode()
    served = {tuple(call) for call in
              re.findall(r"<td><code>([A-Z]+)</code><td><code>([^<]+)</code>", page)}
    written = {(method.upper(), re.sub(r"\{\w+\}", "{}", path))
               for path, method, _, _ in operations(contract)}
    assert served == written, served ^ written


def test_every_parameter_is_described_and_every_component_used():
    with Daemon() as daemon:
        text = daemon.get("/openapi.yaml").body.decode()
    contract = yaml.safe_load(text)
    for path, method, operation, shared in operations(contract):
        named = [resolve(contract, p) for p in operation.get("parameters", []) + shared]
        for parameter in named:
            assert "schema" in parameter, (method, path, parameter)
            assert "type" in parameter["schema"] or "enum" in parameter["schema"], parameter
        inside = {p["name"] for p in named if p["in"] == "path"}
        assert inside == set(re.findall(r"\{(\w+)\}", path)), (method, path)
    for kind, components in contract["components"].items():
        for name in components:
            used = f'#/components/{kind}/{name}' in text or kind == "securitySchemes"
            assert used, f"{kind}/{name} is never referred to"


def members_missing(contract, schema, value, where):
    """Members of a value that its schema has no word about."""
    schemas, properties, others = [schema], {}, None
    while schemas:
        one = resolve(contract, schemas.pop())
        for combined in ("allOf", "anyOf", "oneOf"):
            schemas += one.get(combined, [])
        properties.update(one.get("properties", {}))
        others = one.get("additionalProperties", others)
        if "items" in one and isinstance(value, list):
            for item in value:
                yield from members_missing(contract, one["items"], item, where)
    if not isinstance(value, dict):
        return
    for name, item in value.items():
        inner = properties.get(name, others if isinstance(others, dict) else None)
        if inner is None and others is not True:
            yield f"{where}/{name}"
        elif isinstance(inner, dict):
            yield from members_missing(contract, inner, item, f"{where}/{name}")


def test_no_answer_has_a_member_that_the_contract_does_not_name():
    with Daemon() as daemon:
        contract = contract_of(daemon)
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", resolution=[24, 16], stop={"samples": 4})
        daemon.frame(job)
        paths = {p: p.replace("{scene}", "room").replace("{id}", job) for p in contract["paths"]}
        seen = 0
        for path, real in paths.items():
            answer = contract["paths"][path].get("get", {}).get("responses", {}).get("200", {})
            schema = answer.get("content", {}).get("application/json", {}).get("schema")
            if not schema or "{sha256}" in path:
                continue
            query = "?x=3&y=4" if path.endswith("/pick") else ""
            value = daemon.get(real + query).json()
            assert list(members_missing(contract, schema, value, path)) == []
            seen += 1
        assert seen >= 10, seen
        fault = daemon.post({"scene": "room", "smell": 1}).json()
        assert list(members_missing(contract, {"$ref": PROBLEM}, fault, "problem")) == []


def schemathesis(daemon, job, patched, *options):
    """Its report, and whether it is content."""
    environment = {**os.environ, "SCHEMATHESIS_HOOKS": "contract_hooks",
                   "PYTHONPATH": tap.source("tests", "http"), "CONTRACT_JOB": job,
                   "CONTRACT_PATCHED": patched, "CONTRACT_SCENE": "room", "COLUMNS": "200"}
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [tool("schemathesis"), "--config-file", tap.source("tests", "http", "contract.toml"),
             "run", daemon.url + "/openapi.yaml", "--url", daemon.url, "--checks", "all",
             "--seed", os.environ.get("CONTRACT_SEED", "1"), "--generation-deterministic",
             "--suppress-health-check", "all", "--request-timeout", "30", "--no-color",
             "--continue-on-failure", *options],
            cwd=folder, env=environment, capture_output=True, text=True, timeout=3600, check=False)
    return run.returncode == 0, run.stdout + run.stderr


def test_the_daemon_keeps_the_contract_whatever_it_is_asked():
    tool("schemathesis")
    examples = os.environ.get("CONTRACT_EXAMPLES", "5")
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job, patched = (daemon.submit(scene="room", resolution=[24, 16], stop={"samples": 4})
                        for _ in range(2))
        daemon.frame(job)
        daemon.frame(patched)
        content, report = schemathesis(daemon, job, patched, "--phases",
                                       "examples,coverage,fuzzing", "--max-examples", examples)
        shown = re.sub(r"(?s).*= FAILURES =+", "", report)
        assert content, "\n".join(line[:400] for line in shown.splitlines() if line)
        assert daemon.get("/healthz").status == 200


if __name__ == "__main__":
    tap.main()
