#!/usr/bin/python3
"""glint recolor, on files: against the formula, against a renderer, and what it refuses."""
import json
import os
import struct
import sys
import tempfile

import cli
import tap

try:
    import numpy
    import OpenImageIO as oiio
except ImportError:
    tap.skip_all("no OpenImageIO for Python")

sys.path.insert(0, tap.source("tests", "http"))

WIDTH, HEIGHT = 40, 30
IDS = {"ball": 0x3f123456, "floor": 0x3e654321, "hidden": 0x3d000001}
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])
RED, BLUE = numpy.array([0.7, 0.1, 0.08]), numpy.array([0.05, 0.2, 0.9])


def as_float(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def coverage():
    """A disc with a soft edge."""
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    return numpy.clip(9.5 - numpy.hypot(x - 18.2, y - 14.7), 0, 1).astype("float32")


def picture(colour, light=(1, 1, 1)):
    """The disc in `colour` on grey, its light growing from left to right; albedo beside it."""
    alpha = coverage()[:, :, None]
    shade = (0.3 + numpy.mgrid[0:HEIGHT, 0:WIDTH][1] / WIDTH)[:, :, None] * numpy.array(light)
    albedo = alpha * colour + (1 - alpha) * 0.4
    return (albedo * shade).astype("float32"), albedo.astype("float32")


def write(path, image, albedo=None, manifest=True, layers=("CryptoObject",), attributes=None,
          more=None):
    """An EXR of float channels with ranks of ball and floor in each layer."""
    names, planes = ["R", "G", "B"], [image[:, :, k] for k in range(3)]
    if albedo is not None:
        names += ["albedo.R", "albedo.G", "albedo.B"]
        planes += [albedo[:, :, k] for k in range(3)]
    alpha, zero = coverage(), numpy.zeros((HEIGHT, WIDTH), "float32")
    for layer in layers:
        ids = [numpy.where(alpha > 0, as_float(IDS["ball"]), 0),
               numpy.where(alpha < 1, as_float(IDS["floor"]), 0)]
        names += [f"{layer}00.{c}" for c in "RGBA"]
        planes += [ids[0], alpha, ids[1], 1 - alpha]
    for name in more or []:
        names.append(name)
        planes.append(zero + 0.25)
    spec = oiio.ImageSpec(WIDTH, HEIGHT, len(names), oiio.FLOAT)
    spec.channelnames = names
    for i, layer in enumerate(layers):
        key = f"cryptomatte/{i}abcdef"
        spec[key + "/name"], spec[key + "/hash"] = layer, "MurmurHash3_32"
        spec[key + "/conversion"] = "uint32_to_float32"
        if manifest:
            spec[key + "/manifest"] = json.dumps({n: f"{b:08x}" for n, b in IDS.items()})
    for name, value in (attributes or {}).items():
        spec[name] = value
    out = oiio.ImageOutput.create(path)
    assert out.open(path, spec)
    assert out.write_image(numpy.stack(planes, 2).astype("float32"))
    out.close()


def read(path):
    """{channel: plane}, and the header."""
    image = oiio.ImageInput.open(path)
    assert image, oiio.geterror()
    pixels = image.read_image(oiio.FLOAT)
    return {n: pixels[:, :, i] for i, n in enumerate(image.spec().channelnames)}, image.spec()


def rgb(planes, prefix=""):
    return numpy.stack([planes[prefix + c] for c in "RGB"], 2)


def expected(image, alpha, old, new):
    """The formula of recolour.h, as it is written there."""
    j, out = int(numpy.argmax(old)), image.astype("float64")
    estimate = image.astype("float64")
    for y, x in zip(*numpy.nonzero((alpha > 0) & (alpha < 0.9999))):
        total, weights = numpy.zeros(3), 0
        for v in range(max(y - 2, 0), min(y + 3, image.shape[0])):
            for u in range(max(x - 2, 0), min(x + 3, image.shape[1])):
                w = float(alpha[v, u]) ** 8 / (1 + (u - x) ** 2 + (v - y) ** 2)
                total, weights = total + w * image[v, u], weights + w
        estimate[y, x] = numpy.minimum(total / weights, image[y, x] / alpha[y, x])
    share = (old / old[j]) ** 2
    light = share * estimate / numpy.where(old > 0, old, 1) + (1 - share) * estimate[:, :, j:j + 1] / old[j]
    return out + alpha[:, :, None] * (new * light - estimate)


def mean(image, alpha):
    return image[alpha >= 0.9999].astype("float64").mean(0)


class Files:
    """A folder of pictures, and the command on them."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        return self

    def __exit__(self, *error):
        self.folder.cleanup()

    def __truediv__(self, name):
        return os.path.join(self.folder.name, name)

    def recolor(self, source, *arguments, expect=0, output="out.exr"):
        run = cli.glint("recolor", self / source, "-o", self / output, *arguments)
        assert run.returncode == expect, (run.returncode, run.stderr)
        return run


def color(value):
    return ",".join(repr(float(v)) for v in value)


def test_with_an_albedo_the_formula_is_what_is_computed():
    with Files() as files:
        image, albedo = picture(RED, light=(1, 0.8, 0.5))
        write(files / "a.exr", image, albedo)
        report = json.loads(files.recolor("a.exr", "-n", "ball", "-c", color(BLUE), "--json").stdout)
        planes, _ = read(files / "out.exr")
        old = mean(albedo, coverage())
        assert numpy.allclose(report["names"][0]["old"], old, rtol=1e-5)
        assert report["names"][0]["old_from"] == "albedo"
        assert numpy.allclose(rgb(planes), expected(image, coverage(), old, BLUE), atol=1e-5)
        assert numpy.allclose(rgb(planes, "albedo."), expected(albedo, coverage(), old, BLUE),
                              atol=1e-5)


def test_without_an_albedo_the_brightness_is_kept():
    with Files() as files:
        image, _ = picture(RED)
        write(files / "a.exr", image)
        report = json.loads(files.recolor("a.exr", "-n", "ball", "-c", color(BLUE), "--json").stdout)
        planes, _ = read(files / "out.exr")
        old = mean(image, coverage())
        scaled = old * (BLUE @ LUMINANCE) / (old @ LUMINANCE)
        assert report["names"][0]["old_from"] == "picture"
        assert numpy.allclose(rgb(planes), expected(image, coverage(), scaled, BLUE), atol=1e-5)
        inside = coverage() == 1
        assert numpy.allclose((rgb(planes) @ LUMINANCE)[inside].mean(),
                              (image @ LUMINANCE)[inside].mean(), rtol=0.02)


def test_a_surface_gets_the_colour_as_if_it_had_been_made_so():
    for light in [(1, 1, 1), (1, 0.8, 0.5)]:
        grey = numpy.array([0.5, 0.5, 0.5])
        for before, after in [(RED, BLUE), (BLUE, grey)] if light == (1, 1, 1) else [(grey, RED)]:
            with Files() as files:
                image, albedo = picture(before, light)
                write(files / "a.exr", image, albedo)
                files.recolor("a.exr", "-n", "ball", "-c", color(after))
                planes, _ = read(files / "out.exr")
                wanted, wanted_albedo = picture(after, light)
                inside = coverage() == 1
                assert numpy.allclose(rgb(planes)[inside], wanted[inside], atol=1e-4)
                assert numpy.allclose(rgb(planes), wanted, atol=0.03), "edges"
                assert numpy.allclose(rgb(planes, "albedo."), wanted_albedo, atol=0.03)


def test_a_frame_can_be_recoloured_again_and_again():
    with Files() as files:
        image, albedo = picture(RED)
        write(files / "a.exr", image, albedo)
        files.recolor("a.exr", "-n", "ball", "-c", color(BLUE), output="b.exr")
        files.recolor("b.exr", "-n", "ball", "-c", "0.1,0.5,0.2", output="c.exr")
        files.recolor("a.exr", "-n", "ball", "-c", "0.1,0.5,0.2", output="d.exr")
        assert numpy.allclose(rgb(read(files / "c.exr")[0]), rgb(read(files / "d.exr")[0]),
                              atol=0.01)


def test_nothing_else_in_the_file_changes():
    with Files() as files:
        image, albedo = picture(RED)
        write(files / "a.exr", image, albedo, attributes={"shot": "010", "take": 7},
              more=["Z", "N.X"])
        files.recolor("a.exr", "-n", "ball", "-c", "#3060ff")
        (before, old), (after, new) = read(files / "a.exr"), read(files / "out.exr")
        assert sorted(before) == sorted(after)
        outside = coverage() == 0
        for name, plane in before.items():
            if name[-1] in "RGB" and "Crypto" not in name:
                assert (plane[outside] == after[name][outside]).all(), name
                assert not numpy.allclose(plane, after[name]), name
            else:
                assert (plane.view("uint32") == after[name].view("uint32")).all(), name
        assert new["shot"] == "010" and new["take"] == 7
        key = "cryptomatte/0abcdef/manifest"
        assert json.loads(new[key]) == json.loads(old[key])


def test_a_screen_colour_is_what_the_screen_shows():
    with Files() as files:
        image, albedo = picture(numpy.array([0.5, 0.5, 0.5]))
        write(files / "a.exr", image, albedo)
        for text, srgb in [("#ff8000", (255, 128, 0)), ("#0f8", (0, 255, 136))]:
            report = json.loads(files.recolor("a.exr", "-n", "ball", "-c", text, "--json").stdout)
            v = numpy.array(srgb) / 255
            linear = numpy.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
            assert numpy.allclose(report["color"], linear)


def test_a_png_is_the_picture_for_the_eye():
    with Files() as files:
        image, albedo = picture(RED)
        write(files / "a.exr", image, albedo)
        files.recolor("a.exr", "-n", "ball", "-c", "0.2,0.2,0.2", output="out.png")
        files.recolor("a.exr", "-n", "ball", "-c", "0.2,0.2,0.2", "--exposure", "2",
                      output="bright.png")
        dark, _ = read(files / "out.png")
        bright, _ = read(files / "bright.png")
        linear = 0.2 * (0.3 + 18 / WIDTH)
        for planes, gain in [(dark, 1), (bright, 4)]:
            v = 1.055 * (gain * linear) ** (1 / 2.4) - 0.055
            assert abs(planes["R"][14, 18] - v) < 1.01 / 255


def test_two_names_are_recoloured_each_from_its_own_colour():
    with Files() as files:
        image, albedo = picture(RED)
        write(files / "a.exr", image, albedo)
        run = files.recolor("a.exr", "-n", "ball", "-n", "floor", "-c", "0.3,0.3,0.3")
        assert run.stdout.startswith("ball: ") and "\nfloor: " in run.stdout
        planes, _ = read(files / "out.exr")
        wanted, _ = picture(numpy.array([0.3, 0.3, 0.3]))
        wanted[:] = 0.3 * (0.3 + numpy.mgrid[0:HEIGHT, 0:WIDTH][1] / WIDTH)[:, :, None]
        sure = (coverage() == 1) | (coverage() == 0)
        assert numpy.allclose(rgb(planes)[sure], wanted[sure], atol=1e-4)
        assert numpy.allclose(rgb(planes), wanted, atol=0.05)


def test_names_are_found_in_a_manifest_beside_the_file_or_by_their_hash():
    with Files() as files:
        image, albedo = picture(RED)
        write(files / "a.exr", image, albedo, manifest=False,
              attributes={"cryptomatte/0abcdef/manif_file": "names.json"})
        with open(files / "names.json", "w", encoding="utf-8") as file:
            json.dump({"kugel": f"{IDS['ball']:08x}"}, file)
        files.recolor("a.exr", "-n", "kugel", "-c", "#fff")
        run = files.recolor("a.exr", "-n", "ball", "-c", "#fff", expect=1)
        assert "'ball'" in run.stderr and "there are: kugel" in run.stderr
        os.remove(files / "names.json")
        assert "names.json" in files.recolor("a.exr", "-n", "kugel", "-c", "#fff", expect=1).stderr
        write(files / "b.exr", image, albedo, manifest=False)
        run = files.recolor("b.exr", "-n", "ball", "-c", "#fff", expect=1)
        assert "nothing of 'ball' is in the picture" in run.stderr  # it has another hash


def test_a_manifest_outside_of_the_files_folder_is_not_read():
    with Files() as files:
        image, _ = picture(RED)
        for name in ["../names.json", "/etc/passwd"]:
            write(files / "a.exr", image, manifest=False,
                  attributes={"cryptomatte/0abcdef/manif_file": name})
            run = files.recolor("a.exr", "-n", "ball", "-c", "#fff", expect=1)
            assert run.stderr and not os.path.exists(files / "out.exr")


def test_layers_are_found_by_what_their_names_end_with():
    with Files() as files:
        image, _ = picture(RED)
        write(files / "a.exr", image, layers=("ViewLayer.CryptoObject", "uCryptoAsset"))
        files.recolor("a.exr", "-n", "ball", "-c", "#fff")
        for layer in ["object", "asset", "uCryptoAsset", "ViewLayer.CryptoObject"]:
            files.recolor("a.exr", "-n", "ball", "-c", "#fff", "--layer", layer)
        run = files.recolor("a.exr", "-n", "ball", "-c", "#fff", "-l", "material", expect=1)
        assert "ViewLayer.CryptoObject, uCryptoAsset" in run.stderr
        write(files / "b.exr", image, layers=("crypto_wild",))
        files.recolor("b.exr", "-n", "ball", "-c", "#fff")  # the only one
        write(files / "c.exr", image, layers=("aObject", "bObject"))
        run = files.recolor("c.exr", "-n", "ball", "-c", "#fff", expect=1)
        assert "more than one" in run.stderr
        write(files / "d.exr", image, layers=())
        run = files.recolor("d.exr", "-n", "ball", "-c", "#fff", expect=1)
        assert "no Cryptomatte" in run.stderr


def test_what_cannot_be_recoloured_leaves_no_file():
    with Files() as files:
        image, _ = picture(RED)
        write(files / "a.exr", image)
        with open(files / "cut.exr", "wb") as file, open(files / "a.exr", "rb") as whole:
            file.write(whole.read()[:2000])
        for source, name, told in [("a.exr", "cup", "'cup'"), ("a.exr", "hidden", "'hidden'"),
                                   ("none.exr", "ball", "No such file"),
                                   ("cut.exr", "ball", "cut.exr")]:
            run = files.recolor(source, "-n", name, "-c", "#fff", expect=1)
            assert told in run.stderr, run.stderr
            assert not os.path.exists(files / "out.exr")


def test_hostile_files_are_refused_or_recoloured_but_harm_nothing():
    folder = tap.scenes("hostile", "exr-tinyexr")
    with Files() as files:
        for name in sorted(os.listdir(folder)):
            run = cli.glint("recolor", os.path.join(folder, name), "-n", "a", "-c", "#fff", "-o",
                            files / "out.exr")
            assert run.returncode == 1 and run.stderr.startswith("glint: "), (name, run)


def test_another_renderers_picture_is_recoloured():
    path = tap.scenes("cryptomatte", "cornellBox_CryptoWildcard.0001.exr")
    with Files() as files:
        run = cli.glint("recolor", path, "--image", "diffuse", "-n", "Rect_[]_right", "-c",
                        "#ff8000", "-o", files / "out.exr")
        assert run.returncode == 0, run.stderr
        (before, _), (after, spec) = read(path), read(files / "out.exr")
        changed = (rgb(before, "diffuse.") != rgb(after, "diffuse.")).any(2)
        assert 4e4 < changed.sum() < 6e4 and spec.x == 167
        inside = rgb(after, "diffuse.")[changed]
        assert (inside[:, 0] > inside[:, 1]).mean() > 0.98


if __name__ == "__main__":
    tap.main()
