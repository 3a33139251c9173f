"""Every figure that the pages of docs give of the data beside them is what the data say.

A claim is `file.csv: key,key` (`column` 0.123, ...): of the one row of that file, beside the page or
below, that begins with these keys, to the digits given. Tables are held as wholes: each row of the page is
made again from the data.
"""
import csv
import json
import os
import re
import subprocess

import tap

CLAIM = re.compile(r"`([\w/-]+\.csv):\s+([^`]+)`\s+\(([^)]*)\)")
FIGURE = re.compile(r"`(\w+)`\s+(-?[\d.]+)( %)?")
PAGES = ["accuracy/forecast", "durability", "effects", "mattes", "precision", "soak"]


def path(*parts):
    return tap.source("docs", *parts)


def text(page):
    with open(path(page, "README.md"), encoding="utf-8") as file:
        return file.read()


def flat(page):
    """The page's text in one line, as a sentence may go on in the next."""
    return " ".join(text(page).split())


def load(*parts):
    with open(path(*parts), encoding="utf-8", newline="") as file:
        return json.load(file) if parts[-1].endswith(".json") else list(csv.DictReader(file))


def row_of(page, name, keys):
    found = [row for row in load(page, name) if list(row.values())[:len(keys)] == keys]
    assert len(found) == 1, f"{len(found)} rows {keys} in {page}/{name}"
    return found[0]


def differs(said, percent, value):
    digits = len(said.partition(".")[2])
    return abs(value * (100 if percent else 1) - float(said)) > 0.5001 * 10 ** -digits


def missing(page, lines):
    """Which of the rows of tables, or of the pieces of sentences, the page does not have."""
    page = flat(page)
    return [line for line in lines if line not in page]


def interval(r, turned=False):
    ends = [1 / r[k] if turned else r[k] for k in ("ratio", "low", "high")]
    return "{:.2f} ({:.2f} to {:.2f})".format(ends[0], *sorted(ends[1:]))


def test_every_figure_of_a_row_is_the_row_s():
    wrong, count = [], 0
    for page in PAGES:
        for name, keys, figures in CLAIM.findall(text(page)):
            row = row_of(page, name, keys.split(","))
            for column, said, percent in FIGURE.findall(figures):
                count += 1
                if differs(said, percent, float(row[column])):
                    wrong.append(f"{page}/{name}: {keys}: {column} {said}, is {row[column]}")
    assert count >= 30, count
    assert not wrong, wrong


def test_effects_cost_what_the_bench_said():
    with open(path("effects", "effects.json"), encoding="utf-8") as data:
        made = subprocess.run(["python3", tap.source("tests", "bench", "effects_table")], stdin=data,
                              stdout=subprocess.PIPE, check=True).stdout.decode()
    lines = [" ".join(line.split()) for line in made.splitlines() if line]
    assert len(lines) > 30, len(lines)
    assert not missing("effects", lines), missing("effects", lines)


def test_exactness_costs_what_the_bench_said():
    bench = load("precision", "precision.json")
    lines = [f"| {interval(bench['float64'])} |", f"| {interval(bench['robust'])} |",
             f"| {interval(bench['watertight'])} |",
             f"| {interval(bench['float'])} to encode, {bench['float_bytes']:.2f} the bytes |",
             f"| {interval(bench['fixed'], turned=True)}: double"]
    assert not missing("precision", lines), missing("precision", lines)


def test_kills_are_those_that_were_counted():
    kills = load("durability", "kills.json")
    assert kills["faults"] == []
    lines = [f"killed {kills['kills']} times", f"all {kills['counts']['frames equal']} finished frames",
             f"at most {kills['lost_seconds_most']:.2f} s", f"(median {kills['lost_seconds_median']:.2f} s)",
             f"every {kills['interval_seconds']:g} s"]
    assert not missing("durability", lines), missing("durability", lines)


def test_the_soak_did_what_is_said():
    soak = load("soak", "soak.json")
    done = {}
    for client, times in soak["done"].items():
        kind = client.rpartition("-")[0]
        done[kind] = done.get(kind, 0) + times
    memory = soak["verdicts"]["rss_bytes"]
    lines = [f"{done['batch']:,} batch jobs", f"{done['live']:,} moves", f"{done['patcher']:,} patches",
             f"{done['uploader']:,} uploads", f"with {soak['cpu_seconds']:.0f} s of CPU",
             f"grew by {memory['grew'] / 2**20:.1f} MiB of {memory['median'] / 2**20:.0f}"]
    assert all(v["flat"] for v in soak["verdicts"].values())
    assert not missing("soak", lines), missing("soak", lines)


def late_lines():
    """What the times of the loaded machine came to."""
    kept = {}
    for row in load("accuracy", "choose-load.json")["rows"]:
        inside = abs(row["seconds"] - row["time"]) <= 0.1 * row["time"]
        kept.setdefault(row["time"], []).append((inside, row["seconds"] - row["time"]))
    late = [f"{1000 * max(s for _, s in kept[t]):.0f}" for t in sorted(kept)]
    inside = [str(sum(i for i, _ in kept[t])) for t in sorted(kept)]
    yield (f"in {inside[0]}, {inside[1]} and {inside[2]} of 16 runs, the worst late by "
           f"{late[0]}, {late[1]} and {late[2]} ms")


def time_line(sums):
    worst = 100 * max(s["worst"] for s in sums)
    return (f"{sum(s['kept'] for s in sums)} of {sum(s['runs'] for s in sums)} runs, the worst off by "
            f"{worst:.1f}%")


def test_choices_kept_what_they_were_counted_to_keep():
    scenes = {name: load("accuracy", f"choose-{name}.json") for name in ("room", "strips", "cluster")}
    lines = [*late_lines(), time_line([load("accuracy", "choose-time.json")["time"]]),
             time_line([scene["time"] for scene in scenes.values()])]
    for name, scene in scenes.items():
        error = scene["error"]
        lines.append(f"{error['kept']} of {error['runs']} runs, the worst at {error['worst']:.2f} of it | "
                     f"`choose-{name}.json`")
    assert not missing("accuracy", lines), missing("accuracy", lines)


def table(page, head):
    """Rows of cells of the page's table whose first row begins so; an empty first cell is the one above."""
    lines = text(page).splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith(head)) + 2
    rows = []
    while at < len(lines) and lines[at].startswith("|"):
        cells = [cell.strip() for cell in lines[at].split("|")[1:-1]]
        rows.append([cells[0] or rows[-1][0], *cells[1:]])
        at += 1
    return rows


def wrong_cells(row, said, values):
    """Of the cells of a row, those that are not their value; what is not in figures is left out."""
    cells = [re.match(r"(-?[\d.]+)( %)?", cell) for cell in said]
    return [f"{row}: {c[0]}, is {v:.6g}" for c, v in zip(cells, values) if c and differs(c[1], c[2], v)]


def test_forecasts_hold_as_often_as_was_counted():
    wrong, rows = [], table("accuracy/forecast", "| | judged |")
    for which, judged, *said in rows:
        seeds, _, first = which.partition(", from ")
        row = row_of("accuracy/forecast", "fresh/forecasts.csv" if seeds == "fresh" else "forecasts.csv",
                     [first, "all", "all"])
        wrong += [] if judged == f"{row['judged']} of {row['forecasts']}" else [(which, judged)]
        wrong += wrong_cells(which, said, [float(row[k]) for k in ("median", "median_near", "in_90", "bounds_hold",
                                                             "all_hold")])
    assert len(rows) == 6, rows
    assert not wrong, wrong


def test_large_pictures_errors_are_what_was_measured():
    wrong, rows = [], table("accuracy/forecast", "| scene | 32 samples | 64 |")
    for scene, few, many, flagged, *before in rows:
        now, then = ([row_of("accuracy/forecast", f"fresh/{file}.csv", [scene, samples])
                      for samples in ("32", "64")] for file in ("large", "large-before"))
        wrong += wrong_cells(scene, [few, many, *before], [float(r["error"]) for r in now + then])
        spreads = re.findall("±([0-9.]+)", few + many)
        wrong += wrong_cells(scene, spreads, [float(r["spread"]) for r in now])
        told = [int(r["seeds"]) - int(r["unflagged"]) for r in now]
        wrong += [] if [flagged] * 2 == [f"{n} of 4" for n in told] else [(scene, flagged, told)]
    assert len(rows) == 10, rows
    assert not wrong, wrong


def test_strips_are_as_far_from_sub_rays_as_was_measured():
    sums = {}
    for row in load("mattes", "strips.csv"):
        if row["distance"] == "any" and row["cut"] == "0":
            mine = sums.setdefault((row["reading"], row["alpha"], row["bend"], row["clamp"]), [0, 0, 0.0])
            pixels = int(row["pixels"])
            for i, v in enumerate((pixels, int(row["off"]), pixels * float(row["tv"]))):
                mine[i] += v
    wrong, rows = [], table("mattes", "| reading | alpha | bend |")
    for reading, alpha, bend, *said in rows:
        six, five = (sums[reading, alpha, bend, clamp] for clamp in "10")
        wrong += wrong_cells((reading, alpha, bend), said,
                             [six[0], six[1], five[1], six[2] / six[0], five[2] / five[0]])
    assert len(rows) == 16, rows
    assert not wrong, wrong


def test_hollow_strips_are_off_by_roughness_as_was_measured():
    data = [r for r in load("mattes", "strips.csv") if (r["bend"], r["distance"], r["cut"]) == ("hollow", "any", "0")]
    wrong, rows = [], table("mattes", "| roughness | 0 |")
    for what, *said in rows:
        told = re.match(r"off from (\w+), alpha ([\d.]+)", what)
        reading, alpha = told.groups() if told else ("coverage", "0.1")
        found = sorted((r for r in data if (r["reading"], r["alpha"], r["clamp"]) == (reading, alpha, "1")),
                       key=lambda r: float(r["roughness"]))
        wrong += wrong_cells(what, said, [float(r["pixels" if what == "pixels" else "off"]) for r in found])
        assert len(found) == len(said) == 8, (what, found)
    assert len(rows) == 5, rows
    assert not wrong, wrong


def test_twelve_slots_are_as_exact_as_was_measured():
    scenes = ("plant", "shelves", "cluster", "water", "strips", "forty")
    data = {(r["scene"], r["policy"]): r for r in load("mattes", "policies.csv")
            if (r["slots"], r["kind"]) == ("12", "bounced")}
    wrong, rows = [], table("mattes", "| 12 slots | plant |")
    for policy, *said in rows:
        wrong += wrong_cells(policy, said, [1 - float(data[scene, policy]["within"]) for scene in scenes])
        worst = [(data[scene, policy]["worst"], re.search(r"\(([\d.]+) at worst", cell))
                 for scene, cell in zip(scenes, said)]
        wrong += [(policy, v, m[1]) for v, m in worst if m and differs(m[1], None, float(v))]
    assert len(rows) == 4, rows
    assert not wrong, wrong


def test_policies_lose_what_was_measured():
    data = {(r["policy"], r["slots"]): r for r in load("mattes", "policies.csv")
            if (r["scene"], r["kind"]) == ("forty", "bounced")}
    wrong, rows = [], table("mattes", "| policy | slots | lost |")
    for policies, slots, lost, tv, bias, worst, within in rows:
        noise = bias.partition("(")[2]
        for policy in policies.split(", "):
            values = [float(data[policy, slots][k])
                      for k in ("lost", "tv", "bias", "noise", "worst", "within")]
            wrong += wrong_cells((policy, slots), [lost, tv, bias, noise, worst, within], values)
    assert len(rows) >= 13, rows
    assert not wrong, wrong


def test_files_leave_out_what_was_measured():
    scenes = ("cluster", "plant", "shelves", "water", "strips", "forty")
    data = {(r["scene"], r["type"], r["levels"]): float(r["worst"]) for r in load("mattes", "levels.csv")}
    wrong, rows = [], table("mattes", "| levels | cluster |")
    for levels, *said in rows:
        values = [data[scene, "CryptoObject" if scene == "cluster" else "CryptoGlossObject",
                       levels.strip('`"')] for scene in scenes]
        wrong += wrong_cells(levels, said[:len(scenes)], values)
    assert len(rows) == 7, rows
    assert not wrong, wrong


if __name__ == "__main__":
    tap.main()
