"""cryptomatte_node.py - what Blender's Cryptomatte node makes of a file:

    blender -b --factory-startup -P cryptomatte_node.py -- FILE.exr WIDTH HEIGHT ORDERS.json

ORDERS.json is a list of {"layer": "CryptoObject", "matte": "what a user types", "out": "m.exr"}; the
matte of each is written as a 32-bit EXR. Prints the layers that the node offers, after "LAYERS ".
"""
import json
import sys

import bpy


def offered(node):
    """Layers that the node found. Blender only tells them to who asks for a wrong one."""
    try:
        node.layer_name = "\x01"
    except TypeError as refusal:
        text = str(refusal)
        return [word.strip(" '()") for word in text[text.rindex("("):].split(",") if word.strip(" '()")]
    return []


def compose(file, width, height):
    scene = bpy.context.scene
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.source = "IMAGE"
    node.image = bpy.data.images.load(file)
    out = tree.nodes.new("CompositorNodeComposite")
    out.use_alpha = False
    tree.links.new(node.outputs["Matte"], out.inputs["Image"])
    render = scene.render
    render.resolution_x, render.resolution_y = width, height
    render.resolution_percentage = 100
    render.use_compositing, render.use_sequencer = True, False
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "BW", "32"
    return scene, node


def main(file, width, height, orders):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, node = compose(file, int(width), int(height))
    layers = offered(node)
    print("LAYERS " + json.dumps(layers), flush=True)
    with open(orders, encoding="utf-8") as text:
        for order in json.load(text):
            node.layer_name = next(name for name in layers if name.endswith(order["layer"]))
            node.matte_id = order["matte"]
            scene.render.filepath = order["out"]
            bpy.ops.render.render(write_still=True)


main(*sys.argv[sys.argv.index("--") + 1:])
