"""every_effect.py - a small scene and a job that call for as many rows of the effects table as can
stand together: what a cold kernel cache costs at worst."""
import base64
import struct
import zlib


def png(width, height):
    """A picture of different colours, as a data URI."""
    rows = b"".join(b"\0" + bytes((x * 29 + y * 53 + c * 71) % 200 + 40
                                  for x in range(width) for c in range(4)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(
            ">I", zlib.crc32(kind + data))

    data = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 6, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    return "data:image/png;base64," + base64.b64encode(data).decode()


def texture(**more):
    return {"image": "i", **more}


def place(x, y, z, scale=1.0):
    return {"translation": [x, y, z], "scale": [scale] * 3}


MATERIALS = {
    "wall": {"base_color": [0.7, 0.7, 0.7], "roughness": 0.7, "double_sided": False,
             "base_color_texture": texture(offset=[0.1, 0.2], rotation=0.3, scale=[2, 2]),
             "normal_map": texture(uv_set=1)},
    "coat": {"base_color": [0.5, 0.2, 0.2], "roughness": 0.4, "clearcoat": 1, "specular": 0.5,
             "clearcoat_texture": texture(), "base_color_texture": texture(filter="nearest")},
    "metal": {"base_color": [0.9, 0.8, 0.6], "metallic": 1, "roughness": 0.3},
    "water": {"transmission": 1, "roughness": 0.1, "ior": 1.33, "collimation": 0.5, "priority": 1,
              "attenuation_color": [0.8, 0.9, 1], "attenuation_distance": 1},
    "glass": {"transmission": 1, "roughness": 0, "ior": 1.5, "priority": 2},
    "veil": {"base_color": [1, 1, 1], "opacity": 0.5, "alpha_mode": "blend"},
    "leaf": {"base_color": [0.2, 0.6, 0.2], "alpha_mode": "mask", "base_color_texture": texture()},
    "lamp": {"base_color": [0, 0, 0], "ior": 1, "emission": [8, 8, 7]},
}

SHEET = {"positions": [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], "indices": [0, 1, 2, 0, 2, 3],
         "uvs": [0, 1, 1, 1, 1, 0, 0, 0], "uvs1": [0, 2, 2, 2, 2, 0, 0, 0],
         "colors": [1, 0.5, 0.5, 1, 0.5, 1, 0.5, 1, 0.5, 0.5, 1, 1, 1, 1, 1, 1]}

SCENE = {
    "fps": 24,
    "images": {"i": {"data": png(16, 8)}},
    "materials": MATERIALS,
    "meshes": {"sheet": SHEET, "ball": {"primitive": "sphere", "segments": 24}},
    "nodes": {"swing": {"transform": place(0, 0, 0)}},
    "instances": {
        "wall": {"mesh": "sheet", "material": "wall", "transform": place(0, 0, -3, 4)},
        "coat": {"mesh": "ball", "material": "coat", "transform": place(-1.5, 0, -1, 0.6)},
        "metal": {"mesh": "ball", "material": "metal", "node": "swing",
                  "transform": place(1.5, 0, -1, 0.6)},
        "water": {"mesh": "ball", "material": "water", "transform": place(0, 0, 0, 0.8)},
        "glass": {"mesh": "ball", "material": "glass", "transform": place(0.5, 0, 0, 0.5)},
        "veil": {"mesh": "sheet", "material": "veil", "transform": place(0, 1, 1, 0.5)},
        "leaf": {"mesh": "sheet", "material": "leaf", "transform": place(0, -1, 1, 0.5)},
        **{f"lamp{i}": {"mesh": "sheet", "material": "lamp",
                        "transform": place(i % 3 * 2 - 2, i // 3 * 0.6 - 2, 3, 0.1)}
           for i in range(12)},
    },
    "animations": {"move": {"channels": {"swing": {
        "node": "swing", "path": "translation", "times": [0, 1], "values": [0, 0, 0, 0, 3, 0]}}}},
    "lights": {"bulb": {"type": "point", "intensity": 5, "transform": place(0, 2, 2)}},
    "media": {"fog": {"density": 0.05}},
    "environment": {"image": "i"},
    "cameras": {"eye": {"yfov": 0.9, "lens_radius": 0.02, "focus_distance": 4,
                        "transform": place(0, 0, 4)}},
}

JOB = {"outputs": ["beauty", "crypto_object", "depth", "normal", "albedo", "motion", "samples",
                   "variance"], "shutter": [0, 0.5]}
