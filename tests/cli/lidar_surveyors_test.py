#!/usr/bin/env python3
"""What surveyors expect of LAS files: flight lines by number, ends of scan lines, classes of matter, coordinates of any
extent. Usage: lidar_surveyors_test.py RAYCUBE"""

import csv
import json
import math
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from driver import Program  # noqa: E402
from las_packets import Las  # noqa: E402

program = Program(sys.argv[1])
check = program.check

WORLD = """format = 1
seed = 3
material = [
  {{ name = "ground", reflectance = 0.3, las_class = 2 }},
  {{ name = "roof", reflectance = 0.5, las_class = 6 }},
  {{ name = "car", reflectance = 0.4 }},
]
plane = [
  {{ material = "ground", size_m = [{size}, {size}] }},
  {{ material = "roof", position_m = [40.0, 0.0, 8.0], size_m = [30.0, 60.0] }},
  {{ material = "car", position_m = [-40.0, 0.0, 2.0], size_m = [20.0, 60.0] }},
]
atmosphere = {{ model = "none" }}
{lidars}
"""
LIDAR = """[[lidar]]
name = "{name}"
{platform}
prf_khz = {prf}
{more}
[lidar.pulse]
energy_J = 100e-6
wavelength_nm = 1064.0
fwhm_ns = 4.0
divergence_mrad = 0.5
divergence_is = "full angle at 1/e^2"
[lidar.scan]
{scan}
[lidar.receiver]
aperture_diameter_m = 0.10
fov_mrad = 2.0
[lidar.gate]
start_range_m = 480.0
stop_range_m = 540.0
[lidar.sampling]
subrays = 4
air_return = false
[lidar.products]
cube = false
png = false
waveforms = false
"""
ABOVE = "position_m = [0.0, 0.0, 500.0]\nspeed_m_s = 50.0\npulses = 600"


def survey(folder, size, *lidars):
    file = folder / "survey.toml"
    file.write_text(WORLD.format(size=size, lidars="\n".join(LIDAR.format(**lidar) for lidar in lidars)))
    program.run("render", file, "-o", folder / "out", "--overwrite")
    return {lidar["name"]: folder / "out" / lidar["name"] for lidar in lidars}


def rows(folder, name):
    with open(folder / name) as file:
        return list(csv.DictReader(file))


def strips_classes_and_lines(work):
    """Three flight lines, one numbered by hand; matter's class, else 1; the last return of each line of the scan."""
    scans = {
        "first": 'pattern = "oscillating"\nrate_hz = 50.0\nhalf_angle_deg = 8.0',
        "second": 'pattern = "line"\nrate_hz = 100.0\nhalf_angle_deg = 8.0',
        "third": 'pattern = "fixed"',
    }
    runs = survey(
        work,
        400.0,
        *(
            dict(name=name, platform=ABOVE, prf=10.0, more="strip = 417" if name == "third" else "", scan=scan)
            for name, scan in scans.items()
        ),
    )
    for (name, folder), strip in zip(runs.items(), (1, 2, 417)):
        las, returns, pulses = Las(folder / "returns.las"), rows(folder, "returns.csv"), rows(folder, "pulses.csv")
        points = [las.point(i) for i in range(las.count)]
        check(las.source_id == strip and {p["point_source_id"] for p in points} == {strip}, name)
        wanted = {"ground": 2, "roof": 6, "car": 1}
        check(len(points) == len(returns) >= 550, name, len(points))
        for point, row in zip(points, returns):
            check(point["classification"] == wanted[row["material"]], row)
        check(len({p["classification"] for p in points}) == (1 if name == "third" else 3), name)
        # Lines by the mirror's phase: it turns at a quarter and three quarters of a cycle, or jumps back at the whole.
        angle = {int(p["pulse"]): float(p["scan_angle_deg"]) for p in pulses}
        cycles = {pulse: pulse / 10e3 * (50.0 if name == "first" else 100.0) for pulse in angle}
        line = {p: math.floor(2 * c + 0.5) if name == "first" else math.floor(c) for p, c in cycles.items()}
        ends = {a for a, b in zip(sorted(angle), sorted(angle)[1:]) if name != "third" and line[a] != line[b]}
        flagged = {int(row["pulse"]) for point, row in zip(points, returns) if point["flags"] >> 7}
        if name == "third":
            check(not flagged and not any(point["flags"] >> 6 & 1 for point in points))
            continue
        # Each end is flagged on the last pulse before or at it that has returns; and so is the last of all.
        with_returns = sorted({int(row["pulse"]) for row in returns})
        expected = {max(p for p in with_returns if p <= end) for end in ends} | {with_returns[-1]}
        check(flagged == expected and len(ends) >= 5, name, sorted(flagged ^ expected), len(ends))
        for point, row in zip(points, returns):
            at = int(row["pulse"])
            if at and at - 1 not in ends and at not in ends:
                rising = angle[at] > angle[at - 1]
                check(bool(point["flags"] >> 6 & 1) == rising, name, row)


def any_extent(work):
    """A flight line of 600 km: 0.1 mm steps end at 214 km, so that coordinates have 1 mm; known before tracing."""
    track = work / "track.csv"
    track.write_text("time_s,x_m,y_m,z_m\n0,-300000,0,500\n6000,300000,0,500\n")
    lidar = dict(
        name="long", platform='trajectory = "track.csv"\npulses = 600', prf=1e-4, more="", scan='pattern = "fixed"'
    )
    folder = survey(work, 700000.0, lidar)["long"]
    las, returns = Las(folder / "returns.las"), rows(folder, "returns.csv")
    check(list(las.scale) == [1e-3] * 3, las.scale)
    check(json.loads((folder / "run.json").read_text())["lidar"]["las_scale_m"] == 1e-3)
    check(las.count == len(returns) >= 590, las.count)
    for i, row in enumerate(returns):
        for got, key in zip(las.point(i)["xyz"], ("x_m", "y_m", "z_m")):
            check(abs(got - float(row[key])) <= 0.5e-3 + 1e-7, got, row[key])
    check(abs(las.point(0)["xyz"][0]) > 214e3, "it goes past what 0.1 mm hold")


def packed_points(work):
    """LAZ without a Python that can write it, and with waveforms inside: one error each, before the first pulse, and
    nothing written. (What LAZ holds: lidar_laspy_test.py.)"""
    file = work / "survey.toml"
    text = file.read_text()
    for more, status, wanted in (
        ("laz = true", 3, ("no laspy with lazrs (looked in /bin/false)", "RAYCUBE_PYTHON", "pip install laspy lazrs")),
        ("laz = true\nwaveforms = true\ninternal_waveforms = true", 2, ("survey.toml", "'laz'", "internal_waveforms")),
    ):
        kept = "" if "waveforms" in more else "\nwaveforms = false"
        file.write_text(text.replace("waveforms = false", more + kept))
        program.refused(
            "render", file, "-o", work / "none", status=status, says=wanted, env={"RAYCUBE_PYTHON": "/bin/false"}
        )
        check(not (work / "none").exists(), "something was written")
    # A Python that has both by its word, and compresses nothing: the run is whole all the same.
    python = work / "python"
    python.write_text('#!/bin/sh\n[ "$1 $2" = "-I -c" ]\n')
    python.chmod(0o755)
    for las in (True, False):
        products = "laz = true\nwaveforms = false" + ("" if las else "\nlas = false")
        file.write_text(text.replace("waveforms = false", products))
        done = program.run("render", file, "-o", work / f"kept{las}", env={"RAYCUBE_PYTHON": str(python)})
        check("no returns.laz: " in done.stderr, done.stderr)
        for folder in (work / f"kept{las}").iterdir():
            names = {path.name for path in folder.iterdir()}
            check("returns.las" in names and "returns.laz" not in names, names)
            check(not any(name.startswith(".") for name in names), names)
            check(Las(folder / "returns.las").count > 0)
            warnings = json.loads((folder / "run.json").read_text())["warnings"]
            check(any(warning.startswith("no returns.laz: ") for warning in warnings), warnings)


with tempfile.TemporaryDirectory() as name:
    work = pathlib.Path(name)
    strips_classes_and_lines(work)
    any_extent(work)
    packed_points(work)
print(f"lidar_surveyors: {program.checks} checks")
