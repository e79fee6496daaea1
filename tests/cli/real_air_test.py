#!/usr/bin/env python3
"""Real outputs of MODTRAN and libRadtran as the air of a render, and a real line list: the channels of a .chn as
bands are its own values; one direction serves no other; a line list that changed under its name makes another
table.
usage: real_air_test.py RAYCUBE; outputs from the folder RAYCUBE_SHARED"""

import csv
import json
import math
import os
import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi, own_cache, plate, record

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
shared = pathlib.Path(os.environ.get("RAYCUBE_SHARED") or "/nonexistent") / "reference" / "atmosphere"
if not shared.is_dir():
    print("SKIPPED renders under real air: RAYCUBE_SHARED does not name a folder of real outputs")
    sys.exit(77)
REFLECTANCE = 0.3


def rows_of(path):
    """A CSV of numbers under comments, as lists by column."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    table = list(csv.reader(lines))
    return {name: numpy.array([float(row[i]) for row in table[1:]]) for i, name in enumerate(table[0])}


def plane(work, table, sun, agl_m, bands, pitch=0):
    (work / "bands.csv").write_text("center_nm,fwhm_nm\n" + "".join(f"{c!r},{w!r}\n" for c, w in bands))
    head = f"""atmosphere = {{ tables = "{table}" }}
thermal = {{ below_3um = "left_out" }}
time = {{ sun = {{ zenith_deg = {sun}, azimuth_deg = 150.0 }} }}"""
    return plate(work, head, agl_m=agl_m, lines=2, grid=2, pitch_deg=pitch, size_m=8000.0, reflectance=REFLECTANCE)


def rendered(work, file):
    done = run("render", file, "-o", work / "out", "--overwrite")
    cube = envi(work / "out/camera", "radiance")[1].astype(float)
    return done, cube.reshape(8, -1), record(work / "out/camera")["warnings"]


def one_direction(work, table, sun, agl_m, bands):
    """Said at 10 degrees of pitch, refused at 40 with the angles, by render and `scene check` alike."""
    _, _, warnings = rendered(work, plane(work, table, sun, agl_m, bands, pitch=10))
    said = [text for text in warnings if "one view zenith, 0 deg" in text]
    check(len(said) == 1 and "to 10.06 deg off nadir" in said[0], warnings)
    aside = plane(work, table, sun, agl_m, bands, pitch=40)
    for verb in (["render", aside, "-o", work / "aside"], ["scene", "check", aside], ["plan", aside]):
        refused(
            *verb,
            status=2,
            says=["instrument 'camera'", "one view zenith, 0 deg", "39.94 to 40.06 deg off nadir", "import runs"],
        )
    check(not (work / "aside").exists())


def channels(work):
    """A MODTRAN 6 .chn of 425 channels. Oracle: the same run's columns as the reference tables restate them."""
    sun, agl_m, case = 51.993, 1950.0, "a0.01_w1.5"
    chn = shared / "samples/modtran/isofit_modtran6_vswir.chn"
    run(
        "atmos",
        "import",
        chn,
        "--sun-zenith",
        sun,
        "--sun-azimuth",
        150,
        "--sensor-height",
        agl_m,
        "--even-sky",
        "-o",
        work / "chn.rct",
    )
    told = rows_of(shared / "anchors/modtran6_isofit_pasadena_vswir.csv")
    column = lambda name: told[f"{name}_{case}"]
    reflected = REFLECTANCE * (column("A") + column("B")) * told["E0"] * math.cos(math.radians(sun)) / math.pi
    want = column("Lms") + column("Lss") + reflected / (1 - REFLECTANCE * column("S"))
    bands = list(zip(told["center_nm"].tolist(), told["fwhm_nm"].tolist()))
    done, found, warnings = rendered(work, plane(work, work / "chn.rct", sun, agl_m, bands))
    check(found.shape == (8, 425) and not any("channels" in text for text in warnings), warnings)
    check(warnings == [], warnings)
    # The reference's columns have five digits; A and B of the .chn end at the seventh decimal, which is what is left
    # of bands that water closes.
    digits = REFLECTANCE * 2 * 5e-8 * told["E0"] * math.cos(math.radians(sun)) / math.pi
    off = numpy.abs(found - want)
    clear = want > 1e-3
    check((off <= 1e-4 * want + digits).all(), told["center_nm"][(off > 1e-4 * want + digits).any(axis=0)])
    check(clear.sum() > 400, clear.sum())
    worst = (off / want)[:, clear].max()
    print(f"425 channels of a real .chn as bands: {worst:.1e} of the reference where light comes through")
    one_direction(work, work / "chn.rct", sun, agl_m, bands[:40])
    # Twice as wide, they are no channels any more.
    wide = [(c, 2 * w) for c, w in bands[25:400:20]]
    _, _, warnings = rendered(work, plane(work, work / "chn.rct", sun, agl_m, wide))
    check(any("19 of 19 bands" in text for text in warnings), warnings)


def told(work):
    """The same .chn with the listing of its run, and no option of sun or sensor: a table of the listing's sun."""
    chn, tp6 = (shared / f"samples/modtran/isofit_modtran6_vswir.{end}" for end in ("chn", "tp6"))
    run("atmos", "import", chn, tp6, "--even-sky", "-o", work / "told.rct")
    said = json.loads(run("atmos", "info", work / "told.rct", "--json").stdout)
    # As the listing prints them: sensor 2.3 km, ground 0.35 km, the sun at the ground, its azimuth from -90 + 253.467.
    check(abs(said["sensor_height_m"] - 1950) < 1e-6, said["sensor_height_m"])
    check(abs(said["sun_zenith_deg"] - 51.99282416) < 1e-8, said["sun_zenith_deg"])
    check(abs(said["sun_azimuth_deg"] - 163.46725576) < 1e-6, said["sun_azimuth_deg"])
    says = ["none of the files holds a run", "give its .chn"]
    refused("atmos", "import", tp6, "-o", work / "none.rct", status=2, says=says)
    check(not (work / "none.rct").exists())


def two_directions(work):
    """A uvspec run of view zeniths 0 and 60 degrees serves those between, without a word of its directions."""
    uvspec = shared / "samples/libradtran/uvspec_solar_radiance.out"
    run("atmos", "import", uvspec, "--sun-azimuth", 150, "--sensor-height", 3000, "-o", work / "uvspec.rct")
    _, straight, _ = rendered(work, plane(work, work / "uvspec.rct", 40, 3000, [(555.0, 1.0)]))
    _, aside, warnings = rendered(work, plane(work, work / "uvspec.rct", 40, 3000, [(555.0, 1.0)], pitch=40))
    check(not any("one view zenith" in text for text in warnings), warnings)
    # More of the path, less of the ground: nearly as bright, and not the same air.
    check(abs(aside.mean() / straight.mean() - 1) > 1e-4, aside, straight)


def par_of(path, factor=1.0):
    """Real methane lines as HITRAN's records, the strongest times `factor`; size and time of the file stay."""
    lines = rows_of(shared / "lidar/ch4_lines_3057cm1.csv")
    strength = lines["S_296"].copy()
    strength[strength.argmax()] *= factor
    digits = lambda value, width, places: f"{value:.{places}f}".replace("0.", ".", 1)[:width].rjust(width)
    text = ""
    for i, nu in enumerate(lines["nu0_cm1"]):
        one = (
            f" 61{nu:12.6f}{strength[i]:10.3E}{1:10.3E}{digits(lines['gamma_air'][i], 5, 4)}"
            f"{lines['gamma_self'][i]:5.3f}{lines['E_lower_cm1'][i]:10.4f}{lines['n_air'][i]:4.2f}"
            f"{digits(lines['delta_air'][i], 8, 6)}"
        )
        text += one.ljust(160) + "\r\n"
    path.write_bytes(text.encode())
    os.utime(path, ns=(10**18, 10**18))


def line_list(work):
    """The same name, size and time, and another strength: another table; the first list again: the kept one."""
    made = []
    for factor in (1.0, 1.0, 1.5, 1.0):
        par_of(work / "ch4.par", factor)
        done = run(
            "atmos",
            "build",
            "--sun-zenith",
            40,
            "--aerosol",
            "none",
            "--from",
            3.2700,
            "--to",
            3.2708,
            "--step",
            0.02,
            "--highest",
            0,
            "--lines",
            work / "ch4.par",
            "-o",
            work / "lines.rct",
            "--overwrite",
            "--json",
            "-v",
        )
        info = json.loads(run("atmos", "info", work / "lines.rct", "--json").stdout)
        most = next(row["most"] for row in info["rows"] if row["name"] == "sun_optical_depth")
        made.append((json.loads(done.stdout)["content_hash"], "table from the cache" in done.stderr, most))
    depth = [most for _, _, most in made]
    print("methane at 3.27 um, depth of the strongest line towards the sun:", [f"{most:.4g}" for most in depth])
    check([kept for _, kept, _ in made] == [False, True, False, True], made)
    check(made[0][0] == made[1][0] == made[3][0] != made[2][0], made)
    check(depth[0] == depth[1] == depth[3] and 1.2 < depth[2] / depth[0] <= 1.5, depth)  # continua stay


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    os.environ["XDG_CACHE_HOME"] = own_cache(work)
    channels(work)
    told(work)
    two_directions(work)
    line_list(work)
print(f"real air: {program.checks} checks")
