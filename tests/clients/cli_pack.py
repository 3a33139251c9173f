#!/usr/bin/python3
"""glint packs a .gltf and the files it names into the GLB that it uploads."""
import base64
import json
import os
import struct
import tempfile

import cli
import tap
from fake_daemon import FakeDaemon

PNG = b"\x89PNG\r\n\x1a\n and the rest"


def save(folder, name, data):
    path = os.path.join(folder, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(data if isinstance(data, bytes) else json.dumps(data).encode())
    return path


def data_uri(data, media="application/octet-stream"):
    return f"data:{media};base64,{base64.b64encode(data).decode()}"


def parse_glb(glb):
    """(JSON, BIN) of a GLB whose lengths must add up."""
    magic, version, length = struct.unpack_from("<III", glb)
    assert (magic, version, length) == (0x46546C67, 2, len(glb))
    chunks, at = [], 12
    while at < len(glb):
        size, kind = struct.unpack_from("<II", glb, at)
        assert size % 4 == 0
        chunks.append((kind, glb[at + 8:at + 8 + size]))
        at += 8 + size
    assert at == len(glb) and [kind for kind, _ in chunks] == [0x4E4F534A, 0x004E4942][:len(chunks)]
    return json.loads(chunks[0][1]), chunks[1][1] if len(chunks) > 1 else b""


def put(path):
    """(finished process, uploaded GLB or None)"""
    with FakeDaemon() as daemon:
        run = cli.glint("put", path, server=daemon.url)
        puts = [r for r in daemon.requests if r.method == "PUT"]
        return run, parse_glb(puts[0].body) if puts else None


def view(gltf, binary, index):
    v = gltf["bufferViews"][index]
    assert v["buffer"] == 0
    return binary[v.get("byteOffset", 0):v.get("byteOffset", 0) + v["byteLength"]]


def test_buffers_and_images_become_one_chunk():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "a.bin", b"0123456789")
        save(folder, "maps/\u00e9 1.png", PNG)
        run, packed = put(save(folder, "s.gltf", {
            "asset": {"version": "2.0"},
            "buffers": [{"uri": "a.bin", "byteLength": 9},
                        {"uri": data_uri(b"abcdef"), "byteLength": 6}],
            "bufferViews": [{"buffer": 1, "byteOffset": 2, "byteLength": 3, "target": 34962},
                            {"buffer": 0, "byteLength": 9}],
            "images": [{"uri": "maps/%C3%A9%201.png", "name": "map"},
                       {"uri": data_uri(b"\xff\xd8\xff\xe0", "image/jpeg")},
                       {"bufferView": 1, "mimeType": "image/png"}],
            "accessors": [{"min": [0.1, -1e-7]}]}))
        assert run.returncode == 0, run.stderr
        gltf, binary = packed
        assert len(gltf["buffers"]) == 1 and gltf["buffers"][0].keys() == {"byteLength"}
        assert gltf["buffers"][0]["byteLength"] <= len(binary)
        assert view(gltf, binary, 0) == b"cde" and gltf["bufferViews"][0]["target"] == 34962
        assert view(gltf, binary, 1) == b"012345678"
        first, second, third = gltf["images"]
        assert first == {"name": "map", "bufferView": 2, "mimeType": "image/png"}
        assert second == {"bufferView": 3, "mimeType": "image/jpeg"}
        assert third == {"bufferView": 1, "mimeType": "image/png"}
        assert view(gltf, binary, 2) == PNG and view(gltf, binary, 3) == b"\xff\xd8\xff\xe0"
        assert gltf["accessors"] == [{"min": [0.1, -1e-7]}]


def test_a_file_without_buffers_has_no_chunk_for_them():
    with tempfile.TemporaryDirectory() as folder:
        run, packed = put(save(folder, "s.gltf", {"asset": {"version": "2.0"}}))
        assert run.returncode == 0 and packed == ({"asset": {"version": "2.0"}}, b"")


def test_every_fault_is_told_with_its_pointer_and_nothing_is_sent():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "short.bin", b"123")
        run, packed = put(save(folder, "s.gltf", {
            "buffers": [{"uri": "absent.bin", "byteLength": 3}, {"byteLength": 3},
                        {"uri": "short.bin", "byteLength": 4},
                        {"uri": "data:,hello", "byteLength": 5},
                        {"uri": "data:;base64,!!!!", "byteLength": 3},
                        {"uri": "short.bin", "byteLength": -1},
                        {"uri": "short.bin", "byteLength": 3}],
            "bufferViews": [{"buffer": 6, "byteOffset": 1, "byteLength": 3},
                            {"buffer": 7, "byteLength": 1}, {"byteLength": 1},
                            {"buffer": 6, "byteOffset": 0.5, "byteLength": 1},
                            {"buffer": 6, "byteLength": 3}],
            "images": [{"uri": "%zz.png"}, {"uri": "http://127.0.0.1/x.png"}]}))
        assert run.returncode == 1 and packed is None
        told = [line.split(": ")[1] for line in run.stderr.splitlines()]
        assert told == ([f"/buffers/{i}" for i in range(6)] + [f"/bufferViews/{i}" for i in range(4)]
                        + ["/images/0/uri", "/images/1/uri"])


def test_no_file_outside_the_directory_is_read():
    with tempfile.TemporaryDirectory() as folder:
        secret = save(folder, "secret.bin", b"secret")
        save(folder, "inner-not/secret.bin", b"secret")
        os.makedirs(os.path.join(folder, "inner"))
        os.symlink(secret, os.path.join(folder, "inner", "link.bin"))
        os.mkfifo(os.path.join(folder, "inner", "pipe.bin"))
        for uri in ["../secret.bin", "%2e%2e/secret.bin", "..%2Fsecret.bin", secret, "link.bin",
                    "./x/../../secret.bin", f"file://{secret}", "../inner-not/secret.bin", ".",
                    "pipe.bin", "/dev/zero", "secret.bin%00", ""]:
            run, packed = put(save(folder, "inner/s.gltf",
                                   {"buffers": [{"uri": uri, "byteLength": 1}]}))
            assert run.returncode == 1 and packed is None, uri
            assert "/buffers/0: " in run.stderr, (uri, run.stderr)


def test_what_is_no_gltf_is_refused():
    with tempfile.TemporaryDirectory() as folder:
        for text in [b"", b"[]", b"{", b"glTF", b"\xff" * 64, b"[" * 100000]:
            run, packed = put(save(folder, "s.gltf", text))
            assert run.returncode == 1 and packed is None, text[:10]
        for odd in [{"buffers": 1}, {"images": {"a": 1}}, {"bufferViews": [1], "buffers": [[]]},
                    {"images": [{"uri": 3}, 4]}]:
            run, _ = put(save(folder, "s.gltf", odd))
            assert run.returncode in (0, 1), odd


def test_links_and_relative_names_inside_the_directory_are_followed():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "sub/a.bin", b"abcd")
        os.symlink("sub/a.bin", os.path.join(folder, "b.bin"))
        for uri in ["sub/a.bin", "./sub/../b.bin", "b.bin"]:
            path = save(folder, "s.gltf", {"buffers": [{"uri": uri, "byteLength": 4}],
                                           "bufferViews": [{"buffer": 0, "byteLength": 4}]})
            run, packed = put(path)
            assert run.returncode == 0 and view(*packed, 0) == b"abcd", (uri, run.stderr)


def test_the_chess_set_packs_with_all_its_textures():
    path = tap.scenes("chess", "chess_set_1k.gltf")
    run, packed = put(path)
    assert run.returncode == 0, run.stderr
    with open(path, encoding="utf-8") as file:
        source = json.load(file)
    gltf, binary = packed
    for before, after in zip(source["images"], gltf["images"]):
        with open(os.path.join(os.path.dirname(path), before["uri"]), "rb") as file:
            assert view(gltf, binary, after["bufferView"]) == file.read()
    assert gltf["meshes"] == source["meshes"] and gltf["nodes"] == source["nodes"]


if __name__ == "__main__":
    tap.main()
