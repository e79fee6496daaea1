"""`raycube atmos export`: every value of a table at its place on the axes, against a reader of the .rct that owes ours
nothing. usage: atmos_export_test.py RAYCUBE"""

import csv
import json
import pathlib
import struct
import sys
import tempfile

import numpy

from driver import Program

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused


def read(path):
    with open(path) as file:
        return list(csv.DictReader(file))


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    table = folder / "air.rct"
    run("atmos", "build", "--model", "clear_sky", "--sun-zenith", 40, "--from", 0.5, "--to", 0.6, "--step", 50, "-o",
        table, "-q")
    about = json.loads(run("atmos", "info", "--json", table).stdout)
    done = run("atmos", "export", table)
    check(done.stdout == f"{folder / 'air.csv'}\n", done.stdout)
    lines = read(folder / "air.csv")
    raw = table.read_bytes()
    length = struct.unpack("<Q", raw[16:24])[0]
    header = json.loads(raw[64 : 64 + length])
    arrays = 64 + (length + 63) // 64 * 64
    nodes = {axis["name"]: (axis["unit"], axis["nodes"]) for axis in header["axes"]}
    check({line["row"] for line in lines} == {row["name"] for row in about["rows"]}, "rows")
    check(len(lines) == sum(int(numpy.prod(row["shape"])) for row in header["rows"]), len(lines))
    columns = {name: name + (f"_{unit}" if unit else "") for name, (unit, _) in nodes.items()}
    for row in header["rows"]:
        values = numpy.frombuffer(raw, "<f4", int(numpy.prod(row["shape"])), arrays + row["offset"])
        values = values.reshape(row["shape"])
        of_row = [line for line in lines if line["row"] == row["name"]]
        check(len(of_row) == values.size, row["name"])
        for line in of_row:
            at = tuple(nodes[name][1].index(float(line[columns[name]])) for name in row["axes"])
            check(numpy.float32(line["value"]) == values[at] and line["unit"] == row["unit"], line)
            check(all(not line[columns[name]] for name in nodes if name not in row["axes"] and columns[name] in line))

    # Some rows alone, where asked, in JSON what was written; what is there stays.
    said = json.loads(run("atmos", "export", table, "--row", "sun_transmission", "--row", "solar_irradiance", "-o",
                          folder / "light.csv", "--json").stdout)
    some = read(folder / "light.csv")
    check(said["rows"] == ["solar_irradiance", "sun_transmission"] and said["values"] == len(some) == 9, said)
    check(said["columns"] == list(some[0]) == ["row", "unit", "wavelength_um", "target_height_m", "value"], said)
    check(all(line["target_height_m"] == "" for line in some if line["row"] == "solar_irradiance"), some)
    before = (folder / "light.csv").read_bytes()
    refused("atmos", "export", table, "-o", folder / "light.csv", status=2, says=["light.csv", "--overwrite"])
    check((folder / "light.csv").read_bytes() == before)
    refused("atmos", "export", table, "--row", "moonlight", "-o", folder / "x.csv", status=2,
            says=["no row 'moonlight'", "sun_transmission"])
    check(not (folder / "x.csv").exists())
print(f"atmos_export: {program.checks} checks")
