"""reference.py - block means of a peer's pictures, as tests/render/test_peers.py reads them.

    reference.py OUT.json --scene NAME --peer "WHO" --command "HOW" PART.exr...

The parts are pictures of equal samples and different seeds: their mean is the reference, their
scatter its standard error.
"""
import argparse
import json

import numpy as np

from compare import blocks, read

SIDE = 16


def main():
    p = argparse.ArgumentParser()
    p.add_argument("out")
    p.add_argument("parts", nargs="+")
    p.add_argument("--scene", required=True)
    p.add_argument("--peer", required=True)
    p.add_argument("--command", required=True)
    a = p.parse_args()
    images = [read(part) for part in a.parts]
    means = np.array([blocks(image, SIDE) for image in images])
    error = means.std(0, ddof=1) / np.sqrt(len(images))
    numbers = lambda x: [float(f"{v:.6g}") for v in x.reshape(-1)]
    doc = {"scene": a.scene, "peer": a.peer, "command": a.command,
           "size": [images[0].shape[1], images[0].shape[0]], "block": SIDE,
           "about": "[row][column][rgb] of blocks: mean radiance and its standard error",
           "mean": numbers(means.mean(0)), "error": numbers(error)}
    with open(a.out, "w") as f:
        json.dump(doc, f, indent=1)
        f.write("\n")


if __name__ == "__main__":
    main()
