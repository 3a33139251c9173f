"""table.py - the faults of faults.toml: reading them, and whether each still applies to the source.

A fault replaces one text in one file. It applies where that text is there exactly once; where the
source has moved on, the table is to follow.
"""
import os
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
MEMBERS = ("id", "fault", "file", "old", "new", "tests")


def load():
    """Every fault, in the order of the table."""
    with open(os.path.join(HERE, "faults.toml"), "rb") as f:
        return tomllib.load(f)["fault"]


def mutate(fault, top=TOP):
    """The text of the fault's file with the fault in it; ValueError says why it does not apply."""
    with open(os.path.join(top, fault["file"]), encoding="utf-8") as f:
        text = f.read()
    found = text.count(fault["old"])
    if found != 1:
        raise ValueError(f"{fault['id']}: {fault['file']} has its text {found} times")
    if fault["old"] == fault["new"]:
        raise ValueError(f"{fault['id']}: it changes nothing")
    return text.replace(fault["old"], fault["new"])


def test_source(test, top=TOP):
    """Path of the source of a test as the table names it: "tests/unit/test_x", "tests/http/y.py z"."""
    path = os.path.join(top, test.split()[0])
    return path if path.endswith(".py") else path + ".c"
