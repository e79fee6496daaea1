#!/usr/bin/env python3
"""A stand of crowns against another code: bench/canopy_peer.py RAYCUBE FOLDER [--paths N]

Run by a Python that has PyPI's eradiate-mitsuba 0.5 (Mitsuba 3 with leaves that reflect and transmit). Makes the
fifteen crowns of scenes/rami/generate.py in FOLDER, once each over wide ground, and takes an area of 40 m among them in
both planes by `RAYCUBE measure` and by Mitsuba's path tracer, which sees the same 3 million triangles by instances, in
16 batches of its own draws. Prints both factors in red and near infrared, how far apart they are in standard errors,
and the sum of their squares."""

import argparse
import json
import math
import pathlib
import subprocess
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

ROOT = pathlib.Path(__file__).resolve().parents[1]
BATCHES, SUN_ZENITH_DEG, TOP_M, AREA_M, GROUND_M = 16, 50.0, 25.0, 40.0, 600.0
LEAF = {"reflectance": (0.0546, 0.4957), "transmittance": (0.0149, 0.4409)}  # 650, 850 nm: leaf.csv
SOIL = (0.127, 0.159)


def grey(value):
    """One value in all channels: its leaves draw their side by all channels at once, and are right only of grey."""
    return {"type": "rgb", "value": [value] * 3}


def direction(zenith_deg, azimuth_deg):
    zenith, azimuth = math.radians(abs(zenith_deg)), math.radians(azimuth_deg)
    return np.array([math.sin(zenith) * math.sin(azimuth), math.sin(zenith) * math.cos(azimuth), math.cos(zenith)])


def canopy(folder):
    """The generator's crowns, not repeated, over wide ground, and two measures of an area in their middle."""
    generate = [sys.executable, ROOT / "scenes/rami/generate.py", folder, "--spheres", "--sun-zenith", SUN_ZENITH_DEG]
    subprocess.run([str(part) for part in generate], check=True, stdout=subprocess.DEVNULL)
    file = folder / "canopy.toml"
    head = file.read_text().split("[[measure]]\n")[0]
    head = "".join(line + "\n" for line in head.splitlines() if not line.startswith(("[scene]", "periodic")))
    head = head.replace("size_m = [100.0, 100.0]", f"size_m = [{GROUND_M}, {GROUND_M}]")
    for views in ("principal", "orthogonal"):
        head += f'[[measure]]\nname = "{views}"\nviews = "{views}"\nsize_m = [{AREA_M}, {AREA_M}]\nheight_m = {TOP_M}\n'
        head += "zenith_deg = [-70, 70, 20]\nsamples = 256\npaths = 256\n"
    file.write_text(head)
    return file


def world(folder, sun, band):
    """The crowns by instances, and the ground, in one band."""
    place = mi.ScalarTransform4f
    leaf = {"type": "bilambertian", **{name: grey(pair[band]) for name, pair in LEAF.items()}}
    mesh = {"type": "ply", "filename": str(folder / "leaves.ply"), "face_normals": True, "bsdf": leaf}
    scene = {
        "type": "scene",
        "leaves": {"type": "shapegroup", "mesh": mesh},
        "soil": {
            "type": "rectangle",
            "to_world": place().scale([GROUND_M / 2, GROUND_M / 2, 1]),
            "bsdf": {"type": "diffuse", "reflectance": grey(SOIL[band])},
        },
        "sun": {"type": "directional", "direction": (-sun).tolist(), "irradiance": {"type": "rgb", "value": [1, 1, 1]}},
        "integrator": {"type": "path", "max_depth": 200, "rr_depth": 20},
    }
    for n, (x, y, z, yaw) in enumerate(np.loadtxt(folder / "crowns.csv", delimiter=",", skiprows=1)):
        # Azimuths turn clockwise, Mitsuba's angles the other way.
        there = place().translate([x, y, z]).rotate([0, 0, 1], -yaw)
        scene[f"crown_{n}"] = {"type": "instance", "to_world": there, "group": {"type": "ref", "id": "leaves"}}
    return mi.load_dict(scene)


def target(view):
    """The area, which turns with the view."""
    azimuth = math.degrees(math.atan2(view[0], view[1]))
    there = mi.ScalarTransform4f().translate([0, 0, TOP_M]).rotate([0, 0, 1], -azimuth)
    return there.scale([AREA_M / 2, AREA_M / 2, 1])


def factors(scene, view, sun, paths):
    """Mean and standard error."""
    film = {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}, "component_format": "float32"}
    area = {"type": "rectangle", "to_world": target(view)}
    sensor = mi.load_dict({"type": "distant", "direction": (-view).tolist(), "target": area, "film": film})
    found = []
    for batch in range(BATCHES):
        image = np.array(mi.render(scene, sensor=sensor, spp=paths // BATCHES, seed=batch))
        found.append(math.pi * image.reshape(-1)[0] / sun[2])
    found = np.array(found)
    return found.mean(), found.std(ddof=1) / math.sqrt(BATCHES)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("raycube", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--paths", type=int, default=1 << 20)
    options = parser.parse_args()
    command = [options.raycube, "measure", canopy(options.folder), "-o", options.folder / "out", "--overwrite"]
    done = subprocess.run([*map(str, command), "--json"], check=True, stdout=subprocess.PIPE)
    measures = json.loads(done.stdout)
    sun = direction(SUN_ZENITH_DEG, 180.0)
    views = [view for measure in measures for view in measure["views"]]
    found = []
    for band in range(len(SOIL)):
        scene = world(options.folder, sun, band)
        for view in views:
            way = direction(view["zenith_deg"], view["azimuth_deg"])
            theirs, error = factors(scene, way, sun, options.paths)
            ours, own = view["brf"]["mean"][band], view["brf"]["error"][band]
            found.append(((ours - theirs) / math.hypot(own, error), ours / theirs))
            print(
                f"canopy_peer: band {band + 1}, view {view['zenith_deg']:5.0f}, {view['relative_azimuth_deg']:4.0f}: "
                f"{ours:.5f} +- {own:.5f}, peer {theirs:.5f} +- {error:.5f}, {found[-1][0]:+.2f}",
                flush=True,
            )
    apart, ratio = np.array(found).T
    squares, count, worst = (apart**2).sum(), len(apart), np.abs(apart).max()
    print(f"canopy_peer: ratio {ratio.min():.4f} to {ratio.max():.4f}, mean {ratio.mean():.4f}")
    print(f"canopy_peer: chi-squared {squares:.1f} of {count}, worst {worst:.2f} standard errors")


if __name__ == "__main__":
    sys.exit(main())
