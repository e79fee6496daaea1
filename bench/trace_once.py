#!/usr/bin/env python3
"""raycube against what an expert would write in an afternoon: bench/trace_once.py [--pairs N] [--raycube FILE]
[--reference-samples N]

Run by build/peers/venv/bin/python (`ci/setup --peers` makes it; `ci/bench trace_once` calls both). The script's idea:
direct light is linear in reflectance, so rays are traced once for all bands. Embree under Dr.Jit traces each sample, a
ray to the sun and a ray into the sky for every k-th sample, sums of what both give are kept for each pixel and
material, and one matrix product makes 360 bands of them. raycube renders the same scene (bench/peer_scene.py) with the
same number of samples.

Error: rms over the middle of the image of the difference from one converged render of the script's kind, over the
band's mean; of bands the worst. Both sides must agree with it in each band's mean before anything is timed. Time: the
script's tracing, product and writing; raycube's stages and writing, from the end of its plan on, and with its plan;
load and compilation on neither side. Both curves error (time) are read in log-log at the errors of TARGETS, in each
round of alternating runs. Writes build/bench/trace_once.json and trace_once.md and adds its keys to build/bench.json.
"""

import argparse
import concurrent.futures
import itertools
import json
import math
import os
import pathlib
import statistics
import subprocess
import time

try:
    import numpy as np

    import mitsuba_cube
    import peer_scene

    mi = mitsuba_cube.start_mitsuba("llvm_ad_mono")
    import drjit as dr
except ImportError as missing:
    raise SystemExit(
        f"trace_once: {missing}: the script needs Mitsuba 3 and Dr.Jit; get them by `ci/setup --peers` and run this "
        f"by build/peers/venv/bin/python"
    )

ROOT = peer_scene.ROOT
WORK = ROOT / "build/bench/trace_once"
PIXELS, TREES, THREADS = 256, 240, 2
CROP = 96  # pixels of a side of the middle of the image, where errors are taken
LOW = (PIXELS - CROP) // 2
SCRIPT = list(itertools.product((49, 64, 121), (1, 2, 4)))  # samples a pixel; a sky ray for every so many of them
RAYCUBE = [(64, 20), (64, 32), (121, 40), (121, 64)]  # samples a pixel; sky directions
TARGETS = (0.0200, 0.0135)  # worst-band errors at which times are compared
BEYOND = 1.1  # a curve is read past its last setting up to this factor of error
FAR_APART = 1.2  # two settings tell a curve's slope when their errors differ by this factor
AGREE = 3e-3
REFERENCE_PASS = 256  # samples of one pass of the reference
CHUNK = 512  # pixels whose bands one thread makes and writes at a time: they stay in its cache
OFFSET_M = 2e-3  # rays start this far from a surface: four times what fp32 rounds off 610 m of way


# --- the script ------------------------------------------------------------------------------------------------------
class World:
    """Every placed triangle as one mesh of Embree, with tables of materials and normals by triangle."""

    def __init__(self, scene):
        self.names = scene.materials()
        vertices, faces, materials, first = [], [], [], 0
        for mesh in scene.ground + peer_scene.merged_trees(scene):
            v, f = peer_scene.read_ply(mesh.file)
            vertices.append(v)
            faces.append((f + first).astype(np.uint32))
            materials.append(np.full(len(f), self.names.index(mesh.material), np.uint32))
            first += len(v)
        v, f = np.concatenate(vertices), np.concatenate(faces)
        a, b, c = (v[f[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
        mesh = mi.Mesh("all", len(v), len(f))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"], parameters["faces"] = mi.Float(v.ravel()), mi.UInt32(f.ravel())
        parameters.update()
        self.embree = mi.load_dict({"type": "scene", "all": mesh})
        self.normal = [mi.Float(np.ascontiguousarray(normal[:, i])) for i in range(3)]
        self.material = mi.UInt32(np.concatenate(materials))
        sun, sky, reflectance = peer_scene.band_means(scene)
        colour = np.array([reflectance[name] for name in self.names])
        self.table = np.concatenate([colour * sun / np.pi, colour * sky]).astype(np.float32)
        zenith, azimuth = np.radians([peer_scene.SUN_ZENITH_DEG, peer_scene.SUN_AZIMUTH_DEG])
        towards = [np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)]
        self.sun = mi.Vector3f(*map(float, towards))


def sampler_of(samples):
    sampler = mi.load_dict({"type": "multijitter", "sample_count": samples})
    if sampler.sample_count() != samples:
        raise SystemExit(f"trace_once: Mitsuba's sampler takes {sampler.sample_count()} samples for {samples}")
    return sampler


def trace(world, sampler, every, seed, pixels):
    """Sums over the samples of each of `pixels` by material: the sun's cosine where it is seen, then what share of the
    sky is: [pixel][2 materials]."""
    samples, count, materials = sampler.sample_count(), len(pixels), len(world.names)
    sampler.set_samples_per_wavefront(samples)
    sampler.seed(dr.opaque(mi.UInt32, seed), count * samples)
    place = dr.arange(mi.UInt32, count * samples) // samples
    pixel, inside = dr.gather(mi.UInt32, pixels, place), sampler.next_2d()
    scale, half = peer_scene.GSD_M / peer_scene.CAMERA_HEIGHT_M, 0.5 * PIXELS
    across = scale * (mi.Float(pixel % PIXELS) + inside.x - half)
    along = scale * (half - mi.Float(pixel // PIXELS) - inside.y)
    ray = mi.Ray3f(mi.Point3f(0, 0, peer_scene.CAMERA_HEIGHT_M), dr.normalize(mi.Vector3f(across, along, -1)))
    hit = world.embree.ray_intersect_preliminary(ray, coherent=True)
    met = hit.is_valid()
    normal = mi.Normal3f(*(dr.gather(mi.Float, axis, hit.prim_index, met) for axis in world.normal))
    normal = dr.mulsign(normal, -dr.dot(normal, ray.d))
    point = ray(hit.t) + OFFSET_M * normal
    slot = place * (2 * materials) + dr.gather(mi.UInt32, world.material, hit.prim_index, met)
    cosine, sums = dr.dot(normal, world.sun), dr.zeros(mi.Float, count * 2 * materials)
    lit = met & (cosine > 0)
    lit &= ~world.embree.ray_test(mi.Ray3f(point, world.sun), coherent=True, active=lit)
    dr.scatter_add(sums, cosine / samples, slot, lit)
    draw, rays = sampler.next_2d(), -(-samples // every)
    if every > 1:  # the others' lanes would be traced empty: those that go on are put side by side
        dr.eval(sums, slot, met, point, normal, draw)
        lane = dr.arange(mi.UInt32, count * rays)
        lane = lane // rays * samples + lane % rays * every
        slot, met = dr.gather(mi.UInt32, slot, lane), dr.gather(mi.Bool, met, lane)
        point, normal, draw = (type(v)(*(dr.gather(mi.Float, axis, lane) for axis in v)) for v in (point, normal, draw))
    upwards = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(draw))
    seen = met & (upwards.z > 0)
    seen &= ~world.embree.ray_test(mi.Ray3f(point, upwards), coherent=False, active=seen)
    dr.scatter_add(sums, mi.Float(1 / rays), slot + materials, seen)
    return np.array(sums).reshape(count, 2 * materials)


def write_cube(world, sums, bands_nm, file):
    """Radiance (W m-2 sr-1 um-1) of all bands by one matrix product, as an ENVI cube: fp32, interleaved by pixel."""
    lines = ["ENVI", f"samples = {PIXELS}", f"lines = {PIXELS}", f"bands = {len(bands_nm)}", "header offset = 0"]
    lines += ["file type = ENVI Standard", "data type = 4", "interleave = bip", "byte order = 0"]
    lines += ["wavelength units = Nanometers", f"wavelength = {{{', '.join(f'{c:.6g}' for c in bands_nm[:, 0])}}}"]
    file.with_suffix(".hdr").write_text("\n".join(lines) + "\n")
    with open(file, "wb") as data, concurrent.futures.ThreadPoolExecutor(THREADS) as pool:

        def chunk(first):
            # Debian's numpy has a plain BLAS: einsum's own loops take half the time of its product.
            bands = np.einsum("pm,mb->pb", sums[first : first + CHUNK], world.table)
            os.pwrite(data.fileno(), bands, first * 4 * len(bands_nm))

        list(pool.map(chunk, range(0, len(sums), CHUNK)))


# --- both sides ------------------------------------------------------------------------------------------------------
class Script:
    def __init__(self, scene):
        self.scene, self.world = scene, World(scene)
        self.all_pixels = dr.arange(mi.UInt32, PIXELS * PIXELS)
        self.file, self.seed = WORK / "script.img", 1
        dr.eval(self.all_pixels)

    def run(self, samples, every):
        """Seconds of one cube, which then lies in self.file."""
        sampler, self.seed = sampler_of(samples), self.seed + 1
        self.file.unlink(missing_ok=True)
        began = time.perf_counter()
        sums = trace(self.world, sampler, every, self.seed, self.all_pixels)
        write_cube(self.world, sums, self.scene.bands_nm, self.file)
        return time.perf_counter() - began

    def reference(self, samples):
        """Converged middle of the image, and the rms that is left in it by band."""
        halves, sampler = [], sampler_of(REFERENCE_PASS)
        line = np.arange(LOW, LOW + CROP)
        pixels = mi.UInt32((line[:, None] * PIXELS + line).ravel().astype(np.uint32))
        passes = max(1, samples // (2 * REFERENCE_PASS))
        for half in range(2):
            sums = sum(
                trace(self.world, sampler, 1, 10000 + half * passes + p, pixels).astype(float) for p in range(passes)
            )
            halves.append(sums / passes @ self.world.table)
        mean = 0.5 * (halves[0] + halves[1])
        return mean, np.sqrt(np.mean((0.5 * (halves[0] - halves[1])) ** 2, 0))


def run_raycube(scene, program, samples, directions):
    """Seconds from the end of the plan to the last byte of the cube, and of the plan; the cube lies in WORK/raycube."""
    file = peer_scene.write_simulation(scene, "trace_once", f"lattice = {samples}", directions)
    out = WORK / "raycube"
    subprocess.run(
        [program, "render", file, "-o", out, "--overwrite", "--threads", str(THREADS), "-q", "-q"],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    record = json.loads((out / "camera/run.json").read_text())
    took = record["stage_s"]  # stages that go side by side count once
    not_rendering = ("load", "atmosphere", "kernels", "plan")
    return record["total_s"] - sum(took.get(stage, 0) for stage in not_rendering), took["plan"]


def read_cube(file):
    """The pixels of the reference: [pixel][band]."""
    middle = np.fromfile(file, "<f4").reshape(PIXELS, PIXELS, -1)[LOW : LOW + CROP, LOW : LOW + CROP]
    return middle.reshape(CROP * CROP, -1).astype(float)


def worst_error(cube, reference, own):
    """Worst band's rms over pixels of what a cube errs, over the band's mean; the reference's own rms taken off."""
    square = np.maximum(np.mean((cube - reference) ** 2, 0) - own**2, 0)
    return float(np.max(np.sqrt(square) / reference.mean(0)))


def worst_mean(cube, reference):
    return float(np.max(np.abs(cube.mean(0) / reference.mean(0) - 1)))


# --- curves ----------------------------------------------------------------------------------------------------------
def seconds_at(target, points):
    """Time at which points (error, seconds) reach `target`, straight in log-log between two of them, the least that
    any two give; past the last by a factor BEYOND of error, along the line from the next point that is FAR_APART from
    it in error. Both sides are read so."""
    points = sorted(p for p in points if not any(q[0] <= p[0] and q[1] < p[1] for q in points))

    def between(low, high):
        part = math.log(target / low[0]) / math.log(high[0] / low[0])
        return low[1] * (high[1] / low[1]) ** part

    found = [between(a, b) for a, b in itertools.combinations(points, 2) if a[0] <= target <= b[0] and a[0] < b[0]]
    if found:
        return min(found)
    for end, others in ((points[0], points[1:]), (points[-1], points[-2::-1])):
        apart = [p for p in others if max(end[0] / p[0], p[0] / end[0]) >= FAR_APART]
        if apart and max(end[0] / target, target / end[0]) <= BEYOND:
            return between(end, apart[0])
    raise SystemExit(
        f"trace_once: errors of {points[0][0]:.2%} to {points[-1][0]:.2%} do not reach {target:.2%}: choose other "
        f"settings in bench/trace_once.py"
    )


def useful(errors, seconds):
    """Settings that could lie on the curve at a target: within 5 % of the least time that all together give."""
    points = [(errors[s], seconds[s]) for s in errors]
    kept = set()
    for target in TARGETS:
        best = seconds_at(target, points)
        for pair in itertools.combinations(errors, 2):
            try:
                if seconds_at(target, [(errors[s], seconds[s]) for s in pair]) <= 1.05 * best:
                    kept.update(pair)
            except SystemExit:
                continue
    return [s for s in errors if s in kept]


def spread(key, values, goal=None):
    keys = {key: statistics.median(values), key + "_min": min(values), key + "_max": max(values)}
    keys[key + "_runs"] = len(values)
    if goal is not None:
        keys.update({key + "_goal": goal, key + "_goal_is": "at least"})
    return keys


# --- measurement -----------------------------------------------------------------------------------------------------
def reference_of(script, samples):
    file = WORK / f"reference_{samples}.npz"
    if not file.exists():
        mean, own = script.reference(samples)
        np.savez(file, mean=mean, own=own)
    kept = np.load(file)
    print(f"trace_once: reference known to {np.max(kept['own'] / kept['mean'].mean(0)):.2%}", flush=True)
    return kept["mean"], kept["own"]


def checked(side, setting, cube, reference, own):
    """A side's error, once its bands' means agree with the reference."""
    off = worst_mean(cube, reference)
    if off > AGREE:
        raise SystemExit(
            f"trace_once: {side} {setting}: a band's mean is {off:.2%} off the reference, more than {AGREE:.1%}: not "
            f"the same scene, nothing is timed"
        )
    return worst_error(cube, reference, own), off


def measure(options):
    WORK.mkdir(parents=True, exist_ok=True)
    scene = peer_scene.make(ROOT / "build/bench/peer", PIXELS, TREES)
    script = Script(scene)
    reference, own = reference_of(script, options.reference_samples)
    errors, first_s, means = {"script": {}, "raycube": {}}, {}, []
    for setting in SCRIPT:  # the first run compiles; errors are of both
        script.run(*setting)
        squares = [checked("script", setting, read_cube(script.file), reference, own)]
        first_s[setting] = script.run(*setting)
        squares.append(checked("script", setting, read_cube(script.file), reference, own))
        errors["script"][setting] = math.sqrt(statistics.mean(error**2 for error, _ in squares))
        means += [off for _, off in squares]
        print(f"trace_once: script {setting}: {errors['script'][setting]:.2%}, {first_s[setting]:.2f} s", flush=True)
    for setting in RAYCUBE:
        run_raycube(scene, options.raycube, *setting)
        cube = read_cube(WORK / "raycube/camera/radiance.img")
        errors["raycube"][setting], off = checked("raycube", setting, cube, reference, own)
        means.append(off)
        print(f"trace_once: raycube {setting}: {errors['raycube'][setting]:.2%}", flush=True)
    errors["script"] = {s: errors["script"][s] for s in useful(errors["script"], first_s)}
    rounds = []
    turns = list(itertools.zip_longest(errors["script"], errors["raycube"]))
    for number in range(options.pairs):
        seconds = {"script": {}, "raycube": {}}
        for mine, ours in turns:
            if mine:
                seconds["script"][mine] = script.run(*mine)
            if ours:
                seconds["raycube"][ours] = run_raycube(scene, options.raycube, *ours)
        rounds.append(seconds)
        print(f"trace_once: round {number + 1} of {options.pairs}", flush=True)
    return scene, errors, rounds, max(means)


def figures_of(errors, rounds, agreement):
    """Flat keys: ratios of each round at each target, the worse target's reported, and each setting's medians."""
    keys = {"trace_once_agreement_mean_worst": agreement}
    ratios = {}
    for name, plan in (("render_ratio", 0), ("ratio", 1)):
        for target in TARGETS:
            ratios[name, target] = []
            for seconds in rounds:
                script = seconds_at(target, [(errors["script"][s], t) for s, t in seconds["script"].items()])
                ours = [(errors["raycube"][s], t[0] + plan * t[1]) for s, t in seconds["raycube"].items()]
                ratios[name, target].append(script / seconds_at(target, ours))
            keys.update(spread(f"trace_once_{name}_at_{100 * target:.2f}".replace(".", "_"), ratios[name, target]))
        worse = min(TARGETS, key=lambda target: statistics.median(ratios[name, target]))
        keys.update(spread("trace_once_" + name, ratios[name, worse], 1.2 if plan == 0 else 0.9))
    return keys


def rows_of(errors, rounds):
    rows = []
    for setting, error in errors["script"].items():
        took = statistics.median(seconds["script"][setting] for seconds in rounds)
        rows.append({"side": "script", "samples": setting[0], "every": setting[1], "error": error, "seconds": took})
    for setting, error in errors["raycube"].items():
        took, plan = (statistics.median(seconds["raycube"][setting][i] for seconds in rounds) for i in range(2))
        rows.append({"side": "raycube", "samples": setting[0], "directions": setting[1], "error": error})
        rows[-1].update(seconds=took, plan_s=plan)
    return rows


def markdown(data):
    keys, facts = data["keys"], data["scene"]
    text = [
        f"{facts['triangles_placed'] / 1e6:.1f} M placed triangles, {THREADS} threads; medians of {data['pairs']} "
        f"rounds. Bands' means agree with the reference within {keys['trace_once_agreement_mean_worst']:.2%}.",
        "",
        "| | worst-band error | time, s | plan, s |",
        "|---|---|---|---|",
    ]
    for row in data["settings"]:
        if row["side"] == "script":
            name = f"trace once, {row['samples']} samples, a sky ray for every {row['every']}"
        else:
            name = f"raycube, {row['samples']} samples, {row['directions']} sky directions"
        plan = f"{row['plan_s']:.2f}" if "plan_s" in row else ""
        text.append(f"| {name} | {row['error']:.2%} | {row['seconds']:.2f} | {plan} |")
    text += ["", "| script's time over raycube's | median [lowest .. highest] |", "|---|---|"]
    for key in keys:
        if "ratio" in key and key + "_min" in keys:
            text.append(f"| `{key}` | {keys[key]:.2f} [{keys[key + '_min']:.2f} .. {keys[key + '_max']:.2f}] |")
    return "\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=9, help="rounds of alternating runs")
    parser.add_argument("--raycube", type=pathlib.Path, default=ROOT / "build/raycube")
    parser.add_argument("--reference-samples", type=int, default=4096, help="samples a pixel of the reference")
    options = parser.parse_args()
    if options.pairs < 1 or options.reference_samples < 2 * REFERENCE_PASS:
        parser.error(f"--pairs takes a number from 1, --reference-samples one from {2 * REFERENCE_PASS}")
    began = time.perf_counter()
    scene, errors, rounds, agreement = measure(options)
    data = {"scene": scene.facts(), "pairs": options.pairs, "keys": figures_of(errors, rounds, agreement)}
    data["settings"] = rows_of(errors, rounds)
    (ROOT / "build/bench/trace_once.json").write_text(json.dumps(data, indent=1) + "\n")
    text = markdown(data)
    (ROOT / "build/bench/trace_once.md").write_text(text)
    stored = ROOT / "build/bench.json"
    figures = json.loads(stored.read_text()) if stored.exists() else {}
    stored.write_text(json.dumps({**figures, **data["keys"]}, indent=2) + "\n")
    print(text + f"trace_once: {time.perf_counter() - began:.0f} s, load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
