#!/usr/bin/env python3
"""The table of hard cases and the tests: neither names what the other does not have."""
import glob
import os
import sys
import tempfile

import programs
import tap
import table

sys.path.insert(0, tap.source("tests", "http"))
from daemon import Daemon  # noqa: E402


def test_every_claim_of_a_row_is_a_test():
    known = {}
    for row in table.rows():
        for program, claim in row.tests:
            if program not in known:
                known[program] = table.claims_of(program)
            assert claim in known[program], f"{row.case}: no {claim} in {program}"


def test_every_test_of_stability_is_a_claim_of_a_row():
    named = {pair for row in table.rows() for pair in row.tests}
    for path in sorted(glob.glob(tap.source("tests", "stability", "test_*.c"))):
        program = "stability/" + os.path.basename(path).removesuffix(".c")
        claims = table.claims_of(program)
        assert claims, f"{program} has no test"
        for claim in claims:
            assert (program, claim) in named, f"no row names {claim} of {program}"


def test_rows_without_tests_are_of_methods_that_the_daemon_does_not_list():
    with Daemon() as daemon:
        dials = daemon.get("/v1").json()["dials"]
    for row in table.rows():
        assert bool(row.tests) != bool(row.settings), f"{row.case}: tests or settings"
        there = table.listed(dials, row.settings)
        assert not there, f"{row.case}: {there} exists, so there must be tests"
        for dial, _ in row.settings:
            assert any(known["name"] == dial for known in dials), f"{row.case}: no dial {dial}"


def left_by_the_suite(text, seconds):
    """What is read of a program whose log is that much younger than it is."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "test_x")
        for name, content in ((path, ""), (path + ".log", text)):
            with open(name, "w", encoding="utf-8") as file:
                file.write(content)
        written = os.path.getmtime(path)
        os.utime(path + ".log", (written, written + seconds))
        return programs.suite(path)


def test_what_the_suite_has_left_of_a_program_is_read():
    text = ("1..3\nok 1 - a_is_b\nPASS: test_x 1 - a_is_b\nnot ok 2 - b_is_c\n"
            "FAIL: test_x 2 - b_is_c\nok 3 # SKIP c_is_d\n")
    found = {"a_is_b": ("holds", None), "b_is_c": ("FAILED", None), "c_is_d": ("skipped", None)}
    assert left_by_the_suite(text, 1) == found


def test_what_is_older_than_the_program_or_torn_is_not():
    assert left_by_the_suite("1..1\nok 1 - a_is_b\n", 1)
    assert not left_by_the_suite("1..1\nok 1 - a_is_b\n", -1)
    assert not left_by_the_suite("1..2\nok 1 - a_is_b\n", 1)
    assert not left_by_the_suite("1..1\nok 1 - a_is_b\nERROR: test_x - exited with status 1\n", 1)


def test_no_case_stands_there_twice():
    cases = [(row.section, row.case) for row in table.rows()]
    assert len(set(cases)) == len(cases)


if __name__ == "__main__":
    tap.main()
