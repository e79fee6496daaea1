"""LAS files of known contents, every byte accounted for, read by code from the specification. Usage: lidar_las_test.py
SAMPLES RAYCUBE
Geometry, set by tests/support/las_samples.cpp: beams 10 degrees off nadir, first sample at the gate, returns on and
between samples.
Tolerances: coordinates are stored to 0.1 mm, so half of that on each axis; a direction in float32 is good to 6e-8 of
1.5e-4 m/ps over at most 1.3e5 ps (1e-6 m)."""

import json
import math
import pathlib
import struct
import sys
import tempfile

import patience

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "support"))
from las_packets import Las, place  # noqa: E402

LIGHT = 299792458.0
kQuantum = 0.5e-4 + 2e-6
kExtra = [
    (7, "pulse_id"),
    (10, "range"),
    (10, "range_true"),
    (9, "expected_pe"),
    (9, "echo_fwhm_ns"),
    (9, "pd"),
    (1, "bounce_order"),
    (5, "object_id"),
    (3, "material_id"),
    (9, "incidence_deg"),
    (9, "gff"),
    (9, "trans_2way"),
    (9, "subray_fraction"),
    (5, "pixel"),
    (9, "energy_pe"),
    (4, "pulses_back"),
]
checks = 0


def check(condition, *what):
    global checks
    checks += 1
    assert condition, what


def header(las, expected):
    """Byte-exact: the first 375 bytes built here from the specification's table."""
    points = expected["points"]
    stored = [[round((p[axis] - las.offset[i]) / las.scale[i]) for p in points] for i, axis in enumerate("xyz")]
    box = []
    for i, values in enumerate(stored):
        box += [max(values) * 1e-4 + las.offset[i], min(values) * 1e-4 + las.offset[i]]
    by_return = [sum(p["return_number"] == r for p in points) for r in range(1, 16)]
    packets = expected["format"] == 9
    inside = expected["internal"]
    wkt = expected["wkt"].encode() + b"\0"
    vlrs = (54 + len(wkt)) + (54 + 16 * 192) + (54 + 192) + (4 * (54 + 26) if packets else 0)
    record = (59 if packets else 30) + 69
    at = 375 + vlrs
    evlr = at + record * len(points) if inside else 0
    wanted = (
        b"LASF" + struct.pack("<HH", 0, 1 | 16 | (2 if inside else 4 if packets else 0)) + bytes(16) + bytes([1, 4])
    )
    wanted += b"raycube LIDAR".ljust(32, b"\0") + b"raycube".ljust(32, b"\0")
    wanted += struct.pack("<HHHIIBH", 200, 2026, 375, at, 5 if packets else 3, expected["format"], record) + bytes(24)
    wanted += struct.pack("<3d3d", 1e-4, 1e-4, 1e-4, 500000.0, 5400000.0, 250.0) + struct.pack("<6d", *box)
    wanted += struct.pack("<QQIQ", evlr, evlr, 1 if inside else 0, len(points)) + struct.pack("<15Q", *by_return)
    check(len(wanted) == 375)
    for i in range(375):
        check(las.raw[i] == wanted[i], "header byte", i, las.raw[i], wanted[i])
    check(las.vlrs_end == las.points_at and las.end == len(las.raw), las.vlrs_end, las.points_at, las.end, len(las.raw))
    check(las.vlr("LASF_Projection", 2112) == wkt)
    check(
        las.vlr("raycube", 1).rstrip(b"\0")
        == f"pulses = 200\npulses without return = {expected['without_return']}\n".encode()
    )
    fields = las.vlr("LASF_Spec", 4)
    check(len(fields) == 16 * 192)
    for i, (kind, name) in enumerate(kExtra):
        one = fields[192 * i : 192 * (i + 1)]
        options = 1 if name in ("object_id", "material_id") else 0
        check(one[0:4] == bytes([0, 0, kind, options]) and one[4:36] == name.encode().ljust(32, b"\0"), one[:36])
        no_data = {"object_id": 0xFFFFFFFF, "material_id": 0xFFFF}.get(name, 0)
        check(one[36:160] == bytes(4) + struct.pack("<Q", no_data) + bytes(112), "extra bytes field", name)
        check(one[160:].split(b"\0")[0] != b"", "description of", name)


def points(las, expected):
    for number, p in enumerate(expected["points"]):
        got = las.point(number)
        for axis, value in zip("xyz", got["xyz"]):
            check(abs(value - p[axis]) <= 0.5e-4 + 2e-9, "coordinate", axis, value, p[axis])  # and doubles near 5.4e6
        for key in (
            "intensity",
            "return_number",
            "number_of_returns",
            "classification",
            "user_data",
            "scan_angle",
            "point_source_id",
            "gps_time",
        ):
            check(got[key] == p[key], key, got[key], p[key])
        flags = sum(
            p[key] << bit
            for key, bit in (
                ("synthetic", 0),
                ("key_point", 1),
                ("withheld", 2),
                ("overlap", 3),
                ("scanner_channel", 4),
                ("scan_direction_flag", 6),
                ("edge_of_flight_line", 7),
            )
        )
        check(got["flags"] == flags, got["flags"], flags)
        for value, wanted, (_, name) in zip(struct.unpack("<QddfffBIHffffIfh", las.extra(number)), p["extra"], kExtra):
            check(math.isnan(value) if wanted is None else value == wanted, name, value, wanted)


def waveforms(las, expected, gate_s, spacing_s):
    """L-28: every sample of every packet lies where the geometry puts it, and sample L / spacing is the return."""
    bits = expected["bits"]
    check(las.descriptor(1) == (bits, 0, 256, 500, 0.5 if bits == 8 else 0.01, -1.25), las.descriptor(1))
    check(las.descriptor(2) == (16, 0, 8, 250, 2.0, 0.0))
    store = las.packet_store()
    size = 256 * bits // 8
    data_bytes = 200 * size + 16
    check(
        bytes(store[:60]) == struct.pack("<H16sHQ32s", 0, b"LASF_Spec", 65535, data_bytes, b"waveform data packets")
        and len(store) == 60 + data_bytes
    )
    # Packets lie in pulse order without gaps: those of pulses without return are found although no point refers to
    # them.
    offset = 60
    for wave in expected["waves"]:
        check(wave["offset"] == offset, wave["pulse"], wave["offset"], offset)
        check(list(las.samples(store, 1, offset, size)) == wave["samples"], "samples of pulse", wave["pulse"])
        offset += size
        if wave["pulse"] == 3:
            check(list(las.samples(store, 2, offset, 16)) == [1, 2, 3, 4, 5, 6, 7, 65535])
            offset += 16
    worst = 0.0
    for number, p in enumerate(expected["points"]):
        got = las.point(number)
        check(got["index"] == 1 and got["offset"] == p["offset"] and got["size"] == size, got)
        check(abs(math.hypot(*got["direction"]) - LIGHT / 2 * 1e-12) < 2e-11, "|d| = c / 2 per ps")
        check(place(got, 500, got["location"] / 500) == got["xyz"])
        for sample in (0, 1, 100, 255):
            for i in range(3):
                wanted = p["sensor"][i] + LIGHT / 2 * (gate_s + sample * spacing_s) * p["beam"][i]
                worst = max(worst, abs(place(got, 500, sample)[i] - wanted))
        values = las.samples(store, 1, got["offset"], got["size"])
        near = range(round(got["location"] / 500) - 4, round(got["location"] / 500) + 5)
        peak = max(near, key=lambda i: values[i])
        check(abs(peak - got["location"] / 500) <= 0.501, "the echo's peak lies at its return location", number, peak)
    check(worst <= kQuantum, "worst place of a sample", worst)
    return worst


def damaged(program, folder, las):
    """Truncated and foreign files: exit status 2, one error line that says what is wrong."""
    raw = las.raw
    cases = {
        "empty.las": (b"", "no LAS file"),
        "foreign.las": (b"PK\3\4" + bytes(1000), "no LAS file"),
        "short.las": (raw[:100], "cut short"),
        "header.las": (raw[:300], "cut short"),
        "records.las": (raw[:500], "cut short"),
        "points.las": (raw[: las.points_at + 1000], "cut short"),
        "version.las": (raw[:24] + bytes([2, 0]) + raw[26:], "LAS 2.0"),
        "format.las": (raw[:104] + bytes([11]) + raw[105:], "point format 11"),
        "record.las": (raw[:105] + struct.pack("<H", 20) + raw[107:], "at least"),
        "vlrs.las": (raw[:100] + struct.pack("<I", 4000000000) + raw[104:], "cut short"),
    }
    for name, (content, says) in cases.items():
        (folder / name).write_bytes(content)
        done = patience.run([program, "info", folder / name], capture_output=True, text=True)
        errors = [line for line in done.stderr.splitlines() if "error" in line]
        check(done.returncode == 2 and len(errors) == 1 and says in errors[0] and done.stdout == "", name, done)
    if las.encoding & 4:
        (folder / "cut.las").write_bytes(raw)
        (folder / "cut.wdp").write_bytes(las.packet_store()[:5000])
        done = patience.run([program, "info", folder / "cut.las"], capture_output=True, text=True)
        check(done.returncode == 2 and "cut.wdp: is cut short" in done.stderr, done)


def shown(program, folder, name, las, expected):
    """`raycube info` against what this reader found."""
    text = patience.run([program, "info", folder / f"{name}.las"], capture_output=True, text=True)
    check(
        text.returncode == 0 and "LAS 1.4" in text.stdout and f"{las.count} points" in text.stdout.replace(",", ""),
        text,
    )
    said = json.loads(
        patience.run([program, "info", "--json", folder / f"{name}.las"], capture_output=True, text=True).stdout
    )
    check(
        said["kind"] == "las"
        and said["points"] == las.count
        and said["format"] == las.format
        and said["by_return"] == list(las.by_return),
        said,
    )
    check(
        said["low"] == list(las.low)
        and said["high"] == list(las.high)
        and said["scale"] == list(las.scale)
        and said["wkt"] == expected["wkt"]
    )
    check(said["pulses"] == 200 and said["pulses_without_return"] == expected["without_return"])
    check([f["name"] for f in said["extra_fields"]] == [name for _, name in kExtra])
    if las.format == 9:
        check(said["waveforms"]["where"] == ("internal" if expected["internal"] else "external"), said)
        check(
            said["waveforms"]["descriptors"][0]
            == {
                "index": 1,
                "bits": expected["bits"],
                "samples": 256,
                "spacing_ps": 500,
                "gain": las.descriptor(1)[4],
                "offset": -1.25,
            },
            said["waveforms"],
        )


def main():
    samples, program = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        patience.run([samples, folder], check=True)
        expected = json.loads((folder / "expected.json").read_text())
        check(
            sorted(p.name for p in folder.iterdir())
            == ["bytes.las", "bytes.wdp", "expected.json", "inside.las", "nine.las", "nine.wdp", "six.las"]
        )
        for file, content in expected["files"].items():
            las = Las(folder / f"{file}.las")
            header(las, content)
            points(las, content)
            if content["format"] == 9:
                worst = waveforms(las, content, expected["gate_s"], expected["spacing_s"])
                print(f"{file}: L-28 worst place of a sample off by {worst * 1e3:.4f} mm")
            shown(program, folder, file, las, content)
        damaged(program, folder, Las(folder / "nine.las"))
        (folder / "nine.wdp").unlink()
        lone = patience.run([program, "info", folder / "nine.las"], capture_output=True, text=True)
        check(lone.returncode == 0 and "missing" in lone.stderr, lone)
    print(f"{checks} checks")


main()
