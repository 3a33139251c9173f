"""mitsuba_serve.py - Mitsuba 3 (PyPI) for the bench `peers`.

    mitsuba_serve.py FOLDER WIDTH HEIGHT BOUNCES VARIANT

Lambert is `diffuse`, clear glass `dielectric` or `roughdielectric`, coated `roughplastic`;
rough metal, and what is between metal and dielectric, `principled`.
Emission is one-sided in Mitsuba. Left as it has it: light sampling, its independent sampler, its
roulette from the fifth vertex on. Passes bound the memory of the wavefront variants.
"""
import glob
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

# Dr.Jit's code wants LLVM 16 or later; Debian's default is older.
for library in sorted(glob.glob("/usr/lib/*/libLLVM*.so.1[6-9]*")):
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", library)

import mitsuba as mi
import numpy as np

import neutral
import serve

LANES = 1 << 22 # samples of a pass


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def colour(m):
    if "base_color_file" not in m:
        return rgb(m["base_color"])
    return {"type": "bitmap", "filename": m["base_color_file"],
            "filter_type": "nearest" if m["base_color_texture"]["filter"] == "nearest" else "bilinear"}


def closure(m):
    kind, alpha = neutral.kind(m), m["roughness"] ** 2
    if kind == "glass":
        rough = {"distribution": "ggx", "alpha": alpha} if alpha >= 1e-3 else {}
        return {"type": "roughdielectric" if rough else "dielectric", "int_ior": m["ior"],
                "ext_ior": 1.0, "specular_transmittance": rgb(m["base_color"]), **rough}
    if kind == "lambert":
        inner = {"type": "diffuse", "reflectance": colour(m)}
    elif kind == "metal" and alpha < 1e-3:
        inner = {"type": "conductor", "material": "none", "specular_reflectance": colour(m)}
    elif kind == "coated":
        inner = {"type": "roughplastic", "distribution": "ggx", "alpha": max(alpha, 1e-3),
                 "int_ior": m["ior"], "ext_ior": 1.0, "diffuse_reflectance": colour(m)}
    else:
        inner = {"type": "principled", "base_color": colour(m), "metallic": m["metallic"],
                 "roughness": m["roughness"]}
        if kind != "metal":
            inner["eta"] = m["ior"]
    return {"type": "twosided", "inner": inner}


def bsdf(m):
    inner = closure(m)
    if "opacity_file" not in m:
        return inner
    return {"type": "mask", "inner": inner,
            "opacity": {"type": "bitmap", "filename": m["opacity_file"], "raw": True,
                        "filter_type": "nearest"}}


def shape(m, materials):
    made = mi.Mesh(m["name"], len(m["P"]), len(m["I"]), has_vertex_normals=m["N"] is not None,
                   has_vertex_texcoords=m["UV"] is not None, props=properties(materials[m["material"]],
                                                                             m["N"] is None))
    fill = mi.traverse(made)
    fill["vertex_positions"] = m["P"].astype(np.float32).ravel()
    fill["faces"] = m["I"].astype(np.uint32).ravel()
    if m["N"] is not None:
        fill["vertex_normals"] = m["N"].astype(np.float32).ravel()
    if m["UV"] is not None:
        fill["vertex_texcoords"] = m["UV"].astype(np.float32).ravel()
    fill.update()
    return made


def properties(material, flat):
    out = mi.Properties()
    out["mesh_bsdf"] = mi.load_dict(bsdf(material))
    out["face_normals"] = flat
    if neutral.emits(material):
        out["mesh_emitter"] = mi.load_dict({"type": "area", "radiance": rgb(material["emission"])})
    return out


def sky(e):
    if not e["file"]:
        return {"type": "constant", "radiance": rgb(e["radiance"])}
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180) # its middle is +z
    return {"type": "envmap", "filename": e["file"], "to_world": turn}


def sun(light):
    radiance = np.array(light["color"]) * light["intensity"]
    return {"type": "directional", "direction": [float(-x) for x in light["transform"][:3, 2]],
            "irradiance": rgb(radiance)}


def sensor(camera, width, height):
    to_world = camera["transform"] @ np.diag([-1.0, 1.0, -1.0, 1.0])
    return {"type": "perspective", "fov_axis": "y", "fov": float(np.degrees(camera["yfov"])),
            "near_clip": 1e-3, "far_clip": 1e5, "to_world": mi.ScalarTransform4f(to_world),
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"}}


def load(folder, width, height, bounces):
    scene = neutral.read(folder)
    out = {"type": "scene", "sensor": sensor(scene["camera"], width, height),
           "integrator": {"type": "path", "max_depth": bounces + 2}}
    for k, mesh in enumerate(scene["meshes"]):
        out[f"shape{k}"] = shape(mesh, scene["materials"])
    for k, light in enumerate(scene["lights"]):
        out[f"sun{k}"] = sun(light)
    if scene["environment"]:
        out["sky"] = sky(scene["environment"])
    return mi.load_dict(out)


def passes(samples, pixels):
    """Powers of two that make `samples`."""
    most = max(LANES // pixels, 1)
    while samples:
        n = min(1 << (samples.bit_length() - 1), 1 << (most.bit_length() - 1))
        yield n
        samples -= n


def main():
    folder, width, height, bounces, (variant,) = serve.arguments(sys.argv[1:])
    mi.set_variant(variant)
    scene = load(folder, width, height, bounces)

    def render(samples, seed, out):
        total, number = np.zeros((height, width, 3)), 0
        for number, n in enumerate(passes(samples, width * height)):
            picture = mi.render(scene, spp=n, seed=seed * 1024 + number)
            total += n * np.array(picture, dtype=np.float64)
        (total / samples).astype("<f4").tofile(out)

    serve.loop(f"Mitsuba {mi.__version__} {variant}", render)


main()
