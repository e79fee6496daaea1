"""S63: a cube that lies on no grid is put on a map by gdalwarp -geoloc, from any folder: an oblique, turned image, in
which a panel must come to lie where the scene has it."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

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
    subprocess.run(
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
print(program.checks, "checks")
