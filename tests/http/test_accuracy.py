"""Choosing by price: fronts of scenes, and jobs that say what they may take or must reach."""
import json

import tap
from daemon import ROOM, Daemon
from lasting import Lasting

EXACT = {"accuracy": {"preset": "reference"}, "max_bounces": 16}
ROUGH = {"accuracy": {"gi": "none"}, "max_bounces": 1}


def point(settings, seconds, variance, bias, row=""):
    return {"settings": settings, "seconds": seconds, "rays": 5, "variance": variance,
            "bias": bias, "row": row}


# Measured by nobody: what is picked can be said beforehand.
FRONT = {"points": [point(EXACT, 1e-5, 1, 0, "exact"), point(ROUGH, 1e-6, 0.5, 0.1, "rough")]}
SMALL = {"scene": "room", "resolution": [32, 16], "outputs": ["beauty"]}


def put_front(daemon, front, scene="room"):
    return daemon.ask("PUT", f"/v1/scenes/{scene}/front", json.dumps(front),
                      {"Content-Type": "application/json"})


def finished(daemon, **job):
    ident = daemon.submit(**SMALL, **job)
    daemon.until(ident, lambda j: j["state"] == "done")
    return daemon.job(ident)


def test_a_scene_has_the_front_of_its_class_until_it_is_given_one():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        first = daemon.get("/v1/scenes/room/front").json()
        assert (first["from"], first["class"], first["current"]) == ("class", "plain", False)
        assert len(first["front"]["points"]) >= 5
        assert put_front(daemon, FRONT).status == 201
        own = daemon.get("/v1/scenes/room/front").json()
        assert own["from"] == "scene" and own["front"] == FRONT and not own["current"]
        revision = daemon.get("/v1/scenes/room").json()["revision"]
        assert put_front(daemon, {**FRONT, "revision": revision}).status == 200
        assert daemon.get("/v1/scenes/room/front").json()["current"]
        assert daemon.delete("/v1/scenes/room").status == 204
        assert daemon.get("/v1/scenes/room/front").status == 404
        daemon.put("room", ROOM)
        assert daemon.get("/v1/scenes/room/front").json()["from"] == "class"


def test_what_is_wrong_with_a_front_is_named():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        assert put_front(daemon, FRONT, "attic").status == 404
        bad = put_front(daemon, {"points": [point({"max_bounces": 5000}, -1, 1, 0)]})
        assert bad.status == 422
        assert set(bad.pointers()) == {"/points/0/settings", "/points/0/seconds"}
        assert daemon.get("/v1/scenes/room/front").json()["from"] == "class"


def test_settings_are_picked_from_the_front_and_told():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        put_front(daemon, FRONT)
        # 512 pixels: an exact sample costs 5.1 ms of a worker, a rough one a tenth.
        loose = finished(daemon, accuracy={"error": 0.3})
        assert loose["chosen"]["row"] == "rough" and loose["chosen"]["from"] == "scene"
        assert loose["chosen"]["known_bias"] == 0.1 and loose["chosen"]["expected_error"] <= 0.3
        assert loose["job"]["accuracy"]["gi"] == "none" and loose["job"]["max_bounces"] == 1
        assert abs(loose["job"]["stop"]["error"] ** 2 - (0.3 ** 2 - 0.1 ** 2)) < 1e-9
        assert loose["error"] <= 0.3 and "samples" not in loose["job"]["stop"]
        tight = finished(daemon, accuracy={"error": 0.09}, stop={"samples": 32})
        assert tight["chosen"]["row"] == "exact" and tight["job"]["accuracy"]["gi"] == "path"
        assert tight["chosen"]["settings"]["max_bounces"] == 16
        pinned = finished(daemon, accuracy={"time": 0.05, "gi": "path"})
        assert pinned["chosen"]["row"] == "exact" and pinned["chosen"]["expected_seconds"] == 0.05
        refused = daemon.post({**SMALL, "accuracy": {"error": 0.05, "gi": "none"}})
        assert refused.status == 422 and refused.pointers() == ["/accuracy/error"]
        put_front(daemon, {"points": FRONT["points"][1:]})
        refused = daemon.post({**SMALL, "accuracy": {"time": 1, "gi": "path"}})
        assert refused.status == 422 and refused.pointers() == ["/accuracy"]
        assert "those that the job gives" in refused.body.decode()
        assert "chosen" not in finished(daemon, stop={"samples": 1})


def test_a_front_of_a_scene_that_has_changed_is_said_to_be_of_another_revision():
    wish = {**SMALL, "accuracy": {"error": 0.3}}
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        revision = daemon.get("/v1/scenes/room").json()["revision"]
        put_front(daemon, {**FRONT, "revision": revision})
        before = daemon.post(wish).json()
        assert before["chosen"]["current"] and before["warnings"] == []
        lamp = {"materials": {"lamp": {"emission": [6, 6, 6]}}}
        assert daemon.ask("PATCH", "/v1/scenes/room", json.dumps(lamp),
                          {"Content-Type": "application/merge-patch+json"}).status == 200
        after = daemon.post(wish).json()
        assert after["chosen"]["from"] == "scene" and not after["chosen"]["current"]
        assert len(after["warnings"]) == 1 and "revision" in after["warnings"][0], after
        assert not daemon.get("/v1/scenes/room/front").json()["current"]
        put_front(daemon, {**FRONT, "revision": after["revision"]})
        assert daemon.post(wish).json()["warnings"] == []


def test_an_error_that_takes_more_samples_than_a_job_may_take_is_said_to_be_out_of_reach():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        put_front(daemon, FRONT)
        for wish in ({"accuracy": {"error": 0.03}, "stop": {"samples": 32}},
                     {"accuracy": {"error": 1e-6}}):  # 2^24 samples are the most there are
            job = daemon.post({**SMALL, **wish}).json()
            asked = wish["accuracy"]["error"]
            assert job["chosen"]["expected_error"] > asked, job["chosen"]
            assert any(f"asked for, {asked:.3g}" in text for text in job["warnings"]), job["warnings"]
            daemon.delete(f"/v1/jobs/{job['id']}")
        near = daemon.post({**SMALL, "accuracy": {"error": 0.3}}).json()
        assert near["chosen"]["expected_error"] <= 0.3, near["chosen"]
        assert not any("asked for" in text for text in near["warnings"]), near["warnings"]


def test_a_budget_and_what_else_a_job_may_say():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        put_front(daemon, FRONT)
        region = finished(daemon, accuracy={"error": 0.3}, region=[8, 4, 8, 8])
        assert region["chosen"]["expected_seconds"] < 0.01 and region["error"] <= 0.3
        whole = finished(daemon, accuracy={"error": 0.3})
        # In proportion to the pixels, for the same samples.
        share = region["chosen"]["expected_seconds"] / whole["chosen"]["expected_seconds"]
        assert abs(share - 64 / 512) < 1e-9, share
        batches = finished(daemon, accuracy={"error": 0.3}, estimate="batches")
        assert batches["chosen"]["row"] == whole["chosen"]["row"] and batches["error"] <= 0.3
        adaptive = finished(daemon, accuracy={"error": 0.3}, adaptive=True)
        assert adaptive["samples"] >= 16 and adaptive["error"] <= 0.3  # those of the pilot count not


SHORT = {"accuracy": {"preset": "reference"}, "max_bounces": 2}


def test_a_known_bias_has_its_part_of_the_error_that_a_job_is_to_reach():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        put_front(daemon, {"points": [point(EXACT, 1e-5, 1, 0), point(SHORT, 1e-5, 1, 0.04)]})
        job = finished(daemon, **SHORT, stop={"error": 0.05, "samples": 4096})
        assert job["estimate"]["known_bias"] == 0.04
        assert job["error"] ** 2 + 0.04 ** 2 <= 0.05 ** 2
        exact = finished(daemon, **EXACT, stop={"error": 0.05, "samples": 4096})
        assert exact["estimate"]["known_bias"] is None and exact["samples"] < job["samples"]


def test_less_than_the_known_bias_is_unreachable_with_these_settings():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        put_front(daemon, {"points": [point(SHORT, 1e-5, 1, 0.04)]})
        ident = daemon.submit(**SMALL, **SHORT, stop={"error": 1e-5, "samples": 1000000})
        daemon.until(ident, lambda j: j["estimate"]["forecast"])
        told = daemon.job(ident)["estimate"]["forecast"]
        assert told["error"] == 1e-5 and not told["reachable"] and told["samples"] is None
        daemon.delete(f"/v1/jobs/{ident}")


def test_what_a_job_cannot_have_picked_is_a_fault():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        both = daemon.post({**SMALL, "accuracy": {"time": 1, "error": 0.1}})
        assert both.status == 422 and both.pointers() == ["/accuracy/error"]
        assert daemon.post({**SMALL, "accuracy": {"time": 0}}).pointers() == ["/accuracy/time"]
        assert daemon.post({**SMALL, "accuracy": {"time": 1}, "live": True}).status == 422
        part = daemon.post({**SMALL, "accuracy": {"error": 1}, "sample_range": [0, 4]})
        assert part.status == 422 and "/accuracy" in part.pointers()


def test_a_time_ends_the_job():
    """How well it is held is measured by tests/accuracy/choose."""
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = finished(daemon, accuracy={"time": 0.5})
        assert job["seconds"] >= 0.5 and job["job"]["stop"] == {"seconds": 0.5}
        assert job["chosen"]["from"] == "class" and job["chosen"]["expected_seconds"] == 0.5
        assert job["samples"] >= 1 and job["job"]["accuracy"]["time"] == 0.5


def test_the_choice_and_its_front_are_there_after_a_kill():
    with Lasting() as d:
        d.put("room", ROOM)
        put_front(d, FRONT)
        job = d.post({**SMALL, "accuracy": {"error": 0.3}},
                     {"Idempotency-Key": "once"}).json()["id"]
        d.until(job, lambda j: j["state"] == "done")
        before = d.job(job)
        put_front(d, {"points": [point(EXACT, 1e-5, 1, 0, "other")]})
        d.kill()
        d.start()
        assert d.job(job)["chosen"] == before["chosen"]
        assert d.job(job)["estimate"]["known_bias"] == 0.1
        assert d.job(job)["job"] == before["job"]
        assert d.get("/v1/scenes/room/front").json()["front"]["points"][0]["row"] == "other"
        again = d.post({**SMALL, "accuracy": {"error": 0.3}}, {"Idempotency-Key": "once"})
        assert again.status == 202 and again.json()["id"] == job  # though it would pick another
        d.until(job, lambda j: j["state"] == "done")
        gone = d.ask("DELETE", "/v1/scenes/room")
        assert gone.status == 204, gone.body
        d.kill()
        d.start()
        d.put("room", ROOM)
        assert d.get("/v1/scenes/room/front").json()["from"] == "class"


if __name__ == "__main__":
    tap.main()
