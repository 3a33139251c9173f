"""How long each job had rendered at any moment of a daemon's life, from looking all the time."""
import bisect
import http.client
import threading
import time

GAP = 0.03  # seconds between looks


class RenderingWatch:
    """with RenderingWatch(d) as watch: ... d.kill() ... watch.between(job, film_written, killed)"""

    def __init__(self, d):
        self.d = d
        self.seen = {}  # job: [(time, seconds of rendering)], in order
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.look)

    def __enter__(self):
        self.begin = time.time()
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()

    def look(self):
        while not self.over.is_set():
            try:
                jobs = self.d.get("/v1/jobs").json()["jobs"]
            except (OSError, http.client.HTTPException):
                return  # it is gone
            now = time.time()
            for job in jobs:
                self.seen.setdefault(job["id"], []).append((now, job["seconds"]))
            self.over.wait(GAP)

    def at_most(self, job, when):
        """Rendering cannot have gone on for longer than the time since a look at it."""
        seen = self.seen.get(job, [(self.begin, 0)])
        at, seconds = seen[-1]
        return seconds + max(when - at, 0)

    def at_least(self, job, when):
        """As of the last look before, or of what the first one allows."""
        seen = self.seen.get(job, [(self.begin, 0)])
        before = bisect.bisect_right(seen, (when, float("inf")))
        if before:
            return seen[before - 1][1]
        at, seconds = seen[0]
        return max(seconds - (at - when), 0)

    def between(self, job, first, last):
        """Most rendering from `first`, or the begin of the watch, to `last`, in seconds."""
        return self.at_most(job, last) - self.at_least(job, max(first, self.begin))
