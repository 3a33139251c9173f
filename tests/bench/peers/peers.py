#!/usr/bin/python3
"""peers.py - CPU seconds to equal error, glint beside other renderers, in one run.

    tests/bench/run peers [--scenes cornell,glossy,...] [--renderers glint,cycles-debian,...]
        [--resolution 256] [--targets 0.03,0.01,0.003,0.001] [--rounds 5] [--seconds 20]
        [--reference-seconds 120] [--bounces 8] [--cache DIR] [--out DIR]

Every renderer keeps a scene resident; rounds take them in turn. Cost is user CPU time of rendering:
the slope over several sample counts, so that starting, reading and building are not in it. Error
is relative to the renderer's own reference, whose remaining error, known from its two halves, is
taken off. A renderer whose reference differs from ours is shown and not counted as beaten.
--seconds is what the largest count of a renderer and round may take, --reference-seconds the same
for each half of a reference; references stay in --cache.
"""
import argparse
import json
import math
import os
import platform
import subprocess
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import numpy as np

import crews
import measure
import report
import worlds

PILOT = 16         # samples of a pixel
LEAST, MOST = 4, 1 << 16
REFERENCE_SEEDS = 900001, 900002


def power_of_two(x, least=LEAST, most=MOST):
    return int(min(max(2 ** round(np.log2(max(x, 1))), least), most))


def say(*words):
    print("#", *words, file=sys.stderr, flush=True)


def warm_up(crew):
    """Compiles, builds and fills caches; seconds of a sample of each pixel."""
    crew.render(LEAST, 1, measure.read)
    _, few, least = crew.render(LEAST, 2, measure.read)
    _, more, most = crew.render(PILOT, 3, measure.read)
    return max((more - few) / max(most - least, 1), 1e-6)


def reference(crew, key, per_sample, o):
    """{"mean", "floor", "floor_trimmed", "noise", "samples"}: two halves of other seeds than the rounds have."""
    path = os.path.join(o.cache, f"{key}-{crew.name}.npz")
    if os.path.exists(path):
        with np.load(path) as kept:
            return {"mean": kept["mean"], "samples": int(kept["samples"]),
                    **{k: float(kept[k]) for k in ("floor", "floor_trimmed", "noise")}}
    n = power_of_two(o.reference_seconds / per_sample)
    say(f"{crew.name}: reference of 2 x {n} samples")
    a, b = (crew.render(n, seed, measure.read)[0] for seed in REFERENCE_SEEDS)
    floor, trimmed = measure.floor_of(a, b)
    made = {"mean": (a + b) / 2, "floor": floor, "floor_trimmed": trimmed, "samples": 2 * n,
            "noise": measure.block_noise(a, b)}
    np.savez_compressed(path, **made)
    return made


def counts_of(crew, made, per_sample, o):
    """Three counts, of which the largest reaches the smallest target or the bound of seconds."""
    image, _, _ = crew.render(PILOT, 4, measure.read)
    error = max(measure.relmse(image, made["mean"])[0] - made["floor"], 1e-9)
    wanted = PILOT * error / min(o.targets)
    top = power_of_two(min(wanted, o.seconds / per_sample), 4 * LEAST)
    return sorted({max(top >> k, LEAST) for k in (0, 2, 4)})


def one_round(crew, counts, made, seed):
    out = {"counts": [], "user": [], "relmse": [], "trimmed": []}
    for k, n in enumerate(counts):
        image, user, taken = crew.render(n, seed * 64 + k, measure.read)
        error, trimmed = measure.relmse(image, made["mean"])
        out["counts"].append(taken)
        out["user"].append(user)
        out["relmse"].append(error)
        out["trimmed"].append(trimmed)
    return out


def prepare(names, key, folder, o):
    """{name: {"crew", "made", "counts", "rounds", "version"}} and {name: why it is not there}."""
    there, missing = {}, {}
    for name in names:
        crew = None
        try:
            crew = crews.open_crew(name, o.tools, folder, (o.resolution, o.resolution), o.bounces)
            per_sample = warm_up(crew)
            made = reference(crew, key, per_sample, o)
            there[name] = {"crew": crew, "made": made, "rounds": [], "version": crew.version,
                           "counts": counts_of(crew, made, per_sample, o)}
            say(f"{name}: {o.resolution ** 2 / per_sample / 1e6:.3f} Msamples/s, "
                f"counts {there[name]['counts']}, floor {made['floor']:.2g}")
        except (crews.Missing, OSError, ValueError, KeyError) as why:
            missing[name] = str(why) or repr(why)
            say(f"{name} cannot be had: {missing[name]}")
            if crew:
                crew.close()
    return there, missing


def rates(rounds, pixels):
    """Samples of a pixel per CPU second, median over the rounds."""
    slopes = [measure.line(np.array(r["counts"], float), np.array(r["user"], float))[1]
              for r in rounds]
    return pixels / float(np.median(slopes))


def times(there, target, key):
    """{name: {"seconds": [of each round], "extrapolated", "limited"}}"""
    out = {}
    for name, t in there.items():
        floor = t["made"]["floor" if key == "relmse" else "floor_trimmed"]
        seconds, beyond = measure.rounds_to(target, t["rounds"], floor, key)
        out[name] = {"seconds": seconds.tolist(), "median": float(np.median(seconds)),
                     "extrapolated": beyond, "limited": floor > .25 * target}
    return out


def verdict(reached, agreed):
    """Ours over the best of the peers that render the same."""
    peers = [n for n in reached if n != "glint" and agreed.get(n, {}).get("same")]
    if "glint" not in reached or not peers:
        return None
    best = min(peers, key=lambda n: reached[n]["median"])
    return {"best": best, **measure.interval(np.array(reached["glint"]["seconds"]),
                                             np.array(reached[best]["seconds"]))}


def run_rounds(there, missing, o):
    """Every renderer once a round, in opposite order every other time; one that ends is missing."""
    for k in range(o.rounds):
        for n in list(there) if k % 2 == 0 else list(there)[::-1]:
            t = there[n]
            try:
                t["rounds"].append(one_round(t["crew"], t["counts"], t["made"], 100 + k))
            except (crews.Missing, OSError, ValueError) as why:
                missing[n] = f"in round {k}: {why}"
                there.pop(n)["crew"].close()


def as_data(name, there, missing, agreed, o):
    out = {"scene": name, "missing": missing, "agreement": agreed, "renderers": {}, "targets": {}}
    for n, t in there.items():
        out["renderers"][n] = {"version": t["version"], "samples_per_second":
                               rates(t["rounds"], o.resolution ** 2), "floor": t["made"]["floor"],
                               "reference_samples": t["made"]["samples"], "rounds": t["rounds"]}
    for target in o.targets:
        reached = times(there, target, "relmse")
        out["targets"][f"{target:g}"] = {"reached": reached, "ratio": verdict(reached, agreed),
                                         "trimmed": verdict(times(there, target, "trimmed"), agreed)}
    return out


def scene_results(name, o):
    """What one scene gave, as plain data; None where it cannot be had."""
    folder = os.path.join(o.cache, "scenes", name)
    if not worlds.make(name, folder, o.build):
        say(f"{name}: its file is not under $GLINT_SCENES")
        return None
    say(f"== {name}")
    key = f"{name}-{worlds.fingerprint(folder)}-{o.resolution}-{o.bounces}-{o.reference_seconds:g}"
    there, missing = prepare(o.renderers, key, folder, o)
    try:
        run_rounds(there, missing, o)
    finally:
        for t in there.values():
            t["crew"].close()
    pictures = {n: t["made"]["mean"] for n, t in there.items()}
    noise = {n: t["made"]["noise"] for n, t in there.items()}
    agreed = {n: measure.agreement(pictures["glint"], picture, math.hypot(noise["glint"], noise[n]))
              for n, picture in pictures.items() if n != "glint" and "glint" in pictures}
    if pictures:
        report.sheet(os.path.join(o.out, f"{name}.jpg"), pictures, agreed)
    return as_data(name, there, missing, agreed, o)


def options():
    numbers = lambda text: [float(x) for x in text.split(",")]
    names = lambda text: text.split(",")
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    p.add_argument("--scenes", type=names, default=worlds.NAMES)
    p.add_argument("--renderers", type=names, default=list(crews.RENDERERS))
    p.add_argument("--resolution", type=int, default=256)
    p.add_argument("--targets", type=numbers, default=[.03, .01, .003, .001])
    p.add_argument("--rounds", type=int, default=5)
    p.add_argument("--seconds", type=float, default=20)
    p.add_argument("--reference-seconds", type=float, default=120)
    p.add_argument("--bounces", type=int, default=8)
    p.add_argument("--cache", default="peers-cache")
    p.add_argument("--out", default="peers")
    o = p.parse_args()
    o.build = os.environ.get("GLINT_BUILD", os.getcwd())
    o.tools = os.environ.get("GLINT_PEERS", os.path.join(o.build, "peers-tools"))
    for known, given in (worlds.NAMES, o.scenes), (crews.RENDERERS, o.renderers):
        unknown = [n for n in given if n not in known]
        if unknown:
            p.error(f"{', '.join(unknown)}: known are {', '.join(known)}")
    o.cache, o.out = os.path.abspath(o.cache), os.path.abspath(o.out)
    os.makedirs(o.cache, exist_ok=True)
    os.makedirs(o.out, exist_ok=True)
    return o


def commit():
    where = os.path.dirname(os.path.abspath(__file__))
    found = subprocess.run(["git", "-C", where, "rev-parse", "--short", "HEAD"],
                           capture_output=True, text=True, check=False)
    return found.stdout.strip() or "unknown"


def main():
    o = options()
    start, results = time.time(), []
    for name in o.scenes:
        made = scene_results(name, o)
        if made:
            results.append(made)
            report.write(o.out, results, o)
    last = {"bench": "peers", "resolution": o.resolution, "bounces": o.bounces, "rounds": o.rounds,
            "commit": commit(), "cpu": report.cpu(), "python": platform.python_version(),
            "wall_seconds": round(time.time() - start), "scenes": report.summary(results)}
    print(json.dumps(last))
    return 0 if results else 1


if __name__ == "__main__":
    sys.exit(main())
