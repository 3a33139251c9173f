"""Scenes of every media type, in one file and in several; assets by hash."""
import base64
import hashlib
import json
import os
import signal
import struct
import threading
import time
import zlib

import tap
from daemon import PATIENCE, ROOM, Daemon, form, triangle_glb

TRIANGLE = struct.pack("<9f", -1, -1, 0, 1, -1, 0, 0, 1, 0)
OBJ = b"mtllib paint.mtl\no sail\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n" \
      b"usemtl cloth\nf 1/1 2/2 3/3\n"
MTL = b"newmtl cloth\nKd 0.5 0.25 0.125\nmap_Ke tex/red.png\n"
STL = b"solid wedge\nfacet normal 0 0 1\nouter loop\nvertex -1 -1 0\nvertex 1 -1 0\nvertex 0 1 0\n" \
      b"endloop\nendfacet\nendsolid wedge\n"
PLY = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n" \
      b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" \
      b"-1 -1 0\n1 -1 0\n0 1 0\n3 0 1 2\n"


def png(width=2, height=1, pixel=b"\xff\0\0"):
    """An image of one colour."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))
    rows = (b"\0" + pixel * width) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def gltf(buffer="tri%20angle.bin", image=None):
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "sail"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"name": "cloth"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [-1, -1, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": buffer}],
    }
    if image:
        scene["images"] = [{"uri": image}]
        scene["textures"] = [{"source": 0}]
        scene["materials"][0]["emissiveTexture"] = {"index": 0}
        scene["materials"][0]["emissiveFactor"] = [1, 1, 1]
    return json.dumps(scene).encode()


def put(daemon, body, kind, name="thing"):
    return daemon.ask("PUT", f"/v1/scenes/{name}", body, {"Content-Type": kind} if kind else {})


def put_form(daemon, files):
    return put(daemon, *form(files))


def native(daemon, name="thing"):
    return daemon.get(f"/v1/scenes/{name}?format=native").json()


def name_of(body):
    return hashlib.sha256(body).hexdigest()


def test_each_type_in_one_file_gives_the_same_triangle():
    data = "data:application/octet-stream;base64," + base64.b64encode(TRIANGLE).decode()
    with Daemon() as daemon:
        binary = b"\0" * 80 + struct.pack("<I", 1) + b"\0" * 12 + TRIANGLE + b"\0\0"
        for body, kind in ((triangle_glb(), "model/gltf-binary"), (gltf(data), "model/gltf+json"),
                           (OBJ, "model/obj"), (STL, "model/stl"), (binary, "model/stl"),
                           (PLY, "application/ply"), (PLY, "application/octet-stream"),
                           (PLY, None), (gltf(data), None)):
            answer = put(daemon, body, kind)
            assert answer.status in (200, 201), (kind, answer.body)
            assert answer.json()["triangles"] == 1, kind
        assert daemon.frame(daemon.submit(scene="thing", stop={"samples": 1}))


def test_a_gltf_with_its_files_is_one_form():
    with Daemon() as daemon:
        answer = put_form(daemon, {"sail.gltf": gltf(image="tex/red.png"),
                                   "tri angle.bin": TRIANGLE, "tex/red.png": png(),
                                   "notes.txt": b"unused"})
        assert answer.status == 201, answer.body
        assert any("notes.txt" in w for w in answer.json()["warnings"])
        again = put_form(daemon, {"sail.gltf": gltf(image="tex/red.png"),
                                  "tri angle.bin": TRIANGLE, "tex/red.png": png()})
        assert again.json()["revision"] == answer.json()["revision"]
        assert not any("notes.txt" in w for w in again.json()["warnings"])
        image, = native(daemon)["images"].values()
        assert (image["width"], image["height"], image["asset"]) == (
            2, 1, name_of(b"\xff\0\0\xff" * 2))


def test_folders_that_a_sender_leaves_out_do_not_matter():
    with Daemon() as daemon:
        assert put_form(daemon, {"a.gltf": gltf("deep/er/b.bin"), "b.bin": TRIANGLE}).status == 201
        assert put_form(daemon, {"a.gltf": gltf("deep/b.bin"), "x/b.bin": TRIANGLE,
                                 "y/b.bin": TRIANGLE}).status == 422  # which?


def test_every_file_that_is_missing_is_named_at_its_place():
    with Daemon() as daemon:
        answer = put_form(daemon, {"sail.gltf": gltf(image="tex/red.png")})
        assert answer.status == 422
        assert answer.pointers() == ["/buffers/0/uri", "/images/0/uri"]
        answer = put(daemon, gltf(image="red.png"), "model/gltf+json")
        assert answer.status == 422
        assert answer.pointers() == ["/buffers/0/uri", "/images/0/uri"]
        answer = put_form(daemon, {"sail.obj": OBJ})
        assert answer.status == 422 and b"paint.mtl" in answer.body
        answer = put_form(daemon, {"sail.obj": OBJ, "paint.mtl": MTL})
        assert answer.status == 422 and b"paint.mtl, line 3" in answer.body
        assert b"tex/red.png" in answer.body


def test_no_path_leads_out_of_the_form():
    with Daemon() as daemon:
        for uri in ("../tri.bin", "/etc/passwd", "file:///etc/passwd", "a/../../tri.bin",
                    "%2e%2e/tri.bin", "http://localhost/tri.bin"):
            answer = put_form(daemon, {"sail.gltf": gltf(uri), "tri.bin": TRIANGLE,
                                       "passwd": TRIANGLE})
            assert answer.status == 422 and answer.pointers() == ["/buffers/0/uri"], uri


def test_an_obj_keeps_its_names_and_its_materials():
    with Daemon() as daemon:
        answer = put_form(daemon, {"sail.obj": OBJ, "paint.mtl": MTL, "tex/red.png": png()})
        assert answer.status == 201, answer.body
        scene = native(daemon)
        assert [o.get("name", i) for i, o in scene["objects"].items()] == ["sail"]
        material = scene["materials"]["cloth"]
        assert material["base_color"] == [0.5, 0.25, 0.125]
        assert material["emission"] == [1, 1, 1]  # the map alone says how much
        assert scene["images"][material["emission_texture"]["image"]]["width"] == 2


def test_forms_that_are_none_are_refused():
    body, kind = form({"sail.gltf": gltf(), "tri angle.bin": TRIANGLE})
    two, two_kind = form({"a.obj": OBJ, "b.obj": OBJ})
    none, none_kind = form({"a.png": png()})
    with Daemon() as daemon:
        assert put(daemon, body, "multipart/form-data").status == 415
        assert put(daemon, body, "multipart/form-data; boundary=").status == 415
        assert put(daemon, body, f"multipart/form-data; boundary={'x' * 71}").status == 415
        assert put(daemon, body, "multipart/form-data; boundary=other").status == 400
        assert put(daemon, two, two_kind).status == 422
        assert put(daemon, none, none_kind).status == 422
        for size in range(0, len(body) - 6, 7):
            assert put(daemon, body[:size], kind).status in (400, 422), size
        unnamed = body.replace(b'; filename="tri angle.bin"', b"")
        assert put(daemon, unnamed, kind).status == 400


def test_a_type_that_is_not_taken_is_415_and_names_those_that_are():
    with Daemon() as daemon:
        for kind in ("text/plain", "model/vnd.usdz+zip", "application/x-www-form-urlencoded"):
            answer = put(daemon, OBJ, kind)
            assert answer.status == 415, kind
            for accepted in ("model/gltf-binary", "model/gltf+json", "model/obj", "model/stl",
                             "application/ply", "application/json", "multipart/form-data"):
                assert accepted in answer.headers["Accept"], accepted
        answer = put(daemon, OBJ, None)  # the bytes do not tell
        assert answer.status == 415 and b"model/obj" in answer.body


def test_a_body_that_is_something_else_than_its_type_says_is_refused():
    with Daemon() as daemon:
        for body, kind in ((png(), "model/gltf-binary"), (triangle_glb(), "model/obj"),
                           (triangle_glb(), "application/json"), (PLY, "model/stl"),
                           (gltf(), "application/ply"), (b"PK\x03\x04" + b"\0" * 99, None)):
            answer = put(daemon, body, kind)
            assert answer.status == 415, (kind, answer.body)
            assert answer.json()["errors"][0]["detail"], kind


def test_required_compression_is_refused_by_its_name():
    with Daemon() as daemon:
        for name in ("KHR_draco_mesh_compression", "EXT_meshopt_compression"):
            scene = json.loads(gltf())
            scene["extensionsUsed"] = scene["extensionsRequired"] = [name]
            answer = put_form(daemon, {"a.gltf": json.dumps(scene).encode(),
                                       "tri angle.bin": TRIANGLE})
            assert answer.status == 422 and answer.pointers() == ["/extensionsRequired/0"]
            assert name in answer.json()["detail"]


def test_compression_with_something_to_fall_back_on_is_a_warning():
    with Daemon() as daemon:
        scene = json.loads(gltf())
        scene["extensionsUsed"] = ["KHR_draco_mesh_compression"]
        scene["meshes"][0]["primitives"][0]["extensions"] = {
            "KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
        answer = put_form(daemon, {"a.gltf": json.dumps(scene).encode(), "tri angle.bin": TRIANGLE})
        assert answer.status == 201, answer.body
        assert any("KHR_draco_mesh_compression" in w for w in answer.json()["warnings"])
        scene = json.loads(gltf())
        scene["buffers"].append({"byteLength": 36, "extensions": {
            "EXT_meshopt_compression": {"fallback": True}}})
        scene["bufferViews"][0]["buffer"] = 1
        answer = put_form(daemon, {"a.gltf": json.dumps(scene).encode(), "tri angle.bin": TRIANGLE})
        assert answer.status == 422 and "EXT_meshopt_compression" in answer.json()["detail"]


# Assets

def test_an_asset_is_kept_under_the_hash_of_its_bytes():
    body = png()
    path = f"/v1/assets/{name_of(body)}"
    with Daemon() as daemon:
        assert daemon.get(path).status == 404 and daemon.ask("HEAD", path).status == 404
        assert daemon.ask("PUT", path, body + b"x").status == 422
        assert daemon.get(path).status == 404
        assert daemon.ask("PUT", path, body).status == 201
        assert daemon.ask("PUT", path, body, {"Content-Type": "image/png"}).status == 200
        assert daemon.ask("HEAD", path).status == 200
        assert daemon.get(path).json() == {"sha256": name_of(body), "bytes": len(body)}
        for name in ("x", "A" * 64, name_of(body)[:-1]):
            assert daemon.ask("PUT", f"/v1/assets/{name}", body).status == 422, name


def test_native_scenes_name_assets_of_pixels_pictures_and_meshes():
    pixels = bytes(range(16)) * 2  # 4x2 rgba8
    mesh = TRIANGLE + struct.pack("<3I", 0, 1, 2)
    picture = png()
    scene = {
        "images": {"raw": {"asset": name_of(pixels), "width": 4, "height": 2, "format": "rgba8"},
                   "file": {"asset": name_of(picture)}},
        "materials": {"m": {"base_color_texture": {"image": "raw"},
                            "emission_texture": {"image": "file"}, "emission": [1, 1, 1]}},
        "meshes": {"t": {"asset": name_of(mesh), "vertices": 3, "triangles": 1}},
        "instances": {"i": {"mesh": "t", "material": "m"}},
    }
    with Daemon() as daemon:
        answer = put(daemon, json.dumps(scene), "application/json")
        assert answer.status == 422 and "/meshes/t/asset" in answer.pointers()
        for body in (pixels, mesh, picture):
            assert daemon.ask("PUT", f"/v1/assets/{name_of(body)}", body).status == 201
        answer = put(daemon, json.dumps(scene), "application/json")
        assert answer.status == 201, answer.body
        assert answer.json()["triangles"] == 1
        text = native(daemon)
        assert text["images"]["file"] == {"asset": name_of(b"\xff\0\0\xff" * 2), "width": 2,
                                          "height": 1, "format": "rgba8"}
        # what the daemon says of a scene is a scene, and its assets are there
        assert put(daemon, json.dumps(text), "application/json", "copy").json()["revision"] \
            == answer.json()["revision"]


def test_an_asset_that_an_import_made_goes_with_its_scene():
    with Daemon() as daemon:
        put(daemon, triangle_glb(), "model/gltf-binary")
        mesh, = native(daemon)["meshes"].values()
        path = f"/v1/assets/{mesh['asset']}"
        assert daemon.get(path).status == 200
        assert daemon.delete("/v1/scenes/thing").status == 204
        assert daemon.get(path).status == 404


# What a file can do to the process that reads it

def child_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as text:
        found = text.read().split()
    return int(found[0]) if found else None


def wait_for_child(pid):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        found = child_of(pid)
        if found:
            return found
    raise AssertionError("no import began")


def slow_gltf():
    """Pictures of one colour: small as a file, a second and more to decode."""
    scene = json.loads(gltf(image="0.png"))
    scene["images"] = [{"uri": f"{i}.png"} for i in range(4)]
    scene["textures"] = [{"source": i} for i in range(4)]
    scene["materials"] = [{"emissiveTexture": {"index": i}} for i in range(4)]
    big = png(9000, 9000)
    return form({"a.gltf": json.dumps(scene).encode(), "tri angle.bin": TRIANGLE,
                 **{f"{i}.png": big for i in range(4)}})


def test_an_import_that_dies_is_the_fault_of_its_file_and_a_line_in_the_log():
    body, kind = slow_gltf()
    with Daemon() as daemon:
        helper = child_of(daemon.process.pid)
        for ends, word in ((signal.SIGSEGV, "crashed on this file"), (signal.SIGKILL, "killed"),
                           (signal.SIGXCPU, "took longer")):
            answers = []
            asking = threading.Thread(target=lambda: answers.append(put(daemon, body, kind)))
            asking.start()
            os.kill(wait_for_child(helper), ends)
            asking.join()
            assert answers[0].status == 422, answers[0].body
            assert word in answers[0].json()["detail"], answers[0].body
            assert f"ended by signal {int(ends)}" in daemon.logged()
        assert daemon.get("/v1/scenes/thing").status == 404
        assert daemon.put("room", ROOM).status == 201


if __name__ == "__main__":
    tap.main()
