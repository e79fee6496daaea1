#!/usr/bin/env python3
"""The air and the background of a LIDAR as its user meets them: what there is to know of its air is said once and kept
in run.json; a table of passive light is no air for it; by night what the scene emits is its background.
usage: lidar_air_test.py RAYCUBE"""

import csv
import json
import math
import os
import pathlib
import sys
import tempfile

from driver import PULSE_AND_RECEIVER, Program, camera, gate, options, own_cache, record

program = Program(sys.argv[1])
run, check = program.run, program.check

HEAD = """format = 1
[[material]]
name = "ground"
reflectance = 0.3
{material}
[[plane]]
material = "ground"
size_m = [400.0, 400.0]
[atmosphere]
{air}
{time}
"""
LIDAR = (
    """[[lidar]]
name = "{name}"
position_m = [0.0, 0.0, 500.0]
prf_khz = 10.0
pulses = 2
"""
    + PULSE_AND_RECEIVER
    + gate(400.0, 600.0)
    + """[lidar.products]
png = false
cube = false
"""
)
CAMERA = "[thermal]\ndefault_temperature_K = 300\n" + camera(2, 2, 2, first_nm=550)
SUN, NIGHT = "[time]\nsun = { zenith_deg = 50.0 }", "[time]\nsun = { zenith_deg = 120.0 }"


def written(work, air, *, names=("scan",), nm=1064.0, time="", material="", more=""):
    path = work / "scene.toml"
    lidars = "".join(LIDAR.format(name=name) for name in names).replace("1064.0", str(nm))
    path.write_text(HEAD.format(air=air, time=time, material=material) + more + lidars)
    return path


def rendered(work, file, name="scan"):
    """Warnings on stderr, the run's record, its pulses."""
    done = run("render", file, "-o", work / "out", "--overwrite")
    said = [line.split("warning: ", 1)[1] for line in done.stderr.splitlines() if "warning: " in line]
    with open(work / "out" / name / "pulses.csv", newline="") as table:
        return said, record(work / "out" / name), list(csv.DictReader(table))


def notices(work):
    """Oracle: what `atmos lidar` says of the same air, with the file of heights that lacks most gases."""
    (work / "sonde.csv").write_text("height_km,pressure_hPa,temperature_K\n0,1013,299\n1,904,294\n2,805,288\n")
    air = 'profile_file = "sonde.csv"\nprofile = "tropical"\naerosol = "desert"\n'
    file = written(work, air, names=("one", "two"), time=SUN, more=CAMERA)
    lidar = ("atmos", "lidar", file, "--overwrite", "-o", work / "air.rct", "--json", "--wavelengths")
    told = json.loads(run(*lidar, 1064).stdout)["atmosphere"]
    check(len(told["notices"]) == 2, told)
    check(any("sonde.csv" in n for n in told["notices"]) and any("backscatter" in n for n in told["notices"]))
    # 1064 nm: gases take less than 1 % of the light, which is a limit and no warning.
    check(len(told["limits"]) == 1 and "absorption by gases is absent" in told["limits"][0], told)
    said, two, _ = rendered(work, file, "two")
    for notice in told["notices"]:
        check(
            said.count(notice) == 1, notice, said
        )  # by three instruments of one air, and by the background's passive air
        for name in ("one", "two", "camera"):
            check(record(work / "out" / name)["warnings"].count(notice) == 1, name, notice)
    check(not any("gases is absent" in text for text in said + two["warnings"]), said)
    check(two["atmosphere"]["limits"] == told["limits"] and two["atmosphere"]["notices"] == told["notices"])
    # 760 nm: the oxygen band, where it is one.
    said, kept, _ = rendered(work, written(work, "", nm=760.0))
    check(len(said) == 1 and "absorption by gases is absent" in said[0] and "near 760 nm they have" in said[0], said)
    check(said == kept["warnings"] == kept["atmosphere"]["notices"] and kept["atmosphere"]["limits"] == [])
    # Plain air has nothing to say, no air neither.
    for air in ("", 'model = "none"'):
        said, kept, _ = rendered(work, written(work, air))
        check(said == kept["warnings"] == [], air, said)


def no_aerosol(work):
    file = written(work, 'aerosol = "none"')
    said, kept, _ = rendered(work, file)
    air = kept["atmosphere"]["parameters"]
    check(air["aod_550"] == 0 and air["visibility_km"] is None and air["aod_550_from"] == "no aerosol", air)
    check("atmosphere: aerosol: none" in run("render", file, "-o", work / "out", "--overwrite", "-v").stderr)
    told = run("atmos", "lidar", "--wavelengths", 532, "--aerosol", "none", "-o", work / "none.rct").stdout
    check("\naerosol: none\n" in told and "visibility" not in told, told)
    built = ("atmos", "build", "--sun-zenith", 40, "--from", 0.5, "--to", 0.55, "--step", 50, "--highest", 0)
    told = run(*built, "--aerosol", "none", "--no-cache", "-o", work / "built.rct").stdout
    check("\naerosol: none\n" in told, told)


def tables(work):
    """A passive table has no profiles: refused by every verb, by name, and nothing is written."""
    sky = options(model="clear_sky", sun_zenith=50, sensor_height=500, to=1.2)
    run("atmos", "build", *sky, "-o", work / "sky.rct")
    file = written(work, 'tables = "sky.rct"', time=SUN)
    says = [
        "scene.toml",
        "LIDAR scan",
        "no profiles of extinction and backscatter",
        'found tables = "',
        "sky.rct",
        'a file of its own with model = "layered", or "none"',
    ]
    for verb in (
        ("scene", "check", file),
        ("render", file, "-o", work / "tables"),
        ("render", file, "--dry-run"),
        ("plan", file),
        ("check", file),
    ):
        program.refused(*verb, status=2, says=says)
    check(not (work / "tables").exists())
    program.refused(
        "render",
        written(work, 'model = "clear_sky"', time=SUN),
        "-o",
        work / "tables",
        status=2,
        says=["LIDAR scan", "no profiles of extinction and backscatter", 'use model = "layered"'],
    )


def background_hz(um, kelvin, emissivity):
    """Photons / s of a surface that fills the field: B(T) A Omega dl / (h c / l)."""
    h, c, k = 6.62607015e-34, 299792458.0, 1.380649e-23
    planck = 2e-6 * h * c * c / (um * 1e-6) ** 5 / math.expm1(h * c / (um * 1e-6 * k * kelvin))  # W m-2 sr-1 um-1
    area, solid_angle = math.pi * 0.05**2, math.pi * 1e-3**2
    return emissivity * planck * area * solid_angle * 1e-3 * um * 1e-6 / (h * c)


def by_night(work):
    """The laser's light is emitted by hot matter at any wavelength and by all matter beyond 2.5 um, night or not."""
    for nm, kelvin in ((1064.0, 1200), (1550.0, 800), (3300.0, 300), (10600.0, 290)):
        warm = f"temperature_K = {kelvin}"
        _, _, pulses = rendered(work, written(work, 'model = "none"', nm=nm, time=NIGHT, material=warm))
        want = background_hz(nm * 1e-3, kelvin, 0.7)
        for row in pulses:
            found = float(row["background_hz"])
            # A filter of 1 nm and single precision: the radiance itself is exact at a material's own temperature.
            check(abs(found / want - 1) < 1e-4, nm, kelvin, found, want)
        print(f"{nm:.0f} nm, {kelvin} K by night: {float(pulses[0]['background_hz']):.6g} of {want:.6g} photons / s")
    # Beyond 2.5 um the air emits too, over ground as cold as it may be: path and reflected sky, below a black body's.
    _, _, pulses = rendered(work, written(work, "", nm=10600.0, time=NIGHT, material="temperature_K = 60"))
    check(all(1e-3 < float(row["background_hz"]) / background_hz(10.6, 290, 1) < 0.5 for row in pulses), pulses)
    # Cold ground is dark below 2.5 um, and that is said; nothing is made up for it.
    for material in ("", "temperature_K = 300"):
        said, kept, pulses = rendered(work, written(work, 'model = "none"', time=NIGHT, material=material))
        check(len(said) == 1 and "(solar_background)" in said[0] and "no twilight" in said[0], said)
        check(len(kept["warnings"]) == 1 and "no twilight" in kept["warnings"][0], kept["warnings"])
        check(all(row["background_hz"] in ("", "nan", "0") for row in pulses), pulses[0]["background_hz"])
        check(kept["survey"]["pulses"] == 2 and "background" not in kept["stage_s"], kept["stage_s"])
    # By day the same cold ground reflects the sun.
    _, _, pulses = rendered(work, written(work, 'model = "none"', time=SUN))
    check(all(float(row["background_hz"]) > 1e6 for row in pulses), pulses)


PLATE = """[[material]]
name = "pane"
reflectance = 0.0
transmittance = 0.9
transmission = "plate"
temperature_K = 300.0
[[plane]]
material = "pane"
size_m = [4000.0, 4000.0]
position_m = [0.0, 0.0, 20.0]
"""


def through_plates(work):
    """Without air an open pane takes its transmittance of the sun's light once on its way down and once up, and of what
    hot ground sends once."""
    for time, material, share in ((SUN, "", 0.9**2), (NIGHT, "temperature_K = 1200.0", 0.9)):
        found = []
        for more in ("", PLATE):
            file = written(work, 'model = "none"', time=time, material=material, more=more)
            _, _, pulses = rendered(work, file)
            found.append(float(pulses[0]["background_hz"]))
        print(f"background through a pane: {found[1] / found[0]:.5f} for {share:.5f}")
        # The wavelengths along paths tell light to a tenth of the tolerance of 1 %; nothing else is drawn.
        check(abs(found[1] / found[0] / share - 1) < 2e-3, found, share)


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    # A kept table names the profile it was made of, which may be another file of the same content.
    os.environ["XDG_CACHE_HOME"] = own_cache(folder)
    notices(folder)
    no_aerosol(folder)
    tables(folder)
    by_night(folder)
    through_plates(folder)
print(f"lidar air: {program.checks} checks")
