#!/usr/bin/env python3
"""Assembles the park scene in a folder: terrain, classes, tree meshes, placements, targets, band lists, scene files.

Usage: generate.py OUT [--seed N]        then: raycube render OUT/park.toml -o results/

Needs numpy and nothing else; about 5 s and 40 MB. The same seed gives the same files. Everything is made here or copied
from this folder (park*.toml, materials.toml, spectra/), so OUT can be moved as a whole. facts.json lists what was made.
"""

import argparse
import json
import re
import shutil
import sys
from pathlib import Path

import numpy as np

from generator import bands, layout, objects, planting, raster_io, terrain, trees

MADE_BY = "made by scenes/park/generate.py of raycube; data of the project's own"


def write_terrain(out, park):
    half, post = layout.HALF_M, layout.POST_M
    raster_io.write_envi(
        out / "dem.img",
        park.heights + raster_io.ORIGIN_HEIGHT_M,
        -half - post / 2,
        half + post / 2,
        post,
        f"heights above sea level in metres, {MADE_BY}",
    )
    raster_io.write_envi(
        out / "cover.img", park.fractions, -half, half, post, f"area fractions, {MADE_BY}", terrain.NAMES[1:]
    )
    raster_io.write_png(
        out / "classes.png", park.classes, terrain.PALETTE
    )  # the largest fraction: for people and checks
    raster_io.write_world_file(out / "classes.pgw", -half, half, post)
    area = park.fractions.sum((0, 1), dtype=np.float64) * post * post
    mixtures = len(np.unique(park.fractions.reshape(-1, len(area)) @ (terrain.STEPS * 17.0 ** np.arange(len(area)))))
    return {
        "posts": list(park.heights.shape),
        "post_m": post,
        "height_range_m": [round(float(park.heights.min()), 2), round(float(park.heights.max()), 2)],
        "class_area_m2": {n: round(float(a), 1) for n, a in zip(terrain.NAMES[1:], area)},
        "mixtures": mixtures,
    }


def write_objects(out):
    meshes = {
        "wood_block": objects.wood_block(),
        "yellow_target": objects.yellow_target(),
        "shed": objects.shed(),
        "fence": objects.fence(),
        "lamp_post": objects.lamp_post(),
        "court_lines": objects.court_lines(),
        "car_white": objects.car("white_paint"),
        "car_grey": objects.car("steel"),
        "car_red": objects.car("red_cloth"),
    }
    for name, groups in meshes.items():
        raster_io.write_obj(out / f"{name}.obj", groups, [f"{name}, metres, z up, {MADE_BY}"])
    return {name: int(sum(len(t) for _, _, t in groups)) for name, groups in meshes.items()}


def write_bands(out, sensors):
    """Sensors to copy, the bands that the park's own file names beside it; how many the spectrometer has."""
    shutil.copytree(sensors, out / "sensors", dirs_exist_ok=True)
    for name in ("spectir_360.csv", "wasp_rgb.csv"):
        shutil.copyfile(sensors / name, out / name)
    (out / "lwir_45.csv").write_text(
        "# Nominal thermal imaging spectrometer\ncenter_nm,fwhm_nm\n"
        + "".join(f"{c:g},{w:g}\n" for c, w in bands.lwir_45())
    )
    rows = (line for line in (sensors / "spectir_360.csv").read_text().splitlines() if not line.startswith("#"))
    return sum(1 for _ in rows) - 1


#: What the leaves and the grass of one species are made of, in place of those of others (--species 1).
ONE_SPECIES = {"half_dry_grass": "lawn_grass", "dry_grass": "lawn_grass", "aspen_leaf": "maple_leaf"}
ONE_SPECIES |= {"walnut_leaf": "maple_leaf", "spruce_needles": "maple_leaf"}


def write_materials(text, species):
    """materials.toml, in which all grass and all leaves are alike where one species is asked for."""
    if species != 1:
        return text
    parts = re.split(r"(?m)^(?=\[\[material\]\])", text)
    of = {re.search(r'name = "(.*)"', part).group(1): part for part in parts[1:]}
    for name, like in ONE_SPECIES.items():
        of[name] = of[like].replace(f'name = "{like}"', f'name = "{name}"')
    return parts[0] + "".join(of.values())


def main():
    parser = argparse.ArgumentParser(description="Assembles the park scene in a folder.")
    parser.add_argument("out", type=Path, help="folder to write; made when missing")
    parser.add_argument("--seed", type=int, default=2012, help="seed of everything drawn (default 2012)")
    parser.add_argument("--species", type=int, choices=(1, 4), default=4, help="1: all grass and all trees alike")
    arguments = parser.parse_args()
    out, seed, here = arguments.out, arguments.seed, Path(__file__).resolve().parent
    out.mkdir(parents=True, exist_ok=True)

    park = terrain.Park(seed)
    facts = {"seed": seed, "terrain": write_terrain(out, park), "trees": {}, "instances": {}}
    for name, make in trees.SPECIES.items():
        groups, facts["trees"][name] = make(seed)
        raster_io.write_obj(
            out / f"{name}.obj", groups, [f"{name}, metres, z up, {MADE_BY}", json.dumps(facts["trees"][name])]
        )
    facts["object_triangles"] = write_objects(out)

    placements = dict(planting.plant(park, seed))
    placements["fence"] = planting.fence()
    placements["green_targets"] = planting.green_targets(seed)
    placements.update({f"cars_{colour}": rows for colour, rows in planting.cars(seed).items()})
    for name, rows in placements.items():
        raster_io.write_placements(
            out / f"{name}.csv", rows, [f"{name}: scene metres, yaw clockwise from north, {MADE_BY}"]
        )
        facts["instances"][name] = len(rows)
    facts["bands"] = write_bands(out, here.parent / "sensors")

    for name in ("park.toml", "park_lwir.toml", "park_scene.toml"):
        shutil.copyfile(here / name, out / name)
    (out / "materials.toml").write_text(write_materials((here / "materials.toml").read_text(), arguments.species))
    shutil.copyfile(here.parent / "lidar" / "park_survey.toml", out / "park_survey.toml")
    shutil.copytree(here / "spectra", out / "spectra", dirs_exist_ok=True)
    (out / "facts.json").write_text(json.dumps(facts, indent=1) + "\n")
    print(
        f"park: {sum(facts['instances'].values())} instances, {len(facts['trees'])} plant meshes, {facts['bands']} "
        f"bands in {out}"
    )
    print(f"scene: {out / 'park.toml'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
