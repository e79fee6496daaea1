#!/usr/bin/python3
"""Draws docs/pictures/atmosphere_*.png: layered tables against published results.

    RAYCUBE_SHARED=... docs/pictures/atmosphere_charts.py BUILD_FOLDER

Runs the tests anchor_* of that build, which write what they compare to $RAYCUBE_CHARTS, and draws it. Needs matplotlib.
"""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

TESTS = ["lowtran_thermal", "modtran5", "modtran6", "uvspec", "g173"]
PICTURES = pathlib.Path(__file__).resolve().parent
BLUE, ORANGE, GREEN, RED, GREY = "#1f5fa8", "#d9742b", "#2f8f5b", "#b3323c", "#777777"
plt.rcParams.update(
    {
        "font.size": 9,
        "axes.grid": True,
        "grid.color": "#dddddd",
        "grid.linewidth": 0.6,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "lines.linewidth": 1.1,
    }
)


def read(folder, name):
    with open(folder / f"{name}.csv", encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    return {key: [float(row[key]) for row in rows] for key in rows[0]}


def two_panels(title, heights=(3, 2)):
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(9, 6), sharex=True, height_ratios=heights, layout="constrained")
    top.set_title(title, loc="left", fontsize=10)
    return figure, top, bottom


def shade(axes, spans, label=None):
    for axis in axes:
        for k, (low, high) in enumerate(spans):
            axis.axvspan(
                low, high, color="#f0e6d8", lw=0, label=label if k == 0 and axis is axes[0] else None, zorder=0
            )


def save(figure, name):
    figure.savefig(PICTURES / f"atmosphere_{name}.png", dpi=110)
    plt.close(figure)


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def percent(a, b):
    return [100 * (x / y - 1) for x, y in zip(a, b)]


def modtran5_transmission(folder):
    d = read(folder, "modtran5_transmission")
    figure, top, bottom = two_panels(
        "A-13  Transmission straight down to the sea, midlatitude summer, rural aerosol\n"
        "MODTRAN 5.2.1 (grey) and raycube, triangular slit of 20 nm"
    )
    for key, colour, label in (
        ("1", BLUE, "from 1 km, visibility 23 km"),
        ("20", GREEN, "from 20 km, 23 km"),
        ("5", RED, "from 1 km, 5 km"),
    ):
        top.plot(d["um"], d[f"r{key}"], color="#bbbbbb", lw=2.6)
        top.plot(d["um"], d[f"t{key}"], color=colour, label=label)
    top.set_ylabel("transmission")
    top.legend(loc="upper center", bbox_to_anchor=(0.72, 1.02))
    bands = [
        (0.58, 0.7, 0.002),
        (0.7, 1, 0.0052),
        (1, 1.3, 0.0078),
        (1.3, 1.5, 0.0182),
        (1.5, 1.75, 0.0117),
        (1.75, 2, 0.0156),
        (2, 2.4, 0.0143),
        (2.4, 3, 0.0169),
        (3, 3.4, 0.039),
        (3.4, 3.96, 0.0338),
    ]
    for low, high, bar in bands:
        bottom.fill_between(
            [low, high], -bar, bar, color="#f0e6d8", lw=0, label="bar of the rms at 1 km" if low == 0.58 else None
        )
    for key, colour in (("1", BLUE), ("20", GREEN), ("5", RED)):
        bottom.plot(d["um"], minus(d[f"t{key}"], d[f"r{key}"]), color=colour, lw=0.8)
    bottom.set(ylabel="raycube - MODTRAN", xlabel="wavelength, um", ylim=(-0.12, 0.12), xlim=(0.4, 4.0))
    bottom.legend(loc="upper left")
    save(figure, "modtran5_transmission")


def running_mean(values, half):
    out = []
    for i in range(len(values)):
        part = values[max(0, i - half) : i + half + 1]
        out.append(sum(part) / len(part))
    return out


def modtran5_thermal(folder):
    d = read(folder, "modtran5_thermal")
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.4), sharex=True, height_ratios=(3, 2), layout="constrained")
    figure.suptitle(
        "A-13  Thermal window straight down, midlatitude summer: MODTRAN 5.2.1 (pale: means over 40 nm) and raycube, "
        "which resolves\n"
        "0.2 um at 10 um. Below: 40 nm pale, running means over 0.5 um bold.",
        fontsize=10,
        x=0.01,
        ha="left",
    )
    lwir = [i for i, um in enumerate(d["um"]) if um >= 7.9]
    um = [d["um"][i] for i in lwir]
    for key, colour, label in (
        ("1", BLUE, "from 1 km, visibility 23 km"),
        ("20", GREEN, "from 20 km, 23 km"),
        ("5", RED, "from 1 km, 5 km"),
    ):
        t, rt, l, rl = ([d[name][i] for i in lwir] for name in (f"t{key}", f"rt{key}", f"l{key}", f"rl{key}"))
        pale = {"color": colour, "alpha": 0.3, "lw": 0.8}
        bold = {"color": colour, "lw": 1.6}
        axes[0][0].plot(um, rt, **pale)
        axes[0][0].plot(um, t, **bold)
        axes[1][0].plot(um, minus(t, rt), **pale)
        axes[1][0].plot(um, minus(running_mean(t, 6), running_mean(rt, 6)), **bold)
        axes[0][1].plot(um, rl, **pale)
        axes[0][1].plot(um, l, label=label, **bold)
        axes[1][1].plot(um, percent(l, rl), **pale)
        axes[1][1].plot(um, percent(running_mean(l, 6), running_mean(rl, 6)), **bold)
    axes[0][0].set_ylabel("transmission")
    axes[1][0].set(ylabel="raycube - MODTRAN", xlabel="wavelength, um", ylim=(-0.15, 0.15))
    axes[0][1].set_ylabel("path radiance with the ground's\nlight scattered in, W m$^{-2}$ sr$^{-1}$ um$^{-1}$")
    axes[1][1].set(ylabel="raycube over MODTRAN - 1, %", xlabel="wavelength, um", ylim=(-30, 30), xlim=(7.9, 13.05))
    axes[0][1].legend(loc="upper center")
    for column in (0, 1):
        shade([axes[0][column], axes[1][column]], [(9.4, 10.0)])
    axes[0][0].text(9.7, 0.06, "ozone", ha="center", color=GREY)
    save(figure, "modtran5_thermal")


def modtran6(folder):
    d, t = read(folder, "modtran6_path"), read(folder, "modtran6_transmission")
    figure, top, bottom = two_panels(
        "A-14  Nadir from 2.3 km over 0.35 km, sun at 52 degrees: raycube against MODTRAN 6 (correlated-k, DISORT)",
        (1, 1),
    )
    bands = [(0.678, 0.738), (0.752, 0.776), (0.804, 0.842)]
    shade([top, bottom], bands, "bands of O$_2$ and water")
    top.axhspan(-3, 3, color=BLUE, alpha=0.08, lw=0, label="bar at depth 0.04: 3 %")
    top.plot(
        d["um"], [100 * (r - 1) for r in d["ratio_clear"]], color=BLUE, marker="o", ms=3, label="aerosol depth 0.04"
    )
    top.plot(
        d["um"],
        [100 * (r - 1) for r in d["ratio_010"]],
        color=ORANGE,
        marker="o",
        ms=3,
        label="aerosol depth 0.10 (bar 8 %)",
    )
    top.set(ylabel="path radiance, raycube\nover MODTRAN - 1, %", ylim=(-9, 9))
    top.legend(loc="lower left", ncols=2)
    bottom.axhspan(-0.003, 0.003, color=BLUE, alpha=0.08, lw=0, label="bar outside bands: 0.003")
    bottom.plot(t["um"], t["t_error_clear"], color=BLUE, marker="o", ms=2.5)
    bottom.plot(t["um"], t["t_error_010"], color=ORANGE, marker="o", ms=2.5)
    bottom.set(
        ylabel="transmission,\nraycube - MODTRAN", xlabel="wavelength, um", xlim=(0.395, 0.875), ylim=(-0.012, 0.045)
    )
    bottom.legend(loc="upper left")
    save(figure, "modtran6_path")


def uvspec(folder):
    d = read(folder, "uvspec_sky")
    figure, top, bottom = two_panels(
        "A-16  Sky towards the sun (right) and away from it, sun at 40 degrees, rural aerosol of 23 km\n"
        "uvspec-DISORT (rings) and raycube, over each code's own solar irradiance"
    )
    for um, colour in ((0.42, BLUE), (0.55, GREEN), (0.865, ORANGE), (1.65, RED)):
        rows = sorted(
            (z, f, r) for u, z, f, r in zip(d["um"], d["zenith"], d["found"], d["reference"]) if abs(u - um) < 1e-6
        )
        zenith, found, reference = zip(*rows)
        top.semilogy(zenith, found, color=colour, label=f"{um} um")
        top.semilogy(zenith, reference, "o", mfc="none", color=colour, ms=5)
        bottom.plot(zenith, percent(found, reference), color=colour, marker="o", ms=3)
    bottom.axhspan(-3, 3, color=BLUE, alpha=0.08, lw=0, label="bar: 3 %")
    top.set_ylabel("radiance over solar irradiance, sr$^{-1}$")
    top.legend(ncols=4, loc="upper left")
    bottom.set(
        ylabel="raycube over uvspec - 1, %",
        xlabel="zenith angle in the sun's plane, degrees (sun at +40)",
        ylim=(-6, 6),
    )
    bottom.legend(loc="upper left")
    save(figure, "uvspec_sky")


def g173(folder):
    d = read(folder, "g173")
    figure, top, bottom = two_panels(
        "A-20  Direct normal light of ASTM G173-03 from its stated inputs and its own sun, means over 10 nm"
    )
    top.plot(d["um"], d["reference"], color="#bbbbbb", lw=2.8, label="ASTM G173, direct and circumsolar")
    top.plot(d["um"], d["found"], color=BLUE, label="raycube")
    top.set_ylabel("irradiance, W m$^{-2}$ nm$^{-1}$")
    top.legend(loc="upper right")
    through = [r / e for r, e in zip(d["reference"], d["extraterrestrial"])]
    cores = [(u - 0.005, u + 0.005) for u, t in zip(d["um"], through) if t <= 0.3]
    shade([top, bottom], cores, "less than 0.3 comes through")
    points = [(u, 100 * (f / r - 1)) for u, f, r, t in zip(d["um"], d["found"], d["reference"], through) if t > 0.3]
    bottom.axhspan(-3, 3, color=BLUE, alpha=0.08, lw=0, label="bar of the mean: 3 %")
    bottom.plot(*zip(*points), ".", color=BLUE, ms=4)
    bottom.set(ylabel="raycube over ASTM - 1, %", xlabel="wavelength, um", xlim=(0.4, 2.4), ylim=(-18, 18))
    top.legend(loc="upper right")
    bottom.legend(loc="lower left")
    save(figure, "g173")


def lowtran_thermal(folder):
    d = read(folder, "lowtran_thermal")
    figure, top, bottom = two_panels(
        "A-12  Thermal light with LOWTRAN7's bands and rules, midlatitude summer: LOWTRAN7 (grey) and raycube"
    )
    for key, colour, label in (("path", BLUE, "path, 3 km straight down"), ("sky", ORANGE, "sky at the zenith")):
        top.plot(d["um"], d[f"reference_{key}"], color="#bbbbbb", lw=2.6)
        top.plot(d["um"], d[key], color=colour, label=label)
        bottom.plot(d["um"], percent(d[key], d[f"reference_{key}"]), color=colour, lw=0.8)
    top.set_ylabel("radiance, W m$^{-2}$ sr$^{-1}$ um$^{-1}$")
    top.legend(loc="upper right")
    bottom.axhspan(-2, 2, color=BLUE, alpha=0.08, lw=0, label="bar: 2 % (and 1e-4 of Planck's law)")
    bottom.set(ylabel="raycube over LOWTRAN7 - 1, %", xlabel="wavelength, um", xlim=(2.5, 20), ylim=(-3, 3))
    bottom.legend(loc="lower right")
    save(figure, "lowtran_thermal")


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) == 2 else "build")
    if "RAYCUBE_SHARED" not in os.environ:
        sys.exit("atmosphere_charts.py: RAYCUBE_SHARED is not set; the reference figures are read there")
    with tempfile.TemporaryDirectory() as name:
        for test in TESTS:
            env = {**os.environ, "RAYCUBE_CHARTS": name, "RAYCUBE_FULL": "1"}
            subprocess.run([build / "tests" / f"test_anchor_{test}"], check=True, env=env)
        folder = pathlib.Path(name)
        for draw in (lowtran_thermal, modtran5_transmission, modtran5_thermal, modtran6, uvspec, g173):
            draw(folder)


if __name__ == "__main__":
    main()
