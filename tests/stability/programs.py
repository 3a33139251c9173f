"""programs.py - runs a test program of a build tree and reads what came of each of its tests."""
import json
import os
import re
import subprocess
import tempfile
import xml.etree.ElementTree as xml

import tap

LIMIT = 1800  # seconds until a program counts as hung
SUITE_WORKERS = "2"  # of the programs that `make check` runs


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


def alone(claim, folder):
    """Of the environment: has a program run one claim and no other. folder: for what that takes."""
    preload = os.path.join(folder, "filter.so")
    if not os.path.exists(preload):
        subprocess.run(["cc", "-shared", "-fPIC", "-o", preload,
                        tap.source("tests", "mutation", "filter.c"), "-lcmocka"], check=True)
    return {"MUTATION_CLAIM": claim, "LD_PRELOAD": preload}


def _newer(path, than):
    return os.path.exists(path) and os.path.getmtime(path) >= os.path.getmtime(than)


def suite(path):
    """As run(), from what `make check` has left beside a program since it was built: it does not say
    how long each test took. Empty where there is no such log, or not of a whole and sound run."""
    log = f"{path}.log"
    if not _newer(log, path):
        return {}
    with open(log, encoding="utf-8", errors="replace") as file:
        text = file.read()
    planned = re.search(r"^1\.\.(\d+)", text, re.M)
    lines = re.findall(r"^(not ok|ok) \d+ (# SKIP|-) (\w+)", text, re.M)
    if not planned or int(planned[1]) != len(lines) or re.search(r"^ERROR: ", text, re.M):
        return {}
    word_of = {("ok", "-"): "holds", ("ok", "# SKIP"): "skipped"}
    return {name: (word_of.get((ok, mark), "FAILED"), None) for ok, mark, name in lines}


def kept(program, build, workers):
    """As run(), or what an earlier call got of the program as it is, or of the suite where it asks for
    no other number of workers than that; None where it is not built."""
    path = os.path.join(build, "tests", program)
    if not os.path.exists(path):
        return None
    asked = _workers_of(path, workers)
    found = suite(path) if asked in ("any", SUITE_WORKERS) else {}
    if found:
        return found
    results = f"{path}.results-{asked}.json"
    if not _newer(results, path):
        found = run(program, build, workers, {})
        with open(results, "w", encoding="utf-8") as file:
            json.dump(found, file)
    with open(results, encoding="utf-8") as file:
        return json.load(file)
