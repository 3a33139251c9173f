#!/usr/bin/python3
"""GET /metrics: text that Prometheus takes, names by one rule, figures that are true."""
import os
import re
import subprocess
import time

import tap
from daemon import PATIENCE, ROOM, Daemon


def families(text):
    """{name: type}, and {name of a sample: {labels: value}}; checks the form on the way."""
    types, samples, help_of = {}, {}, None
    for line in text.splitlines():
        if line.startswith("# HELP "):
            help_of = line.split()[2]
            assert help_of not in types, f"{help_of} comes twice"
        elif line.startswith("# TYPE "):
            _, _, name, kind = line.split()
            assert name == help_of, f"{name} has no HELP"
            types[name] = kind
        else:
            name, labels, value = re.fullmatch(r"([a-z_]+)(?:\{(.*)\})? (\S+)", line).groups()
            family = re.sub(r"_(bucket|sum|count)$", "", name) if name not in types else name
            assert family == help_of, f"{name} stands in the family {help_of}"
            of_name = samples.setdefault(name, {})
            assert (labels or "") not in of_name, f"{line} comes twice"
            of_name[labels or ""] = float(value)
    return types, samples


def scrape(daemon):
    answer = daemon.get("/metrics")
    assert answer.headers["Content-Type"] == "text/plain; version=0.0.4; charset=utf-8"
    return answer.body.decode()


def render(daemon):
    daemon.put("room", ROOM)
    job = daemon.submit(scene="room", stop={"samples": 4})
    with daemon.connect(f"/v1/jobs/{job}/tiles") as tiles:
        parts = sum(1 for _ in tiles.parts())
    daemon.frame(job)
    return job, parts


def test_promtool_finds_no_fault():
    promtool = tap.tool("promtool")
    with Daemon("--threads", "2") as daemon:
        render(daemon)
        daemon.get("/nowhere")
        told = subprocess.run([promtool, "check", "metrics"], input=scrape(daemon),
                              capture_output=True, text=True, timeout=PATIENCE)
        assert told.returncode == 0 and told.stdout + told.stderr == "", told


def test_names_and_units_follow_one_rule():
    with Daemon("--threads", "1") as daemon:
        job, _ = render(daemon)
        text = scrape(daemon)
        types, samples = families(text)
        for name, kind in types.items():
            assert name.startswith("glint_"), name
            assert name.endswith("_total") == (kind == "counter"), (name, kind)
            assert not re.search(r"_(ms|us|ns|kb|mb|percent|milliseconds)(_|$)", name), name
        assert job not in text and "room" not in text, "a label grows with what clients send"
        for name, of_name in samples.items():
            assert all(value >= 0 for value in of_name.values()), name


def test_requests_are_counted_by_route_and_class_of_status():
    with Daemon("--threads", "1") as daemon:
        render(daemon)
        for _ in range(3):
            daemon.get("/v1/jobs/nobody")
        daemon.get("/what/is/this")
        daemon.ask("BREW", "/v1", None)
        end = time.monotonic() + PATIENCE  # a request is counted once it is over: after its answer
        while True:
            _, samples = families(scrape(daemon))
            requests = samples["glint_http_requests_total"]
            timed = samples["glint_http_request_seconds_count"][""]
            # Streams take no part in the times.
            if requests.get('method="",route="",status="4xx"') == 2 and (
                    timed == sum(requests.values()) - 1):
                break
            assert time.monotonic() < end, requests
        assert requests['method="GET",route="/v1/jobs/{}",status="4xx"'] == 3
        assert requests['method="PUT",route="/v1/scenes/{}",status="2xx"'] == 1


def strange_figures(daemon, since, parts):
    """Those that are not what the system says of the process, and the job of it, at about this time."""
    text = scrape(daemon)
    folder = f"/proc/{daemon.process.pid}"
    with open(f"{folder}/statm", encoding="ascii") as file:
        resident = int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    files, threads = len(os.listdir(f"{folder}/fd")), len(os.listdir(f"{folder}/task"))
    _, samples = families(text)

    def one(name, labels=""):
        return samples[f"glint_{name}"][labels]

    right = {
        "process_open_fds": abs(one("process_open_fds") - files) <= 2,
        "process_resident_memory_bytes":
            0.8 < one("process_resident_memory_bytes") / resident < 1.25,
        "process_start_time_seconds":
            since - 2 < one("process_start_time_seconds") < time.time() + 2,
        "process_cpu_seconds_total": 0 < one("process_cpu_seconds_total") < 100 * PATIENCE,
        "process_threads": one("process_threads") == threads,
        "workers": one("workers") == 2,
        "scenes": one("scenes") == 1,
        "jobs_submitted_total": one("jobs_submitted_total") == 1,
        "job_waits_total": one("job_waits_total") == 1,
        "job_wait_seconds_total": 0 < one("job_wait_seconds_total") < PATIENCE,
        "http_waiting": one("http_waiting", 'lane="frame"') == 0,
        "jobs": one("jobs", 'state="done"') == 1,
        "http_tiles_sent_total": one("http_tiles_sent_total") == parts,
        "slices_total": one("slices_total") >= 4,
        "worker_busy_seconds_total": one("worker_busy_seconds_total") > 0,
        "build_info": any('version="' in labels for labels in samples["glint_build_info"]),
    }
    return [name for name, is_right in right.items() if not is_right], text


# What the job held is given back beside the scrape, and memory is read a moment later.
def test_figures_are_those_of_the_process_and_its_work():
    before = time.time()
    with Daemon("--threads", "2") as daemon:
        _, parts = render(daemon)
        end = time.monotonic() + PATIENCE
        while True:
            strange, text = strange_figures(daemon, before, parts)
            if not strange:
                break
            assert time.monotonic() < end, (strange, text)


ARENA = 64 << 20  # of address space: each arena but the first begins at a multiple of it


def mappings(process):
    """(first byte, byte behind, access, name) of each."""
    with open(f"/proc/{process}/maps", encoding="utf-8") as file:
        for line in file:
            found = re.match(r"(\w+)-(\w+) (\S+) \S+ \S+ \d+\s*(.*)", line)
            yield int(found[1], 16), int(found[2], 16), found[3], found[4]


def arenas(process):
    """Those of the C library that are not its first: what is in use, and closed what is not yet."""
    maps = list(mappings(process))
    return sum(1 for (start, middle, access, name), (behind, end, closed, _) in zip(maps, maps[1:])
               if start % ARENA == 0 and access == "rw-p" and not name
               and behind == middle and closed == "---p" and end == start + ARENA)


# Each arena keeps what was ever needed at one time in the threads that it serves: with one for each
# thread memory crept up for hours.
def test_all_threads_allocate_from_one_heap():
    with Daemon("--threads", "2") as daemon:
        render(daemon)
        _, samples = families(scrape(daemon))
        used = samples["glint_heap_bytes"]['state="used"']
        if any(re.search(r"/lib[at]san\.", name) for *_, name in mappings(daemon.process.pid)):
            return  # has a heap of its own
        assert used > 0
        assert arenas(daemon.process.pid) == 0


if __name__ == "__main__":
    tap.main()
