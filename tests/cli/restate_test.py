#!/usr/bin/python3
"""The committed figures are what the scripts in atmos_tables/fit make from the public ones.

Usage: restate_test.py SOURCE_FOLDER. Skips, loudly, without RAYCUBE_SHARED.
"""

import os
import pathlib
import sys
import tempfile

import patience

source = pathlib.Path(sys.argv[1]) / "atmos_tables"
if "RAYCUBE_SHARED" not in os.environ:
    print("SKIPPED: RAYCUBE_SHARED is not set, the restated figures were not compared with their sources")
    sys.exit(77)
shared = pathlib.Path(os.environ["RAYCUBE_SHARED"]) / "reference" / "atmosphere"


def script(name, *arguments):
    done = patience.run(["/usr/bin/python3", source / "fit" / name, *arguments], capture_output=True)
    assert done.returncode == 0, f"{name}: {done.stderr.decode()}"
    return done.stdout


def compare(name, made, committed):
    kept = (source / committed).read_bytes()
    assert (
        made == kept
    ), f"{name} makes another {committed} ({len(made)} bytes, committed {len(kept)}): run it again and commit"
    print(f"{committed}: {len(kept)} bytes as {name} makes them")


with tempfile.TemporaryDirectory() as folder:
    script("restate_aerosols.py", shared / "aerosol", folder)
    for part in ["optics", "phases", "heights"]:
        file = f"lowtran7_{part}.inc"
        compare("restate_aerosols.py", (pathlib.Path(folder) / file).read_bytes(), f"aerosol/data/{file}")
compare(
    "restate_moon.py",
    script("restate_moon.py", shared / "anchors" / "lowtran7_direct_vnir_swir.csv"),
    "data/moon_albedo.inc",
)
compare("restate_afgl.py", script("restate_afgl.py", shared / "profiles"), "optics/data/afgl_1986.inc")
solar = shared / "solar"
compare("restate_sun.py", script("restate_sun.py", "tsis1", solar), "data/solar_tsis1_gueymard.inc")
e490 = shared.parent.parent / "data" / "solar" / "astm_e490_0.12_1000um.csv"
compare("restate_sun.py", script("restate_sun.py", "e490", e490), "data/solar_e490.inc")
