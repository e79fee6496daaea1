"""Chart of LIDAR profiles: extinction and backscatter against height. Usage: lidar_plot.py FIGURES.json CHART.png"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

STYLES = {"molecular": "--", "aerosol": "-", "gas": ":"}


def profiles(axis, data, quantity, title, unit):
    height = np.asarray(data["height_m"]) / 1000
    for i, wavelength in enumerate(data["wavelength_um"]):
        for part, style in STYLES.items():
            rows = data["rows"].get(f"{quantity}_{part}")
            if rows is None:
                continue
            values = np.asarray(rows[i])
            axis.plot(
                np.where(values > 0, values, np.nan),
                height,
                style,
                color=f"C{i % 10}",
                lw=1,
                label=f"{1000 * wavelength:.8g} nm, {part}",
            )
    axis.set(title=title, xlabel=unit, ylabel="height above z = 0, km", xscale="log", ylim=(0, min(30, height[-1])))
    axis.grid(alpha=0.3)
    axis.legend(fontsize=7)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    figure, axes = plt.subplots(1, 2, figsize=(12, 7), layout="constrained", sharey=True)
    profiles(axes[0], data, "extinction", "extinction", "m-1")
    profiles(axes[1], data, "backscatter", "backscatter", "m-1 sr-1")
    figure.suptitle(data["title"])
    figure.savefig(sys.argv[2], dpi=110, format="png")


main()
