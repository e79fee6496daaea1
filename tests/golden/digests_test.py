#!/usr/bin/env python3
"""SHA-256 of every product of a list of scenes, against the figures that were recorded: what is moved about in the tree
may not move a bit. One scene for each form that kernels are built in (samplers, motion, point spread, chunks, adaptive
samples, sources of light, nodes, ground around; of LIDARs detectors, sampling, bounces, plates, leaves, gloss, volumes,
turbulence). usage: digests_test.py RAYCUBE FOLDER [--set NAME] [--write | --within]

Bits are those of the instruction set that PoCL compiles kernels for, not of a processor's maker or name: FOLDER has a
file for each set that was met (avx2.csv). Besides they may depend on the versions of PoCL, of LLVM, of the C library
and of the C++ compiler, which the second line states and a failure compares. The C library has functions for processors
without FMA, too: with those 6 of 259 products move, the returns of three LIDARs. A processor that has more than AVX2 is
told by the environment to compile for AVX2 (kernel_target.py), so each with AVX2 is held to that record; what it has of
its own is held to the record of that set. AVX-512 is held to AVX2's: all 259 products of the 40 scenes had the same
bits on an AMD EPYC with AVX-512 (family 25, model 17; 2026-11-30, kernels for skylake-avx512), on Intel's as Bochs
emulates it (skylake-x; host, Embree and C library on that processor, too), and where both were recorded on one
processor (commits d60c6427, 7ef013b3, e6fad690, ab96dadc), and no kernel takes what only one of them has (approximate
reciprocals, above all, which differ between makers). Should they part, --set avx512 --write makes a record of its own.
Where no record fits, some of the scenes are rendered in several ways that may not change a bit (threads, tiles, width
of vectors) and compared with each other, which the last line says. Nothing is skipped.

--write records what is found instead of comparing; where bits were meant to move, the files of other sets are no longer
true, and go. --set NAME compiles for a lesser set than the processor's. --within compares the ways alone. Left out:
run.json (times), pictures that matplotlib draws, the day in a LAS header.
"""

import argparse
import csv
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import kernel_target

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
from driver import PULSE_AND_RECEIVER, Program  # noqa: E402

parser = argparse.ArgumentParser()
parser.add_argument("raycube")
parser.add_argument("folder", type=pathlib.Path)
parser.add_argument("--set", choices=kernel_target.PROCESSORS)
parser.add_argument("--write", action="store_true")
parser.add_argument("--within", action="store_true")
arguments = parser.parse_args()
program, folder = Program(arguments.raycube), arguments.folder

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
SMALL_TILES = "small tiles"
RECORD_IT = f"which {sys.argv[0]} RAYCUBE FOLDER --set %s --write records"
SCENES = [*CAMERAS, *("lidar_" + name for name in LIDARS)]
#: Where no record fits: some of them, of each kind of sampling, air, light and detection.
WITHIN = [
    *("grid", "small_objects", "adaptive", "whiskbroom", "ground_around", "lamps"),
    *("lidar_linear", "lidar_bounces", "lidar_array", "lidar_smoke"),
]
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


class Record:
    """A file of FOLDER: two lines on what it was made with, then scene, product and SHA-256."""

    def __init__(self, path):
        self.path = path
        self.digests, self.versions = {}, ""
        if path.exists():
            with open(path, newline="") as file:
                file.readline()
                self.versions = file.readline().strip("# \n")
                self.digests = {(row["scene"], row["product"]): row["sha256"] for row in csv.DictReader(file)}

    def write(self, kernels, versions, products):
        lines = [f"# {kernels.set}: kernels that PoCL compiles for {kernels.device.processor}\n", f"# {versions}\n"]
        lines += ["scene,product,sha256\n"]
        lines += [f"{scene},{file},{digest}\n" for (scene, file), digest in products.items()]
        self.path.write_text("".join(lines))


def render_in_least_memory(words, env):
    """By tiles of one group of pixels, of one pulse: the program says what the least is where it is given less."""
    memory = 1
    while memory:
        run = [program.path, *map(str, words), "--overwrite", "--memory", str(memory)]
        done = subprocess.run(run, capture_output=True, text=True, env={**os.environ, **env})
        needed = re.search(r"need (\d+) bytes", done.stderr)
        assert done.returncode == 0 or (needed and int(needed[1]) > memory), (run, done.returncode, done.stderr)
        memory = int(needed[1]) if done.returncode else 0


def digests_of(work, name, env, *options):
    """(scene, file) -> digest of what one scene renders; `options` of the program, or SMALL_TILES."""
    file = written(work, name)
    words = ["render", file, "-o", file.parent / "out", "-q"]
    if SMALL_TILES in options:
        render_in_least_memory([*words, *(each for each in options if each != SMALL_TILES)], env)
    else:
        program.run(*words, *options, env=env)
    folders = sorted(path for path in (file.parent / "out").iterdir() if path.is_dir())
    out = {(name, path.name): path for folder in folders for path in sorted(folder.iterdir())}
    digests = {key: hashed(path) for key, path in out.items() if path.name != "run.json"}
    shutil.rmtree(file.parent)
    return digests


class Kernels:
    """The program with kernels of one instruction set: the device's own, or one that it is asked for."""

    def __init__(self, asked=None):
        self.env = kernel_target.asking_for(asked) if asked else {}
        self.device = kernel_target.Device(program.path, self.env)
        self.set = self.device.instruction_set()
        self.chosen = ["--device", self.device.number]

    def render(self, work, name, *options):
        return digests_of(work, name, self.env, *self.chosen, *options)

    def found(self):
        """Of all scenes, in order of the lists."""
        out = {}
        with tempfile.TemporaryDirectory() as work:
            program.run("new", pathlib.Path(work) / "garden", "-q")
            for name in SCENES:
                began = time.monotonic()
                out.update(self.render(pathlib.Path(work), name))
                print(f"{name}: {time.monotonic() - began:.1f} s", flush=True)
        return out


def versions_here(device):
    text = subprocess.run([program.path, "--version"], check=True, capture_output=True, text=True).stdout
    return kernel_target.versions(device, re.search(r"; (.*?)(?:, \w+)?\)", text)[1])


def moved(before, after):
    """Products that differ, or that are not in both."""
    return [
        f"{scene}: {file}"
        for scene, file in sorted(before | after)
        if before.get((scene, file)) != after.get((scene, file))
    ]


def held_to_record(kernels, record):
    """Products that moved; says so, and what else is not as it was recorded."""
    products = kernels.found()
    lines = moved(record.digests, products)
    for line in lines:
        print("moved, or not in both:", line)
    here = versions_here(kernels.device)
    if lines and here != record.versions:
        print(f"recorded with {record.versions}; here {here}: a bit that moved may be theirs")
    print(
        f"digests: {kernels.set}: {len(products)} products of {len(SCENES)} scenes, {len(lines)} moved "
        f"({kernels.device.name})"
    )
    return lines


def ways_of(kernels):
    """What may not change a bit: name -> (kernels, options of `render`)."""
    out = {SMALL_TILES: (kernels, [SMALL_TILES])}
    if kernels.device.is_cpu:
        out["one thread"] = (kernels, ["--threads", "1"])
    if kernels.set and kernels.set != "sse2":
        narrow = Kernels("avx2" if kernels.set == "avx512" else "sse2")
        if narrow.set != kernels.set:
            out[f"vectors of {narrow.set}"] = (narrow, [])
    return out


def held_to_itself(kernels, why):
    """Products that some way to compute them changes; says what was compared, and why."""
    ways, lines, products = ways_of(kernels), [], 0
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        program.run("new", work / "garden", "-q")
        for name in WITHIN:
            began = time.monotonic()
            expected = kernels.render(work, name)
            products += len(expected)
            for way, (other, options) in ways.items():
                found = [f"{line} ({way})" for line in moved(expected, other.render(work, name, *options))]
                for line in found:
                    print("not the same:", line)
                lines += found
            print(f"{name}: {time.monotonic() - began:.1f} s", flush=True)
    print(
        f"digests: {why}: {products} products of {len(WITHIN)} scenes were compared within this device "
        f"({kernels.device.name}), as they come by {', '.join(ways)}: {len(lines)} differ"
    )
    return lines


def compared(asked):
    """What differs from the records, and where none fits within the device."""
    own, lines, lacking = Kernels(asked), [], []
    # Each processor with AVX2 is held to that record, whatever it has besides.
    for name in ["avx2", "avx512"] if own.set == "avx512" and not asked else [own.set]:
        kernels, record = Kernels(name), folder / f"{name}.csv"
        if name is None:
            lacking.append("no record for a device that is no x86-64 processor")
        elif kernel_target.SETS.get(kernels.device.processor) != name:
            lacking.append(f"asked for {name}, PoCL compiles for {kernels.device.processor}")
        elif record.exists():
            lines += held_to_record(kernels, Record(record))
        elif name == "avx512" and (folder / "avx2.csv").exists():
            if different := held_to_record(kernels, Record(folder / "avx2.csv")):
                lacking.append(f"{len(different)} products of {name} are not as those of avx2, {RECORD_IT % name}")
        else:
            lacking.append(f"no record for {name}, {RECORD_IT % name}")
    return lines + (held_to_itself(own, "; ".join(lacking)) if lacking else [])


if arguments.write:
    kernels = Kernels(arguments.set)
    products, to = kernels.found(), Record(folder / f"{kernels.set}.csv")
    to.write(kernels, versions_here(kernels.device), products)
    print(f"digests: {len(products)} products of {len(SCENES)} scenes written to {to.path}")
    sys.exit(0)
if arguments.within:
    different = held_to_itself(Kernels(arguments.set), "no record was read, as --within asks")
else:
    different = compared(arguments.set)
sys.exit(1 if different else 0)
