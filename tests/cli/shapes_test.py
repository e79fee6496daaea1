"""S21 S61: every scattering shape that a material can have (its table in the simulation file), seen by a camera and by
a LIDAR whose pulses bounce: `raycube check` holds the device against the reference, whatever the shape."""

import json
import pathlib
import sys
import tempfile

from driver import PULSE_AND_RECEIVER, Program

program = Program(sys.argv[1])

SCENE = """format = 1
tolerance = 0.05
sky_directions = 32
[atmosphere]
model = "layered"
spectral_step_nm = 20.0
[time.sun]
zenith_deg = 55.0
azimuth_deg = 140.0
day_of_year = 200
[[material]]
name = "shaped"
reflectance = 0.4
{shape}
[[material]]
name = "plain"
reflectance = 0.3
[[plane]]
material = "shaped"
size_m = [300.0, 300.0]
[[plane]]
material = "shaped"
position_m = [4.0, 2.0, 3.0]
size_m = [8.0, 6.0]
tilt_deg = 35.0
[[box]]
material = "plain"
position_m = [-5.0, -3.0, 0.0]
size_m = [4.0, 4.0, 5.0]
[[instrument]]
name = "camera"
kind = "framing"
pixels = 24
lines = 24
altitude_agl_m = 120.0
gsd_m = 1.2
samples = {{ grid = [4, 4] }}
bands = {{ first_nm = 500.0, step_nm = 150.0, count = 3, fwhm_nm = 30.0 }}
[[lidar]]
name = "lidar"
position_m = [0.0, 0.0, 120.0]
prf_khz = 10.0
pulses = 8
{pulse}
[lidar.gate]
start_range_m = 90.0
stop_range_m = 135.0
[lidar.scan]
pattern = "oscillating"
rate_hz = 40.0
half_angle_deg = 4.0
[lidar.sampling]
subrays = 64
bounces = 2
"""


def middle(key):
    """A value inside the range that the schema allows, nearer to its lower end."""
    low = key.get("minimum", key.get("exclusiveMinimum", 0.0))
    return low + 0.35 * (key.get("maximum", low + 1.0) - low)


def holds(what, text):
    """Device and reference agree on the scene, camera and LIDAR alike."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "scene.toml"
        file.write_text(text)
        done = program.run(
            "check", file, "--rays", 2000, "--pixels", 32, "--model-pixels", 4, "--json", "-o", folder + "/out"
        )
        report = json.loads(done.stdout)
        for instrument, of in report.items():
            if isinstance(of, dict) and "passed" in of:
                program.check(of["passed"] is True, what, instrument, of)
                print(f"{what}: {instrument} within limits")


material = json.loads(program.run("scene", "schema").stdout)["properties"]["material"]["items"]["properties"]
shapes = {
    name: key["properties"]
    for name, key in material.items()
    if key.get("type") == "object" and all(of.get("type") == "number" for of in key["properties"].values())
}
program.check("gloss" in shapes, shapes)
for name, keys in shapes.items():
    shape = f"{name} = {{ {', '.join(f'{key} = {middle(of)}' for key, of in keys.items())} }}"
    holds(shape, SCENE.format(shape=shape, pulse=PULSE_AND_RECEIVER))
# A single leaf by what it is made of, instead of the reflectance.
leaf = "leaf = { prospect = { n = 1.6, cab_ug_cm2 = 40, car_ug_cm2 = 10, cw_cm = 0.01, cm_g_cm2 = 0.006 } }"
holds(leaf, SCENE.format(shape=leaf, pulse=PULSE_AND_RECEIVER).replace("reflectance = 0.4\n", "", 1))
# What would send back more light than comes.
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "scene.toml"
    bowl = "rpv = { k = 0.6, theta = -0.2, rho_c = 0.2 }"
    text = SCENE.format(shape=bowl, pulse=PULSE_AND_RECEIVER)
    file.write_text(text.replace("reflectance = 0.4", "reflectance = 0.9"))
    says = ["rpv", "more light would leave than comes", "80 degrees off the normal", "reflectance 0.9"]
    program.refused("render", file, "-o", folder + "/out", status=2, says=says)
print(f"shapes: {program.checks} checks")
