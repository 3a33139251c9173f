#!/usr/bin/python3
"""glint sends a .gltf or .obj with the files that it names as one form."""
import base64
import email.parser
import email.policy
import json
import os
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


def put(path):
    """(finished process, {file name: bytes}, or the body where it is no form, or None)"""
    with FakeDaemon() as daemon:
        run = cli.glint("put", path, server=daemon.url)
        puts = [r for r in daemon.requests if r.method == "PUT"]
    if not puts:
        return run, None
    kind = puts[0].headers["Content-Type"]
    if not kind.startswith("multipart/form-data"):
        return run, (kind, puts[0].body)
    parser = email.parser.BytesParser(policy=email.policy.HTTP)
    message = parser.parsebytes(f"Content-Type: {kind}\r\n\r\n".encode() + puts[0].body)
    return run, {part.get_filename(): part.get_payload(decode=True) for part in message.iter_parts()}


def test_a_gltf_goes_with_its_buffers_and_images():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "a.bin", b"0123456789")
        save(folder, "maps/1 2.png", PNG)
        scene = {"asset": {"version": "2.0"},
                 "buffers": [{"uri": "a.bin", "byteLength": 9}, {"uri": "a.bin", "byteLength": 4},
                             {"uri": "data:;base64," + base64.b64encode(b"x").decode()}],
                 "images": [{"uri": "maps/1%202.png"}, {"bufferView": 1}]}
        run, files = put(save(folder, "s.gltf", scene))
        assert run.returncode == 0, run.stderr
        assert files.keys() == {"s.gltf", "a.bin", "maps/1 2.png"}
        assert json.loads(files["s.gltf"]) == scene
        assert files["a.bin"] == b"0123456789" and files["maps/1 2.png"] == PNG


def test_a_gltf_that_names_no_file_goes_alone():
    with tempfile.TemporaryDirectory() as folder:
        run, sent = put(save(folder, "s.gltf", {"asset": {"version": "2.0"}}))
        assert run.returncode == 0
        assert sent == ("model/gltf+json", b'{"asset": {"version": "2.0"}}')


def test_every_file_that_is_missing_is_told_with_its_pointer_and_nothing_is_sent():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "there.bin", b"123")
        run, sent = put(save(folder, "s.gltf", {
            "buffers": [{"uri": "absent.bin"}, {"uri": "there.bin"}, {"uri": "a%0"}],
            "images": [{"uri": "%zz.png"}, {"uri": "http://127.0.0.1/x.png"}]}))
        assert run.returncode == 1 and sent is None
        told = [line.split(": ")[1] for line in run.stderr.splitlines()]
        assert told == ["/buffers/0/uri", "/buffers/2/uri", "/images/0/uri", "/images/1/uri"]


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
            run, sent = put(save(folder, "inner/s.gltf", {"buffers": [{"uri": uri}]}))
            assert run.returncode == 1 and sent is None, uri
            assert "/buffers/0/uri: " in run.stderr, (uri, run.stderr)
            run, sent = put(save(folder, "inner/s.obj", f"mtllib {uri}\nf 1 2 3\n".encode()))
            assert run.returncode == 0 and sent[0] == "model/obj", uri


def test_what_is_no_gltf_is_refused():
    with tempfile.TemporaryDirectory() as folder:
        for text in [b"", b"[]", b"{", b"glTF", b"\xff" * 64, b"[" * 100000]:
            run, sent = put(save(folder, "s.gltf", text))
            assert run.returncode == 1 and sent is None, text[:10]
        for odd in [{"buffers": 1}, {"images": {"a": 1}}, {"buffers": [[]]},
                    {"images": [{"uri": 3}, 4]}]:
            run, _ = put(save(folder, "s.gltf", odd))
            assert run.returncode == 0, odd


def test_links_and_relative_names_inside_the_directory_are_followed():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "sub/a.bin", b"abcd")
        os.symlink("sub/a.bin", os.path.join(folder, "b.bin"))
        for uri in ["sub/a.bin", "./sub/../b.bin", "b.bin"]:
            run, files = put(save(folder, "s.gltf", {"buffers": [{"uri": uri}]}))
            assert run.returncode == 0 and files[uri] == b"abcd", (uri, run.stderr)


def test_an_obj_goes_with_its_libraries_and_their_pictures():
    with tempfile.TemporaryDirectory() as folder:
        save(folder, "my paint.mtl",
             b"newmtl a\nKd 1 1 1\nmap_Kd -s 2 2 -o 1 1 tex\\red paint.png\nmap_Ke absent.png\n"
             b"bump -bm 0.5 n.png\n")
        save(folder, "second.mtl", b"newmtl b\n")
        save(folder, "tex/red paint.png", PNG)
        save(folder, "n.png", PNG)
        run, files = put(save(folder, "s.obj", b"mtllib my paint.mtl\r\n mtllib no.mtl second.mtl\n"))
        assert run.returncode == 0, run.stderr
        assert files.keys() == {"s.obj", "my paint.mtl", "second.mtl", "tex/red paint.png", "n.png"}


def test_an_obj_without_libraries_goes_alone():
    with tempfile.TemporaryDirectory() as folder:
        for text in (b"v 0 0 0\n", b"mtllib absent.mtl\n", b""):
            run, sent = put(save(folder, "s.obj", text))
            assert run.returncode == 0 and sent == ("model/obj", text)


def test_the_chess_set_goes_with_all_its_textures():
    path = tap.scenes("chess", "chess_set_1k.gltf")
    run, files = put(path)
    assert run.returncode == 0, run.stderr
    with open(path, encoding="utf-8") as file:
        source = json.load(file)
    for image in source["images"]:
        with open(os.path.join(os.path.dirname(path), image["uri"]), "rb") as file:
            assert files[image["uri"]] == file.read()


if __name__ == "__main__":
    tap.main()
