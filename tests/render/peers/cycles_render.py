"""cycles_render.py - renders a scene of scenes.py with Blender's Cycles to an OpenEXR file.

    blender -b --factory-startup -P cycles_render.py -- SCENE.{json,glb} OUT.exr [options]   Debian
    python cycles_render.py SCENE.{json,glb} OUT.exr [options]                    bpy from PyPI
    options: --size 256x256 --spp 1024 --bounces 64 --seed 0 --import

Lambert is a Diffuse BSDF, glass a Glass BSDF. Metal is a Principled BSDF where Blender has F82
Fresnel (4.1 and later; white edge tint: that is Schlick's), a Glossy BSDF of constant colour before,
equal for white metal only. From 4.0 on Cycles' GGX masking correlates heights as ours does; in 3.4
it does not. --import leaves the reading of a glTF file to Blender's importer, which knows textures
and makes a Principled BSDF of every material: not glTF's coupling of coat and base.
"""
import argparse
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import scenes

TURN = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float) # glTF's y up to Blender's z up


def node(tree, kind, **inputs):
    out = tree.nodes.new(kind)
    for name, value in inputs.items():
        out.inputs[name.replace("_", " ")].default_value = value
    return out


def closure(tree, m):
    colour, kind = (*m["base_color"], 1), scenes.kind(m)
    if kind == "metal" and bpy.app.version >= (4, 1):
        out = node(tree, "ShaderNodeBsdfPrincipled", Metallic=1, Roughness=m["roughness"],
                   Base_Color=colour)
        out.distribution = "GGX"
    elif kind == "metal":
        out = node(tree, "ShaderNodeBsdfGlossy", Color=colour, Roughness=m["roughness"])
        out.distribution = "GGX"
    elif kind == "glass":
        out = node(tree, "ShaderNodeBsdfGlass", Color=colour, Roughness=m["roughness"], IOR=m["ior"])
        out.distribution = "GGX"
    else:
        out = node(tree, "ShaderNodeBsdfDiffuse", Color=colour)
    return out.outputs[0]


def one_sided(tree, emission):
    """Nothing where the ray meets the back."""
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs[0])
    tree.links.new(emission, mix.inputs[1])
    return mix.outputs[0]


def material(m):
    out = bpy.data.materials.new("m")
    out.use_nodes = True
    tree = out.node_tree
    tree.nodes.clear()
    shader = closure(tree, m)
    if max(m["emission"]) > 0:
        light = node(tree, "ShaderNodeEmission", Color=(*m["emission"], 1), Strength=1).outputs[0]
        light = light if m["double_sided"] else one_sided(tree, light)
        add = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(shader, add.inputs[0])
        tree.links.new(light, add.inputs[1])
        shader = add.outputs[0]
    tree.links.new(shader, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return out


def mesh(m):
    data = bpy.data.meshes.new(m["name"])
    data.from_pydata((m["P"] @ TURN.T).tolist(), [], m["I"].tolist())
    data.materials.append(material(m["material"]))
    if m["N"] is not None:
        data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
        if bpy.app.version < (4, 1):
            data.use_auto_smooth = True
        data.normals_split_custom_set_from_vertices((m["N"] @ TURN.T).tolist())
    data.update()
    thing = bpy.data.objects.new(m["name"], data)
    for name in ("shadow_terminator_geometry_offset", "shadow_terminator_shading_offset"):
        setattr(thing.cycles, name, 0)
    bpy.context.scene.collection.objects.link(thing)


def camera(c):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle_y = "VERTICAL", c["yfov"]
    data.clip_start, data.clip_end = 1e-3, 1e5
    thing = bpy.data.objects.new("camera", data)
    m = np.eye(4)
    m[:3] = TURN @ c["transform"][:3]
    thing.matrix_world = Matrix(m.tolist())
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


def world(radiance):
    w = bpy.data.worlds.new("world")
    w.use_nodes = True
    background = next(n for n in w.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs[0].default_value, background.inputs[1].default_value = (*radiance, 1), 1
    bpy.context.scene.world = w


def import_gltf(path):
    np.bool = bool # the importer of 3.4 uses this alias, which newer numpy lacks
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path))
    for m in bpy.data.materials:
        for n in m.node_tree.nodes if m.use_nodes else ():
            if n.type == "BSDF_PRINCIPLED":
                n.distribution = "GGX"
    bpy.context.scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    world((0, 0, 0))


def rebuild(path):
    scene = scenes.read(path)
    for m in scene["meshes"]:
        mesh(m)
    camera(scene["camera"])
    world(scene["environment"])


def settings(a):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    c, r = scene.cycles, scene.render
    c.device, c.samples, c.seed = "CPU", a.spp, a.seed
    c.use_denoising = c.use_adaptive_sampling = c.use_fast_gi = False
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = a.bounces
    c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = 0
    c.light_sampling_threshold = 0
    c.caustics_reflective = c.caustics_refractive = True
    c.pixel_filter_type = "BOX"
    r.resolution_x, r.resolution_y = (int(x) for x in a.size.split("x"))
    r.resolution_percentage = 100
    r.threads_mode, r.threads = "FIXED", a.threads
    r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
    r.filepath = os.path.abspath(a.out)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("scene")
    p.add_argument("out")
    p.add_argument("--size", default="256x256")
    p.add_argument("--spp", type=int, default=1024)
    p.add_argument("--bounces", type=int, default=64)
    p.add_argument("--seed", type=int, default=0)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("--import", dest="imported", action="store_true")
    a = p.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    (import_gltf if a.imported else rebuild)(a.scene)
    settings(a)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
