"""S20 S4.9: other codes' runs become a render table, and a scene is rendered with it.
Usage: atmos_table_test.py RAYCUBE

The runs are written here in MODTRAN's tape7 columns from an air stated in closed form: L(r) = L0 + r (T_dir + T_dif) E
/ pi / (1 - r S), a sky of one radiance. Oracle: that closed form again. Tolerances are the printed digits: REF_SOL has
three, radiances five.
"""

import json
import math
import os
import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi, options, scene

program = Program(sys.argv[1])
E0, MU0, T_SUN, T_VIEW, L0, SKY, S, T_DIF = 1500.0, math.cos(math.radians(40)), 0.6, 0.8, 20.0, 60.0, 0.2, 0.1
JOINED = 0.5  # sun to target to sensor: more than T_SUN T_VIEW
DIRECT = E0 * MU0 * JOINED / T_VIEW  # what the ground gets, as the path to the sensor sees it
TOTAL = DIRECT + math.pi * SKY
HEADER = (
    "    FREQ  TOT_TRANS  PTH_THRML  THRML_SCT  SURF_EMIS   SOL_SCAT  SING_SCAT  GRND_RFLT  DRCT_RFLT  TOTAL_RAD  "
    "REF_SOL  SOL@OBS   DEPTH"
    " DIR_EM    TOA_SUN BBODY_T[K]\n"
)
FREQUENCIES = range(8000, 26001, 600)


def cards(itype, iemsct, high, low, angle, azimuth):
    """H1, H2 in km; sun 40 deg, at PARM1 = azimuth from the line of sight."""
    return (
        f"T F 2    {itype}    {iemsct}    1    2    2    2    2    2    2    1    0    0 300.000   0.30\n"
        "    1    1    1    0    0    0  23.00000   0.00000   0.00000   0.00000   0.00000\n"
        "   36MID-LATITUDE SUMMER\n"
        f"{high:10.5f}{low:10.5f}{angle:10.5f}   0.50000   0.00000   0.00000    0        0.00000\n"
        "    2    2    1    0\n"
        f"{azimuth:10.5f}  40.00000   0.00000   0.00000  12.00000   0.00000   0.00000   0.00000\n"
        f"{FREQUENCIES[0]:10.1f}{FREQUENCIES[-1]:10.1f}     600.0     600.0NW              \n"
        "    0   0    0.000  0    0.000  0    0.700\n"
    )


def radiance_run(head, transmission, path, reflected=0.0, direct=0.0, albedo=0.0):
    text = head + HEADER
    for v in FREQUENCIES:
        um = 1e4 / v
        per_cm = um * um * 1e-8  # W m-2 um-1 to W cm-2 (cm-1)-1
        e = lambda x: f"{x * per_cm:.4E}"
        total = float(e(path)) + float(e(reflected))
        text += (
            f"{v:8.2f}{transmission:11.8f}"
            + "".join(
                f"{x:>11}" for x in (e(0), e(0), e(0), e(path), e(path / 2), e(reflected), e(direct), f"{total:.4E}")
            )
            + f"{E0 * JOINED * per_cm:9.2E}{E0 * T_SUN * per_cm:9.2E}{-math.log(transmission):8.3f}"
            + f"{1 - albedo:7.4f}{e(E0):>11}{290:11.3f}\n"
        )
    return text + " -9999.\n"


def down(albedo=0.0, angle=180.0):
    seen = albedo / math.pi / (1 - albedo * S) * TOTAL
    return radiance_run(
        cards(2, 2, 0.5, 0, angle, 90), T_VIEW, L0 + seen * T_DIF, seen * T_VIEW, seen * T_VIEW * DIRECT / TOTAL, albedo
    )


def sky(zenith, azimuth, radiance=SKY):
    return radiance_run(cards(3, 2, 0, 0, zenith, azimuth), 0.7, radiance)


def sun():
    rows = "".join(
        f"{v:8.2f}{T_SUN:8.4f}{E0 * T_SUN * 1e8 / v / v * 1e-8:9.2E}{E0 * 1e8 / v / v * 1e-8:9.2E}"
        f"{-math.log(T_SUN):15.3E}\n"
        for v in FREQUENCIES
    )
    return cards(3, 3, 0, 0, 40, 0) + "    FREQ   TRANS     SOL TR  SOLAR\n" + rows + " -9999.\n"


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)

    def write(file, *runs):
        (folder / file).write_text("".join(runs))
        return folder / file

    def rows_of(table):
        info = json.loads(program.run("atmos", "info", table, "--json").stdout)
        return {row["name"]: row for row in info["rows"]}, info

    def flat(row, value, within):
        program.check(
            abs(row["least"] - value) <= within * value and abs(row["most"] - value) <= within * value, row, value
        )

    skies = [sky(0, 0)] + [sky(z, a) for z in (60, 90) for a in (0, 90, 180)]

    # One path down and a sky, in two files: the least a render of sunlight needs.
    paths, ups = write("down.tp7", down()), write("sky.tp7", *skies)
    said = program.run("atmos", "import", paths, ups, "--sun-azimuth", "150", "-o", folder / "least.rct").stderr
    program.check("sun alone is not known" in said, said)
    rows, info = rows_of(folder / "least.rct")
    program.check(info["sun_zenith_deg"] == 40 and info["sensor_height_m"] == 500)
    axes = {axis["name"]: axis["count"] for axis in info["axes"]}
    program.check((axes["sky_zenith"], axes["sky_azimuth"], axes["view_zenith"]) == (3, 3, 1), axes)
    flat(rows["solar_irradiance"], E0, 1e-4), flat(rows["view_transmission"], T_VIEW, 1e-6), flat(
        rows["path_radiance_solar"], L0, 1e-4
    )
    flat(rows["sky_radiance_solar"], SKY, 1e-4), flat(rows["sun_transmission"], JOINED / T_VIEW, 6e-3)
    program.check(rows["two_way_factor"]["least"] == rows["two_way_factor"]["most"] == 1)
    program.check(any("sun alone is not known" in notice for notice in info["provenance"]["notices"]))

    # The whole chain: that table renders three grey strips.
    strips = scene(folder, "strips.toml", air=f'{{ tables = "{folder / "least.rct"}" }}', pixels=24, lines=4)
    program.run("render", strips, "-o", folder / "out")
    _, cube = envi(folder / "out" / "camera", "radiance")
    for column, albedo in ((4, 0.10), (12, 0.45), (20, 0.80)):
        expected = L0 + albedo * (E0 * MU0 * JOINED / math.pi + T_VIEW * SKY)
        # REF_SOL's three digits carry half of the light; the render's own tolerance is 1 %.
        program.check(numpy.allclose(cube[:, column, :], expected, rtol=1e-2), albedo, expected, cube[0, column])

    # Three albedos separate ground and air; a direct-irradiance run gives the sun alone, so the two-way factor is
    # known.
    three = write("three.tp7", down(0), down(0.3), down(0.8), sun())
    program.run("atmos", "import", three, ups, "-o", folder / "three.rct")
    rows, info = rows_of(folder / "three.rct")
    flat(rows["sun_transmission"], T_SUN, 1e-4), flat(rows["two_way_factor"], JOINED / T_SUN / T_VIEW, 6e-3)
    # Differences of five-digit radiances: S is the small difference of two ratios near 1.
    flat(rows["spherical_albedo"], S, 1e-2), flat(rows["diffuse_view_transmission"], T_DIF, 1e-2)
    factor = JOINED / T_SUN / T_VIEW
    flat(
        rows["diffuse_irradiance"], TOTAL / factor - E0 * MU0 * T_SUN, 4e-2
    )  # what R2's three digits leave of a difference
    program.check(rows["diffuse_return"]["least"] == rows["spherical_albedo"]["least"])

    # Albedos that the runs do not tell are asked for in order; another number of them is refused.
    program.run("atmos", "import", three, ups, "--albedo", "0,0.3,0.8", "-o", folder / "told.rct")
    program.refused(
        "atmos", "import", three, ups, "--albedo", "0,0.3", "-o", folder / "no.rct", status=2, says=["2 for 3 runs"]
    )

    # What is missing is listed, all of it; contradictions and holes too.
    program.refused(
        "atmos",
        "import",
        ups,
        "-o",
        folder / "no.rct",
        status=2,
        messages=4,
        says=[
            "view_transmission, transmission from target to sensor",
            "sun_transmission",
            "path_radiance_solar",
            "the sensor's height",
        ],
    )
    program.refused(
        "atmos", "import", paths, "-o", folder / "no.rct", status=2, says=["sky_radiance_solar", "--even-sky"]
    )
    program.refused(
        "atmos",
        "import",
        paths,
        write("hole.tp7", *skies[:-1]),
        "-o",
        folder / "no.rct",
        status=2,
        says=["sky_radiance_solar", "no run at", "sky_azimuth 180, sky_zenith 90"],
    )
    program.refused(
        "atmos",
        "import",
        paths,
        ups,
        write("other.tp7", sky(60, 90, 2 * SKY)),
        "-o",
        folder / "no.rct",
        status=2,
        says=["two runs say different things", "sky_zenith 60"],
    )
    program.run("atmos", "import", paths, "--partial", "-o", folder / "part.rct")
    program.check("sky_radiance_solar" in rows_of(folder / "part.rct")[1]["absent_rows"])
    program.refused("atmos", "import", paths, ups, "-o", folder / "least.rct", status=2, says=["least.rct"])
    program.check(not (folder / "no.rct").exists())

    # A user's own CSV: columns named as rows, places behind the names.
    own = write(
        "own.csv",
        "wavelength [nm],solar_irradiance [W m-2 um-1],sun_transmission [1],view_transmission [1],path_radiance_solar "
        "[W m-2 sr-1 um-1],"
        "sky_radiance_solar_z0 [W m-2 sr-1 um-1],sky_radiance_solar_z90 [W m-2 sr-1 um-1],note [1]\n",
        *(f"{nm},1500,0.6,0.8,{5 + nm / 100},50,70,1\n" for nm in range(400, 1001, 50)),
    )
    said = program.run(
        "atmos", "import", own, "--sun-zenith", "40", "--sensor-height", "500", "-o", folder / "own.rct"
    ).stderr
    program.check("own.csv: note left out" in said and "two-way factor 1" in said, said)
    rows, _ = rows_of(folder / "own.rct")
    program.check(
        (rows["sky_radiance_solar"]["least"], rows["sky_radiance_solar"]["most"]) == (50, 70)
        and rows["path_radiance_solar"]["most"] == 15
    )
    program.run("atmos", "plot", folder / "own.rct")

    several = json.loads(program.run("atmos", "import", paths, ups, "--json").stdout)
    program.check([file["format"] for file in several] == ["tape7", "tape7"] and len(several[1]["runs"]) == 7)

    shared = os.environ.get("RAYCUBE_SHARED")
    if shared:
        chn = pathlib.Path(shared) / "reference/atmosphere/samples/modtran/isofit_modtran6_vswir.chn"
        sun_and_sensor = options(sun_zenith=40, sun_azimuth=150, sensor_height=500)
        program.run("atmos", "import", chn, *sun_and_sensor, "--even-sky", "-o", folder / "chn.rct")
        strips = scene(folder, "real.toml", air=f'{{ tables = "{folder / "chn.rct"}" }}', pixels=12, lines=2)
        program.run("render", strips, "-o", folder / "real")
        _, cube = envi(folder / "real" / "camera", "radiance")
        program.check(
            bool((numpy.diff(cube[0, [2, 6, 10], :], axis=0) > 0).all())
        )  # brighter ground, more light, in every band
    else:
        print("SKIPPED: RAYCUBE_SHARED is not set, no real .chn was rendered with", file=sys.stderr)
print(f"atmos import to a table: ok, {program.checks} checks")
