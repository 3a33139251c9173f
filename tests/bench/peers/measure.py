"""measure.py - errors, costs and what follows from them; no renderer is known here."""
import numpy as np
import OpenImageIO as oiio

LUMINANCE = np.array([.2126, .7152, .0722])
OFFSET = 0.01       # of the relative square error, in squared radiance
TRIMMED = 0.001     # share of the worst pixels that the trimmed error leaves out
BLUR = 8            # pixels of a block of the agreement check
SAME_MEAN = 0.05    # agreement: |ratio of mean luminances - 1|
SAME_BLOCKS = 0.06  # agreement: median over blocks of the same
SAME_MOST = 0.25    # agreement: 95th percentile over blocks of the same
SLOWEST, FASTEST = -0.8, -1.5 # slopes of log error over log count: heavy tails, stratification
RESAMPLES = 4000


def read(path, width, height):
    """[height][width][3] of an OpenEXR file or of raw rows of RGB floats."""
    with open(path, "rb") as f:
        magic = f.read(4)
    if magic != b"\x76\x2f\x31\x01":
        return np.fromfile(path, "<f4").reshape(height, width, 3).astype(np.float64)
    image = oiio.ImageInput.open(path)
    names = list(image.spec().channelnames)
    pixels = image.read_image("float")
    image.close()
    pick = [next(i for i, n in enumerate(names) if n.split(".")[-1] == c) for c in "RGB"]
    return pixels[..., pick].astype(np.float64)


def square_errors(image, reference):
    """Of each pixel, relative, mean over the channels."""
    return ((image - reference) ** 2 / (reference ** 2 + OFFSET)).mean(2).reshape(-1)


def with_and_without_worst(errors):
    """(mean, mean without the worst pixels)"""
    e = np.sort(errors)
    keep = len(e) - int(round(TRIMMED * len(e)))
    return float(e.mean()), float(e[:keep].mean())


def relmse(image, reference):
    """(mean, mean without the worst pixels)"""
    return with_and_without_worst(square_errors(image, reference))


def floor_of(a, b):
    """relmse() that the mean of two independent halves still has."""
    mean = (a + b) / 2
    return with_and_without_worst(
        (((a - b) / 2) ** 2 / (mean ** 2 + OFFSET)).mean(2).reshape(-1))


def blurred(image):
    h, w = image.shape[0] // BLUR, image.shape[1] // BLUR
    y = image[:h * BLUR, :w * BLUR] @ LUMINANCE
    return y.reshape(h, BLUR, w, BLUR).mean((1, 3))


def block_noise(a, b):
    """What two independent halves say of the blocks of their mean: median relative error."""
    a, b = blurred(a), blurred(b)
    mean = (a + b) / 2
    lit = mean > .01 * mean.mean()
    return float(np.median(np.abs(a - b)[lit] / 2 / mean[lit]))


def agreement(ours, theirs, noise):
    """How far a peer's reference is from ours: ratio of means, |ratio - 1| of blurred pixels. Where
    the noise of both in the blocks is above half the tolerance, nobody can tell: "resolved"."""
    a, b = blurred(ours), blurred(theirs)
    lit = a > .01 * a.mean()
    off = np.abs(b[lit] / a[lit] - 1)
    ratio = float((theirs @ LUMINANCE).mean() / (ours @ LUMINANCE).mean())
    median, p95 = (float(np.quantile(off, q)) for q in (.5, .95))
    resolved = noise <= SAME_BLOCKS / 2
    return {"mean_ratio": ratio, "blocks_median": median, "blocks_p95": p95, "noise": noise,
            "resolved": resolved, "same": resolved and abs(ratio - 1) <= SAME_MEAN
            and median <= SAME_BLOCKS and p95 <= SAME_MOST}


def line(x, y):
    """Intercept and slope by least squares, the rows weighted as 1/y: costs differ by powers."""
    w = 1 / np.maximum(y, 1e-6)
    a = np.stack([np.ones_like(x), x], 1) * w[:, None]
    return np.linalg.lstsq(a, y * w, rcond=None)[0]


def samples_to(target, counts, errors):
    """Samples at which the error falls to the target: between two measured counts by the line
    through their logarithms, beyond them from the nearest on with the slope of all, within what
    unbiased sampling has. (samples, extrapolated)"""
    n, e = np.log(counts), np.log(np.maximum(errors, 1e-12))
    t = np.log(target)
    for k in range(len(n) - 1):
        if e[k] >= t > e[k + 1]:
            return float(np.exp(n[k] + (n[k + 1] - n[k]) * (e[k] - t) / (e[k] - e[k + 1]))), False
    slope = float(np.clip(np.polyfit(n, e, 1)[0], FASTEST, SLOWEST))
    near = 0 if t > e[0] else -1
    return float(np.exp(n[near] + (t - e[near]) / slope)), True


def rounds_to(target, rounds, floor, key):
    """Seconds to the target in each round; a round is {"counts", "user", "relmse", "trimmed"}."""
    out = []
    for r in rounds:
        counts = np.array(r["counts"], float)
        errors = np.maximum(np.array(r[key]) - floor, 1e-9)
        seconds = max(line(counts, np.array(r["user"], float))[1], 1e-9)
        n, beyond = samples_to(target, counts, errors)
        out.append((seconds * n, beyond))
    return np.array([s for s, _ in out]), any(beyond for _, beyond in out)


def interval(ours, theirs, seed=1):
    """Median of the ratios of paired rounds and a bootstrap 95 % interval of it."""
    ratios = ours / theirs
    random = np.random.default_rng(seed)
    drawn = np.median(ratios[random.integers(0, len(ratios), (RESAMPLES, len(ratios)))], 1)
    low, high = np.quantile(drawn, (.025, .975))
    return {"median": float(np.median(ratios)), "low": float(low), "high": float(high)}
