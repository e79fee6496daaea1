#!/usr/bin/python3
"""Canopies in the manner of the RAMI exercises: scenes/rami/generate.py OUT [--lai L] [--angles uniform|planophile|
erectophile] [--radius M] [--height M] [--cell M] [--spheres] [--seed N] [--sun-zenith DEG]

Without --spheres a layer of leaves of one size: LAI square metres of them a square metre of ground, their middles
evenly spread between the ground and the canopy's height, in a cell that repeats. With --spheres fifteen crowns of
radius 10 m about 15 m up in a cell of 100 m, 50 000 leaves of radius 0.1 m in each. Leaves are regular hexagons of a
disc's area (their radius is the disc's), their normals drawn from de Wit's distributions over the upper hemisphere:
uniform g = sin, planophile g = 2/pi (1 + cos 2 theta), erectophile g = 2/pi (1 - cos 2 theta). The sun stands in the
south. Writes canopy.toml, leaves.ply and, of the crowns, crowns.csv; the same arguments make the same files."""

import argparse
import pathlib

import numpy as np

CROWNS, CROWN_RADIUS_M, CROWN_LEAVES, CROWN_CELL_M, CROWN_HEIGHT_M = 15, 10.0, 50000, 100.0, 15.0


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
    along = np.cross(facing, np.where(np.abs(facing[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]]))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(facing, along)
    side = radius * np.sqrt(np.pi / (1.5 * np.sqrt(3)))
    turn = rng.uniform(0, 2 * np.pi, (len(centers), 1)) + np.arange(6) * np.pi / 3
    return centers[:, None] + side * (
        np.cos(turn)[..., None] * along[:, None] + np.sin(turn)[..., None] * across[:, None]
    )


def write_ply(path, corners):
    count = len(corners)
    first = 6 * np.arange(count)[:, None, None]
    triangles = (first + np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])).reshape(-1, 3)
    faces = np.zeros(len(triangles), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, triangles
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {6 * count}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + corners.astype("<f4").tobytes() + faces.tobytes())


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


def scene(options, cell, copies, top_m):
    bands = "{ first_nm = 650.0, step_nm = 200.0, count = 2, fwhm_nm = 10.0 }"  # red and near infrared
    measure = f"size_m = [{cell}, {cell}]\nheight_m = {top_m}\n"
    place = f'[[scatter]]\nmesh = "leaves"\npositions = "crowns.csv"\n' if options.spheres else (
        '[[instance]]\nmesh = "leaves"\n'
    )
    return f"""# Made by scenes/rami/generate.py: red (650 nm) and near infrared (850 nm).
format = 1
bounces = 64
atmosphere = {{ model = "none" }}
time = {{ sun = {{ zenith_deg = {options.sun_zenith}, azimuth_deg = 180.0 }} }}
[scene]
periodic = {{ x_m = {cell}, y_m = {cell}, copies = {copies} }}
[[material]]
name = "leaf"
file = "leaf.csv"
[[material]]
name = "soil"
file = "soil.csv"
[[plane]]
name = "soil"
material = "soil"
size_m = [{cell}, {cell}]
[[mesh]]
name = "leaves"
file = "leaves.ply"
material = "leaf"
{place}[[instrument]]
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
{measure}"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--lai", type=float, default=3.0, help="leaf area over ground area")
    parser.add_argument("--angles", choices=("uniform", "planophile", "erectophile"), default="uniform")
    parser.add_argument("--radius", type=float, default=0.05, help="of a leaf, m")
    parser.add_argument("--height", type=float, default=2.0, help="of the layer, m")
    parser.add_argument("--cell", type=float, default=10.0, help="side of the cell that repeats, m")
    parser.add_argument("--spheres", action="store_true", help="crowns in place of a layer")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sun-zenith", type=float, default=20.0, help="deg")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(options.seed)
    if options.spheres:
        places = crown_places(rng)
        rows = np.column_stack([places, np.full(CROWNS, CROWN_HEIGHT_M), rng.uniform(0, 360, CROWNS)])
        np.savetxt(options.out / "crowns.csv", rows, "%.4f", ",", header="x_m,y_m,z_m,yaw_deg", comments="")
        corners, cell, top_m = crown(rng, options), CROWN_CELL_M, CROWN_HEIGHT_M + CROWN_RADIUS_M
    else:
        corners, cell, top_m = layer(rng, options), options.cell, options.height
    # Light that goes level leaves 7 of 1000 of a layer of LAI 1 at 7 heights, less than 1 at 24.
    copies = int(np.ceil(24 * top_m / cell))
    write_ply(options.out / "leaves.ply", corners)
    curve = "wavelength_nm,reflectance,transmittance\n600,0.0546,0.0149\n700,0.0546,0.0149\n800,0.4957,0.4409\n"
    (options.out / "leaf.csv").write_text(curve + "900,0.4957,0.4409\n")
    soil = "wavelength_nm,reflectance\n600,0.127\n700,0.127\n800,0.159\n900,0.159\n"
    (options.out / "soil.csv").write_text(soil)
    (options.out / "canopy.toml").write_text(scene(options, cell, copies, top_m))
    print(f"canopy: {len(corners)} leaves, {options.out / 'canopy.toml'}")


if __name__ == "__main__":
    main()
