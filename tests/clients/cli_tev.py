#!/usr/bin/python3
"""glint watch --tev and render --tev against a viewer that checks every byte it is sent."""
import contextlib
import json
import os
import socket
import struct
import sys
import tempfile
import threading

import cli
import tap

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "http"))
from daemon import PATIENCE, ROOM, Daemon  # noqa: E402

SIZE = (200, 136)  # three by four tiles of 64x64, cut at the edges
TILES = 12


def text(packet):
    value, _, rest = packet.partition(b"\0")
    return value.decode(), rest


def texts(packet):
    (count,), packet = struct.unpack("<i", packet[:4]), packet[4:]
    names = []
    for _ in range(count):
        name, packet = text(packet)
        names.append(name)
    return names, packet


class Image:
    def __init__(self, width, height, channels):
        self.width, self.height = width, height
        self.planes = {name: [None] * (width * height) for name in channels}

    def update(self, channels, rect, values):
        x, y, w, h = rect
        for c, name in enumerate(channels):
            for row in range(h):
                at = (y + row) * self.width + x
                self.planes[name][at:at + w] = values[(c * h + row) * w:(c * h + row + 1) * w]

    def complete(self):
        return all(None not in plane for plane in self.planes.values())


class Viewer(threading.Thread):
    """tev as far as it is talked to. `leave_after`: it closes the first connection after that many
    packets; `reads`: whether it takes anything at all."""

    def __init__(self, port=0, leave_after=None, reads=True):
        super().__init__(daemon=True)
        self.listener = socket.create_server(("127.0.0.1", port))
        self.port = self.listener.getsockname()[1]
        self.address = f"127.0.0.1:{self.port}"
        self.leave_after, self.reads = leave_after, reads
        self.images, self.updates, self.log, self.fault = {}, [], [], None
        self.connections = 0
        self.leave = threading.Event()

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *error):
        self.leave.set()
        with contextlib.suppress(OSError):
            self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.join(PATIENCE)
        assert not self.fault, self.fault

    def run(self):
        try:
            while not self.leave.is_set():
                connection, _ = self.listener.accept()
                self.connections += 1
                with connection:
                    self.serve(connection)
        except OSError:
            pass
        except Exception as fault:  # told to the test
            self.fault = repr(fault)

    def serve(self, connection):
        if not self.reads:
            self.leave.wait(PATIENCE)
            return
        with connection.makefile("rb") as stream:
            while head := stream.read(4):
                size = struct.unpack("<I", head)[0]
                body = stream.read(size - 4)
                if len(body) < size - 4:
                    return  # it was cut, so it never came
                self.take(body[0], body[1:])
                if self.connections == 1 and len(self.log) == self.leave_after:
                    return

    def take(self, kind, packet):
        self.log.append(kind)
        if kind == 4:
            name, packet = text(packet[1:])
            width, height = struct.unpack("<ii", packet[:8])
            channels, packet = texts(packet[8:])
            assert name not in self.images and not packet
            self.images[name] = Image(width, height, channels)
        elif kind == 6:
            name, packet = text(packet[1:])
            channels, packet = texts(packet)
            n, rect = len(channels), struct.unpack("<iiii", packet[:16])
            offsets = struct.unpack(f"<{n}q", packet[16:16 + 8 * n])
            strides = struct.unpack(f"<{n}q", packet[16 + 8 * n:16 + 16 * n])
            pixels = rect[2] * rect[3]
            assert offsets == tuple(c * pixels for c in range(n)) and set(strides) == {1}
            values = struct.unpack(f"<{n * pixels}f", packet[16 + 16 * n:])
            self.images[name].update(channels, rect, values)
            self.updates.append((name, rect))
        else:
            assert kind == 2, kind
            name, packet = text(packet)
            assert not packet and self.images.pop(name)


def planes_of(exr):
    """{channel: floats} of the file's beauty."""
    try:
        import OpenImageIO as oiio
    except ImportError as missing:
        raise tap.Skip("no OpenImageIO") from missing
    with tempfile.NamedTemporaryFile(suffix=".exr") as file:
        file.write(exr)
        file.flush()
        image = oiio.ImageBuf(file.name)
        pixels = image.get_pixels(oiio.FLOAT)
        names = image.spec().channelnames
        return {name: pixels[..., names.index(name)].ravel().tolist() for name in "RGBA"}


def assert_shows(viewer, job, exr):
    image, planes = viewer.images[job], planes_of(exr)
    assert (image.width, image.height) == SIZE and list(image.planes) == list("RGBA")
    for name, plane in planes.items():
        assert image.planes[name] == plane, name


def submit(daemon, samples, **job):
    return daemon.submit(scene="room", resolution=SIZE, stop={"samples": samples}, **job)


@contextlib.contextmanager
def house():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        yield daemon


def watch(daemon, job, address):
    return cli.glint("watch", job, "--tev", address, "--progress", "none", server=daemon.url)


def test_the_viewer_has_the_frame_when_the_job_has_ended():
    with house() as daemon, Viewer() as viewer:
        job = submit(daemon, 48)
        run = watch(daemon, job, viewer.address)
        assert run.returncode == 0, run.stderr
        viewer.__exit__()
        assert_shows(viewer, job, daemon.frame(job, "&outputs=beauty"))
        assert viewer.log[0] == 4 and viewer.connections == 1


def test_each_tile_of_a_finished_job_is_sent_once():
    with house() as daemon, Viewer() as viewer:
        job = submit(daemon, 2)
        frame = daemon.frame(job, "&outputs=beauty")
        assert watch(daemon, job, viewer.address).returncode == 0
        viewer.__exit__()
        assert_shows(viewer, job, frame)
        assert len(viewer.updates) == len(set(viewer.updates)) == TILES


def test_without_a_viewer_the_job_is_watched_all_the_same():
    with house() as daemon, cli.Silence() as url:
        job = submit(daemon, 4)
        run = watch(daemon, job, url.removeprefix("http://"))
        assert run.returncode == 0, run.stderr


def test_a_viewer_that_reads_nothing_holds_nobody_up():
    with house() as daemon, Viewer(reads=False) as viewer:
        job = submit(daemon, 64)
        run = watch(daemon, job, viewer.address)
        assert run.returncode == 0, run.stderr
        assert daemon.job(job)["state"] == "done"


def test_a_viewer_that_comes_back_gets_the_whole_image_anew():
    with house() as daemon, Viewer(leave_after=5) as viewer:
        job = submit(daemon, 1000000)
        process = cli.start("watch", job, "--tev", viewer.address, "--progress", "none",
                            server=daemon.url)
        daemon.until(job, lambda j: viewer.connections == 2 and job in viewer.images
                     and viewer.images[job].complete())
        daemon.delete(f"/v1/jobs/{job}")
        process.communicate(timeout=PATIENCE)
        viewer.__exit__()
        assert viewer.log[:6] == [4, 6, 6, 6, 6, 2] and viewer.log[6] == 4
        frame = daemon.get(f"/v1/jobs/{job}/frame.exr?outputs=beauty").body
        assert_shows(viewer, job, frame)


def test_render_shows_its_picture_too():
    with Viewer() as viewer, tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/room.json", "w", encoding="utf-8") as file:
            json.dump(ROOM, file)
        with house() as daemon:
            run = cli.glint("render", f"{folder}/room.json", "-o", f"{folder}/f.exr", "-n", 4,
                            "-r", "%dx%d" % SIZE, "--tev", viewer.address, server=daemon.url)
            assert run.returncode == 0, run.stderr
        viewer.__exit__()
        with open(f"{folder}/f.exr", "rb") as file:
            assert_shows(viewer, *viewer.images, file.read())


def test_an_address_that_is_none_is_wrong_usage():
    for address in ("localhost:x", ":1", "[::1", "a:1:2"):
        with cli.Silence() as url:
            run = cli.glint("watch", "job", "--tev", address, server=url)
            assert run.returncode == 64, (address, run.stderr)
            assert address in run.stderr


if __name__ == "__main__":
    tap.main()
