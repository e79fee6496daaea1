#!/usr/bin/python3
"""Speed against accuracy of the layered air: bench/solver_accuracy.py [--figures FILE.json]

Builds and runs build/raycube_solver_accuracy (about a minute), writes build/bench/solver_accuracy.json and .csv, draws
docs/pictures/solver_accuracy.png and prints the table of docs/atmosphere.md. --figures draws an earlier run's file
anew.
"""

import argparse
import csv
import json
import pathlib
import subprocess

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

ROOT = pathlib.Path(__file__).resolve().parent.parent
KNOBS = {
    "streams": ("streams", "ms of CPU per wavelength"),
    "layering": ("layers (times the default 33)", "ms of CPU per wavelength"),
    "k-terms": ("k-terms", "ms of CPU per wavelength"),
    "step": ("spectral step, nm", "ms of CPU per channel\n(10 nm wide; LWIR 500 nm)"),
}
QUANTITIES = ["path radiance", "sky radiance", "fluxes"]
COLOURS = {
    "visible": "tab:green",
    "red edge, oxygen": "tab:red",
    "water band": "tab:blue",
    "SWIR": "tab:orange",
    "LWIR": "tab:purple",
}


def measure(folder):
    subprocess.run(["cmake", "--build", ROOT / "build", "--target", "raycube_solver_accuracy"], check=True)
    folder.mkdir(parents=True, exist_ok=True)
    figures = folder / "solver_accuracy.json"
    subprocess.run([ROOT / "build/raycube_solver_accuracy", figures], check=True)
    return figures


def series(points, knob, window, quantity):
    rows = [p for p in points if (p["knob"], p["window"], p["quantity"]) == (knob, window, quantity)]
    return sorted(rows, key=lambda p: p["setting"])


def draw(points, file):
    figure, axes = plt.subplots(len(QUANTITIES), len(KNOBS), figsize=(14, 9.2), sharey="row", sharex="col")
    for row, quantity in enumerate(QUANTITIES):
        for column, (knob, (title, x_label)) in enumerate(KNOBS.items()):
            axis = axes[row][column]
            for window, colour in COLOURS.items():
                line = series(points, knob, window, quantity)
                time = [p["cpu_ms"] for p in line]
                axis.plot(time, [100 * p["rms"] for p in line], "o-", color=colour, ms=4, lw=1.3, label=window)
                axis.plot(time, [100 * p["worst"] for p in line], ":", color=colour, lw=0.9)
                for p in line:
                    if p["default"]:
                        axis.plot(p["cpu_ms"], 100 * p["rms"], "o", mfc="none", mec="black", ms=9, mew=1.1)
                    if window == "visible" or (window == "LWIR" and knob == "step"):
                        axis.annotate(
                            f"{p['setting']:g}",
                            (p["cpu_ms"], 100 * p["rms"]),
                            textcoords="offset points",
                            xytext=(-5, -12),
                            ha="center",
                            fontsize=8,
                            color=colour,
                        )
            axis.set(xscale="log", yscale="log")
            axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.xaxis.set_minor_formatter(NullFormatter())
            axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.margins(x=0.1, y=0.1)
            axis.grid(True, which="major", lw=0.4, alpha=0.6)
            if row == 0:
                axis.set_title(title, fontsize=11)
            if row == len(QUANTITIES) - 1:
                axis.set_xlabel(x_label, fontsize=9)
            if column == 0:
                axis.set_ylabel(f"{quantity}\nerror, %", fontsize=10)
    handles, labels = axes[0][0].get_legend_handles_labels()
    handles.append(plt.Line2D([], [], color="grey", ls=":", lw=0.9))
    handles.append(plt.Line2D([], [], ls="", marker="o", mfc="none", mec="black", ms=9))
    figure.legend(
        handles,
        labels + ["worst (dots and lines: rms)", "default setting"],
        loc="upper center",
        ncol=7,
        fontsize=9.5,
        bbox_to_anchor=(0.5, 0.955),
        frameon=False,
    )
    figure.suptitle(
        "Layered air: error against time, one setting changed at a time (midlatitude summer, rural 23 km, sun at 40 "
        "degrees)",
        fontsize=12,
        y=0.985,
    )
    figure.tight_layout(rect=(0, 0, 1, 0.93))
    figure.savefig(file, dpi=90, metadata={"Software": None})


def write_csv(points, file):
    with open(file, "w", newline="") as out:
        writer = csv.DictWriter(out, fieldnames=list(points[0]))
        writer.writeheader()
        writer.writerows(points)


def shown(value):
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def percent(value):
    return shown(100 * value) if value >= 1e-6 else "< 0.0001"


def table(points):
    """Markdown: a row per setting, rms / worst in percent, over the four windows of the sun and over the thermal
    one."""
    print(
        "| setting | ms | path radiance | sky radiance | fluxes | LWIR: path, sky, fluxes (rms) |\n"
        "|---|---|---|---|---|---|"
    )
    for knob in KNOBS:
        settings = sorted(
            {p["setting"] for p in points if p["knob"] == knob and (knob != "step" or p["window"] != "LWIR")}
        )
        for setting in settings:
            # Thermal steps stand beside the solar ones of the same multiple of the finest.
            rows = [
                p
                for p in points
                if p["knob"] == knob
                and p["setting"] == setting * (50 if p["window"] == "LWIR" and knob == "step" else 1)
            ]
            sun = [p for p in rows if p["window"] != "LWIR"]
            cells = []
            for quantity in QUANTITIES:
                found = [p for p in sun if p["quantity"] == quantity]
                rms = (sum(p["rms"] ** 2 for p in found) / len(found)) ** 0.5
                cells.append(f"{percent(rms)} / {percent(max(p['worst'] for p in found))}")
            thermal = [
                percent(p["rms"]) for q in QUANTITIES for p in rows if p["window"] == "LWIR" and p["quantity"] == q
            ]
            times = [p["cpu_ms"] for p in sun]
            mark = " (default)" if knob != "step" and all(p["default"] for p in rows) else ""
            name = (
                f"step {setting:g} nm" + f" (LWIR {50 * setting:g})" if knob == "step" else f"{knob} {setting:g}{mark}"
            )
            print(f"| {name} | {shown(min(times))}-{shown(max(times))} | {' | '.join(cells)} | {', '.join(thermal)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figures", type=pathlib.Path, help="draw this file instead of measuring")
    parser.add_argument("--picture", type=pathlib.Path, default=ROOT / "docs/pictures/solver_accuracy.png")
    arguments = parser.parse_args()
    folder = ROOT / "build/bench"
    points = json.loads((arguments.figures or measure(folder)).read_text())
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(points, folder / "solver_accuracy.csv")
    draw(points, arguments.picture)
    table(points)


if __name__ == "__main__":
    main()
