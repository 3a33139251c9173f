"""What was accepted is there after a restart, and goes on where it stood."""
import hashlib
import json
import os
import signal

import tap
from daemon import ROOM, triangle_glb
from lasting import Lasting

SLOW = {"samples": 4096}
OFTEN = ("--checkpoint-seconds", "0.1")


def without(description, *names):
    return {key: value for key, value in description.items() if key not in names}


def settled(description):
    """Of a job that has ended, what must be the same after a restart."""
    return without(description, "eta_seconds", "checkpoint")


def test_scenes_are_listed_with_their_revision_after_a_kill():
    with Lasting() as d:
        d.put("room", ROOM)
        d.put("sail", triangle_glb())
        d.patch("/v1/scenes/room", {"instances": {"ball": {"transform": {"scale": [1, 1, 1]}}}})
        before = {s["name"]: s for s in d.get("/v1/scenes").json()["scenes"]}
        native = {name: d.get(f"/v1/scenes/{name}?format=native").body for name in before}
        d.kill()
        d.start()
        after = {s["name"]: s for s in d.get("/v1/scenes").json()["scenes"]}
        for name, scene in before.items():
            assert after[name]["revision"] == scene["revision"]
            assert after[name]["triangles"] == scene["triangles"]
            assert after[name]["created"] == scene["created"]
            assert d.get(f"/v1/scenes/{name}?format=native").body == native[name]
            assert d.get(f"/v1/scenes/{name}").json()["state"] == "resident"


def test_a_long_chain_of_patches_leads_to_the_same_text():
    with Lasting() as d:
        d.put("room", ROOM)
        for i in range(40):
            d.patch("/v1/scenes/room", {"environment": {"radiance": [i, 1, 1]},
                                        "materials": {"red": {"roughness": i / 40}}})
        native = d.get("/v1/scenes/room?format=native").body
        d.kill()
        assert max(depth for depth, in d.rows("SELECT depth FROM revision")) <= 32
        d.start()
        assert d.get("/v1/scenes/room?format=native").body == native


def test_a_deleted_scene_is_gone_with_its_files():
    with Lasting() as d:
        def files():
            return sum(len(names) for _, _, names in os.walk(d.path("assets")))

        d.put("room", ROOM)
        room = files()
        d.put("sail", triangle_glb())
        assert files() > room
        assert d.delete("/v1/scenes/sail").status == 204
        d.restart()
        assert [s["name"] for s in d.get("/v1/scenes").json()["scenes"]] == ["room"]
        d.wait(lambda: len(d.rows("SELECT id FROM revision")) == 1, "a revision that nobody needs")
        d.wait(lambda: files() == room, "files that nobody needs")


def mapped(d):
    with open(f"/proc/{d.process.pid}/maps", encoding="utf-8") as file:
        return sum(1 for _ in file)


# The system allows a process 65,530.
def test_small_assets_take_no_mapping_each_before_a_restart_or_after():
    with Lasting("--threads", "1") as d:
        before = mapped(d)
        bodies = [f"small {i}".encode() for i in range(80)]
        paths = [f"/v1/assets/{hashlib.sha256(body).hexdigest()}" for body in bodies]
        for path, body in zip(paths, bodies):
            assert d.ask("PUT", path, body).status == 201
        assert mapped(d) < before + 40
        d.restart()
        d.wait(lambda: all(d.ask("HEAD", path).status == 200 for path in paths), "all are back")
        assert mapped(d) < before + 40


def test_an_asset_outlives_the_daemon_that_took_it():
    body = b"asset" * 1000
    name = hashlib.sha256(body).hexdigest()
    with Lasting() as d:
        assert d.ask("PUT", f"/v1/assets/{name}", body).status == 201
        d.kill()
        d.start()
        d.wait(lambda: d.get(f"/v1/assets/{name}").status == 200, "the asset")
        assert d.ask("PUT", f"/v1/assets/{name}", body).status == 200


def test_a_finished_job_is_served_from_its_film():
    with Lasting() as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", stop={"samples": 16}, mattes={"levels": 1},
                       outputs=["beauty", "crypto_object", "normal", "variance"])
        frame = d.frame(job)
        mattes = d.get(f"/v1/jobs/{job}/mattes").json()
        pick = d.get(f"/v1/jobs/{job}/pick?x=64&y=48").json()
        before = settled(d.job(job))
        assert before["ranks"]["pixels"] and before["warnings"]
        d.restart()
        after = settled(d.job(job))
        assert after == before, [(k, before[k], after[k]) for k in before if after[k] != before[k]]
        assert d.frame(job) == frame
        assert d.get(f"/v1/jobs/{job}/mattes").json() == mattes
        assert d.get(f"/v1/jobs/{job}/pick?x=64&y=48").json() == pick
        # it does not need the scene
        assert d.delete("/v1/scenes/room").status == 204
        assert d.frame(job) == frame


def test_a_job_goes_on_from_its_film_to_the_same_frame():
    with Lasting(*OFTEN) as d:
        d.put("room", ROOM)
        whole = d.submit(scene="room", stop={"samples": 300}, seed=7)
        frame = d.frame(whole)
        job = d.submit(scene="room", stop={"samples": 300}, seed=7)
        d.wait(lambda: d.rows(f"SELECT film FROM job WHERE id='{job}'")[0][0], "a film")
        d.kill()
        kept = json.loads(d.rows(f"SELECT rendered FROM job WHERE id='{job}'")[0][0])["samples"]
        d.start()
        d.wait(lambda: d.job(job)["state"] != "queued", "the job goes on")
        assert d.job(job)["samples"] >= kept
        assert d.frame(job) == frame
        assert d.job(job)["samples"] == 300


def test_a_stopped_daemon_keeps_every_sample():
    with Lasting() as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", stop=SLOW)
        d.until(job, lambda j: j["samples"] >= 2)
        assert d.stop() == 0
        kept = json.loads(d.rows("SELECT rendered FROM job")[0][0])["samples"]
        assert kept >= 2
        d.start()
        first = d.until(job, lambda j: j["state"] == "rendering")
        assert first["samples"] >= kept
        assert first["seconds"] > 0


def test_queue_pause_priority_and_stop_are_as_they_were():
    with Lasting("--threads", "1") as d:
        d.put("room", ROOM)
        first = d.submit(scene="room", stop=SLOW, priority=5)
        second = d.submit(scene="room", stop=SLOW, name="second")
        paused = d.submit(scene="room", stop={"samples": 64})
        d.patch(f"/v1/jobs/{paused}", {"paused": True, "priority": -3, "stop": {"samples": 32}})
        cancelled = d.submit(scene="room", stop=SLOW)
        assert d.delete(f"/v1/jobs/{cancelled}").status == 202
        forgotten = d.submit(scene="room", stop=SLOW)
        d.delete(f"/v1/jobs/{forgotten}")
        d.wait(lambda: d.job(forgotten)["state"] == "cancelled", "a cancelled job")
        assert d.delete(f"/v1/jobs/{forgotten}").status == 204
        d.kill()
        d.start()
        jobs = d.get("/v1/jobs").json()["jobs"]
        assert [j["id"] for j in jobs] == [first, second, paused, cancelled]
        assert jobs[0]["priority"] == 5
        assert jobs[1]["name"] == "second"
        assert (jobs[2]["state"], jobs[2]["priority"]) == ("paused", -3)
        assert jobs[2]["job"]["stop"]["samples"] == 32
        assert jobs[3]["state"] == "cancelled"
        d.delete(f"/v1/jobs/{first}")
        d.delete(f"/v1/jobs/{second}")
        d.patch(f"/v1/jobs/{paused}", {"paused": False})
        d.frame(paused)
        assert d.job(paused)["samples"] == 32


def test_a_key_answers_the_same_job_after_a_restart():
    key = {"Idempotency-Key": "farm-7"}
    with Lasting() as d:
        d.put("room", ROOM)
        body = {"scene": "room", "resolution": [64, 48], "stop": {"samples": 2}}
        job = d.post(body, key).json()["id"]
        d.kill()
        d.start()
        again = d.post(body, key)
        assert again.status == 202 and again.json()["id"] == job
        assert again.headers["Idempotent-Replayed"] == "true"
        assert d.post({**body, "seed": 3}, key).status == 422
        assert len(d.get("/v1/jobs").json()["jobs"]) == 1


def test_a_job_keeps_its_revision_though_the_scene_moved_on():
    with Lasting(*OFTEN) as d:
        d.put("room", ROOM)
        revision = d.get("/v1/scenes/room").json()["revision"]
        job = d.submit(scene="room", stop={"samples": 200}, seed=3)
        d.patch("/v1/scenes/room", {"materials": {"red": {"base_color": [0, 1, 0]}}})
        d.kill()
        d.start()
        frame = d.frame(job)
        assert d.job(job)["revision"] == revision
        d.put("other", ROOM)
        assert d.frame(d.submit(scene="other", stop={"samples": 200}, seed=3)) == frame


def test_a_live_job_is_where_its_scene_and_camera_are():
    with Lasting() as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", live=True, stop={"samples": 8})
        camera = {"yfov": 0.5, "transform": {"translation": [0, 1, 4]}}
        d.patch(f"/v1/jobs/{job}", {"camera": camera})
        d.patch("/v1/scenes/room", {"materials": {"red": {"base_color": [0, 1, 0]}}})
        revision = d.get("/v1/scenes/room").json()["revision"]
        d.kill()
        d.start()
        d.wait(lambda: d.job(job)["samples"] == 8, "the live job shows its scene")
        seen = d.job(job)
        assert seen["revision"] == revision
        assert seen["job"]["camera"] == camera


def test_a_finished_job_takes_more_samples_after_a_restart():
    with Lasting() as d:
        d.put("room", ROOM)
        whole = d.frame(d.submit(scene="room", stop={"samples": 24}, seed=2))
        job = d.submit(scene="room", stop={"samples": 8}, seed=2)
        d.frame(job)
        d.restart()
        d.patch(f"/v1/jobs/{job}", {"stop": {"samples": 24}})
        d.wait(lambda: d.job(job)["samples"] == 24, "the samples")
        assert d.frame(job) == whole


def torn(path):
    with open(path, "r+b") as file:
        file.truncate(os.path.getsize(path) // 2)


def test_a_torn_film_is_put_aside_and_the_one_before_goes_on():
    with Lasting(*OFTEN) as d:
        d.put("room", ROOM)
        frame = d.frame(d.submit(scene="room", stop={"samples": 400}, seed=7))
        job = d.submit(scene="room", stop={"samples": 400}, seed=7)
        d.wait(lambda: d.rows(f"SELECT film_before FROM job WHERE id='{job}'")[0][0], "two films")
        d.kill()
        film, before = d.rows(f"SELECT film, film_before FROM job WHERE id='{job}'")[0]
        assert before
        torn(d.path("films", f"{job}.{film}"))
        d.start()
        assert d.frame(job) == frame
        assert f"{job}.{film}.torn" in d.films()
        assert any("lost" in w for w in d.job(job)["warnings"])


def test_without_any_film_a_job_begins_anew():
    with Lasting(*OFTEN) as d:
        d.put("room", ROOM)
        frame = d.frame(d.submit(scene="room", stop={"samples": 200}, seed=7))
        job = d.submit(scene="room", stop={"samples": 200}, seed=7)
        d.wait(lambda: any(f.startswith(job) for f in d.films()), "a film")
        d.kill()
        for film in d.films():
            if film.startswith(job):
                torn(d.path("films", film))
        d.start()
        assert d.frame(job) == frame


def test_sigusr1_writes_films_now():
    with Lasting() as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", stop=SLOW)
        d.until(job, lambda j: j["samples"] >= 1)
        assert not d.films()
        d.process.send_signal(signal.SIGUSR1)
        d.wait(lambda: f"{job}.1" in d.films(), "a film")
        d.wait(lambda: d.metric('glint_checkpoint_total{result="kept"}') >= 1, "it is counted")
        d.delete(f"/v1/jobs/{job}")


def test_forgotten_jobs_leave_no_film():
    with Lasting() as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", stop={"samples": 2})
        d.frame(job)
        d.wait(d.films, "the last film")
        assert d.delete(f"/v1/jobs/{job}").status == 204
        assert not d.films()
        assert not d.rows("SELECT id FROM job")


if __name__ == "__main__":
    tap.main()
