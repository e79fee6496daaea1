"""S20 S4.5: an aerosol of one's own in a scene file and by options: stated, from tables, from a refractive index and
sizes; what is wrong with one is said in one line each, with its place. Usage: own_aerosol_input_test.py RAYCUBE"""

import json
import math
import pathlib
import sys
import tempfile

from driver import Program, camera, own_cache

program = Program(sys.argv[1])
check = program.check

SCENE = """format = 1
time = {{ sun = {{ zenith_deg = 50 }} }}
material = [{{ name = "plate", reflectance = 0.5 }}]
plane = [{{ material = "plate", size_m = [60, 60] }}]
{camera}[atmosphere]
streams = 8
k_terms = 1
{keys}
[[atmosphere.own_aerosol]]
{own}
"""
STATED = "optical_depth = 0.3\nangstrom = 1.2\nsingle_scattering_albedo = 0.92\nasymmetry = 0.66\n"
SPHERES = "optical_depth = 0.3\nmedian_radius_um = [0.1]\ngeometric_sigma = [1.7]\n"

with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    env = {"XDG_CACHE_HOME": own_cache(folder)}

    def scene(own, keys=""):
        path = folder / "scene.toml"
        path.write_text(SCENE.format(keys=keys, own=own, camera=camera(2, 2, 2, first_nm=500, step_nm=20)))
        return path

    def file(name, text):
        (folder / name).write_text(text)
        return name

    def built(*given, **more):
        said = program.run(
            "atmos", "build", *given, "-o", folder / "air.rct", "--overwrite", "--step", 20, "--json", env=env, **more
        )
        return json.loads(said.stdout)["atmosphere"]["parameters"]

    # In a file: the whole aerosol is the user's; beside a shipped one where that is named. Both depths are said.
    seen = built(scene(STATED))
    check(seen["aod_550_from"] == "own aerosols" and abs(seen["aod_550"] - 0.3) < 1e-9, seen)
    check(seen["own_aerosols"][0]["single_scattering_albedo"] == [0.92], seen)
    rural = built(scene(STATED, 'aerosol = "rural"\naod_550 = 0.1'))
    check(abs(rural["aod_550"] - 0.4) < 1e-6 and rural["aerosol"] == "rural", rural)
    smoke = scene(STATED + 'name = "smoke"\n')
    said = program.run("atmos", "build", smoke, "-o", folder / "b.rct", "--step", 20, env=env)
    check("aerosol: optical depth 0.3 at 550 nm (smoke)" in said.stdout, said.stdout)

    # A depth at another wavelength, by Angstrom's law.
    seen = built(scene(STATED + "wavelength_nm = 440\n"))
    check(abs(seen["aod_550"] - 0.3 * (550 / 440) ** -1.2) < 1e-9, seen)

    # From tables: optics and refractive indices; sizes as modes or a modified gamma distribution; heights.
    file("optics.csv", "wavelength_nm,extinction,single_scattering_albedo,asymmetry\n300,3,0.9,0.7\n900,1,0.95,0.6\n")
    seen = built(scene('optical_depth = 0.3\noptics = "optics.csv"\nscale_height_km = 1.5\n'))
    check(seen["own_aerosols"][0]["extinction"] == [3, 1] and "angstrom" not in seen["own_aerosols"][0], seen)
    rows = "".join(f"{um},{','.join(str(0.6**k) for k in range(40))}\n" for um in (0.3, 0.9))
    file("moments.csv", f"wavelength_um,{','.join(f'moment_{k}' for k in range(40))}\n{rows}")
    built(scene('optical_depth = 0.3\nangstrom = 1\nsingle_scattering_albedo = 1\noptics = "moments.csv"\n'))
    file("index.csv", "wavelength_um,n,k\n0.3,1.5,0.01\n0.9,1.45,0.02\n")
    built(scene(SPHERES + 'refractive_index_file = "index.csv"\nextinction_profile = [[0, 1], [1, 0.5], [3, 0]]\n'))
    file("heights.csv", "height_m,extinction_per_km\n0,0.2\n1000,0.1\n3000,0\n")
    seen = built(scene(STATED + 'extinction_profile_file = "heights.csv"\n'))["own_aerosols"][0]
    check(seen["height_km"] == [0, 1, 3] and seen["height_extinction"] == [0.2, 0.1, 0], seen)
    built(scene("optical_depth = 0.3\nrefractive_index = [1.45, 0.001]\nmodified_gamma = [2, 15.1186, 0.5]\n"))

    # LIDARs: what Henyey-Greenstein says of backscatter is told of, unless its lidar ratio is stated.
    lidar = ("atmos", "lidar", scene(STATED), "--wavelengths", 532, "-o", folder / "lidar.rct", "--overwrite")
    check("backscatter is that of Henyey-Greenstein" in program.run(*lidar).stderr)
    stated = program.run(*lidar, "--lidar-ratio", "own=50", "--json")
    check("Henyey-Greenstein" not in stated.stderr, stated.stderr)
    ratio = json.loads(stated.stdout)["atmosphere"]["parameters"]["lidar_ratio_sr"]["own"][0]
    check(abs(ratio - 50) < 1e-9, ratio)

    # By options: the clear sky's defaults, in the layered model; the light that comes through follows Beer's law.
    bare = ("--sun-zenith", 0, "--from", 0.5, "--to", 0.56, "--highest", 0, "--no-cache")
    seen = built(*bare, "--aerosol", "own", "--aod", 0.2, "--scale-height", 1)
    own = seen["own_aerosols"][0]
    check((own["angstrom"], own["single_scattering_albedo"], own["asymmetry"]) == (1.2, [0.945], [0.65]), own)
    built(*bare, "--aerosol", "none")

    def sun(path):
        drawn = folder / "drawn.png"
        program.run("atmos", "plot", path, "-o", drawn, "--overwrite")
        figures = json.loads(drawn.with_suffix(".json").read_text())
        return figures["wavelength_um"], figures["sun_transmission"]

    um, clear = sun(folder / "air.rct")
    built(*bare, "--aerosol", "own", "--aod", 0.2, "--angstrom", 2, "--ssa", 1)
    for wave, before, after in zip(um, clear, sun(folder / "air.rct")[1]):
        depth = 0.2 * (wave / 0.55) ** -2
        # The layers of the two airs differ, and the plot's digits are five.
        check(abs(math.log(before / after) - depth) < 1e-3 * depth, (wave, before, after))

    def tabled(name, *rows):
        """STATED, its extinction from a table."""
        file(name, "wavelength_nm,extinction\n" + "\n".join(rows) + "\n")
        return STATED.replace("angstrom = 1.2", f'optics = "{name}"')

    file("down.csv", "height_km,extinction\n2,1\n1,1\n")
    file("only.csv", "wavelength_nm,extinction\n300,1\n900,1\n")
    # What is wrong is said by its place, once, and nothing is written.
    (folder / "air.rct").unlink()
    build = ("atmos", "build", "-o", folder / "air.rct")
    for own, says in (
        ("optical_depth = 0.3\nangstrom = 1.2\nasymmetry = 0.6\n", ("says nothing of its single-scattering albedo",)),
        ("optical_depth = -0.1\n" + STATED.split("\n", 1)[1], ("optical_depth", "-0.1")),
        (STATED.replace("0.92", "1.02"), ("single_scattering_albedo", "1.02")),
        (STATED.replace("0.66", "1"), ("asymmetry", "1")),
        (STATED.replace("0.66", "-1"), ("asymmetry", "-1")),
        (STATED + "phase_moments = [1, 0.6]\n", ("both an asymmetry and moments",)),
        (STATED.replace("asymmetry = 0.66", "phase_moments = [1, 0.9, 0.3]"), ("negative", "at", "deg")),
        (STATED.replace("asymmetry = 0.66", "phase_moments = [0.9, 0.3]"), ("chi_0, must be 1", "0.9")),
        (STATED + "median_radius_um = [0.1]\n", ("'median_radius_um' is of spheres",)),
        (STATED + "extinction_profile = [[2, 1], [1, 1]]\n", ("heights must ascend", "1 after 2")),
        (STATED + "extinction_profile = [[1, 1], [2, -1]]\n", ("must not be negative", "-1")),
        (STATED + "extinction_profile = [[1, 1], [2, 1]]\nscale_height_km = 2\n", ("exclude each other",)),
        (STATED + 'extinction_profile_file = "down.csv"\n', ("down.csv:3", "heights must ascend", "1 after 2")),
        (
            STATED + 'extinction_profile_file = "heights.csv"\nscale_height_km = 2\n',
            ("'extinction_profile_file' and 'scale_height_km' exclude each other",),
        ),
        (STATED + 'extinction_profile_file = "only.csv"\n', ("only.csv:1", "height_km or height_m")),
        (STATED + 'optics = "only.csv"\n', ("'angstrom' and the column extinction", "exclude each other")),
        (SPHERES + "refractive_index = [1.5, 0.01]\nangstrom = 1\n", ("'angstrom' states what Mie's series makes",)),
        (SPHERES + "refractive_index = [1.5, -0.01]\n", ("refractive_index", "-0.01")),
        ("optical_depth = 0.3\nrefractive_index = [1.5, 0.01]\n", ("a refractive index and no sizes",)),
        (SPHERES.replace("[1.7]", "[1.7, 2]") + "refractive_index = [1.5, 0]\n", ("2 for 1",)),
        (
            SPHERES.replace("0.1]", "0.1, 0.5]").replace("[1.7]", "[1.7, 2]") + "refractive_index = [1.5, 0]\n",
            ("0 for 2",),
        ),
        (tabled("back.csv", "600,1", "500,2"), ("back.csv:3", "must ascend")),
        (tabled("gap.csv", "505,1", "600,2"), ("cover 0.505 to 0.6 um", "and the table more")),
        (tabled("zero.csv", "300,0", "600,2"), ("zero.csv:2", "extinction must lie in 0 to")),
    ):
        program.refused(*build, scene(own), status=2, says=list(says))
    for given, says in (
        (("--aerosol", "own"), ("how much of it", "--aod")),
        (("--aerosol", "own", "--aod", 0.1, "--visibility", 5), ("--visibility",)),
        (("--aerosol", "own", "--aod", 0.1, "--humidity", 50), ("--humidity is for a shipped aerosol",)),
        (("--ssa", 0.9), ("--ssa belongs to --model clear_sky, or to --aerosol own",)),
        (("--scale-height", 1), ("--scale-height belongs to --aerosol own",)),
        (("--model", "clear_sky", "--scale-height", 1), ("--scale-height belongs to --model layered",)),
    ):
        program.refused(*build, "--sun-zenith", 50, *given, status=2, says=list(says))
    program.refused(
        *build, scene(STATED, "aod_550 = 0.2"), status=2, says=["scene.toml:", "'aod_550' belongs to a shipped aerosol"]
    )
    program.refused(*build, scene(STATED), "--aod", 0.2, status=2, says=["--aod 0.2", "aerosols of its own"])
    check(not (folder / "air.rct").exists())
    # An aerosol that is named takes the place of all of the file's.
    check("own_aerosols" not in built(scene(STATED), "--aerosol", "rural"))
print(f"own aerosol: ok, {program.checks} checks")
