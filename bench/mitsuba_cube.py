#!/usr/bin/env python3
"""A 360-band cube by raycube and by Mitsuba 3 at equal error: bench/mitsuba_cube.py [--launcher CMD] [--figures
FILE.json]

Run by build/peers/venv/bin/python (`ci/setup --peers` makes it; `ci/bench mitsuba` calls both). One scene
(bench/peer_scene.py): the same vertices, spectra, sun, even sky, pinhole and box filter; direct light only, no air.
Error: rms over the middle of the image of the difference from a converged render by the same code, over the band's
mean; of bands the median. Time: without load and compilation; Mitsuba's is that of mi.render alone, raycube's holds its
plan, all stages and writing the cube to disk. Writes build/bench/mitsuba.json, build/bench/mitsuba.md,
docs/pictures/mitsuba_error.png and mitsuba_images.png. --launcher is put before every timed process.
"""

import argparse
import ctypes.util
import glob
import json
import os
import pathlib
import shlex
import statistics
import subprocess
import sys
import time

import numpy as np

import mitsuba_report
import peer_scene

ROOT = peer_scene.ROOT
WORK = mitsuba_report.WORK
PIXELS, TREES, CROP, THREADS = 256, 240, 96, 2
# Bands of the converged renders and of the renders in three channels: 648, 555, 482 nm first, for the pictures.
TRIPLES = [(54, 34, 18), (8, 26, 44), (70, 84, 98), (112, 126, 150), (170, 200, 230), (262, 300, 340)]
REFERENCE_SPP, REFERENCE_PASSES = 1024, 8
RAYCUBE_REFERENCE = ("jittered = [24, 24]", 2304)
TIMED = [
    b for triple in TRIPLES[::2] for b in triple
]  # of these the timed renders are made, and of both sides' errors the median
RAYCUBE = [
    (9, 4),
    (16, 8),
    (36, 16),
    (64, 16),
    (64, 32),
    (121, 48),
    (256, 96),
]  # samples a pixel, rays into the sky
# variant: renders that make 360 bands, renders timed, samples a pixel.
VARIANTS = {
    "scalar_rgb": ("three bands a render, 120 renders", 120, 3, (4, 16, 64, 256)),
    "llvm_ad_rgb": ("three bands a render, 120 renders", 120, 3, (4, 16, 64, 256)),
    "llvm_ad_mono": ("one band a render, 360 renders", 360, 3, (4, 16, 64)),
    "scalar_spectral": ("specfilm of 360 bands, one render", 1, 1, (1, 4)),
    "llvm_ad_spectral": ("specfilm of 360 bands, one render", 1, 1, (4, 16)),
}


def llvm_library():
    """LLVM 17 or later: 14 and 15, which PoCL brings, lack an instruction that Dr.Jit 1.5 asks for."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return os.environ["DRJIT_LIBLLVM_PATH"]
    found = sorted(glob.glob(str(ROOT / "build/peers/llvm/usr/lib/*/libLLVM.so.*")))
    return found[-1] if found else ctypes.util.find_library("LLVM-19")


# --- Mitsuba ---------------------------------------------------------------------------------------------------------
def band_shape(centre_nm, fwhm_nm):
    nodes, weight = peer_scene.band_nodes(centre_nm, fwhm_nm, 33)
    step = nodes[1] - nodes[0]
    return {
        "type": "irregular",
        "wavelengths": ", ".join(f"{n:.6f}" for n in nodes),
        "values": ", ".join(f"{w / step:.8g}" for w in weight),
    }


def curve(nodes, values):
    return {
        "type": "irregular",
        "wavelengths": ", ".join(f"{n:.6g}" for n in nodes),
        "values": ", ".join(f"{v:.8g}" for v in values),
    }


def mitsuba_scene(mi, scene, variant, chosen, crop=None, bounces=0):
    """The scene with the light and reflectances of `chosen` bands (rgb, mono) or with whole spectra (spectral); light
    comes by up to `bounces` surfaces after the first."""
    sun, sky, reflectance = peer_scene.band_means(scene)
    grid = np.arange(385.0, 2470.1, 1.0)
    if variant.endswith("spectral"):
        light = {"sun": curve(grid, peer_scene.sun_irradiance(grid)), "sky": curve(grid, peer_scene.sky_radiance(grid))}
        colour = {m: curve(*peer_scene.spectrum(m).T) for m in reflectance}
    else:
        chosen = list(chosen) if variant.endswith("rgb") else chosen[0]
        as_is = (
            (lambda v: {"type": "rgb", "value": [float(x) for x in v]})
            if variant.endswith("rgb")
            else (lambda v: {"type": "uniform", "value": float(v)})
        )
        light = {"sun": as_is(sun[chosen]), "sky": as_is(sky[chosen])}
        colour = {m: as_is(r[chosen]) for m, r in reflectance.items()}
    film = {"width": scene.pixels, "height": scene.pixels, "rfilter": {"type": "box"}, "component_format": "float32"}
    if crop:
        film.update({f"crop_offset_{a}": (scene.pixels - crop) // 2 for a in "xy"}, crop_width=crop, crop_height=crop)
    if variant.endswith("spectral"):
        film.update(type="specfilm", **{f"band_{i:03d}": band_shape(*b) for i, b in enumerate(scene.bands_nm.tolist())})
    else:
        film.update(type="hdrfilm", pixel_format="rgb" if variant.endswith("rgb") else "luminance")
    turn = mi.ScalarTransform4f
    zenith, azimuth = np.radians([peer_scene.SUN_ZENITH_DEG, peer_scene.SUN_AZIMUTH_DEG])
    towards_sun = [np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)]
    height = peer_scene.CAMERA_HEIGHT_M
    # The sun is always picked as emitter and the sky met by the BSDF's own samples: the least noise for its time of the
    # settings tried.
    world = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": bounces + 2} if bounces else
        {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1},
        "sensor": {
            "type": "perspective",
            "fov_axis": "x",
            "near_clip": 1.0,
            "far_clip": 1e4,
            "fov": float(2 * np.degrees(np.arctan(0.5 * scene.pixels * peer_scene.GSD_M / height))),
            "to_world": turn().look_at([0, 0, height], [0, 0, 0], [0, 1, 0]),
            "film": film,
            "sampler": {"type": "multijitter", "sample_count": 16},
        },
        "sun": {
            "type": "directional",
            "direction": [-float(v) for v in towards_sun],
            "irradiance": light["sun"],
            "sampling_weight": 1.0,
        },
        "sky": {"type": "constant", "radiance": light["sky"], "sampling_weight": 0.0},
    }
    for material, reflects in colour.items():
        world[f"of_{material}"] = {"type": "twosided", "side": {"type": "diffuse", "reflectance": reflects}}

    def shape(mesh):
        return {
            "type": "ply",
            "filename": str(mesh.file),
            "face_normals": True,
            "bsdf": {"type": "ref", "id": f"of_{mesh.material}"},
        }

    # Placed trees as one mesh a material: without instances Mitsuba is faster, and its LLVM variants compile in
    # seconds, not minutes.
    for mesh in scene.ground:
        world[mesh.name] = shape(mesh)
    for mesh in peer_scene.merged_trees(scene):
        world[mesh.name] = shape(mesh)
    return mi.load_dict(world)


def start_mitsuba(variant):
    if variant.startswith("llvm"):
        library = llvm_library()
        if not library:
            raise SystemExit("mitsuba: no LLVM library; run ci/setup --peers or set DRJIT_LIBLLVM_PATH")
        os.environ["DRJIT_LIBLLVM_PATH"] = str(library)
    import drjit
    import mitsuba as mi

    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    drjit.set_thread_count(THREADS)
    return mi


def choose_bands(mi, world, scene, variant, chosen):
    """Gives a loaded scene the light and reflectances of other bands."""
    sun, sky, reflectance = peer_scene.band_means(scene)
    value = (
        (lambda v: mi.Color3f(*[float(x) for x in v])) if variant.endswith("rgb") else (lambda v: mi.Float(float(v[0])))
    )
    chosen = list(chosen)[: 3 if variant.endswith("rgb") else 1]
    parameters = mi.traverse(world)
    parameters["sun.irradiance.value"], parameters["sky.radiance.value"] = value(sun[chosen]), value(sky[chosen])
    for material, r in reflectance.items():
        parameters[f"of_{material}.brdf_0.reflectance.value"] = value(r[chosen])
    parameters.update()


def mitsuba_reference():
    """Converged triples of the middle of the image; scalar_rgb."""
    variant = "scalar_rgb"
    mi, scene, images = start_mitsuba(variant), make_scene(), []
    world = mitsuba_scene(mi, scene, variant, TRIPLES[0], CROP)
    for triple in TRIPLES:
        choose_bands(mi, world, scene, variant, triple)
        images.append(
            sum(
                np.array(mi.render(world, spp=REFERENCE_SPP // REFERENCE_PASSES, seed=1000 + p))
                for p in range(REFERENCE_PASSES)
            )
            / REFERENCE_PASSES
        )
        print(f"mitsuba: converged {triple}", flush=True)
    np.save(WORK / "mitsuba_reference.npy", np.concatenate(images, 2))


def mitsuba_time(variant, counts):
    """One line of JSON a number of samples: seconds for all 360 bands; saves the middle of the bands rendered."""
    text, renders, timed, _ = VARIANTS[variant]
    mi, scene = start_mitsuba(variant), make_scene()
    world = mitsuba_scene(mi, scene, variant, TRIPLES[0])
    low = (PIXELS - CROP) // 2
    for spp in counts:
        images, seconds, bands = [], [], []
        # The first round loads, traces and compiles kernels and is thrown away.
        for index in range(-1, timed):
            triple = TRIPLES[2 * max(index, 0)]
            chosen = range(360) if variant.endswith("spectral") else triple if variant.endswith("rgb") else triple[:1]
            if not variant.endswith("spectral"):
                choose_bands(mi, world, scene, variant, triple)
            began = time.perf_counter()
            image = np.array(mi.render(world, spp=spp, seed=1 + max(index, 0)))
            if index < 0:
                continue
            seconds.append(time.perf_counter() - began)
            images.append(image[low : low + CROP, low : low + CROP, : len(chosen)])
            bands += list(chosen)
            if index == 0:
                np.save(WORK / f"full_{variant}_{spp}.npy", image[:, :, :3])
        np.save(WORK / f"{variant}_{spp}.npy", np.concatenate(images, 2))
        print(
            json.dumps(
                {
                    "variant": variant,
                    "text": text,
                    "spp": spp,
                    "seconds": renders * statistics.mean(seconds),
                    "renders_timed": timed,
                    "bands": bands,
                }
            ),
            flush=True,
        )


# --- raycube
# -----------------------------------------------------------------------------------------------------------
def make_scene():
    return peer_scene.make(WORK / "scene", PIXELS, TREES)


def read_cube(folder, pixels):
    return np.fromfile(folder / "camera/radiance.img", "<f4").reshape(pixels, pixels, -1)


def render(file, out, launcher=()):
    subprocess.run(
        [*launcher, ROOT / "build/raycube", "render", file, "-o", out, "--overwrite", "--threads", str(THREADS), "-q"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return json.loads((out / "camera/run.json").read_text())


def raycube_reference(scene):
    samples, sky = RAYCUBE_REFERENCE
    middle = peer_scene.dataclasses.replace(scene, pixels=CROP)
    render(peer_scene.write_simulation(middle, "reference", samples, sky), WORK / "raycube_reference")
    return read_cube(WORK / "raycube_reference", CROP)


def raycube_time(scene, samples, sky, launcher, repeats=2):
    file = peer_scene.write_simulation(scene, "timed", f"lattice = {samples}", sky)
    runs = [render(file, WORK / "timed", launcher)["stage_s"] for _ in range(repeats)]
    not_rendering = ("load", "atmosphere", "kernels", "plan")
    stages = [sum(s for name, s in run.items() if name not in not_rendering) for run in runs]
    low = (PIXELS - CROP) // 2
    cube = read_cube(WORK / "timed", PIXELS)
    np.save(WORK / f"full_raycube_{samples}_{sky}.npy", cube[:, :, list(TRIPLES[0])])
    return {
        "samples": samples,
        "sky_directions": sky,
        "stages_s": min(stages),
        "plan_s": min(run["plan"] for run in runs),
        "seconds": min(s + r["plan"] for s, r in zip(stages, runs)),
    }, cube[low : low + CROP, low : low + CROP]


# --- figures
# -----------------------------------------------------------------------------------------------------------
def median_error(image, reference):
    """rms over pixels over the band's mean; the median of the bands."""
    return float(np.median(np.sqrt(np.mean((image - reference) ** 2, (0, 1))) / reference.mean((0, 1))))


def measure(launcher, earlier):
    WORK.mkdir(parents=True, exist_ok=True)
    scene = make_scene()
    me = [sys.executable, str(pathlib.Path(__file__).resolve())]
    if not (WORK / "mitsuba_reference.npy").exists():
        subprocess.run([*me, "--reference"], check=True)
    if not (WORK / "raycube_reference.npy").exists():
        np.save(WORK / "raycube_reference.npy", raycube_reference(scene))
    theirs, ours = np.load(WORK / "mitsuba_reference.npy"), np.load(WORK / "raycube_reference.npy")
    listed = [b for triple in TRIPLES for b in triple]
    means = np.abs(theirs.mean((0, 1)) / ours[:, :, listed].mean((0, 1)) - 1)
    data = {
        "scene": scene.facts(),
        "agreement_mean_worst": float(means.max()),
        "agreement_rms": median_error(theirs, ours[:, :, listed]),
        "crop": CROP,
        "reference_spp": REFERENCE_SPP,
        "raycube": [],
        "mitsuba": [],
        "failed": {},
    }
    if (
        data["agreement_mean_worst"] > 3e-3
    ):  # the noise of both means over the middle is below 1e-3: more is another scene
        raise SystemExit(
            f"mitsuba: the converged images differ by {data['agreement_mean_worst']:.2%} in a band's mean: not the "
            f"same scene"
        )
    for samples, sky in RAYCUBE:
        point, cube = raycube_time(scene, samples, sky, launcher)
        data["raycube"].append(
            {
                **point,
                "error": median_error(cube[:, :, TIMED], ours[:, :, TIMED]),
                "error_360": median_error(cube, ours),
            }
        )
        print("raycube", data["raycube"][-1], flush=True)
    if earlier:
        data["mitsuba"], data["failed"] = earlier["mitsuba"], earlier["failed"]
        return data
    for variant, (_, _, _, counts) in VARIANTS.items():
        run = subprocess.run(
            [*launcher, *me, "--time", variant, *map(str, counts)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        if run.returncode:
            data["failed"][variant] = (run.stderr.strip().splitlines() or [f"status {run.returncode}"])[-1]
            print(f"mitsuba: {variant} does not run: {data['failed'][variant]}", flush=True)
        for line in run.stdout.splitlines():
            if not line.startswith("{"):
                continue
            point = json.loads(line)
            image, bands = np.load(WORK / f"{variant}_{point['spp']}.npy"), point.pop("bands")
            shown = [i for i, b in enumerate(bands) if b in listed]
            point["error"] = median_error(image[:, :, shown], theirs[:, :, [listed.index(bands[i]) for i in shown]])
            data["mitsuba"].append(point)
            print("mitsuba", point, flush=True)
    return data


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--launcher", default="", help="command put before every timed process")
    parser.add_argument("--figures", type=pathlib.Path, help="draw an earlier run's file anew")
    parser.add_argument(
        "--keep-mitsuba", action="store_true", help="time raycube alone; Mitsuba's times from build/bench/mitsuba.json"
    )
    parser.add_argument("--reference", action="store_true", help="only Mitsuba's converged render")
    parser.add_argument(
        "--time", nargs="+", metavar="VARIANT SPP", help="only the timed renders of one variant of Mitsuba"
    )
    options = parser.parse_args()
    if options.reference:
        return mitsuba_reference()
    if options.time:
        return mitsuba_time(options.time[0], [int(n) for n in options.time[1:]])
    stored = ROOT / "build/bench/mitsuba.json"
    earlier = json.loads(stored.read_text()) if options.keep_mitsuba else None
    data = (
        json.loads(options.figures.read_text()) if options.figures else measure(shlex.split(options.launcher), earlier)
    )
    mitsuba_report.compare(data)
    data["what_an_expert_would_use"] = mitsuba_report.what_an_expert_would_use(data)
    stored.write_text(json.dumps(data, indent=1) + "\n")
    mitsuba_report.draw_errors(data)
    mitsuba_report.draw_images(data)
    (ROOT / "build/bench/mitsuba.md").write_text(mitsuba_report.markdown(data))
    print(mitsuba_report.markdown(data))


if __name__ == "__main__":
    main()
