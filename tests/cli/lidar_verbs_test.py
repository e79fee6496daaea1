#!/usr/bin/python3
"""raycube lidar gff and dial as users run them: lidar_verbs_test.py RAYCUBE SCENES

gff against the specification's overlap table (L-03); dial on a run without air over a plane: columns around the closed
form of a box of gas, with errors that describe their spread.
"""

import csv
import json
import pathlib
import sys
import tempfile

from driver import Program

KEYS = ("level1_uniform", "level1_gaussian", "level2")
L03 = {
    400: (0.231326, 0.152787, 0.002628),
    450: (1, 0.999934, 0.317491),
    500: (1, 1, 0.798252),
    550: (1, 0.999939, 0.442462),
    600: (0.647398, 0.720684, 0.064448),
}

DIAL = """
format = 1
seed = 5
[[material]]
name = "soil"
reflectance = 0.2
source = "constant"
[[plane]]
name = "ground"
material = "soil"
size_m = [400.0, 400.0]
[[volume]]
name = "cloud"
shape = "box"
gas = "CH4"
position_m = [0.0, 0.0, 10.0]
size_m = [300.0, 300.0, 20.0]
concentration_ppm = 10.0
line = { strength_cm = 2.0e-19, half_width_per_cm = 0.06, center_per_cm = 3030.0 }
[atmosphere]
model = "none"
[[lidar]]
name = "dial"
position_m = [0.0, 0.0, 150.0]
prf_khz = 1.0
pulses = 400
products = { png = false, las = false }
[lidar.pulse]
divergence_mrad = 1.0
divergence_is = "full angle at 1/e^2"
fwhm_ns = 10.0
[[lidar.pulse.line]]
name = "on"
wavelength_nm = 3300.330033
fwhm_nm = 0.1
energy_J = 2e-4
[[lidar.pulse.line]]
name = "off"
wavelength_nm = 3298.697015
fwhm_nm = 0.02
energy_J = 1e-4
[lidar.receiver]
aperture_diameter_m = 0.20
fov_mrad = 2.0
quantum_efficiency = 0.3
filter_fwhm_nm = 10.0
[lidar.gate]
start_range_m = 120.0
stop_range_m = 180.0
bin_ns = 5.0
[lidar.sampling]
subrays = 16
[lidar.detector]
mode = "photons"
dark_rate_hz = 1e6
"""


def rows_of(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def gff(program, folder, scenes):
    chart = folder / "gff.png"
    done = program.run("lidar", "gff", "-o", chart, "--from", 400, "--to", 600, "--points", 5, "--json")
    said = json.loads(done.stdout)
    program.check(said["overlap_at_surface"] < 1e-40, said)
    program.check(abs(said["overlap_at_plume"]["plume"] - 0.798252) < 1e-6, said)
    for row in rows_of(folder / "gff.csv"):
        for key, expected in zip(KEYS, L03[int(float(row["range_m"]))]):
            program.check(abs(float(row[key]) - expected) < 1e-6, row, key)
    program.check(chart.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n", "PNG")
    # L-05: parallel axes.
    program.run(
        "lidar",
        "gff",
        "-o",
        folder / "b.png",
        "--separation",
        0.2,
        "--crossing",
        0,
        "--fov",
        1,
        "--divergence",
        0.5,
        "--from",
        200,
        "--to",
        400,
        "--points",
        3,
    )
    for row, expected in zip(rows_of(folder / "b.csv"), (0.020682, 0.174870, 0.427208)):
        program.check(abs(float(row["level2"]) - expected) < 1e-6, row)
    coaxial = json.loads(
        program.run("lidar", "gff", scenes / "lidar/pipeline_dial.toml", "-o", folder / "p.png", "--json").stdout
    )
    program.check(0.9 < coaxial["overlap_at_plume"]["leak"] < 1 and 0.9 < coaxial["overlap_at_surface"] < 1, coaxial)
    program.refused("lidar", "gff", "-o", chart, status=2, says=["gff"])
    program.refused("lidar", "gff", "--obscuration", 0.3, "-o", folder / "x.png", status=2, says=["obscuration", "0.3"])
    program.refused("lidar", "gff", "--from", 10, "--to", 5, "-o", folder / "x.png", status=2, says=["--from", "10"])
    program.refused("lidar", "gff", "--lidar", "me", "-o", folder / "x.png", status=2, says=["FILE"])
    program.refused(
        "lidar",
        "gff",
        scenes / "lidar/pipeline_dial.toml",
        "--lidar",
        "me",
        "-o",
        folder / "x.png",
        status=2,
        says=["me", "dial"],
    )


def dial(program, folder):
    scene = folder / "box.toml"
    scene.write_text(DIAL)
    program.run("render", scene, "-o", folder / "run")
    run = folder / "run" / "dial"
    said = json.loads(program.run("lidar", "dial", run, "--json").stdout)
    rows = rows_of(run / "columns.csv")
    program.check(said["good"] == 400 and len(rows) == 400, said)
    # 10 ppm over 20 m, seen straight down.
    for row in rows:
        program.check(abs(float(row["expected_ppm_m"]) - 200) < 0.2, row)
        program.check(abs(float(row["z_m"])) < 0.5 and row["state"] == "good", row)
    z = [(float(row["column_ppm_m"]) - 200) / float(row["error_ppm_m"]) for row in rows]
    mean, square = sum(z) / 400, sum(v * v for v in z) / 400
    program.check(abs(mean) < 4 / 20 and abs(square - 1) < 4 * (2 / 400) ** 0.5, mean, square)
    # The mean cross section alone reads low: the line is as wide as the gas' own.
    thin = sum(float(row["column_thin_ppm_m"]) for row in rows) / 400
    program.check(0.96 * 200 < thin < 0.98 * 200, thin)
    averaged = json.loads(
        program.run("lidar", "dial", run, scene, "--average", 100, "-o", folder / "mean.png", "--json").stdout
    )
    means = rows_of(folder / "mean.csv")
    program.check(averaged["good"] == 4 and all(row["averaged"] == "100" for row in means), averaged)
    program.check(all(abs(float(m["error_ppm_m"]) / float(rows[0]["error_ppm_m"]) - 0.1) < 0.01 for m in means), means)
    program.refused("lidar", "dial", run, status=2, says=["columns"])
    program.refused("lidar", "dial", folder, status=2, says=["run.json"])
    other = folder / "other.toml"
    other.write_text(DIAL.replace("bin_ns = 5.0", "bin_ns = 2.0"))
    program.refused("lidar", "dial", run, other, "-o", folder / "y.png", status=2, says=["bins", "gate"])
    other.write_text(
        DIAL.replace('gas = "CH4"\n', 'gas = "CH4"\nyaw_deg = 0.0\n', 1).replace('name = "dial"', 'name = "lidar"')
    )
    program.refused("lidar", "dial", run, other, "--lidar", "dial", "-o", folder / "y.png", status=2, says=["dial"])


def main():
    program = Program(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        gff(program, pathlib.Path(name), pathlib.Path(sys.argv[2]))
        dial(program, pathlib.Path(name))
    print(f"{program.checks} checks")


main()
