#!/usr/bin/python3
"""What jobs say of their own error and of the samples they need, beside what is true.

usage: tests/accuracy/forecast.py BUILD OUT [--seeds 16] [--first 64] [--samples 4096]
                                  [--size 96x64] [--only SCENE]... [--keep]

Scenes are those of glint-demo-scene and, where the variable GLINT_SCENES names a folder, interiors
from there. Each is rendered once for every seed, by one worker; OUT gets estimates.csv,
forecasts.csv and calibration.svg. --keep takes what OUT has measured already.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import tempfile

DEMOS = ["cluster", "forty", "strips", "plant", "water", "shelves"]
INTERIORS = ["cornell-box", "staircase2", "bathroom", "veach-bidir"]
LOOKS = [32, 64, 128, 256, 512, 1024, 2048]
LEVELS = {50: (4, 5), 80: (3, 6), 90: (2, 7), 95: (1, 8)}  # quantiles of a forecast, by their place


def scenes(build, folder):
    for name in DEMOS:
        path = folder / f"{name}.json"
        path.write_bytes(subprocess.run([build / "glint-demo-scene", name], check=True,
                                        stdout=subprocess.PIPE).stdout)
        yield name, path
    root = os.environ.get("GLINT_SCENES")
    for name in INTERIORS:
        path = pathlib.Path(root or ".") / "interiors" / f"{name}.glb"
        if root and path.exists():
            yield name, path


def measure(options, name, path, folder):
    raw = options.out / f"{name}.measured"
    if options.keep and raw.exists():
        return raw
    job = folder / "job.json"
    width, height = map(int, options.size.split("x"))
    job.write_text(json.dumps({"scene": "s", "resolution": [width, height], "outputs": ["beauty"],
                               "stop": {"samples": 16}}))
    program = options.build / "tests/accuracy/forecast"
    with open(raw, "wb") as out:
        subprocess.run([program, "measure", path, job, str(options.seeds), str(options.samples),
                        str(options.first)], check=True, stdout=out)
    return raw


def looks_of(raw):
    """{samples: [[error, true, linear, true, tone-mapped, true, tail] of each seed]}"""
    looks = {}
    for line in open(raw):
        kind, _, samples, *rest = line.strip().split(",")
        if kind == "look" and int(samples) in LOOKS:
            looks.setdefault(int(samples), []).append([float(x) for x in rest])
    return looks


def forecasts_of(options, raw):
    with open(raw, "rb") as measured:
        text = subprocess.run([options.build / "tests/accuracy/forecast", "predict",
                               str(options.first)], check=True, stdin=measured,
                              stdout=subprocess.PIPE).stdout.decode()
    return [[float(x) for x in line.split(",")[1:]] for line in text.splitlines()]


def ratio(rows, column):
    return math.sqrt(sum(r[column] ** 2 for r in rows) / sum(r[column + 1] ** 2 for r in rows))


def estimate_rows(name, looks):
    for samples, rows in sorted(looks.items()):
        yield [name, samples, len(rows)] + [f"{ratio(rows, c):.4f}" for c in (0, 2, 4)] + [
            sum(r[6] < 2.5 for r in rows)]


def median(values):
    values = sorted(values)
    return values[len(values) // 2] if values else math.nan


def report(forecasts, out):
    """Forecasts that are not lower bounds and whose target was reached; then what was flagged."""
    for name in sorted({f[0] for f in forecasts}) + [None]:
        mine = [f[1] for f in forecasts if name in (None, f[0])]
        said = [f for f in mine if not f[2] and f[3] > 0]
        low = [f for f in mine if f[2]]
        row = [name or "all", len(mine), len(low), sum(f[3] == 0 for f in mine), len(said)]
        row.append(f"{median([f[4] / f[3] for f in said]):.3f}")
        for low_at, high_at in LEVELS.values():
            inside = sum(f[4 + low_at] < f[3] < f[4 + high_at] for f in said)
            row.append(f"{inside / len(said):.3f}" if said else "")
        bounds = sum(f[3] == 0 or f[3] >= f[6] for f in low)
        row.append(f"{bounds / len(low):.3f}" if low else "")
        out.writerow(row)
        print(*row)


def plot(forecasts, path):
    said = [(f[1][3], f[1][4]) for f in forecasts if not f[1][2] and f[1][3] > 0]
    flagged = [(f[1][3], f[1][4]) for f in forecasts if f[1][2] and f[1][3] > 0]
    every = [v for p in said + flagged for v in p]
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


def main():
    p = argparse.ArgumentParser()
    p.add_argument("build", type=pathlib.Path)
    p.add_argument("out", type=pathlib.Path)
    p.add_argument("--seeds", type=int, default=16)
    p.add_argument("--first", type=int, default=64)
    p.add_argument("--samples", type=int, default=4096)
    p.add_argument("--size", default="96x64")
    p.add_argument("--only", action="append")
    p.add_argument("--keep", action="store_true")
    options = p.parse_args()
    options.build = options.build.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    estimates, forecasts = [], []
    with tempfile.TemporaryDirectory() as folder:
        for name, path in scenes(options.build, pathlib.Path(folder)):
            if options.only and name not in options.only:
                continue
            raw = measure(options, name, path, pathlib.Path(folder))
            estimates += estimate_rows(name, looks_of(raw))
            forecasts += [(name, f) for f in forecasts_of(options, raw)]
    with open(options.out / "estimates.csv", "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["scene", "samples", "seeds", "error_ratio", "linear_ratio", "tone_ratio",
                      "rare_events"])
        out.writerows(estimates)
    with open(options.out / "forecasts.csv", "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["scene", "forecasts", "lower_bounds", "not_reached", "judged",
                      "median_ratio", "in_50", "in_80", "in_90", "in_95", "bounds_that_hold"])
        report(forecasts, out)
    plot(forecasts, options.out / "calibration.svg")


if __name__ == "__main__":
    main()
