#!/usr/bin/env python3
"""What a statistical level for leaves could be worth: bench/leaf_level.py [--launcher CMD]

A level that knows how many leaves there are and how they are turned, but not where each one is, misses a pixel's
radiance by at least what pixels of independent draws of the same leaves scatter. Slabs 8 m deep of square leaves,
anywhere and turned any way, over soil, are drawn twice and rendered; the floor of the error is rms(A - B) / sqrt(2)
over the mean, worst of three bands, less what A rendered with another seed shows to be noise of the render (variance of
the mean of both A: 3/4 of it is taken off). Pixels of 0.5 m are averaged to larger ones; an rms over N of them is known
to 1 / sqrt(2 N), and the worst of three bands lies a little high where that is not small. What such a level could save
at best is the time of the same image of bare soil.
Writes build/bench/leaf_level.json and leaf_level.md. --launcher is put before every render.
"""

import argparse
import json
import pathlib
import shlex
import subprocess

import numpy as np

import peer_scene

ROOT = peer_scene.ROOT
WORK = ROOT / "build/bench/leaf_level"
DEPTH_M, MARGIN_M, GSD_M = 8.0, 10.0, 0.5
#: leaf's side m, layers (leaf area over ground area), image's side m, jittered samples along a pixel's side, sky
# directions
CASES = ((0.2, 2, 80, 12, 16), (0.2, 7, 80, 16, 64), (0.2, 14, 80, 12, 16), (0.07, 7, 32, 32, 16))
PIXELS_M = (0.5, 2, 8)


def write_leaves(path, leaf_m, layers, side_m, seed):
    """Square leaves of two triangles each, uniform in place and turn; layers * side^2 / leaf^2 of them."""
    rng = np.random.default_rng(seed)
    wide = side_m + 2 * MARGIN_M
    count = int(layers * wide * wide / leaf_m**2)
    centre = rng.random((count, 3)) * (wide, wide, DEPTH_M) + (-wide / 2, -wide / 2, 1)
    up, azimuth, turn = 2 * rng.random(count) - 1, 2 * np.pi * rng.random(count), 2 * np.pi * rng.random(count)
    level = np.sqrt(1 - up**2)
    a = np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth], 1)
    b = np.stack([-up * np.cos(azimuth), -up * np.sin(azimuth), level], 1)
    corners = [
        centre
        + leaf_m
        * np.sqrt(0.5)
        * (np.cos(turn + k * np.pi / 2)[:, None] * a + np.sin(turn + k * np.pi / 2)[:, None] * b)
        for k in range(4)
    ]
    first = 4 * np.arange(count)[:, None]
    faces = np.concatenate([first + (0, 1, 2), first + (0, 2, 3)])
    peer_scene.write_ply(path, np.stack(corners, 1).reshape(-1, 3), faces)


def render(launcher, name, side_m, grid, sky, seed):
    """Radiance [band][line][column] of the leaves in `name` (None: bare soil), and seconds of the stages but reading,
    planning and writing."""
    pixels, wide = round(side_m / GSD_M), side_m + 2 * MARGIN_M + 40
    materials = "".join(
        f'[[material]]\nname = "{m}"\nfile = {json.dumps(str(peer_scene.SPECTRA / (m + ".csv")))}\n'
        for m in ("loam", "maple_leaf")
    )
    (WORK / "bands.csv").write_text("center_nm,fwhm_nm\n550,20\n650,20\n850,20\n")
    file = WORK / "leaves.toml"
    leaves = (
        f'[[mesh]]\nname = "leaves"\nfile = "{name}"\nmaterial = "maple_leaf"\n[[instance]]\nmesh = "leaves"\n'
        if name
        else ""
    )
    file.write_text(
        f'format = 1\nbounces = 0\nsky_directions = {sky}\n[atmosphere]\nmodel = "clear_sky"\n[time.sun]\n'
        f'zenith_deg = 40.0\nazimuth_deg = 150.0\n{materials}'
        f'[[plane]]\nmaterial = "loam"\nsize_m = [{wide}, {wide}]\n{leaves}'
        f'[[instrument]]\nname = "camera"\nkind = "framing"\naltitude_agl_m = 2000.0\ngsd_m = {GSD_M}\n'
        f'pixels = {pixels}\nlines = {pixels}\n'
        f'samples = {{ jittered = [{grid}, {grid}] }}\nexr = false\npng = false\ninterleave = "bsq"\n'
        f'bands = "bands.csv"\n'
    )
    out = WORK / "out"
    subprocess.run(
        [*launcher, ROOT / "build/raycube", "render", file, "-o", out, "--overwrite", "--seed", str(seed), "-q"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    record = json.loads((out / "camera/run.json").read_text())
    not_tracing = ("load", "atmosphere", "kernels", "plan", "write")
    seconds = sum(s for stage, s in record["stage_s"].items() if stage not in not_tracing)
    return np.fromfile(out / "camera/radiance.img", "<f4").reshape(3, pixels, pixels).astype(float), seconds


def averaged(image, times):
    count = image.shape[1] // times
    return image[:, : count * times, : count * times].reshape(3, count, times, count, times).mean((2, 4))


def measure(launcher, leaf_m, layers, side_m, grid, sky):
    files = WORK / "a.ply", WORK / "b.ply"
    for seed, path in enumerate(files):
        write_leaves(path, leaf_m, layers, side_m, seed + 1)
    (a, seconds), (again, _), (b, _) = (
        render(launcher, path.name, side_m, grid, sky, seed)
        for path, seed in ((files[0], 1), (files[0], 2), (files[1], 3))
    )
    for path in files:
        path.unlink()
    bare = min(render(launcher, None, side_m, grid, sky, seed)[1] for seed in (1, 2, 3))
    for pixel_m in PIXELS_M:
        one, two, other = (averaged(image, round(pixel_m / GSD_M)) for image in (a, again, b))
        mean = one.mean((1, 2))

        def rms(x, y):
            return np.sqrt(((x - y) ** 2).mean((1, 2)) / 2) / mean

        noise = rms(one, two)
        floor = np.sqrt(np.maximum(rms((one + two) / 2, other) ** 2 - 0.75 * noise**2, 0))
        yield {
            "leaf_m": leaf_m,
            "layers": layers,
            "pixel_m": pixel_m,
            "pixels": one[0].size,
            "triangles_per_pixel": round(2 * layers * pixel_m**2 / leaf_m**2),
            "floor": float(floor.max()),
            "known_to": float(1 / np.sqrt(2 * one[0].size)),
            "noise": float(noise.max()),
            "time_over_bare_soil": seconds / bare,
        }


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--launcher", type=shlex.split, default=[])
    launcher = arguments.parse_args().launcher
    WORK.mkdir(parents=True, exist_ok=True)
    rows = []
    for case in CASES:
        for row in measure(launcher, *case):
            rows.append(row)
            print(
                f"leaves of {row['leaf_m']} m, {row['layers']} layers, pixels of {row['pixel_m']} m: at least "
                f"{100 * row['floor']:.3g} %",
                flush=True,
            )
    text = (
        "| leaves m | layers | pixels m | triangles a pixel | error of any statistical level, worst band, at least % | "
        "that is known to | noise of the renders % | "
        "time over that of bare soil |\n|---|---|---|---|---|---|---|---|\n"
    )
    for row in rows:
        known_to = float(f"{100 * row['known_to']:.1g}")
        text += (
            f"| {row['leaf_m']} | {row['layers']} | {row['pixel_m']} | {row['triangles_per_pixel']} | "
            f"{100 * row['floor']:.2g} | {known_to:g} % | {100 * row['noise']:.2g} | "
            f"{row['time_over_bare_soil']:.0f} x |\n"
        )
    (ROOT / "build/bench/leaf_level.md").write_text(text)
    seven = next(row for row in rows if row["layers"] == 7 and row["pixel_m"] == PIXELS_M[0])
    (ROOT / "build/bench/leaf_level.json").write_text(
        json.dumps({"rows": rows, "keys": {"leaf_level_floor_7_layers": seven["floor"]}}, indent=2) + "\n"
    )


if __name__ == "__main__":
    main()
