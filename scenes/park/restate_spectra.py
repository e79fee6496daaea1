#!/usr/bin/env python3
"""Makes scenes/park/spectra/*.csv: published measurements restated at 10 nm (to 2.5 um) and 20 to 100 nm (to 14 um).

Usage: RAYCUBE_SHARED=FOLDER restate_spectra.py        (reads FOLDER/data/spectra, writes beside this file)

A material is a list of measured pieces, each with the range it serves. Within a piece the value at a grid point is the
mean of the measured points in the grid cell, or linear interpolation where the cell holds none: deep water-vapour gaps
of field spectra are bridged that way, and the header says where. A second piece that continues a first one beyond its
measured range may be scaled so that the two meet; the header gives the factor. Only libraries that may be passed on are
used: USGS splib07 (public domain), ECOSTRESS/ASTER (free use with citation), MUUFL Gulfport and rrtm (MIT).
"""

import os
import sys
from pathlib import Path

import numpy as np

LIBRARIES = {
    "usgs": "USGS Spectral Library Version 7 (Kokaly et al. 2017, doi:10.5066/F7RR1WDJ), public domain",
    "aster": "ASTER/ECOSTRESS spectral library (Baldridge et al. 2009, doi:10.1016/j.rse.2008.11.007; (c) Caltech/JPL, "
    "free use with citation)",
    "muufl": "MUUFL Gulfport data (Gader et al., REP-2013-570, University of Florida 2013), MIT licence",
    "rrtm": "R package rrtm, wood and soil spectra after PEcAn and PROSAIL, MIT licence",
}

FADE_NM = 3500.0  # a continuation into the thermal infrared keeps its own measured level from here on

# name: (what it stands for, [(file, sample, from_nm, to_nm, scale to meet the piece before/after it), ...])
# `anchor` pieces (scaled False) keep the measured level.
MATERIALS = {
    "lawn_grass": (
        "mown lawn",
        [
            ("usgs_lawn_grass_green", "Lawn_Grass GDS91 green", 385, 2500, False),
            ("aster_grass", "grass (JHU, green grass)", 2500, 14000, True),
        ],
    ),
    "half_dry_grass": (
        "meadow in September",
        [
            ("usgs_grass_half_dry_half_green", "Grass_dry.5+.5green AMX28", 385, 2500, False),
            ("aster_dry_grass", "dry grass (JHU)", 2500, 14000, True),
        ],
    ),
    "dry_grass": (
        "dry grass",
        [
            ("usgs_grass_golden_dry", "Grass_Golden_Dry GDS480", 385, 2490, False),
            ("aster_dry_grass", "dry grass (JHU)", 2490, 14000, True),
        ],
    ),
    "straw": ("stubble", [("aster_dry_grass", "dry grass (JHU)", 385, 14000, False)]),
    "maple_leaf": (
        "maple foliage",
        [
            ("usgs_maple_leaves", "Maple_Leaves DW92-1", 385, 2500, False),
            ("aster_decidous", "deciduous trees (JHU)", 2500, 14000, True),
        ],
    ),
    "aspen_leaf": (
        "aspen foliage",
        [
            ("aster_decidous", "deciduous trees (JHU)", 350, 425, True),
            ("usgs_aspen_leaf_green", "Aspen Aspen-1 green-top", 425, 2430, False),
            ("aster_decidous", "deciduous trees (JHU)", 2430, 14000, True),
        ],
    ),
    "walnut_leaf": (
        "shrub foliage",
        [
            ("usgs_walnut_leaf", "Walnut_Leaf SUN (Green)", 385, 2500, False),
            ("aster_decidous", "deciduous trees (JHU)", 2500, 14000, True),
        ],
    ),
    "spruce_needles": ("conifer foliage", [("aster_conifer", "conifer trees (JHU)", 350, 14000, False)]),
    "bark": (
        "bark of stems and branches",
        [
            ("muufl_field_bark", "Bark, mean of 40", 350, 400, True),
            ("rrtm_wood_bark", "wood-reflect", 400, 2490, False),
        ],
    ),
    "leaf_litter": (
        "forest floor",
        [
            ("muufl_field_ground_litter", "GroundLitter, mean of 10", 350, 1000, False),
            ("usgs_oak_leaf_dried", "Oak Oak-Leaf-2 dried", 1000, 2490, True),
        ],
    ),
    "loam": (
        "dark loam",
        [
            ("muufl_field_dirt", "Dirt, mean of 5", 350, 400, True),
            ("aster_black_loam", "black loam 85P4663 (JHU)", 400, 14000, False),
        ],
    ),
    "track_soil": (
        "surface of the dirt track",
        [("muufl_field_dirt", "Dirt, mean of 5", 350, 400, True), ("rrtm_soil_dry_wet", "soil, dry", 400, 2490, False)],
    ),
    "sand": ("dry sand", [("usgs_sand_beach_dry", "Sand DWO-3-DEL2ar1 no oil", 385, 2490, False)]),
    "gravel": (
        "crushed grey stone; measured on a grey aggregate block",
        [("usgs_cinder_block_grey", "Cinder_Block GDS356 Lg Grey", 385, 2490, False)],
    ),
    "asphalt": (
        "old asphalt",
        [
            ("usgs_asphalt_road_old", "Asphalt GDS376 Blck_Road old", 385, 2490, False),
            ("aster_construction_asphalt", "construction asphalt (JHU)", 2490, 14000, True),
        ],
    ),
    "concrete": (
        "concrete",
        [
            ("usgs_concrete_road_light_grey", "Concrete GDS375 Lt Gry Road", 385, 2490, False),
            ("aster_construction_concrete", "construction concrete (JHU)", 2490, 14000, True),
        ],
    ),
    "blue_cotton": (
        "blue cotton-like cloth",
        [("muufl_cloth_blue", "target cloth Blue, laboratory", 350, 2500, False)],
    ),
    "blue_felt": (
        "blue synthetic fabric in place of felt",
        [("usgs_fabric_nylon_blue", "Nylon_Fabric GDS433 Blu RpSt", 385, 2490, False)],
    ),
    "yellow_cotton": (
        "yellow cotton",
        [("usgs_fabric_cotton_terrycloth_yellow", "Terrycloth_Fabric GDS537 Yel", 385, 2490, False)],
    ),
    "yellow_felt": (
        "yellow polymer in place of synthetic felt",
        [("usgs_plastic_hdpe_yellow", "Plastic_HDPE GDS386 Yelopaqu", 385, 2490, False)],
    ),
    "red_nylon": (
        "red synthetic fabric",
        [("usgs_fabric_nylon_red", "Nylon_Fabric GDS431 Red RpSt", 385, 2490, False)],
    ),
    "burlap": ("brown burlap", [("usgs_fabric_burlap_brown", "Burlap_Fabric GDS430 Brown", 385, 2490, False)]),
    "green_paint": (
        "green painted wood; measured on the paint's pigment",
        [("usgs_pigment_green_chromium_oxide", "Oxide_of_chromium GDS795", 385, 2490, False)],
    ),
    "white_paint": (
        "white paint; measured on the paint's pigment",
        [("usgs_pigment_white_titanium_dioxide", "Titanium_dioxide GDS798 TiO2", 385, 2490, False)],
    ),
    "red_cloth": (
        "red car paint; measured on red cloth",
        [("muufl_cloth_red", "target cloth Red, laboratory", 350, 2500, False)],
    ),
    "steel": ("coated steel", [("usgs_coated_steel_girder", "Coated_Steel_Girder WTC01-8", 385, 2490, False)]),
    "black_rubber": (
        "tyres and dark glass; measured on black roofing felt",
        [("usgs_roofing_felt_black", "Roofing_Felt GDS377 Black", 385, 2490, False)],
    ),
    "brick": ("shed walls", [("usgs_brick_dark_red", "Brick GDS350 Dk Red Building", 385, 2490, False)]),
    "shingle": ("shed roof", [("usgs_asphalt_shingle_dark_grey", "Asphalt_Shingle GDS367 DkGry", 385, 2490, False)]),
    "wood": ("shed doors", [("usgs_wood_beam_pine", "Wood_Beam GDS363 Nw Pine 2X4", 385, 2490, False)]),
}


def grid_nm(low, high):
    """Output wavelengths: 10 nm to 2.5 um, 20 nm to 3 um, 50 nm to 5 um, 100 nm beyond."""
    grid = np.concatenate(
        [np.arange(350, 2500, 10), np.arange(2500, 3000, 20), np.arange(3000, 5000, 50), np.arange(5000, 14001, 100)]
    )
    grid = np.unique(np.concatenate([[low], grid[(grid >= low) & (grid <= high)], [high]])).astype(float)
    keep = np.concatenate([[True], np.diff(grid) > 2.5])
    return grid[keep]


def read(folder, name):
    rows = [
        line.split(",")
        for line in (folder / f"{name}.csv").read_text().splitlines()
        if line and not line.startswith(("#", "wavelength"))
    ]
    data = np.array([(float(r[0]) * 1000, float(r[1])) for r in rows])
    return data[np.argsort(data[:, 0])]


def sample(data, grid, half_width):
    """Mean of the measured points within half a grid step, else linear interpolation; never extrapolates."""
    if grid[0] < data[0, 0] - 0.6 or grid[-1] > data[-1, 0] + 0.6:
        raise SystemExit(
            f"restate_spectra: measured {data[0, 0]:.1f}-{data[-1, 0]:.1f} nm, wanted {grid[0]}-{grid[-1]} nm"
        )
    out = np.interp(grid, data[:, 0], data[:, 1])
    for i, (w, h) in enumerate(zip(grid, half_width)):
        inside = np.abs(data[:, 0] - w) <= h
        if inside.sum() >= 3:  # fewer points would shift a slope towards one side
            out[i] = data[inside, 1].mean()
    return out


def gaps(data, low, high):
    """Stretches without measured points that are wider than 30 nm below 2.5 um."""
    d = data[(data[:, 0] >= low) & (data[:, 0] <= min(high, 2500)), 0]
    return [(a, b) for a, b in zip(d[:-1], d[1:]) if b - a > 30]


def restate(folder, name, stands_for, pieces):
    low, high = pieces[0][2], pieces[-1][3]
    grid = grid_nm(low, high)
    half = np.minimum(np.diff(grid, prepend=grid[0] - 10), np.diff(grid, append=grid[-1] + 10)) / 2
    anchor = next(i for i, p in enumerate(pieces) if not p[4])
    measured = [read(folder, p[0]) for p in pieces]
    values, factors = [None] * len(pieces), [1.0] * len(pieces)
    for i in [anchor] + [k for k in range(len(pieces)) if k != anchor]:
        _, _, a, b, scaled = pieces[i]
        if scaled:  # meet the anchor at the joint: means over 20 nm (40 nm above 2.4 um) on both sides of it
            joint, width = (b, 10) if i < anchor else (a, 20)
            level = [d[(np.abs(d[:, 0] - joint) <= width), 1].mean() for d in (measured[anchor], measured[i])]
            factors[i] = level[0] / level[1]
        inside = (grid >= a) & ((grid < b) | (i == len(pieces) - 1))
        fade = (
            np.clip((grid[inside] - joint) / (FADE_NM - joint), 0, 1) if scaled and i > anchor and b > FADE_NM else 0.0
        )
        values[i] = (factors[i] + (1 - factors[i]) * fade) * sample(measured[i], grid[inside], half[inside])
    value = np.concatenate(values)
    if not (np.all(np.isfinite(value)) and value.min() >= 0 and value.max() <= 1):
        raise SystemExit(f"restate_spectra: {name} leaves [0, 1]: {value.min()} .. {value.max()}")
    head = [f"# {name}: {stands_for}"]
    sources = []
    for (file, label, a, b, scaled), factor, data in zip(pieces, factors, measured):
        text = f'{LIBRARIES[file.split("_")[0]]}, sample "{label}", {a}-{b} nm'
        if scaled:
            text += f", times {factor:.4f} to meet its neighbour"
            text += f", the factor going linearly to 1 at {FADE_NM:g} nm" if b > FADE_NM and a > 2000 else ""
        for g in gaps(data, a, b):
            text += f"; no data {g[0]:.0f}-{g[1]:.0f} nm, bridged linearly"
        sources.append(text)
    head.append("# source: " + " | ".join(sources))
    head.append(f"# ends at {grid[0]:.0f} and {grid[-1]:.0f} nm: nothing is known beyond")
    body = ["wavelength_nm,reflectance"] + [f"{w:g},{v:.5f}" for w, v in zip(grid, value)]
    return "\n".join(head + body) + "\n"


def main():
    if "RAYCUBE_SHARED" not in os.environ:
        raise SystemExit("restate_spectra: set RAYCUBE_SHARED to the folder that holds data/spectra")
    folder = Path(os.environ["RAYCUBE_SHARED"]) / "data" / "spectra"
    out = Path(__file__).resolve().parent / "spectra"
    out.mkdir(exist_ok=True)
    for name, (stands_for, pieces) in MATERIALS.items():
        (out / f"{name}.csv").write_text(restate(folder, name, stands_for, pieces))
    print(f"restate_spectra: {len(MATERIALS)} files in {out}")


if __name__ == "__main__":
    sys.exit(main())
