"""Jobs: submitted, checked, rendered, cancelled, shared."""
import json
import threading

import tap
from daemon import ROOM, Daemon
from lasting import Lasting

EXR_MAGIC = b"\x76\x2f\x31\x01"
PNG_MAGIC = b"\x89PNG\r\n\x1a\n"

# (pointers of the faults, job)
FAULTS = [
    (["/scene"], {}),
    (["/scene"], {"scene": 7}),
    (["/scene"], {"scene": "attic"}),
    (["/bounces"], {"scene": "room", "bounces": 3}),
    (["/stop/sample"], {"scene": "room", "stop": {"sample": 3}}),
    (["/stop/samples"], {"scene": "room", "stop": {"samples": 0}}),
    (["/outputs/1"], {"scene": "room", "outputs": ["beauty", "smell"]}),
    (["/resolution/0"], {"scene": "room", "resolution": [0, 64]}),
    (["/resolution/1"], {"scene": "room", "resolution": [64, 16385]}),
    (["/accuracy/gi"], {"scene": "room", "accuracy": {"gi": "surfel"}}),
    (["/surfels"], {"scene": "room", "surfels": {"count": 8}}),
    (["/camera"], {"scene": "room", "camera": "nobody"}),
    (["/max_bounces", "/priority", "/scene"],
     {"scene": "attic", "max_bounces": -1, "priority": 1000}),
]


def test_every_fault_of_a_job_is_named_in_one_answer():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        for pointers, job in FAULTS:
            answer = daemon.post(job)
            assert answer.status == 422, (job, answer.status, answer.body)
            assert answer.pointers() == pointers, (job, answer.body)
        for text in (b"", b"{", b"[1,2", b"{} {}", b'{"scene": "\xff"}', b'{"a": 1e999'):
            answer = daemon.post(text)
            assert answer.status == 400, (text, answer.status, answer.body)
        assert daemon.get("/v1/jobs").json() == {"jobs": [], "next": None}


def test_a_job_is_rendered_and_described():
    with Daemon() as daemon:
        revision = daemon.put("room", ROOM).json()["revision"]
        answer = daemon.post({"scene": "room", "resolution": [128, 96], "stop": {"samples": 32},
                              "outputs": ["beauty", "depth", "normal", "crypto_object", "motion"]})
        assert answer.status == 202
        job = answer.json()["id"]
        assert answer.headers["Location"] == f"/v1/jobs/{job}"
        assert daemon.frame(job)[:4] == EXR_MAGIC
        state = daemon.job(job)
        assert (state["state"], state["samples"], state["progress"]) == ("done", 32, 1)
        assert state["revision"] == revision and state["seconds"] > 0
        assert [j["id"] for j in daemon.get("/v1/jobs").json()["jobs"]] == [job]
        for output in ("beauty", "depth", "normal", "crypto_object", "motion"):
            picture = daemon.get(f"/v1/jobs/{job}/frame.png?output={output}&exposure=-1.5")
            assert picture.status == 200 and picture.body[:8] == PNG_MAGIC, output
        assert daemon.get(f"/v1/jobs/{job}/frame.png?output=albedo").status == 422
        assert daemon.get(f"/v1/jobs/{job}/frame.exr?outputs=albedo").status == 422
        some = daemon.frame(job, "&outputs=depth")
        assert len(some) < len(daemon.frame(job))
        assert daemon.frame(job, "&layout=multipart") != daemon.frame(job)
        floats = daemon.frame(job, "&pixels=float")
        assert len(floats) > len(daemon.frame(job)) == len(daemon.frame(job, "&pixels=half"))


def test_a_finished_frame_is_one_thing_that_can_be_fetched_in_parts():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 4})
        whole = daemon.get(f"/v1/jobs/{job}/frame.exr?wait=done")
        etag = whole.headers["ETag"]
        path = f"/v1/jobs/{job}/frame.exr"
        assert daemon.get(path, {"If-None-Match": etag}).status == 304
        part = daemon.get(path, {"Range": "bytes=10-19", "If-Range": etag})
        assert part.status == 206 and part.body == whole.body[10:20]
        assert part.headers["Content-Range"] == f"bytes 10-19/{len(whole.body)}"
        assert part.headers["Repr-Digest"] == whole.headers["Repr-Digest"]
        rest = daemon.get(path, {"Range": "bytes=-7"})
        assert rest.body == whole.body[-7:]
        assert daemon.get(path, {"Range": f"bytes={len(whole.body)}-"}).status == 416
        assert daemon.get(path, {"Range": "bytes=1-2", "If-Range": '"x"'}).status == 200
        head = daemon.ask("HEAD", path)
        assert int(head.headers["Content-Length"]) == len(whole.body) and not head.body


def test_the_same_job_gives_the_same_bytes_with_1_2_and_3_workers():
    frames = []
    for threads in (1, 2, 3):
        with Daemon("--threads", str(threads)) as daemon:
            daemon.put("room", ROOM)
            job = daemon.submit(scene="room", stop={"samples": 48}, seed=7)
            frames.append(daemon.frame(job))
            again = daemon.submit(scene="room", stop={"samples": 48}, seed=7)
            assert daemon.frame(again) == frames[-1]
            other = daemon.submit(scene="room", stop={"samples": 48}, seed=8)
            assert daemon.frame(other) != frames[-1]
    assert frames[0] == frames[1] == frames[2]


def test_a_cancelled_job_keeps_its_pixels_until_it_is_forgotten():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 1000000})
        daemon.until(job, lambda j: j["samples"] > 0)
        assert daemon.delete(f"/v1/jobs/{job}").status == 202
        daemon.until(job, lambda j: j["state"] == "cancelled")
        assert daemon.get(f"/v1/jobs/{job}/frame.exr").body[:4] == EXR_MAGIC
        assert daemon.get(f"/v1/jobs/{job}/frame.exr?wait=done").status == 409
        assert daemon.delete(f"/v1/jobs/{job}").status == 204
        assert daemon.get(f"/v1/jobs/{job}").status == 404
        assert daemon.get(f"/v1/jobs/{job}/frame.exr").status == 404


def test_waiting_ends_when_the_job_is_cancelled():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 1000000})
        answers = []
        waiting = threading.Thread(target=lambda: answers.append(
            daemon.get(f"/v1/jobs/{job}/frame.exr?wait=done")))
        waiting.start()
        daemon.until(job, lambda j: j["samples"] > 0)
        assert not answers
        daemon.delete(f"/v1/jobs/{job}")
        waiting.join()
        assert answers[0].status == 409


def test_two_jobs_share_the_workers():
    with Daemon("--threads", "2") as daemon:
        daemon.put("room", ROOM)
        jobs = [daemon.submit(scene="room", stop={"samples": 1000000}) for _ in range(2)]
        for job in jobs:
            daemon.until(job, lambda j: j["samples"] >= 16)
        start = [daemon.job(job)["samples"] for job in jobs]
        daemon.until(jobs[0], lambda j: j["samples"] >= start[0] + 256)
        done = [daemon.job(job)["samples"] - s for job, s in zip(jobs, start)]
        assert 0.5 < done[0] / done[1] < 2, done
        for job in jobs:
            daemon.delete(f"/v1/jobs/{job}")


def patch(daemon, job, body):
    return daemon.ask("PATCH", f"/v1/jobs/{job}", json.dumps(body).encode(),
                      {"Content-Type": "application/merge-patch+json"})


def done(state):
    return state["state"] == "done"


def test_more_samples_continue_a_finished_job_to_the_bytes_of_one_run():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        whole = daemon.submit(scene="room", stop={"samples": 40}, seed=3)
        job = daemon.submit(scene="room", stop={"samples": 7}, seed=3)
        first = daemon.frame(job)
        spent = daemon.job(job)["rays"]["camera"]
        answer = patch(daemon, job, {"stop": {"samples": 40}})
        assert answer.status == 200 and answer.json()["job"]["stop"] == {"samples": 40}
        frame = daemon.frame(job)
        state = daemon.job(job)
        assert state["samples"] == 40
        assert frame == daemon.frame(whole) != first
        # The seven that were there were not taken again.
        assert state["rays"]["camera"] == daemon.job(whole)["rays"]["camera"] > spent
        assert patch(daemon, job, {"stop": {"samples": 12}}).status == 409
        assert patch(daemon, job, {"stop": {"samples": 40}}).status == 200  # said twice
        assert patch(daemon, job, {"stop": {"samples": 0}}).pointers() == ["/stop/samples"]


def test_a_job_that_does_not_know_its_error_tells_none_and_stops_by_none():
    with Lasting() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", estimate="none", stop={"samples": 24}, seed=3)
        frame, state = daemon.frame(job), daemon.job(job)
        assert state["job"]["estimate"] == "none" and state["samples"] == 24
        assert state["error"] is None and state["estimate"]["interval"] == [None, None], state["estimate"]
        assert not state["estimate"]["rare_events"]
        assert daemon.get(f"/v1/jobs/{job}/convergence").json()["curve"] == []
        assert patch(daemon, job, {"stop": {"error": 0.1}}).pointers() == ["/stop/error"]
        assert patch(daemon, job, {"stop": {"samples": 40}}).status == 200
        more = daemon.frame(job)
        assert daemon.job(job)["samples"] == 40 and more != frame
        assert more != daemon.frame(daemon.submit(scene="room", stop={"samples": 40}, seed=3))
        daemon.restart()
        assert daemon.frame(job) == more and daemon.job(job)["error"] is None


def test_a_cancelled_job_goes_on_to_the_bytes_of_one_run():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 1000000}, seed=5)
        daemon.until(job, lambda j: j["samples"] > 0)
        daemon.delete(f"/v1/jobs/{job}")
        daemon.until(job, lambda j: j["state"] == "cancelled")
        more = {"samples": daemon.job(job)["samples"] + 20}
        assert patch(daemon, job, {"stop": more}).status == 200
        whole = daemon.submit(scene="room", stop=more, seed=5)
        assert daemon.frame(job) == daemon.frame(whole)


def test_a_finished_job_goes_on_after_a_restart():
    with Lasting() as daemon:
        daemon.put("room", ROOM)
        whole = daemon.frame(daemon.submit(scene="room", stop={"samples": 40}, seed=3))
        job = daemon.submit(scene="room", stop={"samples": 7}, seed=3)
        daemon.frame(job)
        rays = daemon.job(job)["rays"]["camera"]
        daemon.wait(lambda: (daemon.job(job)["checkpoint"] or {}).get("samples") == 7, "no last film")
        daemon.kill()
        daemon.start()
        assert patch(daemon, job, {"stop": {"samples": 5}}).status == 409
        assert patch(daemon, job, {"stop": {"samples": 40}}).status == 200
        assert daemon.frame(job) == whole
        assert daemon.job(job)["rays"]["camera"] > rays


def test_a_job_tells_what_of_it_is_on_the_disk():
    with Lasting("--checkpoint-seconds", "0.1") as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 1000000})
        daemon.wait(lambda: daemon.job(job)["checkpoint"], "no checkpoint")
        first = daemon.job(job)["checkpoint"]
        daemon.wait(lambda: daemon.job(job)["checkpoint"]["samples"] > first["samples"], "no other")
        state = daemon.job(job)
        assert state["checkpoint"]["samples"] <= state["samples"]
        assert state["created"] <= state["checkpoint"]["written"]
        daemon.delete(f"/v1/jobs/{job}")


def test_a_finished_job_whose_scene_is_gone_stays_finished():
    with Lasting() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 4})
        frame = daemon.frame(job)
        assert daemon.delete("/v1/scenes/room").status == 204
        daemon.stop()
        daemon.start()
        # What nobody needs is collected a moment after; until then the job could go on.
        daemon.wait(lambda: not daemon.rows("SELECT id FROM revision"), "the scene is still kept")
        answer = patch(daemon, job, {"stop": {"samples": 8}})
        assert answer.status == 409, answer.body
        assert daemon.job(job)["state"] == "done" and daemon.frame(job) == frame


def test_who_is_preempted_goes_on_to_the_same_bytes():
    with Daemon("--threads", "2") as daemon:
        daemon.put("room", ROOM)
        twin = daemon.frame(daemon.submit(scene="room", stop={"samples": 48}, seed=1))
        low = daemon.submit(scene="room", stop={"samples": 48}, seed=1)
        high = daemon.submit(scene="room", stop={"samples": 64}, seed=2, priority=5)
        daemon.until(high, done)
        assert daemon.frame(low) == twin


def test_a_client_with_one_job_gets_as_much_as_one_with_many():
    with Daemon("--threads", "2") as daemon:
        daemon.put("room", ROOM)
        body = {"scene": "room", "resolution": [128, 96], "stop": {"samples": 1000000}}
        many = [daemon.post(body, {"Glint-Client": "many"}).json()["id"] for _ in range(5)]
        one = daemon.post(body, {"Glint-Client": "one"}).json()["id"]
        for job in many + [one]:
            daemon.until(job, lambda j: j["samples"] >= 4)
        def spent(jobs):
            return sum(daemon.job(job)["worker_seconds"] for job in jobs)
        start = spent(many), spent([one])
        daemon.until(one, lambda j: spent([one]) >= start[1] + 1)
        assert 0.7 < (spent(many) - start[0]) / (spent([one]) - start[1]) < 1.4
        assert {j["client"] for j in daemon.get("/v1/jobs?client=one").json()["jobs"]} == {"one"}


def test_jobs_are_listed_by_state_and_client_a_page_at_a_time():
    with Lasting() as daemon:
        daemon.put("room", ROOM)
        body = {"scene": "room", "resolution": [64, 64], "stop": {"samples": 1}}
        jobs = [daemon.post(body, {"Glint-Client": c}).json()["id"] for c in ("a", "b", "a", "a")]
        for job in jobs:
            daemon.until(job, done)
            daemon.wait(lambda: daemon.job(job)["checkpoint"], "nothing of it is kept")

        def listed(query):
            answer = daemon.get(f"/v1/jobs?{query}").json()
            return [j["id"] for j in answer["jobs"]], answer["next"]
        assert listed("") == (jobs, None)
        assert listed("client=a") == ([jobs[0], jobs[2], jobs[3]], None)
        assert listed("state=queued,rendering") == ([], None)
        assert listed("state=failed,done&limit=3") == (jobs[:3], jobs[2])
        assert listed(f"limit=3&after={jobs[2]}") == (jobs[3:], None)
        assert listed(f"limit=1&client=a&after={jobs[0]}") == ([jobs[2]], jobs[2])
        bad = daemon.get("/v1/jobs?state=done,smiling&limit=-1&colour=1")
        assert bad.status == 422 and len(bad.json()["errors"]) == 3, bad.body
        assert daemon.get("/v1/jobs?after=nobody").status == 422
        whole = daemon.get("/v1/jobs")
        assert daemon.get("/v1/jobs", {"If-None-Match": whole.headers["ETag"]}).status == 304


def test_a_job_names_the_request_that_brought_it():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        body = {"scene": "room", "resolution": [64, 64], "stop": {"samples": 1}}
        job = daemon.post(body, {"X-Request-Id": "shot-7.take-2"}).json()
        assert job["request"] == "shot-7.take-2" and job["client"] == ""
        assert job["memory_bytes"] > 64 * 64 * 16


def test_the_house_tells_what_it_does():
    with Daemon("--threads", "2") as daemon:
        daemon.put("room", ROOM)
        idle = daemon.get("/v1/stats").json()
        assert [w["job"] for w in idle["workers"]] == [None, None]
        job = daemon.submit(scene="room", stop={"samples": 1000000})
        daemon.until(job, lambda j: j["samples"] >= 16)
        busy = daemon.get("/v1/stats").json()
        assert job in [w["job"] for w in busy["workers"]]
        assert max(w["busy"] for w in busy["workers"]) > 0
        assert busy["jobs"]["rendering"] == 1 and busy["slices"] > 0
        memory = busy["memory"]
        assert 0 < memory["film_bytes"] + memory["scene_bytes"] < memory["limit_bytes"]
        assert memory["limit_bytes"] < memory["machine_bytes"] and memory["resident_bytes"] > 0
        daemon.delete(f"/v1/jobs/{job}")
        daemon.until(job, lambda j: j["state"] == "cancelled")
        after = daemon.get("/v1/stats").json()
        assert after["memory"]["film_bytes"] == 0 < after["memory"]["ended_film_bytes"]


def test_what_can_never_fit_is_refused_with_figures():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        answer = daemon.post({"scene": "room", "resolution": [16384, 16384],
                              "outputs": ["beauty", "depth", "normal", "albedo", "crypto_object"]})
        assert answer.status == 507 and answer.pointers() == ["/resolution"], answer.body
        assert "GiB" in answer.json()["errors"][0]["detail"]
        assert daemon.get("/v1/jobs").json()["jobs"] == []


def test_a_repeated_submission_is_one_job():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        body = {"scene": "room", "resolution": [64, 64], "stop": {"samples": 1}}
        key = {"Idempotency-Key": "farm-17-3"}
        first, second = daemon.post(body, key), daemon.post(body, key)
        assert first.status == second.status == 202
        assert first.json()["id"] == second.json()["id"]
        assert second.headers["Idempotent-Replayed"] == "true"
        assert daemon.post({**body, "seed": 1}, key).status == 422
        assert len(daemon.get("/v1/jobs").json()["jobs"]) == 1
        daemon.frame(first.json()["id"])
        assert daemon.delete("/v1/scenes/room").status == 204
        third = daemon.post(body, key)  # its answer may have been lost, whatever was deleted since
        assert third.status == 202 and third.json()["id"] == first.json()["id"]
        assert daemon.post(body).status == 422
        assert daemon.post({**body, "resolution": [0, 64]}).body.count(b'"pointer"') == 2


def test_the_plan_and_the_curve_are_told():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 16})
        daemon.frame(job)
        plan = daemon.get(f"/v1/jobs/{job}/plan").json()
        assert all(effect["reason"] for effect in plan["effects"])
        curve = daemon.get(f"/v1/jobs/{job}/convergence").json()["curve"]
        assert [p["samples"] for p in curve] == sorted({p["samples"] for p in curve})
        assert curve[-1]["samples"] <= 16 and curve[-1]["rays"] > 0
        told = daemon.job(job)["invariants"]
        assert told["sound"] and not any(told["rejected"].values())
        assert told["bright"] == told["coverage_lost"] == told["coverage_clamped"] == 0


def test_a_job_says_what_its_files_have_no_rank_for():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        few = daemon.submit(scene="room", stop={"samples": 16}, mattes={"levels": 1})
        enough = daemon.submit(scene="room", stop={"samples": 16}, mattes={"levels": "auto"})
        daemon.frame(few)
        daemon.frame(enough)
        told = daemon.job(few)
        assert told["ranks"]["pixels"] > 0 and 0.02 < told["ranks"]["left_out"] < 1
        assert told["ranks"]["needed"] in (2, 4, 6)
        of_ranks = [w for w in told["warnings"] if "1 ranks" in w]
        assert len(of_ranks) == 1 and f"\"levels\": {told['ranks']['needed']}" in of_ranks[0]
        told = daemon.job(enough)
        assert told["job"]["mattes"]["levels"] == "auto" and not told["warnings"]
        assert told["ranks"] == {"pixels": 0, "left_out": 0, "needed": 6}


def test_mattes_are_listed_drawn_and_picked():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 16})
        daemon.frame(job)
        layers = daemon.get(f"/v1/jobs/{job}/mattes").json()["layers"]
        assert set(layers) == {"object", "material", "asset"}
        seen = {n["name"]: n["coverage"] for n in layers["object"]["names"] if n["coverage"] > 0}
        assert {"ball", "cube", "floor", "wall"} <= set(seen)
        assert sum(seen.values()) <= 128 * 96 + 1e-3
        path = f"/v1/jobs/{job}/matte"
        assert daemon.get(f"{path}.png?name=ball").body[:8] == PNG_MAGIC
        assert daemon.get(f"{path}.exr?layer=asset&name=toys").body[:4] == EXR_MAGIC
        assert daemon.get(f"{path}.exr?name=ball&name=cube").status == 200
        assert daemon.get(f"{path}.exr?name=nobody").status == 404
        assert daemon.get(f"{path}.exr?name=ball&through=reflection").status == 422
        assert daemon.get(f"{path}.exr?layer=object").status == 422
        under = daemon.get(f"/v1/jobs/{job}/pick?x=64&y=90").json()["primary"]["object"]
        assert under[0]["name"] == "floor" and abs(under[0]["coverage"] - 1) < 1e-3
        assert daemon.get(f"/v1/jobs/{job}/pick?x=128&y=0").status == 422


def attributes(exr):
    """{name: value} of the header of a file of one part."""
    found, at = {}, 8
    while exr[at]:
        name, kind, rest = exr[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = int.from_bytes(exr[at:at + 4], "little")
        found[name.decode()] = exr[at + 4:at + 4 + size]
        at += 4 + size
    return found


def test_a_matte_tells_of_its_frame_what_the_frame_tells():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 4}, seed=9)
        frame = attributes(daemon.frame(job))
        matte = attributes(daemon.get(f"/v1/jobs/{job}/matte.exr?name=ball").body)
        same = {"software", "chromaticities", "worldToCamera", "worldToNDC",
                *(name for name in frame if name.startswith("glint/"))}
        assert {"glint/samples", "glint/seed", "glint/sceneHash", "glint/complete"} < same
        assert {name: matte.get(name) for name in same} == {name: frame[name] for name in same}
        assert matte["glint/samples"] == bytes([4, 0, 0, 0])


def test_without_a_matte_output_every_matte_is_a_fault_of_the_same_kind():
    with Daemon() as daemon:
        daemon.put("room", ROOM)
        job = daemon.submit(scene="room", stop={"samples": 1}, outputs=["beauty"])
        daemon.frame(job)
        for call in ("matte.png?name=ball", "matte.exr?name=ball", "pick?x=1&y=1",
                     "mattes?layer=object"):
            answer = daemon.get(f"/v1/jobs/{job}/{call}")
            assert answer.status == 422 and answer.pointers() == [""], (call, answer.body)
            for output in ("crypto_object", "crypto_material", "crypto_asset"):
                assert output in answer.json()["errors"][0]["detail"], (call, answer.body)


if __name__ == "__main__":
    tap.main()
