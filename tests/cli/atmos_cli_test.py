"""raycube atmos build | info | plot | import as a user drives them. Usage: atmos_cli_test.py RAYCUBE FOLDER"""

import functools
import json
import os
import pathlib
import shutil
import sys

from driver import Program

program, folder = Program(sys.argv[1]), pathlib.Path(sys.argv[2])
run = functools.partial(program.run, "atmos")
shutil.rmtree(folder, ignore_errors=True)
folder.mkdir(parents=True)


table = folder / "clear.rct"
build = ["build", "--model", "clear_sky", "--sun-zenith", "40", "--aod", "0.2", "--step", "20"]

# S18: the same inputs give the same bytes; nothing is overwritten silently.
assert run(*build, "-o", table).stdout == f"table: {table}\naerosol: optical depth 0.2 at 550 nm\n"
again = json.loads(run(*build, "-o", folder / "again.rct", "--json").stdout)
assert (folder / "again.rct").read_bytes() == table.read_bytes()
before = table.read_bytes()
assert str(table) in run(*build, "-o", table, status=2).stderr
assert table.read_bytes() == before
run(*build, "-o", table, "--overwrite")

info = json.loads(run("info", table, "--json").stdout)
assert info["content_hash"] == again["content_hash"]
assert info["sun_zenith_deg"] == 40 and info["provenance"]["parameters"]["aod_550"] == 0.2
assert info["provenance"]["stated_errors"]
names = {row["name"] for row in info["rows"]}
assert {"sun_transmission", "sky_radiance_solar", "path_radiance_solar", "two_way_factor"} <= names
assert "path_radiance_thermal" in info["absent_rows"] and not names & set(info["absent_rows"])
text = run("info", table).stdout
assert "absent rows" in text and "sun zenith 40 deg" in text

# The layered model is the default; its tables are kept, and the kept one is the same.
os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
layered = ["build", "--sun-zenith", "40", "--from", "0.5", "--to", "0.55", "--step", "25", "--highest", "0"]
run(*layered, "-o", folder / "layered.rct")
kept = list((folder / "cache/raycube/atmosphere").glob("*.rct"))
assert len(kept) == 1, kept
run(*layered, "-o", folder / "from_cache.rct")
run(*layered, "--no-cache", "--threads", "1", "-o", folder / "anew.rct")
assert (
    (folder / "layered.rct").read_bytes()
    == (folder / "from_cache.rct").read_bytes()
    == (folder / "anew.rct").read_bytes()
)
kept[0].write_bytes(kept[0].read_bytes()[:1000])
damaged = run(*layered, "-o", folder / "again_built.rct")
assert (
    "built anew" in damaged.stderr and (folder / "again_built.rct").read_bytes() == (folder / "anew.rct").read_bytes()
)
assert list((folder / "cache/raycube/atmosphere").iterdir()) == kept
assert (
    json.loads(run("info", folder / "layered.rct", "--json").stdout)["provenance"]["parameters"]["profile"]
    == "us_standard"
)
assert "belongs to --model clear_sky" in run(*layered, "--angstrom", "1.3", "-o", folder / "x.rct", status=2).stderr
assert "belongs to --model layered" in run(*build, "--co2", "400", "-o", folder / "x.rct", status=2).stderr

vacuum = folder / "vacuum.rct"
run("build", "--sun-zenith", "30", "--no-air", "-o", vacuum)
rows = {row["name"]: row for row in json.loads(run("info", vacuum, "--json").stdout)["rows"]}
assert rows["view_transmission"]["least"] == rows["view_transmission"]["most"] == 1
assert rows["sky_radiance_solar"]["most"] == 0

# Bad input: status 2 and a message that says what is wrong.
assert "where is the sun" in run("build", "-o", folder / "x.rct", status=2).stderr
dark = run("build", "--sun-zenith", "95", *layered[3:], "-o", folder / "dark.rct")
assert "no twilight" in dark.stderr
rows = {row["name"]: row for row in json.loads(run("info", folder / "dark.rct", "--json").stdout)["rows"]}
assert rows["sky_radiance_solar"]["most"] == rows["path_radiance_solar"]["most"] == 0
assert (
    "above the sensor" in run("build", "--sun-zenith", "5", "--highest", "700", "-o", folder / "x.rct", status=2).stderr
)
assert "--water" in run("build", "--sun-zenith", "5", "--water", "-1", "-o", folder / "x.rct", status=2).stderr
assert not (folder / "x.rct").exists()
broken = bytearray(before)
broken[len(broken) // 2] ^= 1
(folder / "broken.rct").write_bytes(broken)
assert "corrupt" in run("info", folder / "broken.rct", status=2).stderr
assert "cannot be opened" in run("info", folder / "none.rct", status=3).stderr

run("plot", table, "-o", folder / "chart.png")
assert (folder / "chart.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
figures = json.loads((folder / "chart.json").read_text())
assert len(figures["sun_transmission"]) == len(figures["wavelength_um"]) == 109
assert all(0 <= t <= 1 for t in figures["two_way_transmission"])
assert "view_zenith 85" in run("plot", table, "--view-zenith", "85", "-o", folder / "no.png", status=2).stderr
assert not list(folder.glob("no.*"))
# S20: another code's output is read, or refused with file and line.
output = folder / "direct.tp7"
output.write_text("    FREQ   TRANS     SOL TR  SOLAR\n 2000.00  0.5000 4.00E-07 8.00E-07      6.931E-01\n -9999.\n")
imported = json.loads(run("import", output, "--json").stdout)
assert imported["format"] == "tape7" and imported["runs"][0]["wavelength_um"] == [5.0]
columns = {column["name"]: column for column in imported["runs"][0]["columns"]}
assert (
    abs(columns["solar_irradiance"]["values"][0] - 3.2) < 1e-12 and columns["solar_irradiance"]["unit"] == "W m-2 um-1"
)
assert "direct irradiance: 1 wavelength, 5 to 5 um" in run("import", output).stdout
output.write_text(output.read_text().replace("4.00E-07", "********"))
assert f"{output}:2: SOL_TR did not fit its field" in run("import", output, status=2).stderr
assert "tape7, 7sc" in run("import", output, "--format", "tape8", status=2).stderr
assert "which code wrote this" in run("import", folder / "chart.png", status=2).stderr
assert "cannot be read" in run("import", folder / "none.tp7", status=3).stderr
left = [path.name for path in folder.iterdir() if path.name.startswith(".")]
assert not left, f"temporaries left behind: {left}"
print("atmos verbs: ok")
