"""S14 S16 S61: thermal light as users run it: a table written here from its documented format, a scene with
temperatures, `atmos info`, `check`, `render`, and what is refused. Oracle: Planck's law in numpy; the air is
isothermal."""

import hashlib
import json
import pathlib
import struct
import sys
import tempfile

import numpy

from driver import Program, camera, envi

program = Program(sys.argv[1])
run, check = program.run, program.check


def planck(um, kelvin):
    """W m-2 sr-1 um-1, exact SI constants."""
    h, k, c = 6.62607015e-34, 1.380649e-23, 299792458.0
    l = numpy.asarray(um, dtype=float) * 1e-6
    return 2 * h * c * c / (l**5 * numpy.expm1(h * c / (l * k * kelvin))) * 1e-6


def write_table(path, kelvin, depth, sky=True):
    """Isothermal air over one node of everything: T = exp(-depth), path B (1 - T), sky B. docs/table_format.md."""
    um = numpy.arange(7.5, 13.5, 0.005)
    b, ones = planck(um, kelvin), numpy.ones_like(um)
    rows = [
        ("view_transmission", "1", ["wavelength", "target_height", "view_zenith"], ones * numpy.exp(-depth)),
        (
            "path_radiance_thermal",
            "W m-2 sr-1 um-1",
            ["wavelength", "target_height", "view_zenith"],
            b * (1 - numpy.exp(-depth)),
        ),
    ]
    if sky:
        rows.append(("sky_radiance_thermal", "W m-2 sr-1 um-1", ["wavelength", "target_height", "sky_zenith"], b))
    axes = [
        ("wavelength", "um", list(um)),
        ("target_height", "m", [0.0]),
        ("view_zenith", "deg", [0.0]),
        ("sky_zenith", "deg", [0.0]),
    ]
    arrays, listed = b"", []
    for name, unit, of, values in rows:
        listed.append(
            {
                "name": name,
                "unit": unit,
                "text": "isothermal air",
                "axes": of,
                "shape": [len(um), 1, 1],
                "offset": len(arrays),
            }
        )
        data = values.astype("<f4").tobytes()
        arrays += data + b"\0" * (-len(data) % 64)
    header = json.dumps(
        {
            "format": "raycube render table",
            "version": 1,
            "medium": "vacuum",
            "solar_source": "none",
            "sun_zenith_deg": 120.0,
            "sun_azimuth_deg": 0.0,
            "sensor_height_m": 500.0,
            "provenance": {"model": "isothermal air"},
            "axes": [{"name": n, "unit": u, "nodes": v} for n, u, v in axes],
            "rows": listed,
        }
    ).encode()
    size = len(header)
    body = header + b"\0" * (-size % 64) + arrays
    head = (
        bytes.fromhex("895243540d0a1a0a")
        + struct.pack("<IIQQ", 1, 0x01020304, size, 64 + len(body))
        + hashlib.sha256(body).digest()
    )
    path.write_bytes(head + body)


def scene(path, thermal):
    path.write_text(f"""format = 1
time = {{ sun = {{ zenith_deg = 120 }} }}
atmosphere = {{ tables = "air.rct" }}
{thermal[0]}
[[material]]
name = "ground"
reflectance = 0.06
{thermal[1]}
[[material]]
name = "metal"
reflectance = 0.8
[[plane]]
material = "ground"
size_m = [60, 60]
[[box]]
material = "metal"
size_m = [6, 4, 5]
{camera(24, 20, 4, first_nm=8000, step_nm=500, count=9, fwhm_nm=100)}""")
    return path


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    write_table(work / "air.rct", 290.0, 0.3)
    check("sky_radiance_thermal" in run("atmos", "info", work / "air.rct").stdout)

    # An isothermal world at 290 K: every band of every pixel is B(290 K), whatever reflects, hides or transmits.
    same = scene(work / "same.toml", ("thermal = { default_temperature_K = 290 }", ""))
    run("render", same, "-o", work / "same", "-q")
    _, cube = envi(work / "same" / "camera", "radiance")
    fine = numpy.arange(-250, 251) / 1000.0
    response = numpy.exp(-4 * numpy.log(2) * (fine / 0.1) ** 2)
    expected = numpy.array([(response * planck(8 + 0.5 * b + fine, 290.0)).sum() / response.sum() for b in range(9)])
    check(numpy.abs(cube / expected - 1).max() < 1e-5, numpy.abs(cube / expected - 1).max())

    # Two temperatures: warm ground is brighter, and `check` is green with a figure for the surroundings.
    warm = scene(work / "warm.toml", ("[thermal]\ndefault_temperature_K = 280", "temperature_K = 300"))
    report = json.loads(run("check", warm, "--json", "--pixels", 480, "--model-pixels", 24).stdout)["camera"]
    check(report["passed"] and report["sky_unexplained"] == 0 and report["worst"] < 2e-5, report["failures"])
    check(0 < report["model"]["surroundings"]["figure"] < 0.01 and report["model"]["sun"]["figure"] == 0)
    check("surroundings at one temperature" in run("check", warm, "--pixels", 40).stdout)
    run("render", warm, "-o", work / "warm", "-q")
    _, cube = envi(work / "warm" / "camera", "radiance")
    corner = cube[0, 0] / (
        0.94 * planck(8 + 0.5 * numpy.arange(9), 300.0) * numpy.exp(-0.3)
        + planck(8 + 0.5 * numpy.arange(9), 290.0) * (1 - 0.94 * numpy.exp(-0.3))
    )
    check(numpy.abs(corner - 1).max() < 2e-3, corner)  # at band centres: a band of 0.1 um bends B by 1e-3
    plan = json.loads(run("render", warm, "--dry-run", "--json").stdout)
    check(json.dumps(plan).count("temperature_nodes_K") == 1)

    # Refused: a material in use without a temperature, half of the thermal rows.
    bare = scene(work / "bare.toml", ("", "temperature_K = 300"))
    program.refused(
        "render", bare, "-o", work / "bare", status=2, says=["bare.toml", "material 'metal'", "default_temperature_K"]
    )
    check(not (work / "bare").exists())
    write_table(work / "air.rct", 290.0, 0.3, sky=False)
    program.refused(
        "render", same, "-o", work / "half", status=2, says=["no row 'sky_radiance_thermal'", "thermal light"]
    )

    # A plate that fills the view, without air: 1200 K at 2.2 um by day (B = 9972.8), 300 K at 10 um by night
    # (B = 9.92403).
    def vacuum(name, material, zenith, center_nm):
        path = work / f"{name}.toml"
        path.write_text(f"""format = 1
time = {{ sun = {{ zenith_deg = {zenith} }} }}
atmosphere = {{ model = "none" }}
material = [{{ name = "plate", {material} }}]
plane = [{{ material = "plate", size_m = [60, 60] }}]
{camera(4, 4, 4, first_nm=center_nm, fwhm_nm=5)}""")
        return path

    lava = vacuum("lava", "reflectance = 0.1, temperature_K = 1200", 40, 2200)
    run("render", lava, "-o", work / "lava", "-q")
    _, cube = envi(work / "lava" / "camera", "radiance")
    check(8975 < cube.min() < 8980 and cube.max() < 8980, cube)  # 0.9 B, and 1.99 of the sun
    check('"passed": true' in run("check", lava, "--json", "--pixels", 16).stdout)
    black = vacuum("black", "reflectance = 0, temperature_K = 300", 120, 10000)
    run("render", black, "-o", work / "black", "-q")
    _, cube = envi(work / "black" / "camera", "radiance")
    check(numpy.abs(cube / 9.92403 - 1).max() < 2e-6, cube)
    cold = vacuum("cold", "reflectance = 0.5", 120, 10000)
    says = ["cold.toml", "material 'plate'", "beyond 4 um"]
    program.refused("render", cold, "-o", work / "cold", status=2, says=says)

print(f"{program.checks} checks hold")
