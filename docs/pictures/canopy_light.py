#!/usr/bin/python3
"""Where light goes in layers of leaves and stands of trees: docs/pictures/canopy_light.py RAYCUBE OUT [FOLDER]

Makes layers of leaf area 1, 3 and 5 and the two stands (scenes/rami/generate.py), takes their budgets of sunlight with
RAYCUBE (a minute on two cores), writes OUT/canopy_light.png; FOLDER keeps the canopies, build/canopies without it."""

import csv
import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
CANOPIES = {
    "LAI 1": ("lai1", "--lai", "1"),
    "LAI 3": ("lai3", "--lai", "3"),
    "LAI 5": ("lai5", "--lai", "5"),
    "birches": ("birch", "--stand", "birch"),
    "spruces": ("conifer", "--stand", "conifer"),
}
BANDS = ("650nm", "850nm")


def shares(program, folder, name, *arguments):
    """{(quantity, of, band): share} of a canopy under the sun."""
    place = folder / name
    if not (place / "light/light/budget.csv").exists():
        subprocess.run([sys.executable, ROOT / "scenes/rami/generate.py", place, *arguments], check=True)
        command = [program, "measure", place / "canopy.toml", "--name", "light", "-o", place / "light", "--overwrite"]
        subprocess.run(command, check=True)
    lines = (place / "light/light/budget.csv").read_text().splitlines()[1:]
    return {(row["quantity"], row["of"], row["band"]): float(row["share"]) for row in csv.DictReader(lines)}


def draw_profiles(axis, found, band):
    for (name, share), colour in zip(found.items(), ("tab:orange", "tab:green", "tab:blue", "tab:purple", "tab:red")):
        heights = sorted(float(of) for quantity, of, of_band in share if quantity == "down" and of_band == band)
        top = heights[-1] / 0.9
        at = [f"{height:g}" for height in heights]
        down = [share["transmitted", "", band]] + [share["down", height, band] for height in at] + [1]
        up = [np.nan] + [share["up", height, band] for height in at] + [share["reflected", "", band]]
        relative = np.array([0, *heights, top]) / top
        axis.plot(down, relative, color=colour, label=name)
        axis.plot(up, relative, color=colour, linestyle=":")
    axis.set(title=band.replace("nm", " nm"), xlabel="share of the sunlight", ylabel="height over that of the canopy")
    axis.set_xlim(0, 1)
    axis.grid(alpha=0.3)


def draw_shares(axis, found):
    places, names = [], []
    for i, (name, share) in enumerate(found.items()):
        for j, band in enumerate(BANDS):
            parts = (share["reflected", "", band], share["canopy", "", band], share["absorbed", "soil", band])
            below, place = 0, 2.5 * i + j
            for part, colour in zip(parts, ("0.8", "tab:green", "tab:brown")):
                axis.bar(place, part, bottom=below, color=colour, width=0.9)
                below += part
            places.append(place)
            names.append(f"{name}, {band[:-2]}")
    axis.set_xticks(places, names, rotation=60, ha="right", fontsize=8)
    for label, colour in (("ground", "tab:brown"), ("canopy", "tab:green"), ("reflected", "0.8")):
        axis.bar(0, 0, color=colour, label=label)
    axis.set(title="where it goes", ylim=(0, 1))
    axis.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))


def main():
    program, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    folder = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else ROOT / "build/canopies"
    found = {label: shares(program, folder, *of) for label, of in CANOPIES.items()}
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    for axis, band in zip(axes, BANDS):
        draw_profiles(axis, found, band)
    axes[0].legend(title="solid: down\ndotted: up", fontsize=8, title_fontsize=8, loc="lower right")
    draw_shares(axes[2], found)
    figure.savefig(out / "canopy_light.png", dpi=110)


main()
