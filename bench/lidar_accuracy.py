#!/usr/bin/python3
"""Accuracy of a LIDAR's settings against their cost: bench/lidar_accuracy.py [--figures FILE.json]

Builds and runs build/raycube_lidar_accuracy (about a minute), writes build/bench/lidar_accuracy.json, draws
docs/pictures/lidar_accuracy.png and prints the tables of docs/lidar.md. --figures draws an earlier run's file anew.
"""

import argparse
import json
import pathlib
import subprocess

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = pathlib.Path(__file__).resolve().parent.parent


def measure(folder):
    subprocess.run(["cmake", "--build", ROOT / "build", "--target", "raycube_lidar_accuracy"], check=True)
    folder.mkdir(parents=True, exist_ok=True)
    figures = folder / "lidar_accuracy.json"
    subprocess.run([ROOT / "build/raycube_lidar_accuracy", figures], check=True)
    return figures


def groups(points, key):
    names = list(dict.fromkeys(p[key] for p in points))
    return [(name, [p for p in points if p[key] == name]) for name in names]


def curve(axis, points, **how):
    """Error, in per cent, over the time of a pulse, with each point's setting beside it."""
    places = [(p["us_per_pulse"], 100 * p["error"]) for p in points]
    axis.loglog(*zip(*places), "o-", ms=4, **how)
    for p, place in zip(points, places):
        axis.annotate(f"{p['setting']}", place, textcoords="offset points", xytext=(4, 4), fontsize=8)


def draw(data, file):
    figure, axes = plt.subplots(2, 3, figsize=(14, 8))
    axis = axes[0][0]
    for name, points in groups(data["subrays"], "scene"):
        curve(axis, points, label=name)
    axis.set(
        title="sub-rays of a pulse (against 32768)",
        xlabel="device time, us per pulse",
        ylabel="rms waveform error, % of the peak",
    )
    axis = axes[0][1]
    for name, points in groups(data["shape"], "method"):
        axis.loglog([p["setting"] for p in points], [p["error"] for p in points], "o-", ms=4, label=name)
    axis.set(
        title="pulse of 4 ns in bins of 1 ns (against its integral)",
        xlabel="sub-bins, or phases, in a bin",
        ylabel="worst bin error over the peak bin",
    )
    axis = axes[0][2]
    curve(axis, data["bounces"], color="tab:red", label="Lambert corner, 0.5 and 0.4")
    axis.axhline(0.2, color="tab:gray", ls="--", lw=1)
    axis.text(data["bounces"][0]["us_per_pulse"], 0.21, "noise of drawn directions", fontsize=8, va="bottom")
    axis.set(
        title="bounces (4096 sub-rays; against all orders)",
        xlabel="device time, us per pulse",
        ylabel="light left out, %",
    )
    axis = axes[1][0]
    for name, points in groups(data["line_nodes"], "case"):
        axis.loglog([p["setting"] for p in points], [max(p["error"], 1e-16) for p in points], "o-", ms=4, label=name)
    axis.set(
        title="nodes of a laser line on an absorption line",
        xlabel="Gauss-Hermite nodes",
        ylabel="error of the two-way transmission",
    )
    axis.set_ylim(1e-13, 1e6)
    axis = axes[1][1]
    axis.loglog(
        [p["setting"] for p in data["node_times"]],
        [p["us_per_pulse"] for p in data["node_times"]],
        "o-",
        ms=4,
        color="tab:brown",
        label="64 sub-rays, air",
    )
    axis.set(title="what nodes cost", xlabel="Gauss-Hermite nodes", ylabel="device time, us per pulse")
    axis = axes[1][2]
    ranges = [p["range_m"] / 1e3 for p in data["ranges"]]
    axis.loglog(
        ranges,
        [1e3 * p["float_seconds_m"] for p in data["ranges"]],
        "s--",
        color="tab:gray",
        label="times kept in single precision",
    )
    axis.loglog(
        ranges,
        [1e3 * p["ours_m"] for p in data["ranges"]],
        "o-",
        color="tab:blue",
        label="raycube, single precision near the scene",
    )
    axis.set(title="worst range error, slope 1e-3, 0.1 ns bins", xlabel="range, km", ylabel="mm")
    for axis in axes.flat:
        axis.grid(True, which="major", alpha=0.4)
        axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def table(data):
    print("| sub-rays |" + "".join(f" {p['setting']} |" for p in data["subrays"] if p["scene"].startswith("terrain")))
    for name, points in groups(data["subrays"], "scene"):
        print(f"| {name}: rms error, % of the peak |" + "".join(f" {100 * p['error']:.2g} |" for p in points))
        print(f"| us per pulse |" + "".join(f" {p['us_per_pulse']:.3g} |" for p in points))
    for p in data["ranges"]:
        print(
            f"range {p['range_m'] / 1e3:g} km: {1e3 * p['ours_m']:.3g} mm; float seconds "
            f"{1e3 * p['float_seconds_m']:.3g} mm"
        )
    for p in data["bounces"]:
        print(f"{p['setting']} bounces: {100 * p['error']:.2g} % left out, {p['us_per_pulse']:.3g} us")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figures", type=pathlib.Path)
    options = parser.parse_args()
    figures = options.figures or measure(ROOT / "build/bench")
    data = json.loads(figures.read_text())
    draw(data, ROOT / "docs/pictures/lidar_accuracy.png")
    table(data)


if __name__ == "__main__":
    main()
