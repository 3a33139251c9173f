#!/usr/bin/python3
"""events.py > events.csv: how often the interval of sixteen batches holds where light comes in events.

A pixel's value is the number of events among its samples, Poisson's. It is scored as tests/accuracy/scores.c
scores: against the mean of seven others, with the deviations that the batches of all give, and 2.131
of Student's law of 15 degrees, which holds .95 of normal numbers.
"""
import math
import random

BATCHES, SEEDS, TRIALS = 16, 8, 4000
EVENTS = [2, 4, 8, 16, 32]


def poisson(rng, mean):
    limit, n, product = math.exp(-mean), 0, rng.random()
    while product > limit:
        product *= rng.random()
        n += 1
    return n


def value(rng, mean):
    """[mean of the batches, its variance]"""
    batches = [poisson(rng, mean) for _ in range(BATCHES)]
    middle = sum(batches) / BATCHES
    return middle, sum((b - middle) ** 2 for b in batches) / (BATCHES * (BATCHES - 1))


def share_inside(rng, events):
    values = inside = 0
    for _ in range(TRIALS):
        pixel = [value(rng, events / BATCHES) for _ in range(SEEDS)]
        total, spread = sum(m for m, _ in pixel), sum(v for _, v in pixel)
        for mean, variance in pixel:
            others = (total - mean) / (SEEDS - 1)
            both = variance + (spread - variance) / (SEEDS - 1) ** 2
            values += both > 0
            inside += both > 0 and abs(mean - others) < 2.131 * math.sqrt(both)
    return inside / values


def main():
    rng = random.Random(1)
    print("events,inside")
    for events in EVENTS:
        print(f"{events},{share_inside(rng, events):.4f}")


if __name__ == "__main__":
    main()
