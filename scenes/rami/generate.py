#!/usr/bin/python3
"""Canopies in the manner of the RAMI exercises: scenes/rami/generate.py OUT [--lai L] [--angles uniform|planophile|
erectophile] [--radius M] [--height M] [--cell M] [--spheres | --stand birch|conifer] [--seed N] [--sun-zenith DEG]

By itself a layer of leaves of one size: LAI square metres of them a square metre of ground, their middles
evenly spread between the ground and the canopy's height, in a cell that repeats. With --spheres fifteen crowns of
radius 10 m about 15 m up in a cell of 100 m, 50 000 leaves of radius 0.1 m in each. With --stand 10 000 trees of five
shapes (trees.py), turned and scaled by 0.8 to 1.15, none nearer than 1.6 m to another, in a cell of 316 m (1000 a
hectare), over a mossy ground. Leaves are regular hexagons of a
disc's area (their radius is the disc's), their normals drawn from de Wit's distributions over the upper hemisphere:
uniform g = sin, planophile g = 2/pi (1 + cos 2 theta), erectophile g = 2/pi (1 - cos 2 theta). The sun stands in the
south. Writes canopy.toml, curves, meshes and places; the same arguments make the same files."""

import argparse
import pathlib

import numpy as np
import trees

CROWNS, CROWN_RADIUS_M, CROWN_LEAVES, CROWN_CELL_M, CROWN_HEIGHT_M = 15, 10.0, 50000, 100.0, 15.0
TREES, TREE_SHAPES, STAND_CELL_M, TREES_APART_M = 10000, 5, 316.0, 1.6


def zenith_angles(rng, kind, count):
    """Angles of the leaves' normals from the zenith, rad, by inverting their cumulative distribution."""
    theta = np.linspace(0, np.pi / 2, 4001)
    below = {
        "uniform": 1 - np.cos(theta),
        "planophile": (2 * theta + np.sin(2 * theta)) / np.pi,
        "erectophile": (2 * theta - np.sin(2 * theta)) / np.pi,
    }[kind]
    return np.interp(rng.random(count), below, theta)


def normals(rng, kind, count):
    theta, azimuth = zenith_angles(rng, kind, count), rng.uniform(0, 2 * np.pi, count)
    flat = np.sin(theta)
    return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.cos(theta)])


def hexagons(rng, centers, facing, radius):
    """Corners [leaf][6][3] of hexagons with a disc's area, each turned about its normal by chance."""
    along, across = trees.frame(facing)
    side = radius * np.sqrt(np.pi / (1.5 * np.sqrt(3)))
    turn = rng.uniform(0, 2 * np.pi, (len(centers), 1)) + np.arange(6) * np.pi / 3
    return centers[:, None] + side * (
        np.cos(turn)[..., None] * along[:, None] + np.sin(turn)[..., None] * across[:, None]
    )


def write_ply(path, triangles):
    """Triangles [n][3][3] that share no corners."""
    count = len(triangles)
    faces = np.zeros(count, [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, np.arange(3 * count).reshape(-1, 3)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {3 * count}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {count}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + triangles.astype("<f4").tobytes() + faces.tobytes())


def layer(rng, options):
    """Leaves of a layer."""
    count = round(options.lai * options.cell**2 / (np.pi * options.radius**2))
    span = np.array([options.cell, options.cell, options.height - 2 * options.radius])
    low = np.array([-0.5 * options.cell, -0.5 * options.cell, options.radius])
    return hexagons(rng, low + span * rng.random((count, 3)), normals(rng, options.angles, count), options.radius)


def crown(rng, options):
    """Leaves of one crown about its middle."""
    places = rng.uniform(-1, 1, (3 * CROWN_LEAVES, 3))
    places = places[(places**2).sum(1) < 1][:CROWN_LEAVES] * (CROWN_RADIUS_M - 0.1)
    return hexagons(rng, places, normals(rng, options.angles, len(places)), 0.1)


def crown_places(rng):
    """Middles on the cell, none within a crown of another, over its edges too."""
    places = []
    while len(places) < CROWNS:
        place = rng.uniform(-0.5, 0.5, 2) * CROWN_CELL_M
        apart = [np.abs(place - other) for other in places]
        if all(np.hypot(*np.minimum(d, CROWN_CELL_M - d)) > 2 * CROWN_RADIUS_M for d in apart):
            places.append(place)
    return np.array(places)


def tree_places(rng):
    """Feet of trees on the cell, evenly by chance but none too near to another, over its edges too."""
    across = int(STAND_CELL_M / TREES_APART_M)
    side, taken, places = STAND_CELL_M / across, {}, []
    while len(places) < TREES:
        place = rng.uniform(0, STAND_CELL_M, 2)
        i, j = (place / side).astype(int)
        near = (taken.get(((i + di) % across, (j + dj) % across)) for di in range(-2, 3) for dj in range(-2, 3))
        apart = (np.abs(place - other) for other in near if other is not None)
        if all(np.hypot(*np.minimum(d, STAND_CELL_M - d)) > TREES_APART_M for d in apart):
            taken[i, j] = place
            places.append(place - STAND_CELL_M / 2)
    return np.array(places)


def material(name):
    return f'[[material]]\nname = "{name}"\nfile = "{name}.csv"\n'


def mesh(name, of):
    return f'[[mesh]]\nname = "{name}"\nfile = "{name}.ply"\nmaterial = "{of}"\n'


def scatter(name, places):
    return f'[[scatter]]\nmesh = "{name}"\npositions = "{places}"\n'


def curve(path, columns, *rows):
    """Two flat ends, red up to 700 nm and near infrared from 800 nm on."""
    red, infrared = (",".join(map(str, row)) for row in rows)
    path.write_text(f"wavelength_nm,{columns}\n400,{red}\n700,{red}\n800,{infrared}\n900,{infrared}\n")


def leaves_alone(rng, options):
    """A layer or crowns: what is placed, side of the cell, top."""
    curve(options.out / "leaf.csv", "reflectance,transmittance", (0.0546, 0.0149), (0.4957, 0.4409))
    curve(options.out / "soil.csv", "reflectance", (0.127,), (0.159,))
    head = material("leaf") + material("soil")
    if options.spheres:
        places = crown_places(rng)
        rows = np.column_stack([places, np.full(CROWNS, CROWN_HEIGHT_M), rng.uniform(0, 360, CROWNS)])
        np.savetxt(options.out / "crowns.csv", rows, "%.4f", ",", header="x_m,y_m,z_m,yaw_deg", comments="")
        corners, cell, top_m = crown(rng, options), CROWN_CELL_M, CROWN_HEIGHT_M + CROWN_RADIUS_M
    else:
        corners, cell, top_m = layer(rng, options), options.cell, options.height
    write_ply(options.out / "leaves.ply", trees.fans(corners))
    placed = scatter("leaves", "crowns.csv") if options.spheres else '[[instance]]\nmesh = "leaves"\n'
    print(f"canopy: {len(corners)} leaves, {options.out / 'canopy.toml'}")
    return head + mesh("leaves", "leaf") + placed, cell, top_m


def stand(rng, options):
    """Trees: what is placed, side of the cell, top."""
    if options.stand == "birch":
        curve(options.out / "leaf.csv", "reflectance,transmittance", (0.051, 0.03), (0.45, 0.45))
        curve(options.out / "bark.csv", "reflectance", (0.3,), (0.45,))
    else:
        curve(options.out / "leaf.csv", "reflectance,transmittance", (0.06, 0.02), (0.43, 0.35))
        curve(options.out / "bark.csv", "reflectance", (0.12,), (0.3,))
    curve(options.out / "soil.csv", "reflectance", (0.06,), (0.28,))
    places, shape = tree_places(rng), rng.integers(0, TREE_SHAPES, TREES)
    rows = np.column_stack([places, rng.uniform(0, 360, TREES), rng.uniform(0.8, 1.15, TREES)])
    text, top_m, foliage_m2 = material("leaf") + material("bark") + material("soil"), 0.0, 0.0
    for k in range(TREE_SHAPES):
        wood, leaves = (
            trees.birch(rng, hexagons, normals, options.angles) if options.stand == "birch" else trees.conifer(rng)
        )
        of = rows[shape == k]
        np.savetxt(options.out / f"trees{k}.csv", of, "%.4f", ",", header="x_m,y_m,yaw_deg,scale", comments="")
        for name, triangles, matter in ((f"wood{k}", wood, "bark"), (f"leaves{k}", leaves, "leaf")):
            write_ply(options.out / f"{name}.ply", triangles)
            text += mesh(name, matter) + scatter(name, f"trees{k}.csv")
            top_m = max(top_m, triangles[..., 2].max() * of[:, 3].max())
        corners = leaves[:, 1:] - leaves[:, :1]
        area_m2 = 0.5 * np.linalg.norm(np.cross(corners[:, 0], corners[:, 1]), axis=1).sum()
        foliage_m2 += area_m2 * (of[:, 3] ** 2).sum()
    lai = foliage_m2 / STAND_CELL_M**2
    print(f"stand: {TREES} trees, leaf area {lai:.2f}, {top_m:.1f} m high, {options.out / 'canopy.toml'}")
    return text, STAND_CELL_M, float(np.ceil(top_m))


def scene(options, things, cell, copies, top_m):
    bands = "{ first_nm = 650.0, step_nm = 200.0, count = 2, fwhm_nm = 10.0 }"  # red and near infrared
    measure = f"size_m = [{cell}, {cell}]\nheight_m = {top_m}\n"
    return f"""# Made by scenes/rami/generate.py: red (650 nm) and near infrared (850 nm).
format = 1
bounces = 64
atmosphere = {{ model = "none" }}
time = {{ sun = {{ zenith_deg = {options.sun_zenith}, azimuth_deg = 180.0 }} }}
[scene]
periodic = {{ x_m = {cell}, y_m = {cell}, copies = {copies} }}
[[plane]]
name = "soil"
material = "soil"
size_m = [{cell}, {cell}]
{things}[[instrument]]
name = "camera"
kind = "framing"
altitude_agl_m = {100.0 * top_m}
gsd_m = {cell / 128}
pixels = 256
lines = 256
bands = {bands}
[[measure]]
name = "principal"
{measure}[[measure]]
name = "orthogonal"
views = "orthogonal"
{measure}[[measure]]
name = "albedo"
views = "hemisphere"
{measure}[[budget]]
name = "light"
ground = ["soil"]
levels_m = [{", ".join(f"{top_m * k / 10:g}" for k in range(1, 10))}]
[[budget]]
name = "even"
light = "isotropic"
ground = ["soil"]
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--lai", type=float, default=3.0, help="leaf area over ground area")
    parser.add_argument("--angles", choices=("uniform", "planophile", "erectophile"), default="uniform")
    parser.add_argument("--radius", type=float, default=0.05, help="of a leaf, m")
    parser.add_argument("--height", type=float, default=2.0, help="of the layer, m")
    parser.add_argument("--cell", type=float, default=10.0, help="side of the cell that repeats, m")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--spheres", action="store_true", help="crowns in place of a layer")
    kind.add_argument("--stand", choices=("birch", "conifer"), help="trees in place of a layer")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sun-zenith", type=float, default=20.0, help="deg")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(options.seed)
    things, cell, top_m = stand(rng, options) if options.stand else leaves_alone(rng, options)
    # Light that goes level leaves 7 of 1000 of a layer of LAI 1 at 7 heights, less than 1 at 24.
    copies = int(np.ceil(24 * top_m / cell))
    (options.out / "canopy.toml").write_text(scene(options, things, cell, copies, top_m))


if __name__ == "__main__":
    main()
