"""S21 S61: every scattering shape that a material can have (its table in the simulation file), seen by a camera and by
a LIDAR whose pulses bounce: `raycube check` holds the device against the reference, whatever the shape.
usage: shapes_test.py RAYCUBE [--full]; without --full two of the shapes."""

import json
import pathlib
import sys
import tempfile

from driver import Program, pulse_and_receiver

program = Program(sys.argv[1])
PULSE_AND_RECEIVER = pulse_and_receiver(fov_mrad=400.0)  # it sees what is scattered twice

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
[[box]]
material = "shaped"
position_m = [-2.5, 1.0, 0.0]
size_m = [2.0, 9.0, 9.0]
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


def number(key):
    """Schema of one number of a shape, which may also be given as a list; None: it is something else."""
    return next((of for of in key.get("anyOf", []) if of.get("type") == "number"), None)


def inside(key, part=0.35):
    """A value inside the range that the schema allows, nearer to its lower end; of an exponent what cameras see."""
    of = number(key)
    if of.get("maximum") == 100 and of.get("minimum") == 1:
        return 10 + 60 * part
    low = of.get("minimum", of.get("exclusiveMinimum", 0.0))
    return low + part * (of.get("maximum", low + 1.0) - low)


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
                if instrument == "lidar":  # else nothing that was scattered twice was compared
                    program.check(of["scattered"]["groups"] > 0, what, of["scattered"])
                print(f"{what}: {instrument} within limits")


material = json.loads(program.run("scene", "schema").stdout)["properties"]["material"]["items"]["properties"]
shapes = {
    name: key["properties"]
    for name, key in material.items()
    if key.get("type") == "object" and "at_nm" in key["properties"]
}
program.check("gloss" in shapes, shapes)
if "--full" not in sys.argv:  # one that reflects and one that mirrors; each of the others takes 5 to 10 s
    shapes = {name: shapes[name] for name in ("oren_nayar", "gloss")}
for name, keys in shapes.items():
    numbers = {key: of for key, of in keys.items() if number(of)}
    program.check(len(numbers) == len(keys) - 1, keys)
    shape = f"{name} = {{ {', '.join(f'{key} = {inside(of)}' for key, of in numbers.items())} }}"
    holds(shape, SCENE.format(shape=shape, pulse=PULSE_AND_RECEIVER))
    # Given at wavelengths on both sides of the bands and of the pulses.
    lists = ", ".join(f"{key} = [{inside(of, 0.5)}, {inside(of, 0.3)}]" for key, of in numbers.items())
    changing = f"{name} = {{ at_nm = [520.0, 1200.0], {lists} }}"
    text = SCENE.format(shape=changing, pulse=PULSE_AND_RECEIVER)
    if name == "hapke":  # by the material's curve, which is single-scattering albedo, and not by wavelength
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "scene.toml"
            file.write_text(text)
            program.refused("scene", "check", file, status=2, says=["'at_nm' means nothing for hapke"])
        continue
    holds(changing, text)
# A single leaf by what it is made of, instead of the reflectance.
leaf = "leaf = { prospect = { n = 1.6, cab_ug_cm2 = 40, car_ug_cm2 = 10, cw_cm = 0.01, cm_g_cm2 = 0.006 } }"
holds(leaf, SCENE.format(shape=leaf, pulse=PULSE_AND_RECEIVER).replace("reflectance = 0.4\n", "", 1))
# What changes with the curve, or by Fresnel's law for a measured index: both from files.
with tempfile.TemporaryDirectory() as folder:
    soil = pathlib.Path(folder) / "soil.csv"
    soil.write_text("wavelength_nm,reflectance\n400,0.35\n600,0.6\n800,0.85\n1000,0.9\n")
    shape = "hapke = { b = 0.3, c = 0.2, slope_deg = 15.0, b0 = 0.6, h = 0.08 }"
    soil.write_text(soil.read_text() + "1100,0.8\n")
    text = SCENE.format(shape=shape, pulse=PULSE_AND_RECEIVER).replace("reflectance = 0.4", f'file = "{soil}"', 1)
    holds("hapke, albedo 0.35 to 0.9", text)
    gold = pathlib.Path(folder) / "gold.csv"
    rows = ("400,1.47,1.95", "500,0.97,1.87", "600,0.25,3.03", "700,0.13,4.06", "900,0.17,5.72", "1100,0.28,7.3")
    gold.write_text("wavelength_nm,n,k\n" + "\n".join(rows) + "\n")  # Johnson & Christy (1972), rounded
    metal = f'fresnel = {{ roughness = 0.6, file = "{gold}" }}'
    text = SCENE.format(shape=metal, pulse=PULSE_AND_RECEIVER).replace("reflectance = 0.4", "reflectance = 0.01", 1)
    holds("gold", text)
    file = pathlib.Path(folder) / "scene.toml"
    file.write_text(text)
    for wrong, says in (
        ("wavelength_nm,k\n400,1\n500,1\n", ["gold.csv:1", "no column 'n'"]),
        ("wavelength_nm,n,k\n400,1.4,-2\n500,1,1\n", ["gold.csv:2", "k is not within 0 .. 1000", "-2"]),
        ("wavelength_nm,n\n500,1.4\n400,1\n", ["gold.csv:3", "wavelengths are not ascending", "0.4 um after 0.5"]),
        ("wavelength_nm,n\n500,1.4\n", ["a refractive index needs two wavelengths at least"]),
        ("wavelength_nm,n,k\n520,1.4,1\n580,1,1\n", ["the index of material 'shaped'"]),
    ):
        gold.write_text(wrong)
        program.refused("plan", file, "--instrument", "camera", status=2, says=says)
# A goniometer's table: the camera above the lit field sees the file's factor, wavelength by wavelength.
with tempfile.TemporaryDirectory() as folder:
    table = pathlib.Path(folder) / "sand.csv"
    rows = ["light_zenith_deg,view_zenith_deg,relative_azimuth_deg,500nm,1.2um"]
    for light in (0, 30, 55, 75):
        for view in (0, 25, 60):
            for turn in (0, 90, 180) if light and view else (0,):
                lobe = 1 + 0.002 * light - 0.001 * view * turn / 90 + 1e-5 * light * view * (turn == 0)
                rows.append(f"{light},{view},{turn},{0.9 * lobe:.6f},{1.1 * lobe:.6f}")
    table.write_text("\n".join(rows) + "\n")
    measured = f'measured = {{ file = "{table}" }}'
    holds("measured", SCENE.format(shape=measured, pulse=PULSE_AND_RECEIVER))
    file = pathlib.Path(folder) / "scene.toml"
    for wrong, says in (
        (rows[:-1], ["sand.csv", "1 combination of its angles has no factor", "light 75, viewer 60, azimuth 180"]),
        ([rows[0], "0,0,0,1.4,3.5"], ["measured", "more light would leave than comes", "albedo 1.4"]),
    ):
        table.write_text("\n".join(wrong) + "\n")
        file.write_text(SCENE.format(shape=measured, pulse=PULSE_AND_RECEIVER))
        program.refused("scene", "check", file, status=2, says=says)
    file.write_text(SCENE.format(shape='measured = { file = "none.csv" }', pulse=PULSE_AND_RECEIVER))
    program.refused("scene", "check", file, status=2, says=["none.csv", "scene.toml"])
for pair in ("gloss = { roughness = 0.2, f0 = 0.1 }\nphong = { exponent = 9.0, reflectance = 0.1 }",):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "scene.toml"
        file.write_text(SCENE.format(shape=pair, pulse=PULSE_AND_RECEIVER))
        program.refused("scene", "check", file, status=2, says=["a material has one gloss", "gloss and phong"])
# Lists that do not fit their wavelengths.
for shape, says in (
    ("gloss = { roughness = 0.2, f0 = [0.1, 0.2] }", ["'f0' is not of as many wavelengths as 'at_nm'", "2 values, 0"]),
    (
        "rpv = { at_nm = [500, 600, 700], k = [0.8, 0.9], theta = 0.0, rho_c = 1.0 }",
        ["'k' is not of as many wavelengths as 'at_nm'", "2 values, 3 wavelengths"],
    ),
    ("oren_nayar = { at_nm = [600, 500], sigma_deg = [10, 20] }", ["'at_nm' must ascend", "500 after 600"]),
    ("oren_nayar = { at_nm = [500, 600], sigma_deg = 10 }", ["'at_nm' means nothing where no number changes"]),
    ("oren_nayar = { at_nm = [500, 600], sigma_deg = [10, 95] }", ["'sigma_deg' is out of range", "95"]),
):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "scene.toml"
        file.write_text(SCENE.format(shape=shape, pulse=PULSE_AND_RECEIVER))
        program.refused("scene", "check", file, status=2, says=says)
# What would send back more light than comes; of lists at a wavelength that no curve names.
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "scene.toml"
    lists = "rpv = { at_nm = [450, 550, 650], k = [1, 0.6, 1], theta = [0, -0.2, 0], rho_c = [1, 0.2, 1] }"
    file.write_text(SCENE.format(shape=lists, pulse=PULSE_AND_RECEIVER).replace("= 0.4", "= 0.7", 1))
    program.refused("scene", "check", file, status=2, says=["more light would leave than comes", "at 550 nm"])
    lists = "gloss = { at_nm = [450, 650], roughness = 0.3, f0 = [0, 0.7] }"
    file.write_text(SCENE.format(shape=lists, pulse=PULSE_AND_RECEIVER))
    program.refused("scene", "check", file, status=2, says=["f0 above 1", "0.4 + 0.7"])
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "scene.toml"
    bowl = "rpv = { k = 0.6, theta = -0.2, rho_c = 0.2 }"
    text = SCENE.format(shape=bowl, pulse=PULSE_AND_RECEIVER)
    file.write_text(text.replace("reflectance = 0.4", "reflectance = 0.9"))
    says = ["rpv", "more light would leave than comes", "80 degrees off the normal", "reflectance 0.9"]
    program.refused("render", file, "-o", folder + "/out", status=2, says=says)

# Light goes straight on through the tilted plane, which mirrors too.
pane = '[[material]]\nname = "pane"\nreflectance = 0.05\ntransmittance = 0.8\ntransmission = "plate"\n'
glazed = SCENE.format(shape=pane + "gloss = { roughness = 0.3, f0 = 0.05 }", pulse=PULSE_AND_RECEIVER)
holds("plate", glazed.replace('material = "shaped"\nposition_m = [4.0', 'material = "pane"\nposition_m = [4.0', 1))
print(f"shapes: {program.checks} checks")
