"""Chart of a receiver's overlap with a beam against range. Usage: lidar_gff.py FIGURES.json CHART.png"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def mark(axes, data):
    for axis in axes:
        if "surface_m" in data:
            low, high = data["surface_m"]
            axis.axvspan(low, max(high, low + 0.002 * data["range_m"][-1]), color="tab:brown", alpha=0.35, lw=0)
        for plume in data.get("plumes", []):
            axis.axvline(plume["range_m"], color="tab:green", lw=2, alpha=0.6)
    top = axes[0].get_xaxis_transform()
    labels = [
        (plume["range_m"], f"{plume['name']}: {plume['overlap']:.3g}", "tab:green") for plume in data.get("plumes", [])
    ]
    if "surface_m" in data:
        labels.append((data["surface_m"][0], "surfaces", "tab:brown"))
    span, last, row = data["range_m"][-1] - data["range_m"][0], -1e300, 0
    for at, text, color in sorted(labels):
        row = row + 1 if at - last < 0.15 * span else 0  # names of close marks stand above one another
        axes[0].text(at, 1.02 + 0.06 * row, text, transform=top, color=color, ha="center")
        last = at


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    r = np.asarray(data["range_m"])
    figure, axes = plt.subplots(3, 1, figsize=(9, 9.5), layout="constrained", sharex=True, height_ratios=[2, 1.4, 1.2])
    axes[0].plot(r, data["uniform"], "--", color="tab:gray", lw=1, label="level 1: hard circle, uniform beam")
    axes[0].plot(r, data["gauss"], ":", color="tab:gray", lw=1.4, label="level 1: hard circle, Gaussian beam")
    axes[0].plot(r, data["exact"], color="tab:blue", lw=2, label=f"level 2: exact vignetting ({data['beam']})")
    axes[0].set(ylabel="overlap", ylim=(-0.02, 1.05))
    axes[0].legend(fontsize=8)
    per = np.asarray(data["per_m2"])
    axes[1].plot(r, per / per.max() if per.max() > 0 else per, color="tab:blue", lw=2)
    axes[1].set(ylabel="level 2 / range$^2$, of its peak", ylim=(-0.02, 1.05))
    if per.max() > 0:
        axes[1].annotate(
            f"peak at {data['peak_m']:.6g} m",
            (data["peak_m"], 1),
            xytext=(8, -12),
            textcoords="offset points",
            fontsize=8,
        )
    beam, field = np.asarray(data["beam_m"]), np.asarray(data["field_m"])
    apart = np.asarray(data["apart_m"])
    # Seen in the plane of both axes: the separation has a sign, which turns where the axes cross.
    turn = int(np.argmin(apart))
    sign = (
        np.where(np.arange(len(r)) <= turn, 1, -1) if 0 < turn < len(r) - 1 and apart[turn] < 0.05 * apart.max() else 1
    )
    centre = sign * apart
    axes[2].fill_between(r, centre - beam, centre + beam, color="tab:red", alpha=0.3, lw=0, label="beam")
    axes[2].fill_between(r, -field, field, color="tab:blue", alpha=0.2, lw=0, label="field of view")
    axes[2].plot(r, centre, color="tab:red", lw=0.8)
    axes[2].set(xlabel="range along the receiver's axis, m", ylabel="across, m", xlim=(r[0], r[-1]))
    axes[2].legend(fontsize=8)
    for axis in axes:
        axis.grid(alpha=0.3)
    mark(axes, data)
    figure.suptitle(f"Overlap of beam and receiver: {data['title']}")
    figure.savefig(sys.argv[2], dpi=110, format="png")


main()
