"""luxcore_serve.py - LuxCore (PyPI pyluxcore) for the bench `peers`.

    luxcore_serve.py FOLDER WIDTH HEIGHT BOUNCES

Lambert is `matte`, a mirror `mirror`, glass `glass` or `roughglass` (its microfacets are Schlick's,
not GGX); metal and coated are `disney`. PATHCPU with its default sampler (Sobol) and light strategy;
no clamping, no noise estimate, box filter.
"""
import os
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

os.environ["OCL_ICD_VENDORS"] = os.devnull # PoCL and its own LLVM do not live in one process

import numpy as np
import pyluxcore

import neutral
import serve

TURN = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float) # glTF's y up to LuxCore's z up
SKY_TURN = [-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]


class Description:
    """Properties by their names; items are counted, as names of scenes may hold dots."""

    def __init__(self):
        self.properties, self.textures = pyluxcore.Properties(), {}

    def put(self, prefix, **values):
        for name, value in values.items():
            value = value if isinstance(value, list) else [value]
            self.properties.Set(pyluxcore.Property(f"{prefix}.{name.replace('_', '.')}", value))

    def picture(self, path, nearest):
        """The name of an image of linear values."""
        if path not in self.textures:
            name = self.textures[path] = f"picture{len(self.textures)}"
            self.put(f"scene.textures.{name}", type="imagemap", file=path, gamma=1.0,
                     filter="nearest" if nearest else "linear")
        return self.textures[path]

    def colour(self, m):
        if "base_color_linear" not in m:
            return [float(c) for c in m["base_color"]]
        return self.picture(m["base_color_linear"],
                            m["base_color_texture"]["filter"] == "nearest")


def material(d, name, m):
    prefix, kind, alpha = f"scene.materials.{name}", neutral.kind(m), m["roughness"] ** 2
    if neutral.emits(m):
        d.put(prefix, type="matte", kd=[0.0, 0.0, 0.0], emission=[float(e) for e in m["emission"]])
    elif kind == "lambert":
        d.put(prefix, type="matte", kd=d.colour(m))
    elif kind == "glass":
        d.put(prefix, kr=[1.0, 1.0, 1.0], kt=d.colour(m), interiorior=float(m["ior"]), exteriorior=1.0)
        if alpha < 1e-3:
            d.put(prefix, type="glass")
        else:
            d.put(prefix, type="roughglass", uroughness=alpha, vroughness=alpha)
    elif kind == "metal" and alpha < 1e-3:
        d.put(prefix, type="mirror", kr=d.colour(m))
    else:
        f0 = ((m["ior"] - 1) / (m["ior"] + 1)) ** 2
        d.put(prefix, type="disney", basecolor=d.colour(m), metallic=float(m["metallic"]),
              roughness=float(m["roughness"]), specular=f0 / .08)
    if "opacity_file" in m:
        d.put(prefix, transparency=d.picture(m["opacity_file"], True))


def mesh(scene, d, index, m, material_name):
    rows = lambda a: None if a is None else [tuple(r) for r in a.tolist()]
    turned = lambda a: None if a is None else a @ TURN.T
    scene.DefineMesh(f"mesh{index}", rows(turned(m["P"])), rows(m["I"]), rows(turned(m["N"])),
                     rows(m["UV"]), None, None)
    d.put(f"scene.objects.thing{index}", shape=f"mesh{index}", material=material_name)


def camera(d, c, height):
    """LuxCore's rows are one lower than its camera looks: the window is moved against that."""
    row = 2.0 / height
    m = TURN @ c["transform"][:3]
    floats = lambda v: [float(x) for x in v]
    d.put("scene.camera", type="perspective", lookat_orig=floats(m[:, 3]),
          lookat_target=floats(m[:, 3] - m[:, 2]), up=floats(m[:, 1]),
          fieldofview=float(np.degrees(c["yfov"])), lensradius=0.0, autofocus_enable=False,
          screenwindow=[-1.0, 1.0, -1.0 - row, 1.0 - row])


def lights(d, scene):
    for k, light in enumerate(scene["lights"]):
        d.put(f"scene.lights.sun{k}", type="sharpdistant",
              direction=[float(-x) for x in TURN @ light["transform"][:3, 2]],
              color=[float(c * light["intensity"]) for c in light["color"]])
    e = scene["environment"]
    if e and e["file"]:
        d.put("scene.lights.sky", type="infinite", file=e["file"], gamma=1.0,
              transformation=SKY_TURN)
    elif e:
        d.put("scene.lights.sky", type="constantinfinite", color=[float(x) for x in e["radiance"]])


def load(folder, height):
    world, scene, d = neutral.read(folder), pyluxcore.Scene(), Description()
    names = {name: f"material{k}" for k, name in enumerate(world["materials"])}
    for name, m in world["materials"].items():
        material(d, names[name], m)
    for k, m in enumerate(world["meshes"]):
        mesh(scene, d, k, m, names[m["material"]])
    camera(d, world["camera"], height)
    lights(d, world)
    scene.Parse(d.properties)
    return scene


def settings(width, height, bounces, samples, seed):
    values = {
        "renderengine.type": "PATHCPU", "renderengine.seed": seed, "batch.haltspp": samples,
        "native.threads.count": os.cpu_count(), "sampler.sobol.adaptive.strength": 0.0,
        "path.pathdepth.total": bounces + 2, "path.pathdepth.diffuse": bounces + 2,
        "path.pathdepth.glossy": bounces + 2, "path.pathdepth.specular": bounces + 2,
        "path.clamping.variance.maxvalue": 0.0, "path.hybridbackforward.enable": False,
        "film.width": width, "film.height": height, "film.filter.type": "NONE", # a box of a pixel
        "film.imagepipelines.0.0.type": "NOP",
        "film.noiseestimation.warmup": 0, "film.safesave": False}
    out = pyluxcore.Properties()
    for name, value in values.items():
        out.Set(pyluxcore.Property(name, [value]))
    return out


def main():
    folder, width, height, bounces, _ = serve.arguments(sys.argv[1:])
    pyluxcore.Init(lambda message: None)
    scene = load(folder, height)

    def render(samples, seed, out):
        config = pyluxcore.RenderConfig(settings(width, height, bounces, samples, seed), scene)
        session = pyluxcore.RenderSession(config)
        session.Start()
        while not session.HasDone():
            time.sleep(.005)
            session.UpdateStats() # looks whether it is to halt
        session.Stop()

        def finish():
            session.UpdateStats()
            taken = session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat()
            picture = np.zeros(width * height * 3, np.float32)
            session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB_IMAGEPIPELINE, picture)
            picture.reshape(height, width, 3)[::-1].tofile(out)
            return taken / (width * height)

        return finish

    serve.loop(f"LuxCore {pyluxcore.Version()}", render)
    os._exit(0) # its threads do not outlive the interpreter


main()
