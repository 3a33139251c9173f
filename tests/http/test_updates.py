"""PATCH of scenes and cameras: merge patches, conditions, who follows and who does not."""
import base64
import hashlib
import json
import struct
import tempfile
import threading
import time
import zlib

import tap
from daemon import PATIENCE, ROOM, Daemon, triangle_glb

MERGE = {"Content-Type": "application/merge-patch+json"}

# A wall that glows and fills the view: every pixel is its emission.
GLOW = {
    "materials": {"glow": {"base_color": [0, 0, 0], "ior": 1, "emission": [0.5, 0.25, 1]}},
    "meshes": {"wall": {"primitive": "quad", "size": [40, 40]}},
    "instances": {"wall": {"mesh": "wall", "material": "glow"}},
    "cameras": {"near": {"yfov": 0.5, "transform": {"translation": [0, 0, 4]}},
                "away": {"yfov": 0.5, "transform": {"translation": [0, 0, 4],
                                                    "rotation": [0, 1, 0, 0]}}},
    "environment": {"radiance": [2, 2, 2]},
}
GREEN = {"materials": {"glow": {"emission": [0, 4, 0]}}}


def patch(daemon, body, scene="room", **headers):
    text = body if isinstance(body, (str, bytes)) else json.dumps(body)
    return daemon.ask("PATCH", f"/v1/scenes/{scene}", text, {**MERGE, **headers})


def native(daemon, scene="room"):
    return daemon.get(f"/v1/scenes/{scene}?format=native").json()


def colour(exr):
    """The mean of R, G and B; skips where there is nothing to read them with."""
    try:
        import OpenImageIO as oiio
    except ImportError:
        raise tap.Skip("no OpenImageIO")
    with tempfile.NamedTemporaryFile(suffix=".exr") as file:
        file.write(exr)
        file.flush()
        pixels = oiio.ImageBuf(file.name).get_pixels()
        return [round(float(c), 3) for c in pixels[:, :, :3].mean(axis=(0, 1))]


def live(daemon, scene="glow", **job):
    return daemon.submit(scene=scene, live=True, stop={"samples": 16}, outputs=["beauty"], **job)


def wait_idle(daemon, job, revision=None):
    """Until the live job has nothing more to do, at this revision."""
    end = time.monotonic() + PATIENCE
    while True:
        now = daemon.job(job)
        if now["progress"] == 1 and now["samples"] == 16 and revision in (None, now["revision"]):
            assert now["state"] == "rendering", now
            return now
        assert time.monotonic() < end, now
        time.sleep(0.02)


def test_null_removes_objects_merge_arrays_are_replaced():
    with Daemon() as daemon:
        before = daemon.put("room", ROOM).json()["revision"]
        answer = patch(daemon, {
            "materials": {"red": {"base_color": [0, 0, 1], "roughness": 0.25},
                          "new": {"metallic": 1, "name": None}},
            "instances": {"cube": None, "ball": {"material": "new"}}})
        assert answer.status == 200, answer.body
        made = answer.json()
        assert answer.headers["ETag"] == f'"{made["revision"]}"' and made["revision"] != before
        scene = native(daemon)
        assert scene["materials"]["red"]["base_color"] == [0, 0, 1]
        assert scene["materials"]["red"]["roughness"] == 0.25
        assert scene["materials"]["white"]["base_color"] == [0.7, 0.7, 0.7]
        assert "cube" not in scene["instances"] and made["instances"] == 4
        assert scene["instances"]["ball"]["material"] == "new"
        assert scene["instances"]["ball"]["mesh"] == "sphere"


def test_the_revision_is_that_of_the_same_scene_put_whole():
    with Daemon() as daemon:
        daemon.put("room", {**ROOM, "environment": {"radiance": [0, 0, 0]}})
        patched = patch(daemon, {"materials": {"red": {"roughness": 0.125}}}).json()["revision"]
        whole = json.loads(json.dumps(ROOM))
        whole["materials"]["red"]["roughness"] = 0.125
        whole["environment"] = {"radiance": [0, 0, 0]}
        assert daemon.put("whole", whole).json()["revision"] == patched


def test_a_patch_that_changes_nothing_keeps_the_revision_and_all_parts():
    with Daemon() as daemon:
        before = daemon.put("room", ROOM).json()["revision"]
        for body in ({}, {"materials": {"red": {"base_color": [0.7, 0.1, 0.1]}}},
                     {"instances": {"nobody": None}}):
            answer = patch(daemon, body).json()
            assert answer["revision"] == before, body
            changes = answer["changes"]
            assert not changes["rebuilt"] + changes["uploaded"] + changes["later"], changes
            assert changes["kept"]


PARTS = {"meshes", "textures", "materials", "instances", "lights", "environment", "bvh",
         "placement"}
FLAG = {"meshes": {"flag": {"positions": [0, 0, 0, 0.1, 0, 0, 0, 0.1, 0], "indices": [0, 1, 2]}},
        "instances": {"wall": {"mesh": "flag"}}}
MOVE = {"instances": {"wall": {"transform": {"translation": [0, 0.5, 0]}}}}
# (body, what is written at once, what when a job asks)
EDITS = [
    ({"materials": {"red": {"roughness": 0.5}}}, {"materials"}, set()),
    ({"instances": {"cube": {"transform": {"translation": [0.1, 0.4, 0.1]}}}}, {"instances"},
     {"bvh", "placement"}),
    ({"environment": {"radiance": [3, 2, 1]}}, {"environment"}, set()),
    ({"environment": {"rotation": 1}}, {"environment"}, set()),
    ({"media": {"fog": {"density": 0.1}}}, set(), set()),
    ({"cameras": {"other": {"yfov": 0.5}}}, set(), set()),
]


def test_the_answer_says_what_was_made_anew():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        for body, anew, later in EDITS:
            changes = patch(daemon, body).json()["changes"]
            assert set(changes["rebuilt"] + changes["uploaded"]) == anew, (body, changes)
            assert set(changes["later"]) == later, (body, changes)
            assert set(changes["kept"]) == PARTS - anew - later, (body, changes)
            assert changes["milliseconds"]["total"] >= changes["milliseconds"]["parse"] > 0


def test_what_a_live_job_traces_is_made_at_once():
    with Daemon() as daemon:
        daemon.put("glow", GLOW)
        wait_idle(daemon, live(daemon))
        for body, rebuilt in ((MOVE, {"placement"}), (GREEN, set()), (FLAG, {"bvh", "placement"})):
            changes = patch(daemon, body, "glow").json()["changes"]
            assert rebuilt <= set(changes["rebuilt"]), (body, changes)
            assert "placement" not in changes["later"], (body, changes)


def test_edits_of_what_moves_are_for_later():
    with Daemon() as daemon:
        daemon.put("rail", MOVING)
        for body in ({"nodes": {"rail": {"transform": {"translation": [1, 0, 0]}}}}, {"fps": 12}, SLOWER,
                     {"instances": {"wall": {"transform": {"translation": [0, 1, 0]}}}}):
            answer = patch(daemon, body, "rail")
            assert answer.status == 200, answer.body
            changes = answer.json()["changes"]
            assert {"bvh", "placement"} <= set(changes["later"]), (body, changes)
        changes = patch(daemon, GREEN, "rail").json()["changes"]
        assert {"bvh", "placement"} <= set(changes["kept"]), changes


def test_a_scene_that_came_as_glb_is_patched():
    with Daemon() as daemon:
        before = daemon.put("sail", triangle_glb()).json()
        scene = native(daemon, "sail")
        [material] = scene["materials"]
        [instance] = scene["instances"]
        answer = patch(daemon, {"materials": {material: {"emission": [0, 0, 3]}},
                                "instances": {instance: {"visible": False}}}, "sail")
        assert answer.status == 200, answer.body
        scene = native(daemon, "sail")
        assert scene["materials"][material]["emission"] == [0, 0, 3]
        assert scene["instances"][instance]["visible"] is False
        assert answer.json()["warnings"] == before["warnings"]


def test_warnings_of_what_was_added_go_when_it_is_replaced():
    with Daemon() as daemon:
        before = daemon.put("sail", triangle_glb()).json()["warnings"]
        [added] = [w for w in before if "environment" in w]
        moved = patch(daemon, {"cameras": {"far": {"yfov": 1}}}, "sail").json()["warnings"]
        assert added in moved
        after = patch(daemon, {"environment": {"radiance": [2, 2, 2]}}, "sail").json()["warnings"]
        assert after == [w for w in before if w != added]
        assert daemon.get("/v1/scenes/sail").json()["warnings"] == after


def test_warnings_of_what_a_patch_lacks_stay():
    bare = {"materials": ROOM["materials"], "meshes": ROOM["meshes"], "cameras": ROOM["cameras"],
            "instances": {"ball": {"mesh": "sphere", "material": "red"}},
            "environment": {"radiance": [3, 3, 3]}}
    uri = "data:image/png;base64," + base64.b64encode(png((255, 0, 0))).decode()
    for more in ({}, {"images": {"dot": {"data": uri}}},
                 {"meshes": {"t": {"positions": [0, 0, 0, 1, 0, 0, 0, 1, 0],
                                   "indices": [0, 1, 2]}}}):
        with Daemon() as daemon:
            assert daemon.put("room", bare).json()["warnings"] == []
            said = patch(daemon, {"environment": None, **more}).json()["warnings"]
            assert len(said) == 1 and "was added" in said[0], (more, said)
            assert patch(daemon, {"materials": {"red": {"roughness": 1}}}).json()["warnings"] == said


def test_a_warning_goes_when_its_cause_does():
    with Daemon() as daemon:
        daemon.put("glow", GLOW)
        [said] = patch(daemon, {"media": {"fog": {"density": 0.1}}}, "glow").json()["warnings"]
        assert "fog" in said
        assert patch(daemon, GREEN, "glow").json()["warnings"] == [said]
        assert patch(daemon, {"media": {"fog": None}}, "glow").json()["warnings"] == []


def png(rgb):
    """A PNG of one pixel."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"\0" + bytes(rgb))) + chunk(b"IEND", b""))


def test_a_patch_brings_pictures_and_meshes():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        uri = "data:image/png;base64," + base64.b64encode(png((255, 0, 0))).decode()
        answer = patch(daemon, {
            "images": {"dot": {"data": uri}},
            "materials": {"red": {"base_color_texture": {"image": "dot"}}}})
        assert answer.status == 200, answer.body
        assert native(daemon)["images"]["dot"]["width"] == 1
        green = png((0, 255, 0))
        name = hashlib.sha256(green).hexdigest()
        assert daemon.ask("PUT", f"/v1/assets/{name}", green,
                          {"Content-Type": "application/octet-stream"}).status == 201
        answer = patch(daemon, {"images": {"leaf": {"asset": name}}})
        assert answer.status == 200, answer.body
        assert native(daemon)["images"]["leaf"]["format"] == "rgba8"
        answer = patch(daemon, {
            "meshes": {"flag": {"positions": [0, 0, 0, 1, 0, 0, 0, 1, 0], "indices": [0, 1, 2]}},
            "instances": {"flag": {"mesh": "flag", "material": "red"}}})
        assert answer.status == 200, answer.body
        assert "asset" in native(daemon)["meshes"]["flag"]
        data = "data:image/png;base64," + base64.b64encode(green).decode()
        assert patch(daemon, {"images": {"dot": {"data": data}}}).status == 422
        old = {member: None for member in ("asset", "width", "height", "format")}
        answer = patch(daemon, {"images": {"dot": {**old, "data": data}}})
        assert answer.status == 200, answer.body
        assert native(daemon)["images"]["dot"] == native(daemon)["images"]["leaf"]
        broken = patch(daemon, {"images": {"dot": {"data": uri[:-20]}}})
        assert broken.status == 422 and broken.pointers() == ["/images/dot/data"], broken.body


# (status, pointers or None, body)
FAULTS = [
    (400, None, b"{"),
    (400, None, b""),
    (422, [""], b"[]"),
    (422, [""], b"7"),
    (422, ["/materials/red/rough"], {"materials": {"red": {"rough": 1}}}),
    (422, ["/materials/red/roughness", "/things"],
     {"materials": {"red": {"roughness": 2}}, "things": {}}),
    (422, ["/instances/ball/mesh", "/instances/cube/material"],
     {"instances": {"ball": {"mesh": "none"}, "cube": {"material": None}}}),
    (422, ["/instances/wall/material"], {"materials": {"red": None}}),
    (422, ["/meshes/box/asset"], {"meshes": {"box": {"asset": "0" * 64}}}),
]


def test_faults_are_named_in_the_patched_scene_and_change_nothing():
    with Daemon() as daemon:
        revision = daemon.put("room", ROOM).json()["revision"]
        for status, pointers, body in FAULTS:
            answer = patch(daemon, body)
            assert answer.status == status, (body, answer.status, answer.body)
            if pointers is not None:
                assert answer.pointers() == pointers, (body, answer.body)
            assert daemon.get("/v1/scenes/room").json()["revision"] == revision
        assert patch(daemon, {}, "attic").status == 404
        answer = daemon.ask("PATCH", "/v1/scenes/room", "{}", {"Content-Type": "text/plain"})
        assert answer.status == 415, answer.body


def test_if_match_guards_a_patch():
    with Daemon() as daemon:
        old = daemon.put("room", ROOM).headers["ETag"]
        first = patch(daemon, {"materials": {"red": {"roughness": 0.5}}}, **{"If-Match": old})
        assert first.status == 200
        second = patch(daemon, {"materials": {"red": {"roughness": 0.6}}}, **{"If-Match": old})
        assert second.status == 412, second.body
        assert native(daemon)["materials"]["red"]["roughness"] == 0.5
        assert patch(daemon, {}, "none", **{"If-Match": "*"}).status == 412


def test_patches_at_once_are_all_applied():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        answers = []

        def add(i):
            answers.append(patch(daemon, {"materials": {f"m{i}": {"roughness": i / 16}}}).status)
        threads = [threading.Thread(target=add, args=(i,)) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert answers == [200] * 8, answers
        materials = native(daemon)["materials"]
        assert {f"m{i}" for i in range(8)} <= set(materials)


def test_of_two_guarded_patches_at_once_one_is_refused():
    with Daemon() as daemon:
        etag = daemon.put("room", ROOM).headers["ETag"]
        answers = []

        def add(i):
            answers.append(patch(daemon, {"materials": {f"m{i}": {}}},
                                 **{"If-Match": etag}).status)
        threads = [threading.Thread(target=add, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sorted(answers) == [200, 412, 412, 412], answers


def test_a_batch_job_keeps_its_revision():
    with Daemon() as daemon:
        revision = daemon.put("room", ROOM).json()["revision"]
        settings = {"scene": "room", "resolution": [192, 128], "stop": {"samples": 24}}
        twin = daemon.frame(daemon.submit(**settings))
        job = daemon.submit(**settings)
        assert patch(daemon, {"materials": {"white": {"base_color": [0, 0, 1]}}}).status == 200
        assert daemon.frame(job) == twin
        assert daemon.job(job)["revision"] == revision
        assert daemon.frame(daemon.submit(**settings)) != twin


def test_a_live_job_follows_its_scene_and_idles():
    with Daemon() as daemon:
        first = daemon.put("glow", GLOW).json()["revision"]
        job = live(daemon)
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            tiles = stream.parts()
            headers, body = next(tiles)
            assert headers["Glint-Revision"] == first and colour(body) == [0.5, 0.25, 1]
            wait_idle(daemon, job, first)
            busy = daemon.job(job)["worker_seconds"]
            daemon.frame(daemon.submit(scene="glow", outputs=["beauty"], stop={"samples": 64}))
            assert daemon.job(job)["worker_seconds"] == busy  # while another had its turns
            second = patch(daemon, GREEN, "glow").json()["revision"]
            while headers["Glint-Revision"] == first:
                headers, body = next(tiles)
            assert headers["Glint-Revision"] == second and colour(body) == [0, 4, 0]
        wait_idle(daemon, job, second)
        frame = daemon.get(f"/v1/jobs/{job}/frame.exr")
        assert colour(frame.body) == [0, 4, 0]
        assert frame.headers["Glint-Revision"] == second


def test_a_live_job_follows_its_camera():
    with Daemon() as daemon:
        daemon.put("glow", GLOW)
        job, other = live(daemon), live(daemon)

        def move(camera):
            return daemon.ask("PATCH", f"/v1/jobs/{job}", json.dumps({"camera": camera}), MERGE)
        for camera, expected in (("away", [2, 2, 2]), (None, [0.5, 0.25, 1]),
                                 ({"yfov": 0.3, "transform": {"rotation": [0, 1, 0, 0]}},
                                  [2, 2, 2])):
            wait_idle(daemon, job)
            answer = move(camera)
            assert answer.status == 200, answer.body
            assert answer.json()["job"].get("camera") == camera
            end = time.monotonic() + PATIENCE
            while colour(daemon.get(f"/v1/jobs/{job}/frame.exr").body) != expected:
                assert time.monotonic() < end, (camera, expected)
        assert colour(daemon.get(f"/v1/jobs/{other}/frame.exr").body) == [0.5, 0.25, 1]
        for camera, pointers in (("nobody", ["/camera"]), (7, ["/camera"]),
                                 ({"yfov": 9}, ["/camera/yfov"])):
            answer = move(camera)
            assert answer.status == 422 and answer.pointers() == pointers, answer.body
        batch = daemon.submit(scene="glow", stop={"samples": 1})
        answer = daemon.ask("PATCH", f"/v1/jobs/{batch}", '{"camera": "away"}', MERGE)
        assert answer.status == 422 and answer.pointers() == ["/camera"], answer.body


def test_a_live_job_that_cannot_follow_stays_and_says_why():
    with Daemon() as daemon:
        first = daemon.put("glow", GLOW).json()["revision"]
        job = live(daemon, camera="away")
        wait_idle(daemon, job)
        second = patch(daemon, {"cameras": {"away": None}}, "glow").json()["revision"]
        end = time.monotonic() + PATIENCE
        while not daemon.job(job)["warnings"]:
            assert time.monotonic() < end
            time.sleep(0.02)
        assert daemon.job(job)["revision"] == first
        assert "away" in daemon.job(job)["warnings"][0]
        third = patch(daemon, {"cameras": {"away": GLOW["cameras"]["away"]}, **GREEN},
                      "glow").json()["revision"]
        assert third not in (first, second)
        wait_idle(daemon, job, third)
        assert daemon.job(job)["warnings"] == []


def test_a_deleted_scene_lives_on_in_its_live_job():
    with Daemon() as daemon:
        first = daemon.put("glow", GLOW).json()["revision"]
        job = live(daemon)
        wait_idle(daemon, job)
        assert daemon.delete("/v1/scenes/glow").status == 409
        assert daemon.delete("/v1/scenes/glow?force=true").status == 204
        assert patch(daemon, GREEN, "glow").status == 404
        assert daemon.job(job)["revision"] == first
        assert colour(daemon.get(f"/v1/jobs/{job}/frame.exr").body) == [0.5, 0.25, 1]
        assert daemon.delete(f"/v1/jobs/{job}").status == 202
        assert daemon.job(job)["state"] == "cancelled"


def test_many_edits_while_tiles_are_read_end_at_the_last():
    with Daemon() as daemon:
        daemon.put("glow", GLOW)
        job = live(daemon, resolution=[256, 192])
        with daemon.connect(f"/v1/jobs/{job}/tiles") as stream:
            tiles = stream.parts()
            next(tiles)
            for i in range(1, 31):
                answer = patch(daemon, {"materials": {"glow": {"emission": [0, i / 8, 0]}}}, "glow")
                daemon.ask("PATCH", f"/v1/jobs/{job}", json.dumps({"camera": {
                    "yfov": 0.4 + i / 1000, "transform": {"translation": [0, 0, 4]}}}), MERGE)
            last = answer.json()["revision"]
            seen = {}
            while len(seen) < 12:
                headers, body = next(tiles)
                assert colour(body)[0] in (0, 0.5), headers
                if headers["Glint-Revision"] == last:
                    assert colour(body) == [0, 3.75, 0]
                    seen[headers["Glint-Tile"]] = body
        wait_idle(daemon, job, last)
        assert daemon.metric("glint_scenes") == 1


# The wall moves out of the view in the second half of its animation's second.
MOVING = {
    **GLOW,
    "nodes": {"rail": {}},
    "instances": {"wall": {"mesh": "wall", "material": "glow", "node": "rail"}},
    "animations": {"slide": {"channels": {"x": {
        "node": "rail", "path": "translation", "interpolation": "step", "times": [0, 0.5],
        "values": [0, 0, 0, 500, 0, 0]}}}},
    "fps": 10,
}


SLOWER = {"animations": {"slide": {"channels": {"x": {
    **MOVING["animations"]["slide"]["channels"]["x"], "times": [0, 0.8], "asset": None,
    "keys": None}}}}}


def test_jobs_render_the_pose_of_their_frame_side_by_side():
    with Daemon() as daemon:
        daemon.put("rail", MOVING)
        seen = {"scene": "rail", "outputs": ["beauty"], "stop": {"samples": 4}}
        jobs = [(daemon.submit(**seen, **settings), expected) for settings, expected in (
            ({"frame": 0}, [0.5, 0.25, 1]), ({"frame": 4}, [0.5, 0.25, 1]),
            ({"frame": 5}, [2, 2, 2]), ({"frame": 5, "fps": 20}, [0.5, 0.25, 1]),
            ({"frame": 9, "animation": "slide"}, [2, 2, 2]),
            ({"frame": 9, "animation": "none"}, [0.5, 0.25, 1]))]
        for job, expected in jobs:
            assert colour(daemon.frame(job)) == expected, (job, expected)
        answer = daemon.post({"scene": "rail", "animation": "walk"})
        assert answer.status == 422 and answer.pointers() == ["/animation"], answer.body
        assert "slide" in answer.json()["detail"]
        assert daemon.get("/v1/scenes/rail").json()["bytes"]["poses"] > 0


def test_a_live_job_follows_the_animation_that_is_edited():
    with Daemon() as daemon:
        daemon.put("rail", MOVING)
        job = live(daemon, "rail", frame=7)
        wait_idle(daemon, job)
        assert colour(daemon.get(f"/v1/jobs/{job}/frame.exr").body) == [2, 2, 2]
        answer = patch(daemon, SLOWER, "rail")
        assert answer.status == 200, answer.body
        revision = answer.json()["revision"]
        wait_idle(daemon, job, revision)
        assert colour(daemon.get(f"/v1/jobs/{job}/frame.exr").body) == [0.5, 0.25, 1]


if __name__ == "__main__":
    tap.main()
