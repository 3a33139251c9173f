#!/usr/bin/python3
"""Our OpenEXR files as programs read them that share no code with ours, and theirs as we read them.

OpenImageIO and the tools of OpenEXR use the C++ library; cryptomatte.py follows the specification.
"""
import json
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tap
from tools import exrinfo, run

try:
    import numpy as np
    from cryptomatte import STORED, decode, read, stored_id
except ImportError as missing:
    tap.skip_all(str(missing))

PROGRAM = tap.build("tests", "render", "write_frame")
WIDTH, HEIGHT = 48, 32
NAMES = ["bunny", "torus", "равнина", "name, with, comma", 'name containing a "quote"  ',
         "flowerA.flowerA_petal11.:778", "flowerA.flowerA_petal1.:1065", "back\\slash"]
FOLDER = tempfile.TemporaryDirectory()


def path(name):
    return os.path.join(FOLDER.name, name)


def known(compression="zip", layout="single"):
    out = path(f"{compression}-{layout}.exr")
    if not os.path.exists(out):
        clamped = run(PROGRAM, out, compression, layout)
        assert int(clamped) == HEIGHT, clamped  # one column of B
    return out


def check_cryptomatte(planes, attribute, kind, key, shift):
    assert attribute(f"cryptomatte/{key}/name") == kind
    assert attribute(f"cryptomatte/{key}/hash") == "MurmurHash3_32"
    assert attribute(f"cryptomatte/{key}/conversion") == "uint32_to_float32"
    manifest = json.loads(attribute(f"cryptomatte/{key}/manifest"))
    assert manifest == {name: f"{stored_id(name):08x}" for name in NAMES}, manifest
    assert list(manifest) == sorted(NAMES, key=str.encode)
    assert {name: STORED.get(name, stored) for name, stored in manifest.items()} == manifest
    k = np.arange(WIDTH) // 6 + shift
    coverage = decode(planes, kind)
    for n, name in enumerate(NAMES):
        want = 0.5 * (k % 8 == n) + 0.25 * ((k + 1) % 8 == n) + 0.125 * ((k + 3) % 8 == n)
        assert (coverage[int(manifest[name], 16)] == np.tile(want, (HEIGHT, 1))).all(), name
    assert (coverage[0] == 0.125).all()
    first = np.ascontiguousarray(planes[f"{kind}00.B"]).view(np.uint32)
    assert (planes[f"{kind}00.A"] == 0.25).all() and (first != 0).all()
    # A tie of an eighth: the lower bits, of nothing, come first.
    assert (planes[f"{kind}01.R"] == 0).all() and (planes[f"{kind}01.A"] == 0.125).all()
    assert (planes[f"{kind}02.R"] == 0).all() and (planes[f"{kind}02.G"] == 0).all()


def check_images(planes):
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    f32 = np.float32
    assert (planes["R"] == x / 8).all() and (planes["G"] == -y).all()
    blue = np.where(x == 7, 65504, f32(np.float16(0.1)))
    assert (planes["B"] == blue).all() and (planes["A"] == 1).all()
    depth = np.where(x % 2 == 1, f32(1e30), f32(1.1) + y.astype(f32))
    assert (planes["Z"] == depth).all()
    assert (planes["N.X"] == x.astype(f32) * f32(0.001) - f32(0.02)).all()
    assert (planes["samples.Y"] == 1000000 * y + x).all()


def check_header(part):
    spec = part.spec
    assert (spec.x, spec.y, spec.width, spec.height) == (10, -5, WIDTH, HEIGHT)
    assert (spec.full_x, spec.full_y, spec.full_width, spec.full_height) == (0, 0, 96, 64)
    assert spec.tile_width == 0, "tiled"
    assert np.allclose(part.attribute("chromaticities"),
                       [.64, .33, .30, .60, .15, .06, .3127, .3290], atol=1e-7)
    assert part.attribute("worldToCamera") == (1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 5, 6, 7, 1)
    assert part.attribute("glint/samples") == 64
    assert part.attribute("PixelAspectRatio") == 1
    assert part.attribute("screenWindowWidth") == 1
    comments = part.attribute("ImageDescription") or part.attribute("comments")
    assert comments == "two\nlines"
    for dated in ("DateTime", "capDate", "Software"):
        assert part.attribute(dated) is None, dated


def test_openimageio_reads_every_pixel_type_and_attribute():
    for compression in ("none", "zip", "zips"):
        parts = read(known(compression))
        assert len(parts) == 1
        check_header(parts[0])
        check_images(parts[0].planes)
        for name, kind in parts[0].types.items():
            want = "half" if name in "RGBA" else "uint" if name == "samples.Y" else "float"
            assert str(kind) == want, (name, str(kind))
        assert parts[0].attribute("compression") == compression


def test_a_numpy_decoder_finds_names_and_coverage():
    part = read(known())[0]
    check_cryptomatte(part.planes, part.attribute, "CryptoObject", "3ae39a5", 0)
    check_cryptomatte(part.planes, part.attribute, "CryptoMaterial", "be359d6", 2)


def test_multipart_has_colour_first_and_all_keys_there():
    parts = read(known("zip", "multipart"))
    names = [part.attribute("oiio:subimagename") for part in parts]
    assert names == ["rgba", "CryptoMaterial", "CryptoObject", "N", "Z", "samples"], names
    assert sorted(parts[0].planes) == ["A", "B", "G", "R"]
    planes = {}
    for part in parts:
        check_header(part)
        planes.update(part.planes)
    check_images(planes)
    for kind, key, shift in (("CryptoObject", "3ae39a5", 0), ("CryptoMaterial", "be359d6", 2)):
        own = parts[names.index(kind)]
        assert own.attribute("compression") == "zips"
        check_cryptomatte(planes, parts[0].attribute, kind, key, shift)
        check_cryptomatte(planes, own.attribute, kind, key, shift)
    assert parts[0].attribute("compression") == "zip"
    assert parts[1].attribute("cryptomatte/3ae39a5/name") is None


def test_exrinfo_lists_the_channels_in_order():
    text = exrinfo("-v", known())
    listed = [word for word in text.replace("'", " ").split() if word in read(known())[0].planes]
    assert listed and listed == sorted(listed, key=str.encode), text
    assert len(exrinfo("-a", known("zip", "multipart"))) > 0


def test_iinfo_and_oiiotool_read_it():
    text = run(tap.tool("iinfo"), "-v", known()).decode()
    assert "48 x" in text and "CryptoObject00.R" in text, text
    stats = run(tap.tool("oiiotool"), "--stats", known()).decode()
    assert "65504" in stats and "Stats NanCount: 0" in stats.replace("  ", " "), stats


def same_pixels(a, b):
    theirs, ours = read(a)[0], read(b)[0]
    assert sorted(theirs.planes) == sorted(ours.planes)
    for name, plane in theirs.planes.items():
        got = ours.planes[name]
        assert (np.ascontiguousarray(plane).view(np.uint32) ==
                np.ascontiguousarray(got).view(np.uint32)).all(), (a, name)
    for window in ("x", "y", "width", "height", "full_width", "full_height"):
        assert getattr(theirs.spec, window) == getattr(ours.spec, window), window


def test_our_reader_agrees_with_openimageio_on_every_compression():
    oiiotool = tap.tool("oiiotool")
    variants = [[c, *extra] for c in ("none", "rle", "zips", "zip", "piz", "pxr24")
                for extra in ([], ["--tile", "32", "16"], ["-d", "half"], ["-d", "float"])]
    variants += [["b44", "-d", "half"], ["b44a", "-d", "half"],
                 ["b44", "--tile", "16", "16", "-d", "half"]]
    for variant in variants:
        foreign, copied = path("foreign.exr"), path("copied.exr")
        # 1e30 in Z would be infinite as a half, and our writer clamps that.
        channels = "R,G,B,A,N.X" if "half" in variant else "R,G,B,A,N.X,Z"
        run(oiiotool, known(), "--ch", channels, "--compression", *variant, "-o", foreign)
        run(PROGRAM, "--copy", foreign, copied)
        same_pixels(foreign, copied)


def test_our_reader_takes_the_finest_level_of_a_texture():
    foreign, copied = path("texture.exr"), path("copied.exr")
    run(tap.tool("maketx"), "--format", "exr", known(), "-o", foreign)
    run(PROGRAM, "--copy", foreign, copied)
    same_pixels(foreign, copied)


def test_our_reader_agrees_with_openimageio_on_published_samples():
    folder = tap.scenes("cryptomatte")
    for name in sorted(os.listdir(folder)):
        if name.endswith(".exr"):
            copied = path("copied.exr")
            run(PROGRAM, "--copy", os.path.join(folder, name), copied)
            same_pixels(os.path.join(folder, name), copied)


def test_every_name_of_the_published_manifests_has_our_id():
    folder = tap.scenes("cryptomatte")
    names = {}
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".exr"):
            continue
        for attribute in read(os.path.join(folder, name))[0].spec.extra_attribs:
            if attribute.name.startswith("cryptomatte/") and attribute.name.endswith("/manifest"):
                names.update(json.loads(attribute.value))
    lines = "".join(name + "\n" for name in names).encode()
    ids = run(PROGRAM, "--ids", input=lines).decode().split()
    assert len(ids) == len(names) > 10
    for (name, stored), ours in zip(names.items(), ids):
        assert stored == ours == f"{stored_id(name):08x}", (name, stored, ours)


if __name__ == "__main__":
    tap.main()
