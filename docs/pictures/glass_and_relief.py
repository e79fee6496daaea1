#!/usr/bin/python3
"""Draws docs/pictures/glass_and_relief.png: beds of leaves in the open and under panes, clear, in pairs and coloured,
and pavements that are flat, of cobbles by an image of heights and of waves by an image of normals, in true colour.
Usage: glass_and_relief.py RAYCUBE PICTURE"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BEDS = {"open": (), "a pane": ("pane",), "two panes": ("pane", "pane"), "red pane": ("red pane",)}
PAVEMENTS = {"flat": "", "bump: cobbles": "BUMP", "normals: waves": "NORMALS", "five times as high": "DEEP"}
SCENE = """format = 1
seed = 3
tolerance = 0.02
sky_directions = 256
bounces = 6
time = { sun = { zenith_deg = 48.0, azimuth_deg = 140.0 } }
atmosphere = { model = "layered", aerosol = "rural", visibility_km = 40.0 }
material = [
  { name = "concrete", reflectance = 0.25 },
  { name = "leaf", leaf = { prospect = { n = 1.5, cab_ug_cm2 = 45, car_ug_cm2 = 9, cw_cm = 0.01, cm_g_cm2 = 0.006 } } },
  { name = "red pane", file = "red.csv", transmission = "plate" },
MATERIALS
]
plane = [
PLANES
]
mesh = [{ name = "plants", file = "plants.obj", material = "leaf" }]
INSTANCES
[[instrument]]
name = "camera"
kind = "framing"
pixels = 560
lines = 280
position_m = [0.0, 0.0, 60.0]
ifov_mrad = 0.7
samples = { lattice = 34 }
bands = { first_nm = 475.0, step_nm = 80.0, count = 3, fwhm_nm = 45.0 }
"""
STEP_M, SIDE_M = 5.6, 4.2


def plants(path):
    """Rows of tufts of single leaves."""
    random = np.random.default_rng(4)
    lines, faces = [], []
    for x in np.arange(-1.2, 1.3, 0.6):
        for y in np.arange(-1.2, 1.3, 0.6):
            for _ in range(60):
                base = np.array([x, y, 0.15]) + 0.16 * random.normal(size=3) * (1, 1, 0.6)
                a, b = 0.12 * random.normal(size=3), 0.12 * random.normal(size=3)
                first = len(lines) + 1
                lines += [f"v {p[0]:.4f} {p[1]:.4f} {max(p[2], 0.02):.4f}" for p in (base, base + a, base + b)]
                faces.append(f"f {first} {first + 1} {first + 2}")
    path.write_text("\n".join(lines + faces) + "\n")


def float_image(path, values):
    values = values.reshape(values.shape[0], values.shape[1], -1)
    values.astype("<f4").tofile(path)
    Path(str(path) + ".hdr").write_text(
        f"ENVI\nsamples = {values.shape[1]}\nlines = {values.shape[0]}\nbands = {values.shape[2]}\nheader offset = 0\n"
        "file type = ENVI Standard\ndata type = 4\ninterleave = bip\nbyte order = 0\n"
    )


def cobbles(path, size=24):
    """Round stones in rows that are set off by half a stone, 2 x 2 of them."""
    y, x = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5, indexing="ij")
    row = np.floor(2 * y / size)
    u, v = (2 * x / size + 0.5 * row) % 1 - 0.5, 2 * y / size % 1 - 0.5
    float_image(path, np.sqrt(np.clip(0.25 - u**2 - v**2, 0, None)))


def waves(path, size=32):
    y, x = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5, indexing="ij")
    slope = 0.5 * np.cos(2 * np.pi * (x - y) / size) / np.sqrt(2)
    normal = np.stack([-slope, -slope, np.ones_like(slope)], -1)
    float_image(path, normal / np.linalg.norm(normal, axis=-1, keepdims=True))


def write_scene(folder):
    plants(folder / "plants.obj")
    cobbles(folder / "cobbles.img")
    waves(folder / "waves.img")
    nm = np.arange(350, 2501, 10.0)
    let = 0.04 + 0.85 / (1 + np.exp(-(nm - 590) / 12))
    (folder / "red.csv").write_text(
        "wavelength_nm,reflectance,transmittance\n" + "\n".join(f"{x:g},0.03,{t:.4f}" for x, t in zip(nm, let)) + "\n"
    )
    relief = {
        "": "",
        "BUMP": ', bump = { image = "cobbles.img", height_m = [0.0, 0.12], texel_m = 0.04 }',
        "DEEP": ', bump = { image = "cobbles.img", height_m = [0.0, 0.6], texel_m = 0.04 }',
        "NORMALS": ', normals = { image = "waves.img", texel_m = 0.03 }',
    }
    pane = 'name = "pane", reflectance = 0.0, transmittance = 0.88, transmission = "plate"'
    materials = [f"{{ {pane}, gloss = {{ roughness = 0.1, f0 = 0.08 }} }}"]
    planes, places = ['{ material = "concrete", size_m = [200.0, 200.0] }'], []
    for i, key in enumerate(PAVEMENTS.values()):
        materials.append(f'{{ name = "pavement {i}", reflectance = 0.35{relief[key]} }}')
        planes.append(
            f'{{ material = "pavement {i}", size_m = [{SIDE_M}, {SIDE_M}], position_m = '
            f"[{STEP_M * (i - 1.5):.2f}, -3.2, 0.02] }}"
        )
    for i, panes in enumerate(BEDS.values()):
        at = STEP_M * (i - 1.5)
        places.append(f'{{ mesh = "plants", position_m = [{at:.2f}, 3.0, 0.0] }}')
        for level, pane in enumerate(panes):
            planes.append(
                f'{{ material = "{pane}", size_m = [{SIDE_M - 0.9 * level}, {SIDE_M}], position_m = '
                f"[{at:.2f}, 3.0, {0.9 + 0.3 * level:.2f}] }}"
            )
    join = ",\n  ".join
    text = SCENE.replace("MATERIALS", "  " + join(materials) + ",").replace("PLANES", "  " + join(planes))
    (folder / "glass.toml").write_text(text.replace("INSTANCES", f"instance = [\n  {join(places)}\n]"))


def read_cube(folder):
    header = dict(line.split(" = ", 1) for line in (folder / "radiance.hdr").read_text().splitlines() if " = " in line)
    shape = tuple(int(header[key]) for key in ("lines", "samples", "bands"))
    return np.fromfile(folder / "radiance.img", "<f4").reshape(shape)


def main():
    program, picture = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_scene(folder)
        subprocess.run([program, "render", folder / "glass.toml", "-o", folder / "out", "-q"], check=True)
        cube = read_cube(folder / "out" / "camera")
    colour = cube[:, :, ::-1] / cube[:8, :8].mean((0, 1))[::-1] * 0.25  # concrete is grey
    shown = np.clip(1.1 * colour / (0.35 + colour), 0, 1) ** (1 / 2.2)
    figure, axes = plt.subplots(figsize=(11.2, 5.6), dpi=110)
    axes.imshow(shown, interpolation="nearest")
    pixel_m = 60 * 0.7e-3
    for y_m, names in ((5.45, BEDS), (-5.75, PAVEMENTS)):
        for i, label in enumerate(names):
            x, y = 280 + STEP_M * (i - 1.5) / pixel_m, 140 - y_m / pixel_m
            axes.text(x, y, label, color="white", ha="center", fontsize=9)
    axes.axis("off")
    figure.subplots_adjust(0, 0, 1, 1)
    figure.savefig(picture)


if __name__ == "__main__":
    main()
