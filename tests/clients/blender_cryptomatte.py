"""blender_cryptomatte.py - recolours in Blender what Cryptomatte layers of a file cover, bounces included:

    blender -b --factory-startup -P blender_cryptomatte.py -- FILE.exr WIDTH HEIGHT ORDERS.json

ORDERS.json is a list of
    {"layers": ["CryptoObject", "CryptoReflObject"],   their mattes are added up, at most to 1
     "names": ["leaf"],                                what a user types, or instead of it
     "pick": ["CryptoRefrObject", x, y],               where a user clicks, y from the top
     "hue": 0.8, "value": 1.0,                         of the Hue Saturation Value node; 0.5, 1: as it is
     "out": "new.exr", "matte": "matte.exr"}
`out`, .exr or .png, is the picture and `matte` the mattes' sum. Prints the layers that the node
offers after "LAYERS ", and what each order has picked after "PICKED ".
"""
import json
import os
import sys
import tempfile

import bpy
import numpy as np


class Compositor:
    """The compositor's tree, with the file as its only picture."""

    def __init__(self, file, width, height):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.scene.use_nodes = True
        self.tree = self.scene.node_tree
        self.tree.nodes.clear()
        self.image = bpy.data.images.load(file)
        self.out = self.add("Composite", use_alpha=False)
        render = self.scene.render
        render.resolution_x, render.resolution_y = width, height
        render.resolution_percentage = 100
        render.use_compositing, render.use_sequencer = True, False
        self.scene.view_settings.view_transform = "Standard"

    def add(self, kind, **settings):
        node = self.tree.nodes.new(f"CompositorNode{kind}")
        for name, value in settings.items():
            setattr(node, name, value)
        return node

    def link(self, output, to):
        self.tree.links.new(output, to)

    def write(self, output, path, grey=False):
        """What a socket gives, as a file."""
        settings = self.scene.render.image_settings
        exr = path.endswith(".exr")
        settings.file_format = "OPEN_EXR" if exr else "PNG"
        settings.color_mode = "BW" if grey else "RGB"
        settings.color_depth = "32" if exr else "8"
        self.link(output, self.out.inputs["Image"])
        self.scene.render.filepath = path
        bpy.ops.render.render(write_still=True)

    def cryptomatte(self, layer, matte=""):
        node = self.add("CryptomatteV2", source="IMAGE", image=self.image)
        node.layer_name = next(name for name in offered(node) if name.endswith(layer))
        node.matte_id = matte
        return node


def offered(node):
    """Layers that the node found. Blender only tells them to who asks for a wrong one."""
    try:
        node.layer_name = "\x01"
    except TypeError as refusal:
        text = str(refusal)
        return [word.strip(" '()") for word in text[text.rindex("("):].split(",") if word.strip(" '()")]
    return []


def pick(compositor, layer, x, y):
    """What the eyedropper takes from the node's Pick output: the ID that covers the pixel most."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "pick.exr")
        node = compositor.cryptomatte(layer)
        compositor.write(node.outputs["Pick"], path)
        image = bpy.data.images.load(path)
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        value = pixels.reshape(height, width, image.channels)[height - 1 - y, x, 0]
    return f"<{value:.9g}>"


def matte(compositor, layers, typed):
    """The socket of the sum of the layers' mattes."""
    sockets = [compositor.cryptomatte(layer, typed).outputs["Matte"] for layer in layers]
    total = sockets[0]
    for socket in sockets[1:]:
        both = compositor.add("Math", operation="ADD", use_clamp=True)
        compositor.link(total, both.inputs[0])
        compositor.link(socket, both.inputs[1])
        total = both.outputs["Value"]
    return total


def recolour(compositor, order):
    typed = ",".join(order.get("names", [])) or pick(compositor, *order["pick"])
    print("PICKED " + json.dumps(typed), flush=True)
    covered = matte(compositor, order["layers"], typed)
    picture = compositor.add("Image", image=compositor.image)
    colour = compositor.add("HueSat")
    colour.inputs["Hue"].default_value = order["hue"]
    colour.inputs["Value"].default_value = order.get("value", 1.0)
    compositor.link(covered, colour.inputs["Fac"])
    # A multilayer file has its picture in the socket that is called after it.
    whole = next(s for s in picture.outputs if s.enabled and s.name in ("Combined", "Image"))
    compositor.link(whole, colour.inputs["Image"])
    compositor.write(colour.outputs["Image"], order["out"])
    if "matte" in order:
        compositor.write(covered, order["matte"], grey=True)


def main(file, width, height, orders):
    compositor = Compositor(file, int(width), int(height))
    node = compositor.add("CryptomatteV2", source="IMAGE", image=compositor.image)
    print("LAYERS " + json.dumps(offered(node)), flush=True)
    with open(orders, encoding="utf-8") as text:
        for order in json.load(text):
            recolour(compositor, order)


main(*sys.argv[sys.argv.index("--") + 1:])
