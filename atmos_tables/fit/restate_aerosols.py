#!/usr/bin/python3
"""Restates LOWTRAN7's aerosol and cloud figures (AFGL-TR-88-0177, public domain) as
atmos_tables/aerosol/data/lowtran7_*.inc.

Usage: restate_aerosols.py FOLDER TARGET; writes TARGET/lowtran7_optics.inc, lowtran7_phases.inc and
lowtran7_heights.inc, with FOLDER holding lowtran7_aerosol_optics.csv, _aerosol_profiles.csv, _phase_functions.csv,
_phase_function_index.csv. Own layout: one row per substance and grade (relative humidity in %, wind speed in m/s for
desert, 0 where neither matters), extinction 1 at 0.55 um; phase functions as ln(4 pi P); profiles cut to their region.
"""

import contextlib
import csv
import math
import sys

# Own name -> (name in the optics, name in the phase index or None, grades).
HUMID = ["0", "70", "80", "99"]
SUBSTANCES = {
    "rural": ("rural", "rural", HUMID),
    "urban": ("urban", "urban", HUMID),
    "maritime": ("maritime_oceanic", "maritime", HUMID),
    "tropospheric": ("tropospheric", "tropospheric", HUMID),
    "desert": ("desert_wind", None, ["0", "10", "20", "30"]),
    "fog_advective": ("fog1_advective", "fog_advection", [""]),
    "fog_radiative": ("fog2_radiative", "fog_radiation", [""]),
    "stratospheric": ("stratospheric_background", "stratospheric_background", [""]),
    "volcanic_aged": ("volcanic_aged", "volcanic_aged", [""]),
    "volcanic_fresh": ("volcanic_fresh", "volcanic_fresh", [""]),
    "meteoric": ("meteoric_dust", "meteoric_dust", [""]),
    "cumulus": ("cloud_cumulus", None, [""]),
    "altostratus": ("cloud_altostratus", None, [""]),
    "stratus": ("cloud_stratus", None, [""]),
    "stratocumulus": ("cloud_stratocumulus", None, [""]),
    "nimbostratus": ("cloud_nimbostratus", None, [""]),
    "cirrus_64um": ("cirrus_64um", None, [""]),
    "cirrus_4um": ("cirrus_4um", None, [""]),
}
LONGEST_UM = 200  # most models end there
PROFILES = {  # own name -> (columns, lowest and highest row used, km)
    "kBoundary": (["bl_vis50", "bl_vis23", "bl_vis10", "bl_vis5", "bl_vis2"], 0, 2),
    "kTroposphere": (["trop_ss_vis50", "trop_ss_vis23", "trop_fw_vis50", "trop_fw_vis23"], 3, 10),
    "kStratosphere": (
        [
            "strat_bg_ss",
            "strat_modvolc_ss",
            "strat_hivolc_ss",
            "strat_exvolc_ss",
            "strat_bg_fw",
            "strat_modvolc_fw",
            "strat_hivolc_fw",
            "strat_exvolc_fw",
        ],
        11,
        30,
    ),
    "kUpper": (["upper_normal", "upper_volc_to_normal"], 35, 100),
}


def read(folder, name):
    with open(f"{folder}/lowtran7_{name}.csv", encoding="ascii") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def numbers(values, form):
    return "{" + ", ".join(format(float(v), form) for v in values) + "}"


def wrapped(text, indent):
    """Breaks a long row at commas, 120 columns; every line begins with `indent`."""
    lines, line = [], indent
    for part in text.split(", "):
        piece = part + ", "
        if len(line) + len(piece) > 120:
            lines.append(line.rstrip())
            line = indent
        line += piece
    return "\n".join(lines + [line.rstrip(", ")])


def optics(rows):
    waves = sorted({float(r["wavelength_um"]) for r in rows if float(r["wavelength_um"]) <= LONGEST_UM})
    print(f"constexpr double kWave_um[{len(waves)}] =")
    print(wrapped(numbers(waves, ".6g"), "  ") + ";")
    entries = [(own, source, grade) for own, (source, _, grades) in SUBSTANCES.items() for grade in grades]
    print("/// extinction and absorption over extinction at 0.55 um, asymmetry.")
    print(f"constexpr OpticsRow kOptics[{len(entries)}] = {{")
    for own, source, grade in entries:
        model, humidity = (source + grade, "") if own == "desert" else (source, grade)
        mine = {float(r["wavelength_um"]): r for r in rows if r["model"] == model and r["rh_percent"] == humidity}
        unit = float(mine[0.55]["extinction"])
        if len(grades := SUBSTANCES[own][2]) > 1:
            assert all(float(mine[w]["absorption"]) > 0 for w in waves), f"{own} {grades}: no logarithm of absorption"
        print(f'  {{"{own}", {grade or 0},')
        print(wrapped(numbers([float(mine[w]["extinction"]) / unit for w in waves], ".6g"), "   ") + ",")
        print(wrapped(numbers([float(mine[w]["absorption"]) / unit for w in waves], ".6g"), "   ") + ",")
        print(wrapped(numbers([mine[w]["asymmetry"] for w in waves], ".5g"), "   ") + "},")
    print("};")


def phase_functions(functions, index):
    angles = [r["angle_deg"] for r in functions]
    count = len(functions[0]) - 1
    print(f"constexpr double kPhaseAngle_deg[{len(angles)}] =")
    print(wrapped(numbers(angles, ".4g"), "  ") + ";")
    print(
        "/// ln(4 pi P) of the Mie functions, P per sr, as the source rounds them: their integrals are not exactly 1."
    )
    print(f"constexpr double kLogPhase[{count}][{len(angles)}] = {{")
    for i in range(1, count + 1):
        print(wrapped(numbers([math.log(4 * math.pi * float(r[f"P{i}"])) for r in functions], ".5f"), "  ") + ",")
    print("};")
    waves = [name for name in index[0] if name != "model"]
    print(f"constexpr double kPhaseWave_um[{len(waves)}] =")
    print(wrapped(numbers(waves, ".6g"), "  ") + ";")
    by_name = {r["model"]: r for r in index}
    entries = [(own, source, grade) for own, (_, source, grades) in SUBSTANCES.items() if source for grade in grades]
    print("/// Which row of kLogPhase a substance uses at each wavelength.")
    print(f"constexpr PhaseRow kPhase[{len(entries)}] = {{")
    for own, source, grade in entries:
        row = by_name[f"{source}_rh{grade}" if grade else source]
        print(f'  {{"{own}", {grade or 0},')
        print(wrapped(numbers([int(row[w]) - 1 for w in waves], ".0f"), "   ") + "},")
    print("};")


def profiles(rows):
    for name, (columns, low, high) in PROFILES.items():
        mine = [r for r in rows if low <= float(r["z_km"]) <= high]
        print(f"/// Height, km, then extinction at 0.55 um, km-1:")
        print(wrapped(", ".join(columns), "/// ") + ".")
        print(f"constexpr double {name}[{len(mine)}][{len(columns) + 1}] = {{")
        for r in mine:
            print("  " + numbers([r["z_km"]] + [r[c] for c in columns], ".6g") + ",")
        print("};")


def write(target, name, action, *tables):
    with open(f"{target}/lowtran7_{name}.inc", "w", encoding="ascii") as file, contextlib.redirect_stdout(file):
        print(
            "// Aerosols, fogs and clouds of LOWTRAN7 (Kneizys, F. X. et al. 1988, Users Guide to LOWTRAN 7, "
            "AFGL-TR-88-0177):"
        )
        print(
            "// models of Shettle, E. P. and Fenn, R. W. (1979), AFGL-TR-79-0214, and successors. US government, "
            "public domain."
        )
        print("// Restated by atmos_tables/fit/restate_aerosols.py.")
        action(*tables)


def main():
    folder, target = sys.argv[1:]
    write(target, "optics", optics, read(folder, "aerosol_optics"))
    write(target, "phases", phase_functions, read(folder, "phase_functions"), read(folder, "phase_function_index"))
    write(target, "heights", profiles, read(folder, "aerosol_profiles"))


if __name__ == "__main__":
    main()
