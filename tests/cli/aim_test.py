#!/usr/bin/env python3
"""Cameras aimed at a point or so far off the nadir: the middle of the image looks there, at that angle and from where
it must stand. Usage: aim_test.py RAYCUBE"""

import math
import pathlib
import sys
import tempfile

import numpy as np

from driver import Program, envi

program = Program(sys.argv[1])
check = program.check
EAST, NORTH = 276000.0, 4753000.0

SCENE = """format = 1
bounces = 0
material = [{{ name = "soil", reflectance = 0.3 }}]
plane = [{{ material = "soil", position_m = [0.0, 0.0, {ground}], size_m = [40000.0, 40000.0] }}]
atmosphere = {{ model = "none" }}
time = {{ sun = {{ zenith_deg = 30.0, azimuth_deg = 150.0, day_of_year = 264 }} }}
[scene]
origin = {{ epsg = 32618, easting_m = 276000.0, northing_m = 4753000.0, height_m = 0.0 }}
[[instrument]]
name = "camera"
kind = "{kind}"
pixels = 31
lines = 31
ifov_mrad = 1.0
samples = {{ grid = [1, 1] }}
bands = {{ first_nm = 550.0, step_nm = 10.0, count = 1, fwhm_nm = 10.0 }}
png = false
exr = false
{aim}
"""


def looked(folder, aim, kind="framing", ground=5.0):
    """Places of the pixels, relative to the scene's origin, and the record's pose."""
    file = folder / "scene.toml"
    file.write_text(SCENE.format(aim=aim, kind=kind, ground=ground))
    program.run("render", file, "-o", folder / "out", "--overwrite", "-q", "-q")
    places = envi(folder / "out/camera", "location")[1]
    return places - (EAST, NORTH, 0.0)


def aimed(folder):
    point = (120.0, -340.0, 5.0)
    at = "look_at_m = [120.0, -340.0, 5.0]\n"
    # From a place: the middle pixel meets the point, and the image's top lies beyond it.
    places = looked(folder, "position_m = [-200.0, 60.0, 805.0]\n" + at)
    check(np.abs(places[15, 15] - point).max() < 1e-3, places[15, 15])
    way = np.array(point[:2]) - (-200.0, 60.0)
    up = places[0, 15, :2] - places[30, 15, :2]
    check(abs(np.cross(up, way)) < 1e-6 * np.linalg.norm(up) * np.linalg.norm(way) and up @ way > 0, up, way)
    # With a heading of its own it keeps that, and rolls.
    places = looked(folder, "position_m = [-200.0, 60.0, 805.0]\nheading_deg = 200.0\n" + at)
    check(np.abs(places[15, 15] - point).max() < 1e-3, places[15, 15])
    # From so far off the nadir, so high above the point: 40 degrees, looking to the south-east.
    aim = at + "altitude_agl_m = 1000.0\noff_nadir_deg = 40.0\noff_nadir_azimuth_deg = 130.0\n"
    places = looked(folder, aim)
    check(np.abs(places[15, 15] - point).max() < 1e-3, places[15, 15])
    # The slant range is 1000 m / cos 40: a pixel across, of 1 mrad in the image's plane, spans that.
    across = np.linalg.norm(places[15, 16] - places[15, 14])
    check(abs(across / (2e-3 * 1000 / math.cos(math.radians(40))) - 1) < 1e-4, across)
    # Along the way that it looks a pixel is longer by 1 / cos 40 (over half a pixel's change of that).
    along = places[14, 15] - places[16, 15]
    check(abs(np.linalg.norm(along) / across * math.cos(math.radians(40)) - 1) < 1e-3, along, across)
    azimuth = math.degrees(math.atan2(along[0], along[1])) % 360
    check(abs(azimuth - 130) < 1e-3, azimuth)


def off_nadir(folder):
    """About where it stands: the middle lies aside by the height's tangent."""
    for azimuth, more in ((0.0, ""), (250.0, "off_nadir_azimuth_deg = 250.0\n")):
        places = looked(
            folder, "altitude_agl_m = 600.0\ncenter_m = [10.0, 20.0]\noff_nadir_deg = 25.0\n" + more, ground=0
        )
        aside = 600 * math.tan(math.radians(25))
        wanted = (10 + aside * math.sin(math.radians(azimuth)), 20 + aside * math.cos(math.radians(azimuth)))
        check(np.abs(places[15, 15, :2] - wanted).max() < 1e-3, places[15, 15], wanted)
    # A scanner that flies north and looks to the right: every line's middle lies aside, lines follow one another north.
    aim = "altitude_agl_m = 600.0\nheading_deg = 0.0\noff_nadir_deg = 25.0\noff_nadir_azimuth_deg = 90.0\n"
    places = looked(folder, aim, kind="pushbroom", ground=0)
    aside = 600 * math.tan(math.radians(25))
    check(np.abs(places[:, 15, 0] - aside).max() < 1e-3, places[:, 15, 0])
    check(np.abs(np.diff(places[:, 15, 1]) - 0.6).max() < 1e-3, np.diff(places[:, 15, 1]))


def refused(folder):
    for aim, says in (
        (
            "altitude_agl_m = 600.0\nlook_at_m = [0.0, 0.0, 0.0]\npitch_deg = 3.0\n",
            "'pitch_deg' and 'look_at_m' both turn",
        ),
        ("altitude_agl_m = 600.0\noff_nadir_deg = 3.0\nroll_deg = 3.0\n", "'roll_deg' and 'off_nadir_deg' both turn"),
        ("altitude_agl_m = 600.0\noff_nadir_azimuth_deg = 3.0\n", "'off_nadir_azimuth_deg' goes with off_nadir_deg"),
        (
            "altitude_agl_m = 600.0\nlook_at_m = [0.0, 0.0, 0.0]\noff_nadir_azimuth_deg = 3.0\n",
            "'off_nadir_azimuth_deg' goes with off_nadir_deg",
        ),
        (
            "position_m = [0.0, 0.0, 600.0]\nlook_at_m = [5.0, 0.0, 600.0]\n",
            "'look_at_m' does not lie below the instrument",
        ),
        (
            "position_m = [0.0, 0.0, 600.0]\nlook_at_m = [5.0, 0.0, 0.0]\noff_nadir_deg = 10.0\n",
            "'position_m' does not go with look_at_m and off_nadir_deg",
        ),
    ):
        file = folder / "scene.toml"
        file.write_text(SCENE.format(aim=aim, kind="framing", ground=0))
        program.refused("render", file, "-o", folder / "none", status=2, says=[says])


with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    aimed(folder)
    off_nadir(folder)
    refused(folder)
print(f"aim: {program.checks} checks")
