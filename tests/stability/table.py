"""table.py - the rows of hard cases in tests/stability/rows, and the tests that they name."""
import re
from typing import NamedTuple

import tap


class Row(NamedTuple):
    section: str
    case: str
    holds: str
    tolerance: str
    kind: str
    tests: list  # of (program, claim); empty where the method is not built
    settings: list  # of (dial, setting) of methods that are not built


def _tests(text):
    pairs = []
    for part in text.split(","):
        program, _, claims = part.strip().partition(":")
        pairs += [(program, claim) for claim in claims.split()]
    return pairs


def _row(line):
    fields = [field.strip() for field in line.split("|")]
    if len(fields) != 6 or not all(fields) or fields[4] not in "ES":
        raise ValueError(f"not a row: {line}")
    methods = fields[5].removeprefix("not built:")
    if methods != fields[5]:
        return Row(*fields[:5], [], [tuple(m.split("=")) for m in methods.split()])
    return Row(*fields[:5], _tests(fields[5]), [])


def rows():
    with open(tap.source("tests", "stability", "rows"), encoding="utf-8") as file:
        lines = [line.strip() for line in file]
    return [_row(line) for line in lines if line and not line.startswith("#")]


def claims_of(program):
    """Claims that a test program registers, from its source; none where there is no such program."""
    try:
        with open(tap.source("tests", program + ".c"), encoding="utf-8") as file:
            return re.findall(r"cmocka_unit_test(?:_setup_teardown)?\((\w+)", file.read())
    except FileNotFoundError:
        return []


def listed(dials, settings):
    """Those of the settings that the daemon's table of dials lists; `dials` as in GET /v1."""
    exist = {(dial["name"], setting) for dial in dials
             for setting in (dial["exact"], *dial["approximations"])}
    return [pair for pair in settings if pair in exist]
