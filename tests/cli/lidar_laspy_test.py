"""LAS files of known contents opened by laspy (PyPI), an implementation nobody here wrote.
Usage: lidar_laspy_test.py SAMPLES RUN_SAMPLES DATA_FOLDER. Runs in the virtual environment that ci/setup makes; without
laspy and lazrs there, it says so and skips (77)."""

import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import patience

try:
    import laspy
    import numpy
except ImportError as reason:
    print(
        f"SKIPPED: no laspy ({reason}): LAS files were NOT opened by an independent library. ci/setup installs it from "
        f"PyPI when it can be reached."
    )
    sys.exit(77)

checks = 0
kExtra = (
    "pulse_id range range_true expected_pe echo_fwhm_ns pd bounce_order object_id material_id incidence_deg gff "
    "trans_2way subray_fraction pixel energy_pe pulses_back"
).split()
kTypes = "u8 f8 f8 f4 f4 f4 u1 u4 u2 f4 f4 f4 f4 u4 f4 i2".split()


def check(condition, *what):
    global checks
    checks += 1
    assert condition, what


def compare(las, expected):
    header, points = las.header, expected["points"]
    check(str(header.version) == "1.4" and header.point_format.id == expected["format"], header)
    check(header.point_count == len(points) == len(las.points))
    check(
        list(header.number_of_points_by_return) == [sum(p["return_number"] == r for p in points) for r in range(1, 16)]
    )
    encoding = header.global_encoding
    check(
        encoding.wkt
        and encoding.gps_time_type == laspy.header.GpsTimeType.STANDARD
        and not encoding.synthetic_return_numbers
    )
    waves = expected["format"] == 9
    check(bool(encoding.waveform_data_packets_internal) == expected["internal"])
    check(bool(encoding.waveform_data_packets_external) == (waves and not expected["internal"]))
    check(str(header.creation_date) == "2026-07-19" and header.generating_software == "raycube", header.creation_date)
    check(list(header.scales) == [1e-4] * 3 and list(header.offsets) == [500000, 5400000, 250])
    for i, axis in enumerate("xyz"):
        values, wanted = numpy.asarray(las[axis]), numpy.array([p[axis] for p in points])
        check(abs(values - wanted).max() <= 0.5e-4 + 2e-9, axis)  # stored to 0.1 mm
        check(values.min() == header.mins[i] and values.max() == header.maxs[i], "bounding box", axis)
    for name in (
        "intensity",
        "return_number",
        "number_of_returns",
        "synthetic",
        "key_point",
        "withheld",
        "overlap",
        "scanner_channel",
        "scan_direction_flag",
        "edge_of_flight_line",
        "classification",
        "user_data",
        "scan_angle",
        "point_source_id",
        "gps_time",
    ):
        check(numpy.array_equal(las[name], [p[name] for p in points]), name)
    check(list(las.point_format.extra_dimension_names) == kExtra, list(las.point_format.extra_dimension_names))
    for i, (name, kind) in enumerate(zip(kExtra, kTypes)):
        check(las[name].dtype == kind, name, las[name].dtype)
        wanted = numpy.array([numpy.nan if p["extra"][i] is None else p["extra"][i] for p in points], dtype=kind)
        check(numpy.array_equal(las[name], wanted, equal_nan=wanted.dtype.kind == "f"), name)
    projection = [v for v in header.vlrs if v.record_id == 2112]
    check(len(projection) == 1 and projection[0].string == expected["wkt"])
    if waves:
        kinds = header.vlrs.get("WaveformPacketVlr")
        first = kinds[0].parsed_record
        check(
            len(kinds) == 2
            and (first.bits_per_sample, first.number_of_samples, first.temporal_sample_spacing)
            == (expected["bits"], 256, 500),
            first,
        )
        check(first.digitizer_offset == -1.25 and first.digitizer_gain == (0.5 if expected["bits"] == 8 else 0.01))
        check(
            set(numpy.asarray(las["wavepacket_index"])) == {1}
            and set(numpy.asarray(las["wavepacket_size"])) == {256 * expected["bits"] // 8}
        )
        check(numpy.array_equal(las["wavepacket_offset"], [p["offset"] for p in points]))
        wanted = numpy.array([p["beam"] for p in points]) * (-299792458.0 / 2 * 1e-12)
        for i, name in enumerate(("x_t", "y_t", "z_t")):
            check(abs(numpy.asarray(las[name]) - wanted[:, i]).max() < 1.5e-11, name)  # float32 of 1.5e-4
        delay = [(2 * p["range"] / 299792458.0 - 3.9e-6) * 1e12 for p in points]
        check(
            abs(numpy.asarray(las["return_point_wave_location"]) - delay).max() < 8e-3
        )  # float32 below 131072 ps: half of 2^-7


def runs(program, folder):
    """The files of whole runs, external and internal waveforms."""
    for name, pixels, waves in (("survey", 1, "external"), ("flash", 64, "internal")):
        patience.run(
            [program, name, folder / name],
            check=True,
            env={**os.environ, "RAYCUBE_DATA": str(folder)},
            stderr=subprocess.DEVNULL,
        )
        las = laspy.read(folder / name / "returns.las")
        check(las.header.point_format.id == 9 and getattr(las.header.global_encoding, f"waveform_data_packets_{waves}"))
        check(sum(las.header.number_of_points_by_return) == len(las.points) == las.header.point_count > 500)
        check(
            int(las.pixel.max()) == pixels - 1
            and set(numpy.asarray(las.point_source_id)) == {1}
            and set(numpy.asarray(las.material_id)) == {0, 1}
            and (las.intensity.max() > 32767)
        )
        floor = 180 if name == "survey" else 0
        check(
            set(numpy.round(numpy.asarray(las.z)[numpy.asarray(las.subray_fraction) == 1]).astype(int))
            == {floor, floor + 10}
        )
        check(len(las.header.vlrs.get("WaveformPacketVlr")) == 2)


def kept(record):
    """What LAZ keeps of a VLR. Of extra bytes laspy fills in lowest and highest values, which no option of ours says
    are there."""
    data = record.record_data_bytes()
    if (record.user_id, record.record_id) == ("LASF_Spec", 4):
        data = b"".join(data[at : at + 64] + data[at + 112 : at + 192] for at in range(0, len(data), 192))
    return record.user_id, record.record_id, record.description, data


def packed(program, folder, data):
    """LAZ holds what LAS holds, beside it or instead of it, and points into the same packets."""
    environment = {**os.environ, "RAYCUBE_DATA": data, "RAYCUBE_PYTHON": sys.executable}
    for name in ("packed", "packed_alone"):
        patience.run([program, name, folder / name], check=True, env=environment)
        check((folder / name / "returns.las").exists() == (name == "packed"))
        check((folder / name / "returns.wdp").exists())
        check(not [path for path in (folder / name).iterdir() if path.name.startswith(".")], "scratch left")
        files = set(json.loads((folder / name / "run.json").read_text())["files"])
        check("returns.laz" in files and ("returns.las" in files) == (name == "packed"), files)
    plain, small = folder / "packed/returns.las", folder / "packed/returns.laz"
    check(small.stat().st_size < 0.6 * plain.stat().st_size, "not smaller")
    check(small.read_bytes()[400:] == (folder / "packed_alone/returns.laz").read_bytes()[400:], "not the same points")
    las, laz = laspy.read(plain), laspy.read(small)
    check(len(las.points) > 500 and laz.header.are_points_compressed)
    check(las.header.point_format == laz.header.point_format)
    for name in las.point_format.dimension_names:
        check(numpy.asarray(las[name]).tobytes() == numpy.asarray(laz[name]).tobytes(), name)
    for item in (
        "mins maxs scales offsets number_of_points_by_return creation_date system_identifier generating_software"
    ).split():
        check(numpy.array_equal(getattr(las.header, item), getattr(laz.header, item)), item)
    check(las.header.global_encoding.value == laz.header.global_encoding.value)
    check([kept(v) for v in las.header.vlrs] == [kept(v) for v in laz.header.vlrs], "VLRs")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        patience.run([sys.argv[1], folder], check=True)
        expected = json.loads((folder / "expected.json").read_text())
        for file, content in expected["files"].items():
            compare(laspy.read(folder / f"{file}.las"), content)
        runs(sys.argv[2], folder)
        if importlib.util.find_spec("lazrs"):
            packed(sys.argv[2], folder, sys.argv[3])
        else:
            print("no lazrs: LAZ was NOT read back by an independent library. ci/setup installs it from PyPI.")
            sys.exit(77)
    print(f"laspy {laspy.__version__}: {checks} checks")


main()
