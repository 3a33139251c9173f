#!/usr/bin/python3
"""glint merge: films of two daemons' jobs become the frame of one, byte for byte."""
import json
import os
import sys
import tempfile

import cli
import tap

sys.path.insert(0, tap.source("tests", "http"))
from daemon import ROOM, Daemon  # pylint: disable=wrong-import-position

OUTPUTS = ["beauty", "variance", "samples", "depth", "normal", "albedo", "motion", "crypto_object",
           "crypto_material", "crypto_asset"]
WIDTH, HEIGHT = 90, 52


class Farm:
    """Two daemons with one scene, a folder, and what one run makes of it."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.daemons = [Daemon("--threads", "1").__enter__() for _ in range(2)]
        for daemon in self.daemons:
            daemon.put("room", ROOM)
        return self

    def __exit__(self, *error):
        for daemon in self.daemons:
            daemon.__exit__(*error)
        self.folder.cleanup()

    def __truediv__(self, name):
        return os.path.join(self.folder.name, name)

    def job(self, which, **members):
        job = {"scene": "room", "resolution": [WIDTH, HEIGHT], "outputs": OUTPUTS, "seed": 5}
        return self.daemons[which].submit(**{**job, **members})

    def film(self, name, which, **members):
        job = self.job(which, **members)
        run = cli.glint("get", job, "-w", "-o", self / name, server=self.daemons[which].url)
        assert run.returncode == 0, run.stderr
        return self / name

    def whole(self, **members):
        job = self.job(0, **members)
        answer = self.daemons[0].get(f"/v1/jobs/{job}/frame.exr?wait=done")
        assert answer.status == 200, answer.body
        return answer.body

    def merge(self, *arguments, expect=0):
        run = cli.glint("merge", *arguments)
        assert run.returncode == expect, (run.returncode, run.stdout, run.stderr)
        return run


def read(path):
    with open(path, "rb") as file:
        return file.read()


def test_regions_and_sample_ranges_of_two_daemons_make_the_frame_of_one_run():
    with Farm() as farm:
        whole = farm.whole(stop={"samples": 18})
        left = farm.film("left.film", 0, region=[0, 0, 41, HEIGHT], stop={"samples": 18})
        right = farm.film("right.film", 1, region=[41, 0, WIDTH - 41, HEIGHT], stop={"samples": 18})
        run = farm.merge(right, left, "-o", farm / "regions.exr")
        assert read(farm / "regions.exr") == whole
        assert run.stderr == "" and "regions.exr" in run.stdout

        ranges = [farm.film(f"{first}.film", first % 2, sample_range=[first, end])
                  for first, end in ((0, 5), (5, 16), (16, 18))]
        farm.merge(*ranges, "-o", farm / "ranges.exr")
        assert read(farm / "ranges.exr") == whole

        top = [farm.film(f"top{first}.film", first % 2, sample_range=[first, end],
                         region=[0, 0, WIDTH, 20]) for first, end in ((0, 9), (9, 18))]
        rest = farm.film("rest.film", 1, region=[0, 20, WIDTH, HEIGHT - 20], stop={"samples": 18})
        farm.merge(*top, "--film", farm / "top.film")
        farm.merge(rest, farm / "top.film", "-o", farm / "mixed.exr")
        assert read(farm / "mixed.exr") == whole


def test_outputs_layout_and_pixels_are_those_of_the_daemon():
    with Farm() as farm:
        parts = [farm.film(f"{first}.film", first % 2, sample_range=[first, end])
                 for first, end in ((0, 3), (3, 4))]
        whole = farm.job(0, stop={"samples": 4})
        frame = farm.daemons[0].frame(whole, "&outputs=beauty,depth,crypto_object&layout=multipart"
                                        "&pixels=float")
        farm.merge(*parts, "-o", farm / "some.exr", "--layout", "multipart",
                   "--outputs", "beauty,depth,crypto_object", "--pixels", "float")
        assert read(farm / "some.exr") == frame


def test_what_does_not_fit_is_refused_with_every_reason_and_no_file():
    with Farm() as farm:
        one = farm.film("one.film", 0, sample_range=[0, 4])
        same = farm.film("same.film", 1, sample_range=[3, 6])
        seed = farm.film("seed.film", 1, sample_range=[6, 8], seed=6)
        run = farm.merge(one, same, seed, "-o", farm / "no.exr", expect=1)
        assert "both have samples 3 to 4" in run.stderr, run.stderr
        assert "6 of " in run.stderr and "is not 5" in run.stderr, run.stderr
        late = farm.film("late.film", 1, sample_range=[8, 9])
        run = farm.merge(one, late, "-o", farm / "no.exr", expect=1)
        assert "have not all samples from 0 to 9" in run.stderr, run.stderr
        assert not os.path.exists(farm / "no.exr")
        run = farm.merge(one, late, "--partial", "-o", farm / "partial.exr", "--json")
        assert json.loads(run.stdout)["complete"] is False
        farm.merge(one, late, "--partial", "--film", farm / "no.film", expect=1)
        assert not os.path.exists(farm / "no.film")


def test_films_of_adaptive_jobs_are_refused_by_name():
    with Farm() as farm:
        left = farm.film("left.film", 0, region=[0, 0, 41, HEIGHT], stop={"samples": 64})
        right = farm.film("right.film", 1, region=[41, 0, WIDTH - 41, HEIGHT], adaptive=True,
                          stop={"samples": 64})
        for partial in ([], ["--partial"]):
            run = farm.merge(left, right, *partial, "-o", farm / "no.exr", expect=1)
            assert "right.film is of an adaptive job" in run.stderr, run.stderr
            assert "left.film is of" not in run.stderr and not os.path.exists(farm / "no.exr")
        asked = {"scene": "room", "adaptive": True, "sample_range": [0, 32]}
        refused = farm.daemons[0].post(asked)  # nor is such a part rendered
        assert refused.status == 422 and refused.pointers() == ["/adaptive"], refused.body


def test_files_that_are_no_films_are_each_named():
    with Farm() as farm:
        film = farm.film("a.film", 0, sample_range=[0, 2])
        with open(farm / "torn.film", "wb") as file:
            file.write(read(film)[:-1])
        with open(farm / "later.film", "wb") as file:
            bytes_ = read(film)
            file.write(bytes_[:8] + bytes([bytes_[8] + 1]) + bytes_[9:])
        run = farm.merge(film, farm / "torn.film", farm / "later.film", farm / "none.film",
                         "-o", farm / "no.exr", expect=1)
        for reason in ("torn.film: the film is torn", "later.film: the film is of version 3",
                       "versions up to 2", "none.film: No such file"):
            assert reason in run.stderr, run.stderr


def test_a_command_line_that_asks_for_nothing_is_wrong_usage():
    assert cli.glint("merge", "a.film").returncode == 64
    assert cli.glint("merge", "-o", "a.exr").returncode == 64
    assert cli.glint("merge", "a.film", "-o", "a.png").returncode == 64
    assert cli.glint("merge", "a.film", "-o", "a.exr", "--outputs", "beauti").returncode == 64


def test_the_film_of_an_ended_job_has_a_digest_and_ranges():
    with Farm() as farm:
        job = farm.job(0, sample_range=[0, 3])
        daemon = farm.daemons[0]
        path = f"/v1/jobs/{job}/film"
        whole = daemon.get(path + "?wait=done")
        assert whole.status == 200 and whole.body[:8] == b"GLNTFILM"
        assert whole.headers["Content-Type"] == "application/vnd.glint.film"
        assert whole.headers["Repr-Digest"].startswith("sha-256=:")
        again = daemon.get(path, headers={"If-None-Match": whole.headers["ETag"]})
        assert again.status == 304
        part = daemon.get(path, headers={"Range": "bytes=8-11"})
        assert part.status == 206 and part.body == whole.body[8:12] == b"\x02\0\0\0"
        assert daemon.get("/v1/jobs/nothing/film").status == 404


def test_the_film_of_a_running_job_is_one_moment_of_it():
    with Farm() as farm:
        job = farm.job(0, stop={"samples": 100000})
        daemon = farm.daemons[0]
        daemon.until(job, lambda state: state["samples"] >= 4)
        film = farm / "running.film"
        with open(film, "wb") as file:
            file.write(daemon.get(f"/v1/jobs/{job}/film").body)
        farm.merge(film, "-o", farm / "no.exr", expect=1)
        farm.merge(film, "--partial", "-o", farm / "running.exr")
        assert read(farm / "running.exr")[:4] == b"\x76\x2f\x31\x01"


if __name__ == "__main__":
    tap.main()
