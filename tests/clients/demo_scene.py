#!/usr/bin/python3
"""The demo scene is sound: always the same, references that resolve, closed glass bodies."""
import json
import os
import subprocess
from collections import Counter

import tap

PROGRAM = os.path.join(os.environ.get("GLINT_BUILD", tap.build()), "glint-demo-scene")


def write():
    return subprocess.run([PROGRAM], capture_output=True, check=True).stdout


SCENE = json.loads(write()) if os.access(PROGRAM, os.X_OK) else tap.skip_all(f"no {PROGRAM}")


def points(flat):
    return [tuple(flat[i:i + 3]) for i in range(0, len(flat), 3)]


def triangles(mesh):
    """Corners of each triangle, equal places being equal."""
    place = points(mesh["positions"])
    return [[place[i] for i in corner] for corner in points(mesh["indices"])]


def material_of(instance):
    return SCENE["materials"][instance["material"]]


def test_it_is_the_same_every_time():
    assert write() == write()


def test_every_reference_resolves():
    for name, instance in SCENE["instances"].items():
        assert instance["mesh"] in SCENE["meshes"], name
        assert instance["material"] in SCENE["materials"], name
        assert instance["object"] == name and name in SCENE["objects"]


def test_there_are_hundreds_of_named_things_in_material_groups_and_assets():
    assert len(SCENE["instances"]) > 700
    used = Counter(i["material"] for i in SCENE["instances"].values())
    assert len(used) > 30
    assets = Counter(o["asset"] for o in SCENE["objects"].values())
    assert {"bead", "cube", "rod", "pebble", "ring", "cone", "glass", "metal", "set"} == set(assets)


def test_there_are_rough_and_clear_glass_and_rough_and_perfect_metals():
    glass = {m["roughness"] for m in SCENE["materials"].values() if m.get("transmission")}
    metal = {m["roughness"] for m in SCENE["materials"].values() if m.get("metallic")}
    assert 0 in glass and any(0.1 <= r <= 0.4 for r in glass)
    assert 0 in metal and any(0.1 <= r <= 0.4 for r in metal)


def test_meshes_together_stay_small():
    own = [m for m in SCENE["meshes"].values() if "indices" in m]
    assert sum(len(m["indices"]) // 3 for m in own) < 300_000


def test_bodies_are_closed_and_turned_outwards():
    """Each edge is used once in each direction, and the signed volume is positive."""
    open_on_purpose = {"shelves", "floor", "wall"}
    for name, mesh in SCENE["meshes"].items():
        if "positions" not in mesh or name in open_on_purpose:
            continue
        edges, volume = Counter(), 0
        for a, b, c in triangles(mesh):
            edges.update([(a, b), (b, c), (c, a)])
            volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                       + a[2] * (b[0] * c[1] - b[1] * c[0]))
        assert volume > 0, name
        for (a, b), count in edges.items():
            assert count == 1 and edges[b, a] == 1, (name, a, b)


def test_normals_are_unit_and_on_the_side_of_their_triangle():
    for name, mesh in SCENE["meshes"].items():
        if "positions" not in mesh:
            continue
        normals, place = points(mesh["normals"]), points(mesh["positions"])
        for n in normals:
            assert abs(sum(x * x for x in n) - 1) < 1e-4, name
        for corner in points(mesh["indices"]):
            a, b, c = (place[i] for i in corner)
            u, v = ([q[k] - a[k] for k in range(3)] for q in (b, c))
            across = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            for i in corner:
                assert sum(x * y for x, y in zip(across, normals[i])) > 0, (name, corner)


def reach(instance):
    """Radius of the circle about the instance's origin that holds it, seen from above."""
    mesh, (x, _, z) = SCENE["meshes"][instance["mesh"]], instance["transform"]["scale"]
    if "primitive" in mesh:
        return max(x, z)
    return max(((x * p[0]) ** 2 + (z * p[2]) ** 2) ** 0.5 for p in points(mesh["positions"]))


def test_small_things_stand_in_rows_without_touching_each_other():
    shelves = {}
    for name, instance in SCENE["instances"].items():
        shelf, _, thing = name.partition("/")
        if shelf.startswith("shelf") and thing:
            shelves.setdefault(shelf, []).append((name, instance))
    assert len(shelves) == 13
    for row in shelves.values():
        for (name, one), (other, two) in zip(row, row[1:]):
            (x, _, z), (x2, _, z2) = (i["transform"]["translation"] for i in (one, two))
            assert (x - x2) ** 2 + (z - z2) ** 2 > (reach(one) + reach(two)) ** 2, (name, other)


if __name__ == "__main__":
    tap.main()
