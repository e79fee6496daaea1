"""Charts of two render tables' differences: per quantity both spectra, and B - A below. Usage: atmos_compare.py
FIGURES.json CHART.png"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def panel(figure, grid, data, quantity):
    wavelength = np.asarray(data["wavelength_um"])
    a, b = (np.asarray(quantity[key], dtype=float) for key in ("spectrum_a", "spectrum_b"))
    both = grid.subgridspec(2, 1, height_ratios=[3, 2], hspace=0.05)
    upper = figure.add_subplot(both[0])
    lower = figure.add_subplot(both[1], sharex=upper)
    upper.plot(wavelength, a, lw=0.9, label="A")
    upper.plot(wavelength, b, lw=0.9, ls="--", label="B")
    positive = np.concatenate([a[a > 0], b[b > 0]])
    # Radiances fall by decades from the blue to the infrared; below a millionth of the peak nothing is told.
    if not quantity["ratio"] and positive.size and positive.max() > 30 * np.median(positive):
        upper.set_yscale("log")
        upper.set_ylim(positive.max() * 1e-6 if positive.min() < positive.max() * 1e-6 else None, None)
    title = quantity["name"] + (", " + quantity["where"] if quantity["where"] else "")
    upper.set_title(title, fontsize=9)
    upper.set_ylabel(quantity["unit"], fontsize=8)
    upper.legend(fontsize=7)
    upper.tick_params(labelbottom=False)
    relative = not quantity["ratio"]
    scale = np.where(a > 0, a, np.nan) if relative else 1
    difference = 100 * (b - a) / scale if relative else b - a
    lower.plot(wavelength, difference, lw=0.8, color="tab:red")
    for band in quantity["bands"]:
        mean = band["mean_relative"] if relative else band["mean"]
        if mean is not None:
            low, high = band["low_um"], band["high_um"]
            if "fwhm_um" in band:
                low, high = band["center_um"] - band["fwhm_um"] / 2, band["center_um"] + band["fwhm_um"] / 2
            lower.plot([low, high], [100 * mean if relative else mean] * 2, color="black", lw=1.4)
    finite = difference[np.isfinite(difference)]
    if relative and finite.size:
        # Where A is nearly dark the ratio says nothing: the axis follows the bulk and the band means.
        means = [abs(100 * band["mean_relative"]) for band in quantity["bands"] if band["mean_relative"] is not None]
        reach = 1.1 * max([np.percentile(np.abs(finite), 98), 1e-3, *means])
        lower.set_ylim(-reach, reach)
    lower.axhline(0, color="gray", lw=0.6)
    lower.set_ylabel("B - A, %" if relative else "B - A", fontsize=8)
    if wavelength[0] > 0 and wavelength[-1] > 8 * wavelength[0]:
        lower.set_xscale("log")
        ticks = [
            t
            for t in (0.3, 0.4, 0.5, 0.7, 1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 30)
            if wavelength[0] <= t <= wavelength[-1]
        ]
        lower.set_xticks(ticks, [f"{t:g}" for t in ticks])
        lower.minorticks_off()
    lower.set_xlabel("wavelength, um", fontsize=8)
    for axis in (upper, lower):
        axis.grid(alpha=0.3)
        axis.tick_params(labelsize=7)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    quantities = data["quantities"]
    columns = min(3, len(quantities))
    rows = -(-len(quantities) // columns)
    width, height = 5.2 * columns, 3.4 * rows + 1.6
    figure = plt.figure(figsize=(width, height))
    grid = figure.add_gridspec(
        rows,
        columns,
        left=0.7 / width,
        right=1 - 0.15 / width,
        bottom=0.45 / height,
        top=1 - 1.4 / height,
        hspace=0.3,
        wspace=0.22,
    )
    for index, quantity in enumerate(quantities):
        panel(figure, grid[index // columns, index % columns], data, quantity)
    names = (
        f"A: {pathlib.Path(data['a']).name}   B: {pathlib.Path(data['b']).name}   target {data['target_height_m']:g} m"
    )
    figure.suptitle(
        "\n".join([names + "; black: band means", *data["differs"][:4]]), fontsize=10, y=1 - 0.1 / height, va="top"
    )
    figure.savefig(sys.argv[2], dpi=90)


if __name__ == "__main__":
    main()
