#!/usr/bin/python3
"""glint accuracy: a whole run on a small scene, resumed; what it writes, and the front it puts."""
import csv
import json
import os
import sys
import tempfile
import xml.etree.ElementTree as xml

import cli
import tap

sys.path.insert(0, tap.source("tests", "http"))
from daemon import ROOM, Daemon  # pylint: disable=wrong-import-position

COLUMNS = ("scene,method,knob,value,seed,spp,rays_camera,rays_bounce,rays_shadow,cpu_s,wall_s,"
           "threads,rmse61,relmse,relmse_trim,flip,matte_mae,tv,bias,sd,est_error,pred_cost,"
           "ref_id,build").split(",")
SMALL = ["--resolution", "24x16", "--seeds", "2", "--samples", "4", "--reference-samples", "32",
         "--dials", "gi,through"]


def rows(folder):
    with open(os.path.join(folder, "accuracy.csv"), encoding="utf-8", newline="") as file:
        table = csv.DictReader(file)
        assert table.fieldnames == COLUMNS
        return list(table)


def run(daemon, folder, *more, expect=0):
    done = cli.glint("accuracy", "room", *SMALL, "-o", folder, *more, server=daemon.url)
    assert done.returncode == expect, (done.returncode, done.stdout, done.stderr)
    return done


def check_rows(table):
    """Two twins, no bounces, two kinds of mattes: two seeds at three counts, and the means."""
    assert len(table) == 5 * (2 * 3 + 1)
    for row in table:
        camera = int(row["rays_camera"].split(".")[0])
        assert row["scene"] == "room" and row["flip"] == ""
        assert camera == 24 * 16 * int(row["spp"]), row
        assert float(row["cpu_s"]) > 0 and float(row["wall_s"]) > 0
        matte = row["ref_id"].startswith("matte")
        assert bool(row["tv"]) == matte and bool(row["rmse61"]) == (not matte)
        assert bool(row["bias"]) == bool(row["sd"]) == (row["seed"] == "all")
    one = [r for r in table if r["knob"] == "accuracy.gi"]
    exact = [r for r in table if r["value"] == "colour"]
    assert all(int(a["rays_bounce"]) < int(b["rays_bounce"])
               for a, b in zip(one, exact) if a["seed"] != "all")


def test_a_run_is_measured_drawn_and_put():
    with Daemon() as daemon, tempfile.TemporaryDirectory() as base:
        folder = os.path.join(base, "report")
        daemon.put("room", ROOM)
        assert daemon.get("/v1/scenes/room/front").json()["from"] == "class"
        done = run(daemon, folder)
        assert "Progress: 100%" in done.stdout and "5 settings, 35 rows" in done.stdout
        check_rows(rows(folder))
        for plot in ("accuracy.gi.svg", "mattes.through.svg"):
            tree = xml.parse(os.path.join(folder, "plots", plot))
            circles = [e for e in tree.iter() if e.tag.endswith("circle")]
            assert len(circles) >= 2 * 2 * 3, plot
            assert any(c.get("fill") == "#fff" for c in circles)
            assert any(c.get("fill") != "#fff" for c in circles)
        for name in ("index.html", "failures.html", "differences/accuracy.gi-none.png",
                     "differences/mattes.through-none.png"):
            assert os.path.getsize(os.path.join(folder, name)) > 60, name
        check_json(folder)
        check_front(daemon, folder)
        check_resumed(daemon, folder)


def check_json(folder):
    with open(os.path.join(folder, "accuracy.json"), encoding="utf-8") as file:
        report = json.load(file)
    assert len(report["settings"]) == 5 and len(report["no_method_built"]) > 5
    by_name = {(s["knob"], s["value"]): s for s in report["settings"]}
    twin = by_name["twin", "colour"]
    assert twin["rays_over_exact"] == [1, 1, 1]
    # A matte of what is seen directly lacks what the metal ball reflects, and nothing else.
    none, matte = by_name["mattes.through", "none"], by_name["twin", "matte"]
    assert matte["points"][-1]["error"][0] < none["points"][-1]["error"][0] < 0.1
    assert none["bias2"] > 2 * none["bias2_se"] and matte["bias2"] < 2 * matte["bias2_se"]


def check_front(daemon, folder):
    front = daemon.get("/v1/scenes/room/front").json()
    with open(os.path.join(folder, "front.json"), encoding="utf-8") as file:
        assert front["front"] == json.load(file)
    assert front["from"] == "scene" and front["current"]
    points = front["front"]["points"]
    assert len(points) == 2  # the twin and direct light, no mattes
    twin = next(p for p in points if p["settings"]["accuracy"]["gi"] == "path")
    assert twin["bias"] == 0 and twin["variance"] > 0 and twin["seconds"] > 0


def check_resumed(daemon, folder):
    """A row that is lost is rendered again, what is there is not."""
    before = daemon.metric("glint_jobs_submitted_total")
    table = rows(folder)
    with open(os.path.join(folder, "accuracy.csv"), "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(r for r in table if (r["value"], r["seed"], r["spp"]) != ("colour", "2", "4"))
    run(daemon, folder)
    again = rows(folder)
    assert daemon.metric("glint_jobs_submitted_total") == before + 2  # and one that asks the plan
    check_rows(again)

    def of_seed(rows_of, value, seed):
        return [(r["spp"], r["rays_bounce"], r["rmse61"]) for r in rows_of
                if r["value"] == value and r["seed"] == seed]
    assert of_seed(again, "colour", "2") == of_seed(table, "colour", "2")  # images repeat bit for bit


def test_a_folder_is_of_one_programme():
    with Daemon() as daemon, tempfile.TemporaryDirectory() as base:
        daemon.put("room", ROOM)
        few = ["--resolution", "8x8", "--seeds", "2", "--samples", "2", "--dials", "gi"]
        for scene, size, expect in (("room", "8x8", 0), ("room", "9x8", 1), ("room", "8x8", 0)):
            few[1] = size
            done = cli.glint("accuracy", scene, *few, "-o", base, server=daemon.url)
            assert done.returncode == expect, (size, done.stdout, done.stderr)
            assert ("resolution" in done.stderr) == bool(expect), done.stderr
        before = rows(base)
        other = {**ROOM, "cameras": {"main": {**ROOM["cameras"]["main"], "yfov": 0.7}}}
        daemon.put("room", other)
        done = cli.glint("accuracy", "room", *few, "-o", base, server=daemon.url)
        assert done.returncode == 1 and "revision" in done.stderr, done.stderr
        assert rows(base) == before


def test_a_render_has_its_settings_picked_and_says_so():
    with Daemon() as daemon, tempfile.TemporaryDirectory() as base:
        daemon.put("room", ROOM)
        frame = os.path.join(base, "frame.exr")
        done = cli.glint("render", "room", "-r", "24x16", "--reach", "0.5", "-o", frame,
                         server=daemon.url)
        assert done.returncode == 0 and os.path.getsize(frame) > 500, done.stderr
        assert "from the front of its class; expected error" in done.stderr, done.stderr
        both = cli.glint("render", "room", "--reach", "0.5", "--within", "1", "-o", frame,
                         server=daemon.url)
        assert both.returncode == 1 and "/accuracy/error" in both.stderr


def test_what_cannot_be_measured_is_a_fault_of_the_command_line_or_the_daemons():
    with Daemon() as daemon, tempfile.TemporaryDirectory() as base:
        daemon.put("room", ROOM)
        bad = cli.glint("accuracy", "room", "--seeds", "1", "-r", "4x4", server=daemon.url)
        assert bad.returncode == 64 and "--seeds" in bad.stderr and "--resolution" in bad.stderr
        unknown = run(daemon, base, "--dials", "gi,surfels", expect=1)
        assert "surfels" in unknown.stderr and "accuracy.gi" in unknown.stderr
        missing = cli.glint("accuracy", "attic", "-o", base, server=daemon.url)
        assert missing.returncode == 1 and "attic" in missing.stderr


if __name__ == "__main__":
    tap.main()
