#!/usr/bin/python3
"""What jobs say of their own error and of the samples they need, beside what is true.

usage: tests/accuracy/forecast.py BUILD OUT [--raw FOLDER] [--seed 1] [--seeds 16] [--samples 2048]
                                  [--size 32x16] [--only SCENE]... [--estimates]

Scenes are those of glint-demo-scene and, where the variable GLINT_SCENES names a folder, some from
there. Each is rendered once for every seed, by one worker. FOLDER keeps their films: what is there is
not rendered again, so that a run that was stopped goes on, and a change of estimates or forecasts is
measured on the same films. OUT gets estimates.csv, scores.csv, forecasts.csv and
calibration.svg; with --estimates the first alone. Its spreads are standard deviations of the ratios
beside them, from leaving out seed by seed.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import struct
import tempfile
import urllib.parse
import urllib.request

DEMOS = ["cluster", "forty", "strips", "plant", "water", "shelves"]
OTHERS = ["interiors/cornell-box.glb", "interiors/staircase2.glb", "interiors/veach-bidir.glb",
          "chess/chess_set_glass.gltf"]
LOOKS = [32, 64, 128, 256, 512, 1024, 2048]
SCORED = 256  # samples of the pixels that are scored
TARGETS = {32: (2, 4, 8), 64: (2, 4, 8), 256: (1.414, 2, 2.828)}  # samples: what the error is divided by
NEAR = 4  # divisors of the error up to this are reached within the samples that are taken
LEVELS = {50: (4, 5), 80: (3, 6), 90: (2, 7), 95: (1, 8)}  # quantiles of a forecast, by their place

RATIOS = ["error", "linear", "tone", "spread"]
ESTIMATES = ["scene", "samples", "seeds", *RATIOS, "unflagged", *("unflagged_" + r for r in RATIOS)]
FORECASTS = ["first", "scene", "seeds", "forecasts", "not_reached", "judged", "median", "median_near", "in_50",
             "in_80", "in_90", "in_95", "bounds", "bounds_hold", "bounds_median", "bounds_in_90",
             "all_hold"]


def pack(gltf):
    """A .gltf with the files that it names, as the bytes of a .glb."""
    tree, blob = json.loads(gltf.read_text()), bytearray()

    def add(uri):
        data = urllib.request.urlopen(urllib.parse.urljoin(gltf.as_uri(), uri)).read()
        blob.extend(bytes(-len(blob) % 4))
        blob.extend(data)
        return len(blob) - len(data), data

    starts = [add(buffer["uri"])[0] for buffer in tree["buffers"]]
    for view in tree["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
        view["buffer"] = 0
    for image in tree.get("images", []):
        start, data = add(image.pop("uri"))
        image["mimeType"] = "image/png" if data.startswith(b"\x89PNG") else "image/jpeg"
        image["bufferView"] = len(tree["bufferViews"])
        tree["bufferViews"].append({"buffer": 0, "byteOffset": start, "byteLength": len(data)})
    blob.extend(bytes(-len(blob) % 4))
    tree["buffers"] = [{"byteLength": len(blob)}]
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(blob)) +
            struct.pack("<I4s", len(text), b"JSON") + text +
            struct.pack("<I4s", len(blob), b"BIN\0") + blob)


def scenes(build, folder):
    for name in DEMOS:
        path = folder / f"{name}.json"
        path.write_bytes(subprocess.run([build / "glint-demo-scene", name], check=True,
                                        stdout=subprocess.PIPE).stdout)
        yield name, path
    root = os.environ.get("GLINT_SCENES")
    for other in OTHERS:
        path = pathlib.Path(root or ".").resolve() / other
        if root and path.exists() and path.suffix == ".gltf":
            packed = folder / f"{path.stem}.glb"
            packed.write_bytes(pack(path))
            yield path.stem, packed
        elif root and path.exists():
            yield path.stem, path


def write_job(options, folder, samples):
    job = folder / "job.json"
    job.write_text(json.dumps({"scene": "s", "resolution": options.size, "outputs": ["beauty"],
                               "stop": {"samples": samples}}))
    return job


def measure(options, name, path, folder):
    """What the program says of the scene's films, which it renders where they are not there."""
    films = options.raw / name
    films.mkdir(parents=True, exist_ok=True)
    job = write_job(options, folder, 16)
    program = options.build / "tests/accuracy/forecast"
    films = [str(v) for v in (films, *options.size, options.samples, options.seed, options.seeds)]
    subprocess.run([program, "record", *films, path, job], check=True)
    return subprocess.run([program, "measure", *films], check=True, stdout=subprocess.PIPE).stdout


def scores_of(options, name, path, folder):
    """[values of pixels, share of them inside of what their batches say in 95 cases of 100]"""
    kept = options.raw / name / f"scores.{SCORED}"
    if not kept.exists():
        job = write_job(options, folder, SCORED)
        program = options.build / "tests/accuracy/forecast"
        kept.write_bytes(subprocess.run([program, "scores", "8", path, job], check=True,
                                        stdout=subprocess.PIPE).stdout)
    return kept.read_text().strip().split(",")


def looks_of(measured):
    """{samples: [[error, true, linear, true, tone-mapped, true, rare events] of each seed]}"""
    looks = {}
    for line in measured.decode().splitlines():
        kind, _, samples, *rest = line.split(",")
        if kind == "look" and int(samples) in LOOKS:
            looks.setdefault(int(samples), []).append([float(x) for x in rest])
    return looks


def forecasts_of(options, first, measured):
    program = [options.build / "tests/accuracy/forecast", "predict", first, *TARGETS[first]]
    text = subprocess.run([str(word) for word in program], check=True, input=measured,
                          stdout=subprocess.PIPE).stdout.decode()
    return [[float(x) for x in line.split(",")[1:]] for line in text.splitlines()]


def ratio(rows, column):
    return math.sqrt(sum(r[column] ** 2 for r in rows) / sum(r[column + 1] ** 2 for r in rows))


def jackknife(rows, column):
    """The standard deviation of the ratio. Source: Tukey 1958."""
    n = len(rows)
    without = [ratio(rows[:i] + rows[i + 1:], column) for i in range(n)]
    return math.sqrt((n - 1) / n * sum((r - sum(without) / n) ** 2 for r in without))


def ratios(rows):
    """The ratios of all three errors, and the spread of the first."""
    said = [f"{ratio(rows, c):.4f}" for c in (0, 2, 4)] if rows else [""] * 3
    return said + [f"{jackknife(rows, 0):.4f}" if len(rows) > 1 else ""]


def estimate_rows(name, looks):
    for samples, rows in sorted(looks.items()):
        sound = [r for r in rows if not r[6]]
        yield [name, samples, len(rows), *ratios(rows), len(sound), *ratios(sound)]


def median(values):
    values = sorted(values)
    return values[len(values) // 2] if values else math.nan


def held(forecasts, low, high, last):
    """The share of the intervals that hold the truth; what comes after the last sample is known to
    be outside of those that end before."""
    known = [f for f in forecasts if f[3] or f[4 + high] <= last]
    inside = sum(f[4 + low] < f[3] < f[4 + high] for f in known)
    return f"{inside / len(known):.3f}" if known else ""


def row_of(mine, last):
    """Forecasts; then those that were given as lower bounds, and what they would have been worth; and
    the share of all that were right in what they said."""
    said, low = [f for f in mine if not f[2]], [f for f in mine if f[2]]
    row = [len(mine), sum(f[3] == 0 for f in mine), len(said)]
    row.append(f"{median([f[4] / (f[3] or last) for f in said]):.3f}" if said else "")
    near = [f for f in said if f[1] <= NEAR]
    row.append(f"{median([f[4] / (f[3] or math.inf) for f in near]):.3f}" if near else "")
    row += [held(said, *ends, last) for ends in LEVELS.values()]
    known = [f for f in low if f[3] or f[6] <= last]
    bounds = sum(f[3] == 0 or f[3] >= f[6] for f in known)
    row += [len(low), f"{bounds / len(known):.3f}" if known else ""]
    row.append(f"{median([f[4] / (f[3] or last) for f in low]):.3f}" if low else "")
    right = [f for f in said if f[3] or f[4 + LEVELS[90][1]] <= last]
    held_all = bounds + sum(f[6] < f[3] < f[11] for f in right)
    return row + [held(low, *LEVELS[90], last), f"{held_all / (len(known) + len(right)):.3f}"]


def report(first, forecasts, last):
    """Scene by scene, then all, with odd seeds and with even ones."""
    groups = [(name, "all", [f for n, f in forecasts if n == name])
              for name in sorted({n for n, _ in forecasts})]
    groups += [("all", which, [f for _, f in forecasts if f[0] % 2 in parity])
               for which, parity in (("all", (0, 1)), ("odd", (1,)), ("even", (0,)))]
    for name, which, mine in groups:
        yield [first, name, which, *row_of(mine, last)]


def plot(forecasts, path):
    said = [(f[1][3], f[1][4]) for f in forecasts if not f[1][2] and f[1][3] > 0]
    flagged = [(f[1][3], f[1][4]) for f in forecasts if f[1][2] and f[1][3] > 0]
    every = [v for p in said + flagged for v in p] or [1]
    low, high = math.log(min(every) * 0.8), math.log(max(every) * 1.25)
    at = lambda v: 40 + 340 * (math.log(v) - low) / (high - low)
    dot = lambda p, style: f'<circle cx="{at(p[0]):.1f}" cy="{400 - at(p[1]):.1f}" r="2" {style}/>'
    line = lambda k, style: (f'<path d="M{at(math.exp(low)):.1f} {400 - at(math.exp(low) * k):.1f}'
                             f'L{at(math.exp(high)):.1f} {400 - at(math.exp(high) * k):.1f}" {style}/>')
    marks = [2 ** k for k in range(4, 15) if low < math.log(2 ** k) < high]
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 400" '
             'font-family="sans-serif" font-size="10">', '<rect width="400" height="400" fill="#fff"/>']
    parts += [f'<text x="{at(m):.0f}" y="376" text-anchor="middle">{m}</text>'
              f'<text x="34" y="{404 - at(m):.0f}" text-anchor="end">{m}</text>' for m in marks]
    parts += [line(1, 'stroke="#000"'), line(1.1, 'stroke="#999" stroke-dasharray="3 3"'),
              line(0.9, 'stroke="#999" stroke-dasharray="3 3"')]
    parts += [dot(p, 'fill="none" stroke="#c60" stroke-opacity="0.5"') for p in flagged]
    parts += [dot(p, 'fill="#036" fill-opacity="0.6"') for p in said]
    parts += ['<text x="210" y="393" text-anchor="middle">samples at which the error was reached</text>',
              '<text transform="translate(10 200) rotate(-90)" text-anchor="middle">foretold</text>',
              '<text x="60" y="20">filled: forecasts; open: lower bounds; dashed: 10 % off</text></svg>']
    path.write_text("\n".join(parts) + "\n")


def write(path, columns, rows):
    with open(path, "w", newline="", encoding="utf-8") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(columns)
        out.writerows(rows)


def main():
    p = argparse.ArgumentParser()
    p.add_argument("build", type=pathlib.Path)
    p.add_argument("out", type=pathlib.Path)
    p.add_argument("--raw", type=pathlib.Path)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--seeds", type=int, default=16)
    p.add_argument("--samples", type=int, default=2048)
    p.add_argument("--size", default="32x16")
    p.add_argument("--only", action="append")
    p.add_argument("--estimates", action="store_true")
    options = p.parse_args()
    options.build = options.build.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    options.raw = options.raw or options.out / "films"
    options.size = [int(side) for side in options.size.split("x")]
    estimates, forecasts, scores = [], {first: [] for first in TARGETS}, []
    with tempfile.TemporaryDirectory() as folder:
        for name, path in scenes(options.build, pathlib.Path(folder)):
            if options.only and name not in options.only:
                continue
            measured = measure(options, name, path, pathlib.Path(folder))
            estimates += estimate_rows(name, looks_of(measured))
            if options.estimates:
                continue
            scores.append([name, 8, SCORED, *scores_of(options, name, path, pathlib.Path(folder))])
            for first, made in forecasts.items():
                made += [(name, f) for f in forecasts_of(options, first, measured)]
    write(options.out / "estimates.csv", ESTIMATES, estimates)
    if not options.estimates:
        write(options.out / "scores.csv", ["scene", "seeds", "samples", "values", "inside"], scores)
        write(options.out / "forecasts.csv", FORECASTS,
              [row for first, made in forecasts.items() for row in report(first, made, options.samples)])
        plot(sum(forecasts.values(), []), options.out / "calibration.svg")


if __name__ == "__main__":
    main()
