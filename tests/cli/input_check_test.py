#!/usr/bin/env python3
"""What inputs alone say is wrong is told before any air is computed or ray sent, by `scene check` and at the start of
render, check, plan and chart alike; what nothing uses is not asked. The built-in air of these scenes would take a
minute, and be told and kept. usage: input_check_test.py RAYCUBE"""

import pathlib
import re
import sys
import tempfile

from driver import GROUND, PULSE_AND_RECEIVER, Program, options, record, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
LAYERED = '{ model = "layered" }'

SONDE = """height_km,pressure_hPa,temperature_K,h2o_relative_humidity_percent
{ground},900,288,{humidity}
5,540,255,50
12,190,216,50
"""
LIDAR = (
    "format = 1\n"
    + GROUND
    + """[time]
sun = { zenith_deg = 30.0, azimuth_deg = 150.0 }
[[lidar]]
name = "scan"
position_m = [0.0, 0.0, 500.0]
prf_khz = 10.0
pulses = 4
"""
    + PULSE_AND_RECEIVER
    + """[lidar.gate]
start_range_m = 400.0
stop_range_m = 600.0
[lidar.detector]
solar_background = true
"""
)


def lidar(work, name, air):
    path = work / name
    path.write_text(LIDAR.replace("[[lidar]]", f"[atmosphere]\n{air.strip('{} ').replace(', ', chr(10))}\n[[lidar]]"))
    return path


def edited(path, old, new):
    text = path.read_text()
    assert old in text, (path, old)
    path.write_text(text.replace(old, new))
    return path


def nothing_computed(work, done, *what):
    """No air, which would be told when it is done and kept in the cache, and no kernel, which would be kept as well."""
    check(not re.search(r"atmosphere +\d+ %", done.stderr), *what, done.stderr)
    cache = work / "cache"
    check(not [path for path in cache.rglob("*") if path.is_file()], *what, list(cache.rglob("*")))


def all_refuse(work, file, says, more=()):
    """Every verb that would compute refuses alike, before it has computed anything."""
    verbs = [
        ["scene", "check", file],
        ["render", file, "-o", work / "out"],
        ["render", file, "--dry-run"],
        ["plan", file],
        ["check", file],
        ["chart", file, "-o", work / "chart"],
    ]
    texts = set()
    for verb in verbs:
        done = run(*verb, status=2, env={"XDG_CACHE_HOME": str(work / "cache")})
        nothing_computed(work, done, verb)
        texts.add("\n".join(line for line in done.stderr.splitlines() if line.startswith("raycube: error: ")))
        check(done.stdout == "" and not (work / "out").exists(), verb, done.stdout)
    check(len(texts) == 1, texts)
    text = texts.pop()
    for part in says:
        check(part in text, part, text)
    return text


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    (work / "narrow.csv").write_text("wavelength_nm,reflectance\n500,0.1\n700,0.2\n")
    (work / "late.csv").write_text(
        "# source: somebody's, who does not say which file\nwavelength_nm,reflectance\n500,0.1\n2500,0.2\n"
    )
    kDark = '{ name = "dark", reflectance = 0.10 }'

    def with_material(name, text, **more):
        return edited(scene(work, name, **more), kDark, text)

    # A material nobody uses is not asked for its curve, nor for a temperature: the same bytes as without it.
    plain = scene(work, "plain.toml")
    unused = with_material("unused.toml", kDark + ',\n  { name = "nobody", file = "narrow.csv" }')
    run("render", plain, "-o", work / "plain")
    check("sound" in run("scene", "check", unused).stdout)
    run("render", unused, "-o", work / "unused")
    check((work / "unused/camera/radiance.img").read_bytes() == (work / "plain/camera/radiance.img").read_bytes())
    run("check", unused, "--rays", "1000", "--pixels", "8")
    run("plan", unused)

    # Nor is that of a mesh which is listed and never placed; placed, it is used.
    (work / "m.obj").write_text("v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n")
    mesh = 'mesh = [{ name = "spare", file = "m.obj", material = "nobody" }]\n'
    listed = edited(
        with_material("listed.toml", kDark + ',\n  { name = "nobody", file = "narrow.csv" }'),
        "plane = [",
        mesh + "plane = [",
    )
    check("sound" in run("scene", "check", listed).stdout)
    run("render", listed, "-o", work / "listed")
    check((work / "listed/camera/radiance.img").read_bytes() == (work / "plain/camera/radiance.img").read_bytes())
    run("check", listed, "--rays", "1000", "--pixels", "8")
    run("plan", listed)
    placed = edited(listed, "plane = [", 'instance = [{ mesh = "spare" }]\nplane = [')
    all_refuse(work, placed, ["material 'nobody'", "covers 500 to ", "narrow.csv"])

    # One that is used is told with its file, its range, what is needed, and which end is short.
    for name, file, ends in (
        ("late.toml", "late.csv", "it begins too late"),
        ("narrow.toml", "narrow.csv", "it begins too late and ends too early"),
    ):
        bad = with_material(name, f'{{ name = "dark", file = "{file}" }}', air=LAYERED)
        all_refuse(
            work, bad, ["instrument 'camera'", "material 'dark'", "covers 500 to ", ends, "band 1 400 to 500 nm", file]
        )

    # Everything at once: a curve, a temperature, a view and a band out of the model.
    several = with_material("several.toml", '{ name = "dark", file = "narrow.csv" }', air=LAYERED)
    edited(
        several,
        "bands = { first_nm = 450.0, step_nm = 50.0, count = 10, fwhm_nm = 20.0 }",
        "bands = { first_nm = 10000.0, step_nm = 50.0, count = 2, fwhm_nm = 20.0 }",
    )
    text = all_refuse(
        work,
        several,
        ["it ends too early", "material 'dark': has no temperature", "material 'light': has no temperature"],
    )
    check(text.count("\n") == 3, text)  # one curve, three temperatures

    beyond = edited(scene(work, "beyond.toml", air=LAYERED), "first_nm = 450.0", "first_nm = 250.0")
    all_refuse(work, beyond, ["the layered model covers 0.3 to 30 um"])
    level = scene(work, "level.toml", air=LAYERED, instrument="pitch_deg = 90.0")
    all_refuse(work, level, ["looks up or level"])

    # A table that ends inside a band, of another sun or height, is refused by its file's name.
    sky = options(model="clear_sky", sun_zenith=40, sun_azimuth=150, sensor_height=500, to=0.8)
    run("atmos", "build", *sky, "--from", 0.42, "-o", work / "air.rct")
    table = scene(work, "table.toml", air='{ tables = "air.rct" }')
    all_refuse(work, table, ["air.rct' covers 420 to 800 nm", "it begins too late and ends too early"])

    # A sounding is read, whoever asks for it: wetter than any air, or far above the ground.
    (work / "wet.csv").write_text(SONDE.format(ground=0, humidity=140))
    (work / "high.csv").write_text(SONDE.format(ground=1.5, humidity=40))
    for name, says in (
        ("wet", ["wet.csv:2", "no more water than 100 %", "140 %"]),
        ("high", ["high.csv", "lowest level of 1.5 km", "ground_height_m"]),
    ):
        air = f'{{ model = "layered", profile_file = "{name}.csv" }}'
        all_refuse(work, scene(work, name + ".toml", air=air), says)
        all_refuse(work, lidar(work, name + "_lidar.toml", air), says)
    # Lines that are not there.
    all_refuse(work, scene(work, "lines.toml", air='{ model = "layered", lines = "none.par" }'), ["none.par"])
    # What a LIDAR's background of light asks of the materials: temperatures at 3.3 um, curves over the whole filter.
    (work / "line.csv").write_text("wavelength_nm,reflectance\n1063.9,0.1\n1064.1,0.2\n")
    for name, change, says in (
        ("cold", ("1064.0", "3300.0"), ["material 'ground': has no temperature"]),
        ("line", ("reflectance = 0.3", 'file = "line.csv"'), ["line.csv", "begins too late and ends too early"]),
    ):
        light = edited(lidar(work, name + "_light.toml", LAYERED), *change)
        for verb in (["scene", "check", light], ["plan", light], ["render", light, "-o", work / "out"]):
            refused(
                *verb,
                status=2,
                says=[
                    "LIDAR 'scan': the light of the scene in its field of view",
                    "set solar_background = false",
                    *says,
                ],
            )
            check(not (work / "out").exists())
        dark = edited(
            edited(lidar(work, name + "_dark.toml", LAYERED), *change),
            "solar_background = true",
            "solar_background = false",
        )
        check("sound" in run("scene", "check", dark).stdout)
    up = edited(lidar(work, "up.toml", LAYERED), "prf_khz = 10.0", "prf_khz = 10.0\npitch_deg = 180.0")
    refused("scene", "check", up, status=2, says=["LIDAR 'scan'", "looks up or level", "set solar_background = false"])

    # A tolerance that no plan holds, by the whole tables, before a kernel is compiled; `scene check` knows where no air
    # is to be computed.
    bound = ("atmos", "build", "--model", "clear_sky", "--sun-zenith", "40", "--sun-azimuth", "150")
    run(*bound, "--sensor-height", "500", "-o", work / "sun.rct")
    head = "tolerance = 1e-7\nbounces = 0"
    fine = scene(work, "fine.toml", head=head, air='{ tables = "sun.rct" }', pixels=2, lines=2)
    refused("scene", "check", fine, status=2, says=["32 channels cannot hold the tolerance of 1e-07", "measured on "])
    check("sound" in run("scene", "check", fine, "--set", "tolerance=0.01").stdout)

    # The clear sky is formulas, which `scene check` evaluates; a layered air is solved by `plan` first, and kept.
    air = '{ model = "clear_sky" }'
    clear = scene(work, "clear.toml", head=head, air=air, pixels=2, lines=2)
    refused("scene", "check", clear, status=2, says=["32 channels cannot hold the tolerance of 1e-07", "measured on "])
    check("0 notices" in run("scene", "check", clear, "--set", "tolerance=0.01").stdout)
    solved = edited(
        scene(work, "solved.toml", head=head, air=LAYERED, pixels=2, lines=2), "count = 10, fwhm_nm = 20.0",
        "count = 1, fwhm_nm = 2.0"
    )
    kept = {"XDG_CACHE_HOME": str(work / "kept")}
    done = run("scene", "check", solved, env=kept)
    check("1 notice" in done.stdout and "`raycube plan` does" in done.stderr, done)
    check("0 notices" in run("scene", "check", solved, "--set", "tolerance=0.01", env=kept).stdout)
    planned = refused("plan", solved, status=2, says=["cannot hold the tolerance"], env=kept).stderr.splitlines()
    checked = refused("scene", "check", solved, status=2, says=["cannot hold the tolerance"], env=kept).stderr
    check(checked.strip() in planned, checked, planned)

    # What a table will hold is known before it is computed: how far it looks, which rows it has; and nodes of more
    # channels than there are, whatever the air.
    for model in ("clear_sky", "layered"):
        air = f'{{ model = "{model}" }}'
        oblique = edited(scene(work, "oblique.toml", air=air), "altitude_agl_m = 500.0", "position_m = [0, 0, 500]")
        edited(oblique, "gsd_m = 1.0", "ifov_mrad = 1.0\npitch_deg = 84.0")
        all_refuse(work, oblique, ["looks 84.34 deg off nadir", "ends at 80.00 deg"])
        for nodes in ("height_nodes = 3, path_nodes = 5", "height_nodes = 5, view_nodes = 7"):
            many = scene(work, "many.toml", air=air, head=f"plan = {{ {nodes} }}")
            all_refuse(work, many, ["[plan] asks for what no plan can have", nodes.replace(" =", "")])
    coupled = scene(work, "coupled.toml", air='{ model = "clear_sky", adjacency = "local" }')
    all_refuse(work, coupled, ["the atmosphere table lacks one of spherical_albedo"])

    # An output that may not be replaced is known as early.
    done = refused(
        "render",
        scene(work, "again.toml", air=LAYERED),
        "-o",
        work / "plain",
        status=2,
        says=["is there already", "--overwrite"],
        env={"XDG_CACHE_HOME": str(work / "cache")},
    )
    nothing_computed(work, done)
print(f"input check: {program.checks} checks")
