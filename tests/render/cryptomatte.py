"""cryptomatte.py - OpenEXR files as OpenImageIO reads them, and Cryptomatte from its specification.

Shares no code with the project's own reader, hash and decoder, and checks them.
"""
import struct

import numpy as np
import OpenImageIO as oiio


def murmur3(data):
    def rotate(value, bits):
        return (value << bits | value >> (32 - bits)) & 0xffffffff

    def mix(k):
        return rotate(k * 0xcc9e2d51 & 0xffffffff, 15) * 0x1b873593 & 0xffffffff

    h = 0
    whole = len(data) // 4 * 4
    for (k,) in struct.iter_unpack("<I", data[:whole]):
        h = (rotate(h ^ mix(k), 13) * 5 + 0xe6546b64) & 0xffffffff
    h ^= mix(int.from_bytes(data[whole:], "little")) ^ len(data)
    h = (h ^ h >> 16) * 0x85ebca6b & 0xffffffff
    h = (h ^ h >> 13) * 0xc2b2ae35 & 0xffffffff
    return h ^ h >> 16


def stored_id(name):
    h = murmur3(name.encode())
    return h ^ 1 << 23 if h >> 23 & 255 in (0, 255) else h


# Names that are hard for one reason or another, and what the specification makes of them.
STORED = {"bunny": "13851a76", "default": "42c9679f", "torus": "f19c73fd", "равнина": "9623511e",
          "name, with, comma": "62fa4db8", 'name containing a "quote"  ': "af8bfa09",
          "flowerA.flowerA_petal11.:778": "008586a5", "flowerA.flowerA_petal1.:1065": "7f0e5296"}


class Part:
    """One part as OpenImageIO gives it: spec, channel planes by name, attributes."""

    def __init__(self, image, index):
        image.seek_subimage(index, 0)
        self.spec = spec = image.spec()
        self.types = dict(zip(spec.channelnames,
                              spec.channelformats or [spec.format] * spec.nchannels))
        self.planes = {}
        for c, name in enumerate(spec.channelnames):
            wanted = "uint" if str(self.types[name]) == "uint" else "float"
            pixels = image.read_image(index, 0, c, c + 1, wanted)
            self.planes[name] = np.asarray(pixels).reshape(spec.height, spec.width)

    def attribute(self, name):
        return self.spec.getattribute(name)


def read(file):
    image = oiio.ImageInput.open(file)
    assert image, oiio.geterror()
    parts = []
    while image.seek_subimage(len(parts), 0):
        parts.append(Part(image, len(parts)))
    image.close()
    return parts


def decode(planes, kind):
    """Coverage planes by ID of one Cryptomatte, in a dictionary."""
    coverage = {}
    layer = 0
    while f"{kind}{layer:02d}.R" in planes:
        for i, c in ("RG", "BA"):
            ids = np.ascontiguousarray(planes[f"{kind}{layer:02d}.{i}"]).view(np.uint32)
            weight = planes[f"{kind}{layer:02d}.{c}"]
            for one in np.unique(ids):
                coverage.setdefault(int(one), np.zeros(ids.shape, np.float64))
                coverage[int(one)] += np.where(ids == one, weight, 0)
        layer += 1
    return coverage
