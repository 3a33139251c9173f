"""compare.py - mean ratio and block ratios of two pictures of one scene.

    compare.py OURS.exr PEER.exr [--block 16] [--map]

For each channel and for luminance: mean of ours over the peer's, then the 5th, 50th and 95th
percentile of the ratios of block means, and the worst block; blocks with less than a hundredth of
the peer's mean are left out. --map prints the luminance ratios.
"""
import argparse

import numpy as np
import OpenImageIO as oiio

LUMINANCE = np.array([.2126, .7152, .0722])


def read(path, layer=""):
    """R, G and B of a layer, "" or a name with its dot."""
    image = oiio.ImageInput.open(path)
    names = list(image.spec().channelnames)
    pixels = image.read_image("float")
    image.close()
    pick = [names.index(layer + c) for c in "RGB"]
    return pixels[..., pick].astype(np.float64)


def blocks(image, side):
    h, w = image.shape[0] // side, image.shape[1] // side
    return image[:h * side, :w * side].reshape(h, side, w, side, -1).mean((1, 3))


def ratios(ours, peer, side):
    """Of block means; NaN where the peer has less than a hundredth of its mean."""
    a, b = blocks(ours, side), blocks(peer, side)
    return np.where(b < .01 * b.mean((0, 1)), np.nan, a / np.maximum(b, 1e-30))


def main():
    p = argparse.ArgumentParser()
    p.add_argument("ours")
    p.add_argument("peer")
    p.add_argument("--block", type=int, default=16)
    p.add_argument("--map", action="store_true")
    o = p.parse_args()
    a, b = read(o.ours), read(o.peer)
    a, b = (np.concatenate([x, (x @ LUMINANCE)[..., None]], 2) for x in (a, b))
    r = ratios(a, b, o.block)
    for c, name in enumerate(("R", "G", "B", "Y")):
        v = r[..., c].reshape(-1)
        worst = int(np.nanargmax(np.abs(v - 1)))
        p5, p50, p95 = np.nanquantile(v, (.05, .5, .95))
        print(f"{name} mean {a[..., c].mean() / b[..., c].mean():.4f}  p5 {p5:.4f}  p50 {p50:.4f}  "
              f"p95 {p95:.4f}  worst {v[worst]:.4f} "
              f"at row {worst // r.shape[1]} column {worst % r.shape[1]}")
    if o.map:
        for row in r[..., 3]:
            print(" ".join(f"{v:6.3f}" for v in row))


if __name__ == "__main__":
    main()
