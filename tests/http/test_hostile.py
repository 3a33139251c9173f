"""Every file of the hostile corpora as a scene, an image or a job: a clear answer, and no harm done."""
import concurrent.futures
import hashlib
import json
import os
import re
import threading
import time
from urllib.parse import unquote

import tap
from daemon import PATIENCE, ROOM, Daemon, form

SECONDS = PATIENCE / 4  # of a loaded machine; what has no bound takes hours
BYTES = 1 << 30
ROOT = "hostile"

TYPES = {".glb": "model/gltf-binary", ".gltf": "model/gltf+json", ".obj": "model/obj",
         ".ply": "application/ply", ".stl": "model/stl", ".json": "application/json"}
PICTURES = (".png", ".jpg", ".webp", ".exr")
SQUARE = b"mtllib %s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl %s\nf 1 2 3\n"


def files(*folders):
    for folder in folders:
        for path, _, names in sorted(os.walk(tap.scenes(ROOT, folder))):
            yield from (os.path.join(path, name) for name in sorted(names))


def read(path):
    with open(path, "rb") as file:
        return file.read()


def uris(node):
    """Every "uri" and "mtllib" that a file names."""
    if isinstance(node, dict):
        for key, value in node.items():
            if key == "uri" and isinstance(value, str):
                yield value
            else:
                yield from uris(value)
    elif isinstance(node, list):
        for item in node:
            yield from uris(item)


def named(path, body):
    """The files beside `path` that it names and that are there: {name: bytes}."""
    found = []
    if path.endswith(".gltf"):
        try:
            found = [unquote(uri) for uri in uris(json.loads(body))]
        except (ValueError, RecursionError):
            pass
    elif path.endswith(".obj"):
        found = [name.decode(errors="replace").strip()
                 for name in re.findall(rb"^mtllib\s+(.+)$", body, re.M)]
    folder = os.path.dirname(path)
    inside = [name for name in found if name and ".." not in name and "\0" not in name
              and os.path.isfile(os.path.join(folder, name))]
    return {name: read(os.path.join(folder, name)) for name in inside}


class Answers:
    """Asks a daemon from two threads; keeps what came and how long it took."""

    def __init__(self, daemon):
        self.daemon, self.taken = daemon, {}

    def ask(self, label, *request):
        start = time.monotonic()
        answer = self.daemon.ask(*request)
        seconds = time.monotonic() - start
        assert seconds < SECONDS, f"{label}: {seconds:.1f} s"
        kind = answer.headers["Content-Type"]
        if answer.status >= 300:
            assert 400 <= answer.status < 500, (label, answer.status, answer.body)
            assert kind == "application/problem+json", (label, kind)
            problem = answer.json()
            assert problem["detail"] and problem["status"] == answer.status, (label, problem)
            assert answer.status not in (400, 422) or problem["errors"], (label, problem)
        self.taken[label] = answer
        return answer

    def scene(self, path):
        """As what its extension says, with the files that it names."""
        body, kind = read(path), TYPES.get(os.path.splitext(path)[1], "application/octet-stream")
        beside = named(path, body)
        if beside:
            body, kind = form({os.path.basename(path): body, **beside})
        return self.ask(path, "PUT", "/v1/scenes/hostile", body, {"Content-Type": kind})

    def picture(self, path):
        """As an image that a scene names by hash."""
        body = read(path)
        name = hashlib.sha256(body).hexdigest()
        if not body:
            return self.ask(path, "PUT", f"/v1/assets/{name}", body)
        assert self.ask(path, "PUT", f"/v1/assets/{name}", body).status in (200, 201)
        scene = {**ROOM, "images": {"picture": {"asset": name}},
                 "environment": {"image": "picture"}}
        return self.ask(path, "PUT", "/v1/scenes/hostile", json.dumps(scene),
                        {"Content-Type": "application/json"})

    def library(self, path):
        """As the materials of a triangle."""
        first = re.search(rb"^newmtl\s+(.+?)\s*$", read(path), re.M)
        triangle = SQUARE % (os.path.basename(path).encode(), first[1] if first else b"none")
        body, kind = form({"a.obj": triangle, os.path.basename(path): read(path)})
        return self.ask(path, "PUT", "/v1/scenes/hostile", body, {"Content-Type": kind})

    def job(self, path):
        return self.ask("job " + path, "POST", "/v1/jobs", read(path),
                        {"Content-Type": "application/json"})

    def all(self, method, paths):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            return dict(zip(paths, pool.map(method, paths)))


class Memory:
    """The most that the daemon and the processes under it hold together, sampled."""

    def __init__(self, daemon):
        self.pid, self.peak, self.done = daemon.process.pid, 0, threading.Event()
        self.thread = threading.Thread(target=self.watch)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *error):
        self.done.set()
        self.thread.join()

    def tree(self, pid):
        yield pid
        try:
            with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as text:
                below = text.read().split()
        except OSError:
            below = []
        for child in below:
            yield from self.tree(int(child))

    def resident(self, pid):
        try:
            with open(f"/proc/{pid}/statm", encoding="ascii") as text:
                pages = text.read().split()
        except OSError:
            return 0
        # what it shares with the process above it is counted there
        return (int(pages[1]) - (int(pages[2]) if pid != self.pid else 0)) * 4096

    def watch(self):
        while not self.done.wait(0.02):
            self.peak = max(self.peak, sum(map(self.resident, self.tree(self.pid))))


def frame(daemon):
    daemon.put("room", ROOM)
    return daemon.frame(daemon.submit(scene="room", resolution=[64, 48], stop={"samples": 2}))


def errors_of(path):
    """Errors that the Khronos validator reports; None without a report."""
    for name in os.listdir(os.path.dirname(path)):
        if name.startswith(os.path.basename(path)) and name.endswith(".report.json"):
            with open(os.path.join(os.path.dirname(path), name), encoding="utf-8") as text:
                return json.load(text)["issues"]["numErrors"]
    return None


def wrong_json(answers, jobs):
    for path, answer in answers.items():
        name = os.path.basename(path)
        if name.startswith("n_") and (answer.status < 400 or jobs[path].status < 400):
            yield name, "taken"
        elif name.startswith("y_") and 400 in (answer.status, jobs[path].status):
            yield name, answer.body


def is_whole(path):
    """All that it names is there: the corpus was split by the names of its files."""
    if not path.endswith(".gltf"):
        return True
    try:
        outside = [uri for uri in uris(json.loads(read(path))) if not uri.startswith("data:")]
    except ValueError:
        return True
    return len(set(outside)) == len(named(path, read(path)))


def wrong_gltf(answers):
    for path, answer in answers.items():
        if ("khronos-validator" in path and errors_of(path) == 0 and is_whole(path)
                and answer.status >= 300):
            yield path, answer.body


def wrong_made(answers):
    with open(tap.scenes(ROOT, "made/README.md"), encoding="utf-8") as text:
        wishes = dict(re.findall(r"^- `(.+?)`: (.+)$", text.read(), re.M))
    for path, answer in answers.items():
        wish = wishes.get(os.path.basename(path), "")
        if wish.startswith("refuse") and " or " not in wish and answer.status < 400:
            yield path, wish
        elif wish.startswith("load;") and answer.status >= 300:
            yield path, answer.body


def is_report(path):
    return path.endswith(".report.json")


def run_all(asked):
    scenes = [path for path in files("assimp", "gltf-afl", "khronos-validator", "made")
              if not is_report(path) and not path.endswith((".mtl", *PICTURES))]
    answers = asked.all(asked.scene, scenes)
    texts = list(files("json"))
    wrong = [*wrong_gltf(answers), *wrong_made(answers),
             *wrong_json(asked.all(asked.scene, texts), asked.all(asked.job, texts))]
    everything = list(files(""))
    asked.all(asked.picture, [path for path in everything
                              if path.endswith(PICTURES) or f"{os.sep}exr-" in path])
    asked.all(asked.library, [path for path in everything if path.endswith(".mtl")])
    asked.all(asked.job, [path for path in everything if is_report(path)])
    assert not wrong, wrong
    return len(everything)


def test_every_file_is_answered_in_time_and_the_next_frame_is_that_of_a_fresh_daemon():
    tap.scenes(ROOT)
    with Daemon() as fresh:
        expected = frame(fresh)
    with Daemon() as daemon, Memory(daemon) as memory:
        asked = Answers(daemon)
        count = run_all(asked)
        assert daemon.get("/healthz").status == 200
        assert frame(daemon) == expected
        print(f"{count} files, {len(asked.taken)} answers, "
              f"{sum(a.status < 300 for a in asked.taken.values())} of them taken, "
              f"peak {memory.peak >> 20} MiB")
        crashes = [line for line in daemon.logged().splitlines() if "ended by signal" in line]
        print("\n".join(crashes) or "no import crashed")
    assert memory.peak < BYTES, memory.peak


if __name__ == "__main__":
    tap.main()
