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

# A material: what it stands for. Below it its pieces from short to long wavelengths: file, the range it serves in nm,
# whether it keeps its measured level or is scaled until it meets the piece that does, and the sample's name.
MATERIALS = """
lawn_grass: mown lawn
    usgs_lawn_grass_green                  385  2500 keeps Lawn_Grass GDS91 green
    aster_grass                           2500 14000 meets grass (JHU, green grass)
half_dry_grass: meadow in September
    usgs_grass_half_dry_half_green         385  2500 keeps Grass_dry.5+.5green AMX28
    aster_dry_grass                       2500 14000 meets dry grass (JHU)
dry_grass: dry grass
    usgs_grass_golden_dry                  385  2490 keeps Grass_Golden_Dry GDS480
    aster_dry_grass                       2490 14000 meets dry grass (JHU)
straw: stubble
    aster_dry_grass                        385 14000 keeps dry grass (JHU)
maple_leaf: maple foliage
    usgs_maple_leaves                      385  2500 keeps Maple_Leaves DW92-1
    aster_decidous                        2500 14000 meets deciduous trees (JHU)
aspen_leaf: aspen foliage
    aster_decidous                         350   425 meets deciduous trees (JHU)
    usgs_aspen_leaf_green                  425  2430 keeps Aspen Aspen-1 green-top
    aster_decidous                        2430 14000 meets deciduous trees (JHU)
walnut_leaf: shrub foliage
    usgs_walnut_leaf                       385  2500 keeps Walnut_Leaf SUN (Green)
    aster_decidous                        2500 14000 meets deciduous trees (JHU)
spruce_needles: conifer foliage
    aster_conifer                          350 14000 keeps conifer trees (JHU)
bark: bark of stems and branches
    muufl_field_bark                       350   400 meets Bark, mean of 40
    rrtm_wood_bark                         400  2490 keeps wood-reflect
leaf_litter: forest floor
    muufl_field_ground_litter              350  1000 keeps GroundLitter, mean of 10
    usgs_oak_leaf_dried                   1000  2490 meets Oak Oak-Leaf-2 dried
loam: dark loam
    muufl_field_dirt                       350   400 meets Dirt, mean of 5
    aster_black_loam                       400 14000 keeps black loam 85P4663 (JHU)
track_soil: surface of the dirt track
    muufl_field_dirt                       350   400 meets Dirt, mean of 5
    rrtm_soil_dry_wet                      400  2490 keeps soil, dry
sand: dry sand
    usgs_sand_beach_dry                    385  2490 keeps Sand DWO-3-DEL2ar1 no oil
gravel: crushed grey stone; measured on a grey aggregate block
    usgs_cinder_block_grey                 385  2490 keeps Cinder_Block GDS356 Lg Grey
asphalt: old asphalt
    usgs_asphalt_road_old                  385  2490 keeps Asphalt GDS376 Blck_Road old
    aster_construction_asphalt            2490 14000 meets construction asphalt (JHU)
concrete: concrete
    usgs_concrete_road_light_grey          385  2490 keeps Concrete GDS375 Lt Gry Road
    aster_construction_concrete           2490 14000 meets construction concrete (JHU)
blue_cotton: blue cotton-like cloth
    muufl_cloth_blue                       350  2500 keeps target cloth Blue, laboratory
blue_felt: blue synthetic fabric in place of felt
    usgs_fabric_nylon_blue                 385  2490 keeps Nylon_Fabric GDS433 Blu RpSt
yellow_cotton: yellow cotton
    usgs_fabric_cotton_terrycloth_yellow   385  2490 keeps Terrycloth_Fabric GDS537 Yel
yellow_felt: yellow polymer in place of synthetic felt
    usgs_plastic_hdpe_yellow               385  2490 keeps Plastic_HDPE GDS386 Yelopaqu
red_nylon: red synthetic fabric
    usgs_fabric_nylon_red                  385  2490 keeps Nylon_Fabric GDS431 Red RpSt
burlap: brown burlap
    usgs_fabric_burlap_brown               385  2490 keeps Burlap_Fabric GDS430 Brown
green_paint: green painted wood; measured on the paint's pigment
    usgs_pigment_green_chromium_oxide      385  2490 keeps Oxide_of_chromium GDS795
white_paint: white paint; measured on the paint's pigment
    usgs_pigment_white_titanium_dioxide    385  2490 keeps Titanium_dioxide GDS798 TiO2
red_cloth: red car paint; measured on red cloth
    muufl_cloth_red                        350  2500 keeps target cloth Red, laboratory
steel: coated steel
    usgs_coated_steel_girder               385  2490 keeps Coated_Steel_Girder WTC01-8
black_rubber: tyres and dark glass; measured on black roofing felt
    usgs_roofing_felt_black                385  2490 keeps Roofing_Felt GDS377 Black
brick: shed walls
    usgs_brick_dark_red                    385  2490 keeps Brick GDS350 Dk Red Building
shingle: shed roof
    usgs_asphalt_shingle_dark_grey         385  2490 keeps Asphalt_Shingle GDS367 DkGry
wood: shed doors
    usgs_wood_beam_pine                    385  2490 keeps Wood_Beam GDS363 Nw Pine 2X4
"""


def materials(table):
    """(name, what it stands for, [(file, sample, from_nm, to_nm, scaled), ...]) of each material."""
    out = []
    for line in table.strip().splitlines():
        if line.startswith(" "):
            file, low, high, level, label = line.split(maxsplit=4)
            out[-1][2].append((file, label, int(low), int(high), {"keeps": False, "meets": True}[level]))
        else:
            name, _, stands_for = line.partition(": ")
            out.append((name, stands_for, []))
    return out


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
    everything = materials(MATERIALS)
    for name, stands_for, pieces in everything:
        (out / f"{name}.csv").write_text(restate(folder, name, stands_for, pieces))
    print(f"restate_spectra: {len(everything)} files in {out}")


if __name__ == "__main__":
    sys.exit(main())
