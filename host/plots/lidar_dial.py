"""Chart of retrieved gas columns: map, against the noiseless return, bias against depth. Usage: lidar_dial.py
FIGURES.json CHART.png"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def binned(x, y, bins=10):
    """Mean of y in even bins of x that hold 5 points or more, and the mean's standard error."""
    which = np.minimum(((x - x.min()) / max(np.ptp(x), 1e-30) * bins).astype(int), bins - 1)
    parts = [which == i for i in range(bins) if np.count_nonzero(which == i) >= 5]
    return (
        np.array([(x[p].mean(), y[p].mean(), y[p].std() / np.sqrt(np.count_nonzero(p))) for p in parts])
        .reshape(-1, 3)
        .T
    )


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    figure, axes = plt.subplots(1, 3, figsize=(16, 5.2), layout="constrained")
    if data.get("column"):
        column, error, thin, expected, depth = (
            np.asarray(data[key]) for key in ("column", "error", "thin", "expected", "depth")
        )
        low, high = np.percentile(expected, [1, 99.5])
        points = axes[0].scatter(
            data["x_m"], data["y_m"], c=column, s=6, cmap="viridis", vmin=min(low, 0), vmax=max(high, low + 1e-6)
        )
        figure.colorbar(points, ax=axes[0], label=f"{data['gas']} column, ppm m")
        axes[0].set(xlabel="x, m", ylabel="y, m", aspect="equal", title="retrieved column")
        axes[1].errorbar(expected, column, yerr=error, fmt=".", ms=3, lw=0.4, alpha=0.4)
        ends = np.array([expected.min(), expected.max()])
        axes[1].plot(ends, ends, color="black", lw=1)
        totals = data["totals"]
        axes[1].set(
            xlabel="from the noiseless return, ppm m",
            ylabel="retrieved, ppm m",
            title=f"{100 * totals['within_one_sigma']:.1f} % within one sigma, rms {totals['rms_deviation_sigma']:.2f} "
            f"sigma",
        )
        for values, name, color in (
            (column, "line averaged after the exponential", "tab:blue"),
            (thin, "mean cross section", "tab:orange"),
        ):
            x, y, dy = binned(depth, values - expected)
            axes[2].errorbar(x, y, yerr=dy, fmt="o-", ms=4, lw=1, color=color, label=name)
        axes[2].axhline(0, color="black", lw=0.8)
        axes[2].set(xlabel="two-way optical depth on the line", ylabel="bias, ppm m", title="bias against depth")
        axes[2].legend(fontsize=8)
    for axis in axes:
        axis.grid(alpha=0.3)
    figure.suptitle(f"{data['title']}: {data['gas']}")
    figure.savefig(sys.argv[2], dpi=110, format="png")


main()
