"""Chart of a sweep. Usage: sweep.py FIGURES.json PICTURE.png

FIGURES.json is what `raycube sweep` writes as sweep.json: a row of panels for each metric.
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

INK, SOFT = "#1f5f8b", "#b9c8d2"


def values(numbers):
    return np.array([np.nan if v is None else v for v in numbers], dtype=float)


def name_of(metric):
    return metric["name"] + (f", {metric['unit']}" if metric["unit"] else "")


def scatter(axes, data, metric, at):
    """The metric over one parameter; a line where the others are at rest."""
    points = np.array([[point[p["name"]] for p in data["parameters"]] for point in data["points"]], dtype=float)
    y = values([point[metric["name"]] for point in data["points"]])
    x, parameter = points[:, at], data["parameters"][at]
    if data["method"] == "one_at_a_time":
        others = [i for i in range(points.shape[1]) if i != at]
        rest = np.array([data["parameters"][i]["rest"] for i in others])
        alone = (points[:, others] == rest).all(1) if others else np.ones(len(x), bool)
        order = np.argsort(x[alone])
        axes.plot(x[alone][order], y[alone][order], "o-", color=INK, ms=4)
    else:
        axes.plot(x, y, "o", color=SOFT, ms=3)
        levels = np.unique(x)
        if len(levels) <= 12:
            axes.plot(levels, [np.nanmean(y[x == v]) for v in levels], "o-", color=INK, ms=4)
    if parameter["log"]:
        axes.set_xscale("log")
    axes.set(xlabel=parameter["name"], ylabel=name_of(metric))


def bars(axes, metric):
    """First order and total, with their intervals."""
    indices = metric["indices"]
    place = np.arange(len(indices))
    for shift, kind, colour in ((-0.18, "first", INK), (0.18, "total", SOFT)):
        height = values([i[kind] for i in indices])
        low, high = (values([i[f"{kind}_95"][k] for i in indices]) for k in (0, 1))
        axes.bar(place + shift, height, 0.34, color=colour, label="first order" if kind == "first" else "total")
        around = np.maximum(0, [height - low, high - height])
        axes.errorbar(place + shift, height, around, fmt="none", ecolor="0.2", capsize=2, lw=1)
    axes.set_xticks(place, [i["parameter"] for i in indices], rotation=15)
    axes.set(ylabel="share of the variance", title=name_of(metric))
    axes.legend(frameon=False, fontsize=8)


def main(figures, picture):
    with open(figures, encoding="utf-8") as file:
        data = json.load(file)
    metrics, parameters = data["metrics"], data["parameters"]
    sobol = data["method"] == "sobol"
    columns = len(parameters) + int(sobol)
    figure, axes = plt.subplots(
        len(metrics), columns, figsize=(3.2 * columns, 2.8 * len(metrics)), squeeze=False, layout="constrained"
    )
    for row, metric in zip(axes, metrics):
        for at in range(len(parameters)):
            scatter(row[at], data, metric, at)
        if sobol:
            bars(row[-1], metric)
    figure.suptitle(data["title"])
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:3])
