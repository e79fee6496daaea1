"""What a LIDAR run leaves in its folder: time cube, LAS, waveforms, tables and pictures say the same, and what the
geometry says.
Usage: lidar_products_test.py RUN_SAMPLES RAYCUBE (tests/support/lidar_run_samples.cpp: a plane, and a roof 10 m above
it)
"""

import csv
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

import matplotlib.image
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "support"))
import patience
from driver import envi  # noqa: E402
from las_packets import Las, place  # noqa: E402

LIGHT = 299792458.0
checks = 0


def check(condition, *what):
    global checks
    checks += 1
    assert condition, what


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def whole(folder, files):
    """Nothing but the files the record names, and the record."""
    record = json.loads((folder / "run.json").read_text())
    names = sorted(p.name for p in folder.iterdir())
    check(names == sorted(files + ["run.json"]), names)
    check(sorted([*record["files"], "run.json"] + ["waveforms.hdr"]) == names, record["files"])
    return record


def pictures(folder):
    for name in ("waveforms.png", "ranges.png", "points.png"):
        picture = matplotlib.image.imread(folder / name)
        check(
            picture.shape[0] > 500 and picture.shape[1] > 800 and picture[..., :3].std() > 0.03,
            name,
            picture.shape,
            picture.std(),
        )


def points_and_table(las, returns, east, north, up):
    """Every row of returns.csv is a point of the LAS file, in order."""
    check(las.count == len(returns) > 0)
    unit = float(las.vlr("raycube", 1).rstrip(b"\0").decode().split("intensity = ")[1])
    strongest = max(float(r["energy_pe"]) for r in returns)
    check(unit * 32767 < strongest <= unit * 65535, unit, strongest)
    for number, row in enumerate(returns):
        point = las.point(number)
        for got, key in zip(point["xyz"], (east, north, up)):
            check(abs(got - float(row[key])) <= 0.5e-4 + 2e-9, key, got, row[key])  # stored to 0.1 mm
        check(point["return_number"] == int(row["return"]) and point["number_of_returns"] == int(row["of"]))
        check(point["gps_time"] == float(row["gps_time_s"]) and point["point_source_id"] == 1)
        check(point["intensity"] == round(float(row["energy_pe"]) / unit), point["intensity"], row)
        truth = struct.unpack("<QddfffBIHffffIfh", las.extra(number))
        check(
            truth[0] == int(row["pulse"])
            and truth[1] == float(row["range_m"])
            and truth[2] == float(row["range_true_m"])
        )
        for value, key in zip(
            truth[3:6] + truth[9:13] + truth[14:15],
            (
                "expected_pe",
                "fwhm_ns",
                "detection_probability",
                "incidence_deg",
                "overlap",
                "transmission_2way",
                "footprint_share",
                "energy_pe",
            ),
        ):
            check(value == numpy.float32(row[key]), key, value, row[key])
        check(
            truth[6] == int(row["order"])
            and truth[13] == int(row["pixel"])
            and truth[15] == int(row["pulses_back"])
            and str(truth[7]) == row["object"]
            and ["grass", "roof"][truth[8]] == row["material"],
            truth,
            row,
        )


def survey(program, folder):
    patience.run([program, "survey", folder], check=True)
    record = whole(
        folder,
        [
            "waveforms.img",
            "waveforms.hdr",
            "returns.las",
            "returns.wdp",
            "returns.csv",
            "pulses.csv",
            "waveforms.png",
            "ranges.png",
            "points.png",
        ],
    )
    las, returns, pulses = Las(folder / "returns.las"), rows_of(folder / "returns.csv"), rows_of(folder / "pulses.csv")
    header, cube = envi(folder, "waveforms")
    check(
        header["raycube bin start ns"] == "3900"
        and header["raycube bin width ns"] == "1"
        and header["raycube pixels"] == "1",
        header,
    )
    check(
        cube.shape == (2000, 200, 2)
        and header["band names"] == ["laser expected [photons]", "laser recorded [photo-electrons]"],
        cube.shape,
        header,
    )
    check("32618" in las.vlr("LASF_Projection", 2112).decode() and las.offset == (276000.0, 4753000.0, 180.0))
    check(las.software.startswith("raycube 0.") and las.system == "simulated survey" and las.year >= 2026)
    points_and_table(las, returns, "easting_m", "northing_m", "height_m")
    unseen = [p for p in pulses if p["returns"] == "0"]
    check(
        len(pulses) == 2000
        and len(unseen) == 200
        and record["lidar"]["pulses_without_return"] == 200
        and record["lidar"]["returns"] == len(returns)
    )
    check(las.vlr("raycube", 1).startswith(b"pulses = 2000\npulses without return = 200\n"))
    # Geometry: a return lies on its pulse's axis, on the plane (180 m) or on the roof (190 m). The middle of a pulse of
    # 4 ns in bins of 1 ns, cut at a thousandth, is good to 1 mm; a footprint cut by the roof's edge keeps its range,
    # not its place.
    of_pulse = {int(p["pulse"]): p for p in pulses}
    heights = {"grass": 0, "roof": 0}
    store = las.packet_store()
    for number, row in enumerate(returns):
        pulse, point = of_pulse[int(row["pulse"])], las.point(number)
        exit_m = [float(pulse[k]) for k in ("exit_easting_m", "exit_northing_m", "exit_height_m")]
        axis = [float(pulse[k]) for k in ("axis_x", "axis_y", "axis_z")]
        check(abs(float(row["range_m"]) - float(row["range_true_m"])) < 1e-3, row)
        if float(row["footprint_share"]) == 1:
            check(abs(float(row["height_m"]) - (190 if row["material"] == "roof" else 180)) < 2e-3, row)
            # Sub-rays spread over a footprint of 0.15 m at 600 m: 0.014 degrees.
            check(
                abs(float(row["incidence_deg"]) - abs(float(pulse["scan_angle_deg"]))) < 0.02,
                row["incidence_deg"],
                pulse["scan_angle_deg"],
            )
            heights[row["material"]] += 1
        check(abs(point["scan_angle"] * 0.006 - float(pulse["scan_angle_deg"])) <= 0.003 + 1e-9)
        # L-28: a sample stands for the middle of its bin, on the axis.
        for sample in (0, 77, 199):
            wanted = LIGHT / 2 * (3.9e-6 + (sample + 0.5) * 1e-9)
            for got, start, d in zip(place(point, 1000, sample), exit_m, axis):
                check(abs(got - start - wanted * d) < 0.5e-4 + 1e-5, sample, got)
        samples = las.samples(store, point["index"], point["offset"], point["size"])
        _, _, _, spacing, gain, offset = las.descriptor(point["index"])
        check(
            spacing == 1000 and point["offset"] == 60 + 400 * int(pulse["cube_line"]),
            "packets lie in the order of the cube's lines",
        )
        check(
            numpy.array_equal(numpy.float32(offset + gain * numpy.array(samples)), cube[int(pulse["cube_line"]), :, 1]),
            "the packet is the cube's record",
        )
    check(heights["grass"] > 1000 and heights["roof"] > 50, heights)
    check(len(store) == 60 + 400 * 2000, "pulses without return have their packets too")
    check(las.descriptor(1)[4:] == (2.0, -4.0) and las.descriptor(2)[4:] == (1.0, -4.0))
    ledger(pulses, cube[:, :, 0:1].sum(axis=(1, 2), dtype=float))
    # The axis of a pulse may miss the roof while its footprint hits: then two returns share a packet.
    pairs = [r for r in returns if r["of"] == "2"]
    check(len(pairs) >= 2 and {r["material"] for r in pairs} == {"grass", "roof"}, pairs)
    pictures(folder)


def ledger(pulses, photons):
    for pulse, row_sum in zip(pulses, photons):
        value = {
            key: float(pulse[key])
            for key in (
                "absorbed",
                "air",
                "volumes",
                "escaped",
                "truncated",
                "collected",
                "early",
                "late",
                "near",
                "photons_emitted",
                "photons_in_gate",
            )
        }
        check(abs(sum(value[key] for key in ("absorbed", "air", "volumes", "escaped", "truncated")) - 1) < 1e-9, pulse)
        check(abs(value["photons_in_gate"] - row_sum) <= 1e-6 * row_sum)  # the cube's floats
        in_gate = value["photons_in_gate"] / value["photons_emitted"]
        check(
            abs(in_gate + value["early"] + value["late"] + value["near"] - value["collected"])
            <= 1e-6 * value["collected"],
            pulse,
        )


def flash(program, folder):
    patience.run([program, "flash", folder], check=True)
    whole(
        folder,
        [
            "waveforms.img",
            "waveforms.hdr",
            "returns.las",
            "returns.csv",
            "pulses.csv",
            "photons.csv",
            "waveforms.png",
            "ranges.png",
            "points.png",
        ],
    )
    las, returns, photons, pulses = Las(folder / "returns.las"), *(
        rows_of(folder / f"{n}.csv") for n in ("returns", "photons", "pulses")
    )
    header, cube = envi(folder, "waveforms")
    names = [
        f"{line} {what}"
        for line in ("on", "off")
        for what in (
            "once scattered [photons]",
            "scattered more often [photons]",
            "air [photons]",
            "recorded [photo-electrons]",
        )
    ]
    check(
        cube.shape == (5 * 64, 256, 8) and header["band names"] == names and header["raycube pixels"] == "64",
        cube.shape,
        header,
    )
    check(header["wavelength"] == ["1.6455"] * 4 + ["1.6456"] * 4)
    check((cube[:, :, [1, 5]] == 0.25).all() and (cube[:, :, [2, 6]] == 0.125).all())
    check(las.encoding & 2 and las.evlrs[0][:2] == ("LASF_Spec", 65535) and las.evlrs[0][3] == 5 * 64 * 2 * 512)
    check(b"LOCAL_CS" in las.vlr("LASF_Projection", 2112))
    points_and_table(las, returns, "x_m", "y_m", "z_m")
    store = las.packet_store()
    for number, row in enumerate(returns):
        point, line = las.point(number), ("on", "off").index(row["line"])
        check(point["flags"] >> 4 & 3 == line == point["user_data"])
        record = (int(row["pulse"]) * 64 + int(row["pixel"])) * 2 + line
        check(point["offset"] == 60 + 512 * record, "packets: pulse by pulse, pixel by pixel, line by line")
        samples = las.samples(store, point["index"], point["offset"], point["size"])
        _, _, _, _, gain, offset = las.descriptor(point["index"])
        check(
            numpy.array_equal(numpy.float32(offset + gain * numpy.array(samples)), cube[record // 2, :, 4 * line + 3])
        )
    check(
        len(photons) == len(returns)
        and all(p["delay_ns"] == r["delay_ns"] and p["pixel"] == r["pixel"] for p, r in zip(photons, returns))
    )
    for p in photons:
        check(math.isclose(float(p["range_m"]), float(p["delay_ns"]) * LIGHT / 2e9, rel_tol=1e-12))
    check(len(pulses) == 10 and [p["line"] for p in pulses] == ["on", "off"] * 5)
    check(
        math.isclose(
            float(pulses[1]["photons_emitted"]) / float(pulses[0]["photons_emitted"]),
            2 * 1.6456 / 1.6455,
            rel_tol=1e-12,
        )
    )
    pictures(folder)


def refusals(program, folder):
    """A second run changes nothing; without the drawing script the data are whole and the record says what is
    missing."""
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    done = patience.run([program, "flash", folder], capture_output=True, text=True)
    check(done.returncode == 1 and "is there already" in done.stderr, done)
    check(before == {p.name: p.read_bytes() for p in folder.iterdir()})
    bare, data = folder.parent / "bare", folder.parent / "data"
    data.mkdir()
    patience.run(
        [program, "flash", bare], check=True, env={**os.environ, "RAYCUBE_DATA": str(data)}, stderr=subprocess.DEVNULL
    )
    record = whole(bare, ["waveforms.img", "waveforms.hdr", "returns.las", "returns.csv", "pulses.csv", "photons.csv"])
    check(len(record["warnings"]) == 1 and "no pictures" in record["warnings"][0], record["warnings"])
    for name in ("waveforms.img", "waveforms.hdr", "returns.las", "returns.csv", "pulses.csv", "photons.csv"):
        again, once = (bare / name).read_bytes(), before[name]
        if name == "returns.las":  # the day of writing
            again, once = (raw[:90] + raw[94:] for raw in (again, once))
        check(again == once, "the same run gives the same bytes", name)
    check(record["digest"] == json.loads(before["run.json"])["digest"])


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        survey(program, folder / "survey")
        flash(program, folder / "flash")
        refusals(program, folder / "flash")
        said = patience.run(
            [sys.argv[2], "info", folder / "survey"], capture_output=True, text=True, check=True
        ).stdout
        check("pulses        2000, 200 without return, " in said and "returns.las" in said, said)
    print(f"{checks} checks")


main()
