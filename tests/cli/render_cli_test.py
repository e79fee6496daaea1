#!/usr/bin/env python3
"""`raycube render` as users drive it: what it leaves, who can read it, and that it is the same however it was made.
usage: render_cli_test.py RAYCUBE SCENES [--full]. Without --full: no check of the garden, which check_cli has."""

import json
import pathlib
import re
import sys
import tempfile

import numpy
import spectral.io.envi
import patience
from driver import FULL, Program, envi, header_of, record, scene

program = Program(sys.argv[1])
run, check = program.run, program.check
scenes = pathlib.Path(sys.argv[2]).resolve()
kProducts = {"radiance.img", "radiance.hdr", "truth.img", "truth.hdr", "preview.exr", "quicklook.png", "run.json"}


def names(folder):
    return {path.name for path in pathlib.Path(folder).iterdir()}


def layer(header, truth, name):
    return truth[:, :, [text.split()[0] for text in header["band names"]].index(name)]


def check_cube(folder, pixels, lines, bands, elevation, azimuth):
    """S26 and section 2 of the conventions: a header other tools understand, data of that size, truth that adds up."""
    check(names(folder) == kProducts, names(folder))
    header, radiance = envi(folder, "radiance")
    check(radiance.shape == (lines, pixels, bands) and header["file type"] == "ENVI Standard", header)
    wavelength, fwhm = ([float(text) for text in header[key]] for key in ("wavelength", "fwhm"))
    check(len(wavelength) == len(fwhm) == bands and wavelength == sorted(set(wavelength)) and min(fwhm) > 0, header)
    check(header["wavelength units"] == "Nanometers" and 300 < wavelength[0] < wavelength[-1] < 3000, header)
    check(header["data units"] == "W m-2 sr-1 um-1" and "band-averaged" in header["description"], header)
    check(float(header["sun elevation"]) == elevation and float(header["sun azimuth"]) == azimuth, header)
    shown = [int(text) for text in header["default bands"]]
    check(len(shown) == 3 and all(abs(wavelength[b - 1] - nm) <= 10 for b, nm in zip(shown, (650, 550, 450))), shown)
    check(radiance.dtype == numpy.float32 and numpy.isfinite(radiance).all() and (radiance > 0).all())

    # GDAL reads the same header: size, type, and a wavelength per band in the right unit.
    info = json.loads(
        patience.run(
            ["gdalinfo", "-json", pathlib.Path(folder) / "radiance.img"], check=True, capture_output=True, text=True
        ).stdout
    )
    check(info["driverShortName"] == "ENVI" and info["size"] == [pixels, lines] and len(info["bands"]) == bands)
    for band, nm in zip(info["bands"], wavelength):
        check(
            float(band["metadata"][""]["wavelength"]) == nm and band["metadata"][""]["wavelength_units"] == "Nanometers"
        )

    # So does Spectral Python: the same samples at the same wavelengths, in nanometres.
    image = spectral.io.envi.open(
        str(pathlib.Path(folder) / "radiance.hdr"), str(pathlib.Path(folder) / "radiance.img")
    )
    check(
        image.shape == (lines, pixels, bands)
        and image.bands.centers == wavelength
        and image.bands.band_unit == "Nanometers"
    )
    check(numpy.array_equal(numpy.asarray(image.open_memmap()), radiance))

    truth_header, truth = envi(folder, "truth")
    check(truth.shape == (lines, pixels, len(truth_header["band names"])))
    check(all(re.search(r" \[[^]]+\]$", text) for text in truth_header["band names"]), truth_header["band names"])
    hit = layer(truth_header, truth, "hit_fraction")
    abundance = sum(
        truth[:, :, i] for i, text in enumerate(truth_header["band names"]) if text.startswith("abundance_")
    )
    check(numpy.abs(abundance - hit).max() < 1e-6)

    made = record(folder)
    check(made["image"]["samples"] == pixels and made["image"]["bands"] == bands and len(made["digest"]) == 64)
    check(set(made["files"]) | {"run.json", "radiance.hdr", "truth.hdr"} == kProducts, made["files"])
    check(made["rays"] > 0 and made["total_s"] > 0 and made["memory"]["peak_bytes"] > 0 and made["program_hash"])
    check((pathlib.Path(folder) / "quicklook.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n"))
    check((pathlib.Path(folder) / "preview.exr").read_bytes().startswith(b"\x76\x2f\x31\x01"))
    return radiance, truth_header, truth


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)

    # The shipped panels, and the scene a newcomer starts from. Their panels are flat, level and free: with the same
    # sun, sky and air the brighter panel is the brighter one in every band, and each stays inside its material's share
    # of the sun.
    done = run("render", scenes / "panels" / "panels.toml", "-o", work / "panels")
    check(done.stdout == f"{work}/panels/camera/radiance.img\n", done.stdout)
    radiance, header, truth = check_cube(work / "panels" / "camera", 64, 48, 200, 50, 150)
    black, white = (layer(header, truth, f"abundance_{name}") == 1 for name in ("black", "white"))
    check(black.sum() >= 200 and white.sum() >= 200)
    check((radiance[white].min(axis=0) > radiance[black].max(axis=0)).all())
    run("new", work / "garden", "-q")
    run("render", work / "garden" / "garden.toml", "-o", work / "garden-out")
    _, header, truth = check_cube(work / "garden-out" / "camera", 64, 64, 98, 50, 160)
    check((layer(header, truth, "hit_fraction") == 1).all() and (layer(header, truth, "abundance_leaf") > 0).sum() > 20)
    if FULL:  # what README says to type
        check("within limits" in run("check", work / "garden" / "garden.toml", "--pixels", 100).stdout)
    shadow = layer(header, truth, "sun_fraction")
    check(shadow.min() == 0 and shadow.max() == 1)

    # Without air, radiance = reflectance x E0 cos(40) / pi: ratios 4.5 and 8 of the three strips in every band. 1e-5:
    # the bound of the fp32 path. Their places: strips of 10 m, pixels of 1 m whose edges fall on the strips' edges.
    strips = scene(work, "strips.toml")
    run("render", strips, "-o", work / "strips")
    base = work / "strips" / "camera"
    _, reference = envi(base, "radiance")
    check((numpy.abs(reference[:, 7:17] / reference[:, :1] - 4.5) < 4.5e-5).all())
    check((numpy.abs(reference[:, 17:] / reference[:, :1] - 8) < 8e-5).all())
    digest = record(base)["digest"]

    # The same bits on repeat, with one thread and two, little memory and much, and in --json.
    for name, options in (
        ("again", []),
        ("one", ["--threads", 1]),
        ("two", ["--threads", 2]),
        ("small", ["--memory", "256M"]),
        ("large", ["--memory", "8G"]),
        ("lines", ["--memory", "100K"]),
    ):
        result = json.loads(run("render", strips, "-o", work / name, "--json", "-q", *options).stdout)["instruments"]
        check(
            len(result) == 1 and result[0]["digest"] == digest == record(work / name / "camera")["digest"], name, result
        )
        check(result[0]["cube"] == f"{work}/{name}/camera/radiance.img")
        for file in ("radiance.img", "truth.img"):
            check((work / name / "camera" / file).read_bytes() == (base / file).read_bytes(), name, file)
    check(record(work / "lines" / "camera")["rows"]["tile_lines"] < 12)  # so that tiles did differ
    seeded = json.loads(run("render", strips, "-o", work / "seed", "--json", "--seed", 7).stdout)
    check(record(work / "seed" / "camera")["seed"] == 7)

    # One cube in every interleave and as scaled integers.
    for interleave in ("bil", "bsq"):
        run("render", scene(work, "other.toml", instrument=f'interleave = "{interleave}"'), "-o", work / interleave)
        header, cube = envi(work / interleave / "camera", "radiance")
        check(header["interleave"] == interleave and (cube == reference).all())
        check(record(work / interleave / "camera")["digest"] == digest)
    run(
        "render",
        scene(work, "other.toml", instrument="integer_scale = 50.0\npng = false\nexr = false"),
        "-o",
        work / "uint16",
    )
    header, cube = envi(work / "uint16" / "camera", "radiance")
    check(
        cube.dtype == numpy.uint16 and names(work / "uint16" / "camera") == kProducts - {"preview.exr", "quicklook.png"}
    )
    check(
        numpy.abs(cube - reference * 50.0).max() <= 0.5 + 1e-2
    )  # half a count, and the float's last bit at 2e4 counts
    check(record(work / "uint16" / "camera")["clipped"] == {"low": 0, "high": 0, "not_a_number": 0})
    gain = {float(text) for text in header["data gain values"]}
    check(gain == {0.02}, gain)

    # Georeferenced: where each pixel looks, in doubles. A float at a northing of 4 753 000 m would step by half a
    # metre.
    tables = scene(work, "geo.toml").read_text().replace("format = 1\n", "")
    inline = "scene = { origin = { epsg = 32618, easting_m = 276000.0, northing_m = 4753000.0, height_m = 180.0 } }\n"
    (work / "geo.toml").write_text(
        "format = 1\n"
        + inline
        + tables.replace('{ model = "none" }', "{ aod_550 = 0.2, spectral_step_nm = 20.0 }")
        + 'band_truth = ["transmission"]\n'
    )
    run("render", work / "geo.toml", "-o", work / "geo")
    geo = work / "geo" / "camera"
    check(
        names(geo)
        == kProducts | {"location.img", "location.hdr", "radiance.vrt", "transmission.img", "transmission.hdr"},
        names(geo),
    )
    header, location = envi(geo, "location")
    check(location.dtype == numpy.float64 and header["band names"] == ["easting [m]", "northing [m]", "height [m]"])
    check("EPSG:32618" in header["description"])
    easting, northing = 276000 - 11.5 + numpy.arange(24), 4753000 + 5.5 - numpy.arange(12)
    # 1e-4 m: truth keeps float metres from the origin (1e-6) of rays traced in float over 500 m (6e-5).
    check(numpy.abs(location[:, :, 0] - easting[None, :]).max() < 1e-4)
    check(numpy.abs(location[:, :, 1] - northing[:, None]).max() < 1e-4)
    check(numpy.abs(location[:, :, 2] - 180).max() < 1e-4)

    # Level ground seen straight down, north up, is a map grid: map info in every header, and GDAL places the corner and
    # the system. Turned by 30 degrees it is none.
    for name in ("radiance", "truth", "location", "transmission"):
        info = json.loads(
            patience.run(
                ["gdalinfo", "-json", geo / f"{name}.img"], check=True, capture_output=True, text=True
            ).stdout
        )
        corner = numpy.array(info["geoTransform"])
        check(numpy.abs(corner - [276000 - 12, 1, 0, 4753000 + 6, 0, -1]).max() < 1e-4, corner)
        check("UTM zone 18N" in info["coordinateSystem"]["wkt"], info["coordinateSystem"]["wkt"][:100])
    (work / "turned.toml").write_text((work / "geo.toml").read_text() + "heading_deg = 30.0\n")
    run("render", work / "turned.toml", "-o", work / "turned")
    check(not any("map info" in header_of(path) for path in (work / "turned" / "camera").glob("*.hdr")))

    # Transmission from ground to sensor: between 0 and 1, more of it at 850 nm than in the blue (Rayleigh), the longer
    # way at the corner lets no more through. Without air it is 1.
    header, transmission = envi(geo, "transmission")
    check(
        header["data units"] == "1"
        and transmission.shape == (12, 24, 10)
        and 0 < transmission.min() < transmission.max() < 1
    )
    check((transmission[:, :, 8] > transmission[:, :, 0]).all() and (transmission[0, 0] <= transmission[6, 12]).all())
    run("render", scene(work, "other.toml", instrument='band_truth = ["transmission"]'), "-o", work / "clear")
    check(numpy.abs(envi(work / "clear" / "camera", "transmission")[1] - 1).max() < 1e-6)

    # --dry-run: the plan and the memory, and not a byte on the disk.
    dry = run("render", strips, "-o", work / "dry", "--dry-run").stdout
    check(
        "camera: 24 x 12 pixels, 10 bands, 9 samples per pixel" in dry and "memory" in dry and "tolerance 0.01" in dry,
        dry,
    )
    dry = json.loads(run("render", strips, "-o", work / "dry", "--dry-run", "--json", "--memory", "1G").stdout)[
        "instruments"
    ][0]
    check(
        dry["cube_bytes"] == (base / "radiance.img").stat().st_size
        and dry["truth_bytes"] == (base / "truth.img").stat().st_size
    )
    check(
        dry["memory"]["budget_bytes"] == 1 << 30
        and 0 < dry["memory"]["total_bytes"] < 1 << 30
        and dry["plan"]["height_m"],
        dry,
    )
    check(dry["estimated_s"] > 0, dry["estimated_s"])
    dry = run("render", strips, "-o", work / "dry", "--dry-run", "--json", env={"OCL_ICD_VENDORS": "/nonexistent"})
    check(
        "estimated_s" not in json.loads(dry.stdout)["instruments"][0] and "time cannot be estimated" in dry.stderr,
        dry.stderr,
    )
    check(not (work / "dry").exists())

    # `info` and the instrument's name
    check(json.loads(run("info", "--json", base).stdout)["run"]["digest"] == digest)
    check(header_of(base / "radiance.hdr")["sensor type"] == "raycube camera")
print(f"render: {program.checks} checks")
