"""compare.py - mean ratio and block ratios of two pictures of one scene.

    compare.py OURS.exr PEER.exr [--block 16] [--map]

For each channel and for luminance: mean of ours over the peer's, then the 5th, 50th and 95th
percentile of the ratios of block means, and the worst block. --map prints the luminance ratios.
"""
import argparse

import numpy as np
import OpenImageIO as oiio

LUMINANCE = np.array([.2126, .7152, .0722])


def read(path):
    image = oiio.ImageInput.open(path)
    names = list(image.spec().channelnames)
    pixels = image.read_image("float")
    image.close()
    pick = [next(k for k, n in enumerate(names) if n.split(".")[-1] == c) for c in "RGB"]
    return pixels[..., pick].astype(np.float64)


def blocks(image, side):
    h, w = image.shape[0] // side, image.shape[1] // side
    return image[:h * side, :w * side].reshape(h, side, w, side, -1).mean((1, 3))


def ratios(ours, peer, side):
    a, b = blocks(ours, side), blocks(peer, side)
    return a / np.maximum(b, 1e-9)


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
        worst = int(np.argmax(np.abs(v - 1)))
        print(f"{name} mean {a[..., c].mean() / b[..., c].mean():.4f}  p5 {np.quantile(v, .05):.4f}  "
              f"p50 {np.quantile(v, .5):.4f}  p95 {np.quantile(v, .95):.4f}  worst {v[worst]:.4f} "
              f"at row {worst // r.shape[1]} column {worst % r.shape[1]}")
    if o.map:
        for row in r[..., 3]:
            print(" ".join(f"{v:6.3f}" for v in row))


if __name__ == "__main__":
    main()
