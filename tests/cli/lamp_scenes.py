"""Scenes with lamps, for the tests of what they bring and of what is refused: a floor at night under a camera."""

import math
import sys

import numpy

from driver import Program, envi

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

REFLECTANCE, SIZE, GRID = 0.4, 24, 4
WORLD = """format = 1
seed = 7
{head}
material = [
  {{ name = "floor", reflectance = 0.4 }},
  {{ name = "dark", reflectance = 0.05 }},
  {{ name = "leaf", reflectance = 0.3, transmittance = 0.25 }},
  {materials}
]
plane = [{{ material = "{floor}", size_m = [400.0, 400.0] }}, {planes}]
atmosphere = {{ model = "none" }}
time = {{ sun = {{ zenith_deg = {sun}, azimuth_deg = 150.0 }} }}
lamp = [{lamps}]
[[instrument]]
name = "camera"
kind = "framing"
pixels = {pixels}
lines = {pixels}
altitude_agl_m = 300.0
gsd_m = {gsd}
bands = {{ first_nm = 500.0, step_nm = 200.0, count = 2, fwhm_nm = 20.0 }}
{instrument}
"""
DEFAULTS = dict(
    head="bounces = 0",
    materials="",
    floor="floor",
    planes="",
    sun=120.0,
    lamps="",
    pixels=SIZE,
    gsd=0.25,
    instrument=f"samples = {{ grid = [{GRID}, {GRID}] }}",
)
POINT = '{{ name = "{name}", position_m = [{at}], spectrum = "flat.csv", power_W = {power} }}'
# flat.csv: as much at all wavelengths from 0.4 to 0.9 um, 2 per um of its flux.
FLAT = 2.0
RED = 1 / 0.15  # red.csv at 700 nm, per um: trapezoids of 0.05, 0.1 and 0.05 um


def world(work, name, **values):
    file = work / f"{name}.toml"
    file.write_text(WORLD.format(**{**DEFAULTS, **values}))
    return file


def render(work, name, *options, **values):
    """Radiance, and the truth's layers by name."""
    run("render", world(work, name, **values), "-o", work / name, "-q", *options)
    header, truth = envi(work / name / "camera", "truth")
    names = [one.partition(" [")[0] for one in header["band names"]]
    return envi(work / name / "camera", "radiance")[1].astype(float), {
        one: truth[..., i] for i, one in enumerate(names)
    }


def write_files(work):
    (work / "flat.csv").write_text("wavelength_um,flux\n0.4,1\n0.9,1\n")
    (work / "line.csv").write_text("wavelength_nm,flux\n554.9,1\n555.1,1\n")
    (work / "red.csv").write_text("wavelength_nm,flux\n600,0\n650,3\n750,3\n800,0\n")
    head = "IESNA:LM-63-2002\n[TEST] none\nTILT=NONE\n1 1000 {multiplier} {v} {h} 1 2 0 0 0 1.0 1.0 50\n"
    vertical = numpy.arange(0, 91)
    cosine = numpy.cos(numpy.radians(vertical)) * 100
    (work / "cosine.ies").write_text(
        head.format(multiplier=2.0, v=91, h=1)
        + " ".join(map(str, vertical))
        + "\n0\n"
        + " ".join(f"{c:.6f}" for c in cosine)
        + "\n"
    )
    narrow = numpy.clip(1 - vertical / 60.0, 0, 1) * 100  # of all planes the same but for a factor
    planes = "\n".join(
        " ".join(f"{c:.6f}" for c in narrow * (1 + 0.5 * math.cos(math.radians(h)))) for h in (0, 45, 90, 135, 180)
    )
    (work / "street.ies").write_text(
        head.format(multiplier=1.0, v=91, h=5) + " ".join(map(str, vertical)) + "\n0 45 90 135 180\n" + planes + "\n"
    )
