"""serve.py - the loop that a renderer of the bench runs in: requests on stdin, answers on stdout."""
import json
import os
import resource
import sys


def user_seconds():
    """User CPU time of this process and of the children that ended."""
    return sum(resource.getrusage(who).ru_utime
               for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def loop(name, render):
    """Calls render(samples, seed, out) for each line "SAMPLES SEED OUT" and answers its CPU seconds.

    render may return what is to be done after the clock has stopped; that may return the samples of
    a pixel that were taken, where these are not those asked for. What the renderer itself prints
    goes to stderr.
    """
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    print(json.dumps({"ready": name}), file=answers, flush=True)
    for line in sys.stdin:
        samples, seed, out = line.split()
        start = user_seconds()
        finish = render(int(samples), int(seed), out)
        user = user_seconds() - start
        taken = finish() if finish else None
        print(json.dumps({"user": user, "samples": taken or int(samples)}), file=answers, flush=True)


def arguments(argv):
    """FOLDER WIDTH HEIGHT BOUNCES [MORE]..."""
    folder, width, height, bounces, *more = argv
    return folder, int(width), int(height), int(bounces), more
