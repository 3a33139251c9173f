"""mitsuba_render.py - renders a scene of scenes.py with Mitsuba 3 (PyPI) to an OpenEXR file.

    mitsuba_render.py SCENE.{json,glb} OUT.exr --size 256x256 --spp 1024 [--parts 16] [--seed 0]

Lambert is `diffuse`, metal `conductor` or `roughconductor` of reflectance 1 (only white metal is
the same in both), glass `dielectric` or `roughdielectric`; rough ones GGX with alpha = roughness
squared. Emission is one-sided in Mitsuba. Its masking is Smith's without correlation of heights, so
rough lobes are equal only while alpha is small.
"""
import argparse
import os
import tempfile

import mitsuba as mi
import numpy as np

import scenes


def write_ply(path, mesh):
    columns = [mesh["P"]] + ([mesh["N"]] if mesh["N"] is not None else [])
    names = ["x", "y", "z"] + (["nx", "ny", "nz"] if mesh["N"] is not None else [])
    rows = np.hstack(columns).astype("<f4")
    faces = np.zeros(len(mesh["I"]), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    faces["n"], faces["i"] = 3, mesh["I"]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}",
              *(f"property float {n}" for n in names), f"element face {len(faces)}",
              "property list uchar int vertex_index", "end_header", ""]
    with open(path, "wb") as f:
        f.write("\n".join(header).encode() + rows.tobytes() + faces.tobytes())


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def bsdf(material):
    kind, alpha = scenes.kind(material), material["roughness"] ** 2
    rough = {"distribution": "ggx", "alpha": alpha} if alpha >= 1e-3 else {}
    if kind == "glass":
        return {"type": "roughdielectric" if rough else "dielectric", "int_ior": material["ior"],
                "ext_ior": 1.0, **rough}
    if kind == "metal":
        inner = {"type": "roughconductor" if rough else "conductor", "material": "none",
                 "specular_reflectance": rgb(material["base_color"]), **rough}
    else:
        inner = {"type": "diffuse", "reflectance": rgb(material["base_color"])}
    return {"type": "twosided", "inner": inner}


def shape(folder, index, mesh):
    path = os.path.join(folder, f"{index}.ply")
    write_ply(path, mesh)
    out = {"type": "ply", "filename": path, "face_normals": mesh["N"] is None,
           "bsdf": bsdf(mesh["material"])}
    if max(mesh["material"]["emission"]) > 0:
        out["emitter"] = {"type": "area", "radiance": rgb(mesh["material"]["emission"])}
    return out


def sensor(camera, width, height):
    to_world = camera["transform"] @ np.diag([-1.0, 1.0, -1.0, 1.0])
    return {"type": "perspective", "fov_axis": "y", "fov": float(np.degrees(camera["yfov"])),
            "near_clip": 1e-3, "far_clip": 1e5, "to_world": mi.ScalarTransform4f(to_world),
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"}}


def load(path, width, height, bounces):
    scene = scenes.read(path)
    with tempfile.TemporaryDirectory() as folder:
        out = {"type": "scene", "sensor": sensor(scene["camera"], width, height),
               "integrator": {"type": "path", "max_depth": bounces + 1, "rr_depth": 5}}
        for k, mesh in enumerate(scene["meshes"]):
            out[f"shape{k}"] = shape(folder, k, mesh)
        if max(scene["environment"]) > 0:
            out["sky"] = {"type": "constant", "radiance": rgb(scene["environment"])}
        return mi.load_dict(out)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("scene")
    p.add_argument("out")
    p.add_argument("--size", default="256x256")
    p.add_argument("--spp", type=int, default=1024)
    p.add_argument("--parts", type=int, default=16, help="passes: bounds the memory")
    p.add_argument("--bounces", type=int, default=64)
    p.add_argument("--seed", type=int, default=0)
    p.add_argument("--variant", default="llvm_ad_rgb")
    a = p.parse_args()
    mi.set_variant(a.variant)
    width, height = (int(x) for x in a.size.split("x"))
    scene = load(a.scene, width, height, a.bounces)
    total = 0.0
    for k in range(a.parts):
        total = total + np.array(mi.render(scene, spp=a.spp // a.parts, seed=a.seed * 4096 + k),
                                 dtype=np.float64)
    mi.Bitmap((total / a.parts).astype(np.float32)).write(a.out)


if __name__ == "__main__":
    main()
