#!/usr/bin/env python3
"""A scene of input nobody here wrote: terrain of Heidelberg (SRTM, 25 m posts), a scanned tree, measured spectra, all
from the folder RAYCUBE_SHARED. Geometry: relief of 90 to 581 m, 25 trees. Light: sun at 40 degrees, with and without
air. Sensors: a camera from 3000 m at 25 m, one from 300 m at 1 m. Expected: heights of the very DEM, radiance of closed
form without air. usage: real_input_test.py RAYCUBE"""

import os
import pathlib
import sys
import tempfile

import numpy
from driver import Program, envi

shared = pathlib.Path(os.environ.get("RAYCUBE_SHARED") or "/nonexistent")
if not shared.is_dir():
    print("SKIPPED rendering of real input: RAYCUBE_SHARED does not name a folder of real input")
    sys.exit(77)
program = Program(sys.argv[1])
check = program.check
data = shared / "data"
kCenters_nm = 450.0 + 70.0 * numpy.arange(8)
kFwhm_nm = 20.0
kOrigin = (478522.0, 5474600.0)  # the middle of the DEM
# Independent of our readers: the same DEM as ASCII posts, the upper left post 12.5 m in from the corner.
posts = numpy.loadtxt(data / "dem" / "heidelberg_dem_256.asc", skiprows=6)
kFirstPost = (475322.625829136 + 12.5, 5477800.390295740 - 12.5)


def scene_text(air):
    return f"""format = 1
bounces = 0
scene = {{ origin = {{ epsg = 32632, easting_m = {kOrigin[0]}, northing_m = {kOrigin[1]} }} }}
tolerance = 0.02
material = [
  {{ name = "grass", file = "{data}/spectra/usgs_lawn_grass_green.csv" }},
  {{ name = "bark", file = "{data}/spectra/helios_bark_elm.csv" }},
]
terrain = [{{ raster = "{data}/dem/heidelberg_dem_256_float32.tif", material = "grass" }}]
mesh = [{{ name = "tree", file = "{data}/meshes/helios_tree1.obj", material = "bark", unit_m = 6.0 }}]
scatter = [{{ mesh = "tree", positions = "trees.csv", on_terrain = true }}]
atmosphere = {air}
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 150.0 }} }}
""" + "".join(
        f"""[[instrument]]
name = "{name}"
kind = "framing"
altitude_agl_m = {height}
gsd_m = {gsd}
pixels = 32
lines = 24
samples = {{ grid = [8, 8] }}
bands = {{ first_nm = {kCenters_nm[0]}, step_nm = 70.0, count = 8, fwhm_nm = {kFwhm_nm} }}
""" for name, height, gsd in (("wide", 3000.0, 25.0), ("close", 300.0, 1.0))
    )


def curve(file, scale):
    """(wavelength in nm, value) of the first two columns."""
    rows = numpy.loadtxt(
        file, delimiter=",", skiprows=1 + sum(line.startswith("#") for line in open(file)), usecols=(0, 1)
    )
    return lambda nm: numpy.interp(nm, rows[:, 0] * scale, rows[:, 1])


def band_mean(value):
    """Gaussian band means by fine quadrature."""
    out = []
    for center in kCenters_nm:
        fine = numpy.linspace(center - 2.5 * kFwhm_nm, center + 2.5 * kFwhm_nm, 4001)
        weight = numpy.exp(-4 * numpy.log(2) * ((fine - center) / kFwhm_nm) ** 2)
        out.append((weight * value(fine)).sum() / weight.sum())
    return numpy.array(out)


def dem_at(easting, northing):
    """Height between the posts, bilinear, and how far any surface through the posts may differ: half the largest second
    difference (twist and curvature) of the posts around."""
    x, y = (easting - kFirstPost[0]) / 25, (kFirstPost[1] - northing) / 25
    i, j = numpy.floor(y).astype(int), numpy.floor(x).astype(int)
    v, u = y - i, x - j
    height = (1 - v) * ((1 - u) * posts[i, j] + u * posts[i, j + 1]) + v * (
        (1 - u) * posts[i + 1, j] + u * posts[i + 1, j + 1]
    )
    near = numpy.stack([posts[i + a, j + b] for a in range(-1, 3) for b in range(-1, 3)], axis=-1).reshape(
        *x.shape, 4, 4
    )
    second = numpy.maximum.reduce(
        [
            numpy.abs(numpy.diff(near, 2, axis=-1)).max((-1, -2)),
            numpy.abs(numpy.diff(near, 2, axis=-2)).max((-1, -2)),
            numpy.abs(numpy.diff(numpy.diff(near, axis=-1), axis=-2)).max((-1, -2)),
        ]
    )
    return height, second / 2 + 1e-3


sun = curve(data / "solar" / "tsis1_hsrs_0p5nm.csv", 1)  # mW m-2 nm-1 = W m-2 um-1
grass = curve(data / "spectra" / "usgs_lawn_grass_green.csv", 1000)
irradiance = band_mean(sun)
reflected = band_mean(lambda nm: grass(nm) * sun(nm))

with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    rows = [f"{-12 + 6 * (k % 5)},{-12 + 6 * (k // 5)},{40 * k % 360},{0.7 + 0.02 * k}" for k in range(25)]
    (work / "trees.csv").write_text("x_m,y_m,yaw_deg,scale\n" + "\n".join(rows) + "\n")
    for air in ("none", "clear"):
        (work / f"{air}.toml").write_text(
            scene_text('{ model = "none" }' if air == "none" else '{ model = "clear_sky", aod_550 = 0.15 }')
        )
        program.run("render", work / f"{air}.toml", "-o", work / air)
        for name in ("wide", "close"):
            _, radiance = envi(work / air / name, "radiance")
            header, values = envi(work / air / name, "truth")
            truth = {text.split()[0]: values[:, :, i] for i, text in enumerate(header["band names"])}
            _, place = envi(work / air / name, "location")
            bare = truth["abundance_bark"] == 0
            check((truth["hit_fraction"] == 1).all() and numpy.isfinite(radiance).all() and radiance.max() > 0)

            # Where it looks: heights of the DEM's range (90 to 581 m; trees at most 19 m), the bare ground's of its
            # posts.
            top = 581 + 6.0 * 2.668 * 1.2
            check(
                place[:, :, 2].min() >= 90 and place[:, :, 2].max() <= top, place[:, :, 2].min(), place[:, :, 2].max()
            )
            height, bound = dem_at(place[:, :, 0], place[:, :, 1])
            off = numpy.abs(place[:, :, 2] - height)
            check((off[bare] <= bound[bare]).all(), air, name, (off - bound)[bare].max())
            if name == "close":  # straight below the camera, where relief does not shift a pixel: half a pixel each way
                middle = place[11:13, 15:17, :2].mean(axis=(0, 1))
                check(numpy.abs(middle - kOrigin).max() < 1.5, middle)
                check(truth["abundance_bark"].max() > 0.2 and bare.sum() > 100)

            # How bright: no Lambertian surface under this sun and sky outshines a white one that faces the sun in full
            # sun.
            check((radiance <= 1.05 * irradiance / numpy.pi).all(), (radiance / irradiance).max() * numpy.pi)
            if air == "clear":
                check((radiance > 0).all())
                lawn = radiance[bare].mean(axis=0)
                check(lawn[6] / irradiance[6] > 3 * lawn[3] / irradiance[3])  # the red edge: 870 nm against 660 nm
                continue
            # Without air bare ground has radiance = rho E0 C / pi, C the mean of cosine times visibility: the same in
            # every band. 0.1 %: our TSIS-1 is kept at 2 nm, this file has steps of 0.5 nm. Where the slope is the
            # neighbours' own, C is the cosine of the incidence itself.
            check((radiance[truth["sun_fraction"] == 0] == 0).all())
            lit = bare & (truth["sun_fraction"] > 0.5)
            ratio = radiance[lit] * numpy.pi / reflected
            spread = numpy.abs(ratio / ratio.mean(axis=1)[:, None] - 1).max()
            check(lit.sum() > 100 and spread < 0.001, lit.sum(), spread)
            print(
                f"{name}: spectra of {lit.sum()} bare pixels within {spread:.2%}, ground within {off[bare].max():.3f} "
                f"m of the "
                "posts' bilinear surface"
            )
            if name == "close":
                incidence = truth["sun_incidence_deg"]
                flat = bare[1:-1, 1:-1] & (truth["sun_fraction"][1:-1, 1:-1] == 1)
                for line, sample in ((0, 1), (2, 1), (1, 0), (1, 2)):
                    flat &= numpy.abs(incidence[line : line + 22, sample : sample + 30] - incidence[1:-1, 1:-1]) < 1e-3
                cosine = numpy.cos(numpy.radians(incidence[1:-1, 1:-1][flat]))
                ratio = radiance[1:-1, 1:-1][flat] * numpy.pi / (reflected * cosine[:, None])
                check(
                    flat.sum() >= 10 and numpy.abs(ratio - 1).max() < 0.001,
                    flat.sum(),
                    ratio.min(axis=0),
                    ratio.max(axis=0),
                )
                print(
                    f"close: radiance of {flat.sum()} pixels within {numpy.abs(ratio - 1).max():.2%} of rho E0 cos / pi"
                )
print(f"real input: {program.checks} checks")
