"""S26 truth per band (`band_truth`) and the layers of truth.img that go with it. Oracles: without air radiance is
reflectance times irradiance over pi, and irradiance goes with the cosine of incidence; abundances times curves are the
reflectance; emitted light goes with emissivity and with Planck's law; the parts' sum is the radiance, whose bits do not
know of them, in every form that a cube is rendered in; `explain` tells a pixel's parts by another way.
usage: band_truth_test.py RAYCUBE [--full]. Without --full: not the forms whose samples alone differ from another's."""

import json
import pathlib
import sys
import tempfile

import numpy

from driver import FULL, Program, envi, record

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

ROUNDING = 2e-5  # float sums of a few hundred terms, rows of the skeleton among them that cancel
PARTS = "path ground_around sun sky thermal_sky surroundings emission between_surfaces".split()
SUN_DEG = 40.0

# Soil, a tilted roof, a leaf plate and a box that shades; three camera pixels to each side of everything.
WORLD = """format = 1
seed = 3
tolerance = {tolerance}
{head}
material = [
  {{ name = "soil", reflectance = 0.20, temperature_K = 300.0 }},
  {{ name = "roof", reflectance = 0.50, temperature_K = 300.0 }},
  {{ name = "cool", reflectance = 0.20, temperature_K = 280.0 }},
  {{ name = "leaf", reflectance = 0.40, transmittance = 0.35, temperature_K = 300.0 }},
  {more}
]
plane = [
  {{ material = "soil", size_m = [300.0, 300.0] }},
  {{ material = "roof", position_m = [-8.0, 4.0, 3.0], size_m = [5.0, 4.0], yaw_deg = 150.0, tilt_deg = 30.0 }},
  {{ material = "cool", position_m = [8.0, 4.0, 0.01], size_m = [5.0, 4.0] }},
  {{ material = "leaf", position_m = [8.0, -5.0, 1.0], size_m = [4.0, 4.0] }},
  {plane}
]
box = [{{ material = "cool", position_m = [-6.0, -5.0, 0.0], size_m = [4.0, 4.0, 4.0] }}]
atmosphere = {air}
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 150.0, day_of_year = 200 }} }}
[[instrument]]
name = "camera"
kind = "framing"
pixels = 26
lines = 17
altitude_agl_m = 300.0
gsd_m = 1.0
{samples}
bands = {{ {bands} }}
{instrument}
"""
VISIBLE = "first_nm = 450.0, step_nm = 110.0, count = 10, fwhm_nm = 20.0"
LONGWAVE = "first_nm = 9000.0, step_nm = 500.0, count = 4, fwhm_nm = 100.0"
DEFAULTS = dict(
    tolerance=0.02,
    head="bounces = 0\nsky_directions = 16",
    more="",
    plane="",
    air='{ model = "none" }',
    samples="samples = { grid = [3, 3] }",
    bands=VISIBLE,
    instrument="",
)
ALL = 'band_truth = ["parts", "irradiance", "reflectance", "emissivity", "transmission"]'


def written(work, name, **values):
    file = work / f"{name}.toml"
    file.write_text(WORLD.format(**{**DEFAULTS, **values}))
    return file


class Cube:
    """A rendered cube with its truth."""

    def __init__(self, folder):
        self.folder = folder
        self.radiance = self.read("radiance")
        header, layers = envi(folder, "truth")
        names = [name.partition(" [")[0] for name in header["band names"]]
        self.layers = {name: layers[..., i].astype(float) for i, name in enumerate(names)}
        there = [name for name in PARTS if (folder / f"radiance_{name}.img").exists()]
        self.parts = {name: self.read(f"radiance_{name}") for name in there}

    def read(self, name):
        return envi(self.folder, name)[1].astype(float)

    def pure(self, material):
        return self.layers[f"abundance_{material}"] == 1

    def check_sum(self):
        apart = numpy.abs(sum(self.parts.values()) / self.radiance - 1).max()
        check(apart < ROUNDING, self.folder, apart)


def rendered(work, name, *options, **values):
    file = written(work, name, **{"instrument": ALL, **values})
    run("render", file, "-o", work / name, "-q", *options)
    return Cube(work / name / "camera")


def check_without_air(work):
    """Sunlight alone, scattered once by Lambert surfaces."""
    cube = rendered(work, "vacuum")
    check(set(cube.parts) == {"path", "sun"}, cube.parts.keys())
    check(not cube.parts["path"].any() and numpy.array_equal(cube.parts["sun"], cube.radiance))
    irradiance, reflectance, layers = cube.read("irradiance"), cube.read("reflectance"), cube.layers
    for material, value in (("soil", 0.20), ("roof", 0.50), ("cool", 0.20)):
        here = cube.pure(material)
        check(here.sum() > 3, material, here.sum())
        check(numpy.allclose(reflectance[here], value, rtol=1e-6), material)
        check(numpy.allclose(numpy.pi * cube.radiance[here], value * irradiance[here], rtol=1e-6), material)
    lit = cube.pure("soil") & (layers["sun_fraction"] == 1)
    level = irradiance[lit][0]
    check(numpy.allclose(irradiance[lit], level, rtol=1e-6) and level[0] > 1000, level)
    roof = cube.pure("roof")
    cosine = numpy.cos(numpy.radians(layers["sun_incidence_deg"][roof]))[:, None]
    check(numpy.allclose(cosine, numpy.cos(numpy.radians(SUN_DEG - 30.0)), rtol=1e-5), cosine)
    check(numpy.allclose(irradiance[roof] / level, cosine / numpy.cos(numpy.radians(SUN_DEG)), rtol=1e-5))
    dark = cube.pure("soil") & (layers["sun_fraction"] == 0)
    check(dark.sum() > 2 and not irradiance[dark].any() and not cube.radiance[dark].any(), dark.sum())
    mixed = layers["abundance_roof"] * layers["abundance_soil"] > 0
    check(mixed.sum() > 5)
    curves = {"soil": 0.20, "roof": 0.50, "cool": 0.20, "leaf": 0.40}
    means = sum(value * layers[f"abundance_{name}"] for name, value in curves.items())
    check(numpy.allclose(reflectance, means[..., None], rtol=1e-6))
    through = 0.35 * layers["abundance_leaf"]
    check(numpy.allclose(cube.read("emissivity"), (1 - means - through)[..., None], rtol=1e-6))
    check((cube.read("transmission") == 1).all())
    return cube


def check_angles(cube):
    """Between the surface and the way to the sensor, and temperatures."""
    layers = cube.layers
    soil, roof = cube.pure("soil"), cube.pure("roof")
    seen = numpy.cos(numpy.radians(layers["view_incidence_deg"]))  # a mean over the pixel, which spans 0.2 degrees
    check(numpy.allclose(seen[soil], numpy.cos(numpy.radians(layers["view_zenith_deg"][soil])), atol=3e-6))
    zenith, azimuth = (numpy.radians(layers[f"view_{name}_deg"][roof]) for name in ("zenith", "azimuth"))
    # a normal 30 degrees from the zenith towards 150
    cosine = numpy.cos(zenith) * numpy.cos(numpy.pi / 6) + numpy.sin(zenith) * numpy.sin(numpy.pi / 6) * numpy.cos(
        azimuth - numpy.radians(150.0)
    )
    check(numpy.allclose(seen[roof], cosine, atol=3e-6))
    warm = 300.0 - 20.0 * layers["abundance_cool"]
    check(numpy.allclose(layers["temperature_K"], warm, rtol=1e-6) and (layers["temperature_K"] < 299).any())


def check_in_air(work):
    """What falls onto open ground, times its reflectance and what the air lets through, is what comes of it, where
    gases do not make a band's average of products differ from the product of averages."""
    cube = rendered(work, "air", air='{ model = "clear_sky", adjacency = "off" }')
    check(set(cube.parts) == {"path", "sun", "sky"}, cube.parts.keys())
    cube.check_sum()
    open_ground = cube.pure("soil") & (cube.layers["sun_fraction"] == 1)
    irradiance, transmission = cube.read("irradiance")[open_ground], cube.read("transmission")[open_ground]
    seen = (cube.parts["sun"] + cube.parts["sky"])[open_ground]
    # away from objects the sky is open: the median pixel
    ratio = numpy.median(numpy.pi * seen / (0.20 * irradiance * transmission), axis=0)
    check(numpy.allclose(ratio[:3], 1, atol=2e-3), ratio)  # 450, 560, 670 nm; further on lie bands of water
    shaded = cube.pure("soil") & (cube.layers["sun_fraction"] == 0)
    dim = cube.read("irradiance")[shaded]  # of 16 rays a pixel: noise may be negative where the sky is nearly closed
    check(not cube.parts["sun"][shaded].any(), "sunlight in the shade")
    check((dim.mean(0) > 0).all() and (dim.mean(0) < 0.5 * irradiance.mean(0)).all(), dim.mean(0))


def check_heat(work):
    """Emission goes by emissivity at one temperature, and by Planck's law at one emissivity."""
    cube = rendered(work, "heat", bands=LONGWAVE, air='{ model = "layered", spectral_step_nm = 20.0 }')
    check({"path", "thermal_sky", "surroundings", "emission"} <= set(cube.parts) <= set(PARTS), cube.parts.keys())
    cube.check_sum()
    told = record(cube.folder)["warnings"]
    check(any("sunlight" in line and "irradiance" in line for line in told) != ("sun" in cube.parts), told)
    emission, emissivity = cube.parts["emission"], cube.read("emissivity")
    of = {name: numpy.median(emission[cube.pure(name)], axis=0) for name in ("soil", "roof", "cool", "leaf")}
    check(numpy.allclose(of["roof"] / of["soil"], 0.50 / 0.80, rtol=2e-3), of)  # heights of 3 m apart
    check(numpy.allclose(of["leaf"] / of["soil"], 0.25 / 0.80, rtol=2e-3), of)
    check(numpy.allclose(emissivity[cube.pure("leaf")], 0.25, rtol=1e-6))
    um = 9.0 + 0.5 * numpy.arange(4)
    law = numpy.expm1(14387.76877 / (um * 300.0)) / numpy.expm1(14387.76877 / (um * 280.0))
    check(numpy.allclose(of["cool"] / of["soil"], law, rtol=2e-3), of["cool"] / of["soil"], law)


MANY = "".join(f'{{ name = "m{i}", reflectance = {0.01 + 0.003 * i:.3f}, temperature_K = 300.0 }},' for i in range(300))
STRIPES = "".join(
    f'{{ material = "m{i}", position_m = [{0.05 + 0.003 * i:.3f}, 0.0, 0.5], size_m = [0.003, 6.0] }},'
    for i in range(300)
)
AIR = '{ model = "clear_sky" }'
FORMS = {
    "lattice": dict(samples="samples = { lattice = 34 }"),
    "bounces": dict(head="bounces = 3\nsky_directions = 40"),
    "chosen": dict(head="", samples=""),
    "small": dict(samples="samples = { lattice = 8 }", small='small_objects = "on"'),
    "chunks": dict(samples="samples = { jittered = [40, 40] }"),
    "adaptive": dict(samples="samples = { lattice = 64, first = 8 }"),
    "errors": dict(samples="samples = { jittered = [6, 6] }", small='standard_error = "bands"'),
    "spread": dict(samples="samples = { jittered = [4, 4] }", small="psf = { sigma_px = 0.6, support_px = 5.0 }"),
    "integers": dict(small='integer_scale = 100.0\ninterleave = "bsq"'),
    "rough": dict(more='{ name = "rough", reflectance = 0.3, oren_nayar = { sigma_deg = 25.0 } },',
                  plane='{ material = "rough", position_m = [0.0, 0.0, 0.1], size_m = [3.0, 3.0] },'),
    "gloss": dict(more='{ name = "wet", reflectance = 0.1, gloss = { roughness = 0.2, f0 = 0.05 } },',
                  plane='{ material = "wet", position_m = [0.0, 0.0, 0.1], size_m = [3.0, 3.0] },'),
    "overflow": dict(more=MANY, plane=STRIPES, samples="samples = { grid = [24, 24] }"),
    "hosted": dict(more=MANY, plane=STRIPES, samples="samples = { jittered = [32, 32] }"),
    "around": dict(
        air='{ model = "layered", spectral_step_nm = 20.0, adjacency = "local" }',
        bands="first_nm = 500.0, step_nm = 100.0, count = 3, fwhm_nm = 40.0",
    ),
}
#: Forms that go by their samples through what another one goes through as well.
ALIKE = () if FULL else ("chosen", "small", "chunks", "errors", "spread")


def white_sky_rough(sigma_deg):
    """White-sky albedo over the curve of Oren & Nayar's surface in Fujii's form (2012), by midpoints."""
    s2 = numpy.radians(sigma_deg) ** 2
    b = 0.45 * s2 / (s2 + 0.09) / (1 - 0.5 * s2 / (s2 + 0.33))
    a = 1 / (1 + (0.5 - 2 / (3 * numpy.pi)) * b)
    cosines = numpy.sqrt((numpy.arange(120) + 0.5) / 120)
    c_in, c_out, turn = numpy.meshgrid(cosines, cosines, (numpy.arange(120) + 0.5) / 120 * numpy.pi, indexing="ij")
    s = numpy.sqrt((1 - c_in**2) * (1 - c_out**2)) * numpy.cos(turn)
    t = numpy.where(s > 0, numpy.maximum(c_in, c_out), 1.0)
    return (a * (1 + b * s / t)).mean()


def white_sky_gloss(alpha, f0):
    """Share of an even light that a GGX gloss with Schlick's term sends back, by facets drawn evenly of its law (Walter
    et al. 2007) and masking joined by azimuth (Heitz 2014), as docs/light.md has it."""
    rng = numpy.random.default_rng(5)
    n = 400_000
    cos_i = numpy.sqrt(rng.random(n))
    light = numpy.stack([numpy.sqrt(1 - cos_i**2), numpy.zeros(n), cos_i])
    u, phi = rng.random(n), 2 * numpy.pi * rng.random(n)
    tan2 = alpha**2 * u / (1 - u)
    cos_h = 1 / numpy.sqrt(1 + tan2)
    sin_h = numpy.sqrt(tan2) * cos_h
    half = numpy.stack([sin_h * numpy.cos(phi), sin_h * numpy.sin(phi), cos_h])
    turn = (light * half).sum(0)
    out = 2 * turn * half - light
    seen = (out[2] > 1e-4) & (turn > 0)
    smith = [(numpy.sqrt(1 + alpha**2 * (1 / c**2 - 1)) - 1) / 2 for c in (cos_i[seen], out[2][seen])]
    azimuth = numpy.abs(numpy.arctan2(out[1][seen], out[0][seen]))
    join = 4.41 * azimuth / (4.41 * azimuth + 1)
    masking = 1 / (1 + numpy.maximum(*smith) + join * numpy.minimum(*smith))
    fresnel = f0 + (1 - f0) * (1 - turn[seen]) ** 5
    return (fresnel * masking * turn[seen] / (cos_i[seen] * cos_h[seen])).sum() / n


BEYOND = {
    "rough": ("rough", 0.3 * (white_sky_rough(25.0) - 1), 1e-4),
    "gloss": ("wet", white_sky_gloss(0.2, 0.05), 2e-3),
}


def check_form(work, name, values):
    """The parts sum to the radiance; the radiance has the bits that it has without them."""
    values = {"air": AIR, **values}
    more = values.pop("small", "")
    cube = rendered(work, name, **{**values, "instrument": more + "\n" + ALL})
    alone = work / f"{name}_alone"
    run("render", written(work, alone.name, **{**values, "instrument": more}), "-o", alone, "-q")
    for file in ("radiance.img", "truth.img", "standard_error.img"):
        if (alone / "camera" / file).exists():
            same = (alone / "camera" / file).read_bytes() == (cube.folder / file).read_bytes()
            check(same, name, file, "has other bits with truth per band")
    files = set(record(cube.folder)["files"])
    check({f"radiance_{part}.img" for part in cube.parts} | {"irradiance.img", "transmission.img"} <= files, files)
    if name == "integers":
        cube.radiance /= 100.0
        whole = numpy.maximum(sum(cube.parts.values()), 0)  # negative noise in the shade is clipped
        check(numpy.abs(whole - cube.radiance).max() < 0.00501, numpy.abs(whole - cube.radiance).max())
    else:
        cube.check_sum()
    emissivity, reflectance = cube.read("emissivity"), cube.read("reflectance")
    through = 0.35 * cube.layers["abundance_leaf"] / cube.layers["hit_fraction"]
    lacking = 1 - emissivity - reflectance - through[..., None]
    if name not in BEYOND:
        check(numpy.allclose(lacking, 0, atol=1e-5), name)
        return cube
    # Of an even light what a lobe sends back beyond its curve: none where there is no such matter, else by its share.
    material, beyond, tolerance = BEYOND[name]
    share = cube.layers[f"abundance_{material}"] / cube.layers["hit_fraction"]
    check(numpy.any(share > 0.9), name)
    check(numpy.allclose(lacking, beyond * share[..., None], atol=1e-5 + tolerance), name, lacking[share > 0.9].mean())
    return cube


def check_more_of_forms(work, cubes):
    check("between_surfaces" in cubes["bounces"].parts and cubes["bounces"].parts["between_surfaces"].mean() > 0)
    check("ground_around" in cubes["around"].parts and cubes["around"].parts["ground_around"].mean() > 0)
    over, hosted = (record(cubes[name].folder)["rows"] for name in ("overflow", "hosted"))
    check(over["overflow_pixels"] > 0 and hosted["per_sample_pixels"] > 0, over, hosted)
    file = work / "lattice.toml"
    run("render", file, "-o", work / "little", "-q", "--memory", "40M", "--threads", 1)
    for path in sorted(cubes["lattice"].folder.glob("*.img")):
        check(path.read_bytes() == (work / "little" / "camera" / path.name).read_bytes(), path.name, "of little memory")


def check_against_explain(work, cube):
    for line, sample in ((8, 13), (4, 5), (12, 7)):
        told = json.loads(run("explain", work / "bounces.toml", "--pixel", f"{sample},{line}", "--json").stdout)
        for part, values in cube.parts.items():
            light = sum(numpy.array(x["radiance"]) for x in told["light"] if x["kind"] == part)
            check(numpy.allclose(values[line, sample], light, rtol=1e-5, atol=1e-6 * cube.radiance.max()), part)


def check_refusals(work):
    file = written(work, "wrong", instrument='band_truth = ["sunn"]')
    refused("render", file, "-o", work / "wrong", status=2, says=["band_truth", "sunn", "between_surfaces"])
    file = written(work, "wrong", instrument='band_truth = "parts"')
    refused("render", file, "-o", work / "wrong", status=2, says=["band_truth", "a list of parts, path"])
    check(not (work / "wrong").exists())


def main(work):
    check_angles(check_without_air(work))
    check_in_air(work)
    check_heat(work)
    cubes = {name: check_form(work, name, values) for name, values in FORMS.items() if name not in ALIKE}
    check_more_of_forms(work, cubes)
    check_against_explain(work, cubes["bounces"])
    check_refusals(work)
    print(f"band truth: {program.checks} checks hold")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        main(pathlib.Path(folder))
