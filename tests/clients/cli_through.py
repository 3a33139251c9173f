#!/usr/bin/python3
"""glint render, matte and recolor through bounces: glass before a plant, from the scene to the file."""
import functools
import json
import os
import subprocess
import sys
import tempfile

import cli
import tap

sys.path[:0] = [tap.source("tests", "http"), tap.source("tests", "render")]
try:
    import numpy as np
    from cryptomatte import decode, read, stored_id
except ImportError as missing:
    tap.skip_all(str(missing))
from daemon import Daemon  # noqa: E402

FOLDER = tempfile.TemporaryDirectory()
CLASSES = ["primary", "reflection", "refraction"]
INFIX = {"primary": "", "reflection": "Refl", "refraction": "Refr"}
BLUE = np.array([0.05, 0.1, 0.8])


def path(name):
    return os.path.join(FOLDER.name, name)


def glint(*arguments, expect=0, **more):
    run = cli.glint(*arguments, **more)
    assert run.returncode == expect, (run.returncode, run.stderr)
    return run


@functools.lru_cache(maxsize=None)
def rendered():
    """The plant's frame in frame.exr, and beside it what the daemon makes of its mattes."""
    scene = subprocess.run([tap.build("glint-demo-scene"), "plant"], check=True, capture_output=True)
    with open(path("plant.json"), "wb") as file:
        file.write(scene.stdout)
    with open(path("job.json"), "w", encoding="utf-8") as file:
        json.dump({"mattes": {"through": "glossy", "classes": True, "alpha": 0.02, "levels": 16,
                               "slots": 32}}, file)
    with Daemon() as daemon:
        url = f"http://127.0.0.1:{daemon.port}"
        glint("render", path("plant.json"), "-o", path("frame.exr"), "--job", path("job.json"),
              "--resolution", "120x90", "--samples", 16, "--outputs", "beauty,albedo,crypto_object",
              server=url)
        (job,) = [j["id"] for j in daemon.get("/v1/jobs").json()["jobs"]]
        for name in CLASSES + [",".join(CLASSES)]:
            glint("matte", job, "--name", "pot", "--through", name, "-o", path(f"{name}.exr"), server=url)
        listed = glint("mattes", job, server=url).stdout
        refused = glint("matte", job, "--name", "pot", "--through", "glossy", "-o", path("no.exr"),
                        expect=1, server=url)
    return read(path("frame.exr"))[0].planes, refused.stderr, listed


def pot(name):
    """Its coverage by numpy, from the file."""
    kind = f"Crypto{INFIX[name]}Object"
    none = np.zeros((90, 120))
    return decode(rendered()[0], kind).get(stored_id("pot"), none)


def rgb(planes, prefix=""):
    return np.stack([planes[prefix + c] for c in "RGB"], 2).astype("float64")


def recoloured(through, output):
    rendered()
    more = ["--through", through] if through else []
    run = glint("recolor", path("frame.exr"), "-n", "pot", "-c", ",".join(map(str, BLUE)), *more,
                "-o", path(output), "--json")
    return read(path(output))[0].planes, json.loads(run.stdout)


def test_the_mattes_of_the_daemon_are_those_of_the_file():
    total = 0
    for name in CLASSES:
        plane = read(path(f"{name}.exr"))[0].planes["A"] if rendered() else None
        last = rendered()[0][f"Crypto{INFIX[name]}Object07.A"]  # what has no rank there is less
        assert np.abs(plane - pot(name)).max() <= last.max() + 1e-6, name
        assert np.abs(plane - pot(name))[last == 0].max() < 1e-6, name
        total = total + plane
    whole = read(path(f"{','.join(CLASSES)}.exr"))[0].planes["A"]
    assert np.abs(whole - total).max() < 1e-6
    assert "no mattes of" in rendered()[1]


def test_the_list_of_names_has_the_sums_of_the_mattes_by_class():
    lines = rendered()[2].splitlines()
    assert lines[0] == "object:" and lines[1].split() == ["NAME", "HASH", "PIXELS", "REFLECTION", "REFRACTION"]
    (row,) = [line.split() for line in lines if line.startswith("pot ")]
    for name, told in zip(CLASSES, row[2:]):
        assert abs(float(told) - read(path(f"{name}.exr"))[0].planes["A"].sum()) <= 6e-4 * float(told) + 1e-3, name


def test_the_pot_is_seen_through_glass_where_it_is_not_seen_directly():
    direct, refracted = pot("primary"), pot("refraction")
    glass = decode(rendered()[0], "CryptoObject")[stored_id("glass")]
    assert refracted[glass == 1].max() > 0.5 and refracted[glass == 1].sum() > 30
    assert direct[glass == 1].max() == 0


def test_recolor_changes_what_the_classes_cover_and_nothing_else():
    before = rgb(rendered()[0])
    for through in (None, *CLASSES, ",".join(CLASSES)):
        matte = sum(pot(name) for name in (through or "primary").split(","))
        planes, _ = recoloured(through, "new.exr")
        changed = np.abs(rgb(planes) - before).max(2)
        assert changed[matte == 0].max() == 0, through
        assert (changed[matte > 0.3] > 1e-3).all(), through
        assert changed.max() > 0.01 or matte.max() < 0.3, through


def test_the_new_colour_is_seen_through_the_glass_and_the_glass_keeps_its_albedo():
    planes, report = recoloured(",".join(CLASSES), "blue.exr")
    before, after = rgb(rendered()[0]), rgb(planes)
    through = (pot("primary") == 0) & (pot("refraction") > 0.6)
    assert through.sum() > 20, through.sum()
    assert (before[through][:, 0] > before[through][:, 2]).mean() > 0.95  # it was red
    bluer = (after - before)[through]
    assert (bluer[:, 2] > 0).mean() > 0.95 and (bluer[:, 0] < 0).mean() > 0.95
    albedo = np.abs(rgb(planes, "albedo.") - rgb(rendered()[0], "albedo.")).max(2)
    assert albedo[pot("primary") == 0].max() == 0 < albedo.max()
    alone = recoloured(None, "alone.exr")[1]
    assert report["names"][0]["old"] == alone["names"][0]["old"], "its own albedo, not the glass's"


if __name__ == "__main__":
    tap.main()
