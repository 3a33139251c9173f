"""State folders that cannot be used, and disks that take no more: nothing is destroyed, and the
daemon says what is wrong."""
import contextlib
import hashlib
import json
import os
import resource
import shutil
import sqlite3
import subprocess
import tempfile
import time

import daemon
import tap
from daemon import ROOM
from lasting import Lasting

LIMIT = 768 * 1024  # bytes that a file may have where the disk stands for full


def content(folder):
    """Every file but the log and the lock, by name."""
    found = {}
    for root, _, names in os.walk(folder):
        for name in names:
            if name not in ("log", "lock") and not name.startswith("journal.db-"):
                with open(os.path.join(root, name), "rb") as file:
                    found[os.path.relpath(os.path.join(root, name), folder)] = file.read()
    return found


def used(d):
    """A state folder with something in it, and nobody at it."""
    d.put("room", ROOM)
    d.frame(d.submit(scene="room", stop={"samples": 2}))
    assert d.stop() == 0


def test_a_second_daemon_is_refused():
    with Lasting() as d:
        code, said = d.refusal()
        assert code != 0
        assert "in use by another glintd" in said and str(d.process.pid) in said
        assert d.get("/readyz").status == 200


def test_a_newer_journal_is_refused_and_left_as_it_is():
    with Lasting() as d:
        used(d)
        connection = sqlite3.connect(d.path("journal.db"))
        connection.execute("PRAGMA user_version=99")
        connection.close()
        before = content(d.state)
        code, said = d.refusal()
        assert code != 0
        assert "newer" in said and "99" in said
        assert content(d.state) == before


def test_a_foreign_database_is_refused_and_left_as_it_is():
    with Lasting() as d:
        assert d.stop() == 0
        for name in os.listdir(d.state):
            if name.startswith("journal.db"):
                os.unlink(d.path(name))
        connection = sqlite3.connect(d.path("journal.db"))
        connection.execute("CREATE TABLE recipes(name TEXT)")
        connection.commit()
        connection.close()
        before = content(d.state)
        code, said = d.refusal()
        assert code != 0
        assert "no journal of glintd" in said
        assert content(d.state) == before


def test_a_damaged_journal_is_refused_and_left_as_it_is():
    for damage in (lambda file: file.truncate(5000), lambda file: file.write(b"\xff" * 4096),
                   lambda file: (file.seek(4096), file.write(b"\xa5" * 20000))):
        with Lasting() as d:
            used(d)
            with open(d.path("journal.db"), "r+b") as file:
                damage(file)
            before = content(d.state)
            code, said = d.refusal()
            assert code != 0
            assert "journal.db" in said and ("damaged" in said or "no journal" in said), said
            assert content(d.state) == before


def test_a_folder_that_cannot_be_written_is_refused():
    with Lasting() as d:
        assert d.stop() == 0
        shutil.rmtree(d.path("assets"))
        with open(d.path("assets"), "w", encoding="utf-8") as file:
            file.write("in the way")
        code, said = d.refusal()
        assert code != 0
        assert "assets" in said
        os.unlink(d.path("assets"))
        d.start()


@contextlib.contextmanager
def small_disk(mebibytes):
    """A folder on a file system of its own."""
    folder = tempfile.mkdtemp(prefix="glint-disk-")
    mount = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={mebibytes}m", "none", folder],
                           capture_output=True, text=True, check=False)
    if mount.returncode:
        os.rmdir(folder)
        raise tap.Skip(f"no file system can be mounted: {mount.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)
        os.rmdir(folder)


def fill(folder):
    fd = os.open(os.path.join(folder, "ballast"), os.O_WRONLY | os.O_CREAT)
    with contextlib.suppress(OSError):
        while True:
            os.write(fd, b"\0" * 4096)
    os.close(fd)


def check_refused(d, blob, name):
    refused = d.ask("PUT", f"/v1/assets/{name}", blob)
    assert refused.status == 507, refused.body
    assert "MiB are free" in refused.json()["detail"]
    assert d.get(f"/v1/assets/{name}").status == 404


def check_not_kept(d, job):
    """What renders goes on, and says that it is not kept."""
    said = []
    d.wait(lambda: said.extend(w for w in d.job(job)["warnings"] if "not being kept" in w) or said,
           "a warning")
    parts = said[-1].split("; ")[0].split(": ")
    assert len(parts) == len(set(parts)), f"it gives a reason twice: {said[-1]}"
    assert d.metric('glint_checkpoint_total{result="failed"}') >= 1
    assert "not kept" in d.logged()
    samples = d.job(job)["samples"]
    d.wait(lambda: d.job(job)["samples"] > samples, "the job goes on")
    d.wait(lambda: not [f for f in d.films() if f.endswith(".new")], "nothing half written stays")


def test_a_full_disk_stops_no_job_and_takes_no_more():
    with small_disk(12) as folder, Lasting("--checkpoint-seconds", "0.2", state=folder) as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", stop={"samples": 60000})
        d.until(job, lambda j: j["samples"] >= 1)
        fill(folder)
        blob = os.urandom(2 << 20)
        name = hashlib.sha256(blob).hexdigest()
        check_refused(d, blob, name)
        check_not_kept(d, job)
        os.unlink(os.path.join(folder, "ballast"))
        assert d.ask("PUT", f"/v1/assets/{name}", blob).status == 201
        d.wait(lambda: not d.job(job)["warnings"], "it is kept again")
        d.kill()
        d.start()
        assert d.job(job)["state"] in ("queued", "rendering")
        d.delete(f"/v1/jobs/{job}")


def test_files_that_may_not_grow_are_like_a_full_disk():
    """No mount is needed for this one: the limit of a file's size is that of the process."""
    with Lasting("--checkpoint-seconds", "0.2") as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", resolution=[320, 200], stop={"samples": 60000})
        d.until(job, lambda j: j["samples"] >= 1)
        resource.prlimit(d.process.pid, resource.RLIMIT_FSIZE, (LIMIT, resource.RLIM_INFINITY))
        check_not_kept(d, job)
        resource.prlimit(d.process.pid, resource.RLIMIT_FSIZE,
                         (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        d.wait(lambda: not d.job(job)["warnings"], "it is kept again")
        d.delete(f"/v1/jobs/{job}")


def test_submissions_that_cannot_be_kept_are_refused():
    with small_disk(8) as folder, Lasting(state=folder) as d:
        d.put("room", ROOM)
        fill(folder)
        full = None
        for i in range(400):  # the journal has room of its own for some
            answer = d.post({"scene": "room", "resolution": [16, 16], "name": "x" * 1000,
                             "stop": {"samples": 1}, "seed": i})
            if answer.status != 202:
                full = answer
                break
        assert full and full.status == 507, full and full.body
        assert "MiB are free" in full.json()["detail"]
        assert full.json()["type"].endswith("capacity") or full.json()["status"] == 507
        os.unlink(os.path.join(folder, "ballast"))
        assert d.post({"scene": "room", "resolution": [16, 16], "stop": {"samples": 1}}).status == 202


def test_a_damaged_file_of_a_scene_is_told_and_kept_aside():
    with Lasting() as d:
        d.put("sail", daemon.triangle_glb())
        assert d.stop() == 0
        files = [os.path.join(root, name) for root, _, names in os.walk(d.path("assets"))
                 for name in names]
        for path in files:
            with open(path, "r+b") as file:
                file.write(b"\0\1\2\3")
        d.start()
        d.wait(lambda: d.get("/v1/scenes/sail").json()["state"] == "failed", "it cannot be loaded")
        scene = d.get("/v1/scenes/sail").json()
        assert "damaged" in scene["problem"]
        refused = d.post({"scene": "sail"})
        assert refused.status == 500 and refused.json()["type"] == "/problems/damaged"
        assert "cannot be loaded" in d.logged()
        assert any(name.endswith(".torn") for _, _, names in os.walk(d.path("assets"))
                   for name in names)
        d.put("sail", daemon.triangle_glb())
        assert d.get("/v1/scenes/sail").json()["state"] == "resident"
        d.restart()
        d.wait(lambda: d.get("/v1/scenes/sail").json()["state"] == "resident", "it is back")


def test_a_job_that_cannot_be_read_back_is_listed_as_failed_and_left_as_it_is():
    with Lasting() as d:
        d.put("room", ROOM)
        job = d.submit(scene="room", stop={"samples": 2}, name="of a later version")
        before = d.get(f"/v1/jobs/{job}/frame.exr?wait=done").body
        assert d.stop() == 0
        with contextlib.closing(sqlite3.connect(d.path("journal.db"))) as connection, connection:
            connection.execute("UPDATE job SET text=json_insert(text, '$.colour', 1)")
        row, films = d.rows("SELECT * FROM job"), d.films()
        for _ in range(2):
            d.start()
            listed, = d.get("/v1/jobs").json()["jobs"]
            assert listed["id"] == job and listed["state"] == "failed", listed
            assert listed["problem"]["type"] == "/problems/damaged"
            assert "colour" in listed["problem"]["detail"]
            assert d.get(f"/v1/jobs/{job}/frame.exr").body == before
            assert d.stop() == 0
            assert d.rows("SELECT * FROM job") == row and d.films() == films
        d.start()
        assert d.delete(f"/v1/jobs/{job}").status == 204
        assert d.get("/v1/jobs").json()["jobs"] == []
        assert not d.rows("SELECT id FROM job")


def test_films_put_aside_are_kept_for_a_while_the_newest_few():
    with Lasting() as d:
        used(d)
        day = 86400
        for n in range(20):
            path = d.path("films", f"{n:032x}.1." + ("torn" if n % 2 else "newer"))
            with open(path, "w", encoding="utf-8") as file:
                file.write("film")
            os.utime(path, (time.time() - n * day,) * 2)
        old = d.path("films", "f" * 32 + ".1.torn")
        with open(old, "w", encoding="utf-8") as file:
            file.write("film")
        os.utime(old, (time.time() - 31 * day,) * 2)
        d.start()
        aside = [name for name in d.films() if name.endswith((".torn", ".newer"))]
        assert [int(name[:32], 16) for name in aside] == list(range(16)), aside


def test_what_a_kill_left_half_written_is_swept():
    with Lasting() as d:
        used(d)
        for name in (d.path("films", "0" * 32 + ".7"), d.path("films", "1" * 32 + ".1.new"),
                     d.path("assets", "ab", "ab" + "0" * 62 + ".new"),
                     d.path("assets", "ab", "ab" + "0" * 62)):
            with open(name, "w", encoding="utf-8") as file:
                file.write("half")
        d.start()
        d.wait(lambda: not os.listdir(d.path("assets", "ab")), "assets are swept")
        assert len(d.films()) == 1


if __name__ == "__main__":
    tap.main()
