#!/usr/bin/env python3
"""Checks the shipped park against issue-level numbers, reading the files as any user would (S1, S2, S3, S42, S52, S54).

Usage: park_generator_test.py SCENES_DIR WORK_DIR [--full]. Exit status 1 and one line per failure.
Without --full the generator runs once: that the same seed makes the same files takes it a second time.
The oracle is the requirement itself: counts and sizes are taken from the written files, never from facts.json.
"""

import csv
import hashlib
import math
import struct
import sys
import tomllib
import zlib
from pathlib import Path

import numpy as np

import patience

failures = []


def check(name, ok, found):
    print(f"{'ok  ' if ok else 'FAIL'} {name}: {found}")
    if not ok:
        failures.append(name)


def table(path):
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    rows = list(csv.reader(lines))
    return rows[0], np.array(rows[1:], float)


def obj(path):
    """Vertices, and triangles per material."""
    vertices, faces, material = [], {}, None
    for line in path.read_text().splitlines():
        if line.startswith("v "):
            vertices.append(tuple(map(float, line.split()[1:4])))
        elif line.startswith("usemtl "):
            material = line[7:]
        elif line.startswith("f "):
            faces.setdefault(material, []).append([int(w) - 1 for w in line.split()[1:]])
    return np.array(vertices), {m: np.array(t) for m, t in faces.items()}


def png_indices(path):
    data = path.read_bytes()
    width, height = struct.unpack(">II", data[16:24])
    at, packed = 8, b""
    while at < len(data):
        (size,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            packed += data[at + 8 : at + 8 + size]
        at += 12 + size
    return np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, width + 1)[:, 1:]


def areas(v, t):
    return 0.5 * np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1)


def digest(folder):
    h = hashlib.sha256()
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        h.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return h.hexdigest()


class Park:
    """A generated park as its files describe it."""

    def __init__(self, folder):
        self.folder = folder
        self.scene = {}
        for name in ("park_scene.toml", "park.toml"):
            self.scene |= tomllib.loads((folder / name).read_text())
        self.materials = {m["name"]: m for m in tomllib.loads((folder / "materials.toml").read_text())["material"]}
        self.planes = {p["name"]: p for p in self.scene["plane"]}
        self.board = self.planes["blue checkerboard 24 x 24 ft"]
        side = int((folder / "dem.hdr").read_text().split("samples = ")[1].split()[0])
        self.heights = np.fromfile(folder / "dem.img", "<f4").reshape(-1, side)
        self.classes = png_indices(folder / "classes.png")
        self.material_of_class = {int(k): v for k, v in self.scene["terrain"][0]["materials"].items()}
        self.bands = table(folder / "spectir_360.csv")[1]

    def class_at(self, x_m, y_m):
        """Class under places of the map, metres east and north of its centre."""
        return self.classes[((200 - y_m) * 2).astype(int), ((x_m + 200) * 2).astype(int)]


def generated(scenes, work):
    """The park of the first of two runs, or None when the generator fails."""
    digests = []
    for run in ("a", "b") if "--full" in sys.argv else ("a",):
        done = patience.run(
            [sys.executable, str(scenes / "park" / "generate.py"), str(work / run)], capture_output=True, text=True
        )
        check(
            f"generator ends with 0 (run {run})",
            done.returncode == 0,
            done.stderr.strip() or done.stdout.splitlines()[0],
        )
        if done.returncode:
            return None
        digests.append(digest(work / run))
    if len(digests) > 1:
        check("same seed, same files", digests[0] == digests[1], digests[0][:16])
    return Park(work / "a")


def check_placements(park):
    """S1, S3: trees and their places. Returns vertices, triangles per material and places of each kind of tree."""
    trees, instances = {}, 0
    meshes = {m["name"]: m for m in park.scene["mesh"]}
    for scatter in park.scene["scatter"]:
        header, rows = table(park.folder / scatter["positions"])
        check(f"{scatter['positions']} columns", header == ["x_m", "y_m", "yaw_deg", "scale"], ",".join(header))
        vertices, faces = obj(park.folder / meshes[scatter["mesh"]]["file"])
        smallest = min(areas(vertices, t).min() for t in faces.values())
        check(f"{scatter['mesh']}: no zero-area face", smallest > 1e-7, f"smallest {smallest:.2e} m2")
        if "leaf" in faces:
            trees[scatter["mesh"]] = (vertices, faces, rows)
            if len(faces["leaf"]) >= 20000:
                instances += len(rows)
    big = big_trees(trees)
    check(
        "at least 3 trees of at least 20 000 leaf triangles", len(big) >= 3, {n: len(trees[n][1]["leaf"]) for n in big}
    )
    check("at least 300 instances of them", instances >= 300, instances)
    return trees


def big_trees(trees):
    return [n for n, (_, f, _) in trees.items() if len(f["leaf"]) >= 20000]


def check_crowns(trees):
    for name in big_trees(trees):
        v, f, _ = trees[name]
        leaf = f["leaf"]
        edge = np.linalg.norm(v[leaf[:, 1]] - v[leaf[:, 0]], axis=1)
        radius = np.percentile(np.hypot(*v[np.unique(leaf)][:, :2].T), 98)
        lai = areas(v, leaf).sum() / (math.pi * radius**2)
        check(f"{name}: leaf area index of the crown 1.5..8", 1.5 < lai < 8, round(lai, 2))
        check(f"{name}: median leaf edge 3..15 cm", 0.03 < np.median(edge) < 0.15, round(float(np.median(edge)), 3))


def check_crowded_pixels(trees):
    """Pixels of the 1 m instrument that hold many triangles: leaf centroids per square metre are a lower bound."""
    count = np.zeros((320, 320), int)
    for name in big_trees(trees):
        v, f, rows = trees[name]
        centre = v[f["leaf"]].mean(1)[:, :2]
        for x, y, yaw, scale in rows:
            a = math.radians(yaw)
            gx = x + scale * (math.cos(a) * centre[:, 0] + math.sin(a) * centre[:, 1])
            gy = y + scale * (-math.sin(a) * centre[:, 0] + math.cos(a) * centre[:, 1])
            i, j = np.floor(gx + 160).astype(int), np.floor(160 - gy).astype(int)
            inside = (i >= 0) & (i < 320) & (j >= 0) & (j < 320)
            count += np.bincount(j[inside] * 320 + i[inside], minlength=320 * 320).reshape(320, 320)
    check("at least 2000 pixels with 200 or more triangles", (count >= 200).sum() >= 2000, int((count >= 200).sum()))


def check_terrain(park):
    """S2: relief and classes."""
    heights, classes, named = park.heights, park.classes, park.material_of_class
    check(
        "relief in metres",
        3 < np.ptp(heights) < 40 and np.isfinite(heights).all(),
        f"{heights.min():.1f}..{heights.max():.1f}",
    )
    cover = np.fromfile(park.folder / "cover.img", "<f4").reshape(classes.shape + (-1,))
    check(
        "cover fractions sum to 1, at most 4 in a cell",
        (cover.sum(2) == 1).all() and (cover >= 0).all() and ((cover > 0).sum(2) <= 4).all(),
        (float(cover.sum(2).min()), float(cover.sum(2).max()), int((cover > 0).sum(2).max())),
    )
    check("classes.png is the largest fraction", (cover.argmax(2) + 1 == classes).all(), classes.shape)
    check("every band of the cover has a material", sorted(named) == list(range(1, cover.shape[2] + 1)), sorted(named))
    share = {n: float(cover[..., c - 1].mean()) for c, n in named.items()}
    needed = ("lawn_grass", "gravel", "track_soil", "asphalt", "leaf_litter")
    check(
        "grass, gravel, soil, asphalt, litter all present",
        all(share[n] > 0.002 for n in needed),
        {n: round(share[n], 4) for n in needed},
    )


def check_grounds(park, trees):
    """Nothing is planted on courts or track, and the targets stand level."""
    planted = 0
    for _, _, rows in trees.values():
        # What stands on the map's edge stands on its outermost cell.
        x_m, y_m = np.clip(rows[:, 0], -200, 199.75), np.clip(rows[:, 1], -199.75, 200)
        under = [park.material_of_class[int(c)] for c in park.class_at(x_m, y_m)]
        planted += int(np.isin(under, ["asphalt", "track_soil", "gravel", "concrete"]).sum())
    check("no tree on court, track, road or apron", planted == 0, planted)
    court = park.heights[2 * (200 - 91) : 2 * (200 - 61), 2 * (200 + 106) : 2 * (200 + 130)]  # x 106..130, y 61..91 m
    check("the targets' court is level", np.ptp(court) == 0, float(np.ptp(court)))


def check_targets(park):
    """Panels, checkerboard and yellow pattern (S52)."""
    planes, board = park.planes, park.board
    panel = {c: park.materials[planes[f"{c} panel"]["material"]]["reflectance"] for c in ("black", "white")}
    check("panels 0.10 and 0.80", panel == {"black": 0.10, "white": 0.80}, panel)
    slant = [planes[f"{c} panel"]["yaw_deg"] % 90 for c in ("black", "white")]
    check("slanted edges of 5 to 8 degrees", all(5 <= s <= 8 for s in slant), slant)
    check(
        "checkerboard of two fabrics with 1 ft cells, 24 x 24 ft",
        board["checker"]["cell_m"] == 0.3048
        and np.allclose(board["size_m"], 24 * 0.3048)
        and len(set(board["checker"]["materials"])) == 2,
        board["checker"],
    )
    v, f = obj(park.folder / "yellow_target.obj")
    cotton = areas(v, f["yellow_cotton"]).sum() / sum(areas(v, t).sum() for t in f.values())
    check("yellow target is 25 % cotton", abs(cotton - 0.25) < 1e-3, round(float(cotton), 6))


def check_blocks(park):
    """S54: green blocks."""
    _, blocks = table(park.folder / "green_targets.csv")
    v, _ = obj(park.folder / "wood_block.obj")
    check(
        "24 green blocks of 12 x 20 inch",
        len(blocks) == 24 and np.allclose(np.ptp(v, axis=0)[:2], (0.3048, 0.508), atol=1e-3),
        len(blocks),
    )
    c = park.class_at(blocks[:, 0], blocks[:, 1])
    check("blocks lie on grass", np.isin(c, (1, 2, 3)).all(), sorted(map(int, np.unique(c))))


def check_bands(park):
    """S42: the published bands, and the instrument that has them."""
    bands = park.bands
    n = np.arange(1, 361)
    law = np.where(n <= 125, 394.8 + 4.6 * n, 394.8 + 4.6 * 125 + 6.3 * (n - 125))
    check(
        "360 bands after S42, ascending, ending at 2450 within a step",
        len(bands) == 360 and np.allclose(bands[:, 0], law, atol=1e-3) and abs(bands[-1, 0] - 2450) < 6.3,
        (len(bands), bands[0, 0], bands[-1, 0]),
    )
    published = {19: 482, 25: 509, 26: 514, 35: 555, 55: 648}
    check(
        "published band centres to 1 nm",
        all(abs(bands[b - 1, 0] - w) < 1 for b, w in published.items()),
        {b: bands[b - 1, 0] for b in published},
    )
    spectir = next(i for i in park.scene["instrument"] if i["name"] == "spectir")
    check(
        "spectir: 1 m, 610 m, 320 x 320, samples by the tolerance of 3 %",
        (spectir["gsd_m"], spectir["altitude_agl_m"], spectir["pixels"], spectir["lines"], park.scene["tolerance"])
        == (1.0, 610.0, 320, 320, 0.03)
        and "samples" not in spectir,
        spectir["kind"],
    )


def materials_in_use(park):
    scene = park.scene
    used = set(park.material_of_class.values()) | {
        m
        for x in scene["mesh"]
        for m in list(x.get("materials", {}).values()) + ([x["material"]] if "material" in x else [])
    }
    used |= {p["material"] for p in scene["plane"] + scene["box"] if "material" in p} | set(
        park.board["checker"]["materials"]
    )
    return used


def check_spectra(park):
    """Range, values, source, reach of the instrument's bands (three widths beyond the outermost centres)."""
    materials, used, bands = park.materials, materials_in_use(park), park.bands
    low, high = bands[0, 0] - 3 * bands[0, 1], bands[-1, 0] + 3 * bands[-1, 1]
    check("every material used is defined", used <= set(materials), sorted(used - set(materials)))
    for name, material in materials.items():
        if "file" not in material:
            continue
        path = park.folder / material["file"]
        head = [line for line in path.read_text().splitlines() if line.startswith("#")]
        _, rows = table(path)
        ok = np.all(np.diff(rows[:, 0]) > 0) and rows[:, 1].min() >= 0 and rows[:, 1].max() <= 1
        ok &= rows[0, 0] <= low and rows[-1, 0] >= high and np.diff(rows[rows[:, 0] <= 2500, 0]).max() <= 20
        ok &= any(line.startswith("# source: ") for line in head) and any("ends at" in line for line in head)
        if not ok:
            check(f"spectrum {name}", False, (rows[0, 0], rows[-1, 0], rows[:, 1].min(), rows[:, 1].max()))
    check(
        "spectra within [0, 1], ascending, sourced, covering all bands",
        not any(f.startswith("spectrum") for f in failures),
        len(materials),
    )


def main():
    park = generated(Path(sys.argv[1]), Path(sys.argv[2]))
    if park is None:
        return 1
    trees = check_placements(park)
    check_crowns(trees)
    check_crowded_pixels(trees)
    check_terrain(park)
    check_grounds(park, trees)
    check_targets(park)
    check_blocks(park)
    check_bands(park)
    check_spectra(park)
    print(f"park_generator_test: {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
