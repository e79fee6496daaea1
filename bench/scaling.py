#!/usr/bin/env python3
"""How time grows with pixels and triangles, and memory with samples, bands and lines: bench/scaling.py [--launcher CMD]
[--figures FILE.json]

Runs build/raycube render on a meadow with trees of 20 000 triangles each, one tree for every 100 m2. Time: the sum of
run.json's stages after the plan, the lesser of two runs. Memory: the largest resident set of the process, as the kernel
counted it.
Writes build/bench/scaling.csv, scaling.json and scaling.md and docs/pictures/scaling.png. --launcher is put before
every timed process.
"""

import argparse
import csv
import json
import os
import pathlib
import shlex
import subprocess

import numpy as np

import peer_scene

ROOT = peer_scene.ROOT
WORK = ROOT / "build/bench/scaling"
HEIGHT_M, SPACING_M, TREE_TRIANGLES = 2000.0, 10.0, 20000
MEMORY = "512M"
COLUMNS = (
    "panel",
    "series",
    "x",
    "seconds",
    "resident_bytes",
    "triangles_placed",
    "pixels",
    "samples",
    "bands",
    "lines",
)


def write_tree(path):
    """A trunk and 19 988 leaves of 14 cm in a round crown 10 m high."""
    rng = np.random.default_rng(5)
    count = TREE_TRIANGLES - 12
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    centre = direction * (rng.uniform(0.3, 1, (count, 1)) ** (1 / 2)) * (3.6, 3.6, 4) + (0, 0, 6)
    a, b = rng.normal(size=(2, count, 3))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(a, b)
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    leaves = np.stack([centre + 0.08 * a, centre - 0.07 * a + 0.07 * b, centre - 0.07 * a - 0.07 * b], 1).reshape(-1, 3)
    angle = np.arange(6) * np.pi / 3
    ring = np.stack([0.15 * np.cos(angle), 0.15 * np.sin(angle)], 1)
    trunk = np.concatenate([np.column_stack([ring, np.full(6, z)]) for z in (-0.2, 5.0)])
    n = np.arange(6)
    sides = np.concatenate([np.stack([n, (n + 1) % 6, n + 6], 1), np.stack([(n + 1) % 6, (n + 1) % 6 + 6, n + 6], 1)])
    return peer_scene.write_ply(
        path, np.concatenate([trunk, leaves]), np.concatenate([sides, 12 + np.arange(3 * count).reshape(-1, 3)])
    )


def write_simulation(name, trees, side_m, pixels, lines, samples, bands, field_m, sky):
    """`trees` on a square meadow of `side_m`; the camera's `pixels` span `field_m`."""
    across = int(np.ceil(np.sqrt(trees)))
    rng = np.random.default_rng([9, trees])
    place = (
        np.stack(np.meshgrid(np.arange(across), np.arange(across)), -1).reshape(-1, 2)[:trees] + 0.5 - across / 2
    ) * SPACING_M
    rows = np.column_stack(
        [place + rng.uniform(-2, 2, place.shape), rng.uniform(0, 360, trees), rng.uniform(0.9, 1.1, trees)]
    )
    (WORK / f"{name}.csv").write_text(
        "x_m,y_m,yaw_deg,scale\n" + "".join(",".join(f"{v:.4f}" for v in row) + "\n" for row in rows)
    )
    spectra = [
        f'[[material]]\nname = "{m}"\nfile = {json.dumps(str(peer_scene.SPECTRA / (m + ".csv")))}\n'
        for m in ("lawn_grass", "maple_leaf")
    ]
    step = 2000 / max(bands - 1, 1)
    (WORK / f"{name}.toml").write_text(
        f'format = 1\nbounces = 0\nsky_directions = {sky}\n[atmosphere]\ntables = "sky.rct"\nadjacency = "off"\n'
        f"[time.sun]\nzenith_deg = {peer_scene.SUN_ZENITH_DEG}\nazimuth_deg = {peer_scene.SUN_AZIMUTH_DEG}\n"
        + "".join(spectra)
        + f'[[plane]]\nmaterial = "lawn_grass"\nsize_m = [{side_m}, {side_m}]\n[[mesh]]\nname = "tree"\n'
        f'file = "tree.ply"\nmaterial = "maple_leaf"\n'
        f'[[scatter]]\nmesh = "tree"\npositions = "{name}.csv"\non_terrain = false\n'
        f'[[instrument]]\nname = "camera"\nkind = "framing"\nposition_m = [0.0, 0.0, {HEIGHT_M}]\n'
        f'ifov_mrad = {1000 * field_m / pixels / HEIGHT_M!r}\n'
        f"pixels = {pixels}\nlines = {lines}\nsamples = {{ lattice = {samples} }}\nexr = false\npng = false\n"
        f"bands = {{ first_nm = 400.0, step_nm = {step!r}, count = {bands}, fwhm_nm = 5.0 }}\n"
    )
    return WORK / f"{name}.toml"


def run(
    launcher,
    *,
    panel,
    series,
    x,
    repeats,
    trees=100,
    side_m=140.0,
    pixels=128,
    lines=None,
    samples=9,
    bands=360,
    field_m=100.0,
    sky=4,
):
    lines = lines or pixels
    file = write_simulation("scaling", trees, side_m, pixels, lines, samples, bands, field_m, sky)
    out, seconds = WORK / "out", []
    for _ in range(repeats):
        child = subprocess.Popen(
            [
                *launcher,
                ROOT / "build/raycube",
                "render",
                file,
                "-o",
                out,
                "--overwrite",
                "--threads",
                "2",
                "--memory",
                MEMORY,
                "-q",
            ],
            stdout=subprocess.DEVNULL,
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise SystemExit(f"scaling: raycube render {file} ended with status {child.returncode}")
        record = json.loads((out / "camera/run.json").read_text())
        not_rendering = ("load", "atmosphere", "kernels", "plan")
        seconds.append(sum(s for stage, s in record["stage_s"].items() if stage not in not_rendering))
    point = {
        "panel": panel,
        "series": series,
        "x": x,
        "seconds": min(seconds),
        "resident_bytes": 1024 * usage.ru_maxrss,
        "triangles_placed": trees * TREE_TRIANGLES + 2,
        "pixels": pixels * lines,
        "samples": samples,
        "bands": bands,
        "lines": lines,
    }
    print(point, flush=True)
    return point


def measure(launcher, panels):
    WORK.mkdir(parents=True, exist_ok=True)
    assert write_tree(WORK / "tree.ply") == TREE_TRIANGLES
    peer_scene.write_table(WORK / "sky.rct", np.arange(385.0, 2470.1, 1.0), HEIGHT_M)
    points = []
    if "pixels" in panels:
        points += [
            run(launcher, panel="pixels", series="the same 100 m x 100 m", x=n * n, pixels=n, repeats=2)
            for n in (64, 128, 256, 512)
        ]
    if "triangles" in panels:
        for trees in (5, 50, 500, 5000):
            side = SPACING_M * np.sqrt(trees)
            points.append(
                run(
                    launcher,
                    panel="triangles",
                    series="all in view",
                    x=trees * TREE_TRIANGLES,
                    trees=trees,
                    side_m=1.4 * side,
                    field_m=float(side),
                    repeats=2,
                )
            )
            if trees >= 50:
                points.append(
                    run(
                        launcher,
                        panel="triangles",
                        series="20 m x 20 m in view",
                        x=trees * TREE_TRIANGLES,
                        trees=trees,
                        side_m=1.4 * side,
                        field_m=20.0,
                        repeats=2,
                    )
                )
    if "memory" in panels:
        points += [
            run((), panel="memory", series="samples a pixel", x=n, pixels=256, samples=n, repeats=1, sky=1)
            for n in (1, 16, 121, 1024)
        ]
        points += [
            run((), panel="memory", series="bands", x=n, pixels=256, samples=1, bands=n, repeats=1, sky=1)
            for n in (10, 40, 160, 640, 2000)
        ]
        points += [
            run((), panel="memory", series="lines", x=n, pixels=256, lines=n, samples=1, repeats=1, sky=1)
            for n in (64, 256, 1024, 4096, 16384)
        ]
    return points


def slope(points):
    """Exponent between the first and the last point of time ~ x^slope."""
    first, last = points[0], points[-1]
    return float(np.log(last["seconds"] / first["seconds"]) / np.log(last["x"] / first["x"]))


def by_series(points, panel):
    chosen = [p for p in points if p["panel"] == panel]
    return {
        s: sorted((p for p in chosen if p["series"] == s), key=lambda p: p["x"])
        for s in dict.fromkeys(p["series"] for p in chosen)
    }


def draw(points):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(14.5, 4.6))
    for axis, panel, label in ((axes[0], "pixels", "pixels"), (axes[1], "triangles", "placed triangles")):
        for name, rows in by_series(points, panel).items():
            axis.loglog(
                [p["x"] for p in rows], [p["seconds"] for p in rows], "o-", ms=4, label=f"{name}: x^{slope(rows):.2f}"
            )
        if not by_series(points, panel):
            continue
        x = np.array(axis.get_xlim())
        start = next(iter(by_series(points, panel).values()))[0]
        axis.loglog(x, start["seconds"] * x / start["x"], ":", color="gray", label="x^1")
        axis.set_ylim(
            0.5 * min(p["seconds"] for p in points if p["panel"] == panel),
            4 * max(p["seconds"] for p in points if p["panel"] == panel),
        )
        axis.set(xlabel=label, ylabel="seconds, 2 threads")
    axes[0].set_title("time over pixels (9 samples, 360 bands, 2 M triangles)", fontsize=9)
    axes[1].set_title("time over triangles (128 x 128 pixels, 9 samples, 360 bands)", fontsize=9)
    for name, rows in by_series(points, "memory").items():
        axes[2].semilogx([p["x"] for p in rows], [p["resident_bytes"] / 1e6 for p in rows], "o-", ms=4, label=name)
    axes[2].axhline(512 * 1.048576, ls=":", color="gray", label="--memory 512M")
    axes[2].set_ylim(0, None)
    axes[2].set(xlabel="samples a pixel, bands, lines", ylabel="largest resident set, MB")
    axes[2].set_title("memory (256 x 256 pixels, but for lines)", fontsize=9)
    for axis in axes:
        axis.grid(True, which="major", alpha=0.4)
        axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(ROOT / "docs/pictures/scaling.png", dpi=100)


def keys(points):
    """Flat figures for bench.json."""
    found = {}
    for panel, name in (("pixels", "scaling_pixels_exponent"), ("triangles", "scaling_triangles_exponent")):
        series = by_series(points, panel)
        if series:
            found[name] = slope(next(iter(series.values())))
    for series, rows in by_series(points, "memory").items():
        found["scaling_memory_" + series.split()[0]] = rows[-1]["resident_bytes"] / rows[0]["resident_bytes"]
    return found


def markdown(points):
    lines = ["| grows | from .. to | seconds | exponent |", "|---|---|---|---|"]
    for panel in ("pixels", "triangles"):
        for name, rows in by_series(points, panel).items():
            lines.append(
                f"| {'placed ' if panel == 'triangles' else ''}{panel}, {name} | {rows[0]['x']:.3g} .. "
                f"{rows[-1]['x']:.3g} | " + ", ".join(f"{p['seconds']:.2g}" for p in rows) + f" | {slope(rows):.2f} |"
            )
    lines += ["", "| grows | values | largest resident set, MB |", "|---|---|---|"]
    for name, rows in by_series(points, "memory").items():
        lines.append(
            f"| {name} | {', '.join(str(p['x']) for p in rows)} | "
            f"{', '.join(format(p['resident_bytes'] / 1e6, '.0f') for p in rows)} |"
        )
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--launcher", default="", help="command put before every timed process")
    parser.add_argument("--figures", type=pathlib.Path, help="draw an earlier run's file anew")
    parser.add_argument(
        "--panels",
        default="pixels,triangles,memory",
        help="measure these anew, the others from build/bench/scaling.json",
    )
    options = parser.parse_args()
    stored = ROOT / "build/bench/scaling.json"
    if options.figures:
        points = json.loads(options.figures.read_text())["points"]
    else:
        panels = options.panels.split(",")
        points = (
            [p for p in json.loads(stored.read_text())["points"] if p["panel"] not in panels] if stored.exists() else []
        )
        points += measure(shlex.split(options.launcher), panels)
    stored.write_text(json.dumps({"keys": keys(points), "points": points}, indent=1) + "\n")
    with open(ROOT / "build/bench/scaling.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(points)
    draw(points)
    (ROOT / "build/bench/scaling.md").write_text(markdown(points))
    print(markdown(points))


if __name__ == "__main__":
    main()
