#!/usr/bin/python3
"""Restates absorption by gases as atmos_tables/gas/data/*.inc: bands of LOWTRAN7 and 6S, continua, ozone, five trace
gases.

Usage: restate_gases.py FOLDER OUT, FOLDER holding gas/*.csv and profiles/afgl_trace_gases.csv. Logarithms of 6S are
scaled by 1e4 and rounded (relative error of a coefficient 1.2e-4, of a transmittance below 4e-5).
"""

import csv
import math
import os
import sys

FIRST, LAST, STEP = 330, 17860, 5  # cm-1, the model's grid of lines
LOWTRAN = (
    "LOWTRAN7 rev. 4.2 (Kneizys et al. 1988, AFGL-TR-88-0177), US Air Force\n"
    "// Geophysics Laboratory; US government, public domain. Restated by atmos_tables/fit/restate_gases.py."
)
GASES = ["H2O", "CO2", "O3", "N2O", "CO", "CH4", "O2", "NO", "SO2", "NO2", "NH3"]  # order of LineGas
SIXS_GASES = GASES[:7]
PLANCK_C2 = 1.4387769  # cm K, h c / k (SI 2019)
# Amounts no path exceeds, g cm-2 (6S): bins whose depth stays below 1e-6 in them are left out.
MOST_G_CM2 = {"H2O": 100, "CO2": 20, "O3": 0.05, "N2O": 0.02, "CO": 0.01, "CH4": 0.02, "O2": 5000}


def read(folder, name):
    with open(os.path.join(folder, name), encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def log_1e4(value):
    return round(1e4 * math.log10(value)) if value > 0 else -1000000


def number(text):
    return float(text) if text else 0.0


def block(kind, name, values):
    lines = [f"constexpr {kind} {name}[{len(values)}] = {{"]
    row = " "
    for value in values:
        item = f" {value},"
        if len(row) + len(item) > 120:
            lines.append(row)
            row = " "
        row += item
    return "\n".join(lines + [row, "};"]) + "\n"


def lowtran_lines(folder):
    coefficient = {int(r["wavenumber_cm1"]): r for r in read(folder, "gas/lowtran7_cprime.csv")}
    runs, packed = [], []
    for region in read(folder, "gas/lowtran7_band_regions.csv"):
        gas = region["species"]
        first = max(int(region["v1_cm1"]), FIRST)
        last = min(int(region["v2_cm1"]), LAST)
        if first > last:
            continue
        values = [coefficient[v][gas + "_Cp"] for v in range(first, last + 1, STEP)]
        assert all(values), f"{gas} {first}: a region with a gap"
        runs.append(
            f"  {{LineGas::{gas.lower()}, {first}, {len(values)}, {len(packed)}, {float(region['a']):g}, "
            f"{float(region['n_pressure']):g}, {float(region['m_temperature']):g}}},"
        )
        packed += [round(1e5 * float(value)) for value in values]
    return (
        f"// Bands of 11 gases, {FIRST} to {LAST} cm-1 at {STEP} cm-1, resolution 20 cm-1 (Pierluissi & Maragoudakis\n"
        f"// 1986, AFGL-TR-86-0272), from {LOWTRAN}\n"
        "// Run: gas, first wavenumber, points, place of the first in kLog10C_1e5, exponent a of T = exp(-(C W)^a), "
        "exponents n\n"
        "// and m of the amount W = int U (p / 1013.25 hPa)^n (273.15 K / T)^m ds. C in cm2 g-1 (water) or "
        "(atm-cm)-1.\n"
        f"constexpr LowtranRun kRuns[{len(runs)}] = {{\n"
        + "\n".join(runs)
        + "\n};\n"
        + block("int", "kLog10C_1e5", packed)
    )


def sixs_lines(folder):
    runs, packed = [], []
    for gas in SIXS_GASES:
        rows = [r for r in read(folder, "gas/sixs_band_model_10cm1.csv") if r["gas"] == gas]
        rows = [r for r in rows if float(r["a1"]) * MOST_G_CM2[gas] >= 1e-6 and int(r["v1_cm1"]) <= 17250]
        begin = 0
        for i, row in enumerate(rows):
            if i + 1 < len(rows) and int(rows[i + 1]["v1_cm1"]) == int(row["v1_cm1"]) + 10:
                continue
            runs.append(f"  {{LineGas::{gas.lower()}, {rows[begin]['v1_cm1']}, {i + 1 - begin}, {len(packed) // 6}}},")
            for r in rows[begin : i + 1]:
                packed += [log_1e4(float(r["a1"])), log_1e4(float(r["a2"]))]
                packed += [round(1e6 * float(r["a3"])), round(1e8 * float(r["a4"]))]
                packed += [round(1e6 * float(r["a5"])), round(1e8 * float(r["a6"]))]
            begin = i + 1
    return (
        "// Random band models of 7 gases in bins of 10 cm-1: 6S / 6SV, Vermote, Tanre, Deuze, Herman & Morcrette "
        "(1997), IEEE\n"
        "// TGRS 35, 675-686, computed by its authors from AFGL and HITRAN lines (subroutines WAVA*, DICA*, OXYG*, "
        "OZON1,\n"
        "// NIOX*, METH*, MOCA*).\n"
        "// Notice of the source: 6S itself is distributed without restriction; copy from the robintw/6S mirror "
        "(MIT-style\n"
        "// licence text).\n"
        "// Keep this notice with the figures.\n"
        "// Restated by atmos_tables/fit/restate_gases.py; bins that stay below a depth of 1e-6 in any path are left\n"
        "// out.\n"
        "// Run: gas, lower edge of the first bin, bins, place of the first. Bin: 1e4 lg a1, 1e4 lg a2, 1e6 a3, 1e8 "
        "a4, 1e6 a5,\n"
        "// 1e8 a6.\n"
        f"constexpr SixsRun kRuns[{len(runs)}] = {{\n" + "\n".join(runs) + "\n};\n" + block("int", "kBins", packed)
    )


def water_continuum(folder):
    """cm2 per molecule and unit of relative density, radiation term and LOWTRAN7's own correction of 1985 included."""
    columns = [[], [], []]
    for row in read(folder, "gas/lowtran7_h2o_continuum.csv"):
        v = int(row["wavenumber_cm1"])
        if not FIRST <= v <= LAST:
            continue
        cold, warm = (v * math.tanh(PLANCK_C2 * v / (2 * t)) for t in (260.0, 296.0))
        correction = 1 - 0.2333 * 200.0**2 / ((v - 1050.0) ** 2 + 200.0**2)
        columns[0].append(warm * correction * float(row["Cs_self_296K"]))
        columns[1].append(cold * correction * float(row["Cs_self_260K"]))
        columns[2].append(warm * (float(row["Cf_foreign_296K"]) + float(row["F_farwing"])))
    return (
        "// Water continuum, 1e-20 cm2 per molecule at a density of one Loschmidt: by water at 296 K and 260 K, by\n"
        "// air.\n"
        + "".join(curve(f"kWater{n}", FIRST, 10, c) for n, c in zip(("Self296", "Self260", "Foreign"), columns))
    )


def curve(name, first, step, values):
    return (
        f"constexpr int {name}First = {first};\n"
        + f"// step {step} cm-1\n"
        + block("double", name, [f"{v:.5g}" for v in values])
    )


def continua(folder):
    rows = {int(r["wavenumber_cm1"]): r for r in read(folder, "gas/lowtran7_n2_hno3_o2_continua.csv")}

    def column(column_name, factor=None):
        present = [v for v, r in rows.items() if r[column_name]]
        out = []
        for v in range(min(present), max(present) + 1, STEP):
            row = rows.get(v, {})
            out.append(number(row.get(column_name)) * (number(row.get(factor)) if factor else 1))
        return min(present), out

    text = ""
    for name, first_last in (
        ("kNitrogen", column("N2_C4_per_km")),
        ("kNitricAcid", column("HNO3_k_per_atmcm")),
        ("kOxygen", column("O2_sigma")),
        ("kOxygenPerK", column("O2_sigma", "O2_alpha")),
        ("kOxygenPerK2", column("O2_sigma", "O2_beta")),
    ):
        text += curve(name, first_last[0], STEP, first_last[1])
    return text


def ozone(folder):
    rows = {int(r["wavenumber_cm1"]): r for r in read(folder, "gas/lowtran7_o3_uvvis_o2_herzberg.csv")}
    visible = [number(rows[v]["k_vis_per_atmcm"]) for v in range(13000, 24301, 50)]
    text = curve("kOzoneVisible", 13000, 50, visible)

    def ultraviolet(v):
        row = rows[v]
        c0 = number(row["C0_1e-20cm2"]) * 0.268678  # 1e-20 cm2 times molecules cm-2 in one atm-cm
        return [c0, c0 * number(row["C1_per_K"]), c0 * number(row["C2_per_K2"])]

    fine = [ultraviolet(v) for v in range(27360, 33401, 20)]
    for i, name in enumerate(("kOzoneNear", "kOzoneNearPerK", "kOzoneNearPerK2")):
        text += curve(name, 27360, 20, [r[i] for r in fine])
    # Beyond the model's range of proof 100 cm-1 are enough: means of the five points around.
    coarse = []
    for v in range(33400, 50001, 100):
        near = [ultraviolet(u) for u in ((v - 40, v - 20, v, v + 20, v + 40) if v < 40760 else (v,))]
        coarse.append([sum(r[i] for r in near) / len(near) for i in range(3)])
    for i, name in enumerate(("kOzoneFar", "kOzoneFarPerK", "kOzoneFarPerK2")):
        text += curve(name, 33400, 100, [r[i] for r in coarse])
    text += curve("kHerzberg", 36000, 100, [number(rows[v]["O2_herzberg_per_atmcm"]) for v in range(36000, 50001, 100)])
    return text


def grey(folder):
    head = f"// What absorbs without line structure, from {LOWTRAN}\n"
    continua_head = (
        "// Nitrogen per km, nitric acid per atm-cm, oxygen near 6.4 um (at 220 K and its change with temperature) "
        "per\n"
        "// atm-cm.\n"
    )
    ozone_head = (
        "// Ozone per atm-cm, visible (Chappuis) and ultraviolet (Bass & Paur 1985, Molina & Molina 1986, Cacciani "
        "1987:\n"
        "// value at 273.15 K and its change with temperature); Herzberg continuum of oxygen per atm-cm.\n"
    )
    return head + water_continuum(folder) + continua_head + continua(folder) + ozone_head + ozone(folder)


def trace(folder):
    names = ["no", "so2", "no2", "nh3", "hno3"]
    rows = read(folder, "profiles/afgl_trace_gases.csv")
    return (
        f"// Five trace gases, ppmv, one profile for all models: Anderson et al. (1986), AFGL-TR-86-0110, as in\n"
        f"// {LOWTRAN}\n"
        "// height in km, " + ", ".join(n.upper() for n in names) + "\n"
        f"constexpr TraceRow kTrace[{len(rows)}] = {{\n"
        + "".join(
            "  {" + ", ".join(f"{float(r[c]):.6g}" for c in ["z_km"] + [n + "_ppmv" for n in names]) + "},\n"
            for r in rows
        )
        + "};\n"
    )


def main():
    folder, out = sys.argv[1:]
    for name, text in (
        ("lowtran7_lines", lowtran_lines),
        ("sixs_lines", sixs_lines),
        ("grey_gases", grey),
        ("trace_gases", trace),
    ):
        with open(os.path.join(out, name + ".inc"), "w", encoding="ascii") as file:
            file.write(text(folder))


if __name__ == "__main__":
    main()
