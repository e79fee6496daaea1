#!/usr/bin/env python3
"""SHA-256 of every product of a list of scenes, against the figures that were recorded: what is moved about in the tree
may not move a bit. One scene for each form that kernels are built in (samplers, motion, point spread, chunks, adaptive
samples, sources of light, nodes, ground around; of LIDARs detectors, sampling, bounces, plates, leaves, gloss, volumes,
turbulence). usage: digests_test.py RAYCUBE FOLDER [--write]
Bits are those of one device and driver: FOLDER has a file for each that was met, its first line the name; on another
the test renders nothing, is skipped (77) and says so. --write records what is found instead of comparing; where bits
were meant to move, the files of other devices are no longer true, and go. Left out: run.json (times), pictures that
matplotlib draws, the day in a LAS header.
"""

import csv
import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
from driver import PULSE_AND_RECEIVER, Program  # noqa: E402

program = Program(sys.argv[1])
folder, write = pathlib.Path(sys.argv[2]), "--write" in sys.argv[3:]

# Flat ground of two halves, a mixed and a checkered plate, a box that shades, a tree, small plates; no two of one
# reflectance.
WORLD = """format = 1
seed = 11
tolerance = {tolerance}
bounces = {bounces}
{head}
material = [
  {{ name = "soil", reflectance = 0.20, temperature_K = 300.0 }},
  {{ name = "grass", file = "grass.csv", temperature_K = 295.0 }},
  {{ name = "leaf", file = "leaf.csv", temperature_K = 294.0 }},
  {{ name = "bark", reflectance = 0.15, temperature_K = 296.0 }},
  {{ name = "roof", reflectance = 0.45, temperature_K = 310.0 }},
  {{ name = "lava", reflectance = 0.10, temperature_K = 1100.0 }},
  {more}
]
plane = [
  {{ material = "soil", position_m = [-100.0, 0.0, 0.0], size_m = [200.0, 400.0] }},
  {{ material = "grass", position_m = [100.0, 0.0, 0.0], size_m = [200.0, 400.0] }},
  {{ material = "roof", position_m = [3.0, 4.0, 0.5], size_m = [0.6, 0.4] }},
  {{ checker = {{ materials = ["soil", "roof"], cell_m = 0.7 }}, position_m = [-8.0, 5.0, 0.2], size_m = [5.0, 4.0] }},
  {plane}
]
box = [{{ material = "roof", position_m = [-4.0, -5.0, 0.0], size_m = [4.0, 5.0, 3.0], yaw_deg = 20.0 }}]
mesh = [{{ name = "tree", file = "tree.obj", materials = {{ crown = "{crown}", trunk = "bark" }} }}]
instance = [
  {{ mesh = "tree", position_m = [-7.0, -2.2, 0.0] }},
  {{ mesh = "tree", position_m = [-2.5, -1.8, 0.0], yaw_deg = 40.0 }},
]
scatter = [{{ mesh = "tree", positions = "trees.csv", on_terrain = false }}]
atmosphere = {air}
time = {{ {light} }}
{volume}
"""
CAMERA = """[[instrument]]
name = "camera"
kind = "{kind}"
pixels = 29
lines = 13
{pose}
{samples}
bands = {{ {bands} }}
{instrument}
"""
FRAME = "altitude_agl_m = 200.0\ngsd_m = 1.1\nheading_deg = 30.0\nroll_deg = 1.0"
DEFAULTS = dict(
    tolerance=0.02,
    bounces=0,
    head="sky_directions = 12",
    more="",
    plane="",
    crown="leaf",
    air='{ model = "clear_sky" }',
    light="sun = { zenith_deg = 50.0, azimuth_deg = 150.0, day_of_year = 200 }",
    volume="",
    kind="framing",
    pose=FRAME,
    samples="samples = { grid = [3, 3] }",
    bands="first_nm = 480.0, step_nm = 60.0, count = 9, fwhm_nm = 30.0",
    instrument="",
)
ROUGH = '{ name = "rough", reflectance = 0.3, oren_nayar = { sigma_deg = 25.0 } },'
ROUGH_GROUND = '{ material = "rough", position_m = [-5.0, -2.0, 0.1], size_m = [12.0, 12.0], tilt_deg = 10.0 },'
LAYERED = '{ model = "layered", spectral_step_nm = 20.0%s }'
LONGWAVE = "first_nm = 8000.0, step_nm = 900.0, count = 5, fwhm_nm = 400.0"
LAMPS = """lamp = [
  { name = "point", position_m = [1.0, 2.0, 4.0], temperature_K = 2800.0, flux_lm = 5000.0 },
  { name = "disc", shape = "disc", position_m = [-3, 1, 3], diameter_m = 2.0, temperature_K = 4000.0, power_W = 5.0 },
  { name = "spot", shape = "spot", cone_deg = [20, 40], position_m = [2, -3, 5], temperature_K = 2800.0, power_W = 60 },
]"""
CAMERAS = {
    "grid": {},
    "vacuum": dict(air='{ model = "none" }', samples="samples = { lattice = 34 }"),
    "one_sample": dict(samples="samples = { grid = [1, 1] }"),
    "chosen": dict(head="", samples=""),
    "small_objects": dict(samples="samples = { lattice = 8 }", instrument='small_objects = "on"'),
    "chunks": dict(samples="samples = { jittered = [40, 40] }"),
    "adaptive": dict(samples="samples = { lattice = 64, first = 8 }"),
    "standard_error": dict(samples="samples = { jittered = [6, 6] }", instrument='standard_error = "bands"'),
    "point_spread": dict(
        samples="samples = { jittered = [4, 4] }", instrument="psf = { sigma_px = 0.6, support_px = 5.0 }"
    ),
    "few_sky_rays": dict(head="sky_directions = 24", samples="samples = { grid = [8, 8] }"),
    "pushbroom_held": dict(kind="pushbroom", pose='poses = "poses.csv"\ngsd_m = 1.1\nmotion = "held"'),
    "pushbroom_moving": dict(kind="pushbroom", pose='poses = "poses.csv"\ngsd_m = 1.1\nmotion = "moving"'),
    "whiskbroom": dict(kind="whiskbroom", pose='poses = "poses.csv"\ngsd_m = 1.1'),
    "integers": dict(instrument="integer_scale = 100.0\ninterleave = \"bsq\"\nexr = true"),
    "layered": dict(air=LAYERED % ', aerosol = "maritime", visibility_km = 15.0'),
    "ground_around": dict(
        air=LAYERED % ', adjacency = "local"', pose=FRAME.replace("200.0", "2000.0").replace("1.1", "6.0")
    ),
    "longwave": dict(air=LAYERED % "", bands=LONGWAVE),
    "midwave": dict(air=LAYERED % "", bands="first_nm = 3300.0, step_nm = 300.0, count = 5, fwhm_nm = 120.0"),
    "fire": dict(
        bands="first_nm = 1600.0, step_nm = 200.0, count = 5, fwhm_nm = 60.0",
        air='{ model = "none" }',
        plane='{ material = "lava", position_m = [6.0, 2.0, 0.1], size_m = [3.0, 3.0] },',
    ),
    "moon": dict(
        air=LAYERED % "",
        light="moon = { zenith_deg = 40.0, azimuth_deg = 150.0, phase_angle_deg = 20.0, day_of_year = 200 }",
    ),
    "oren_nayar": dict(more=ROUGH, plane=ROUGH_GROUND, samples="samples = { grid = [3, 4] }"),
    "band_truth": dict(
        tolerance=0.02,
        bounces=2,
        instrument='band_truth = ["parts", "irradiance", "reflectance", "emissivity", "transmission"]',
    ),
    "lamps": dict(head="sky_directions = 16\n" + LAMPS, bounces=2, samples="samples = { lattice = 34 }"),
    "nodes": dict(tolerance=0.0005, pose=FRAME.replace("roll_deg = 1.0", "roll_deg = 35.0")),
}
LIDAR = (
    """[[lidar]]
name = "lidar"
position_m = [-5.0, -2.0, 120.0]
prf_khz = {prf}
pulses = {pulses}
{shot}
"""
    + PULSE_AND_RECEIVER.replace("fov_mrad = 2.0", "{view}").replace(
        "divergence_mrad = 0.2", "divergence_mrad = {divergence}"
    )
    + """
[lidar.gate]
start_range_m = {start}
stop_range_m = {stop}
[lidar.scan]
pattern = "oscillating"
rate_hz = 40.0
half_angle_deg = 3.0
[lidar.sampling]
subrays = {subrays}
{sampling}
[lidar.products]
png = false
{lidar}
"""
)
LIDAR_DEFAULTS = dict(
    pulses=40,
    prf=10.0,
    start=100.0,
    stop=135.0,
    shot="",
    view="fov_mrad = 2.0",
    divergence=1.0,
    subrays=24,
    sampling="",
    lidar="",
)
ARRAY = "array = { columns = 6, rows = 5, focal_length_mm = 200.0, pitch_um = 400.0 }"
LEAVES = '{ name = "leaves", reflectance = 0.35, transmittance = 0.30, transmission = "leaf" },'
PLATE = '{ name = "net", reflectance = 0.2, transmittance = 0.5, transmission = "plate" },'
GLOSS = '{ name = "wet", reflectance = 0.1, gloss = { roughness = 0.2, f0 = 0.05 } },'
LIDARS = {
    "photons": {},
    "linear": dict(
        lidar='[lidar.detector]\nmode = "linear"\ngain = 20.0\nionization_ratio = 0.2\nreadout_noise_e = 300.0\n'
        'bits = 12\n[lidar.speckle]\non = true'
    ),
    "geiger": dict(lidar='[lidar.detector]\nmode = "geiger"\ndark_rate_hz = 1e5\njitter_fwhm_ns = 0.3'),
    "layered_air": dict(air=LAYERED % ""),
    "bounces": dict(sampling="bounces = 3"),
    "leaves": dict(more=LEAVES, crown="leaves", sampling="bounces = 2"),
    "plates": dict(more=PLATE, plane='{ material = "net", position_m = [-5.0, -2.0, 6.0], size_m = [12.0, 12.0] },'),
    "gloss": dict(more=GLOSS, plane='{ material = "wet", position_m = [-5.0, -2.0, 0.1], size_m = [12.0, 12.0] },'),
    "gloss_bounces": dict(
        more=GLOSS,
        plane='{ material = "wet", position_m = [-5.0, -2.0, 0.1], size_m = [12.0, 12.0] },',
        view="fov_mrad = 60.0",
        sampling="bounces = 2",
    ),
    "turbulence": dict(lidar='[lidar.turbulence]\nprofile = "hufnagel_valley"'),
    "array": dict(pulses=4, view=ARRAY, divergence=20.0, subrays=400),
    "receiver": dict(pulses=4, view=ARRAY, divergence=20.0, sampling='from = "receiver"'),
    "background": dict(
        air=LAYERED % "",
        view="fov_mrad = 60.0\nfilter_fwhm_nm = 20.0",
        lidar="[lidar.detector]\nsolar_background = true",
    ),
    "folded": dict(
        prf=2000.0,
        start=20.0,
        stop=70.0,
        shot="fold_ambiguous = true",
        lidar="[lidar.echoes]\nair_is_background = false",
    ),
    "oren_nayar": dict(more=ROUGH, plane=ROUGH_GROUND, view="fov_mrad = 60.0", sampling="bounces = 2"),
    "smoke": dict(
        volume='[[volume]]\nname = "smoke"\nshape = "box"\nposition_m = [-5.0, -2.0, 4.0]\nsize_m = [20.0, 20.0, 6.0]\n'
        'particles = { extinction_per_m = 0.05 }'
    ),
}
POSES = "x_m,y_m,z_m,roll_deg,pitch_deg,heading_deg\n" + "".join(
    f"{-3 + 0.3 * i:.3f},{-7 + 1.1 * i:.3f},{200 + 0.2 * i:.3f},{0.4 * (i % 3) - 0.3:.3f},{0.3 * (i % 4) - 0.5:.3f},"
    f"{3 + 0.9 * i:.3f}\n"
    for i in range(13)
)


def written(work, name):
    """The scene's file, in a folder of its own beside the small files that it names."""
    folder = work / name
    folder.mkdir()
    for file in ("tree.obj", "trees.csv", "grass.csv", "leaf.csv"):
        shutil.copy(work / "garden" / file, folder)
    (folder / "poses.csv").write_text(POSES)
    values = {**DEFAULTS, **LIDAR_DEFAULTS}
    if name.removeprefix("lidar_") in LIDARS and name.startswith("lidar_"):
        values.update(air='{ model = "none" }')
        values.update(LIDARS[name.removeprefix("lidar_")])
        text = (WORLD + LIDAR).format(**values)
    else:
        values.update(CAMERAS[name])
        text = (WORLD + CAMERA).format(**values)
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def hashed(path):
    data = bytearray(path.read_bytes())
    if path.suffix == ".las":
        data[90:94] = bytes(4)  # day and year it was made
    return hashlib.sha256(data).hexdigest()


def this_device():
    """Name and driver of the one that renders by default."""
    text = subprocess.run([sys.argv[1], "devices", "--json"], check=True, capture_output=True, text=True).stdout
    first = json.loads(text)["devices"][0]
    return f"{first['name']}, {first['driver']}"


def records():
    """Device -> its file."""
    return {path.read_text().partition("\n")[0][2:]: path for path in sorted(folder.glob("*.csv"))}


def name_of_file(device):
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", device) + ".csv"


def found(work):
    """(scene, file) -> digest, in order of the lists."""
    out = {}
    program.run("new", work / "garden", "-q")
    for name in [*CAMERAS, *("lidar_" + name for name in LIDARS)]:
        file = written(work, name)
        began = time.monotonic()
        program.run("render", file, "-o", file.parent / "out", "-q")
        for folder in sorted(path for path in (file.parent / "out").iterdir() if path.is_dir()):
            for path in sorted(folder.iterdir()):
                if path.name != "run.json":
                    out[name, path.name] = hashed(path)
        shutil.rmtree(file.parent)
        print(f"{name}: {time.monotonic() - began:.1f} s")
    return out


device, known = this_device(), records()
if device not in known and not write:
    on = "; ".join(known)
    print(f"digests: SKIPPED: recorded on {on}, this is {device}; bits are those of one device and driver")
    sys.exit(77)
with tempfile.TemporaryDirectory() as work:
    products = found(pathlib.Path(work))
if write:
    lines = [f"# {device}\n", "scene,product,sha256\n"] + [
        f"{scene},{file},{digest}\n" for (scene, file), digest in products.items()
    ]
    to = known.get(device, folder / name_of_file(device))
    to.write_text("".join(lines))
    print(f"digests: {len(products)} products of {len(CAMERAS) + len(LIDARS)} scenes written to {to}")
    sys.exit(0)
with open(known[device], newline="") as file:
    file.readline()
    recorded = {(row["scene"], row["product"]): row["sha256"] for row in csv.DictReader(file)}
moved = [
    f"{scene}: {file}"
    for (scene, file) in sorted(set(recorded) | set(products))
    if recorded.get((scene, file)) != products.get((scene, file))
]
for line in moved:
    print("moved, or not in both:", line)
print(f"digests: {len(products)} products of {len(CAMERAS) + len(LIDARS)} scenes, {len(moved)} moved")
sys.exit(1 if moved else 0)
