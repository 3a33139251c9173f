"""neutral.py - a scene folder as every renderer of the bench reads it: world space, nothing shared.

`glint export` wrote it and worlds.py settled it; glint itself renders the same folder. read() gives
{"meshes", "materials", "lights", "camera", "environment"}: meshes with P [n][3], N [n][3] or None,
UV [n][2] or None, I [m][3] and the name of their material; materials with the members of the native
form, base_color_file (sRGB), base_color_linear and opacity_file where there are such pictures; lights
that are suns.
"""
import json
import os

import numpy as np


def matrix(values):
    """4x4 of 16 numbers, columns first."""
    return np.array(values, float).reshape(4, 4).T


def arrays(folder, mesh):
    """Position, normal, uv and indices out of the mesh's asset, laid out one after the other."""
    data = np.fromfile(os.path.join(folder, mesh["asset"]), np.uint8)
    n, at = mesh["vertices"], 0
    width = {"position": 3, "normal": 3, "uv": 2, "tangent": 4, "uv1": 2, "color": 4}
    out = {}
    for name in ["position", *mesh["attributes"]]:
        size = 4 * width[name] * n
        out[name] = data[at:at + size].view("<f4").reshape(n, width[name]).astype(np.float64)
        at += size
    out["index"] = data[at:at + 12 * mesh["triangles"]].view("<u4").reshape(-1, 3).astype(np.int64)
    return out


def placed(name, instance, a):
    m = matrix(instance["transform"])
    faces = a["index"] if np.linalg.det(m[:3, :3]) > 0 else a["index"][:, ::-1]
    normal = a.get("normal")
    if normal is not None:
        normal = normal @ np.linalg.inv(m[:3, :3])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-20)
    return {"name": name, "material": instance["material"], "N": normal, "UV": a.get("uv"),
            "P": a["position"] @ m[:3, :3].T + m[:3, 3], "I": faces}


def files(folder, material):
    out = dict(material)
    texture = material.get("base_color_texture")
    if texture:
        path = os.path.join(folder, f"picture-{list_name(texture['image'])}")
        out["base_color_file"] = path + ".png"
        out["base_color_linear"] = path + ".exr"
        if material["alpha_mode"] == "mask":
            out["opacity_file"] = path + "-opacity.png"
    return out


def list_name(image):
    """The id of an image as a part of a file name."""
    return "".join(c if c.isalnum() else "_" for c in image)


def environment(folder, doc):
    """None, or {"radiance", "file"}; the file, of rows of RGB floats, has no name if
    the sky is one colour."""
    e = doc.get("environment")
    if not e:
        return None
    assert not e.get("rotation"), "a sky that is turned is not read"
    return {"radiance": e["radiance"],
            "file": os.path.join(folder, "sky.exr") if "image" in e else None}


def read(folder):
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as f:
        doc = json.load(f)
    assert "nodes" not in doc, "what moves is not read"
    cached, meshes = {}, []
    for name, instance in doc["instances"].items():
        if instance["mesh"] not in cached:
            cached[instance["mesh"]] = arrays(folder, doc["meshes"][instance["mesh"]])
        meshes.append(placed(name, instance, cached[instance["mesh"]]))
    camera = next(iter(doc["cameras"].values()))
    return {"meshes": meshes,
            "materials": {k: files(folder, m) for k, m in doc["materials"].items()},
            "lights": [{**light, "transform": matrix(light["transform"])}
                       for light in doc.get("lights", {}).values()],
            "camera": {"transform": matrix(camera["transform"]), "yfov": camera["yfov"]},
            "environment": environment(folder, doc)}


def emits(material):
    return max(material["emission"]) > 0


def kind(material):
    """lambert, metal, glass, or coated: a dielectric layer over a diffuse base; between metal and
    dielectric it is mixed."""
    if material["transmission"] == 1 and material["metallic"] == 0:
        return "glass"
    if material["metallic"] == 1:
        return "metal"
    if material["metallic"] == 0 and material["transmission"] == 0:
        return "lambert" if material["ior"] == 1 else "coated"
    return "mixed"
