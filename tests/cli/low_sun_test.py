#!/usr/bin/env python3
"""A sun at the horizon, below it, and what no pixel may hold. Oracle: the table's own formula for a flat plane,
    L = L_path + rho / pi (T_view + T_dif) R2 (E_direct + E_sky) / (1 - rho S),
worked out here in double from the rows of the .rct at its lowest target and straight down; T_dif = S = 0 where the
model has none. usage: low_sun_test.py RAYCUBE"""

import json
import pathlib
import struct
import sys
import tempfile

import numpy

from driver import Program, envi, own_cache, record

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
kReflectance = 0.3


def rows_of(path):
    """Header and rows of a table, by docs/table_format.md."""
    data = pathlib.Path(path).read_bytes()
    length = struct.unpack("<Q", data[16:24])[0]
    header, start = json.loads(data[64 : 64 + length]), 64 + (length + 63) // 64 * 64
    rows = {
        r["name"]: numpy.frombuffer(data, "<f4", int(numpy.prod(r["shape"])), start + r["offset"])
        .astype(float)
        .reshape(r["shape"])
        for r in header["rows"]
    }
    return header, numpy.array({a["name"]: a["nodes"] for a in header["axes"]}["wavelength"]), rows


def flat_plane(path, centers_um, fwhm_um):
    """Band radiances by the formula; the plane lies at the table's lowest height, the camera looks straight down."""
    header, um, rows = rows_of(path)
    down = {name: row.reshape(len(um), -1)[:, 0] for name, row in rows.items()}
    sun, view = numpy.exp(-down["sun_optical_depth"]), numpy.exp(-down["view_optical_depth"])
    direct = down["solar_irradiance"] * numpy.cos(numpy.radians(header["sun_zenith_deg"])) * sun
    back, around = down.get("spherical_albedo", 0), down.get("diffuse_view_transmission", 0)
    ground = kReflectance / numpy.pi * (direct + down["diffuse_irradiance"]) / (1 - kReflectance * back)
    light = down["path_radiance_solar"] + down["two_way_factor"] * (view + around) * ground
    out = []
    for center in centers_um:
        fine = numpy.linspace(center - 2.5 * fwhm_um, center + 2.5 * fwhm_um, 4001)
        response = numpy.exp(-4 * numpy.log(2) * ((fine - center) / fwhm_um) ** 2)
        out.append((response * numpy.interp(fine, um, light)).sum() / response.sum())
    return numpy.array(out), down["solar_irradiance"].max()


def plane(
    folder,
    air,
    zenith,
    bands='{ first_nm = 440.0, step_nm = 40.0, count = 48, fwhm_nm = 20.0 }',
    name="camera",
    more="",
):
    path = folder / "plane.toml"
    path.write_text(f"""format = 1
material = [ {{ name = "grey", reflectance = {kReflectance}{', temperature_K = 300.0' if more else ''} }} ]
plane = [ {{ material = "grey", size_m = [400.0, 400.0] }} ]
atmosphere = {air}
time = {{ sun = {{ zenith_deg = {zenith}, azimuth_deg = 150.0 }} }}
[[instrument]]
name = "{name}"
kind = "framing"
altitude_agl_m = 1000.0
gsd_m = 1.0
pixels = 4
lines = 4
samples = {{ grid = [4, 4] }}
bands = {bands}
{more}""")
    return path


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    cache = {"XDG_CACHE_HOME": own_cache(work)}
    few = '{ first_nm = 440.0, step_nm = 40.0, count = 16, fwhm_nm = 20.0 }'  # of the model whose grid is 1 nm

    # Between 88 degrees and the horizon: 2 % of the formula, where a band has light to speak of (1e-4 of the brightest,
    # as the plan has it); the plan says no more than that of itself. The layered air knows the flux of its sky, and
    # shading takes that: what is left is linear reading between wavelengths, 0.03 %.
    clear, layered = '{ model = "clear_sky" }', '{ model = "layered", spectral_step_nm = 20.0 }'
    cases = [(clear, zenith, 16, 0.02) for zenith in (85, 88.5, 88.8, 89.5, 89.99)]
    cases += [(layered, 88.5, 16, 0.002), (layered, 89.5, 48, 0.002), (layered, 89.99, 16, 0.002)]
    for model, zenith, bands, bar in cases:
        file, out = plane(work, model, zenith, *([few] if bands == 16 else [])), work / "out"
        centers = 0.44 + 0.04 * numpy.arange(bands)
        run("atmos", "build", file, "-o", work / "air.rct", "--overwrite", env=cache)
        run("render", file, "-o", out, "--overwrite", env=cache)
        want, sun = flat_plane(work / "air.rct", centers, 0.02)
        found = envi(out / "camera", "radiance")[1].astype(float).reshape(16, -1)
        seen = want > 1e-4 * want.max()
        error = numpy.abs(found[:, seen] / want[seen] - 1).max()
        said = record(out / "camera")
        print(f"{model} {zenith}: worst band {error:.4f} of the formula")
        check(numpy.isfinite(found).all() and error < bar, model, zenith, error)
        check(said["radiance_bound"]["pixels_beyond"] == 0 and not said["warnings"], said["warnings"])
        claimed = said["plan"]["planner"]["error"]
        check(claimed["plan"] < 0.01, claimed)  # the file's tolerance, measured against the whole tables

    # While the disc is seen (to 90 deg 50'), the light of 89.99 deg, to the bit, and said.
    for model in (clear, layered):
        sunsets = []
        for zenith in (89.99, 90, 90.8):
            done = run("render", plane(work, model, zenith, few), "-o", work / "set", "--overwrite", env=cache)
            check(("the light of 89.99 deg is taken" in done.stderr) == (zenith >= 90), zenith, done.stderr)
            sunsets.append(envi(work / "set" / "camera", "radiance")[1])
        check(sunsets[0].min() > 0 and all((image == sunsets[0]).all() for image in sunsets), model)

    # A table that was built for such a scene, also between heights that are given, has that light and serves the scene;
    # one of a wide band is cut as the scene's check has it.
    heights = ("--lowest", "0", "--highest", "0")
    for model, more in ((clear, ()), (clear, heights)):
        file = plane(work, model, 90.3, few)
        done = run("atmos", "build", file, *more, "-o", work / "set.rct", "--overwrite", env=cache)
        check("the light of 89.99 deg is taken" in done.stderr, done.stderr)
        header, _, rows = rows_of(work / "set.rct")
        check(header["sun_zenith_deg"] == 89.99 and rows["diffuse_irradiance"].max() > 0, header["sun_zenith_deg"])
        done = run("scene", "check", plane(work, f'{{ tables = "{work / "set.rct"}" }}', 90.3, few))
        check("the light of 89.99 deg is taken" in done.stderr, done.stderr)
    pan = plane(work, clear, 60, '{ first_nm = 650.0, step_nm = 10.0, count = 1, fwhm_nm = 200.0 }')
    done = run("atmos", "build", pan, *heights, "-o", work / "set.rct", "--overwrite", env=cache)
    check("cut to what the atmosphere covers" in done.stderr, done.stderr)
    run("atmos", "build", "--model", "clear_sky", "--sun-zenith", "90.3", "-o", work / "set.rct", "--overwrite")
    check(rows_of(work / "set.rct")[0]["sun_zenith_deg"] == 89.99)

    # Below the horizon: dark, and said; at night too.
    for model in (clear, layered):
        for zenith in (91, 95, 110) if model == clear else (91, 110):
            done = run("render", plane(work, model, zenith, few), "-o", work / "dark", "--overwrite", env=cache)
            check("no twilight" in done.stderr, done.stderr)
            check(any("no twilight" in warning for warning in record(work / "dark" / "camera")["warnings"]))
            check((envi(work / "dark" / "camera", "radiance")[1] == 0).all(), model, zenith)

    # Thermal light knows no hour: bit for bit that of deep night, and of a body of 300 K but for the air.
    thermal = '{ first_nm = 9000.0, step_nm = 1000.0, count = 3, fwhm_nm = 400.0 }'
    images = []
    for zenith in (95, 120):
        file = plane(
            work,
            '{ model = "layered", spectral_step_nm = 100.0 }',
            zenith,
            thermal,
            more='[thermal]\ndefault_temperature_K = 300.0\n',
        )
        done = run("render", file, "-o", work / "warm", "--overwrite", env=cache)
        check("twilight" not in done.stderr, done.stderr)
        images.append(envi(work / "warm" / "camera", "radiance")[1])
    check((images[0] == images[1]).all() and images[0].min() > 5 and images[0].max() < 10.2, images[0])

    # White ground under a high sun lights itself by way of the air: brighter than E0 / pi, and right.
    white = plane(
        work,
        '{ model = "layered", aerosol = "rural", visibility_km = 23.0, spectral_step_nm = 20.0 }',
        0,
        '{ first_nm = 400.0, step_nm = 20.0, count = 3, fwhm_nm = 10.0 }',
    )
    white.write_text(
        white.read_text()
        .replace(f"reflectance = {kReflectance}", "reflectance = 0.98")
        .replace("altitude_agl_m = 1000.0", "altitude_agl_m = 50.0")
        .replace("400.0, 400.0", "4000.0, 4000.0")
    )
    run("render", white, "-o", work / "white", env=cache)
    check(
        record(work / "white" / "camera")["radiance_bound"]["pixels_beyond"] == 0,
        record(work / "white" / "camera")["radiance_bound"],
    )

    # A panchromatic band: its Gaussian (650 nm, FWHM 200 nm, to 2.5 FWHM from 150 nm on) is cut at 300 nm, where the
    # sun's spectrum begins, which takes 2e-5 of it. Oracle: the mean of the table's irradiance over the Gaussian above,
    # summed here. Half as wide again is refused, with the share that a cut would lose: erfc(1.943) / 2 = 3.0e-3.
    wide = '{ first_nm = 650.0, step_nm = 10.0, count = 1, fwhm_nm = FWHM }'
    vacuum = plane(work, '{ model = "none" }', 60, wide.replace("FWHM", "200.0"))
    done = run("render", vacuum, "-o", work / "wide", env=cache)
    check("cut to what the atmosphere covers (band 1: 300 to 1150 nm, 2e-05" in done.stderr, done.stderr)
    run("atmos", "build", vacuum, "-o", work / "none.rct", env=cache)
    _, um, rows = rows_of(work / "none.rct")
    fine = numpy.linspace(0.3, 1.15, 85001)
    response = numpy.exp(-4 * numpy.log(2) * ((fine - 0.65) / 0.2) ** 2)
    irradiance = numpy.interp(fine, um, rows["solar_irradiance"].reshape(len(um), -1)[:, 0])
    want = kReflectance / numpy.pi * 0.5 * (response * irradiance).sum() / response.sum()
    found = envi(work / "wide" / "camera", "radiance")[1]
    check(numpy.abs(found / want - 1).max() < 2e-5, found, want)  # single precision, and the plan's 1e-5 of nodes
    for verb in (["scene", "check"], ["render", "--dry-run"]):
        refused(
            *verb,
            plane(work, '{ model = "none" }', 60, wide.replace("FWHM", "300.0")),
            status=2,
            says=["0.003 of its weight", "covers 0.3 to 1000.0 um"],
            messages=2,
            env=cache,
        )

    # What a table may not make of a cube. E0 = 1000, both transmissions 1, no path: R2 = 20 is light from nowhere.
    def tabled(e0, factor):
        csv = work / "made.csv"
        csv.write_text(
            "wavelength [um],solar_irradiance [W m-2 um-1],sun_transmission [1],view_transmission [1],two_way_factor "
            "[1],"
            "path_radiance_solar [W m-2 sr-1 um-1],sky_radiance_solar [W m-2 sr-1 um-1]\n"
            + "".join(f"{um},{e0},1,1,{factor},0,0\n" for um in (0.4, 0.5, 0.6))
        )
        run(
            "atmos",
            "import",
            csv,
            "--sun-zenith",
            "60",
            "--sun-azimuth",
            "150",
            "--sensor-height",
            "1000",
            "-o",
            work / "made.rct",
            "--overwrite",
        )
        return plane(
            work,
            f'{{ tables = "{work / "made.rct"}" }}',
            60,
            '{ first_nm = 480.0, step_nm = 20.0, count = 2, fwhm_nm = 8.0 }',
        )

    out = work / "bright"
    done = run("render", tabled("1000", "20"), "-o", out, env=cache)
    ratio = kReflectance * 0.5 * 20  # rho E0 cos 60 R2 / pi over E0 / pi
    said = record(out / "camera")
    check("16 of 16 pixels are brighter" in done.stderr, done.stderr)
    check(
        said["radiance_bound"]["pixels_beyond"] == 16 and abs(said["radiance_bound"]["worst_ratio"] / ratio - 1) < 1e-4,
        said["radiance_bound"],
    )
    check(any("brighter" in warning for warning in said["warnings"]))
    run("render", tabled("1000", "1"), "-o", out, "--overwrite", env=cache)
    check(record(out / "camera")["radiance_bound"]["pixels_beyond"] == 0)
    # Beyond single precision: refused, with nothing under its final name.
    none = work / "none"
    refused(
        "render",
        tabled("1e38", "1e10"),
        "-o",
        none,
        status=70,
        env=cache,
        says=["instrument 'camera'", "pixel 0 of line 0", "band 1 (0.48 um)", "no number", "nothing is published"],
    )
    check(not none.exists(), list(none.rglob("*")))  # what the run made and left empty is gone, too
print(f"{program.checks} checks")
