"""cycles_serve.py - Cycles, of Debian's Blender or of bpy from PyPI, for the bench `peers`.

    blender -b --factory-startup -P cycles_serve.py -- FOLDER WIDTH HEIGHT BOUNCES
    python cycles_serve.py FOLDER WIDTH HEIGHT BOUNCES

Lambert is a Diffuse BSDF, clear glass a Glass BSDF; metal, coated and tinted glass are a Principled
BSDF with GGX of one reflection; before 4.0, whose Principled base is Disney's, coated is a Diffuse and
a Glossy BSDF mixed by Fresnel's factor. Lamps emit on their front, which Cycles is told where it knows.
Left as Cycles has it: its sampler, its light tree where there is one, its roulette. Turned off, as
bias: clamping, the threshold of light sampling, the blurring of glossy lobes.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy
import numpy as np
from mathutils import Matrix

import neutral
import serve

TURN = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float) # glTF's y up to Blender's z up
NEW = bpy.app.version >= (4, 0) # the Principled BSDF with an index of refraction and other names


def node(tree, kind, **inputs):
    out = tree.nodes.new(kind)
    for name, value in inputs.items():
        out.inputs[name.replace("_", " ")].default_value = value
    return out


def colour_input(tree, m, shader, name):
    shader.inputs[name].default_value = (*m["base_color"], 1)
    if "base_color_file" in m:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(m["base_color_file"], check_existing=True)
        texture.interpolation = ("Closest" if m["base_color_texture"]["filter"] == "nearest"
                                 else "Linear")
        if m["base_color"] == [1, 1, 1]:
            tree.links.new(texture.outputs["Color"], shader.inputs[name])
        else:
            product = tree.nodes.new("ShaderNodeMixRGB")
            product.blend_type = "MULTIPLY"
            product.inputs[0].default_value = 1
            product.inputs[2].default_value = (*m["base_color"], 1)
            tree.links.new(texture.outputs["Color"], product.inputs[1])
            tree.links.new(product.outputs[0], shader.inputs[name])


def layered(tree, m):
    """A dielectric layer over lambert where the Principled BSDF's base is Disney's."""
    base = tree.nodes.new("ShaderNodeBsdfDiffuse")
    colour_input(tree, m, base, "Color")
    layer = node(tree, "ShaderNodeBsdfGlossy", Roughness=m["roughness"])
    layer.distribution = "GGX"
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(node(tree, "ShaderNodeFresnel", IOR=m["ior"]).outputs[0], mix.inputs[0])
    tree.links.new(base.outputs[0], mix.inputs[1])
    tree.links.new(layer.outputs[0], mix.inputs[2])
    return mix.outputs[0]


def principled(tree, m):
    out = node(tree, "ShaderNodeBsdfPrincipled", Metallic=m["metallic"], Roughness=m["roughness"],
               IOR=m["ior"])
    out.distribution = "GGX"
    out.inputs["Transmission Weight" if NEW else "Transmission"].default_value = m["transmission"]
    if not NEW:
        out.inputs["Specular"].default_value = ((m["ior"] - 1) / (m["ior"] + 1)) ** 2 / 0.08
    colour_input(tree, m, out, "Base Color")
    return out.outputs[0]


def closure(tree, m):
    kind = neutral.kind(m)
    if kind == "lambert":
        out = tree.nodes.new("ShaderNodeBsdfDiffuse")
        colour_input(tree, m, out, "Color")
        return out.outputs[0]
    if kind == "glass" and m["base_color"] == [1, 1, 1] and "base_color_file" not in m:
        out = node(tree, "ShaderNodeBsdfGlass", Roughness=m["roughness"], IOR=m["ior"])
        out.distribution = "GGX"
        return out.outputs[0]
    if kind == "coated" and not NEW:
        return layered(tree, m)
    return principled(tree, m)


def emission(tree, m):
    light = node(tree, "ShaderNodeEmission", Color=(*m["emission"], 1), Strength=1).outputs[0]
    if m["double_sided"]:
        return light
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs[0])
    tree.links.new(light, mix.inputs[1])
    return mix.outputs[0]


def holes(tree, m, shader):
    """Where the opacity's picture is 0."""
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(m["opacity_file"], check_existing=True)
    texture.image.colorspace_settings.name = "Non-Color"
    texture.interpolation = "Closest"
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(texture.outputs["Color"], mix.inputs[0])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    tree.links.new(shader, mix.inputs[2])
    return mix.outputs[0]


def material(name, m):
    out = bpy.data.materials.new(name)
    out.use_nodes = True
    tree = out.node_tree
    tree.nodes.clear()
    if neutral.emits(m):
        shader = emission(tree, m)
        if hasattr(out.cycles, "emission_sampling") and not m["double_sided"]:
            out.cycles.emission_sampling = "FRONT"
    else:
        shader = closure(tree, m)
    if "opacity_file" in m:
        shader = holes(tree, m, shader)
    tree.links.new(shader, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return out


def mesh(m, shader):
    data = bpy.data.meshes.new(m["name"])
    faces = np.ascontiguousarray(m["I"], np.int32)
    data.vertices.add(len(m["P"]))
    data.vertices.foreach_set("co", (m["P"] @ TURN.T).astype(np.float32).ravel())
    data.loops.add(faces.size)
    data.loops.foreach_set("vertex_index", faces.ravel())
    data.polygons.add(len(faces))
    data.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    if not NEW:
        data.polygons.foreach_set("loop_total", np.full(len(faces), 3, np.int32))
    data.materials.append(shader)
    if m["UV"] is not None:
        uv = np.column_stack([m["UV"][:, 0], 1 - m["UV"][:, 1]])[faces.ravel()]
        data.uv_layers.new().data.foreach_set("uv", uv.astype(np.float32).ravel())
    data.update(calc_edges=True)
    data.polygons.foreach_set("use_smooth", [m["N"] is not None] * len(faces))
    if m["N"] is not None:
        if not NEW:
            data.use_auto_smooth = True
        data.normals_split_custom_set_from_vertices((m["N"] @ TURN.T).tolist())
    thing = bpy.data.objects.new(m["name"], data)
    for name in ("shadow_terminator_geometry_offset", "shadow_terminator_shading_offset"):
        if hasattr(thing.cycles, name):
            setattr(thing.cycles, name, 0)
    bpy.context.scene.collection.objects.link(thing)


def oriented(transform):
    m = np.eye(4)
    m[:3] = TURN @ transform[:3]
    return Matrix(m.tolist())


def camera(c):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle_y = "VERTICAL", c["yfov"]
    data.clip_start, data.clip_end = 1e-3, 1e5
    thing = bpy.data.objects.new("camera", data)
    thing.matrix_world = oriented(c["transform"])
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


def sun(light):
    data = bpy.data.lights.new("sun", "SUN")
    data.angle, data.energy, data.color = 0, light["intensity"], light["color"]
    thing = bpy.data.objects.new("sun", data)
    thing.matrix_world = oriented(light["transform"])
    bpy.context.scene.collection.objects.link(thing)


def world(e):
    w = bpy.data.worlds.new("world")
    w.use_nodes = True
    tree = w.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    background.inputs[0].default_value = (*(e["radiance"] if e else (0, 0, 0)), 1)
    background.inputs[1].default_value = 1
    if e and e["file"]:
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(e["file"])
        turn = tree.nodes.new("ShaderNodeMapping")
        turn.inputs["Rotation"].default_value = (0, 0, -np.pi / 2)
        place = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
        tree.links.new(turn.outputs["Vector"], texture.inputs["Vector"])
        tree.links.new(texture.outputs["Color"], background.inputs[0])
    bpy.context.scene.world = w


def settings(width, height, bounces):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    c, r = scene.cycles, scene.render
    c.device = "CPU"
    c.use_denoising = c.use_adaptive_sampling = c.use_fast_gi = c.use_auto_tile = False
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = bounces
    c.transparent_max_bounces = 64
    c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = 0
    c.light_sampling_threshold = 0
    c.caustics_reflective = c.caustics_refractive = True
    c.pixel_filter_type = "BOX"
    r.resolution_x, r.resolution_y, r.resolution_percentage = width, height, 100
    r.threads_mode, r.threads = "FIXED", os.cpu_count()
    r.use_persistent_data = True
    r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
    r.image_settings.exr_codec = "ZIP"


def build(folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = neutral.read(folder)
    materials = {name: material(name, m) for name, m in scene["materials"].items()}
    for m in scene["meshes"]:
        mesh(m, materials[m["material"]])
    camera(scene["camera"])
    for light in scene["lights"]:
        sun(light)
    world(scene["environment"])


def render(samples, seed, out):
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath = out
    bpy.ops.render.render(write_still=False)

    def save():
        bpy.data.images["Render Result"].save_render(out)

    return save


def main():
    argv = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    folder, width, height, bounces, _ = serve.arguments(argv)
    build(folder)
    settings(width, height, bounces)
    serve.loop(f"Cycles {bpy.app.version_string}", render)


main()
