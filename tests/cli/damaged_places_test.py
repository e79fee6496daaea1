#!/usr/bin/env python3
"""A location.img with an impossible place: `ortho` names the pixel instead of asking for a map of terabytes, `locate`
what lies off the Earth. usage: damaged_places_test.py RAYCUBE"""

import pathlib
import sys
import tempfile

import numpy

from driver import Program

program = Program(sys.argv[1])
kLines, kSamples = 30, 40


def write(path, values, more=""):
    values.tofile(path)
    path.with_suffix(".hdr").write_text(
        f"ENVI\nsamples = {values.shape[1]}\nlines = {values.shape[0]}\nbands = {values.shape[2]}\nheader offset = 0\n"
        f"data type = {5 if values.dtype == 'f8' else 4}\ninterleave = bip\nbyte order = 0\n{more}"
    )
    return path


def locations(folder, change=None):
    places = numpy.zeros((kLines, kSamples, 3))
    places[..., 0] = 500000 + numpy.arange(kSamples)
    places[..., 1] = 5e6 - numpy.arange(kLines)[:, None]
    if change:
        change(places)
    return write(
        folder / "location.img",
        places,
        "description = {EPSG:32633}\nband names = {easting [m], northing [m], height [m]}\n",
    )


def put(line, sample, axis, value):
    def change(places):
        places[line, sample, axis] = value

    return change


def far_edge(places):
    """The last lines look towards the horizon, as oblique pictures do."""
    places[-3:, :, 1] += numpy.array([-30, -90, -400])[:, None]


with tempfile.TemporaryDirectory() as made:
    folder = pathlib.Path(made)
    image = write(folder / "image.img", numpy.random.default_rng(1).random((kLines, kSamples, 3)).astype("f4"))
    for change in (None, far_edge):
        place = locations(folder, change)
        program.run("ortho", image, "-o", folder / "map", "--overwrite")
        program.run("analyze", "locate", place, "--other", place, "-o", folder / "located", "--overwrite")
    for line, sample, axis, value in (
        (7, 9, 0, 1e30),
        (7, 9, 0, -1e12),
        (29, 39, 1, 1e10),
        (0, 0, 0, 0.0),
        (0, 39, 1, 0.0),
        (15, 20, 0, 9e8),
        (15, 20, 1, 5.1e6),
    ):
        place = locations(folder, put(line, sample, axis, value))
        says = ["location.img", f"line {line}, sample {sample} (from 0) lies at", "the file is damaged"]
        program.refused("ortho", image, "-o", folder / "no", status=2, says=says)
        program.refused("ortho", image, "-o", folder / "no", "--pixel", 1, status=2, says=says)
        if abs(value) > 1e9:
            program.refused("analyze", "locate", place, "--other", place, "-o", folder / "no", status=2, says=says[:2])
    locations(folder)
    program.refused(
        "ortho", image, "-o", folder / "no", "--pixel", 1e-4, status=2, says=["location.img", "--pixel", "40 x 30"]
    )
    program.check(not list((folder / "no").glob("*")) if (folder / "no").exists() else True)
print(f"damaged places: {program.checks} checks")
