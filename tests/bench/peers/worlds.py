"""worlds.py - the scenes of the bench `peers`, each as a folder that all renderers read.

settle() takes out what they do differently, for glint as for everybody: a dielectric layer rougher
than half (what is under it becomes lambert), normal maps, maps of roughness and metal (their mean
stays), absorption (glass keeps its tint by its colour), and backs that the camera does not see.
Opacity becomes a picture of 0 and 1 that is not filtered.
"""
import hashlib
import json
import math
import os
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "render", "peers"))
import neutral
import scenes

ROUGH_COAT = 0.5
DROPPED_MAPS = ("normal_map", "metallic_roughness_texture", "specular_texture",
                "specular_color_texture", "emission_texture")
SKY = 512, 256 # pixels


# ------------------------------------------------------------------ scenes of our own ----

def lamps(count=2000):
    """Many small lamps of eight colours over a floor with things on it, above what the camera sees:
    pixels show what is lit, not the edges of what lights."""
    random = np.random.default_rng(9)
    parts = {"floor": (scenes.lambert((.6, .6, .6)),
                       scenes.quad((-8, 0, 8), (8, 0, 8), (8, 0, -8), (-8, 0, -8))),
             "wall": (scenes.lambert((.7, .7, .65)),
                      scenes.quad((-8, 0, -8), (8, 0, -8), (8, 6, -8), (-8, 6, -8)))}
    for k in range(12):
        at = (-5.5 + 3.6 * (k % 4), 0.8, -5 + 3.2 * (k // 4))
        made = scenes.metal((.9, .8, .6), .3) if k % 3 == 0 else scenes.lambert((.3 + .05 * k, .5, .4))
        parts[f"ball {k}"] = (made, scenes.sphere(at, .8, 64))
    for k, group in enumerate(np.array_split(np.arange(count), 8)):
        points, faces = [], []
        for _ in group:
            x, y, z = random.uniform((-7.5, 4.2, -7.5), (7.5, 5.5, 5))
            s, n = random.uniform(.01, .04), len(points)
            points += [(x - s, y, z - s), (x + s, y, z - s), (x + s, y, z + s), (x - s, y, z + s)]
            faces += [(n, n + 1, n + 2), (n, n + 2, n + 3)]
        colour = (40 + 25 * math.sin(k), 40 + 25 * math.sin(k + 2), 40 + 25 * math.sin(k + 4))
        parts[f"lamps {k}"] = (scenes.lamp(colour), (points, None, faces))
    return scenes.native(parts, (0, 4, 8), (0, .5, -2), math.radians(36))


def garden():
    """The metals and glasses without lamps, under sky() alone."""
    scene = scenes.MADE["balls"]()
    for name in "key", "rim":
        for members in "materials", "meshes", "instances":
            del scene[members][name]
    return scene


def sky():
    """A blue gradient over brown ground, and a bright haze of eight degrees; float32 [height][width][3]."""
    width, height = SKY
    u, v = np.meshgrid((np.arange(width) + .5) / width, (np.arange(height) + .5) / height)
    up = np.cos(np.pi * v)[..., None]
    out = np.where(up > 0, .25 + up * np.array([.15, .35, .9]) + (1 - up) * np.array([.5, .45, .4]),
                   np.array([.18, .14, .1]) * np.ones_like(up))
    theta, phi = np.pi * v, 2 * np.pi * (u - .62)
    cosine = np.cos(theta) * math.cos(.8) + np.sin(theta) * math.sin(.8) * np.cos(phi)
    out[cosine > math.cos(math.radians(8))] = (60, 52, 40)
    return out.astype(np.float32)


# -------------------------------------------------------------------------- settling ----

def add_asset(folder, data):
    name = hashlib.sha256(data).hexdigest()
    with open(os.path.join(folder, name), "wb") as f:
        f.write(data)
    return name


def write_picture(path, pixels, kind):
    height, width, channels = pixels.shape
    out = oiio.ImageOutput.create(path)
    out.open(path, oiio.ImageSpec(width, height, channels, kind))
    out.write_image(pixels)
    out.close()


def pixels_of(folder, image):
    data = np.fromfile(os.path.join(folder, image["asset"]), np.uint8)
    return data.reshape(image["height"], image["width"], 4)


def mean_of_map(folder, doc, m):
    """Roughness and metallic become those of the map's mean."""
    texture = m.get("metallic_roughness_texture")
    if texture:
        mean = pixels_of(folder, doc["images"][texture["image"]]).reshape(-1, 4).mean(0) / 255
        m["roughness"] *= mean[1]
        m["metallic"] *= mean[2]


def binary_opacity(folder, doc, m):
    texture = m["base_color_texture"]
    image = doc["images"][texture["image"]]
    pixels = pixels_of(folder, image).copy()
    pixels[..., 3] = np.where(pixels[..., 3] < 255 * m["alpha_cutoff"], 0, 255)
    image["asset"] = add_asset(folder, pixels.tobytes())
    texture["filter"], m["alpha_cutoff"] = "nearest", .5


def settle_material(folder, doc, m):
    mean_of_map(folder, doc, m)
    for name in DROPPED_MAPS:
        m.pop(name, None)
    m["double_sided"] = not neutral.emits(m)
    if m["transmission"] == 1 and m["attenuation_distance"] > 0:
        m["base_color"] = [math.sqrt(c) for c in m["attenuation_color"]]
    m["attenuation_distance"] = 0
    if m["metallic"] == 0 and m["transmission"] == 0 and m["roughness"] >= ROUGH_COAT:
        m["ior"], m["roughness"] = 1, 1
    if neutral.emits(m):
        m.update(base_color=[0, 0, 0], metallic=0, ior=1)
        m.pop("base_color_texture", None)
    if m["alpha_mode"] == "mask" and "base_color_texture" in m:
        binary_opacity(folder, doc, m)
    else:
        m["alpha_mode"], m["opacity"] = "opaque", 1


def linear(pixels):
    """Of sRGB bytes, for renderers that know powers only."""
    s = pixels.astype(np.float32) / 255
    return np.where(s <= .04045, s / 12.92, ((s + .055) / 1.055) ** 2.4).astype(np.float32)


def write_pictures(folder, doc):
    used = {m["base_color_texture"]["image"]: m for m in doc["materials"].values()
            if "base_color_texture" in m}
    for name, m in used.items():
        texture = m["base_color_texture"]
        assert (texture["offset"], texture["scale"], texture["rotation"], texture["uv_set"]) == \
            ([0, 0], [1, 1], 0, 0), "coordinates that are transformed are not read"
        pixels = pixels_of(folder, doc["images"][name])
        path = os.path.join(folder, f"picture-{neutral.list_name(name)}")
        write_picture(path + ".png", np.ascontiguousarray(pixels[..., :3]), "uint8")
        write_picture(path + ".exr", linear(pixels[..., :3]), "half")
        if m["alpha_mode"] == "mask":
            write_picture(path + "-opacity.png", np.ascontiguousarray(pixels[..., 3:]), "uint8")
    doc["images"] = {name: doc["images"][name] for name in used}


def write_sky(folder, doc):
    rgb = sky()
    half = np.ones((*rgb.shape[:2], 4), np.float16)
    half[..., :3] = rgb
    doc.setdefault("images", {})["sky"] = {"asset": add_asset(folder, half.tobytes()),
                                           "width": SKY[0], "height": SKY[1], "format": "rgba16f"}
    doc["environment"] = {"radiance": [1, 1, 1], "image": "sky"}
    write_picture(os.path.join(folder, "sky.exr"), half[..., :3].astype(np.float32), "float")


def settle(folder, under_sky):
    path = os.path.join(folder, "scene.json")
    with open(path, encoding="utf-8") as f:
        doc = json.load(f)
    for m in doc["materials"].values():
        settle_material(folder, doc, m)
    write_pictures(folder, doc)
    if under_sky:
        write_sky(folder, doc)
    with open(path, "w", encoding="utf-8") as f:
        json.dump(doc, f)


# ---------------------------------------------------------------------------- making ----

MADE = {"cornell": scenes.MADE["cornell"], "glossy": scenes.MADE["balls"], "garden": garden,
        "lamps": lamps}
FILES = {"bathroom": "interiors/bathroom.glb", "staircase2": "interiors/staircase2.glb",
         "sponza": "interiors/crytek-sponza.glb", "chess": "chess/chess_set_glass.gltf"}
NAMES = ["cornell", "glossy", "million", *FILES, "garden", "lamps"]


def source(name, folder, build):
    """The path of what glint imports, or None where a file of $GLINT_SCENES is not there."""
    native = os.path.join(folder, "source.json")
    if name in MADE:
        with open(native, "w", encoding="utf-8") as f:
            json.dump(MADE[name](), f)
        return native
    if name == "million":
        with open(native, "w", encoding="utf-8") as f:
            subprocess.run([os.path.join(build, "tests/bench/million_scene")], stdout=f, check=True)
        return native
    path = os.path.join(os.environ.get("GLINT_SCENES", ""), FILES[name])
    if not os.path.exists(path):
        return None
    if path.endswith(".gltf"):
        packed = os.path.join(folder, "source.glb")
        scenes.write_glb(packed, *scenes.open_gltf(path))
        return packed
    return path


def make(name, folder, build):
    """Fills the folder; False where the scene cannot be had."""
    os.makedirs(folder, exist_ok=True)
    path = source(name, folder, build)
    if not path:
        return False
    subprocess.run([os.path.join(build, "tests/bench/peers/glint"), "export", path, folder],
                   check=True)
    settle(folder, name == "garden")
    return True


def fingerprint(folder):
    """Of all that a renderer can read there."""
    with open(os.path.join(folder, "scene.json"), "rb") as f:
        return hashlib.sha256(f.read()).hexdigest()[:16]
