"""report.py - what the bench `peers` found: a CSV, a table, a plot and a sheet of pictures a scene."""
import csv
import json
import math
import os
import subprocess

import numpy as np

COLOUR = {"glint": "#c0202a", "cycles-debian": "#888", "cycles": "#f08020", "mitsuba-llvm": "#2060c0",
          "mitsuba-scalar": "#70a0e0", "luxcore": "#208040", "embree": "#804090"}
COLUMNS = ["scene", "renderer", "version", "round", "spp", "user_s", "relmse", "relmse_trim",
           "reference_spp", "reference_relmse"]
PICTURE = 192 # pixels of a side on the sheet


def cpu():
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        for line in f:
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return "unknown"


def rows(results):
    for scene in results:
        for name, r in scene["renderers"].items():
            for k, round_ in enumerate(r["rounds"]):
                for n, user, error, trimmed in zip(round_["counts"], round_["user"],
                                                   round_["relmse"], round_["trimmed"]):
                    yield [scene["scene"], name, r["version"], k, n, f"{user:.4f}", f"{error:.6g}",
                           f"{trimmed:.6g}", r["reference_samples"], f"{r['floor']:.4g}"]


def summary(results):
    """Of each scene and target: ours over the best peer, and who is not compared, and why."""
    out = {}
    for scene in results:
        out[scene["scene"]] = {
            "missing": scene["missing"],
            "something_else": [n for n, a in scene["agreement"].items() if a["resolved"] and not a["same"]],
            "too_noisy": [n for n, a in scene["agreement"].items() if not a["resolved"]],
            "msamples_per_second": {n: round(r["samples_per_second"] / 1e6, 4)
                                    for n, r in scene["renderers"].items()},
            "ratio": {t: target["ratio"] and {k: v if isinstance(v, str) else round(v, 4)
                                              for k, v in target["ratio"].items()}
                      for t, target in scene["targets"].items()}}
    return out


# ----------------------------------------------------------------------------- table ----

def cell(reached, name):
    if name not in reached:
        return ""
    r = reached[name]
    marks = ("~" if r["extrapolated"] else "") + ("*" if r["limited"] else "")
    return f"{r['median']:.3g}{marks}"


def ratio(found):
    if not found:
        return "none to compare"
    return f"{found['median']:.2f} ({found['low']:.2f} to {found['high']:.2f}) {found['best']}"


def agreement(scene):
    for name, a in scene["agreement"].items():
        verdict = ("" if a["same"] else " - **renders something else, not counted**"
                   if a["resolved"] else " - **too noisy to tell, not counted**")
        yield (f"{name}: mean {a['mean_ratio']:.3f} of ours, blocks off by {a['blocks_median']:.1%} "
               f"(median), {a['blocks_p95']:.1%} (95th percentile), "
               f"noise {a['noise']:.1%}" + verdict)
    for name, why in scene["missing"].items():
        yield f"{name}: cannot be had: {why}"


def table(scene):
    names = list(scene["renderers"])
    lines = [f"## {scene['scene']}", "",
             "| relMSE | " + " | ".join(names) + " | glint / best | trimmed |",
             "| --- |" + " --- |" * (len(names) + 2)]
    for target, t in scene["targets"].items():
        cells = [cell(t["reached"], n) for n in names]
        lines.append(f"| {target} | " + " | ".join(cells)
                     + f" | {ratio(t['ratio'])} | {ratio(t['trimmed'])} |")
    speed = (f"{r['samples_per_second'] / 1e6:.3f}" for r in scene["renderers"].values())
    lines += ["| Msamples/s | " + " | ".join(speed) + " | | |", ""]
    return lines + ["- " + text for text in agreement(scene)] + [""]


# ------------------------------------------------------------------------------ plot ----

def points(r):
    """(CPU seconds, error less that of the reference) at each count: geometric means of rounds."""
    gm = lambda values: math.exp(np.mean(np.log(np.maximum(values, 1e-9))))
    return [(gm([x["user"][k] for x in r["rounds"]]),
             gm([x["relmse"][k] - r["floor"] for x in r["rounds"]]))
            for k in range(len(r["rounds"][0]["counts"]))]


def plot(path, scene):
    lines = {n: points(r) for n, r in scene["renderers"].items()}
    every = [p for line in lines.values() for p in line]
    x0, x1 = (f(math.log10(p[0]) for p in every) for f in (min, max))
    y0, y1 = (f(math.log10(p[1]) for p in every) for f in (min, max))
    x0, x1, y0, y1 = math.floor(x0), math.ceil(x1), math.floor(y0), math.ceil(y1)
    px = lambda x: 60 + 380 * (math.log10(x) - x0) / max(x1 - x0, 1)
    py = lambda y: 30 + 250 * (y1 - math.log10(y)) / max(y1 - y0, 1)
    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="560" height="320" font-family="sans-serif" '
           'font-size="11"><rect width="100%" height="100%" fill="#fff"/>',
           f'<text x="60" y="18" font-weight="600">{scene["scene"]}: relMSE over user CPU seconds</text>']
    for k in range(x0, x1 + 1):
        out.append(f'<path d="M{px(10 ** k):.1f} 30V280" stroke="#ddd"/><text x="{px(10 ** k):.1f}" '
                   f'y="296" text-anchor="middle">{10 ** k:g}</text>')
    for k in range(y0, y1 + 1):
        out.append(f'<path d="M60 {py(10 ** k):.1f}H440" stroke="#ddd"/><text x="54" '
                   f'y="{py(10 ** k) + 4:.1f}" text-anchor="end">{10 ** k:g}</text>')
    for row, (name, line) in enumerate(lines.items()):
        same = scene["agreement"].get(name, {"same": True})["same"]
        dash = "" if same else ' stroke-dasharray="4 3"'
        path_ = "L".join(f"{px(x):.1f} {py(y):.1f}" for x, y in line)
        out.append(f'<path d="M{path_}" fill="none" stroke="{COLOUR[name]}" stroke-width="2"{dash}/>')
        out += [f'<circle cx="{px(x):.1f}" cy="{py(y):.1f}" r="3" fill="{COLOUR[name]}"/>'
                for x, y in line]
        out.append(f'<text x="450" y="{44 + 16 * row}" fill="{COLOUR[name]}">{name}'
                   f'{"" if same else " (differs)"}</text>')
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join([*out, "</svg>"]) + "\n")


# ----------------------------------------------------------------------------- sheet ----

def sheet(path, pictures, agreed):
    """All references side by side at one exposure, ours first, labelled."""
    first = next(iter(pictures.values()))
    bright = first.max(2)
    exposure = .35 / max(float(np.median(bright[bright > .01 * bright.mean()])), 1e-4)
    side = first.shape[0]
    tiles = []
    for image in pictures.values():
        step = max(side // PICTURE, 1)
        small = image[:side // step * step, :side // step * step].reshape(
            side // step, step, side // step, step, 3).mean((1, 3))
        grow = max(PICTURE // small.shape[0], 1)
        tiles.append(np.repeat(np.repeat(small, grow, 0), grow, 1))
    light = np.clip(np.concatenate(tiles, 1) * exposure, 0, 1)
    shown = np.where(light <= .0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - .055)
    strip = np.full((18, shown.shape[1], 3), 1.0)
    rgb = (np.concatenate([strip, shown]) * 255 + .5).astype(np.uint8)
    raw = path + ".ppm"
    with open(raw, "wb") as f:
        f.write(f"P6 {rgb.shape[1]} {rgb.shape[0]} 255\n".encode() + rgb.tobytes())
    font = subprocess.run(["fc-match", "-f", "%{file}", "sans"], capture_output=True, text=True,
                          check=True).stdout
    command = ["oiiotool", raw]
    for k, name in enumerate(pictures):
        differs = not agreed.get(name, {"same": True})["same"]
        command += [f"--text:x={4 + k * tiles[0].shape[1]}:y=13:size=11:color=0,0,0:font={font}",
                    name + (" (differs)" if differs else "")]
    subprocess.run([*command, "--compression", "jpeg:88", "-o", path], check=True)
    os.remove(raw)


def write(folder, results, o):
    with open(os.path.join(folder, "peers.csv"), "w", encoding="utf-8", newline="") as f:
        writer = csv.writer(f, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows(results))
    with open(os.path.join(folder, "peers.json"), "w", encoding="utf-8") as f:
        json.dump({"resolution": o.resolution, "rounds": o.rounds, "cpu": cpu(),
                   "scenes": summary(results)}, f, indent=1)
        f.write("\n")
    text = [f"CPU seconds to relMSE at {o.resolution}x{o.resolution}, medians of {o.rounds} rounds; "
            "~ extrapolated, * the reference's own error is above a quarter of the target's", ""]
    for scene in results:
        text += table(scene)
        plot(os.path.join(folder, f"{scene['scene']}.svg"), scene)
    with open(os.path.join(folder, "table.md"), "w", encoding="utf-8") as f:
        f.write("\n".join(text))
