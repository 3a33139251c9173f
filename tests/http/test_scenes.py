"""PUT, GET and DELETE of scenes."""
import json

import tap
from daemon import ROOM, Daemon, triangle_glb


def test_a_scene_is_created_replaced_listed_and_removed():
    with Daemon() as daemon:
        first = daemon.put("room", ROOM)
        assert first.status == 201 and first.headers["Location"] == "/v1/scenes/room"
        resource = first.json()
        assert resource["name"] == "room" and resource["instances"] == 5
        assert first.headers["ETag"] == f'"{resource["revision"]}"'
        assert daemon.put("room", ROOM).status == 200
        assert [s["name"] for s in daemon.get("/v1/scenes").json()["scenes"]] == ["room"]
        assert daemon.delete("/v1/scenes/room").status == 204
        assert daemon.get("/v1/scenes/room").status == 404
        assert daemon.delete("/v1/scenes/room").status == 404


def test_the_revision_follows_the_content():
    with Daemon() as daemon:
        one = daemon.put("a", ROOM).json()["revision"]
        assert daemon.put("b", ROOM).json()["revision"] == one
        other = json.loads(json.dumps(ROOM))
        other["materials"]["red"]["roughness"] = 0.25
        assert daemon.put("b", other).json()["revision"] != one


def test_the_native_form_gives_the_same_scene_again():
    with Daemon() as daemon:
        made = daemon.put("room", {**ROOM, "environment": {"radiance": [1, 1, 1]}})
        native = daemon.get("/v1/scenes/room?format=native")
        assert native.headers["ETag"] != made.headers["ETag"]
        assert set(native.json()["objects"]) == set(ROOM["objects"])


def test_conditions_guard_against_lost_updates():
    with Daemon() as daemon:
        etag = daemon.put("room", ROOM).headers["ETag"]
        json_type = {"Content-Type": "application/json"}
        body = json.dumps(ROOM)
        for condition, status in (({"If-None-Match": "*"}, 412), ({"If-Match": '"old"'}, 412),
                                  ({"If-Match": f'"old", {etag}'}, 200), ({"If-Match": "*"}, 200)):
            answer = daemon.ask("PUT", "/v1/scenes/room", body, {**json_type, **condition})
            assert answer.status == status, (condition, answer.body)
        assert daemon.ask("PUT", "/v1/scenes/new", body,
                          {**json_type, "If-Match": "*"}).status == 412
        assert daemon.get("/v1/scenes/room", {"If-None-Match": etag}).status == 304
        assert daemon.ask("DELETE", "/v1/scenes/room", None,
                          {"If-Match": '"old"'}).status == 412


def test_a_glb_tells_itself_without_a_type():
    with Daemon() as daemon:
        answer = daemon.ask("PUT", "/v1/scenes/sail", triangle_glb())
        assert answer.status == 201, answer.body
        assert answer.json()["triangles"] == 1


def test_cut_files_are_refused_and_the_daemon_serves_on():
    whole = triangle_glb()
    with Daemon() as daemon:
        for size in (0, 1, 4, 11, 12, 19, 20, 100, len(whole) - 40, len(whole) - 1):
            answer = daemon.ask("PUT", "/v1/scenes/cut", whole[:size],
                                {"Content-Type": "model/gltf-binary"})
            assert answer.status in (400, 422), (size, answer.status, answer.body)
        assert daemon.get("/v1/scenes/cut").status == 404
        assert daemon.put("whole", whole).status == 201


def test_a_failed_upload_leaves_the_scene_as_it_was():
    with Daemon() as daemon:
        revision = daemon.put("room", ROOM).json()["revision"]
        assert daemon.ask("PUT", "/v1/scenes/room", b"{",
                          {"Content-Type": "application/json"}).status == 400
        assert daemon.get("/v1/scenes/room").json()["revision"] == revision


def test_every_fault_of_a_scene_is_named():
    scene = json.loads(json.dumps(ROOM))
    scene["materials"]["red"]["metallic"] = 2
    scene["instances"]["ball"]["mesh"] = "cone"
    scene["lamps"] = {}
    with Daemon() as daemon:
        answer = daemon.ask("PUT", "/v1/scenes/room", json.dumps(scene),
                            {"Content-Type": "application/json"})
        assert answer.status == 422
        assert answer.pointers() == ["/instances/ball/mesh", "/lamps", "/materials/red/metallic"]


def test_names_are_checked():
    with Daemon() as daemon:
        for name in ("a%20b", "a%2Fb", "x" * 129, "%E2%98%83"):
            answer = daemon.ask("PUT", f"/v1/scenes/{name}", json.dumps(ROOM),
                                {"Content-Type": "application/json"})
            assert answer.status == 422, (name, answer.status)


def test_an_upload_that_is_broken_off_leaves_nothing():
    with Daemon() as daemon:
        for _ in range(3):
            with daemon.dial() as s:
                s.sendall(b"PUT /v1/scenes/half HTTP/1.1\r\nHost: localhost\r\n"
                          b"Content-Length: 1000000\r\n\r\n" + b"x" * 500000)
        daemon.wait_metric("glint_http_connections", 1)
        assert daemon.get("/v1/scenes/half").status == 404


def test_a_scene_in_use_stays_unless_forced():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 100000})
        daemon.until(job, lambda j: j["state"] == "rendering")
        assert daemon.delete("/v1/scenes/room").status == 409
        assert daemon.delete("/v1/scenes/room?force=true").status == 204
        assert daemon.get("/v1/scenes/room").status == 404
        before = daemon.job(job)["samples"]
        daemon.until(job, lambda j: j["samples"] > before)  # it keeps its revision
        assert daemon.delete(f"/v1/jobs/{job}").status == 202


if __name__ == "__main__":
    tap.main()
