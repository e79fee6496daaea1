"""Chart of error against time for every knob of an instrument. Usage: chart.py FIGURES.json CHART.png"""

import json
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter

MARKERS = "osD^v<>Php*Xd8"
JOINT = "samples and sky_directions"
FLOOR = 1e-9  # an error of zero has a place on a logarithmic axis too


def bars(points, value, low, high):
    """Lengths of error bars below and above, never negative."""
    return [[max(0.0, p[value] - max(p[low], FLOOR)) for p in points], [max(0.0, p[high] - p[value]) for p in points]]


def labels_apart(axis, points):
    """Names each point of the front; of neighbours that would overlap the later is left out."""
    axis.figure.canvas.draw()
    taken = []
    for p in points:
        name = p["label"] if p["knob"] in (JOINT, "samples", "own") else f'{p["knob"]} {p["label"]}'
        text = axis.annotate(
            name, (p["time_s"], max(p["error"], FLOOR)), xytext=(5, 6), textcoords="offset points", fontsize=7
        )
        box = text.get_window_extent()
        if any(box.overlaps(other) for other in taken):
            text.remove()
        else:
            taken.append(box)


def draw(axis, data, device):
    points = [p for p in data["points"] if p["device"] == device and "refused" not in p]
    knobs = [k for k in dict.fromkeys(p["knob"] for p in points) if k not in ("own", JOINT)]
    joint = [p for p in points if p["knob"] == JOINT]
    if joint:
        axis.plot(
            [p["time_s"] for p in joint],
            [max(p["error"], FLOOR) for p in joint],
            ".",
            color="0.6",
            ms=5,
            label=JOINT,
            zorder=1,
        )
    for i, knob in enumerate(knobs):
        some = [p for p in points if p["knob"] == knob]
        axis.errorbar(
            [p["time_s"] for p in some],
            [max(p["error"], FLOOR) for p in some],
            xerr=bars(some, "time_s", "time_low_s", "time_high_s"),
            yerr=bars(some, "error", "error_low", "error_high"),
            fmt=MARKERS[i % len(MARKERS)] + "-",
            color=f"C{i % 10}",
            ms=4,
            lw=0.9,
            elinewidth=0.7,
            alpha=0.85,
            label=knob,
        )
    front = sorted((p for p in points if p["front"]), key=lambda p: p["time_s"])
    axis.plot(
        [p["time_s"] for p in front],
        [max(p["error"], FLOOR) for p in front],
        "-",
        color="k",
        lw=1.6,
        alpha=0.5,
        label="Pareto front",
        zorder=0,
    )
    own = next(p for p in points if p["knob"] == "own")
    axis.plot(own["time_s"], max(own["error"], FLOOR), "*", color="k", ms=13, mfc="none", label="the file's setting")
    axis.axhline(data["tolerance"], color="r", ls="--", lw=1, label=f'tolerance {100 * data["tolerance"]:g} %')
    axis.axhspan(1e-12, data["reference_error"], color="0.85", zorder=-1, label="below the reference's own error")
    errors = [max(p["error"], FLOOR) for p in points]
    axis.set(
        xscale="log",
        yscale="log",
        xlabel="time of the image, s" if data["kind"] == "cube" else "time of the survey, s",
        ylim=(0.5 * min(errors + [data["reference_error"] or min(errors)]), 2 * max(errors + [data["tolerance"]])),
        title=device,
    )
    axis.yaxis.set_major_formatter(FuncFormatter(lambda error, _: f"{100 * error:g} %"))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda seconds, _: f"{seconds:g}"))
    axis.grid(alpha=0.3, which="both", lw=0.4)
    labels_apart(axis, front)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    devices = list(dict.fromkeys(p["device"] for p in data["points"]))
    figure, axes = plt.subplots(
        1, len(devices), figsize=(3 + 7 * len(devices), 7.5), squeeze=False, sharey=True, layout="constrained"
    )
    for axis, device in zip(axes[0], devices):
        draw(axis, data, device)
    figure_name = {"rms": "rms over", "p99": "99th percentile over", "worst": "worst of"}[data["tolerance_of"]]
    listed = " of " + ", ".join(data["tolerance_materials"]) if data["tolerance_materials"] else ""
    axes[0][0].set_ylabel(
        f"error of the worst band: {figure_name} pixels{listed} / band mean"
        if data["kind"] == "cube"
        else "error: rms of waveforms / rms of their peaks"
    )
    axes[0][-1].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    caption = (
        f'{data["name"]}: {data["validated"]} {"pixels" if data["kind"] == "cube" else "pulses"} against '
        f'{data["reference"]}, its own error '
        f'{100 * data["reference_error"]:.2g} %. Time of {data["time_of"]}. {"; ".join(data["machines"])}'
    )
    figure.suptitle("\n".join(textwrap.wrap(caption, 60 + 60 * len(devices))), fontsize=9)
    figure.savefig(sys.argv[2], dpi=110, format="png")


main()
