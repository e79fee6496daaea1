"""S63: a cube that lies on no grid is put on a map by gdalwarp -geoloc, from any folder: an oblique, turned image, in
which a panel must come to lie where the scene has it."""

import pathlib
import sys
import tempfile

import numpy as np

import patience
from driver import Program, envi
from optics_kit import HEAD, camera, panel, with_origin

program = Program(sys.argv[1])
EASTING, NORTHING = 276000.0, 4753000.0
SIDE_M, MIDDLE = 24.0, (30.0, 160.0)


def on_map(folder, **more):
    """The first band on a grid of half a metre, and the places of its pixels."""
    keys = {"pitch_deg": 20.0, "heading_deg": 25.0, "altitude_agl_m": 500.0} | more
    text = with_origin(HEAD).replace("[400.0, 400.0]", "[1200.0, 1200.0]")
    text += panel("bright", (SIDE_M, SIDE_M), MIDDLE)
    text += camera(pixels=150, lines=150, bands="first_nm = 550.0, step_nm = 100.0, count = 2", **keys)
    (folder / "scene.toml").write_text(text)
    program.run("render", folder / "scene.toml", "-o", folder / "out", "--overwrite", "-q", "-q")
    cube = folder / "out/camera/radiance.vrt"
    patience.run(
        ["gdalwarp", "-q", "-overwrite", "-geoloc", "-tr", "0.5", "0.5", "-of", "ENVI", cube, folder / "map.img"],
        check=True,
        cwd="/",
    )
    header, values = envi(folder, "map")
    place = [float(v) for v in header["map info"][3:7]]
    east = place[0] + (np.arange(values.shape[1]) + 0.5) * place[2] - EASTING
    north = place[1] - (np.arange(values.shape[0]) + 0.5) * place[3] - NORTHING
    program.check("UTM_Zone_18N" in str(header["coordinate system string"]), header["coordinate system string"])
    return values[..., 0].astype("f8"), east, north


def ortho(folder, *options, cube="radiance.img"):
    program.run("ortho", folder / "out/camera" / cube, "-o", folder / "ortho", "--overwrite", *options)
    return envi(folder / "ortho", "ortho")


def same_as_gdal(folder, more, values, east, north):
    """`raycube ortho` on the grid that gdalwarp chose: the same values, physical where the cube's are scaled."""
    scale = more.get("integer_scale", 1.0)
    for cube in ("radiance.img", "radiance.hdr"):
        header, image = ortho(folder, "--pixel", 0.5, cube=cube)
        program.check(image.shape[:2] == values.shape and header["map info"][5:7] == ["0.5", "0.5"], image.shape)
        program.check(abs(float(header["map info"][3]) - EASTING - east[0] + 0.25) < 1e-3)  # ten digits
        program.check(abs(float(header["map info"][4]) - NORTHING - north[0] - 0.25) < 1e-3)
        seen = np.isfinite(image[..., 0])
        program.check(seen.any() and np.array_equal(seen, values > 0), seen.mean(), (values > 0).mean())
        program.check(np.array_equal(image[..., 0][seen], (values[seen] / scale).astype("f4")))
    cube = envi(folder / "out/camera", "radiance")[0]
    program.check(header["wavelength"] == cube["wavelength"] and header["data ignore value"] == "nan", header)
    # Its own pixel is about the image's; mixed values stay between those of the image.
    header, mixed = ortho(folder, "--resampling", "bilinear")
    program.check(0.8 < float(header["map info"][5]) < 1.5, header["map info"])
    program.check(np.nanmin(mixed) >= np.nanmin(image) - 1e-4 and np.nanmax(mixed) <= np.nanmax(image) + 1e-4)
    truth = ortho(folder, cube="truth.img")[0]
    program.check(truth["band names"] == envi(folder / "out/camera", "truth")[0]["band names"])


def refused(folder):
    """Images without places, of another size, with pixels past the ground; what is there is not overwritten."""
    image = folder / "out/camera/radiance.img"
    program.refused("ortho", image, "-o", folder / "ortho", status=2, says=["ortho.img", "--overwrite"])
    (folder / "out/camera/location.img").rename(folder / "away.img")
    program.refused("ortho", image, "-o", folder / "new", status=2, says=["radiance.img: there is no location.img"])
    (folder / "away.img").rename(folder / "out/camera/location.img")
    program.refused("ortho", folder / "map.img", "-o", folder / "new", status=2, says=["no location.img beside it"])
    places = np.memmap(folder / "out/camera/location.img", "<f8", "r+")
    places[:3] = np.nan
    places.flush()
    program.refused("ortho", image, "-o", folder / "new", status=2, says=["1 of its pixels has a view past the ground"])
    program.check(not (folder / "new").exists())


with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    for more in ({}, {"integer_scale": 10.0}, {"kind": '"pushbroom"', "line_spacing_m": 1.4}):
        values, east, north = on_map(folder, **more)
        bright = values > 0.5 * values.max()
        x, y = np.meshgrid(np.abs(east - MIDDLE[0]), np.abs(north - MIDDLE[1]))
        inside = (x < SIDE_M / 2) & (y < SIDE_M / 2)
        # A pixel is 1 to 1.3 m on the ground, and the nearest one is taken: an edge may lie half of that aside.
        surely, near = (x < SIDE_M / 2 - 1) & (y < SIDE_M / 2 - 1), (x < SIDE_M / 2 + 1) & (y < SIDE_M / 2 + 1)
        program.check(inside.sum() == (2 * SIDE_M) ** 2 or abs(inside.sum() / (2 * SIDE_M) ** 2 - 1) < 0.05)
        program.check(bright[surely].all() and not bright[~near].any(), more, bright.sum(), inside.sum())
        same_as_gdal(folder, more, values, east, north)
    refused(folder)
print(program.checks, "checks")
