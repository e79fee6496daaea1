#!/usr/bin/python3
"""Draws docs/pictures/band_truth.png: a cube of the starter scene, parts of its radiance and what they come of, 840,
640 and 560 nm as red, green and blue, each stretched from its 1st to its 99th percentile. Usage: band_truth.py RAYCUBE
PICTURE"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ASKED = 'band_truth = ["parts", "irradiance", "reflectance"]'
PANELS = {
    "radiance": "radiance",
    "radiance_sun": "of it: direct sunlight",
    "radiance_sky": "of it: skylight",
    "radiance_between_surfaces": "of it: from surface to surface",
    "irradiance": "irradiance of sun and sky",
    "reflectance": "reflectance",
}
SHOWN = (20, 10, 6)


def cube(folder, name):
    header = dict(line.split(" = ", 1) for line in (folder / f"{name}.hdr").read_text().splitlines() if " = " in line)
    shape = tuple(int(header[key]) for key in ("lines", "samples", "bands"))
    return np.fromfile(folder / f"{name}.img", "<f4").reshape(shape)


def main(raycube, picture):
    with tempfile.TemporaryDirectory() as work:
        first = Path(work) / "first"
        subprocess.run([raycube, "new", first, "-q"], check=True)
        file = first / "first.toml"
        file.write_text(file.read_text().replace("[[instrument]]\n", f"[[instrument]]\n{ASKED}\n"))
        subprocess.run([raycube, "render", file, "-o", first / "out", "-q"], check=True)
        figure, axes = plt.subplots(2, 3, figsize=(9, 6.2), layout="constrained")
        for axis, (name, title) in zip(axes.flat, PANELS.items()):
            colours = cube(first / "out" / "camera", name)[..., SHOWN]
            low, high = np.nanpercentile(colours, (1, 99))
            axis.imshow(np.clip((colours - low) / (high - low), 0, 1))
            axis.set_title(title, fontsize=10)
            axis.axis("off")
        figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    main(*sys.argv[1:3])
