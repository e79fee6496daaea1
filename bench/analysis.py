#!/usr/bin/python3
"""`raycube analyze` on a cube of 2 GB against what a user would run instead: bench/analysis.py [--runs N]

A cube of 1000 x 2332 pixels of 224 bands (float32, BIP; five materials, brightness and correlated spread) is written to
build/bench/analysis. Held before it is timed: classes as scikit-learn's, shares as scipy's. Written to
build/bench/analysis.json, flat; ratios are of wall-clock medians of N alternating runs, files in the page cache:

analyze_ace_vs_read            whole `analyze detect`, maps and all, over reading the file into numpy (np.fromfile)
analyze_ace_vs_copy            the same over reading it block by block into one buffer, which keeps nothing
analyze_eigen_vs_read          whole `analyze eigen` over np.fromfile
analyze_kmeans_vs_sklearn      scikit-learn's rounds alone (Lloyd, float32, same start, to the end) over ours, whole
analyze_kmeans_vs_spectral     the same of `spectral`, from 5 rounds on a fifth of the lines
analyze_unmix_vs_scipy         scipy's nnls with a heavy row for the sum, from 20 000 pixels, over ours, whole
analyze_ace_mb                 resident, MB
The machine should be otherwise idle; 8 GB of memory.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "build/bench/analysis"
LINES, SAMPLES, BANDS, CLASSES = 2332, 1000, 224, 5
HEAVY = 1e6  # of the row that makes shares sum to 1


def make_cube(path):
    rng = np.random.default_rng(1)
    mix = rng.normal(0, 1, (BANDS, BANDS)).astype("f4") / 15
    mean = rng.uniform(20, 60, (CLASSES, BANDS)).astype("f4")
    with open(path, "wb") as file:
        for line in range(0, LINES, 106):
            count = min(106, LINES - line) * SAMPLES
            bright = rng.uniform(0.5, 1.2, (count, 1)).astype("f4")
            pixels = mean[rng.integers(0, CLASSES, count)] * bright
            (pixels + rng.standard_normal((count, BANDS), dtype="f4") @ mix).astype("f4").tofile(file)
    path.with_suffix(".hdr").write_text(
        f"ENVI\nsamples = {SAMPLES}\nlines = {LINES}\nbands = {BANDS}\ndata type = 4\n"
        "interleave = bip\nbyte order = 0\n"
    )


def timed(work):
    start = time.monotonic()
    result = work()
    return time.monotonic() - start, result


def analyze(verb, cube, *more):
    """Seconds of the whole command, its numbers, MB resident."""
    out = WORK / verb
    command = ["/usr/bin/time", "-f", "%M", ROOT / "build/raycube", "analyze", verb, cube, "-o", out, *more]
    command = [str(part) for part in [*command, "--overwrite", "--no-picture", "-q"]]
    seconds, done = timed(lambda: subprocess.run(command, check=True, capture_output=True, text=True))
    return seconds, json.loads((out / f"{verb}.json").read_text()), int(done.stderr.split()[-1]) / 1e3


def copied(path):
    buffer = bytearray(1 << 24)
    with open(path, "rb", 0) as file:
        while file.readinto(buffer):
            pass


def start_of(pixels):
    mean, spread = pixels.mean(0, dtype="f8"), pixels.std(0, dtype="f8", ddof=1)
    return np.array([mean + spread * (2 * k / (CLASSES - 1) - 1) for k in range(CLASSES)])


def spectral_rounds(pixels, start):
    """Seconds of one round of `spectral` on all pixels."""
    import spectral

    spectral.settings.show_progress = False
    part = pixels[: LINES // 5 * SAMPLES].reshape(-1, SAMPLES, BANDS)
    seconds, _ = timed(lambda: spectral.kmeans(part, CLASSES, 5, start_clusters=start))
    return seconds / 5 * len(pixels) / (LINES // 5 * SAMPLES)


def scipy_shares(pixels, endmembers):
    import scipy.optimize

    system = np.vstack([endmembers, np.full(endmembers.shape[1], HEAVY)])
    return np.array([scipy.optimize.nnls(system, np.append(pixel, HEAVY))[0] for pixel in pixels])


def main():
    import sklearn.cluster

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    cube = WORK / "cube.img"
    if not cube.exists():
        make_cube(cube)
    target = ["--target", "t=5:5,5:5"]
    members = [f"{k}:{k},{k}:{k}" for k in range(1, 5)]
    unmix = [x for k, where in enumerate(members) for x in ("--endmember", f"e{k}={where}")]
    analyze("detect", cube, *target)  # into the page cache
    took = {key: [] for key in ("read", "copy", "detect", "eigen", "kmeans", "unmix")}
    for _ in range(options.runs):
        took["read"].append(timed(lambda: np.fromfile(cube, "f4"))[0])
        took["copy"].append(timed(lambda: copied(cube))[0])
        seconds, _, resident = analyze("detect", cube, *target)
        took["detect"].append(seconds)
        took["eigen"].append(analyze("eigen", cube)[0])
        seconds, classes, _ = analyze("kmeans", cube, "--count", CLASSES)
        took["kmeans"].append(seconds)
        took["unmix"].append(analyze("unmix", cube, *unmix)[0])
    s = {key: statistics.median(values) for key, values in took.items()}

    pixels = np.fromfile(cube, "f4").reshape(-1, BANDS)
    start = start_of(pixels)
    lloyd = sklearn.cluster.KMeans(
        CLASSES, init=start.astype("f4"), n_init=1, max_iter=1000, tol=0, algorithm="lloyd", copy_x=False
    )
    sklearn_s, _ = timed(lambda: lloyd.fit(pixels))
    counts = [one["pixels"] for one in classes["classes"]]
    assert np.abs(np.bincount(lloyd.labels_) - counts).max() < 1e-4 * len(pixels), (lloyd.labels_, counts)
    spectral_s = spectral_rounds(pixels, start) * classes["rounds"]
    some = pixels[:: len(pixels) // 20000].astype("f8")
    endmembers = np.array([pixels[k * SAMPLES + k] for k in range(1, 5)], dtype="f8").T
    scipy_s, shares = timed(lambda: scipy_shares(some, endmembers))
    ours = np.fromfile(WORK / "unmix/unmix.img").reshape(5, -1)[:4, :: len(pixels) // 20000].T
    assert np.abs(shares - ours[: len(shares)]).max() < 1e-4, np.abs(shares - ours[: len(shares)]).max()
    figures = {
        "analyze_ace_vs_read": (s["detect"] / s["read"], "at most", 2),
        "analyze_ace_vs_copy": (s["detect"] / s["copy"], None, None),
        "analyze_eigen_vs_read": (s["eigen"] / s["read"], "at most", 4),
        "analyze_kmeans_vs_sklearn": (sklearn_s / s["kmeans"], "at least", 5),
        "analyze_kmeans_vs_spectral": (spectral_s / s["kmeans"], "at least", 5),
        "analyze_unmix_vs_scipy": (scipy_s / len(some) * len(pixels) / s["unmix"], "at least", 5),
        "analyze_ace_mb": (resident, "at most", 1024),
        **{f"analyze_{key}_s": (value, None, None) for key, value in s.items()},
        "analyze_sklearn_s": (sklearn_s, None, None),
    }
    keys = {}
    for key, (value, rule, goal) in figures.items():
        keys[key] = value
        if rule:
            keys.update({key + "_goal": goal, key + "_goal_is": rule})
        print(f"bench: {key} {value:.3g}" + (f" ({rule} {goal})" if rule else ""))
    (ROOT / "build/bench/analysis.json").write_text(json.dumps(keys, indent=2) + "\n")


if __name__ == "__main__":
    sys.exit(main())
