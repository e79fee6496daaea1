#!/usr/bin/python3
"""Reflectance factors of layers of leaves in the plane of the sun: docs/pictures/canopy_brf.py RAYCUBE OUT [FOLDER]

Makes layers of leaf area 1, 3 and 5 (scenes/rami/generate.py), takes their measures with RAYCUBE (6 minutes on two
cores) and writes OUT/canopy_brf.png; FOLDER keeps the canopies, build/canopies without it."""

import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAYERS = (1, 3, 5)


def measured(program, folder, lai):
    """Table of a layer's principal plane: view zenith, wavelength, factor, its error, of it multiply scattered."""
    table = folder / f"lai{lai}/out/principal/measure.csv"
    if not table.exists():
        generate = [sys.executable, ROOT / "scenes/rami/generate.py", folder / f"lai{lai}", "--lai", str(lai)]
        subprocess.run(generate, check=True)
        file = folder / f"lai{lai}/canopy.toml"
        command = [program, "measure", file, "--name", "principal", "-o", folder / f"lai{lai}/out", "--overwrite"]
        subprocess.run(command, check=True)
    return np.loadtxt(table, delimiter=",", skiprows=2, usecols=(0, 3, 4, 5, 6))


def main():
    program, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    folder = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else ROOT / "build/canopies"
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for lai, colour in zip(LAYERS, ("tab:orange", "tab:green", "tab:blue")):
        table = measured(program, folder, lai)
        for axis, band in zip(axes, (0.65, 0.85)):
            zenith, _, factor, error, multiple = table[np.isclose(table[:, 1], band)].T
            axis.plot(zenith, factor, color=colour, label=f"LAI {lai}")
            axis.fill_between(zenith, factor - 3 * error, factor + 3 * error, color=colour, alpha=0.3, linewidth=0)
            axis.plot(zenith, multiple, color=colour, linestyle=":", linewidth=1)
    for axis, name in zip(axes, ("650 nm", "850 nm")):
        axis.set(title=name, xlabel="view zenith, deg (positive: the sun's side)", ylabel="reflectance factor")
        axis.set_ylim(0, None)
        axis.axvline(20, color="0.7", linewidth=0.8)
        axis.grid(alpha=0.3)
    axes[0].legend(title="dotted: by several surfaces")
    figure.savefig(out / "canopy_brf.png", dpi=110)


main()
