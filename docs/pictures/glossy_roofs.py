#!/usr/bin/python3
"""Draws docs/pictures/glossy_roofs.png: vaulted roofs of eight materials under one sun, in true colour: matt, rough,
painted, wet, of metals with a grain along and across, of copper and gold. Usage: glossy_roofs.py RAYCUBE PICTURE"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

COPPER = ((400, 1.18, 2.21), (450, 1.16, 2.4), (500, 1.13, 2.56), (550, 1.02, 2.58), (600, 0.3, 3.2), (650, 0.21, 3.67))
GOLD = ((400, 1.47, 1.95), (450, 1.38, 1.91), (500, 0.97, 1.87), (550, 0.43, 2.46), (600, 0.25, 3.0), (650, 0.16, 3.6))
ROOFS = {
    "white paint": "reflectance = 0.7",
    "rough plaster": "reflectance = 0.7, oren_nayar = { sigma_deg = 35 }",
    "enamel": "file = 'blue.csv', phong = { exponent = 40, reflectance = 0.15 }",
    "wet tiles": "file = 'red.csv', gloss = { roughness = 0.15, f0 = 0.05 }",
    "steel, grain along": "reflectance = 0.02, ward = { roughness_along = 0.1, roughness_across = 0.4, "
    "grain_azimuth_deg = 90, reflectance = 0.6 }",
    "steel, grain across": "reflectance = 0.02, ward = { roughness_along = 0.1, roughness_across = 0.4, "
    "grain_azimuth_deg = 0, reflectance = 0.6 }",
    "copper": "reflectance = 0.01, fresnel = { roughness = 0.25, file = 'copper.csv' }",
    "gold": "reflectance = 0.01, fresnel = { roughness = 0.25, file = 'gold.csv' }",
}
SCENE = """format = 1
seed = 5
tolerance = 0.02
sky_directions = 256
bounces = 4
time = { sun = { zenith_deg = 42.0, azimuth_deg = 170.0 } }
atmosphere = { model = "layered", aerosol = "rural", visibility_km = 40.0 }
material = [
  { name = "asphalt", reflectance = 0.09 },
MATERIALS
]
plane = [{ material = "asphalt", size_m = [300.0, 300.0] }]
MESHES
INSTANCES
[[instrument]]
name = "camera"
kind = "framing"
pixels = 560
lines = 280
position_m = [0.0, 0.0, 220.0]
ifov_mrad = 0.68
samples = { lattice = 34 }
bands = { first_nm = 475.0, step_nm = 80.0, count = 3, fwhm_nm = 45.0 }
"""
LENGTH_M, WIDTH_M, RISE_M, WALL_M, STRIPS = 15.0, 11.0, 3.5, 2.0, 96


def vault(path):
    """A roof like a barrel cut lengthwise, its ridge from west to east, on low walls."""
    turn = np.linspace(0, np.pi, STRIPS + 1)
    lines = [
        f"v {x:.4f} {WIDTH_M / 2 * np.cos(t):.4f} {WALL_M + RISE_M * np.sin(t):.4f}"
        for x in (-LENGTH_M / 2, LENGTH_M / 2)
        for t in turn
    ]
    lines.append("usemtl roof")
    far = STRIPS + 1
    lines += [f"f {i + 1} {i + 2} {i + 2 + far} {i + 1 + far}" for i in range(STRIPS)]
    path.write_text("\n".join(lines) + "\n")


def curve(path, nm, values):
    path.write_text("wavelength_nm,reflectance\n" + "\n".join(f"{x:g},{y:.4f}" for x, y in zip(nm, values)) + "\n")


def write_scene(folder):
    vault(folder / "vault.obj")
    nm = np.arange(350, 1001, 10.0)
    curve(folder / "red.csv", nm, 0.05 + 0.3 / (1 + np.exp(-(nm - 595) / 18)))
    curve(folder / "blue.csv", nm, 0.04 + 0.35 * np.exp(-0.5 * ((nm - 455) / 40) ** 2))
    for name, rows in (("copper", COPPER), ("gold", GOLD)):
        rows = rows + ((1000, rows[-1][1] + 0.1, rows[-1][2] + 2.6),)
        text = "\n".join(",".join(f"{v:g}" for v in row) for row in rows)
        (folder / f"{name}.csv").write_text("wavelength_nm,n,k\n350,1.5,1.8\n" + text + "\n")
    join = ",\n  ".join
    materials = [f'{{ name = "{name}", {keys} }}' for name, keys in ROOFS.items()]
    meshes = [
        f'{{ name = "vault {i}", file = "vault.obj", materials = {{ roof = "{name}" }} }}'
        for i, name in enumerate(ROOFS)
    ]
    places = [
        f'{{ mesh = "vault {i}", position_m = [{19.5 * (i % 4 - 1.5):.2f}, {16 * (0.5 - i // 4):.2f}, 0.0] }}'
        for i in range(len(ROOFS))
    ]
    text = SCENE.replace("MATERIALS", "  " + join(materials) + ",")
    text = text.replace("MESHES", f"mesh = [\n  {join(meshes)}\n]").replace(
        "INSTANCES", f"instance = [\n  {join(places)}\n]"
    )
    (folder / "roofs.toml").write_text(text)


def read_cube(folder):
    header = dict(line.split(" = ", 1) for line in (folder / "radiance.hdr").read_text().splitlines() if " = " in line)
    shape = tuple(int(header[key]) for key in ("lines", "samples", "bands"))
    return np.fromfile(folder / "radiance.img", "<f4").reshape(shape)


def main():
    program, picture = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_scene(folder)
        subprocess.run([program, "render", folder / "roofs.toml", "-o", folder / "out", "-q"], check=True)
        cube = read_cube(folder / "out" / "camera")
    colour = cube[:, :, ::-1] / cube[:8, :8].mean((0, 1))[::-1] * 0.09  # asphalt is grey
    shown = np.clip(1.25 * colour / (0.7 + colour), 0, 1) ** (1 / 2.2)  # bright ones keep their colour
    figure, axes = plt.subplots(figsize=(11.2, 5.6), dpi=110)
    axes.imshow(shown, interpolation="nearest")
    for i, roof in enumerate(ROOFS):
        x, y = 280 + 19.5 * (i % 4 - 1.5) / 220 / 0.68e-3, 140 - 16 * (0.5 - i // 4) / 220 / 0.68e-3
        axes.text(x, y + 44, roof, color="white", ha="center", fontsize=9)
    axes.axis("off")
    figure.subplots_adjust(0, 0, 1, 1)
    figure.savefig(picture)


if __name__ == "__main__":
    main()
