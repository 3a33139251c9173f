#!/usr/bin/python3
"""Mattes of a frame of ours, by Blender's Cryptomatte node and by a decoder that follows the
specification; and the frame in the hands of other programs."""
import functools
import json
import math
import os
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tap
from tools import exrinfo, run

try:
    import numpy as np
    from cryptomatte import STORED, decode, read
except ImportError as missing:
    tap.skip_all(str(missing))

SIZE = 96, 64
FOLDER = tempfile.TemporaryDirectory()
TYPES = {"CryptoObject": "3ae39a5", "CryptoMaterial": "be359d6", "CryptoAsset": "f42029d"}


def path(name):
    return os.path.join(FOLDER.name, name)


def scene():
    """A ring of balls that overlap each other, out of focus, before a wall that leaves some sky."""
    objects = {f"o{i}": {"name": name, "asset": ("left", "", "right")[i % 3]}
               for i, name in enumerate(STORED)}
    instances = {}
    for i, key in enumerate(objects):
        angle = 2 * math.pi * i / len(objects)
        at = [1.3 * math.cos(angle), 0.9 * math.sin(angle), 0.8 * math.sin(2 * angle)]
        instances[f"i{i}"] = {"mesh": "ball", "material": f"m{i % 4}", "object": key,
                              "transform": {"translation": at}}
    instances["wall"] = {"mesh": "wall", "material": "m4",
                         "transform": {"translation": [-1, -1, -2], "rotation": [0, 0, 0.2, 0.98]}}
    return {"environment": {"radiance": [1, 1, 1]}, "objects": objects, "instances": instances,
            "materials": {f"m{i}": {"name": f"material {i}"} for i in range(5)},
            "meshes": {"ball": {"primitive": "sphere", "radius": 0.6},
                       "wall": {"primitive": "quad", "size": [4, 4]}},
            "cameras": {"eye": {"yfov": 0.7, "lens_radius": 0.5, "focus_distance": 5,
                                "transform": {"translation": [0, 0, 5]}}}}


@functools.lru_cache(maxsize=None)
def frame():
    """The rendered file."""
    job = {"scene": "s", "resolution": SIZE, "max_bounces": 1, "stop": {"samples": 64},
           "mattes": {"levels": 12, "slots": 24}}
    for name, value in ("scene.json", scene()), ("job.json", job):
        with open(path(name), "w", encoding="utf-8") as to:
            json.dump(value, to)
    run(tap.build("tests", "render", "render_file"), path("scene.json"), path("job.json"),
        path("frame.exr"))
    return path("frame.exr")


@functools.lru_cache(maxsize=None)
def part():
    parts = read(frame())
    assert len(parts) == 1
    return parts[0]


@functools.lru_cache(maxsize=None)
def manifest(kind):
    return json.loads(part().attribute(f"cryptomatte/{TYPES[kind]}/manifest"))


def matte(kind, *names):
    coverage = decode(part().planes, kind)
    return sum(coverage[int(manifest(kind)[name], 16)] for name in names)


def blender_mattes(orders):
    """Planes that the node gives for [(layer, what a user types)], and the layers it offers."""
    blender = tap.tool("blender")
    listed = [{"layer": layer, "matte": typed, "out": path(f"matte{i}.exr")}
              for i, (layer, typed) in enumerate(orders)]
    with open(path("orders.json"), "w", encoding="utf-8") as to:
        json.dump(listed, to)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cryptomatte_node.py")
    text = run(blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1",
               "-P", script, "--", frame(), *map(str, SIZE), path("orders.json"),
               env={**os.environ, "HOME": FOLDER.name}).decode()
    layers = next(json.loads(line[7:]) for line in text.splitlines() if line.startswith("LAYERS "))
    planes = [next(iter(read(order["out"])[0].planes.values())) for order in listed]
    return planes, layers


def test_manifest_has_the_hash_of_every_name():
    names = manifest("CryptoObject")
    assert {name: names[name] for name in STORED} == STORED
    assert set(names) == {*STORED, "wall"}
    assert set(manifest("CryptoMaterial")) == {f"material {i}" for i in range(5)}
    assert set(manifest("CryptoAsset")) == {"left", "right"}


def test_every_name_has_coverage_and_all_ids_are_in_the_manifest():
    for kind in TYPES:
        coverage = decode(part().planes, kind)
        assert set(coverage) == {0} | {int(stored, 16) for stored in manifest(kind).values()}
        for name in manifest(kind):
            assert matte(kind, name).sum() > 10, (kind, name)
        total = sum(coverage.values())
        assert np.abs(total - 1).max() <= 1e-5, kind
    assert (part().planes["CryptoObject01.A"] > 0).any()  # pixels with four ranks and more


def test_blenders_node_gives_the_mattes_of_the_numpy_decoder():
    def number(name):  # as Blender writes what was picked
        return f"<{struct.unpack('<f', bytes.fromhex(STORED[name])[::-1])[0]:.9g}>"

    comma, quote = "name, with, comma", 'name containing a "quote"  '
    small, big = "flowerA.flowerA_petal11.:778", "flowerA.flowerA_petal1.:1065"
    wanted = [(("CryptoObject", "bunny"), ["bunny"]),
              (("CryptoObject", "равнина"), ["равнина"]),
              (("CryptoObject", small), [small]),
              (("CryptoObject", big), [big]),
              (("CryptoObject", number(comma)), [comma]),
              (("CryptoObject", f"{number(quote)},torus,default"), [quote, "torus", "default"]),
              (("CryptoMaterial", "material 2"), ["material 2"]),
              (("CryptoAsset", "left"), ["left"])]
    planes, layers = blender_mattes([order for order, _ in wanted])
    assert len(layers) == 3 and {name.split(".")[-1] for name in layers} == set(TYPES), layers
    for ((kind, typed), names), plane in zip(wanted, planes):
        ours = matte(kind, *names)
        difference = np.abs(np.minimum(ours, 1) - plane).max()
        print(kind, typed, float(ours.sum()), difference)
        assert ours.sum() > 10 and difference <= 1e-6, (kind, typed, difference)


def test_exrinfo_iinfo_and_oiiotool_read_the_frame():
    wanted = ["R", "A", *(f"{kind}0{layer}.{c}" for kind in TYPES for layer in range(6) for c in "RGBA")]
    info = exrinfo("-v", frame())
    lines = run(tap.tool("iinfo"), "-v", frame()).decode()
    for name in wanted:
        assert name in info and name in lines, name
    for key in TYPES.values():
        assert f"cryptomatte/{key}/manifest" in info and f"cryptomatte/{key}/manifest" in lines
    stats = run(tap.tool("oiiotool"), "--stats", frame()).decode()
    assert f"{SIZE[0]} x {SIZE[1]}" in " ".join(stats.split()), stats
    for bad in "NanCount", "InfCount":
        line = next(line for line in stats.splitlines() if bad in line)
        assert not set(line.split(":")[1]) & set("123456789"), line


if __name__ == "__main__":
    tap.main()
