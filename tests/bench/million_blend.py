"""million_blend.py - the scene of million_scene as a .blend that Cycles renders with one sample.

    blender -b --factory-startup -P million_blend.py -- SCENE.json OUT.blend WIDTH HEIGHT
"""
import json
import sys

import bpy
from mathutils import Matrix, Quaternion, Vector

UP = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))  # y up to z up


def material(name, m):
    out = bpy.data.materials.new(name)
    out.use_nodes = True
    shader = out.node_tree.nodes["Principled BSDF"].inputs
    shader["Base Color"].default_value = (*m["base_color"], 1)
    shader["Roughness"].default_value = m.get("roughness", 1)
    shader["Metallic"].default_value = m.get("metallic", 0)
    shader["Emission"].default_value = (*m.get("emission", (0, 0, 0)), 1)
    return out


def mesh(m):
    """Made in the active object."""
    if m["primitive"] == "sphere":
        segments = m["segments"]
        bpy.ops.mesh.primitive_uv_sphere_add(radius=m["radius"], segments=segments,
                                             ring_count=segments // 2)
        bpy.ops.object.shade_smooth()
    elif m["primitive"] == "box":
        bpy.ops.mesh.primitive_cube_add(size=1)
        for v in bpy.context.object.data.vertices:
            v.co = [a * b for a, b in zip(v.co, m["size"])]
    else:
        bpy.ops.mesh.primitive_plane_add(size=1)
        for v in bpy.context.object.data.vertices:
            v.co = [v.co[0] * m["size"][0], v.co[1] * m["size"][1], 0]
    return bpy.context.object


def matrix(t):
    x, y, z, w = t.get("rotation", (0, 0, 0, 1))
    return UP @ Matrix.Translation(Vector(t.get("translation", (0, 0, 0)))) @ \
        Quaternion((w, x, y, z)).to_matrix().to_4x4()


def build(scene):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = {name: material(name, m) for name, m in scene["materials"].items()}
    for placed in scene["instances"].values():
        made = mesh(scene["meshes"][placed["mesh"]])
        made.matrix_world = matrix(placed.get("transform", {}))
        made.data.materials.append(materials[placed["material"]])
    seen = scene["cameras"]["eye"]
    bpy.ops.object.camera_add()
    camera = bpy.context.object
    camera.data.sensor_fit, camera.data.angle = "VERTICAL", seen["yfov"]
    camera.matrix_world = matrix(seen["transform"])
    bpy.context.scene.camera = camera


def settle(width, height):
    made = bpy.context.scene
    made.render.engine = "CYCLES"
    made.render.resolution_x, made.render.resolution_y = width, height
    made.render.resolution_percentage = 100
    made.cycles.device, made.cycles.samples = "CPU", 1
    made.cycles.use_adaptive_sampling = made.cycles.use_denoising = False
    made.cycles.max_bounces = 8


source, target, width, height = sys.argv[sys.argv.index("--") + 1:]
with open(source, encoding="utf-8") as file:
    build(json.load(file))
settle(int(width), int(height))
bpy.ops.wm.save_as_mainfile(filepath=target)
