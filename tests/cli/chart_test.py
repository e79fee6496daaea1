"""S62 S64: `raycube chart` as users run it, on a tiny scene: figures, files, cache, refusals. Counts are compared,
never wall times. usage: chart_test.py RAYCUBE FOLDER [--full]
Without --full: not what stating the tolerance that is usual changes (nothing), and no chart again as text."""

import csv
import json
import pathlib
import shutil
import sys

from driver import FULL, Program, own_cache

program = Program(sys.argv[1])
run, check = program.run, program.check
folder = pathlib.Path(sys.argv[2])
shutil.rmtree(folder, ignore_errors=True)
folder.mkdir(parents=True)
# References are kept here; compiled kernels where they always are.
env = {"XDG_CACHE_HOME": own_cache(folder)}

SCENE = """format = 1
bounces = 0
sky_directions = 4
material = [{ name = "dark", reflectance = 0.05 }, { name = "light", reflectance = 0.6 }]
plane = [{ size_m = [200.0, 200.0], checker = { materials = ["dark", "light"], cell_m = 1.3 } }]
box = [{ material = "light", position_m = [1.0, 2.0, 0.0], size_m = [4.0, 5.0, 6.0], yaw_deg = 20.0 }]
atmosphere = { model = "AIR" }
time = { sun = { zenith_deg = 40.0, azimuth_deg = 150.0 } }
"""
CAMERA = """[[instrument]]
name = "camera"
kind = "framing"
altitude_agl_m = 200.0
gsd_m = 1.0
pixels = 16
lines = 16
samples = { grid = [3, 3] }
bands = { first_nm = 500.0, step_nm = 100.0, count = 4, fwhm_nm = 10.0 }
"""
LIDAR = """[[lidar]]
name = "laser"
pulses = 64
prf_khz = 1.0
altitude_agl_m = 200.0
speed_m_s = 250.0
[lidar.pulse]
energy_J = 1e-6
wavelength_nm = 1064.0
fwhm_ns = 2.0
exit_diameter_mm = 10.0
exit_is = "1/e^2"
divergence_mrad = 4.0
divergence_is = "full angle at 1/e^2"
[lidar.receiver]
aperture_diameter_m = 0.1
fov_mrad = 6.0
[lidar.gate]
start_range_m = 185.0
stop_range_m = 205.0
bin_ns = 0.5
[lidar.sampling]
subrays = 64
overlap = "off"
"""
sim = folder / "camera.toml"
sim.write_text(SCENE.replace("AIR", "clear_sky") + CAMERA)


def rows(path):
    with open(path) as file:
        return list(csv.DictReader(file))


out = folder / "out"
arguments = ["chart", sim, "--knob", "samples", "--pixels", 256, "--timed-pixels", 64, "--repeats", 2, "-o", out]
first = run(*arguments, env=env)
table = rows(out / "camera_chart/chart.csv")
figures = json.loads((out / "camera_chart/chart.json").read_text())
check((out / "camera_chart/chart.png").read_bytes()[:4] == b"\x89PNG")
samples = [row for row in table if row["knob"] == "samples"]
check(len(samples) == 10 and table[0]["knob"] == "own" and len(table) == 11, [row["label"] for row in table])
error = {row["label"]: float(row["error"]) for row in samples}
# Squares of 1.3 m under pixels of 1 m: n x n samples leave about n^-1.5 of the contrast (a line through n^2 cells).
check(error["1x1"] > 2 * error["3x3"] > 4 * error["7x7"], error)
check(error["1x1"] > 0.3, error)
rays = [float(row["rays"]) for row in samples]
check(all(a < b for a, b in zip(rays, rays[1:])), rays)
for row, n in zip(samples, (1, 2, 3, 4, 5, 7, 9, 11, 15, 21)):
    check(
        row["label"] == f"{n}x{n}" and n * n <= float(row["rays"]) <= n * n * (2 + 4), row
    )  # sun and 4 directions at most
    check(float(row["error_low"]) <= float(row["error"]) <= float(row["error_high"]), row)
    check(float(row["time_low_s"]) <= float(row["time_s"]) <= float(row["time_high_s"]), row)
own = next(row for row in table if row["knob"] == "own")
check(own["error"] == next(row for row in samples if row["label"] == "3x3")["error"])
check(
    any(row["front"] == "1" for row in table) and next(row for row in table if row["label"] == "1x1")["front"] in "01"
)
check(
    figures["validated"] == 256 and 0 < figures["reference_error"] < 0.01 and len(figures["points"]) == len(table),
    figures["reference_error"],
)
check(figures["machines"][0] == table[0]["device"] and len(figures["machines"]) >= 2)
check("own error" in first.stdout and "1x1" in first.stdout)

# What is there stays; with --overwrite the reference comes from the cache and an error is the same number again.
program.refused(*arguments, status=2, says=["chart.csv"], env=env)
again = run(*("sampler" if word == "samples" else word for word in arguments), "--overwrite", "-v", "--json", env=env)
check("reference from the cache" in again.stderr, again.stderr)
points = json.loads(again.stdout)["camera"]["points"]
check(
    [p["label"] for p in points] == ["own", "grid", "lattice", "jittered"]
    and points[0]["error"] == points[1]["error"] == float(own["error"]),
    points,
)
check(len(list((folder / "cache/raycube/reference").iterdir())) == 1)

program.refused(
    "chart",
    sim,
    "--knob",
    "colour",
    "-o",
    folder / "a",
    status=2,
    says=["no knob is called 'colour'", "sky_directions"],
    env=env,
)
program.refused("chart", sim, "--knob", "subrays", "-o", folder / "a", status=2, says=["none of the knobs"], env=env)
program.refused("chart", sim, "--instrument", "radar", "-o", folder / "a", status=2, says=["radar", "camera"], env=env)

# The same settings against the same reference by what the tolerance is of; of light squares alone, which are as many.
by = {"rms": figures}
for name, keys in (
    *([("rms", "")] if FULL else []),
    ("p99", 'tolerance_of = "p99"\n'),
    ("worst", 'tolerance_of = "worst"\n'),
    ("light", 'tolerance_of = "worst"\ntolerance_materials = ["light"]\n'),
):
    asked = folder / f"{name}.toml"
    asked.write_text(sim.read_text().replace("format = 1\n", "format = 1\n" + keys, 1))
    words = [asked if word == sim else folder / name if word == out else word for word in arguments]
    said = run(*words, "--json", "-v", env=env)
    check("reference from the cache" in said.stderr, said.stderr)
    by[name] = json.loads(said.stdout)["camera"]
figure_of = [by[name]["tolerance_of"] for name in by]
check(figure_of == ["rms", "p99", "worst", "worst"] and by["light"]["tolerance_materials"] == ["light"], figure_of)
for i, point in enumerate(by["rms"]["points"]):
    p99, worst, light = (by[name]["points"][i] for name in ("p99", "worst", "light"))
    check(point["rms"] == p99["rms"] == worst["rms"] and point["p95"] <= p99["error"], point, p99)
    check(point["error"] < p99["error"] <= worst["error"] <= worst["error_high"], point, p99, worst)
    check(0 < light["error"] < worst["error"], light, worst)  # over a mean that is brighter
if FULL:
    text = run(*[folder / "light.toml" if word == sim else word for word in arguments], "--overwrite", env=env).stdout
    check("tolerance 0.01 (worst of the pixels of light)" in text, text)

# Pulses: waveforms converge with sub-rays; the reference has more of them than any level.
laser = folder / "laser.toml"
laser.write_text(SCENE.replace("AIR", "none") + LIDAR)
run("chart", laser, "--knob", "subrays", "--knob", "bin_ns", "--pulses", 16, "--repeats", 1, "-o", out, env=env)
table = rows(out / "laser_chart/chart.csv")
error = {(row["knob"], row["label"]): float(row["error"]) for row in table}
check(error["subrays", "1"] > 2 * error["subrays", "64"] > 2 * error["subrays", "1024"], error)
check(error["bin_ns", "2"] > error["bin_ns", "1"] > error["bin_ns", "0.5"], error)
rays = [float(row["rays"]) for row in table if row["knob"] == "subrays"]
check(all(a < b for a, b in zip(rays, rays[1:])), rays)

# Light between surfaces: in a street between bright walls errors fall with the surfaces that light may meet. A file
# need not have it where the knob is named.
street = folder / "street.toml"
street.write_text(
    """format = 1
sky_directions = 256
material = [{ name = "light", reflectance = 0.6 }]
plane = [{ material = "light", size_m = [200.0, 200.0] }]
box = [
  { material = "light", position_m = [0.0, 4.0, 0.0], size_m = [60.0, 5.0, 12.0] },
  { material = "light", position_m = [0.0, -4.0, 0.0], size_m = [60.0, 5.0, 12.0] },
]
atmosphere = { model = "clear_sky" }
time = { sun = { zenith_deg = 40.0, azimuth_deg = 150.0 } }
"""
    + CAMERA.replace("gsd_m = 1.0", "gsd_m = 0.15")
)
asked = ["chart", street, "--pixels", 16, "--timed-pixels", 64, "--reference-grid", 4, "--repeats", 1, "-o", out]
run(*asked, "--knob", "bounces", "--overwrite", env=env)
table = rows(out / "camera_chart/chart.csv")
error = {row["label"]: float(row["error"]) for row in table if row["knob"] == "bounces"}
check(list(error) == ["0", "1", "2", "4", "8", "16", "64"], error)
check(error["0"] > 1.1 * error["1"] > 1.3 * error["2"] > 2 * error["4"] > 2 * error["64"], error)
told = json.loads((out / "camera_chart/chart.json").read_text())["reference"]
check("4096 paths to 64 surfaces" in told, told)
print(f"{program.checks} checks")
