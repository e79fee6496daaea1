"""S26 `first_opaque`: what each ray meets first that lets no light through, past all leaves, and the leaves before it.
Oracle: the same scene without its leaves, rendered by the same rays: what is opaque there is what is seen. usage:
first_opaque_test.py RAYCUBE"""

import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi

program = Program(sys.argv[1])
run, check = program.run, program.check

# Soil, a tilted roof, a box; three stacked sheets of leaf, one of them of another kind, and trees of such leaves.
WORLD = """format = 1
seed = 5
bounces = 0
sky_directions = 4
{head}
material = [
  {{ name = "soil", reflectance = 0.20, temperature_K = 300.0 }},
  {{ name = "roof", reflectance = 0.50, temperature_K = 310.0 }},
  {{ name = "leaf", reflectance = 0.40, transmittance = 0.35, temperature_K = 290.0 }},
  {{ name = "film", reflectance = 0.10, transmittance = 0.80, temperature_K = 280.0 }},
]
plane = [
  {{ material = "soil", size_m = [{size}, {size}] }},
  {{ material = "roof", position_m = [-6.0, 2.0, 2.0], size_m = [5.0, 4.0], tilt_deg = 20.0 }},
  {leaves}
]
box = [{{ material = "roof", position_m = [4.0, -4.0, 0.0], size_m = [3.0, 4.0, 3.0], yaw_deg = 20.0 }}]
{trees}
atmosphere = {{ model = "none" }}
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 150.0 }} }}
[[instrument]]
name = "camera"
kind = "framing"
pixels = 30
lines = 21
altitude_agl_m = 120.0
gsd_m = 1.0
roll_deg = 8.0
first_opaque = true
bands = {{ first_nm = 500.0, step_nm = 100.0, count = 2, fwhm_nm = 20.0 }}
{instrument}
"""
SHEETS = """{ material = "leaf", position_m = [-4.3, 1.0, 5.0], size_m = [7.0, 5.0], tilt_deg = 10.0, yaw_deg = 40.0 },
  { material = "film", position_m = [-3.0, 0.4, 7.0], size_m = [6.0, 6.0] },
  { material = "leaf", position_m = [5.0, -3.6, 4.0], size_m = [4.0, 4.0] },"""
TREES = """mesh = [{ name = "crown", file = "crown.obj", materials = { leaves = "leaf" } }]
instance = [
  { mesh = "crown", position_m = [1.0, 6.0, 2.0] },
  { mesh = "crown", position_m = [2.2, 5.4, 3.0], yaw_deg = 30.0, scale = 1.4 },
]"""
DEFAULTS = dict(head="", size=200.0, leaves=SHEETS, trees=TREES, instrument="samples = { lattice = 34 }")


def crown(path):
    """A hundred triangles at random in a ball of 1.5 m: each ray meets several."""
    random = numpy.random.default_rng(3)
    lines, faces = [], ["usemtl leaves"]
    for i in range(100):
        middle, corners = random.normal(0, 0.6, 3), random.normal(0, 0.4, (3, 3))
        lines += ["v " + " ".join(f"{x:.6f}" for x in middle + corner) for corner in corners]
        faces.append(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}")
    path.write_text("\n".join(lines + faces) + "\n")


def layers(work, name, *options, **values):
    file = work / f"{name}.toml"
    file.write_text(WORLD.format(**{**DEFAULTS, **values}))
    run("render", file, "-o", work / name, "-q", *options)
    header, truth = envi(work / name / "camera", "truth")
    names = [one.partition(" [")[0] for one in header["band names"]]
    return {one: truth[..., i] for i, one in enumerate(names)}


def check_form(work, name, **values):
    """With leaves and without: the opaque shares of the one are the abundances of the other."""
    full, bare = layers(work, name, **values), layers(work, name + "_bare", **{**values, "leaves": "", "trees": ""})
    for material in ("soil", "roof"):
        opaque, seen = full[f"opaque_abundance_{material}"], bare[f"abundance_{material}"]
        check(numpy.allclose(opaque, seen, atol=3e-7), name, material, numpy.abs(opaque - seen).max())
        check(numpy.array_equal(bare[f"opaque_abundance_{material}"], seen), name, "without leaves", material)
    check(not full["opaque_abundance_leaf"].any() and not full["opaque_abundance_film"].any(), name)
    return full, bare


def check_ids(full, bare):
    """Numbers and temperatures of what is opaque, and of the leaves that are seen before it."""
    check(numpy.array_equal(full["opaque_material_id"], bare["material_id"]))
    check(numpy.allclose(full["opaque_temperature_K"], bare["temperature_K"], rtol=1e-6, equal_nan=True))
    leaf, film = full["abundance_leaf"], full["abundance_film"]
    found = ((leaf > 0).sum(), (film > 0).sum(), ((leaf > 0) & (film > 0)).sum())
    check(found[0] > 15 and found[1] > 20 and found[2] > 5, found)
    number = numpy.where(film > leaf, 4, numpy.where(leaf > 0, 3, 0))
    check(numpy.array_equal(full["transparent_material_id"], number))
    mean = (290 * leaf + 280 * film) / numpy.where(leaf + film > 0, leaf + film, numpy.nan)
    check(numpy.allclose(full["transparent_temperature_K"], mean, rtol=1e-6, equal_nan=True))


def main(work):
    crown(work / "crown.obj")
    check_ids(*check_form(work, "lattice"))
    check_form(work, "edge", size=12.0)  # rays that meet nothing behind the leaves
    check_form(work, "grid", instrument="samples = { grid = [5, 4] }\npsf = { sigma_px = 0.5, support_px = 4.0 }")
    check_form(work, "chunks", instrument="samples = { jittered = [40, 40] }")
    errors = layers(work, "errors", instrument='samples = { lattice = 64, first = 8 }\nstandard_error = "worst"')
    shares = sum(errors[f"opaque_abundance_{name}"] for name in ("soil", "roof"))
    check(numpy.allclose(shares, errors["hit_fraction"], atol=1e-6) and numpy.isfinite(errors["standard_error"]).all())
    chosen = layers(work, "chosen", instrument='small_objects = "on"', head="tolerance = 0.02")
    shares = sum(chosen[f"opaque_abundance_{name}"] for name in ("soil", "roof"))
    check(numpy.allclose(shares, 1, atol=1e-6), numpy.abs(shares - 1).max())
    check(((chosen["transparent_material_id"] > 0) == (chosen["abundance_leaf"] + chosen["abundance_film"] > 0)).all())
    once, again = layers(work, "lattice", "--overwrite"), layers(work, "little", "--memory", "30M", "--threads", 1)
    for name in once:
        check(numpy.array_equal(once[name], again[name], equal_nan=True), name, "of little memory")
    print(f"first opaque: {program.checks} checks hold")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        main(pathlib.Path(folder))
