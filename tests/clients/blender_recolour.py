#!/usr/bin/python3
"""An object behind rough glass, picked and recoloured in Blender with what a mirror shows of it."""
import functools
import json
import os
import struct
import subprocess
import sys
import tempfile

import tap

sys.path.insert(0, tap.source("tests", "render"))
try:
    import numpy as np
    from cryptomatte import decode, read, stored_id
except ImportError as missing:
    tap.skip_all(str(missing))

SIZE = 160, 90
FOLDER = tempfile.TemporaryDirectory()
BEHIND = 115, 52  # a pixel of the pane, with the ball behind it
CLASSES = ["CryptoObject", "CryptoReflObject", "CryptoRefrObject"]


def path(name):
    return os.path.join(FOLDER.name, name)


def run(*command, **options):
    return subprocess.run(command, check=True, capture_output=True, timeout=300, **options).stdout


def instance(name, mesh, at, scale=(1, 1, 1), turn=(0, 0, 0, 1)):
    return {name: {"object": name, "mesh": mesh, "material": name,
                   "transform": {"translation": at, "rotation": turn, "scale": scale}}}


def scene():
    """A red ball: its left side in the open, its right behind a frosted pane, all of it in a mirror."""
    instances = {**instance("floor", "quad", [0, 0, 0], (12, 12, 1), (-0.7071068, 0, 0, 0.7071068)),
                 **instance("red", "ball", [0.35, 0.5, -0.6], (0.5, 0.5, 0.5)),
                 **instance("pane", "quad", [0.85, 0.5, 0.3], (1, 1, 1)),
                 **instance("mirror", "quad", [-0.75, 0.5, -0.5], (1.3, 1, 1), (0, 0.38268, 0, 0.92388)),
                 **instance("green", "ball", [-1.1, 0.25, 0.6], (0.25, 0.25, 0.25))}
    return {"environment": {"radiance": [1, 1, 1]}, "objects": {name: {} for name in instances},
            "instances": instances,
            "meshes": {"quad": {"primitive": "quad"}, "ball": {"primitive": "sphere", "segments": 48}},
            "materials": {"floor": {"base_color": [0.5, 0.5, 0.5], "roughness": 1},
                          "red": {"base_color": [0.7, 0.06, 0.05], "roughness": 0.9},
                          "green": {"base_color": [0.08, 0.4, 0.1], "roughness": 0.9},
                          "mirror": {"base_color": [0.9, 0.9, 0.9], "metallic": 1, "roughness": 0.1},
                          "pane": {"transmission": 1, "roughness": 0.12, "thin": True}},
            "cameras": {"eye": {"yfov": 0.5, "transform": {"translation": [0, 0.5, 3.4]}}}}


@functools.lru_cache(maxsize=None)
def frame(mattes="{}", samples=128, size=SIZE):
    job = {"scene": "s", "resolution": size, "stop": {"samples": samples},
           "outputs": ["beauty", "crypto_object"],
           "mattes": {"through": "glossy", "alpha": 0.02, "levels": 8, "slots": 16, **json.loads(mattes)}}
    for name, value in ("scene.json", scene()), ("job.json", job):
        with open(path(name), "w", encoding="utf-8") as to:
            json.dump(value, to)
    out = path(f"frame{frame.cache_info().misses}.exr")
    run(tap.build("tests", "render", "render_file"), path("scene.json"), path("job.json"), out)
    return out


def parted():
    return frame('{"classes": true}')


def planes():
    return read(parted())[0].planes


def rgb(file):
    of = read(file)[0].planes
    return np.stack([of[c] for c in "RGB"], 2)


@functools.lru_cache(maxsize=None)
def blender():
    """What it printed, and the picture before and after."""
    program = tap.tool("blender")
    orders = [{"layers": CLASSES, "pick": ["CryptoRefrObject", *BEHIND], "hue": hue, "out": path(out),
               "matte": path("matte.exr")} for hue, out in ((0.5, "same.exr"), (0.1, "blue.exr"))]
    with open(path("orders.json"), "w", encoding="utf-8") as to:
        json.dump(orders, to)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "blender_cryptomatte.py")
    text = run(program, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "-P", script,
               "--", parted(), *map(str, SIZE), path("orders.json"),
               env={**os.environ, "HOME": FOLDER.name}).decode()
    return text, rgb(path("same.exr")), rgb(path("blue.exr"))


def ours():
    """Coverage of the ball through all classes, by numpy."""
    red = stored_id("red")
    return [decode(planes(), kind).get(red, np.zeros(SIZE[::-1])) for kind in CLASSES]


def test_the_pane_gives_its_place_to_the_ball_and_the_mirror_to_its_reflection():
    direct, reflected, refracted = ours()
    x, y = BEHIND
    assert direct[y, x] == 0 and refracted[y, x] > 0.4, refracted[y, x]
    assert decode(planes(), "CryptoObject")[stored_id("pane")][y, x] > 0.99
    assert reflected.sum() > 100 and refracted.sum() > 100 and direct.sum() > 100
    mirror = decode(planes(), "CryptoObject")[stored_id("mirror")]
    assert reflected[mirror == 0].max() < 0.1 < reflected[mirror == 1].max()


def test_a_click_on_the_pane_picks_the_ball_behind_it():
    text = blender()[0]
    picked = {json.loads(line[7:]) for line in text.splitlines() if line.startswith("PICKED ")}
    value = struct.unpack("<f", struct.pack("<I", stored_id("red")))[0]
    assert len(picked) == 1
    assert np.float32(picked.pop().strip("<>")) == np.float32(value)
    layers = next(json.loads(line[7:]) for line in text.splitlines() if line.startswith("LAYERS "))
    assert {name.split(".")[-1] for name in layers} == set(CLASSES)


def test_blenders_sum_of_mattes_is_that_of_a_numpy_decoder():
    blender()
    plane = next(iter(read(path("matte.exr"))[0].planes.values()))
    assert np.abs(np.minimum(sum(ours()), 1) - plane).max() <= 1e-6


def test_the_ball_is_recoloured_in_the_open_behind_glass_and_in_the_mirror_and_nothing_else_is():
    _, same, blue = blender()
    matte = np.minimum(sum(ours()), 1)
    assert np.abs(same - rgb(parted())).max() < 1e-3
    change = np.abs(blue - same).max(2)
    assert change[matte == 0].max() < 1e-4
    for part in ours():
        inside = part > 0.4
        assert inside.sum() > 100, inside.sum()
        redder, bluer = same - blue, blue - same
        assert (redder[inside][:, 0] > 0.05).mean() > 0.95
        assert (bluer[inside][:, 2] > 0.05).mean() > 0.95


def test_no_type_of_any_job_is_a_prefix_of_another_and_each_has_a_manifest():
    for mattes, types in (("{}", {"CryptoObject", "CryptoGlossObject"}),
                          ('{"classes": true}', set(CLASSES)),
                          ('{"depth_bins": 10}', {"CryptoObject", *(f"CryptoD{i}Object" for i in range(10))})):
        part = read(frame(mattes, 1, (16, 9)))[0]
        told = {a.name: a.value for a in part.spec.extra_attribs if a.name.startswith("cryptomatte/")}
        names = [value for name, value in told.items() if name.endswith("/name")]
        assert set(names) == types
        assert not any(a != b and b.startswith(a) for a in names for b in names)
        for name in names:
            key = f"cryptomatte/{stored_id(name):08x}"[:19]
            assert told[key + "/name"] == name, key
            assert told[key + "/hash"] == "MurmurHash3_32"
            assert told[key + "/conversion"] == "uint32_to_float32"
            manifest = json.loads(told[key + "/manifest"])
            assert manifest == {n: f"{stored_id(n):08x}" for n in scene()["objects"]}
            ids = decode(part.planes, name)
            assert set(ids) <= {0, *(int(i, 16) for i in manifest.values())}


if __name__ == "__main__":
    tap.main()
