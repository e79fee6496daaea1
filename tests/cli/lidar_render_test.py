#!/usr/bin/env python3
"""The shipped LIDAR scenes as users render them, with fewer pulses: ledgers closed, files that agree, the same bits
however they were made, and the methane column of the pipeline survey retrieved from its own counts.
usage: lidar_render_test.py RAYCUBE SCENES PARK [--full], PARK a folder that scenes/park/generate.py wrote
Without --full: the park is rendered once, in many tiles, and the bits of one thread and of many tiles are those of the
pipeline survey and of the Geiger array; one of the shipped scenes has its pictures drawn, 3.5 s each."""

import csv
import json
import math
import pathlib
import re
import shutil
import sys
import tempfile

import numpy
from driver import FULL, GROUND, PULSE_AND_RECEIVER, Program, envi, gate

program = Program(sys.argv[1])
run, check = program.run, program.check
scenes = pathlib.Path(sys.argv[2]).resolve()


park = pathlib.Path(sys.argv[3]).resolve()
ONE_THREAD, MANY_TILES = ["--threads", "1"], ["--threads", "2", "--memory", "64M"]


def fewer(source, target, pulses, drawn=False):
    """The scene with so many pulses, beside the files it names; its pictures drawn or not."""
    text, changed = re.subn(r"(?m)^pulses = \d+", f"pulses = {pulses}", source.read_text())
    assert changed == 1, source
    if not drawn:
        head = "[lidar.products]\n"
        text = text if head in text else f"{text}\n{head}"
        text = text.replace(head, head + "png = false\n")
    target.write_text(text)
    return target


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def closed(folder, pulses, lines):
    """S36, the energy ledger: received + absorbed + escaped + out of gate = emitted, within 1e-6 (it is kept in
    integers)."""
    rows = table(folder / "pulses.csv")
    check(len(rows) == pulses * lines, len(rows))
    for row in rows:
        parts = {name: float(row[name]) for name in ("absorbed", "air", "volumes", "escaped", "truncated")}
        check(abs(sum(parts.values()) - 1) < 1e-6 and all(value >= 0 for value in parts.values()), row)
        out_of_gate = sum(float(row[name]) for name in ("early", "late", "near"))
        check(float(row["collected"]) >= out_of_gate >= 0, row)
    record = json.loads((folder / "run.json").read_text())
    check(record["survey"]["worst_ledger_error"] < 1e-6, record["survey"])
    return rows, record


def digest(scene, out, *options):
    run("render", scene, "-o", out, "--overwrite", *options)
    (folder,) = pathlib.Path(out).iterdir()
    return json.loads((folder / "run.json").read_text())["digest"]


def same_bits(scene, out):
    """Rendered by one thread, then in many tiles."""
    bits = {digest(scene, out, *options) for options in (ONE_THREAD, MANY_TILES)}
    check(len(bits) == 1, bits)


def briggs_plume_ppm(points):
    """Mixing ratio of the shipped leak, after the formula in docs/lidar.md: 2 g/s, 2.5 m/s towards 70 degrees, 0.8 m
    up, class D."""
    towards = math.radians(70)
    x = points[:, 0] * math.sin(towards) + points[:, 1] * math.cos(towards)
    y = points[:, 0] * math.cos(towards) - points[:, 1] * math.sin(towards)
    inside = (x > 0) & (x < 150)
    x = numpy.where(inside, x, 1.0)
    sy, sz = 0.08 * x / numpy.sqrt(1 + 1e-4 * x), 0.06 * x / numpy.sqrt(1 + 1.5e-3 * x)
    z = points[:, 2]
    gram_m3 = (
        2
        / (2 * math.pi * 2.5 * sy * sz)
        * numpy.exp(-(y**2) / (2 * sy**2))
        * (numpy.exp(-((z - 0.8) ** 2) / (2 * sz**2)) + numpy.exp(-((z + 0.8) ** 2) / (2 * sz**2)))
    )
    per_cm3 = numpy.where(inside, gram_m3, 0) / 16.0425 * 6.02214076e23 * 1e-6
    return per_cm3 / 2.479371580e19 * 1e6


def line_transmission(columns_ppm_m, wavelength_nm):
    """Two ways through columns for a Gaussian laser line of 0.02 nm on the shipped Lorentz line, the line averaged
    after the exponential."""
    z = numpy.linspace(-8, 8, 2001)
    weight = numpy.exp(-(z**2) / 2)
    wavenumber = 1e7 / (wavelength_nm + 0.02 * 0.42466090014400953 * z)
    cross = 2.0e-19 / math.pi * 0.06 / ((wavenumber - 3030.0) ** 2 + 0.06**2)
    columns = numpy.atleast_1d(columns_ppm_m)
    return numpy.exp(-2 * 2.479371580e15 * columns[:, None] * cross) @ weight / weight.sum()


ON_NM, OFF_NM = 3300.330033, 3298.697015


def columns_from(ratios):
    """Columns whose on over off transmissions are `ratios`: bisection on the exact curve, so that no cross section has
    to be averaged."""
    low, high = numpy.zeros(len(ratios)), numpy.full(len(ratios), 5000.0)
    for _ in range(30):  # to 5 millionths
        middle = 0.5 * (low + high)
        more = line_transmission(middle, ON_NM) / line_transmission(middle, OFF_NM) > ratios
        low, high = numpy.where(more, middle, low), numpy.where(more, high, middle)
    return 0.5 * (low + high)


def dial(work):
    """S33: the column retrieved from the counts of both lines lies within its own sigma of the truth."""
    scene = fewer(scenes / "lidar/pipeline_dial.toml", work / "pipeline_dial.toml", 240)
    same_bits(scene, work / "dial")
    rows, _ = closed(work / "dial/dial", 240, 2)
    dry = json.loads(run("render", scene, "--dry-run", "--json").stdout)["instruments"][0]
    check(dry["pulses"] == 240 and dry["rays"] == 240 * 64, dry)
    ground = {row["pulse"] for row in table(work / "dial/dial/returns.csv") if row["material"] == "steel"}
    truths, ratios, variances, plume = [], [], [], []
    for on, off in zip(rows[::2], rows[1::2]):
        check(on["line"] == "on" and off["line"] == "off" and on["pulse"] == off["pulse"])
        if on["pulse"] in ground:
            continue  # the pipeline stands in the beam: two heights
        exit_m, axis = (
            (
                numpy.array([float(on[f"{name}_{i}"]) for i in ("x", "y", "z")])
                if name == "axis"
                else numpy.array([float(on[f"exit_{i}_m"]) for i in ("x", "y", "z")])
            )
            for name in ("exit", "axis")
        )
        length = -exit_m[2] / axis[2]
        steps = (numpy.arange(4000) + 0.5) / 4000 * length  # of 4 cm: the leak is 20 cm wide and more
        leak = briggs_plume_ppm(exit_m + steps[:, None] * axis).mean() * length
        truths.append(1.9 * length + leak)
        counts = [float(row["recorded_pe"]) / float(row["photons_emitted"]) for row in (on, off)]
        ratios.append(counts[0] / counts[1])
        variances.append(sum(1 / float(row["recorded_pe"]) + 1 / float(row["speckle_modes"]) for row in (on, off)))
        plume.append(leak)
    truth = numpy.array(truths)
    depth = lambda column: numpy.log(line_transmission(column, OFF_NM) / line_transmission(column, ON_NM))
    slope = depth(truth) - depth(truth - 1)
    deviations = (columns_from(numpy.array(ratios)) - truth) / (numpy.sqrt(variances) / slope)
    print(
        f"DIAL: {len(deviations)} pulses over bare ground, leak up to {max(plume):.0f} ppm m; deviation / sigma: mean "
        f"{deviations.mean():.2f}, "
        f"rms {math.sqrt((deviations**2).mean()):.2f}, within one sigma {(abs(deviations) < 1).mean():.2f}"
    )
    count = len(deviations)
    check(count > 150 and max(plume) > 10, count)
    program.within(deviations.mean(), 4 / math.sqrt(count), "mean")
    program.within(math.sqrt((deviations**2).mean()) - 1, 4 / math.sqrt(2 * count), "rms")
    inside = (abs(deviations) < 1).mean()
    program.between(0.6827 - 4 * math.sqrt(0.6827 * 0.3173 / count), inside, 1.0, "within one sigma")


def geiger(work):
    same_bits(fewer(scenes / "lidar/geiger_array.toml", work / "geiger_array.toml", 2), work / "geiger")
    closed(work / "geiger/flash", 2, 1)
    tags = table(work / "geiger/flash/photons.csv")
    firsts = {(row["pulse"], row["pixel"]) for row in tags}
    check(
        len(firsts) == len(tags) and 1000 < len(tags) <= 2 * 4096, len(tags)
    )  # dead for the rest of the gate: one event a pixel and shot


def survey(work):
    shutil.copytree(park, work / "park")
    scene = fewer(work / "park/park_survey.toml", work / "park/few.toml", 200, drawn=True)
    if FULL:
        same_bits(scene, work / "survey")
    else:
        digest(scene, work / "survey", *MANY_TILES)
    pictures = [path.read_bytes() for path in (work / "survey/survey").glob("*.png")]
    check(len(pictures) >= 3 and all(data.startswith(b"\x89PNG") for data in pictures), len(pictures))
    rows, record = closed(work / "survey/survey", 200, 1)
    returns = table(work / "survey/survey/returns.csv")
    check(len(returns) == record["survey"]["echoes"] >= 195, len(returns))
    exact = [
        float(row["range_m"]) - float(row["range_true_m"])
        for row in returns
        if row["order"] == "1" and row["of"] == "1"
    ]
    # Photon-limited precision of such returns is millimetres; leaves in the footprint spread some.
    check(
        len(exact) > 50 and abs(numpy.median(exact)) < 0.01 and numpy.percentile(numpy.abs(exact), 68) < 0.05,
        numpy.percentile(exact, [5, 50, 95]),
    )


FOLDED = (
    "format = 1\n"
    + GROUND.replace('"ground"\n', '"ground"\nlas_class = 2\n', 1)
    + """[atmosphere]
model = "none"
[time]
sun = {{ zenith_deg = 100.0 }}
[[lidar]]
name = "scan"
position_m = [0.0, 0.0, {height}]
prf_khz = 200.0
pulses = 6
fold_ambiguous = {fold}
"""
    + PULSE_AND_RECEIVER
    + gate("{start}", "{stop}")
    + """[lidar.products]
png = false
"""
)


def photons(work, **values):
    scene = work / "folded.toml"
    scene.write_text(FOLDED.format(**values))
    run("render", scene, "-o", work / "folded", "--overwrite")
    rows = table(work / "folded/scan/pulses.csv")
    for row in rows:  # what reached the detector is in the gate or beside it
        parts = float(row["photons_in_gate"]) / float(row["photons_emitted"]) + sum(
            float(row[name]) for name in ("early", "late", "near")
        )
        check(abs(parts - float(row["collected"])) <= 1e-5 * max(float(row["collected"]), 1e-30), row)
    return [float(row["photons_in_gate"]) for row in rows]


def folding(work):
    """LIDAR 2.4: ambiguous ranges. 200 kHz: 749.48 m between pulses; ground at 1000 m comes into the next pulse's gate
    at 250.5 m; and a gate from 900 m on, opened while two pulses fly, sees ground at 250.5 m by the pulse after."""
    alone = photons(work, height=1000.0, fold="false", start=950.0, stop=1050.0)
    check(min(alone) == max(alone) > 1e3, alone)
    near = photons(work, height=1000.0, fold="false", start=200.0, stop=300.0)
    check(max(near) == 0, near)
    folded = photons(work, height=1000.0, fold="true", start=200.0, stop=300.0)
    check(folded[0] == 0 and all(abs(value / alone[0] - 1) < 1e-5 for value in folded[1:]), folded, alone)
    behind_returns(work, pulses_back=1, range_m=250.5, range_true_m=1000.0, pulses=range(1, 6))
    close = photons(work, height=250.5, fold="false", start=200.0, stop=300.0)
    behind_returns(work, pulses_back=0, range_m=250.5, range_true_m=250.5, pulses=range(6))
    later = photons(work, height=250.5, fold="true", start=950.0, stop=1050.0)
    check(later[-1] == 0 and all(abs(value / close[0] - 1) < 1e-5 for value in later[:-1]), later, close)
    behind_returns(work, pulses_back=-1, range_m=1000.0, range_true_m=250.5, pulses=range(5))
    slope = (work / "folded.toml").read_text().replace("250.5]", "1000.0]")
    slope = slope.replace("start_range_m = 950.0\nstop_range_m = 1050.0", "start_range_m = 200.0\nstop_range_m = 300.0")
    slope = slope.replace("divergence_mrad = 0.2", "divergence_mrad = 2.0").replace("pulses = 6", "pulses = 40")
    slope = slope.replace("fov_mrad = 2.0", "fov_mrad = 10.0").replace("subrays = 16", "subrays = 64")
    (work / "slope.toml").write_text(slope.replace("[200.0, 200.0]", "[200.0, 200.0]\ntilt_deg = 45.0"))
    done = run("render", work / "slope.toml", "-o", work / "slope")
    # The error of its waveforms is that of the pulses whose light it is: a plane is one return, folded or not.
    check("error of the waveforms about" in done.stderr, done.stderr)
    check(len(table(work / "slope/scan/returns.csv")) == 39, "returns of a folded slope")


def behind_returns(work, pulses_back, range_m, range_true_m, pulses):
    """What returns.csv says of the surface: of the pulse whose light it is. Footprint and noise move ranges by cm."""
    rows = table(work / "folded/scan/returns.csv")
    check([int(row["pulse"]) for row in rows] == list(pulses), rows)
    for row in rows:
        check(int(row["pulses_back"]) == pulses_back and int(row["order"]) == 1, row)
        check(row["material"] != "" and int(row["las_class"]) == 2, row)
        check(abs(float(row["range_m"]) - range_m) < 0.1 and abs(float(row["range_true_m"]) - range_true_m) < 0.1, row)
        check(abs(float(row["expected_pe"]) / float(row["energy_pe"]) - 1) < 0.05, row)


def upwards(work):
    """Air above the scene: a LIDAR that looks up from the ground is not dark past its own height."""
    scene = work / "up.toml"
    scene.write_text(
        FOLDED.format(height=2.0, fold="false", start=100.0, stop=5000.0)
        .replace('model = "none"', 'model = "layered"')
        .replace("prf_khz = 200.0", "prf_khz = 1.0\nlook_at_m = [0.0, 1.0, 9000.0]")
        .replace("pulses = 6", "pulses = 1")
    )
    run("render", scene, "-o", work / "up", "--overwrite")
    header, cube = envi(work / "up/scan", "waveforms")
    bin_m = 0.149896229
    row = cube[0, :, [text.split("[")[0].strip() for text in header["band names"]].index("laser expected")]
    early, late = row[:2000].sum(), row[int(2000 / bin_m) : int(2300 / bin_m)].sum()
    check(early > 0 and late > 1e-4 * early, early, late)


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    folding(folder)
    upwards(folder)
    dial(folder)
    geiger(folder)
    survey(folder)
print("lidar_render: all well")
