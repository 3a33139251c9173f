"""programs.py - runs a test program of a build tree and reads what came of each of its tests."""
import json
import os
import subprocess
import tempfile
import xml.etree.ElementTree as xml

import tap

LIMIT = 1800  # seconds until a program counts as hung


def _environment(build, workers, results, more):
    suppressions = tap.source("tests", "sanitizers")
    return {**os.environ, "top_srcdir": tap.source(), "GLINT_BUILD": build,
            "XDG_CACHE_HOME": os.path.join(build, "tests", "cache"), "GLINT_FORESEE": "no",
            "GLINT_TEST_WORKERS": workers,
            "LSAN_OPTIONS": f"suppressions={suppressions}/lsan.supp:print_suppressions=0",
            "ASAN_OPTIONS": "intercept_tls_get_addr=0",
            "CMOCKA_MESSAGE_OUTPUT": "XML", "CMOCKA_XML_FILE": results, **more}


def _outcome(case):
    for tag, word in (("failure", "FAILED"), ("error", "FAILED"), ("skipped", "skipped")):
        if case.find(tag) is not None:
            return word
    return "holds"


def run(program, build, workers, more):
    """{claim: (outcome, seconds)} of a test program; empty where it has left no results. more: of the
    environment."""
    with tempfile.TemporaryDirectory() as scratch:
        results = os.path.join(scratch, "results.xml")
        done = subprocess.run([os.path.join(build, "tests", program)], cwd=build, timeout=LIMIT,
                              env=_environment(build, workers, results, more), check=False,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            cases = xml.parse(results).getroot().iter("testcase")
        except (OSError, xml.ParseError):
            return {}
        found = {case.get("name"): (_outcome(case), float(case.get("time"))) for case in cases}
    failed = any(word == "FAILED" for word, _ in found.values())
    return found if failed or done.returncode in (0, 77) else {}


def _workers_of(path, workers):
    """"any" of a program that does not ask for their number."""
    with open(path, "rb") as file:
        return workers if b"GLINT_TEST_WORKERS" in file.read() else "any"


def kept(program, build, workers):
    """As run(), or what an earlier call got of the program as it is; None where it is not built."""
    path = os.path.join(build, "tests", program)
    if not os.path.exists(path):
        return None
    results = f"{path}.results-{_workers_of(path, workers)}.json"
    if not os.path.exists(results) or os.path.getmtime(results) < os.path.getmtime(path):
        found = run(program, build, workers, {})
        with open(results, "w", encoding="utf-8") as file:
            json.dump(found, file)
    with open(results, encoding="utf-8") as file:
        return json.load(file)
