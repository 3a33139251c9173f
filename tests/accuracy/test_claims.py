"""Every figure that docs/accuracy/README.md gives of a row is what the row says.

A claim is `folder: knob=value` (`column` 0.123, ...): of the row of docs/accuracy/folder/accuracy.csv
with the seed "all", to the digits given. `rays` and `cpu` are over those of the exact twin.
"""
import csv
import os
import re

import tap

DOCS = tap.source("docs", "accuracy")
ROW = re.compile(r"`([\w-]+):\s+([\w.+]+)=([\w.+]+)`\s+\(([^)]*)\)")
FIGURE = re.compile(r"`(\w+)`\s+(-?[\d.]+)")


def load(folder):
    with open(os.path.join(DOCS, folder, "accuracy.csv"), encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if row["seed"] == "all"]


def find(rows, knob, value):
    found = [row for row in rows if (row["knob"], row["value"]) == (knob, value)]
    assert len(found) == 1, f"{len(found)} rows {knob}={value}"
    return found[0]


def twin_of(rows, row):
    return find(rows, "twin", row["ref_id"].split(":")[0])


def cost(row, column):
    if column == "cpu":
        return float(row["cpu_s"])
    return sum(float(row[f"rays_{kind}"]) for kind in ("camera", "bounce", "shadow"))


def figure(rows, row, column):
    if column in ("rays", "cpu"):
        return cost(row, column) / cost(twin_of(rows, row), column)
    return float(row[column])


def text():
    with open(os.path.join(DOCS, "README.md"), encoding="utf-8") as file:
        return file.read()


def test_every_figure_of_a_row_is_the_row_s():
    wrong, count = [], 0
    for folder, knob, value, figures in ROW.findall(text()):
        rows = load(folder)
        row = find(rows, knob, value)
        for column, said in FIGURE.findall(figures):
            digits = len(said.partition(".")[2])
            is_so = figure(rows, row, column)
            count += 1
            if abs(is_so - float(said)) > 0.5001 * 10 ** -digits:
                wrong.append(f"{folder}: {knob}={value}: {column} {said}, is {is_so:.6g}")
    assert count >= 30, count
    assert not wrong, wrong


def test_every_row_that_is_named_is_there():
    named = re.findall(r"`([\w-]+):\s+([\w.+]+)=([\w.+]+)`", text())
    assert len(named) >= 15, named
    for folder, knob, value in (n for n in named if n[0] != "folder"):
        find(load(folder), knob, value)


if __name__ == "__main__":
    tap.main()
