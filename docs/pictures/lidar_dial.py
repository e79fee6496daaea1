#!/usr/bin/python3
"""DIAL over the pipeline: lidar_dial.py RAYCUBE OUTPUT_FOLDER [RESULTS_OF_PIPELINE_DIAL]

Renders scenes/lidar/pipeline_dial.toml unless its results are given, retrieves the methane column of every pulse from
the recorded counts, and draws it beside the truth; then columns of 1 to 10000 ppm m in a box, and what each cross
section makes of them.
"""

import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LOSCHMIDT = 2.479371580e15  # molecules / cm2 in 1 ppm m, 296 K
ON_NM, OFF_NM = 3300.330033, 3298.697015
WIDTH_NM = 0.02


def cross_section(wavelength_nm):
    """The scenes' Lorentz line: 2e-19 cm at 3030 cm-1, half width 0.06 cm-1; cm2."""
    return 2.0e-19 / math.pi * 0.06 / ((1e7 / wavelength_nm - 3030.0) ** 2 + 0.06**2)


def line(wavelength_nm, width_nm):
    z = numpy.linspace(-8, 8, 4001)
    weight = numpy.exp(-(z**2) / 2)
    return cross_section(wavelength_nm + width_nm * 0.42466090014400953 * z), weight / weight.sum()


def transmission(column, wavelength_nm, width_nm):
    cross, weight = line(wavelength_nm, width_nm)
    return (weight * numpy.exp(-2 * numpy.asarray(column)[..., None] * LOSCHMIDT * cross)).sum(-1)


def rows_of(folder):
    with open(folder / "pulses.csv", newline="") as file:
        return list(csv.DictReader(file))


def column_of(rows, what):
    return numpy.array([float(row[what]) for row in rows])


def retrieve(ratio, width_nm):
    grid = numpy.concatenate([[0], numpy.geomspace(0.01, 2e4, 4000)])
    curve = transmission(grid, ON_NM, width_nm) / transmission(grid, OFF_NM, width_nm)
    return numpy.interp(-numpy.log(ratio), -numpy.log(curve), grid)


def plume(points):
    """Mixing ratio of the scene's leak, ppm."""
    towards = math.radians(70)
    x = points[..., 0] * math.sin(towards) + points[..., 1] * math.cos(towards)
    y = points[..., 0] * math.cos(towards) - points[..., 1] * math.sin(towards)
    inside = (x > 0) & (x < 150)
    x = numpy.where(inside, x, 1.0)
    sy, sz = 0.08 * x / numpy.sqrt(1 + 1e-4 * x), 0.06 * x / numpy.sqrt(1 + 1.5e-3 * x)
    z = points[..., 2]
    gram = (
        2
        / (2 * math.pi * 2.5 * sy * sz)
        * numpy.exp(-(y**2) / (2 * sy**2))
        * (numpy.exp(-((z - 0.8) ** 2) / (2 * sz**2)) + numpy.exp(-((z + 0.8) ** 2) / (2 * sz**2)))
    )
    return numpy.where(inside, gram, 0) / 16.0425 * 6.02214076e23 * 1e-6 / 2.479371580e19 * 1e6


def survey(folder):
    rows = rows_of(folder)
    on, off = rows[::2], rows[1::2]
    exits = numpy.stack([column_of(on, f"exit_{i}_m") for i in "xyz"], -1)
    axis = numpy.stack([column_of(on, f"axis_{i}") for i in "xyz"], -1)
    length = -exits[:, 2] / axis[:, 2]
    truth = numpy.zeros(len(on))
    for first in range(0, len(on), 200):
        part = slice(first, first + 200)
        steps = (numpy.arange(4000) + 0.5) / 4000 * length[part, None]
        truth[part] = plume(exits[part, None] + steps[..., None] * axis[part, None]).mean(1) * length[part]
    ratio = (
        column_of(on, "recorded_pe")
        / column_of(on, "photons_emitted")
        / column_of(off, "recorded_pe")
        * column_of(off, "photons_emitted")
    )
    found = retrieve(ratio, WIDTH_NM) - 1.9 * length
    spot = exits + length[:, None] * axis
    return spot, truth, found


BOX = """format = 1
[[material]]
name = "ground"
reflectance = 0.12
[[plane]]
material = "ground"
size_m = [100.0, 100.0]
[[volume]]
name = "cell"
shape = "box"
gas = "CH4"
position_m = [0.0, 0.0, 10.0]
size_m = [50.0, 50.0, 10.0]
concentration_ppm = {ppm}
line = {{ strength_cm = 2.0e-19, half_width_per_cm = 0.06, center_per_cm = 3030.0 }}
[atmosphere]
model = "none"
[time]
sun = {{ zenith_deg = 100.0 }}
[thermal]
default_temperature_K = 300.0
[[lidar]]
name = "dial"
position_m = [0.0, 0.0, 150.0]
prf_khz = 1.0
pulses = 1
[lidar.pulse]
divergence_mrad = 0.1
divergence_is = "full angle at 1/e^2"
fwhm_ns = 10.0
[[lidar.pulse.line]]
name = "on"
wavelength_nm = 3300.330033
fwhm_nm = {width}
energy_J = 1e-3
[[lidar.pulse.line]]
name = "off"
wavelength_nm = 3298.697015
fwhm_nm = {width}
energy_J = 1e-3
[lidar.receiver]
aperture_diameter_m = 0.2
fov_mrad = 2.0
[lidar.gate]
start_range_m = 120.0
stop_range_m = 180.0
bin_ns = 5.0
[lidar.sampling]
subrays = 16
line_nodes = 64
air_return = false
[lidar.products]
las = false
png = false
csv = true
"""


def bias(raycube, work, width_nm):
    columns = numpy.geomspace(1, 1e4, 17)
    ratios = []
    for column in columns:
        scene = work / "box.toml"
        scene.write_text(BOX.format(ppm=repr(float(column / 10)), width=repr(width_nm)))
        subprocess.run(
            [raycube, "render", scene, "-o", work / "box", "--overwrite", "-q"], check=True, stdout=subprocess.DEVNULL
        )
        on, off = (float(row["photons_in_gate"]) / float(row["photons_emitted"]) for row in rows_of(work / "box/dial"))
        ratios.append(on / off)
    return columns, numpy.array(ratios)


def main():
    raycube, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        results = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else work / "dial"
        if len(sys.argv) <= 3:
            subprocess.run(
                [raycube, "render", ROOT / "scenes/lidar/pipeline_dial.toml", "-o", results],
                check=True,
                stdout=subprocess.DEVNULL,
            )
        spot, truth, found = survey(results / "dial")
        figure, axes = plt.subplots(1, 3, figsize=(16, 5.2), layout="constrained")
        shown = axes[0].scatter(
            spot[:, 0],
            spot[:, 1],
            c=numpy.clip(found, 1, None),
            s=5,
            cmap="inferno",
            norm=matplotlib.colors.LogNorm(1, 400),
        )
        figure.colorbar(shown, ax=axes[0], label="retrieved above the ambient 1.9 ppm, ppm m")
        axes[0].set(title="pipeline_dial: every pulse's own column", xlabel="x, m", ylabel="y, m", aspect="equal")
        axes[1].plot([-20, 500], [-20, 500], color="gray", lw=1)
        axes[1].plot(truth, found, ".", ms=3)
        axes[1].set(
            title="against the plume's closed form",
            xlabel="true column of the leak, ppm m",
            ylabel="retrieved, ppm m",
            xscale="symlog",
            yscale="symlog",
        )
        for width, colour in ((1e-6, "tab:gray"), (0.0545, "tab:blue"), (0.1089, "tab:red")):  # 0, 0.05, 0.10 cm-1
            columns, ratio = bias(raycube, work, width)
            depth = 2 * columns * LOSCHMIDT * cross_section(ON_NM)
            cross, weight = line(ON_NM, width)
            mean = (cross * weight).sum() - (line(OFF_NM, width)[0] * line(OFF_NM, width)[1]).sum()
            peak = cross_section(ON_NM) - cross_section(OFF_NM)
            label = f"{width * 1e7 / ON_NM**2:.2f} cm-1"
            with numpy.errstate(divide="ignore"):
                for section, style, what in ((peak, "-", "peak cross section"), (mean, "--", "line's mean")):
                    thin = -numpy.log(ratio) / (2 * LOSCHMIDT * section * columns)
                    axes[2].plot(depth, thin, style, color=colour, label=f"{label}, {what}")
            exact = retrieve(ratio, width) / columns
            axes[2].plot(depth, exact, "o", mfc="none", ms=4, color=colour, label=f"{label}, exact curve")
            print(
                label,
                "peak",
                numpy.interp([1, 1000], columns, -numpy.log(ratio) / (2 * LOSCHMIDT * peak * columns)),
                "1000 ppm m exact",
                numpy.interp(1000, columns, exact),
            )
        axes[2].set(
            title="bias of a column in a box",
            xlabel="two-way optical depth at the line's centre",
            ylabel="retrieved / true column",
            xscale="log",
            ylim=(0, 1.1),
        )
        axes[2].legend(fontsize=7)
        for axis in axes[1:]:
            axis.grid(alpha=0.3)
        figure.savefig(out / "lidar_dial.png", dpi=100)
    print(
        f"leak up to {truth.max():.0f} ppm m; median of retrieved - true over pulses below 5 ppm m: "
        f"{numpy.median((found - truth)[truth < 5]):.2f}"
    )


if __name__ == "__main__":
    main()
