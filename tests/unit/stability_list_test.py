#!/usr/bin/python3
"""Checks that docs/stability.md stays true: stability_list_test.py SOURCE_DIR

Every line of its tables names tests that exist (or says that what it tests is not built yet), and every line that the
specification lists (REQUIREMENTS section 4) stands in a table.
"""

import pathlib
import re
import sys

# The specification's list, in the words of our tables; a line taken out of the document is missed here.
LINES = """
axis-parallel rays in slab planes|hits on edges and vertices of closed bodies, hits listed twice|coincident faces
slivers, zero-area faces|vertices not finite|grazing views, 80 to 89.9 degrees
self-shadowing of low-poly bodies, and at 20 km|traversal deeper than the stack|1 mm beside 100 km
UTM-sized coordinates|earth-centred coordinates|an empty scene|a scene of one triangle|a sensor inside a closed body
white furnace at 1e8 samples|sampling phase against a 1-foot checkerboard|grids of 1 x 1 to 31 x 31
any tile size, memory, page, thread count|a band narrower than the table's step|a band outside the table
bands out of order, duplicate, overlapping|a spectrum that ends inside a band|transmission of 1e-12
reflectance 0, 1, above 1|optical depth 0, 1e-6, 1, 700|sun at and below the horizon|view at the horizon
sensor on the ground, inside and above the air|single-scattering albedo exactly 1|a target above the sensor|0 K
a foil of 1 mm and a slab of 10 m|time steps of 1 s to 1 h|a facet in shadow all day|sub-rays at equal range
the axis misses, the footprint hits|returns at a bin's edge and outside the gate|zero divergence
bins narrower and wider than the pulse|600 m, 20 km, 400 km at 0.1 ns|no photons, 1e9 photons|near-field overlap
optical depth 20|NaN, infinity, negative, empty|wrong unit, wrong byte order|truncated and 0-byte files
`******` in a table|10 GB in a small header|unknown keys, a cyclic include|no OpenCL device|a device without fp64
a device of 256 MB|a full disk|read-only output|Ctrl-C|kill -9 while writing|two runs into one output
a corrupt kernel cache
""".strip().replace("\n", "|").split("|")
NOT_BUILT = "not built: "


def ctest_names(root):
    text = "\n".join(part.read_text() for part in (root / "tests").rglob("*.cmake"))
    names = set(re.findall(r"^\s*raycube_(?:cli_)?test\((\w+)", text, re.M)) | set(
        re.findall(r"add_test\(NAME (\w+)", text)
    )
    return names - {"name"}


def problems(root):
    text = (root / "docs/stability.md").read_text()
    known = ctest_names(root)
    rows = [
        [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        for line in text.splitlines()
        if line.startswith("| ") and not line.startswith("| where")
    ]
    places = [row[0] for row in rows]
    for line in LINES:
        if places.count(line) != 1:
            yield f"docs/stability.md holds the line '{line}' {places.count(line)} times, must be once"
    for row in rows:
        if len(row) != 3 or not all(row):
            yield f"line '{row[0]}' has {len(row)} cells, must have where, tests and what they are held against"
            continue
        if row[1].startswith(NOT_BUILT):
            if "heat" not in (root / "docs/status.md").read_text():
                yield f"line '{row[0]}' is not built, and docs/status.md does not say so"
            continue
        tests = re.findall(r"`(\w+)`", row[1])
        if not tests or re.sub(r"`\w+`|, ", "", row[1]):
            yield f"line '{row[0]}' names its tests as '{row[1]}', must be a list of `names`"
        for test in tests:
            if test not in known:
                yield f"line '{row[0]}': no test '{test}' in tests/*.cmake"


def main():
    found = list(problems(pathlib.Path(sys.argv[1])))
    print(
        "\n".join(found)
        if found
        else f"docs/stability.md: {len(LINES)} lines, each with tests that exist or named as not built"
    )
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
