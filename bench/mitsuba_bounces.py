#!/usr/bin/env python3
"""A 360-band cube with light between surfaces by raycube, by Mitsuba 3 and by a script that knows our skeleton
wavelengths, at equal error of the worst band.

Run by build/peers/venv/bin/python (`ci/setup --peers` makes it; `ci/bench bounces` calls both). The scene of
bench/mitsuba_cube.py: the same vertices, spectra, sun, even sky, pinhole and box filter; no air. Light comes by up to
BOUNCES surfaces after the first. Where no ground is, below the horizon, raycube's world is dark and Mitsuba's as
bright as the sky; the middle of the image, 96 m of 288, is compared.
Error: rms over the middle's pixels of the difference from a converged render by the same code, over the band's mean; of
nine bands from 480 to 1640 nm the worst. Time: without load and compilation; Mitsuba's is that of mi.render alone,
raycube's holds its plan, all stages and writing the cube to disk.
The script renders as many wavelengths as raycube's plan chose (and, told apart, 16), three at a time, and multiplies
them by raycube's matrix; to its renders are added that product and the writing, both measured here. What bands between
the wavelengths are off by is left out, in its favour.
Writes build/bench/mitsuba_bounces.json and .md and docs/pictures/mitsuba_bounces.png.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import time

import matplotlib
import numpy as np

import mitsuba_cube
import mitsuba_report
import peer_scene

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = peer_scene.ROOT
WORK = ROOT / "build/bench/mitsuba_bounces"
BOUNCES = 4
CROP, PIXELS, TRIPLES = mitsuba_cube.CROP, mitsuba_cube.PIXELS, mitsuba_cube.TRIPLES[::2]
TOLERANCE = 0.02  # of which raycube allows a tenth for bands between the wavelengths along paths
BANDS = [b for triple in TRIPLES for b in triple]
REFERENCE_VARIANT, REFERENCE_SPP, REFERENCE_PASSES = "llvm_ad_rgb", 128, 16
RAYCUBE_REFERENCE = ("jittered = [24, 24]", 2304)
RAYCUBE = [(16, 8), (36, 16), (64, 32), (121, 64), (256, 128), (400, 256)]  # samples a pixel, rays into the sky
VARIANTS = {  # renders that make 360 bands, bands of each, samples a pixel
    "scalar_rgb": (120, 3, (4, 16, 64)),
    "llvm_ad_rgb": (120, 3, (4, 16, 64, 256)),
    "llvm_ad_mono": (360, 1, (4, 16, 64)),
}
FEW_WAVELENGTHS = 16
AGREE = 1e-3  # of band means: three times what was found; both noises, bands between wavelengths along paths


def worst_error(image, reference):
    """rms over pixels over the band's mean; the worst of the bands."""
    return float(np.max(np.sqrt(np.mean((image - reference) ** 2, (0, 1))) / reference.mean((0, 1))))


def middle(image):
    low = (image.shape[0] - CROP) // 2
    return image[low : low + CROP, low : low + CROP]


# --- Mitsuba, in processes of their own: one variant each -------------------------------------------------------------
def mitsuba_reference():
    mi, scene, images = mitsuba_cube.start_mitsuba(REFERENCE_VARIANT), mitsuba_cube.make_scene(), []
    world = mitsuba_cube.mitsuba_scene(mi, scene, REFERENCE_VARIANT, TRIPLES[0], CROP, BOUNCES)
    for triple in TRIPLES:
        mitsuba_cube.choose_bands(mi, world, scene, REFERENCE_VARIANT, triple)
        passes = [
            np.array(mi.render(world, spp=REFERENCE_SPP, seed=1000 + p), dtype=float) for p in range(REFERENCE_PASSES)
        ]
        images.append(sum(passes) / REFERENCE_PASSES)
        print(f"mitsuba: converged {triple}", flush=True)
    np.save(WORK / "mitsuba_reference.npy", np.concatenate(images, 2))


def mitsuba_time(variant, counts):
    """A line of JSON for each number of samples: seconds of one render; saves the middle of the bands rendered."""
    renders, at_once, _ = VARIANTS[variant]
    mi, scene = mitsuba_cube.start_mitsuba(variant), mitsuba_cube.make_scene()
    world = mitsuba_cube.mitsuba_scene(mi, scene, variant, TRIPLES[0], None, BOUNCES)
    groups = [BANDS[i : i + at_once] for i in range(0, len(BANDS), at_once)]
    for spp in counts:
        images, seconds = [], []
        for index in range(-1, len(groups)):  # the first round loads, traces and compiles and is thrown away
            chosen = groups[max(index, 0)]
            mitsuba_cube.choose_bands(mi, world, scene, variant, chosen)
            began = time.perf_counter()
            image = np.array(mi.render(world, spp=spp, seed=1 + max(index, 0)))
            if index < 0:
                continue
            seconds.append(time.perf_counter() - began)
            images.append(middle(image)[:, :, :at_once])
        np.save(WORK / f"{variant}_{spp}.npy", np.concatenate(images, 2))
        point = {"variant": variant, "spp": spp, "render_s": statistics.mean(seconds), "at_once": at_once}
        print(json.dumps({**point, "seconds": renders * point["render_s"]}), flush=True)


# --- raycube ----------------------------------------------------------------------------------------------------------
def raycube_reference(scene):
    samples, sky = RAYCUBE_REFERENCE
    part = peer_scene.dataclasses.replace(scene, pixels=CROP)
    mitsuba_cube.render(peer_scene.write_simulation(part, "bounced_reference", samples, sky, BOUNCES), WORK / "ours")
    return mitsuba_cube.read_cube(WORK / "ours", CROP)


def raycube_time(scene, samples, sky, repeats=2):
    file = peer_scene.write_simulation(scene, "bounced", f"lattice = {samples}", sky, BOUNCES, TOLERANCE)
    runs = [mitsuba_cube.render(file, WORK / "timed") for _ in range(repeats)]
    not_rendering = ("load", "atmosphere", "kernels")
    seconds = [sum(s for name, s in run["stage_s"].items() if name not in not_rendering) for run in runs]
    point = {"samples": samples, "sky_directions": sky, "seconds": min(seconds)}
    point["plan_s"] = min(run["stage_s"]["plan"] for run in runs)
    point["skeleton"] = len(runs[0]["plan"]["bounces"]["skeleton_um"])
    return point, middle(mitsuba_cube.read_cube(WORK / "timed", PIXELS))


def product_and_writing_s(wavelengths):
    """What the script does after its renders: pixels x wavelengths by wavelengths x 360, and a file."""
    rng = np.random.default_rng(1)
    light, matrix = (rng.random(s, dtype=np.float32) for s in ((PIXELS * PIXELS, wavelengths), (wavelengths, 360)))
    began = time.perf_counter()
    (light @ matrix).tofile(WORK / "product.img")
    return time.perf_counter() - began


# --- figures ----------------------------------------------------------------------------------------------------------
def measure():
    WORK.mkdir(parents=True, exist_ok=True)
    scene, me = mitsuba_cube.make_scene(), [sys.executable, str(pathlib.Path(__file__).resolve())]
    if not (WORK / "mitsuba_reference.npy").exists():
        subprocess.run([*me, "--reference"], check=True)
    if not (WORK / "raycube_reference.npy").exists():
        np.save(WORK / "raycube_reference.npy", raycube_reference(scene))
    theirs, ours = np.load(WORK / "mitsuba_reference.npy"), np.load(WORK / "raycube_reference.npy")[:, :, BANDS]
    apart = np.abs(theirs.mean((0, 1)) / ours.mean((0, 1)) - 1)
    data = {"scene": scene.facts(), "agreement_mean_worst": float(apart.max()), "raycube": [], "mitsuba": []}
    print("band means of both, worst difference", data["agreement_mean_worst"], apart, flush=True)
    if data["agreement_mean_worst"] > AGREE:
        raise SystemExit(f"mitsuba_bounces: band means differ by {apart.max():.2%}: not the same scene")
    for samples, sky in RAYCUBE:
        point, cube = raycube_time(scene, samples, sky)
        data["raycube"].append({**point, "error": worst_error(cube[:, :, BANDS], ours)})
        print("raycube", data["raycube"][-1], flush=True)
    for variant, (_, _, counts) in VARIANTS.items():
        run = subprocess.run(
            [*me, "--time", variant, *map(str, counts)], stdout=subprocess.PIPE, text=True, check=True
        )
        for line in run.stdout.splitlines():
            if line.startswith("{"):
                point = json.loads(line)
                point["error"] = worst_error(np.load(WORK / f"{variant}_{point['spp']}.npy"), theirs)
                data["mitsuba"].append(point)
                print("mitsuba", point, flush=True)
    data["skeleton"] = max(p["skeleton"] for p in data["raycube"])
    data["product_and_writing_s"] = product_and_writing_s(data["skeleton"])
    return data


def ratios_to(ours, theirs):
    """Seconds of theirs over ours at nine errors that both curves cover, evenly apart in their logarithm."""
    a, b = mitsuba_report.front(ours), mitsuba_report.front(theirs)
    least, most = max(a[-1]["error"], b[-1]["error"]), min(a[0]["error"], b[0]["error"])
    if least >= most:
        return []
    errors = np.geomspace(least * (1 + 1e-9), most * (1 - 1e-9), 9)
    return [(float(e), mitsuba_report.seconds_at(b, e) / mitsuba_report.seconds_at(a, e)) for e in errors]


def fewer_renders(points, wavelengths, after_s):
    """The script's: a variant's points, each with so many renders in place of all bands'."""
    return [dict(p, seconds=math.ceil(wavelengths / p["at_once"]) * p["render_s"] + after_s) for p in points]


def compare(data):
    """Against the fastest variant and against the script, which takes the variant fastest for it: medians over the
    errors."""
    after_s = data["product_and_writing_s"]
    forms = {
        "bounced_cube_vs_mitsuba3_equal_error": lambda points: points,
        "bounced_cube_vs_clever_equal_error": lambda points: fewer_renders(points, data["skeleton"], after_s),
        "bounced_cube_vs_clever_of_16_equal_error": lambda points: fewer_renders(points, FEW_WAVELENGTHS, after_s),
    }
    for name, form in forms.items():
        rows = {}
        for variant in dict.fromkeys(p["variant"] for p in data["mitsuba"]):
            rows[variant] = ratios_to(data["raycube"], form([p for p in data["mitsuba"] if p["variant"] == variant]))
        medians = {v: statistics.median(r for _, r in found) for v, found in rows.items() if found}
        fastest = min(medians, key=medians.get)
        ratios = [r for _, r in rows[fastest]]
        data[name], data[name + "_range"] = medians[fastest], [min(ratios), max(ratios)]
        data[name + "_variant"] = fastest
        data[name + "_errors"] = [rows[fastest][0][0], rows[fastest][-1][0]]


GOALS = {"bounced_cube_vs_mitsuba3_equal_error": 50.0, "bounced_cube_vs_clever_equal_error": 1.5}


def markdown(data):
    lines = [
        f"Converged images of both: band means differ by {100 * data['agreement_mean_worst']:.2g} % at most. Paths "
        f"carry {data['skeleton']} wavelengths; the script's product and writing take "
        f"{data['product_and_writing_s']:.2f} s.",
        "",
        "| | samples a pixel | seconds for 360 bands | rms error, worst of nine bands |",
        "|---|---|---|---|",
    ]
    for p in data["raycube"]:
        lines.append(
            f"| raycube, {p['sky_directions']} sky rays and half as many paths | {p['samples']} | {p['seconds']:.2f} "
            f"(plan {p['plan_s']:.2f}) | {100 * p['error']:.2f} % |"
        )
    for p in data["mitsuba"]:
        lines.append(f"| {p['variant']} | {p['spp']} | {p['seconds']:.3g} | {100 * p['error']:.2f} % |")
    lines.append("")
    for name in ("mitsuba3", "clever", "clever_of_16"):
        key = f"bounced_cube_vs_{name}_equal_error"
        (low, high), (first, last) = data[key + "_range"], data[key + "_errors"]
        goal = f" (at least {GOALS[key]:g})" if key in GOALS else ""
        lines.append(
            f"`{key}` = {data[key]:.3g} [{low:.3g} .. {high:.3g}]{goal} against {data[key + '_variant']}, median over "
            f"nine errors from {100 * first:.2g} to {100 * last:.2g} %.\n"
        )
    return "\n".join(lines)


def draw(data):
    figure, axis = plt.subplots(figsize=(8.5, 5.2))
    curves = {"raycube, all 360 bands (plan and writing included)": data["raycube"]}
    for variant in dict.fromkeys(p["variant"] for p in data["mitsuba"]):
        points = [p for p in data["mitsuba"] if p["variant"] == variant]
        curves[f"Mitsuba 3.9.1 {variant}, path, 360 bands"] = points
        if variant == data["bounced_cube_vs_clever_equal_error_variant"]:
            for count in (data["skeleton"], FEW_WAVELENGTHS):
                curves[f"{variant}, {count} wavelengths times raycube's matrix"] = fewer_renders(
                    points, count, data["product_and_writing_s"]
                )
    for label, points in curves.items():
        mark = "o-" if label.startswith("raycube") else "s--"
        axis.loglog([p["seconds"] for p in points], [100 * p["error"] for p in points], mark, ms=4, label=label,
                    color="black" if label.startswith("raycube") else None)
    light = f"light by up to {BOUNCES} surfaces more"
    mitsuba_report.name_axes(axis, data["scene"], "the worst of nine bands", light)
    axis.set_ylim(0.8, 60)  # room for the legend above the curves
    axis.legend(fontsize=8, loc="upper right")
    figure.tight_layout()
    figure.savefig(ROOT / "docs/pictures/mitsuba_bounces.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reference", action="store_true", help="only Mitsuba's converged render")
    parser.add_argument("--time", nargs="+", metavar="VARIANT SPP", help="only one variant's timed renders")
    parser.add_argument("--figures", type=pathlib.Path, help="report an earlier run's file anew")
    options = parser.parse_args()
    if options.reference:
        return mitsuba_reference()
    if options.time:
        return mitsuba_time(options.time[0], [int(n) for n in options.time[1:]])
    data = json.loads(options.figures.read_text()) if options.figures else measure()
    compare(data)
    (ROOT / "build/bench/mitsuba_bounces.json").write_text(json.dumps(data, indent=1) + "\n")
    (ROOT / "build/bench/mitsuba_bounces.md").write_text(markdown(data))
    draw(data)
    print(markdown(data))


if __name__ == "__main__":
    main()
