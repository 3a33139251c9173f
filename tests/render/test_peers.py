#!/usr/bin/python3
"""Frames of ours beside those of renderers that nobody here wrote: block means and their standard
errors in tests/render/peers/*.json, each with the command that made it.

The frame's mean must lie within FRAME of the peer's, and every block within SIGMAS standard errors
of the difference and BLOCK of the peer's mean. The noise of both sides is bounded, so that a
renderer that is off by 1% fails; a test of its own holds the judge to that.
"""
import functools
import json
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, ".."), os.path.join(HERE, "peers")]
import tap

try:
    import numpy as np
    import compare
    import scenes
except ImportError as missing:
    tap.skip_all(str(missing))

FRAME, BLOCK, SIGMAS = 0.004, 0.006, 4.0
NOISE = 0.001 # most that the standard error of the frame's mean may be, of that mean
SAMPLES = 256
NAMES = "cornell", "balls-white", "balls"


@functools.lru_cache(maxsize=None)
def reference(name):
    with open(os.path.join(HERE, "peers", f"{name}.json")) as f:
        doc = json.load(f)
    shape = doc["size"][1] // doc["block"], doc["size"][0] // doc["block"], 3
    return doc, np.reshape(doc["mean"], shape), np.reshape(doc["error"], shape)


@functools.lru_cache(maxsize=None)
def rendered(name):
    """Our block means and their standard errors."""
    doc, _, _ = reference(name)
    job = {"scene": name, "resolution": doc["size"], "outputs": ["beauty", "variance"],
           "filter": {"kind": "box", "width": 1}, "max_bounces": 64, "seed": 5,
           # The peers' microfacets are made of one reflection too.
           "accuracy": {"microfacet": "single"}, "stop": {"samples": SAMPLES}}
    with tempfile.TemporaryDirectory() as folder:
        path = functools.partial(os.path.join, folder)
        for file, value in ("scene.json", scenes.MADE[name]()), ("job.json", job):
            with open(path(file), "w") as f:
                json.dump(value, f)
        subprocess.run([tap.build("tests/render/render_file"), path("scene.json"),
                        path("job.json"), path("out.exr"), "--threads", "2"],
                       check=True, stdout=sys.stderr)
        image = compare.read(path("out.exr"))
        variance = compare.read(path("out.exr"), "variance.")
    side = doc["block"]
    return (compare.blocks(image, side), np.sqrt(compare.blocks(variance, side)) / side)


def faults(name, factor=1.0):
    """What is wrong with our frame times `factor`, as sentences."""
    _, theirs, their_error = reference(name)
    ours, our_error = rendered(name)
    difference = ours * factor - theirs
    error = np.hypot(our_error * factor, their_error)
    out = []
    for c, channel in enumerate("RGB"):
        mean = theirs[..., c].mean()
        off = difference[..., c].mean() / mean
        noise = np.sqrt((error[..., c] ** 2).sum()) / error[..., c].size / mean
        if abs(off) > FRAME or noise > NOISE:
            out.append(f"{channel} of the frame is off by {off:.2%} +- {noise:.2%}")
    bound = SIGMAS * error + BLOCK * theirs
    for row, column, c in np.argwhere(np.abs(difference) > bound):
        out.append(f"{'RGB'[c]} of block {row},{column} is off by "
                   f"{difference[row, column, c] / theirs[row, column, c]:.2%}, more than "
                   f"{bound[row, column, c] / theirs[row, column, c]:.2%}")
    return out


def agree(name):
    found = faults(name)
    assert not found, "\n".join([reference(name)[0]["peer"], *found])


def test_diffuse_light_is_that_of_mitsuba():
    agree("cornell")


def test_white_metals_and_glass_are_those_of_mitsuba():
    agree("balls-white")


def test_coloured_metals_of_all_roughness_and_glass_are_those_of_cycles():
    agree("balls")


def test_an_error_of_one_percent_would_be_found():
    for name in NAMES:
        for factor in 0.99, 1.01:
            assert faults(name, factor), f"{name} times {factor} passes"


if __name__ == "__main__":
    tap.main()
