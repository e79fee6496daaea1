#!/usr/bin/python3
"""Draws docs/pictures/light_between.png: what light between surfaces changes. Above as light scattered once has it
(bounces = 0), below with light between surfaces: a box with a red and a green wall under a lamp, a grove of single
leaves in true colour and in the near infrared, white blocks under its crowns, and a part of the park.
Usage: light_between.py RAYCUBE PARK PICTURE; PARK: a folder made by scenes/park/generate.py"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BANDS = "bands = { first_nm = 465.0, step_nm = 96.0, count = 5, fwhm_nm = 30.0 }"  # blue, green, red, 753, 849 nm
BOX = """format = 1
tolerance = 0.02
sky_directions = 178
atmosphere = { model = "clear_sky" }
time = { sun = { zenith_deg = 130.0 } }
material = [
  { name = "white", reflectance = 0.73 },
  { name = "red", file = "red.csv" },
  { name = "green", file = "green.csv" },
]
plane = [{ material = "white", size_m = [6.0, 6.0] }]  # the back: cameras look down, so that the box lies on it
box = [
  { material = "red", position_m = [-3.1, 0.0, 0.0], size_m = [0.2, 6.0, 6.0] },
  { material = "green", position_m = [3.1, 0.0, 0.0], size_m = [0.2, 6.0, 6.0] },
  { material = "white", position_m = [0.0, 3.1, 0.0], size_m = [6.4, 0.2, 6.0] },
  { material = "white", position_m = [0.0, -3.1, 0.0], size_m = [6.4, 0.2, 6.0] },
  { material = "white", position_m = [-1.1, -1.2, 0.8], size_m = [1.7, 3.6, 1.7] },
  { material = "white", position_m = [1.1, -2.15, 2.8], size_m = [1.7, 1.7, 1.7] },
]
[[lamp]]
name = "ceiling"
shape = "rectangle"
position_m = [0.0, 2.98, 3.0]
size_m = [1.6, 1.4]
direction = [0, -1, 0]
temperature_K = 3400
flux_lm = 4000.0
[[instrument]]
name = "picture"
kind = "framing"
pixels = 240
lines = 240
position_m = [0.0, 0.0, 19.2]
ifov_mrad = 2.05
samples = { lattice = 89 }
"""
GROVE = """format = 1
tolerance = 0.02
atmosphere = { model = "layered", aerosol = "rural", visibility_km = 40.0 }
time = { sun = { zenith_deg = ZENITH, azimuth_deg = AZIMUTH } }
material = [
  { name = "soil", file = "soil.csv" },
  { name = "bark", reflectance = 0.2 },
  { name = "white", reflectance = 0.8 },
  { name = "leaf", leaf = { prospect = { n = 1.5, cab_ug_cm2 = 38, car_ug_cm2 = 9, cw_cm = 0.01, cm_g_cm2 = 0.005 } } },
]
plane = [{ material = "soil", size_m = [400.0, 400.0] }]
mesh = [{ name = "tree", file = "tree.obj", materials = { leaf = "leaf", bark = "bark" } }]
BLOCKS
TREES
"""
#: Place and direction, samples, rays into the sky, the sun's zenith angle and azimuth.
VIEWS = {
    "grove": ((-16.0, -58.0, 42.0), (0.0, 0.0, 3.0), 2.1, 55, 110, (38.0, 235.0)),
    "under": ((3.5, -7.0, 5.0), (-0.4, 0.0, 0.5), 2.2, 89, 356, (32.0, 8.0)),  # the blocks in the shade
}
PARK = """format = 1
tolerance = 0.02
seed = 2012
[scene]
include = ["materials.toml", "park_scene.toml"]
origin = { epsg = 32618, easting_m = 276000.0, northing_m = 4753000.0, height_m = 180.0 }
[atmosphere]
model = "clear_sky"
[time]
sun = { zenith_deg = 44.0, azimuth_deg = 155.0 }
"""


def camera(name, place, samples, paths):
    return (
        f'[[instrument]]\nname = "{name}"\nkind = "framing"\npixels = 240\nlines = 240\n{place}'
        f"samples = {{ lattice = {samples} }}\n{BANDS}\n"
    ), f"sky_directions = {paths}\n"


def curve(path, nm, values):
    path.write_text("wavelength_nm,reflectance\n" + "\n".join(f"{x:g},{y:.4f}" for x, y in zip(nm, values)) + "\n")


def tree(path, rng):
    """A crown of 2600 square leaves in an ellipsoid that stands on a trunk."""
    lines, faces = [], ["usemtl leaf"]
    for i in range(2600):
        middle = rng.normal(size=3)
        middle *= rng.uniform() ** (1 / 3) / np.linalg.norm(middle)
        a, b = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2] * 0.09
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            lines.append("v {:.4f} {:.4f} {:.4f}".format(*(middle * (2.3, 2.3, 1.9) + (0, 0, 4.6) + x * a + y * b)))
        faces.append("f {} {} {} {}".format(*range(4 * i + 1, 4 * i + 5)))
    at = len(lines)
    turn = np.arange(8) * np.pi / 4
    lines += [f"v {0.14 * np.cos(t):.4f} {0.14 * np.sin(t):.4f} {z}" for z in (0, 4.6) for t in turn]
    faces.append("usemtl bark")
    faces += [f"f {at + k + 1} {at + (k + 1) % 8 + 1} {at + (k + 1) % 8 + 9} {at + k + 9}" for k in range(8)]
    path.write_text("\n".join(lines + faces) + "\n")


def write_scenes(folder, park):
    rng = np.random.default_rng(6)
    nm = np.arange(350, 1101, 10.0)
    curve(folder / "red.csv", nm, 0.05 + 0.58 / (1 + np.exp(-(nm - 605) / 12)))
    curve(folder / "green.csv", nm, 0.05 + 0.4 * np.exp(-0.5 * ((nm - 540) / 35) ** 2))
    curve(folder / "soil.csv", nm, 0.05 + 0.25 * (nm - 350) / 750)
    tree(folder / "tree.obj", rng)
    (folder / "box.toml").write_text(BOX + BANDS + "\n")
    blocks = [(-2.2, 0.3), (-0.6, -0.6), (1.0, 0.4), (8.6, -2.0)]
    text = GROVE.replace(
        "BLOCKS",
        "box = [\n  "
        + ",\n  ".join(
            f'{{ material = "white", position_m = [{x}, {y}, 0.0], size_m = [0.8, 0.8, 0.8] }}' for x, y in blocks
        )
        + "\n]",
    )
    places = [(0.0, 2.2), (-4.4, 1.0), (3.6, 3.4)]
    while len(places) < 60:
        x, y = rng.uniform(-30, 30, 2)
        clear = (abs(x) > 9 or abs(y) > 6) and np.hypot(x - 3.5, y + 7.0) > 7  # of the blocks, and of who looks at them
        if clear and min(np.hypot(x - a, y - b) for a, b in places) > 3.4:
            places.append((x, y))
    text = text.replace(
        "TREES",
        "instance = [\n  "
        + ",\n  ".join(
            f'{{ mesh = "tree", position_m = [{x:.2f}, {y:.2f}, 0.0], yaw_deg = {rng.uniform(0, 360):.0f}, '
            f"scale = {rng.uniform(0.85, 1.3):.2f} }}"
            for x, y in places
        )
        + "\n]",
    )
    for name, (at, to, ifov_mrad, samples, paths, sun) in VIEWS.items():
        place = f"position_m = {list(at)}\nlook_at_m = {list(to)}\nifov_mrad = {ifov_mrad}\n"
        instrument, rays = camera(name, place, samples, paths)
        lit = text.replace("ZENITH", str(sun[0])).replace("AZIMUTH", str(sun[1]))
        lit = lit.replace("tolerance = 0.02\n", "tolerance = 0.02\n" + rays)
        (folder / f"{name}.toml").write_text(lit + instrument)
    for file in park.iterdir():
        if not (folder / file.name).exists():
            os.symlink(file.resolve(), folder / file.name)
    place = "altitude_agl_m = 600.0\ncenter_m = [-110.0, 110.0]\ngsd_m = 0.4\n"
    instrument, rays = camera("park", place, 55, 110)
    (folder / "part.toml").write_text(PARK.replace("tolerance = 0.02\n", "tolerance = 0.02\n" + rays) + instrument)


def rendered(program, file, out, bounces):
    """[line][sample][band], lines from above."""
    text = file.read_text()
    if bounces:  # as many paths as rays into the sky
        text = text.replace("sky_directions = ", "paths = SAME\nsky_directions = ")
        text = text.replace("SAME", text.split("sky_directions = ")[1].split("\n")[0])
    text = text.replace("tolerance = 0.02\n", f"tolerance = 0.02\nbounces = {bounces}\n")
    file = file.with_stem(f"{file.stem}_{bounces}")
    file.write_text(text)
    subprocess.run([program, "render", file, "-o", out, "-q", "-q"], check=True, stdout=subprocess.DEVNULL)
    folder = next(path.parent for path in out.glob("*/radiance.hdr"))
    header = dict(line.split(" = ", 1) for line in (folder / "radiance.hdr").read_text().splitlines() if " = " in line)
    shape = tuple(int(header[key]) for key in ("lines", "samples", "bands"))
    assert header["interleave"].strip() == "bip"
    return np.fromfile(folder / "radiance.img", "<f4").reshape(shape)


def main():
    program, park, picture = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_scenes(folder, park)
        files = {"park": "part.toml", "box": "box.toml", "grove": "grove.toml", "under": "under.toml"}
        cubes = {
            key: [rendered(program, folder / file, folder / f"{key}_{bounces}", bounces) for bounces in (0, 64)]
            for key, file in files.items()
        }
    panels = [
        ("a box under a lamp", "box", (2, 1, 0)),
        ("a grove, true colour", "grove", (2, 1, 0)),
        ("the same at 849 nm", "grove", (4, 4, 4)),
        ("white blocks under its crowns", "under", (2, 1, 0)),
        ("the park: 849, 657, 561 nm", "park", (4, 2, 1)),
    ]
    figure, axes = plt.subplots(2, len(panels), figsize=(12.6, 5.4), dpi=100)
    for column, (title, key, bands) in enumerate(panels):
        pair = [cube[:, :, list(bands)] for cube in cubes[key]]
        # One stretch for both. In the grove the brightest pixels are the blocks' tops, which are white.
        share, gain = (99.97, 1.8) if key == "grove" and column == 1 else (99.5, 1.0)
        white = np.percentile(pair[1], share, axis=(0, 1)) / gain
        for row, cube in enumerate(pair):
            shown = np.clip(cube / white, 0, 1) ** (1 / 2.2)
            axes[row, column].imshow(shown, interpolation="nearest")
            axes[row, column].set(xticks=[], yticks=[])
        axes[0, column].set_title(title, fontsize=9)
    for row, text in enumerate(("light scattered once", "and between surfaces")):
        axes[row, 0].set_ylabel(text, fontsize=9)
    figure.tight_layout(pad=0.6)
    figure.savefig(picture)


if __name__ == "__main__":
    main()
