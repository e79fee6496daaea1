"""raycube atmos lidar, and a table with lines, as a user drives them. Usage: lidar_cli_test.py RAYCUBE FOLDER"""

import functools
import json
import math
import pathlib
import shutil
import sys

from driver import Program

program, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2])
run = functools.partial(program.run, "atmos")
shutil.rmtree(folder, ignore_errors=True)
folder.mkdir(parents=True)


def rows_of(table):
    return {row["name"]: row for row in json.loads(run("info", table, "--json").stdout)["rows"]}


# AIR 9: 532 nm at the ground of the US standard atmosphere: 0.01316 km-1 and 1.549e-3 km-1 sr-1.
table = folder / "lidar.rct"
done = run("lidar", "--wavelengths", "1064,532", "-o", table)
assert done.stdout.startswith(f"table: {table}\n") and "absorption by gases is absent" in done.stderr
assert "aerosol: optical depth" in done.stdout.splitlines()[1], done.stdout
ground = done.stdout.splitlines()[3].split()
assert math.isclose(float(ground[0]), 532) and math.isclose(float(ground[1]), 0.01316, rel_tol=2e-3), ground
assert ground[3] == "absent" and math.isclose(float(ground[4]), 1.549e-3, rel_tol=2e-3), ground
assert "lidar_extinction_gas" not in rows_of(table) and "lidar_depolarization" in rows_of(table)

# A list of one invented methane line: absorption on the line, and a table of sun and sky on a fine grid.
line = " 61 3057.687000 2.000E-19 1.000E+00.05800.078  104.77000.75-.006000"
(folder / "one.par").write_text(line.ljust(160) + "\r\n")
dial = folder / "dial.rct"
done = run(
    "lidar",
    "--wavelengths",
    f"{1e7 / 3058.4:.5f}",
    "--wavelengths",
    f"{1e7 / 3057.687:.5f}",
    "--lines",
    folder / "one.par",
    "--lidar-ratio",
    "rural=55",
    "--cabannes",
    "-o",
    dial,
)
off, on = (float(text.split()[3]) for text in done.stdout.splitlines()[3:5])
assert on > 10 * off > 0 and "holds no lines of h2o" in done.stderr
info = json.loads(run("info", dial, "--json").stdout)
assert info["provenance"]["parameters"]["cabannes_only"]
assert all(math.isclose(ratio, 55) for ratio in info["provenance"]["parameters"]["lidar_ratio_sr"]["rural"])
fine = folder / "fine.rct"
run(
    "build",
    "--model",
    "layered",
    "--sun-zenith",
    "40",
    "--aerosol",
    "none",
    "--from",
    3.2703,
    "--to",
    3.2705,
    "--step",
    0.02,
    "--highest",
    0,
    "--lines",
    folder / "one.par",
    "--no-cache",
    "-o",
    fine,
)
assert rows_of(fine)["sun_optical_depth"]["most"] > 3 * rows_of(fine)["sun_optical_depth"]["least"]

# The same from a scene file.
(folder / "air.toml").write_text("""format = 1
[atmosphere]
model = "layered"
lines = "one.par"
[[atmosphere.cross_section]]
gas = "ethane"
file = "ethane.csv"
mixing_ratio_ppmv = 0.001
""")
(folder / "ethane.csv").write_text(
    "wavenumber_per_cm,pressure_hPa,temperature_K,cross_section_cm2\n"
    "3050,1013.25,296,1e-19\n3060,1013.25,296,1e-19\n"
)
done = run("lidar", folder / "air.toml", "--wavelengths", f"{1e7 / 3058.4:.5f}", "-o", folder / "scene.rct")
ethane = 1e-9 * 2.55e19 * 1e-19 * 1e5
assert math.isclose(float(done.stdout.splitlines()[3].split()[3]) - off, ethane, rel_tol=0.05)

run("plot", dial, "-o", folder / "dial.png")
assert (folder / "dial.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
figures = json.loads((folder / "dial.json").read_text())
assert len(figures["rows"]["extinction_gas"]) == 2 and len(figures["rows"]["extinction_gas"][0]) == len(
    figures["height_m"]
)

# Bad input: status 2 and a message that says what is wrong.
assert "which wavelengths" in run("lidar", "-o", folder / "x.rct", status=2).stderr
assert "'abc' is no number" in run("lidar", "--wavelengths", "abc", "-o", folder / "x.rct", status=2).stderr
assert (
    "NAME=VALUE" in run("lidar", "--wavelengths", 532, "--lidar-ratio", "55", "-o", folder / "x.rct", status=2).stderr
)
assert (
    "no such component"
    in run("lidar", "--wavelengths", 532, "--lidar-ratio", "dust=55", "-o", folder / "x.rct", status=2).stderr
)
assert (
    "the profile carries no 'ethane'"
    in run(
        "lidar",
        "--wavelengths",
        3270,
        "--cross-section",
        f"ethane={folder / 'ethane.csv'}",
        "-o",
        folder / "x.rct",
        status=2,
    ).stderr
)
(folder / "short.par").write_text(line + "\n")
assert (
    "short.par:1: a record has 160 characters"
    in run("lidar", "--wavelengths", 3270, "--lines", folder / "short.par", "-o", folder / "x.rct", status=2).stderr
)
assert (
    "cannot be read"
    in run("lidar", "--wavelengths", 3270, "--lines", folder / "none.par", "-o", folder / "x.rct", status=3).stderr
)
assert not (folder / "x.rct").exists()
print("lidar: ground values, a methane line, scene file, bad input")
