#!/usr/bin/python3
"""Restates the sun's spectra above the air as atmos_tables/data/solar_tsis1_gueymard.inc and solar_e490.inc.

Usage: restate_sun.py tsis1 FOLDER > solar_tsis1_gueymard.inc, FOLDER holding solar_tsis1_hsrs_350-2500nm_0p5nm.csv
(TSIS-1 HSRS) and solar_gueymard2004_composite.csv; or restate_sun.py e490 FILE > solar_e490.inc, FILE a CSV of
wavelength in um and W m-2 um-1. Every node is the average under its hat function, so that linear
interpolation keeps the irradiance of any stretch of a few nodes. Gueymard is scaled to TSIS-1 at both joints by the
ratio of their means over 50 nm; the scale fades to 1 over the next 50 nm.
"""

import sys

import numpy as np


def read(path):
    with open(path, encoding="utf-8") as file:
        rows = [line.split(",") for line in file if line[0].isdigit()]
    return np.array([float(r[0]) for r in rows]), np.array([float(r[1]) for r in rows])


def composite(folder):
    tw, te = read(f"{folder}/solar_tsis1_hsrs_350-2500nm_0p5nm.csv")
    gw, ge = read(f"{folder}/solar_gueymard2004_composite.csv")
    mean = lambda w, e, low, high: np.trapz(np.interp(x := np.linspace(low, high, 2001), w, e), x) / (high - low)
    low = mean(tw, te, 350, 400) / mean(gw, ge, 350, 400)
    high = mean(tw, te, 2450, 2500) / mean(gw, ge, 2450, 2500)
    scale = np.interp(gw, [300, 350, 2500, 2550], [1, low, high, 1])
    below, beyond = gw < 350, gw > 2500
    return np.concatenate([gw[below], tw[(tw >= 350) & (tw <= 2500)], gw[beyond]]), np.concatenate(
        [(ge * scale)[below], te[(tw >= 350) & (tw <= 2500)], (ge * scale)[beyond]]
    )


def hat_average(w, e, left, node, right):
    if left == right:
        return float(np.interp(node, w, e))
    x = np.linspace(left, right, 4001)
    hat = np.minimum(
        (x - left) / (node - left) if node > left else np.inf * np.ones_like(x),
        (right - x) / (right - node) if right > node else np.inf * np.ones_like(x),
    )
    return np.trapz(hat * np.interp(x, w, e), x) / np.trapz(hat, x)


TSIS1_HEAD = (
    "// Exoatmospheric solar irradiance at 1 AU, W m-2 um-1, wavelength nm (vacuum). 350 to 2500 nm: TSIS-1 hybrid "
    "solar\n"
    "// reference spectrum, Coddington, O. M. et al. (2021), Geophys. Res. Lett. 48, e2020GL091709. Below and "
    "beyond:\n"
    "// Gueymard, C. A. (2004), Solar Energy 76, 423-453, scaled to TSIS-1 at the joints. Averages under the hat "
    "function\n"
    "// of each node (2 nm to 1000 nm, 5 nm to 2500 nm, 20 nm to 4 um, 100 to 500 nm to 31 um), so that linear\n"
    "// interpolation keeps the irradiance of any stretch of a few nodes. Restated by "
    "atmos_tables/fit/restate_sun.py."
)
E490_HEAD = (
    "// Exoatmospheric solar irradiance at 1 AU, W m-2 um-1, wavelength nm: ASTM E-490-00a (2000), Standard Solar "
    "Constant\n"
    "// and Zero Air Mass Solar Spectral Irradiance Tables. Averages as in solar_tsis1_gueymard.inc. Restated by\n"
    "// atmos_tables/fit/restate_sun.py."
)


def main():
    if sys.argv[1] == "tsis1":
        w, e = composite(sys.argv[2])
    else:
        w, e = read(sys.argv[2])
        w = 1000 * w
    nodes = np.concatenate(
        [
            np.arange(300, 1000, 2),
            np.arange(1000, 2500, 5),
            np.arange(2500, 4000, 20),
            np.arange(4000, 6000, 100),
            np.arange(6000, 10000, 200),
            np.arange(10000, 31001, 500),
        ]
    )
    print(TSIS1_HEAD if sys.argv[1] == "tsis1" else E490_HEAD)
    line = ""
    for i, node in enumerate(nodes):
        left, right = nodes[max(i - 1, 0)], nodes[min(i + 1, len(nodes) - 1)]
        item = f"{{{node:g}, {hat_average(w, e, left, node, right):.5g}}}, "
        if len(line + item) > 120:
            print(line.rstrip())
            line = ""
        line += item
    print(line.rstrip())


main()
