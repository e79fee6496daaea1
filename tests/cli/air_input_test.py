"""S18 S20: what a user says of the air is used or refused: amounts of aerosol that contradict each other, keys beside
a table, air without air; the optical depth that a visibility makes; a kept table whose input files have changed.
Usage: air_input_test.py RAYCUBE"""

import json
import os
import pathlib
import sys
import tempfile

from driver import Program, camera, options, own_cache

program = Program(sys.argv[1])
check = program.check

SCENE = """format = 1
time = {{ sun = {{ zenith_deg = 50 }} }}
material = [{{ name = "plate", reflectance = 0.5 }}]
plane = [{{ material = "plate", size_m = [60, 60] }}]
{camera}[thermal]
default_temperature_K = 300
[atmosphere]
{keys}
"""

with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    env = {"XDG_CACHE_HOME": own_cache(folder)}

    def scene(keys):
        path = folder / "scene.toml"
        path.write_text(SCENE.format(keys=keys, camera=camera(2, 2, 2, first_nm=3950)))
        return path

    # Options that contradict each other are refused by name, and nothing is written.
    build = ("atmos", "build", "--sun-zenith", 50, "-o", folder / "air.rct")
    lidar = ("atmos", "lidar", "--wavelengths", 532, "-o", folder / "air.rct")
    for verb in (build, lidar):
        for given, says in (
            (("--aerosol", "none", "--aod", 0.5), ("--aod 0.5", "no aerosol", "--aerosol none")),
            (("--aerosol", "none", "--visibility", 5), ("--visibility 5", "no aerosol")),
            (("--aerosol", "none", "--humidity", 50), ("--humidity 50", "no aerosol")),
            (("--visibility", 10, "--aod", 0.2), ("--visibility 10", "--aod 0.2", "remove one")),
            (("--fill", "tropical"), ("--fill tropical", "no profile file")),
        ):
            program.refused(*verb, *given, status=2, says=list(says))
        program.refused(
            *verb, scene('aerosol = "none"'), "--aod", 0.5, status=2, says=["--aod 0.5", 'aerosol = "none"']
        )
    for option, value in (
        ("--water", 2),
        ("--aod", 0.1),
        ("--aerosol", "rural"),
        ("--model", "layered"),
        ("--visibility", 5),
        ("--ozone", 0.3),
    ):
        program.refused(*build, "--no-air", option, value, status=2, says=[option, "without air", "--no-air"])
    program.refused(*build, scene('model = "none"'), "--aod", 0.1, status=2, says=["--aod", 'model = "none"'])
    check(not (folder / "air.rct").exists())

    # So are keys of a scene file: by key, all of them at once.
    sky = options(model="clear_sky", sun_zenith=50, sensor_height=500, to=4.0)
    program.run("atmos", "build", *sky, "-o", folder / "sky.rct")
    columns = ("water_g_cm2", "ozone_atm_cm", "aod_550")
    values = "water_g_cm2 = 2\nozone_atm_cm = 0.3\naod_550 = 0.1"
    for keys, refused in (
        ('aerosol = "none"\naod_550 = 0.5\nhumidity_percent = 40', ("aod_550", "humidity_percent")),
        (
            'aerosol = "none"\nvisibility_km = 5\nseason = "fall_winter"\nstratosphere = "background"',
            ("visibility_km", "season", "stratosphere"),
        ),
        ("wind_m_s = 12", ("wind_m_s",)),
        (f'tables = "sky.rct"\n{values}', columns),
        (f'model = "none"\n{values}\npressure_hPa = 900\nadjacency = "local"', (*columns, "pressure_hPa", "adjacency")),
    ):
        said = program.run("scene", "check", scene(keys), status=2)
        check("scene.toml:" in said.stderr and said.stdout == "", said.stderr)
        for key in refused:
            check(f"'{key}'" in said.stderr, key, said.stderr)
    for keys in (
        'aerosol = "none"\naod_550 = 0',
        'model = "none"\nadjacency = "off"',
        'aerosol = "desert"\nwind_m_s = 12',
        'tables = "sky.rct"\npressure_hPa = 950\nground_height_m = 100',
    ):
        program.run("scene", "check", scene(keys))

    # A model that is not the file's takes over what both know of the air, in either direction, exactly as if the
    # file had named it, and refuses by name what it does not know.
    other = {"clear_sky": "layered", "layered": "clear_sky"}
    shared = "pressure_hPa = 950\nwater_g_cm2 = 1.1\nozone_atm_cm = 0.25\naod_550 = 0.4\nground_height_m = 300"
    grid = ("--from", 3.9, "--to", 4.0, "--step", 100, "--highest", 0, "--overwrite", "-o", folder / "air.rct")

    def made(keys, *options):
        return json.loads(program.run("atmos", "build", scene(keys), *grid, "--json", *options, env=env).stdout)

    def is_air(seen, water, ozone, aod):
        p = seen["atmosphere"]["parameters"]
        check(abs(p["water_g_cm2"] - water) < 0.01 and abs(p["ozone_atm_cm"] - ozone) < 1e-3, p)
        check(abs(p["aod_550"] - aod) < 1e-9, p)

    for model, wanted in other.items():
        own, same = f'model = "{model}"\n{shared}', made(f'model = "{wanted}"\n{shared}')
        turned = made(own, "--model", wanted)
        is_air(turned, 1.1, 0.25, 0.4)
        check(turned["content_hash"] == same["content_hash"], wanted)
        check(made(own, "--model", model)["content_hash"] == made(own)["content_hash"])
        # An option still goes before the file, and the file's word of no air gives way to a model.
        is_air(made(own, "--model", wanted, "--water", 0.7, "--aod", 0.2), 0.7, 0.25, 0.2)
        airless = made('model = "none"', "--model", wanted)
        check(airless["content_hash"] == made(f'model = "{wanted}"')["content_hash"])
    below = made("pressure_hPa = 700", "--ground-height", 300)["atmosphere"]["parameters"]
    check(950 < below["ground_pressure_hPa"] < 1000, below)  # "sets the pressure too"
    cloud = "[[atmosphere.cloud]]\nbase_km = 1\ntop_km = 2\noptical_depth_550 = 7"
    for model, keys, refused in (
        ("clear_sky", "angstrom = 1.3\nground_albedo = 0.2", {"angstrom": "1.3", "ground_albedo": "0.2"}),
        (
            "layered",
            f'profile = "tropical"\nvisibility_km = 5\nk_terms = 2\n{cloud}',
            {"profile": '"tropical"', "visibility_km": "5.0", "k_terms": "2", "cloud": '"top_km":2.0'},
        ),
    ):
        file, way = scene(f'model = "{model}"\n{keys}'), ("--model", other[model])
        says = ["scene.toml:", f"and {other[model]} is asked for instead", "remove it, or choose that model"]
        for key, value in refused.items():
            says += [f"'{key}' belongs to model = \"{model}\"", value]
        program.refused("atmos", "build", file, *grid, *way, status=2, messages=len(refused), says=says)

    # The depth that a visibility makes is told, in words, as JSON and in run.json; asked for by that depth the air is
    # the same.
    small = ("--from", 3.9, "--to", 4.0, "--step", 100, "--highest", 0, "--overwrite")

    def told(*options):
        return json.loads(program.run(*build, *small, *options, "--json", env=env).stdout)["atmosphere"]["parameters"]

    said = program.run(*build, *small, "--visibility", 5, env=env).stdout
    check("aerosol: optical depth 1." in said and "at 550 nm (rural, visibility 5 km)" in said, said)
    seen = told("--visibility", 5)
    depth = seen["aod_550"]
    # LOWTRAN7 at 5 km: 0.770 km-1 to 1 km, from there exponential to 0.0621 km-1 at 2 km: 0.770 + 0.281, and 0.05 to
    # 0.15 of what lies above.
    check(1.05 + 0.05 < depth < 1.05 + 0.15 and seen["aod_550_from"] == "visibility" and f"{depth:.4g}" in said, seen)
    again = told("--aod", repr(depth))
    check(abs(again["visibility_km"] - 5) < 1e-6 and again["aod_550_from"] == "stated", again)
    check(abs(again["aod_550"] - depth) < 1e-9, again)
    none = told("--aerosol", "none")
    check(none["aod_550"] == 0 and none["visibility_km"] is None, none)
    check("optical depth" in program.run(*lidar, "--overwrite", env=env).stdout)

    # A file whose content has changed under its name, size and time makes another table, and does not take the kept
    # one.
    head = "wavenumber_per_cm,pressure_hPa,temperature_K,cross_section_cm2\n"
    table = folder / "gas.csv"
    gas = '[[atmosphere.cross_section]]\ngas = "xy"\nfile = "gas.csv"\nmixing_ratio_ppmv = 1'
    path = scene("streams = 4\n" + gas)
    hashes = []
    for value in (1, 1, 3):
        table.write_text(head + f"2400,1000,290,{value}e-20\n2700,1000,290,{value}e-20\n")
        os.utime(table, ns=(10**18, 10**18))
        made = program.run("atmos", "build", path, "-o", folder / "gas.rct", "--overwrite", "--json", "-v", env=env)
        hashes.append(json.loads(made.stdout)["content_hash"])
        check(("table from the cache" in made.stderr) == (len(hashes) == 2), made.stderr)
    check(hashes[0] == hashes[1] != hashes[2], hashes)

    program.run("render", path, "-o", folder / "out", "-q", env=env)
    record = json.loads((folder / "out" / "camera" / "run.json").read_text())["atmosphere"]
    check(record["parameters"]["aod_550"] > 0.1 and record["model"] == "raycube layered air", record)
print(f"air input: ok, {program.checks} checks")
