#!/usr/bin/env python3
"""A newcomer's first afternoon: a height raster and a tree of their own, the bands of EMIT, and targets a tenth of a
pixel large, all of which must be in the cube and its truth. Nothing is told but the tolerance.
usage: newcomer_test.py RAYCUBE"""

import json
import math
import os
import pathlib
import sys
import tempfile

import numpy
import patience
from driver import Program, envi, record

program = Program(sys.argv[1])
run, check = program.run, program.check

GSD_M, PIXELS, LINES, AGL_M, POST_M, POSTS = 5.0, 48, 40, 2500.0, 5.0, 81
TARGETS, TARGET_M = 20, math.sqrt(0.1) * GSD_M  # a tenth of a pixel's area each
ABUNDANCE_OFF = 0.20  # what is asked for: share of a target's area found in the pixels around it


def ground_m(x, y):
    """A rise of 12 m over the scene with a knoll: slopes up to 7 degrees."""
    return 140 + 0.03 * x + 8 * math.exp(-((x - 40) ** 2 + (y + 30) ** 2) / 60.0**2)


def write_terrain(folder):
    """An Arc ASCII grid in UTM metres, as a DEM portal hands out; posts are at the cells' centres."""
    half = (POSTS - 1) / 2 * POST_M
    rows = [
        " ".join(f"{ground_m(-half + POST_M * i, half - POST_M * j):.3f}" for i in range(POSTS)) for j in range(POSTS)
    ]
    corner = f"xllcorner {477000 - half - POST_M / 2}\nyllcorner {5474000 - half - POST_M / 2}"
    (folder / "dem.asc").write_text(
        f"ncols {POSTS}\nnrows {POSTS}\n{corner}\ncellsize {POST_M}\n" + "\n".join(rows) + "\n"
    )


def write_tree(folder):
    """A spruce: eight-sided trunk of 2 m and a cone of 7 m, two groups."""
    ring = [(math.cos(k * math.pi / 4), math.sin(k * math.pi / 4)) for k in range(8)]
    points = (
        [(0.2 * c, 0.2 * s, z) for z in (0, 2) for c, s in ring]
        + [(1.8 * c, 1.8 * s, 2) for c, s in ring]
        + [(0, 0, 9)]
    )
    text = "".join(f"v {x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in points) + "g trunk\nusemtl trunk\n"
    text += (
        "".join(f"f {k + 1} {(k + 1) % 8 + 1} {(k + 1) % 8 + 9} {k + 9}\n" for k in range(8))
        + "g crown\nusemtl crown\n"
    )
    text += "".join(f"f {17 + k} {17 + (k + 1) % 8} 25\n" for k in range(8))
    (folder / "spruce.obj").write_text(text)
    places = [(-80 + 37.3 * (k % 5), 55 - 31.7 * (k // 5)) for k in range(15)]
    (folder / "trees.csv").write_text(
        "x_m,y_m,yaw_deg,scale\n"
        + "".join(f"{x:.2f},{y:.2f},{37 * k % 360},{0.8 + 0.03 * k:.2f}\n" for k, (x, y) in enumerate(places))
    )
    return places


def write_bands(folder):
    """EMIT's table where it is at hand, else its 285 centres by their mean step (381.0 to 2492.9 nm) and width."""
    shared = os.environ.get("RAYCUBE_SHARED")
    table = pathlib.Path(shared) / "sensors/emit_bands.csv" if shared else None
    table = pathlib.Path(shared) / "data/sensors/emit_bands.csv" if shared and not table.exists() else table
    if table and table.exists():
        text = table.read_text()
    else:
        print("newcomer: RAYCUBE_SHARED is not set: EMIT's bands by their mean step")
        step = (2492.9 - 381.0) / 284
        text = "center_nm,fwhm_nm\n" + "".join(f"{381.0 + step * k:.3f},8.6\n" for k in range(285))
    (folder / "emit.csv").write_text(text)


def places_of_targets(trees):
    """Scattered by golden angles, clear of the trees."""
    places, k = [], 0
    while len(places) < TARGETS:
        r, a = 14.3 * math.sqrt(k + 2.0), k * math.pi * (3 - math.sqrt(5))
        x, y, k = r * math.cos(a), r * math.sin(a), k + 1
        inside = abs(x) < GSD_M * (PIXELS / 2 - 3) and abs(y) < GSD_M * (LINES / 2 - 3)
        if (
            inside
            and all(math.hypot(x - tx, y - ty) > 14 for tx, ty in trees)
            and all(math.hypot(x - px, y - py) > 16 for px, py in places)
        ):
            places.append((x, y))
    return places


def write_scene(folder):
    write_terrain(folder)
    trees = write_tree(folder)
    write_bands(folder)
    (folder / "grass.csv").write_text(
        "wavelength_nm,reflectance\n350,0.03\n550,0.10\n680,0.05\n750,0.42\n1300,0.40\n1450,0.15\n1650,0.28\n"
        "1950,0.06\n2200,0.15\n2550,0.05\n"
    )
    targets = places_of_targets(trees)
    panels = "".join(
        f'[[plane]]\nname = "t{k}"\nmaterial = "panel"\nposition_m = [{x:.3f}, {y:.3f}, 0.4]\n'
        f"size_m = [{TARGET_M:.4f}, {TARGET_M:.4f}]\non_terrain = true\n"
        for k, (x, y) in enumerate(targets)
    )
    (folder / "mine.toml").write_text(f"""format = 1
tolerance = 0.02
[scene]
origin = {{ epsg = 32632, easting_m = 477000.0, northing_m = 5474000.0, height_m = 0.0 }}
[atmosphere]
model = "clear_sky"
aod_550 = 0.1
[time]
sun = {{ zenith_deg = 35.0, azimuth_deg = 150.0, day_of_year = 172 }}
[[material]]
name = "grass"
file = "grass.csv"
[[material]]
name = "needles"
reflectance = 0.15
[[material]]
name = "bark"
reflectance = 0.2
[[material]]
name = "panel"
reflectance = 0.9
[[terrain]]
raster = "dem.asc"
material = "grass"
[[mesh]]
name = "spruce"
file = "spruce.obj"
materials = {{ crown = "needles", trunk = "bark" }}
[[scatter]]
mesh = "spruce"
positions = "trees.csv"
[[instrument]]
name = "emit"
kind = "framing"
pixels = {PIXELS}
lines = {LINES}
altitude_agl_m = {AGL_M}
gsd_m = {GSD_M}
bands = "emit.csv"
""" + panels)
    return targets


def footprint(x, y, z):
    """Line and sample (fractions, pixel edges at whole numbers) that a point is seen at, and metres of a pixel at its
    height."""
    gsd = GSD_M * (AGL_M - (z - ground_m(0, 0))) / AGL_M
    return LINES / 2 - y / gsd, PIXELS / 2 + x / gsd, gsd


def abundance(folder, material):
    header, truth = envi(folder, "truth")
    names = [text.split()[0] for text in header["band names"]]
    return truth[:, :, names.index("abundance_" + material)].astype(float)


def whole_afternoon(folder):
    targets = write_scene(folder)
    run("scene", "check", "mine.toml", cwd=folder)
    plan = json.loads(run("plan", "mine.toml", "--json", cwd=folder).stdout)
    check(plan, "a plan")
    run("render", "mine.toml", "-o", "out", cwd=folder)
    out = folder / "out/emit"
    header, radiance = envi(out, "radiance")
    check(
        radiance.shape == (LINES, PIXELS, 285) and numpy.isfinite(radiance).all() and (radiance > 0).all(),
        radiance.shape,
    )
    wavelength_nm = numpy.array([float(text) for text in header["wavelength"]])
    band = int(numpy.argmin(numpy.abs(wavelength_nm - 550)))
    info = json.loads(
        patience.run(["gdalinfo", "-json", out / "radiance.img"], check=True, capture_output=True, text=True).stdout
    )
    check(info["size"] == [PIXELS, LINES] and len(info["bands"]) == 285, info["size"])

    panel = abundance(out, "panel")
    found, worst, darker = 0, 0.0, 0
    for x, y in targets:
        line, sample, gsd = footprint(x, y, ground_m(x, y) + 0.4)
        low, left = int(line) - 1, int(sample) - 1
        around = panel[low : low + 3, left : left + 3]
        off = around.sum() / (TARGET_M / gsd) ** 2 - 1
        found += around.sum() > 0
        worst = max(worst, abs(off))
        brightest = numpy.unravel_index(numpy.argmax(around), around.shape)
        ring = radiance[low - 1 : low + 4, left - 1 : left + 4, band]
        darker += radiance[low + brightest[0], left + brightest[1], band] <= numpy.median(ring)
    print(
        f"newcomer: {found} of {len(targets)} targets found, abundance off by {worst:.1%} at most; "
        f"samples {record(out)['image']['samples_per_pixel']}"
    )
    check(found == len(targets), found)
    check(worst < ABUNDANCE_OFF, worst)
    check(darker == 0, darker)
    run("check", "mine.toml", cwd=folder)


with tempfile.TemporaryDirectory() as folder:
    whole_afternoon(pathlib.Path(folder))
print(f"{program.checks} checks passed")
