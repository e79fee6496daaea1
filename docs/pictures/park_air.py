#!/usr/bin/python3
"""Draws docs/pictures/park_haze.png and park_lwir.png from real runs.

Usage: park_air.py RAYCUBE PARK OUT      PARK: a folder made by scenes/park/generate.py; OUT: folder of the pictures
The haze picture: three visibilities and two sun heights, camera 3 km above the park, all six with one stretch. The
thermal picture: brightness temperature of park_lwir.toml at 10.05 um, and spectra of four places.
"""

import json
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

VISIBILITY_KM, ZENITH_DEG = (5, 23, 60), (30, 70)
SIMULATION = """format = 1
seed = 2012
sky_directions = 48
[scene]
include = ["materials.toml", "park_scene.toml"]
origin = {{ epsg = 32618, easting_m = 276000.0, northing_m = 4753000.0, height_m = 180.0 }}
[atmosphere]
model = "layered"
profile = "midlatitude_summer"
visibility_km = {visibility}.0
[time]
sun = {{ zenith_deg = {zenith}.0, azimuth_deg = 160.0 }}
[[instrument]]
name = "rgb"
kind = "framing"
altitude_agl_m = 3000.0
center_m = [0.0, 0.0]
gsd_m = 1.0
pixels = 320
lines = 320
samples = {{ grid = [4, 4] }}
bands = "wasp_rgb.csv"
quicklook_bands = [3, 2, 1]
"""


def render(raycube, simulation, out):
    subprocess.run([raycube, "render", simulation, "-o", out, "--overwrite"], check=True)
    folder = next(path.parent for path in Path(out).rglob("radiance.hdr"))
    header = dict(line.split(" = ", 1) for line in (folder / "radiance.hdr").read_text().splitlines() if " = " in line)
    shape = tuple(int(header[key]) for key in ("lines", "samples", "bands"))
    return np.fromfile(folder / "radiance.img", "<f4").reshape(shape)


def haze(raycube, park, out):
    images = {}
    for zenith in ZENITH_DEG:
        for visibility in VISIBILITY_KM:
            name = park / f"haze_{visibility}_{zenith}.toml"
            name.write_text(SIMULATION.format(visibility=visibility, zenith=zenith))
            images[zenith, visibility] = render(raycube, name, park / "out" / name.stem)
    bright = np.percentile(images[ZENITH_DEG[0], VISIBILITY_KM[-1]], 99.5, axis=(0, 1))
    figure, axes = plt.subplots(2, 3, figsize=(9.6, 6.9), layout="constrained")
    for row, zenith in zip(axes, ZENITH_DEG):
        for axis, visibility in zip(row, VISIBILITY_KM):
            axis.imshow(np.clip(images[zenith, visibility][:, :, ::-1] / bright[::-1], 0, 1) ** (1 / 2.2))
            axis.set_title(f"visibility {visibility} km, sun {90 - zenith} deg high", fontsize=10)
            axis.set_axis_off()
    figure.suptitle("The park from 3 km, one stretch for all")
    figure.savefig(out / "park_haze.png", dpi=100)
    for key, image in images.items():
        print(
            f"sun zenith {key[0]}, visibility {key[1]} km: mean radiance blue, green, red",
            *(f"{x:.1f}" for x in image.mean((0, 1))),
        )


def thermal(raycube, park, out):
    cube = render(raycube, park / "park_lwir.toml", park / "out" / "lwir")
    wavelength = 8.05 + 0.1 * np.arange(cube.shape[2])
    temperature = 14387.768775 / wavelength / np.log1p(1.191042972e8 / wavelength**5 / cube)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.6), layout="constrained")
    shown = left.imshow(temperature[:, :, 20], cmap="inferno", vmin=290, vmax=310)
    figure.colorbar(shown, ax=left, label="brightness temperature at 10.05 um (K)")
    left.set_axis_off()
    for label, (line, sample) in {
        "asphalt court": (84, 217),
        "dry grass": (200, 150),
        "tree crown": (120, 22),
        "white panel": (84, 255),
    }.items():
        right.plot(wavelength, temperature[line - 1 : line + 2, sample - 1 : sample + 2].mean((0, 1)), label=label)
        left.plot(sample, line, "c+", markersize=7)
    right.set(xlabel="wavelength (um)", ylabel="brightness temperature (K)")
    right.grid(alpha=0.3)
    right.legend()
    figure.savefig(out / "park_lwir.png", dpi=100)
    print(
        json.dumps(
            {
                "brightness_K_percentiles": [
                    round(float(x), 2) for x in np.percentile(temperature[:, :, 20], [1, 50, 99])
                ]
            }
        )
    )


def main():
    raycube, park, out = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3])
    thermal(raycube, park, out)
    haze(raycube, park, out)


main()
