"""scenes.py - scenes that any renderer can be given alike: flat lists of meshes in world space.

A scene is {"meshes": [...], "camera": {"transform": 4x4 camera to world, "yfov": radians},
"environment": [r, g, b]}; a mesh is {"name", "P" [n][3], "N" [n][3] or None, "I" [m][3],
"material"}; a material has the members of the native scene form that MATERIAL lists.

    scenes.py NAME OUT.json                            a scene of ours, one of MADE, in the native form
    scenes.py pack IN.gltf OUT.glb                     a file with all that it refers to
    scenes.py plain IN.gl[tb] OUT.glb [--white-metal]  the same without dielectric coats
"""
import base64
import json
import math
import os
import struct
import sys
import urllib.parse

import numpy as np

MATERIAL = {"base_color": [1.0, 1.0, 1.0], "metallic": 0.0, "roughness": 1.0, "ior": 1.5,
            "transmission": 0.0, "double_sided": True, "emission": [0.0, 0.0, 0.0]}
METAL_ROUGHNESS = (0.0, 0.1, 0.3, 0.6, 1.0)
METAL_COLOUR = ((0.9, 0.9, 0.9), (1.0, 0.77, 0.34), (0.95, 0.64, 0.54), (0.3, 0.5, 0.9),
                (0.2, 0.7, 0.3))


# ------------------------------------------------------------------ scenes of our own ----

def quad(a, b, c, d):
    """Corners counter-clockwise as seen from the front."""
    return [a, b, c, d], None, [(0, 1, 2), (0, 2, 3)]


def box(size, at, turn):
    """Stands on y = at[1], without a floor, turned about y."""
    x, y, z = size[0] / 2, size[1], size[2] / 2
    corner = [(-x, 0, z), (x, 0, z), (x, 0, -z), (-x, 0, -z),
              (-x, y, z), (x, y, z), (x, y, -z), (-x, y, -z)]
    c, s = math.cos(turn), math.sin(turn)
    corner = [(c * p[0] + s * p[2] + at[0], p[1] + at[1], c * p[2] - s * p[0] + at[2])
              for p in corner]
    faces = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
    return corner, None, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def sphere(centre, radius, segments):
    rings = segments // 2
    normals = [(math.sin(t) * math.cos(p), math.cos(t), -math.sin(t) * math.sin(p))
               for t in (math.pi * i / rings for i in range(rings + 1))
               for p in (2 * math.pi * j / segments for j in range(segments))]
    points = [tuple(c + radius * x for c, x in zip(centre, n)) for n in normals]
    faces = []
    for i in range(rings):
        for j in range(segments):
            k = (j + 1) % segments
            a, b = i * segments + j, i * segments + k
            c, d = a + segments, b + segments
            faces += [(a, c, d)] if i == 0 else [(a, c, b)] if i == rings - 1 else [(a, c, d),
                                                                                    (a, d, b)]
    return points, normals, faces


def checker(side, tiles, odd):
    """Every other square of a floor at y = 0."""
    step, at = side / tiles, -side / 2
    points, faces = [], []
    for j in range(tiles):
        for i in range(tiles):
            if (i + j) % 2 == odd:
                x, z, n = at + i * step, at + j * step, len(points)
                points += [(x, 0, z), (x, 0, z + step), (x + step, 0, z + step), (x + step, 0, z)]
                faces += [(n, n + 1, n + 2), (n, n + 2, n + 3)]
    return points, None, faces


def look_at(eye, at):
    """Column-major camera to world."""
    eye, at = np.array(eye, float), np.array(at, float)
    z = (eye - at) / np.linalg.norm(eye - at)
    x = np.cross((0, 1, 0), z)
    x /= np.linalg.norm(x)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = x, np.cross(z, x), z, eye
    return m.T.reshape(-1).tolist()


def lambert(colour):
    return {"base_color": list(colour), "ior": 1}


def metal(colour, roughness):
    return {"base_color": list(colour), "metallic": 1, "roughness": roughness}


def glass(roughness):
    return {"transmission": 1, "roughness": roughness, "ior": 1.5}


def lamp(radiance):
    return {"base_color": [0, 0, 0], "ior": 1, "emission": list(radiance), "double_sided": False}


def native(parts, eye, at, yfov, environment=None):
    """The native form of {name: (material, (points, normals, faces))}."""
    scene = {"materials": {}, "meshes": {}, "instances": {},
             "cameras": {"camera": {"transform": look_at(eye, at), "yfov": yfov}}}
    if environment:
        scene["environment"] = {"radiance": environment}
    for name, (material, (points, normals, faces)) in parts.items():
        mesh = {"positions": [x for p in points for x in p],
                "indices": [int(i) for f in faces for i in f]}
        if normals:
            mesh["normals"] = [x for n in normals for x in n]
        scene["materials"][name] = material
        scene["meshes"][name] = mesh
        scene["instances"][name] = {"mesh": name, "material": name}
    return scene


def cornell():
    """Lambert and one lamp: light that has only been scattered diffusely."""
    white, red, green = lambert((.73, .73, .73)), lambert((.65, .05, .05)), lambert((.12, .45, .15))
    return native({
        "floor": (white, quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))),
        "ceiling": (white, quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1))),
        "back": (white, quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1))),
        "left": (red, quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1))),
        "right": (green, quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1))),
        "tall": (white, box((.6, 1.2, .6), (-.35, 0, -.3), .3)),
        "short": (white, box((.6, .6, .6), (.35, 0, .33), -.3)),
        "lamp": (lamp((15, 12, 8)), quad((-.25, 1.98, -.25), (.25, 1.98, -.25), (.25, 1.98, .25),
                                         (-.25, 1.98, .25))),
    }, (0, 1, 4.85), (0, 1, 0), math.radians(30))


def metals(colours=METAL_COLOUR, roughness=METAL_ROUGHNESS, rough_glass=.3, segments=256):
    """Five metals, a clear and a rough glass ball, a checker floor, two lamps and a grey sky."""
    parts = {"light tiles": (lambert((.8, .8, .8)), checker(10, 20, 0)),
             "dark tiles": (lambert((.1, .1, .12)), checker(10, 20, 1))}
    for k, (colour, r) in enumerate(zip(colours, roughness)):
        parts[f"metal {k}"] = (metal(colour, r),
                               sphere((k - 2, .45, -.35 * (k % 2) - .6), .45, segments))
    parts["glass"] = (glass(0), sphere((.45, .5, .75), .5, segments))
    parts["rough glass"] = (glass(rough_glass), sphere((-.75, .4, .65), .4, segments))
    parts["key"] = (lamp((12, 11, 10)), quad((-2.5, 3.5, 1), (-2.5, 3.5, -.5), (-1, 3.9, -.5),
                                             (-1, 3.9, 1)))
    parts["rim"] = (lamp((6, 7, 9)), quad((2.2, 1, -2.5), (3.2, 1, -1.5), (3.2, 2.5, -1.5),
                                          (2.2, 2.5, -2.5)))
    return native(parts, (.1, 2.1, 5.2), (0, .35, .1), math.radians(36), [.15, .17, .2])


# ------------------------------------------------------------------------- reading ----

def array(values, width):
    return None if values is None else np.array(values, np.float64).reshape(-1, width)


def read_native(path):
    with open(path) as f:
        doc = json.load(f)
    meshes = []
    for name, instance in doc["instances"].items():
        mesh = doc["meshes"][instance["mesh"]]
        meshes.append({"name": name, "P": array(mesh["positions"], 3),
                       "N": array(mesh.get("normals"), 3), "I": array(mesh["indices"], 3).astype(np.int64),
                       "material": {**MATERIAL, **doc["materials"][instance["material"]]}})
    camera = next(iter(doc["cameras"].values()))
    return {"meshes": meshes, "environment": doc.get("environment", {}).get("radiance", [0, 0, 0]),
            "camera": {"transform": np.array(camera["transform"]).reshape(4, 4).T,
                       "yfov": camera["yfov"]}}


def fetch(uri, folder):
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    with open(os.path.join(folder, urllib.parse.unquote(uri)), "rb") as f:
        return f.read()


def embed(doc, folder):
    """Moves buffers and images of a .gltf into one buffer, which it returns."""
    data, start = b"", []
    for buffer in doc["buffers"]:
        start.append(len(data))
        data += fetch(buffer["uri"], folder)
        data += b"\0" * (-len(data) % 4)
    for view in doc["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + start[view["buffer"]]
        view["buffer"] = 0
    for image in doc.get("images", []):
        uri = image.pop("uri")
        picture = fetch(uri, folder)
        doc["bufferViews"].append({"buffer": 0, "byteOffset": len(data),
                                   "byteLength": len(picture)})
        image["bufferView"] = len(doc["bufferViews"]) - 1
        image["mimeType"] = "image/png" if uri.endswith(".png") else "image/jpeg"
        data += picture + b"\0" * (-len(picture) % 4)
    doc["buffers"] = [{"byteLength": len(data)}]
    return data


def open_gltf(path):
    """The document of a .glb or .gltf and its only buffer."""
    with open(path, "rb") as f:
        data = f.read()
    if not path.endswith(".glb"):
        doc = json.loads(data)
        return doc, embed(doc, os.path.dirname(path))
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[28 + length:]


def write_glb(path, doc, data):
    text = json.dumps(doc).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as f:
        f.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
        for kind, chunk in (b"JSON", text), (b"BIN\0", data):
            f.write(struct.pack("<I4s", len(chunk), kind) + chunk)


def accessor(doc, data, index):
    a = doc["accessors"][index]
    view = doc["bufferViews"][a["bufferView"]]
    kind = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[a["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
    at = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    step = view.get("byteStride", np.dtype(kind).itemsize * width)
    rows = np.ndarray((a["count"], width), kind, data, at, (step, np.dtype(kind).itemsize))
    return rows.astype(np.float64)


def gltf_material(m):
    pbr, extension = m.get("pbrMetallicRoughness", {}), m.get("extensions", {})
    strength = extension.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
    return {"base_color": pbr.get("baseColorFactor", [1, 1, 1, 1])[:3],
            "metallic": pbr.get("metallicFactor", 1), "roughness": pbr.get("roughnessFactor", 1),
            "ior": extension.get("KHR_materials_ior", {}).get("ior", 1.5),
            "transmission": extension.get("KHR_materials_transmission", {})
                                     .get("transmissionFactor", 0),
            "double_sided": m.get("doubleSided", False),
            "emission": [strength * e for e in m.get("emissiveFactor", [0, 0, 0])]}


def node_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    if "rotation" in node:
        raise ValueError("nodes with a rotation are not read")
    m = np.diag([*node.get("scale", [1.0, 1.0, 1.0]), 1.0])
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m


def read_glb(path):
    doc, data = open_gltf(path)
    scene = {"meshes": [], "environment": [0, 0, 0]}
    materials = [gltf_material(m) for m in doc["materials"]]

    def visit(index, above):
        node = doc["nodes"][index]
        m = above @ node_matrix(node)
        if "camera" in node:
            scene["camera"] = {"transform": m,
                               "yfov": doc["cameras"][node["camera"]]["perspective"]["yfov"]}
        turn = np.linalg.inv(m[:3, :3]).T
        for k, p in enumerate(doc["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []):
            get = lambda key: (accessor(doc, data, p["attributes"][key])
                               if key in p["attributes"] else None)
            n = get("NORMAL")
            if n is not None:
                n = n @ turn.T
                n /= np.linalg.norm(n, axis=1, keepdims=True)
            faces = accessor(doc, data, p["indices"]).astype(np.int64).reshape(-1, 3)
            faces = faces if np.linalg.det(m[:3, :3]) > 0 else faces[:, ::-1]
            scene["meshes"].append({"name": f"{index}.{k} {node.get('name', '')}", "I": faces,
                                    "P": get("POSITION") @ m[:3, :3].T + m[:3, 3], "N": n,
                                    "material": materials[p["material"]]})
        for child in node.get("children", []):
            visit(child, m)

    for root in doc["scenes"][doc.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    return scene


def read(path):
    return read_glb(path) if path.endswith(".glb") else read_native(path)


def kind(material):
    """lambert, metal or glass; anything between them has no equal in other renderers."""
    if material["metallic"] == 1:
        return "metal"
    if material["transmission"] == 1:
        return "glass"
    if material["metallic"] == 0 and material["transmission"] == 0 and material["ior"] == 1:
        return "lambert"
    raise ValueError(f"no other renderer has this material: {material}")


def plain(source, target, white_metal):
    """Removes what other renderers do differently: the coat of diffuse materials, emission of back
    sides, attenuation and, if asked, the colour of metals."""
    doc, data = open_gltf(source)
    for m in doc["materials"]:
        volume = m.get("extensions", {}).get("KHR_materials_volume", {})
        volume.pop("attenuationDistance", None) # its absence is infinity; the walls stay solid
        pbr = m.setdefault("pbrMetallicRoughness", {})
        transmits = "KHR_materials_transmission" in m.get("extensions", {})
        if pbr.get("metallicFactor", 1) == 0 and not transmits:
            m.setdefault("extensions", {})["KHR_materials_ior"] = {"ior": 1}
            pbr["roughnessFactor"] = 1
        if white_metal and pbr.get("metallicFactor", 1) == 1:
            pbr["baseColorFactor"] = [1, 1, 1, 1]
        if max(m.get("emissiveFactor", [0])) > 0:
            m["doubleSided"] = False
    doc["extensionsUsed"] = sorted({*doc.get("extensionsUsed", []), "KHR_materials_ior"})
    write_glb(target, doc, data)


WHITE = ((1.0, 1.0, 1.0),) * 5
NARROW = (0.0, 0.05, 0.1, 0.15, 0.2) # roughness below which no renderer's masking is seen
MADE = {"cornell": cornell, "metals": metals, "metals-white": lambda: metals(WHITE),
        "balls": lambda: metals(segments=96),
        "balls-white": lambda: metals(WHITE, NARROW, .15, 96)}


def main():
    if len(sys.argv) >= 4 and sys.argv[1] == "plain":
        plain(sys.argv[2], sys.argv[3], "--white-metal" in sys.argv)
    elif len(sys.argv) == 4 and sys.argv[1] == "pack":
        write_glb(sys.argv[3], *open_gltf(sys.argv[2]))
    elif len(sys.argv) == 3 and sys.argv[1] in MADE:
        with open(sys.argv[2], "w") as f:
            json.dump(MADE[sys.argv[1]](), f)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
