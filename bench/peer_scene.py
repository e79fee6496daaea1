"""One scene for raycube and another renderer, down to the same vertices, spectra and light; no air.

A square of relief with patches of eight measured soils and plants (one PLY each), trees of the park's generator placed
by turn, scale and move, a sun, a sky of one radiance in all directions, a pinhole camera 610 m above. Lengths in
metres: x east, y north, z up.
"""

import dataclasses
import hashlib
import json
import pathlib
import struct
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
SPECTRA = ROOT / "scenes/park/spectra"
sys.path.insert(0, str(ROOT / "scenes/park"))
from generator import trees as park_trees  # noqa: E402

GROUND = ("lawn_grass", "half_dry_grass", "dry_grass", "track_soil", "gravel", "asphalt", "leaf_litter", "loam")
LEAVES = {"maple": "maple_leaf", "aspen": "aspen_leaf", "spruce": "spruce_needles", "shrub": "walnut_leaf"}
SUN_ZENITH_DEG, SUN_AZIMUTH_DEG = 40.0, 150.0  # azimuth clockwise from north
CAMERA_HEIGHT_M, GSD_M = 610.0, 1.0
SEED = 7


@dataclasses.dataclass
class Mesh:
    name: str
    material: str
    file: pathlib.Path
    triangles: int


@dataclasses.dataclass
class Scene:
    folder: pathlib.Path
    pixels: int  # of a side
    ground: list  # meshes in scene coordinates
    trees: dict  # species: meshes, foot at the origin
    places: dict  # species: rows x_m, y_m, z_m, yaw_deg (clockwise), scale
    bands_nm: np.ndarray  # rows centre, full width at half maximum (Gaussian)

    def materials(self):
        return sorted({m.material for m in self.ground} | {m.material for group in self.trees.values() for m in group})

    def facts(self):
        unique = sum(m.triangles for m in self.ground) + sum(m.triangles for g in self.trees.values() for m in g)
        placed = sum(len(self.places[s]) * sum(m.triangles for m in g) for s, g in self.trees.items())
        return {
            "pixels": self.pixels,
            "bands": len(self.bands_nm),
            "trees": sum(map(len, self.places.values())),
            "triangles": unique,
            "triangles_placed": placed + sum(m.triangles for m in self.ground),
            "materials": len(self.materials()),
        }


def sun_irradiance(wavelength_nm):
    """W m-2 um-1 normal to the beam: a black body of 5772 K seen from 1 au, dimmed as by a clear sky. Smooth, the same
    for both sides."""
    um = np.asarray(wavelength_nm, float) / 1000
    planck = 1.191042972e8 / um**5 / np.expm1(14387.769 / (um * 5772.0))  # W m-2 sr-1 um-1
    return planck * 6.794e-5 * np.exp(-(0.0089 * um**-4 + 0.08 * um**-1.3) / np.cos(np.radians(SUN_ZENITH_DEG)))


def sky_radiance(wavelength_nm):
    """W m-2 sr-1 um-1, the same in all directions: blue, some 14 % of the sun's irradiance at 0.45 um, 3 % at 1 um."""
    um = np.asarray(wavelength_nm, float) / 1000
    return sun_irradiance(wavelength_nm) / np.pi * (0.0045 * um**-4 + 0.025 * um**-1)


def spectrum(material):
    """Columns wavelength_nm, reflectance of the file both sides read; linear between its points."""
    rows = [
        line.split(",")
        for line in (SPECTRA / f"{material}.csv").read_text().splitlines()
        if line and line[0] in "0123456789"
    ]
    return np.array([[float(v) for v in row[:2]] for row in rows])


def band_nodes(centre_nm, fwhm_nm, count=65):
    """Nodes over +-3 standard deviations of a Gaussian band and weights that sum to 1."""
    sigma = fwhm_nm / 2.354820045
    x = np.linspace(-3, 3, count)
    weight = np.exp(-0.5 * x * x)
    return centre_nm + sigma * x, weight / weight.sum()


def band_means(scene):
    """Per band: irradiance of the sun, radiance of the sky, and each material's reflectance as that light weighs it."""
    light = np.pi * np.array([sky_radiance(n) for n, _ in map(lambda b: band_nodes(*b), scene.bands_nm)])
    sun, sky, reflectance = [], [], {m: [] for m in scene.materials()}
    curves = {m: spectrum(m) for m in reflectance}
    for index, band in enumerate(scene.bands_nm):
        nodes, weight = band_nodes(*band)
        sun.append(weight @ sun_irradiance(nodes))
        sky.append(weight @ sky_radiance(nodes))
        by_light = weight * (sun_irradiance(nodes) + light[index])
        for material, curve in curves.items():
            reflectance[material].append(by_light @ np.interp(nodes, *curve.T) / by_light.sum())
    return np.array(sun), np.array(sky), {m: np.array(v) for m, v in reflectance.items()}


def height(x, y):
    return (
        2.5 * np.sin(x / 23) * np.cos(y / 31)
        + 1.2 * np.sin((x + 2 * y) / 17)
        + 0.08 * np.sin(1.9 * x) * np.cos(1.7 * y)
    )


def write_ply(path, vertices, triangles):
    used, index = np.unique(triangles, return_inverse=True)
    vertices, triangles = np.asarray(vertices)[used].astype("<f4"), index.reshape(-1, 3).astype("<i4")
    faces = np.empty(len(triangles), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, triangles
    with open(path, "wb") as file:
        file.write(
            (
                f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\n"
                f"property float y\n"
                f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
            ).encode()
        )
        file.write(vertices.tobytes())
        file.write(faces.tobytes())
    return len(triangles)


def patches(rng, x, y):
    """A material number per cell: the strongest of eight smooth random fields, patches of some 15 m."""
    fields = []
    for _ in GROUND:
        k, phase = rng.normal(0, 0.16, (24, 2)), rng.uniform(0, 2 * np.pi, 24)
        fields.append(np.cos(k[:, :1, None] * x[None] + k[:, 1:, None] * y[None] + phase[:, None, None]).sum(0))
    return np.argmax(fields, axis=0)


def make_ground(folder, half_m, post_m=0.5):
    x = np.arange(-half_m, half_m + post_m / 2, post_m)
    gx, gy = np.meshgrid(x, x)
    vertices = np.stack([gx, gy, height(gx, gy)], -1).reshape(-1, 3)
    n = len(x)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    cells = np.stack([[corner, corner + 1, corner + n + 1], [corner, corner + n + 1, corner + n]]).transpose(2, 0, 1)
    centre = x[:-1] + post_m / 2
    kind = patches(np.random.default_rng([SEED, 1]), *np.meshgrid(centre, centre)).ravel()
    meshes = []
    for index, material in enumerate(GROUND):
        file = folder / f"ground_{material}.ply"
        meshes.append(
            Mesh(f"ground_{material}", material, file, write_ply(file, vertices, cells[kind == index].reshape(-1, 3)))
        )
    return meshes


def make_trees(folder):
    meshes = {}
    for species, make in park_trees.SPECIES.items():
        groups, _ = make(2012)
        meshes[species] = []
        for part, vertices, triangles in groups:
            file = folder / f"{species}_{part}.ply"
            material = LEAVES[species] if part == "leaf" else "bark"
            meshes[species].append(Mesh(f"{species}_{part}", material, file, write_ply(file, vertices, triangles)))
    return meshes


def plant(half_m, trees):
    """Clumps and lone trees; what both sides read is rounded first."""
    rng = np.random.default_rng([SEED, 2])
    places = {species: [] for species in LEAVES}
    species = list(LEAVES)
    clumps = rng.uniform(-half_m, half_m, (6, 2))
    for i in range(trees):
        x, y = (clumps[i % 6] + rng.normal(0, 9, 2)) if i % 5 else rng.uniform(-half_m, half_m, 2)
        x, y = np.round(np.clip([x, y], -half_m, half_m), 3)
        places[species[i % 4]].append(
            (x, y, round(float(height(x, y)), 3), round(rng.uniform(0, 360), 2), round(rng.uniform(0.8, 1.2), 3))
        )
    return places


def read_ply(path):
    """Vertices and triangles of a file of write_ply."""
    data = path.read_bytes()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    vertices, faces = (int(line.split()[2]) for line in data[:start].splitlines() if line.startswith(b"element"))
    return (
        np.frombuffer(data, "<f4", 3 * vertices, start).reshape(-1, 3),
        np.frombuffer(data, [("n", "u1"), ("v", "<i4", 3)], faces, start + 12 * vertices)["v"],
    )


def merged_trees(scene):
    """All placed trees in scene coordinates, one mesh for each mesh of a tree; written once."""
    merged = []
    for species, meshes in scene.trees.items():
        for mesh in meshes:
            file = scene.folder / f"placed_{mesh.name}.ply"
            merged.append(Mesh(f"placed_{mesh.name}", mesh.material, file, mesh.triangles * len(scene.places[species])))
            if file.exists():
                continue
            vertices, triangles = read_ply(mesh.file)
            turned = []
            for x, y, z, yaw_deg, scale in scene.places[species]:
                c, s = np.cos(np.radians(yaw_deg)), np.sin(np.radians(yaw_deg))
                turned.append(scale * vertices.astype(float) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) + (x, y, z))
            offsets = len(vertices) * np.arange(len(turned))
            write_ply(file, np.concatenate(turned), (triangles[None] + offsets[:, None, None]).reshape(-1, 3))
    return merged


def write_table(path, wavelength_nm, sensor_height_m=CAMERA_HEIGHT_M):
    """Render table (docs/table_format.md) of a sun and an even sky without air."""
    nodes = {
        "wavelength": ("um", list(np.asarray(wavelength_nm) / 1000)),
        "target_height": ("m", [0.0]),
        "view_zenith": ("deg", [0.0]),
        "relative_azimuth": ("deg", [0.0]),
        "sky_zenith": ("deg", [0.0]),
        "sky_azimuth": ("deg", [0.0]),
    }
    sun, sky = sun_irradiance(wavelength_nm), sky_radiance(wavelength_nm)
    one, radiance, irradiance = np.ones_like(sun), "W m-2 sr-1 um-1", "W m-2 um-1"
    rows = {
        "solar_irradiance": (irradiance, ["wavelength"], sun),
        "sun_transmission": ("1", ["wavelength", "target_height"], one),
        "view_transmission": ("1", ["wavelength", "target_height", "view_zenith"], one),
        "two_way_factor": ("1", ["wavelength", "target_height", "view_zenith"], one),
        "path_radiance_solar": (radiance, ["wavelength", "target_height", "view_zenith", "relative_azimuth"], 0 * one),
        "sky_radiance_solar": (radiance, ["wavelength", "target_height", "sky_zenith", "sky_azimuth"], sky),
        "direct_irradiance": (irradiance, ["wavelength", "target_height"], sun * np.cos(np.radians(SUN_ZENITH_DEG))),
        "diffuse_irradiance": (irradiance, ["wavelength", "target_height"], np.pi * sky),
    }
    offset, listed, arrays = 0, [], b""
    for name, (unit, axes, values) in rows.items():
        data = np.asarray(values, "<f4").tobytes()
        listed.append(
            {
                "name": name,
                "unit": unit,
                "text": "an even sky without air",
                "axes": axes,
                "shape": [len(nodes[a][1]) for a in axes],
                "offset": offset,
            }
        )
        arrays += data + bytes(-len(data) % 64)
        offset = len(arrays)
    header = json.dumps(
        {
            "format": "raycube render table",
            "version": 1,
            "medium": "vacuum",
            "solar_source": "bench/peer_scene.py",
            "sun_zenith_deg": SUN_ZENITH_DEG,
            "sun_azimuth_deg": SUN_AZIMUTH_DEG,
            "sensor_height_m": sensor_height_m,
            "provenance": {"model": "even sky, no air"},
            "axes": [{"name": n, "unit": u, "nodes": v} for n, (u, v) in nodes.items()],
            "rows": listed,
        }
    ).encode()
    body = header + bytes(-len(header) % 64) + arrays
    path.write_bytes(
        bytes.fromhex("895243540d0a1a0a")
        + struct.pack("<IIQQ", 1, 0x01020304, len(header), 64 + len(body))
        + hashlib.sha256(body).digest()
        + body
    )


def make(folder, pixels, trees):
    """Writes meshes, table and band list into `folder`; returns what they hold. Meshes there already are kept."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    half_m = 0.5 * pixels * GSD_M
    scene = Scene(
        folder,
        pixels,
        make_ground(folder, half_m + 16),
        make_trees(folder),
        plant(half_m, trees),
        np.loadtxt(ROOT / "scenes/sensors/spectir_360.csv", delimiter=",", comments="#", skiprows=3),
    )
    (folder / "bands.csv").write_text(
        "center_nm,fwhm_nm\n" + "".join(f"{c!r},{w!r}\n" for c, w in scene.bands_nm.tolist())
    )
    write_table(folder / "sky.rct", np.arange(385.0, 2470.1, 1.0))
    for species, rows in scene.places.items():
        (folder / f"{species}.csv").write_text(
            "x_m,y_m,z_m,yaw_deg,scale\n"
            + "".join(",".join(map(repr, r)) + "\n" for r in [[float(v) for v in row] for row in rows])
        )
    return scene


def write_bench_scene(folder):
    """peer.toml of the group any_hit: the sample grid that both of its sides can make."""
    return write_simulation(make(folder, 256, 240), "peer", "grid = [11, 11]", 16)


def write_simulation(scene, name, samples, sky_directions, bounces=0, tolerance=0.001):
    """The scene as a simulation file; samples like 'jittered = [4, 4]'; tolerance: with samples and directions given,
    of the nodes and of the wavelengths along paths. Returns its path."""
    quoted = json.dumps
    text = [
        f"format = 1\nbounces = {bounces}\nsky_directions = {sky_directions}\ntolerance = {tolerance}\n[atmosphere]\n"
        f'tables = "sky.rct"\nadjacency = "off"\n'
        f"[time.sun]\nzenith_deg = {SUN_ZENITH_DEG}\nazimuth_deg = {SUN_AZIMUTH_DEG}\n"
    ]
    for material in scene.materials():
        text.append(f"[[material]]\nname = {quoted(material)}\nfile = {quoted(str(SPECTRA / (material + '.csv')))}\n")
    for mesh in scene.ground + [m for group in scene.trees.values() for m in group]:
        text.append(
            f"[[mesh]]\nname = {quoted(mesh.name)}\nfile = {quoted(mesh.file.name)}\n"
            f"material = {quoted(mesh.material)}\n"
        )
    text += [f"[[instance]]\nmesh = {quoted(mesh.name)}\n" for mesh in scene.ground]
    for species, meshes in scene.trees.items():
        text += [
            f"[[scatter]]\nmesh = {quoted(m.name)}\npositions = {quoted(species + '.csv')}\non_terrain = false\n"
            for m in meshes
        ]
    text.append(
        f"[[instrument]]\nname = \"camera\"\nkind = \"framing\"\nposition_m = [0.0, 0.0, {CAMERA_HEIGHT_M}]\n"
        f"ifov_mrad = {1000 * GSD_M / CAMERA_HEIGHT_M!r}\npixels = {scene.pixels}\nlines = {scene.pixels}\n"
        f"bands = \"bands.csv\"\n"
        f"samples = {{ {samples} }}\nexr = false\npng = false\n"
    )
    file = scene.folder / f"{name}.toml"
    file.write_text("".join(text))
    return file


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("peer_scene: takes the folder to write peer.toml and its files into")
    print(write_bench_scene(sys.argv[1]))
