#!/usr/bin/python3
"""Restates the moon's albedo that LOWTRAN7 (AFGL-TR-88-0177, public domain) used, as atmos_tables/data/moon_albedo.inc.

Usage: restate_moon.py lowtran7_direct_vnir_swir.csv > moon_albedo.inc. The file holds lunar and solar irradiance above
the air for a phase angle of 30 degrees (columns Emoon0, E0), 0.3 to 2.5 um. Their ratio over the program's factor
2.04472e-7 and its phase figure 42.3 is the albedo, which is linear between steps of 0.1 um: the nodes come from a
least-squares fit of that.
"""

import csv
import sys

import numpy

FACTOR, PHASE_30 = 2.04472e-7, 42.3
NODES = numpy.arange(3, 26) / 10


def main():
    with open(sys.argv[1], encoding="ascii") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    wave = numpy.array([1e4 / float(r["nu_cm1"]) for r in rows])
    albedo = numpy.array([float(r["Emoon0"]) / float(r["E0"]) for r in rows]) / FACTOR / PHASE_30
    hats = numpy.array([numpy.interp(wave, NODES, unit) for unit in numpy.eye(len(NODES))]).T
    inside = wave >= NODES[0]
    found = numpy.linalg.lstsq(hats[inside], albedo[inside], rcond=None)[0]
    rounded = numpy.round(found, 3)
    miss = abs(hats[inside] @ rounded / albedo[inside] - 1).max()
    assert miss < 1.5e-3, f"the albedo is not linear between the nodes: {miss}"
    print(
        "// Geometric albedo of the moon against wavelength, um: LOWTRAN7 (Kneizys, F. X. et al. 1988, "
        "AFGL-TR-88-0177; US"
    )
    print("// government, public domain). To 2.5 um fitted to the program's lunar and solar irradiances by")
    print(f"// atmos_tables/fit/restate_moon.py, which they follow to {miss:.1e}.")
    for x, y in zip(NODES, rounded):
        print(f"{{{x:.1f}, {y:.3f}}},")


if __name__ == "__main__":
    main()
