"""Picture of an analysis. Usage: analyze.py FIGURES.json PICTURE.png

FIGURES.json is what `raycube analyze` writes as VERB.json; which picture it is, its "analysis" says.
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def abscissa(data):
    """Of spectra: wavelengths, or numbers of bands; and what they are."""
    if "wavelength_um" in data:
        return 1e3 * np.asarray(data["wavelength_um"]), "wavelength, nm"
    return np.asarray(data["bands"], dtype=float), "band"


def values(numbers):
    return np.array([np.nan if v is None else v for v in numbers], dtype=float)


def spectrum(axes, data, curve, **style):
    """A line over wavelength, interrupted where bands are left out."""
    x, name = abscissa(data)
    order = np.argsort(x)
    x, y, band = x[order], values(curve)[order], np.asarray(data["bands"])[order]
    gaps = np.flatnonzero(np.abs(np.diff(band)) > 1) + 1
    axes.plot(np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan), lw=1.2, **style)
    axes.set(xlabel=name)


def unit(data):
    return data.get("data_units", "value")


def statistics(data, figure):
    left, right = figure.subplots(1, 2)
    for region in data["regions"]:
        spectrum(left, data, region["mean"], label=f"{region['region']} ({region['pixels']} pixels)")
        spectrum(right, data, region["standard_deviation"], label=region["region"])
    left.set(ylabel=unit(data), title="mean")
    right.set(ylabel=unit(data), title="standard deviation")
    left.legend(fontsize=8)


def detect(data, figure):
    axes = figure.subplots()
    spectrum(axes, data, data["background"]["mean"], label="background's mean", color="black")
    for target in data.get("targets", []):
        spectrum(axes, data, target["spectrum"], label=target["name"])
    axes.set(ylabel=unit(data), title="targets and background")
    axes.legend(fontsize=8)


def unmix(data, figure):
    left, right = figure.subplots(1, 2)
    for endmember in data["endmembers"]:
        spectrum(left, data, endmember["spectrum"], label=endmember["name"])
    left.set(ylabel=unit(data), title="endmembers")
    left.legend(fontsize=8)
    names, regions = data["layers"][:-1], data["regions"]
    bottom = np.zeros(len(regions))
    for k, name in enumerate(names):
        share = values([region["mean"][k] for region in regions])
        right.bar([region["region"] for region in regions], share, bottom=bottom, label=name)
        bottom += share
    right.set(ylabel="share", title="mean shares")
    right.legend(fontsize=8)


def kmeans(data, figure):
    axes = figure.subplots()
    for one in data["classes"]:
        spectrum(axes, data, one["center"], label=f"{one['name']} ({one['pixels']} pixels)")
    axes.set(ylabel=unit(data), title=f"centres after {data['rounds']} rounds")
    axes.legend(fontsize=8)


def classify(data, figure):
    parts = figure.subplots(1, 2 if "confusion" in data else 1, squeeze=False)[0]
    for one in data["classes"]:
        spectrum(parts[0], data, one["mean"], label=f"{one['name']} ({one['pixels']} pixels)")
    parts[0].set(ylabel=unit(data), title="means of the classes")
    parts[0].legend(fontsize=8)
    if "confusion" in data:
        confusion = data["confusion"]
        count, names = np.asarray(confusion["count"], dtype=float), confusion["names"]
        share = count / np.maximum(count.sum(axis=1, keepdims=True), 1)
        image = parts[1].imshow(share, vmin=0, vmax=1, cmap="Blues")
        for (i, j), n in np.ndenumerate(count):
            color = "white" if share[i, j] > 0.6 else "black"
            parts[1].text(j, i, f"{n:.0f}", ha="center", va="center", fontsize=8, color=color)
        parts[1].set_xticks(range(len(names) + 1), [*names, "none"], rotation=45, ha="right")
        parts[1].set_yticks(range(len(names)), names)
        kappa = "not defined" if confusion["kappa"] is None else f"{confusion['kappa']:.3f}"
        title = f"accuracy {confusion['accuracy']:.3f}, kappa {kappa}"
        parts[1].set(xlabel="map", ylabel="truth", title=title)
        figure.colorbar(image, ax=parts[1], label="share of the truth's pixels")


def eigen(data, figure):
    left, right = figure.subplots(1, 2)
    for structure, style in zip(data["structures"], ("-", "--")):
        value = values(structure["over_the_first"])
        left.semilogy(
            np.arange(1, len(value) + 1), np.maximum(value, 1e-18), style, marker=".", label=structure["cube"]
        )
        for k, vector in enumerate(structure["eigenvectors"]):
            spectrum(right, data, vector, ls=style, color=f"C{k}", label=f"{k + 1}" if style == "-" else None)
    left.set(xlabel="number", ylabel="eigenvalue over the first", title="eigenvalues")
    left.legend(fontsize=7)
    right.set(title="eigenvectors")
    right.legend(fontsize=8)


def reflectance(data, figure):
    left, right = figure.subplots(1, 2)
    for panel in data["panels"]:
        spectrum(left, data, panel["in_cube"], label=panel["name"])
    left.set(ylabel=unit(data), title="panels in the cube")
    left.legend(fontsize=8)
    spectrum(right, data, data["gain"], label="gain")
    # Bands through which nothing comes from the ground have gains a thousand times those of the others.
    right.set(ylabel=f"reflectance per {unit(data)}", title="gain of the line", yscale="log")


def edge(data, figure):
    spread, line, transfer = figure.subplots(1, 3)
    edges = data["edges"]
    shown = edges if len(edges) <= 6 else [edges[i] for i in np.linspace(0, len(edges) - 1, 6).astype(int)]
    frequency = np.asarray(data["frequency_cycles_per_px"])
    for one in shown:
        at = np.asarray(one["at_px"])
        spread.plot(at, values(one["edge_spread"]), ".-", ms=2, lw=0.8, label=one["band"])
        line.plot(0.5 * (at[1:] + at[:-1]), values(one["line_spread"]), lw=1)
        transfer.plot(frequency, values(one["mtf"]), lw=1.2, label=one["band"])
    spread.set(xlabel="from the edge, px", ylabel="level", title="edge spread")
    line.set(xlabel="from the edge, px", ylabel="share of the step per quarter pixel", title="line spread")
    transfer.axvline(0.5, color="black", lw=0.8, ls=":")
    transfer.set(
        xlabel="cycles per pixel (dotted: Nyquist)", ylabel="MTF", ylim=(0, 1.05), xlim=(0, 1), title="transfer"
    )
    transfer.legend(fontsize=7)


def roc(data, figure):
    axes = figure.subplots()
    for curve in data["curves"]:
        points = np.array([[p[0], p[1]] for p in curve["points"]])
        first = 100 * curve["before_first_false_alarm"]
        label = f"share at least {curve['least_share']:g}: {first:.1f} % before the first false alarm"
        least = 0.5 / curve["negatives"]
        axes.step(np.maximum(points[:, 0], least), points[:, 1], where="post", label=label)
    axes.set(xscale="log", xlabel="false alarms per pixel (left end: none)", ylabel="detection rate", ylim=(0, 1.02))
    axes.set(title=f"{'targets' if data['per_target'] else 'pixels'} found, share of {data['share_of']}")
    axes.legend(fontsize=8)


def register(data, figure):
    axes = figure.subplots()
    whole, blocks = data["whole"], [b for b in data["blocks"] if b["found"]]
    if blocks:
        at = np.array([[b["sample"], b["line"], b["samples"], b["lines"]] for b in blocks])
        arrows = axes.quiver(at[:, 0], at[:, 1], at[:, 2], at[:, 3], angles="xy")
        axes.quiverkey(arrows, 0.9, 1.03, 1, "1 pixel", labelpos="E")
        axes.invert_yaxis()
    axes.set(xlabel="sample", ylabel="line", aspect="equal")
    axes.set_title(f"{whole['samples']:.3f} samples, {whole['lines']:.3f} lines", loc="left", fontsize=9)
    axes.margins(0.15)


def scorecard(data, figure):
    left, right = figure.subplots(1, 2)
    for axes, key, title in ((left, "means", "means"), (right, "deviations", "standard deviations")):
        for values_of, name, style in zip(data[key], (data["cube"], data["other"]), ("-", "--")):
            spectrum(axes, data, values_of, ls=style, label=name)
        axes.set(ylabel=unit(data), title=title)
    left.legend(fontsize=7)


PICTURES = {
    of.__name__: (of, wide)
    for of, wide in (
        (statistics, 12),
        (detect, 7),
        (unmix, 12),
        (kmeans, 7),
        (classify, 12),
        (eigen, 12),
        (reflectance, 12),
        (edge, 15),
        (roc, 7),
        (register, 7),
        (scorecard, 12),
    )
}


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    draw, wide = PICTURES[data["analysis"]]
    figure = plt.figure(figsize=(wide, 4.6), layout="constrained")
    draw(data, figure)
    for axes in figure.axes:
        if axes.get_label() != "<colorbar>" and not axes.images:
            axes.grid(alpha=0.3)
    figure.savefig(sys.argv[2], dpi=110)


main()
