#!/usr/bin/python3
"""Canopies in the manner of the RAMI exercises, measured: bench/canopies.py RAYCUBE FOLDER [--only NAME ...]

Makes the canopies of scenes/rami/generate.py in FOLDER, takes their reflectance factors in the principal and the
orthogonal plane every 2 degrees, their albedo and where their light goes, red and near infrared, and says how well each
is known. Layers are held against a turbid medium's Monte Carlo written here, with the foot of the hot spot that discs
of their size have: no geometry, draws of its own; all views share its photons, so that the chance of the sum of squares
is a guide and no bar. A canopy that FOLDER has measured is not measured again. Writes FOLDER/canopies.json; exit 0 only
if all bars are met."""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
SUN_DEG, HOT_SPOT_DEG = 20.0, 15.0
LEAF, SOIL = ((0.0546, 0.0149), (0.4957, 0.4409)), (0.127, 0.159)  # of generate.py's layers, red and near infrared
#: Leaves of an 800th of the depth: light scattered once leaves along the way that lit it, where they overlap.
FINE = ("--radius", "0.0025", "--height", "2", "--cell", "2")
#  name: arguments, samples and paths of a pixel in each of 16 batches
CANOPIES = {
    "layer of LAI 1": (("--lai", "1", *FINE), 256, 128),
    "layer of LAI 3": (("--lai", "3", *FINE), 256, 128),
    "layer of LAI 5": (("--lai", "5", *FINE), 256, 128),
    "planophile, LAI 3": (("--lai", "3", "--angles", "planophile", *FINE), 256, 128),
    "erectophile, LAI 3": (("--lai", "3", "--angles", "erectophile", *FINE), 256, 128),
    "15 crowns": (("--spheres",), 240, 120),
    "10 000 birches": (("--stand", "birch"), 320, 120),
    "10 000 spruces": (("--stand", "conifer"), 240, 120),
}
MOST_ERROR, MOST_SIGMA, MOST_OFF = 0.005, 4.5, 0.01


def direction(zenith_deg, azimuth_deg):
    zenith, azimuth = math.radians(zenith_deg), math.radians(azimuth_deg)
    return np.array([math.sin(zenith) * math.sin(azimuth), math.sin(zenith) * math.cos(azimuth), math.cos(zenith)])


class Leaves:
    """Normals of leaves of a distribution: g over zenith angles, azimuths even."""

    def __init__(self, kind):
        theta = np.linspace(0, np.pi / 2, 2001)
        self.theta = theta
        self.below = {
            "uniform": 1 - np.cos(theta),
            "planophile": (2 * theta + np.sin(2 * theta)) / np.pi,
            "erectophile": (2 * theta - np.sin(2 * theta)) / np.pi,
        }[kind]
        share = np.diff(self.below)
        middle, turn = (theta[1:] + theta[:-1]) / 2, (np.arange(256) + 0.5) * np.pi / 256
        self.cosines = np.linspace(0, 1, 201)
        flat = np.sqrt(1 - self.cosines**2)
        self.projected = np.array(
            [
                (share * np.abs(c * np.cos(middle)[:, None] + s * np.sin(middle)[:, None] * np.cos(turn)).mean(1)).sum()
                for c, s in zip(self.cosines, flat)
            ]
        )

    def area(self, cosine):
        """Mean projected area of a square metre of leaf towards directions of these cosines with the zenith."""
        return np.interp(np.abs(cosine), self.cosines, self.projected)

    def foot(self, sun, view):
        """Of light scattered once, how much more goes from sun to view than in a turbid medium: the logarithm, for one
        unit of leaf area over ground whose leaves are discs with a radius of one depth, to first order in it. A disc
        that hides both ways from a point counts once, not twice. In its plane, at h from the point, the ways lie k h
        apart, so by Poisson's law the logarithm is the leaves' density times the mean of Int lens(k h) dh, where lens
        is what two such discs share, and Int lens(d) dd = 8/3 r^3."""
        share, middle = np.diff(self.below), (self.theta[1:] + self.theta[:-1]) / 2
        turn = (np.arange(128) + 0.5) * 2 * np.pi / 128
        flat, up = np.sin(middle)[:, None], np.cos(middle)[:, None]
        normal = np.stack([flat * np.cos(turn), flat * np.sin(turn), up * np.ones(128)], -1)
        s, v = normal @ sun, normal @ view
        apart = np.linalg.norm(sun / s[..., None] - view / v[..., None], axis=-1)
        return 8 / (3 * math.pi) * float((share[:, None] * np.where(s * v > 0, 1 / apart, 0)).sum() / 128)

    def met(self, way, rng):
        """Normals of leaves that light going `way` meets: as often as they are large to it."""
        normal, left = np.empty_like(way), np.arange(len(way))
        while len(left):
            theta = np.interp(rng.random(len(left)), self.below, self.theta)
            turn = 2 * np.pi * rng.random(len(left))
            drawn = np.column_stack([np.sin(theta) * np.cos(turn), np.sin(theta) * np.sin(turn), np.cos(theta)])
            taken = rng.random(len(left)) < np.abs((drawn * way[left]).sum(1))
            normal[left[taken]] = drawn[taken]
            left = left[~taken]
        return normal


def about(axis, rng):
    """Directions by the cosine about axes."""
    u, turn = rng.random(len(axis)), 2 * np.pi * rng.random(len(axis))
    other = np.where(np.abs(axis[:, :1]) < 0.6, [[1.0, 0, 0]], [[0, 1.0, 0]])
    along = np.cross(axis, other)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(axis, along)
    flat = np.sqrt(u)[:, None]
    return flat * (np.cos(turn)[:, None] * along + np.sin(turn)[:, None] * across) + np.sqrt(1 - u)[:, None] * axis


def turbid(lai, leaves, leaf, soil, views, photons, rng, groups=20, radius=0.0):
    """Reflectance factors and standard errors towards views (unit vectors) of a layer of tiny leaves over Lambertian
    ground: photons by chance, their light told to every view at each collision. radius: of the leaves, in depths of the
    layer; 0 is a turbid medium."""
    found = []
    thick = np.array([leaves.area(view[2]) / view[2] for view in views])
    sun = direction(SUN_DEG, 180.0)
    once = np.exp([lai * radius * leaves.foot(sun, view) for view in views])
    views = np.array(views)
    for _ in range(groups):
        count = photons // groups
        way = np.tile(-direction(SUN_DEG, 180.0), (count, 1))
        depth, weight, seen, more = np.zeros(count), np.ones(count), np.zeros(len(views)), once
        while len(weight):
            depth = depth - np.log(rng.random(len(weight))) * -way[:, 2] / leaves.area(way[:, 2])
            keep = depth >= 0
            depth, weight, way = depth[keep], weight[keep], way[keep]
            ground = depth >= lai
            depth = np.minimum(depth, lai)
            normal = leaves.met(way, rng)
            normal[ground] = (0, 0, 1)
            normal *= -np.sign((normal * way).sum(1))[:, None]  # to where the light came from
            back, through = np.where(ground, soil, leaf[0]), np.where(ground, 0.0, leaf[1])
            facing = normal @ views.T
            sent = np.where(facing > 0, back[:, None], through[:, None]) * np.abs(facing)
            seen += more * (weight[:, None] * sent * np.exp(-depth[:, None] * thick)).sum(0) / views[:, 2] / count
            more = 1.0  # of light scattered twice and more
            weight = weight * (back + through)
            turned = rng.random(len(weight)) * (back + through) < back
            way = about(np.where(turned[:, None], normal, -normal), rng)
            alive = rng.random(len(weight)) < 0.9  # the others end, these stand for them
            depth, weight, way = depth[alive], weight[alive] / 0.9, way[alive]
        found.append(seen)
    found = np.array(found)
    return found.mean(0), found.std(0, ddof=1) / math.sqrt(groups)


def measured(raycube, folder, arguments, samples, paths):
    """The canopy's report by measure, and the seconds that it took."""
    report, file = folder / "report.json", folder / "canopy.toml"
    if not report.exists():
        subprocess.run([sys.executable, ROOT / "scenes/rami/generate.py", folder, *arguments], check=True)
        more = f"samples = {samples}\npaths = {paths}\n"
        text = file.read_text().replace("[[measure]]\n", f"[[measure]]\n{more}", 2)  # the planes
        file.write_text(text)
        begun = time.monotonic()
        command = [raycube, "measure", file, "-o", folder / "out", "--overwrite", "--json"]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        report.write_text(json.dumps({"seconds": time.monotonic() - begun, "found": json.loads(done.stdout)}))
    kept = json.loads(report.read_text())
    return {one.get("measure", one.get("budget")): one for one in kept["found"]}, kept["seconds"]


def chi_square_p(square, count):
    """Chance of a sum of squares as large, by Wilson and Hilferty's cube root."""
    z = ((square / count) ** (1 / 3) - (1 - 2 / (9 * count))) / math.sqrt(2 / (9 * count))
    return 0.5 * math.erfc(z / math.sqrt(2))


def against_turbid(found, arguments, rng):
    """Per band: views outside the hot spot, their largest difference in standard errors, the chance of the sum of their
    squares, mean ratio."""
    given = dict(zip(arguments[::2], arguments[1::2]))
    leaves, sun = Leaves(given.get("--angles", "uniform")), direction(SUN_DEG, 180.0)
    views = [v for name in ("principal", "orthogonal") for v in found[name]["views"]]
    ways = [direction(abs(v["zenith_deg"]), v["azimuth_deg"]) for v in views]
    outside = np.array([math.degrees(math.acos(min(1.0, w @ sun))) > HOT_SPOT_DEG for w in ways])
    out = []
    for band in range(2):
        radius = float(given["--radius"]) / float(given["--height"])
        wanted, sigma = turbid(
            float(given["--lai"]), leaves, LEAF[band], SOIL[band], ways, 1000000, rng, radius=radius
        )
        ours = np.array([v["brf"]["mean"][band] for v in views])
        error = np.array([v["brf"]["error"][band] for v in views])
        apart = ((ours - wanted) / np.hypot(error, sigma))[outside]
        ratio = ours[outside].mean() / wanted[outside].mean()
        out.append((len(apart), float(np.abs(apart).max()), float(chi_square_p((apart**2).sum(), len(apart))), ratio))
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("raycube", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", nargs="+", choices=CANOPIES, default=list(CANOPIES), metavar="NAME")
    options = parser.parse_args()
    missed, results = [], {}
    for name in options.only:
        arguments, samples, paths = CANOPIES[name]
        found, seconds = measured(
            options.raycube.resolve(), options.folder / name.replace(" ", "_"), arguments, samples, paths
        )
        views = [v for plane in ("principal", "orthogonal") for v in found[plane]["views"]]
        error = [max(v["brf"]["error"][b] / v["brf"]["mean"][b] for v in views) for b in range(2)]
        results[name] = {"seconds": seconds, "views": len(views), "worst_error": error}
        worst = " and ".join(f"{e:.2%}" for e in error)
        print(f"{name}: {len(views)} views, {seconds:.0f} s, worst standard errors {worst}")
        if max(error) > MOST_ERROR:
            missed.append(f"{name}: a standard error of {max(error):.2%}")
        print("   albedo:", found["albedo"]["albedo"])
        print("   light:", json.dumps(found["light"])[:600])
        if "layer" not in name and "LAI" not in name:
            continue
        for band, (count, apart, p, ratio) in enumerate(against_turbid(found, arguments, np.random.default_rng(5))):
            results[name][f"turbid_{band}"] = {"views": count, "apart": apart, "p": p, "ratio": ratio}
            print(f"   band {band}: {count} views outside the hot spot, {apart:.2f} apart, p {p:.3g}, mean {ratio:.4f}")
            if apart > MOST_SIGMA or abs(ratio - 1) > MOST_OFF:
                missed.append(f"{name}, band {band}: {apart:.2f} standard errors, p {p:.2g}, ratio {ratio:.4f}")
    (options.folder / "canopies.json").write_text(json.dumps(results, indent=1))
    for line in missed:
        print("MISSED:", line)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
