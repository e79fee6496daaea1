#!/usr/bin/env python3
"""What run.json says of turbulence, against quadratures of our own: heights of Hufnagel-Valley count from the ground
below the path (terrain, z = 0 or ground_z_m), whatever the beam hits.
usage: lidar_turbulence_run_test.py RAYCUBE"""

import math
import pathlib
import sys
import tempfile

import numpy
from driver import Program, record

program = Program(sys.argv[1])
run, check = program.run, program.check

SCENE = """format = 1
[[material]]
name = "grey"
reflectance = 0.3
{things}
[atmosphere]
model = "none"
[[lidar]]
name = "l"
position_m = {place}
look_at_m = {target}
prf_khz = 1.0
pulses = 2
[lidar.pulse]
energy_J = 1.0
wavelength_nm = {nm}
fwhm_ns = 4.0
exit_diameter_mm = 20.0
exit_is = "1/e^2"
divergence_mrad = 0.2
divergence_is = "full angle at 1/e^2"
[lidar.receiver]
aperture_diameter_m = 0.1
fov_mrad = 2.0
[lidar.gate]
start_range_m = {near}
stop_range_m = {far}
[lidar.sampling]
subrays = 16
[lidar.turbulence]
{turbulence}
[lidar.products]
png = false
"""
HV = 'profile = "hufnagel_valley"'


def cn2(height_m):
    """Hufnagel-Valley 5/7, m^-2/3 (Hufnagel 1974, Ulrich 1988)."""
    h = numpy.maximum(height_m, 0.0)
    return (
        0.00594 * (21 / 27) ** 2 * (1e-5 * h) ** 10 * numpy.exp(-h / 1000)
        + 2.7e-16 * numpy.exp(-h / 1500)
        + 1.7e-14 * numpy.exp(-h / 100)
    )


def integral(heights_m, length_m, weight):
    """Midpoint rule over the path, of Cn2 times a weight of the distance from the start."""
    z = (numpy.arange(len(heights_m)) + 0.5) / len(heights_m) * length_m
    return float((cn2(heights_m) * weight(z)).mean() * length_m)


def expected(heights_m, length_m, nm):
    """Figures of run.json from heights above the ground at the middles of equal steps of the path."""
    k = 2 * math.pi / (nm * 1e-9)
    of = lambda weight: integral(heights_m, length_m, weight)
    return {
        "fried_m": (0.423 * k**2 * of(lambda z: (1 - z / length_m) ** (5 / 3))) ** -0.6,
        "fried_plane_m": (0.423 * k**2 * of(lambda z: 1 + 0 * z)) ** -0.6,
        "isoplanatic_angle_rad": (2.914 * k**2 * of(lambda z: z ** (5 / 3))) ** -0.6,
        "rytov_variance_plane": 2.25 * k ** (7 / 6) * of(lambda z: (length_m - z) ** (5 / 6)),
        "rytov_variance_spherical": 2.25 * k ** (7 / 6) * of(lambda z: (z * (length_m - z) / length_m) ** (5 / 6)),
    }


def rendered(work, **values):
    values.setdefault("turbulence", HV)
    scene = work / "scene.toml"
    scene.write_text(SCENE.format(**values))
    done = run("render", scene, "-o", work / "out", "--overwrite")
    return record(work / "out/l")["survey"]["turbulence"], done.stderr


def agree(found, wanted, tolerance, *what):
    for name, value in wanted.items():
        check(abs(found[name] / value - 1) < tolerance, name, found[name], value, *what)


def box(name, at, size):
    return f'[[box]]\nname = "{name}"\nmaterial = "grey"\nposition_m = {at}\nsize_m = {size}\n'


STEPS = 200000  # of the quadrature here: HV's layers to 1e-7, the ends' powers to 1e-8


def level(work):
    """1 km level at 300 m to a wall: all of it lies at 300 m. fried_m 0.345 (0.065 with heights from what is hit)."""
    values = dict(place=[0.0, -500.0, 300.0], target=[0.0, 500.0, 300.0], near=900.0, far=1100.0, nm=1064.0)
    for z, things in (
        (0.0, box("wall", [0.0, 501.0, 200.0], [50.0, 2.0, 200.0])),
        (
            0.0,
            '[[plane]]\nmaterial = "grey"\nsize_m = [2000.0, 2000.0]\n'
            + box("wall", [0.0, 501.0, 0.0], [50.0, 2.0, 400.0]),
        ),
    ):
        found, said = rendered(work, things=things, **values)
        agree(found, expected(numpy.full(STEPS, 300.0 - z), found["path_m"], 1064.0), 1e-6)
        check(abs(found["path_m"] - 1000) < 0.01 and abs(found["fried_m"] - 0.345) < 5e-4, found)
        # In a scene whose lowest surface hangs in the air the ground is a guess, and says so.
        check(("give ground_z_m" in said) == ("plane" not in things), said)
    found, said = rendered(
        work,
        things=box("wall", [0.0, 501.0, 200.0], [50.0, 2.0, 200.0]),
        turbulence=HV + "\nground_z_m = 180.0",
        **values,
    )
    agree(found, expected(numpy.full(STEPS, 120.0), found["path_m"], 1064.0), 1e-6)
    check("give ground_z_m" not in said, said)


def space(work):
    """From the ground to 100 km at 500 nm: the profile's own name, r0 = 5 cm and 7 urad."""
    found, _ = rendered(
        work,
        things='[[plane]]\nmaterial = "grey"\nsize_m = [100.0, 100.0]\n'
        + box("satellite", [0.0, 0.0, 1e5], [40.0, 40.0, 10.0]),
        place=[0.0, 0.0, 0.01],
        target=[0.0, 0.0, 1e5],
        near=99990.0,
        far=100010.0,
        nm=500.0,
    )
    heights = 0.01 + (numpy.arange(2000000) + 0.5) / 2000000 * found["path_m"]
    agree(found, expected(heights, found["path_m"], 500.0), 3e-6)
    check(
        abs(found["fried_plane_m"] / 0.0496 - 1) < 2e-3 and abs(found["isoplanatic_angle_rad"] / 6.90e-6 - 1) < 2e-3,
        found,
    )


def relief(work):
    """Heights follow the terrain below the path: a valley between two slopes, and a mast's top as the target."""
    posts, step, base = 81, 25.0, 1800.0
    y = (numpy.arange(posts) - 40) * step  # rows from north to south
    profile = base + 0.2 * numpy.abs(y)
    rows = "\n".join(" ".join(f"{profile[posts - 1 - r]:.6f}" for _ in range(posts)) for r in range(posts))
    corner = -40 * step - step / 2
    (work / "valley.asc").write_text(
        f"ncols {posts}\nnrows {posts}\nxllcorner {corner}\nyllcorner {corner}\ncellsize {step}\n{rows}\n"
    )
    things = '[[terrain]]\nraster = "valley.asc"\nmaterial = "grey"\n' + box(
        "mast", [0.0, 600.0, 1900.0], [10.0, 10.0, 160.0]
    )
    values = dict(
        things=things, place=[0.0, -600.0, 2020.0], target=[0.0, 600.0, 2000.0], near=1000.0, far=1300.0, nm=1064.0
    )
    found, said = rendered(work, **values)
    length = found["path_m"]
    share = (numpy.arange(STEPS) + 0.5) / STEPS * length / math.hypot(1200.0, 20.0)
    heights = 2020 - 20 * share - (base + 0.2 * numpy.abs(-600 + 1200 * share))
    # The valley's floor is a kink inside a piece of the quadrature.
    agree(found, expected(heights, length, 1064.0), 1e-4)
    check(abs(found["start_height_m"] - 100) < 1e-3 and "give ground_z_m" not in said, found, said)
    # One height for all of the ground, where a user says so.
    flat, _ = rendered(work, turbulence=HV + "\nground_z_m = 1900.0", **values)
    agree(flat, expected(120 - 20 * share, length, 1064.0), 1e-6)


def names(work):
    """Indices are named by their way, and the choice of distribution by the variance that it goes by."""
    things = '[[plane]]\nmaterial = "grey"\nsize_m = [2000.0, 2000.0]\n' + box(
        "wall", [0.0, 501.0, 0.0], [50.0, 2.0, 400.0]
    )
    values = dict(
        things=things, place=[0.0, -500.0, 300.0], target=[0.0, 500.0, 300.0], near=900.0, far=1100.0, nm=1064.0
    )
    for strength, limit in ((9e-15, "below"), (1e-14, "not below")):
        found, _ = rendered(work, turbulence=f'profile = "constant"\ncn2 = {strength}', **values)
        k, length = 2 * math.pi / 1064e-9, found["path_m"]
        plane = 2.25 * 6 / 11 * k ** (7 / 6) * strength * length ** (11 / 6)
        check(abs(found["rytov_variance_plane"] / plane - 1) < 1e-6, found, plane)
        # The spherical variance is 0.4 of it: it would explain neither.
        check(found["rytov_variance_spherical"] < 0.3 and (plane >= 0.3) == (limit == "not below"), found)
        check(found["distribution"] == ("gamma-gamma" if plane >= 0.3 else "log-normal"), found)
        check(found["distribution_because"] == f"rytov_variance_plane {plane:.4g} is {limit} 0.3", found)
        down, up = found["scintillation_index_one_way_down"], found["scintillation_index_one_way_up"]
        check(
            abs(found["scintillation_index_two_way"] - ((1 + down) * (1 + up) - 1)) < 1e-12 and 0 < up and 0 < down,
            found,
        )
        check(
            len(found["lines"]) == 1 and found["lines"][0]["rytov_variance_plane"] == found["rytov_variance_plane"],
            found,
        )
        check("scintillation_index" not in found, found)


def refused(work):
    scene = work / "bad.toml"
    for text, says in (
        ('profile = "constant"\ncn2 = 1e-14\nground_z_m = 0', "'ground_z_m' means nothing for profile = \"constant\""),
        (HV + "\nground_z_m = 1e9", "'ground_z_m' is out of range"),
    ):
        scene.write_text(
            SCENE.format(
                things=box("wall", [0.0, 501.0, 0.0], [50.0, 2.0, 400.0]),
                turbulence=text,
                place=[0.0, -500.0, 300.0],
                target=[0.0, 500.0, 300.0],
                near=900.0,
                far=1100.0,
                nm=1064.0,
            )
        )
        program.refused("render", scene, "-o", work / "none", status=2, says=[says])


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    refused(folder)
    level(folder)
    space(folder)
    relief(folder)
    names(folder)
print(f"lidar_turbulence_run: {program.checks} checks, all well")
