#!/usr/bin/python3
"""Restates the six AFGL model atmospheres (AFGL-TR-86-0110, public domain) as atmos_tables/optics/data/afgl_1986.inc.

Usage: restate_afgl.py FOLDER > afgl_1986.inc, FOLDER holding afgl_<model>.csv (columns z_km, p_hPa, T_K, <gas>_ppmv,
air_cm3).
"""

import csv
import sys

MODELS = [
    "tropical",
    "midlatitude_summer",
    "midlatitude_winter",
    "subarctic_summer",
    "subarctic_winter",
    "us_standard_1976",
]
OWN = ["p_hPa", "T_K", "air_cm3", "h2o_ppmv", "o3_ppmv", "n2o_ppmv", "co_ppmv", "ch4_ppmv"]
COMMON = ["z_km", "co2_ppmv", "o2_ppmv"]


def read(folder, model):
    with open(f"{folder}/afgl_{model}.csv", encoding="ascii") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def row(values):
    return "{" + ", ".join(f"{float(value):.6g}" for value in values) + "}"


def main():
    tables = [read(sys.argv[1], model) for model in MODELS]
    for table in tables:
        assert [[r[c] for c in COMMON] for r in table] == [
            [r[c] for c in COMMON] for r in tables[0]
        ], "levels or CO2, O2 differ"
    print(
        "// Six model atmospheres, 0 to 120 km: Anderson, G. P. et al. (1986), AFGL Atmospheric Constituent Profiles "
        "(0-120 km),"
    )
    print("// AFGL-TR-86-0110, as in LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177); US government, public domain.")
    print("// Restated by atmos_tables/fit/restate_afgl.py.")
    print(f"constexpr CommonRow kCommon[{len(tables[0])}] = {{")
    for r in tables[0]:
        print("  " + row(r[c] for c in COMMON) + ",")
    print("};")
    print(f"constexpr ModelRow kModels[{len(tables)}][{len(tables[0])}] = {{")
    for model, table in zip(MODELS, tables):
        print(f"  {{  // {model}")
        for r in table:
            print("    " + row(r[c] for c in OWN) + ",")
        print("  },")
    print("};")


if __name__ == "__main__":
    main()
