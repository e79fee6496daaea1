"""What lies or stands under the terrain is told by `scene check`, with its name, its height and the ground's: objects
of every kind, cameras, LIDARs and lamps; what stands on it, above it or beside it is not. usage: buried_test.py
RAYCUBE"""

import pathlib
import sys
import tempfile

from driver import PULSE_AND_RECEIVER, Program, gate

program = Program(sys.argv[1])
check = program.check

HEAD = """format = 1
material = [ { name = "soil", reflectance = 0.2 }, { name = "target", reflectance = 0.6 } ]
terrain = [ { raster = "dem.asc", material = "soil" } ]
mesh = [ { name = "tetra", file = "tetra.obj", material = "target" } ]
[atmosphere]
model = "none"
[time.sun]
zenith_deg = 30.0
azimuth_deg = 90.0
"""
CAMERA = """[[instrument]]
name = "camera"
kind = "framing"
pixels = 12
lines = 8
ifov_mrad = 20.0
bands = { first_nm = 500.0, step_nm = 50.0, count = 2, fwhm_nm = 20.0 }
"""
ABOVE = CAMERA + "position_m = [0.0, 0.0, 300.0]\n"
LIDAR = """[[lidar]]
name = "scan"
position_m = [%s]
prf_khz = 10.0
pulses = 4
""" + PULSE_AND_RECEIVER + gate(10.0, 200.0)
LAMP = """[[lamp]]
name = "street"
shape = "point"
position_m = [0.0, 0.0, %s]
power_W = 100.0
temperature_K = 3000.0
"""


def notices(folder, text):
    """Warnings of `scene check` that tell of the terrain."""
    (folder / "scene.toml").write_text(HEAD + text)
    said = program.run("scene", "check", folder / "scene.toml").stderr
    return [line for line in said.splitlines() if "under the terrain" in line]


def objects(folder):
    for text, name, top in (
        ('[[plane]]\nname = "sheet"\nmaterial = "target"\nsize_m = [2.0, 2.0]\n', "sheet", "0"),
        ('[[box]]\nname = "shed"\nmaterial = "target"\nsize_m = [2.0, 2.0, 3.0]\n', "shed", "3"),
        ('[[instance]]\nmesh = "tetra"\n', "tetra", "1"),
        ('[[instance]]\nmesh = "tetra"\nposition_m = [5.0, 5.0, 240.0]\n', "tetra", "241"),
        ('[[scatter]]\nmesh = "tetra"\npositions = "points.csv"\non_terrain = false\n', "tetra", "1"),
    ):
        if "scatter" in text:
            (folder / "points.csv").write_text("x_m,y_m,z_m\n1,1,0\n2,2,0\n")
        said = notices(folder, text + ABOVE)
        check(len(said) == 1 and f"'{name}' reaches up to {top} m" in said[0], name, said)
        check("the ground there lies at 25" in said[0] and "on_terrain = true" in said[0], said)
    high = "position_m = [0.0, 0.0, 260.0]\n"
    for text in (
        '[[plane]]\nname = "sheet"\nmaterial = "target"\nsize_m = [2.0, 2.0]\non_terrain = true\n',
        '[[plane]]\nname = "sheet"\nmaterial = "target"\nsize_m = [2.0, 2.0]\n' + high,
        '[[plane]]\nname = "beside"\nmaterial = "target"\nsize_m = [900.0, 900.0]\n',  # reaches past the terrain
        '[[instance]]\nmesh = "tetra"\non_terrain = true\n',
        '[[instance]]\nmesh = "tetra"\n' + high,
    ):
        said = notices(folder, text + ABOVE)
        check(said == [], text, said)


def stands(folder):
    """Cameras, LIDARs and lamps: those below the ground."""
    for text, who, z, ground in (
        (CAMERA + "position_m = [-40.0, 0.0, 300.0]\n", "instrument 'camera'", "300", "35"),  # in the cliff
        (LIDAR % "-40.0, 0.0, 300.0", "LIDAR 'scan'", "300", "35"),
        (LAMP % "5.0" + ABOVE, "lamp 'street'", "5", "25"),
    ):
        said = notices(folder, text)
        says = f"{who} stands under the terrain: at z = {z} m, where the ground lies at {ground}"
        check(len(said) == 1 and says in said[0], text, said)
    for text in (ABOVE, LIDAR % "0.0, 0.0, 300.0", LAMP % "270.0" + ABOVE, CAMERA + "altitude_agl_m = 100.0\n"):
        check(notices(folder, text) == [], text)


with tempfile.TemporaryDirectory() as scratch:
    top = pathlib.Path(scratch)
    rows = [" ".join(str((350 if i < 5 else 250) + (i + j) % 3) for i in range(21)) for j in range(21)]
    grid = "ncols 21\nnrows 21\nxllcorner -52.5\nyllcorner -52.5\ncellsize 5\n"
    (top / "dem.asc").write_text(grid + "\n".join(rows) + "\n")
    (top / "tetra.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    objects(top)
    stands(top)
    print(f"buried: {program.checks} checks")
