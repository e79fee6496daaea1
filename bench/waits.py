#!/usr/bin/env python3
"""What a user waits for in five everyday tasks: bench/waits.py [--before COMMIT] [--runs N]

starter    one cube of `raycube new`'s scene
study      fifteen cubes of 64 x 64 pixels of 1.5 m and 200 bands, 32 targets of 0.3 m whose curve changes from one to
           the next; the first one's plan is kept for the others where the program can
park       the 360-band cube of the shipped park
emit       276 bands of 60 m pixels over 10 000 trees, as EMIT sees them from 400 km (its bands inside the curves)
preview    a first picture of the park

Samples and sky directions are the planner's; air and kernels are cached by a run that is not counted. Written to
build/bench/waits.json, flat: `wait_TASK_s`, the least of N runs from the command to its end; processor seconds
`plan_processor_TASK_s` and `render_processor_TASK_s` of one cube, the least of N; and `plan_over_allowance_TASK`,
planning over the larger of a quarter of the render and 0.3 s, whose bar is 1. With --before also `wait_TASK_before_s`
of that commit's program (bench/before.py builds it), of one run, over a park of opaque leaves. The machine should be
otherwise idle.
"""

import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import time

import numpy as np

import before

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "build/bench/waits"
FIGURES = ROOT / "build/bench/waits.json"
ALLOWANCE_OF_RENDER, LEAST_ALLOWANCE_S = 0.25, 0.3
RENDERS_OF_STUDY = 15
SUN = "time = { sun = { zenith_deg = 35.0, azimuth_deg = 150.0, day_of_year = 264 } }\n"


def shell(*command):
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def opened(file, **settings):
    """Samples and sky directions are the planner's, and the given keys of the file's first lines are so."""
    text = re.sub(r"(?m)^(samples|sky_directions) = .*\n", "", file.read_text())
    for key, value in settings.items():
        text = re.sub(rf"(?m)^{key} = .*\n", "", text).replace("format = 1\n", f"format = 1\n{key} = {value}\n", 1)
    out = file.with_name(file.stem + "_open.toml")
    out.write_text(text)
    return out


def starter(program):
    folder = WORK / "starter"
    if not folder.exists():
        shell(program, "new", folder)
    return opened(folder / "starter.toml")


def park(old):
    """The shipped park; for programs that know no leaves made of their content the one of opaque leaves."""
    folder = WORK / ("park_opaque" if old else "park")
    if not (folder / "park.toml").exists():
        shell("/usr/bin/python3", ROOT / ("bench/opaque_park.py" if old else "scenes/park/generate.py"), folder)
    return opened(folder / "park.toml", tolerance=0.03)


def study(step):
    """Targets of a twenty-fifth of a pixel's area on grass, soil and a wood's edge; `step` turns their curve."""
    folder = WORK / "study"
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(32)
    places = rng.uniform(-44, 44, (32, 2))
    targets = "".join(
        f'[[plane]]\nname = "target {k}"\nmaterial = "target"\nposition_m = [{x:.3f}, {y:.3f}, 0.05]\n'
        f"size_m = [0.3, 0.3]\nyaw_deg = {yaw:.1f}\n"
        for k, ((x, y), yaw) in enumerate(zip(places, rng.uniform(0, 90, 32)))
    )
    boxes = "".join(
        f'[[box]]\nname = "block {k}"\nmaterial = "soil"\nposition_m = [{x:.3f}, {y:.3f}, 0.0]\n'
        f"size_m = [3.0, 2.0, {height:.2f}]\nyaw_deg = {yaw:.1f}\n"
        for k, ((x, y), height, yaw) in enumerate(
            zip(rng.uniform(-44, 44, (24, 2)), rng.uniform(1, 5, 24), rng.uniform(0, 90, 24))
        )
    )
    file = folder / f"study_{step:02d}.toml"
    file.write_text(
        "format = 1\ntolerance = 0.03\n"
        f'material = [{{ name = "grass", file = "{ROOT}/scenes/park/spectra/lawn_grass.csv" }}, '
        f'{{ name = "soil", file = "{ROOT}/scenes/park/spectra/loam.csv" }}, '
        f'{{ name = "target", reflectance = {0.1 + 0.05 * step:.2f} }}]\n'
        'atmosphere = { model = "clear_sky", aod_550 = 0.12 }\n' + SUN + "[[plane]]\n"
        'name = "field"\nmaterial = "grass"\nsize_m = [140.0, 140.0]\n' + boxes + targets + "[[instrument]]\n"
        'name = "imager"\nkind = "framing"\npixels = 64\nlines = 64\naltitude_agl_m = 1500.0\ngsd_m = 1.5\n'
        "bands = { first_nm = 420.0, step_nm = 10.0, count = 200, fwhm_nm = 11.0 }\n"
    )
    return file


def emit():
    """Ten thousand trees of the park's kinds on six by six kilometres of grass."""
    folder = WORK / "emit"
    folder.mkdir(parents=True, exist_ok=True)
    trees, rng = WORK / "park", np.random.default_rng(10000)
    scatter = ""
    for kind, material in (("maple", "maple_leaf"), ("spruce", "spruce_needles")):
        places, yaw, scale = rng.uniform(-3000, 3000, (5000, 2)), rng.uniform(0, 360, 5000), rng.uniform(0.8, 1.3, 5000)
        rows = np.column_stack([places, np.zeros(5000), yaw, scale])
        np.savetxt(
            folder / f"{kind}.csv", rows, fmt="%.3f", delimiter=",", header="x_m,y_m,z_m,yaw_deg,scale", comments=""
        )
        shutil.copy(trees / f"{kind}.obj", folder)
        scatter += (
            f'[[mesh]]\nname = "{kind}"\nfile = "{kind}.obj"\nmaterials = {{ leaf = "{material}", bark = "bark" }}\n'
            f'[[scatter]]\nmesh = "{kind}"\npositions = "{kind}.csv"\n'
        )
    spectra = ROOT / "scenes/park/spectra"
    materials = ", ".join(
        f'{{ name = "{name}", file = "{spectra}/{curve}.csv" }}'
        for name, curve in (
            ("grass", "dry_grass"),
            ("bark", "bark"),
            ("maple_leaf", "maple_leaf"),
            ("spruce_needles", "spruce_needles"),
        )
    )
    file = folder / "emit.toml"
    file.write_text(
        f"format = 1\ntolerance = 0.03\nmaterial = [{materials}]\n"
        'atmosphere = { model = "layered", profile = "midlatitude_summer", aod_550 = 0.12 }\n' + SUN + "[[plane]]\n"
        'name = "field"\nmaterial = "grass"\nsize_m = [9000.0, 9000.0]\n' + scatter + "[[instrument]]\n"
        'name = "emit"\nkind = "pushbroom"\npixels = 100\nlines = 100\naltitude_agl_m = 400000.0\ngsd_m = 60.0\n'
        "bands = { first_nm = 411.0, step_nm = 7.4, count = 276, fwhm_nm = 8.5 }\n"
    )
    return file


class Waits:
    def __init__(self, program, runs, old=False):
        self.program, self.runs, self.old, self.out = program, runs, old, WORK / "out"

    def render(self, file, instrument, *more):
        """Seconds from the command to its end, and run.json."""
        start = time.monotonic()
        shell(
            self.program, "render", file, "--instrument", instrument, "-o", self.out, "--overwrite", "-q", "-q", *more
        )
        return time.monotonic() - start, json.loads((self.out / instrument / "run.json").read_text())

    def cube(self, file, instrument):
        self.render(file, instrument)
        done = [self.render(file, instrument) for _ in range(self.runs)]
        spent = [record.get("processor_s", {}) for _, record in done]
        return min(seconds for seconds, _ in done), {
            part: min(s[part] for s in spent) for part in ("plan", "render") if all(part in s for s in spent)
        }

    def study(self):
        """Fifteen renders, one after the other; the least of the runs. Later ones take the first one's plan."""
        files = [study(step) for step in range(RENDERS_OF_STUDY)]
        self.render(files[0], "imager")
        takes_plan, took = self.can_take_plan(files), []
        for _ in range(self.runs):
            start = time.monotonic()
            if takes_plan:
                shell(self.program, "plan", files[0], "-o", WORK / "study/plan.json", "--overwrite")
            for file in files:
                self.render(file, "imager", *(("--plan", WORK / "study/plan.json") if takes_plan else ()))
            took.append(time.monotonic() - start)
        return min(took)

    def can_take_plan(self, files):
        """Whether a plan of one scene is a first guess for the next."""
        try:
            shell(self.program, "plan", files[0], "-o", WORK / "study/plan.json", "--overwrite")
            self.render(files[1], "imager", "--plan", WORK / "study/plan.json")
        except subprocess.CalledProcessError:
            return False
        return True

    def preview(self, file):
        """Until there is a picture; None: this program has no previews."""
        took, picture = [], WORK / "preview.png"
        for _ in range(self.runs + 1):
            picture.unlink(missing_ok=True)
            start = time.monotonic()
            command = [self.program, "preview", file, "--instrument", "spectir", "-o", picture]
            viewing = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while not picture.exists() and viewing.poll() is None:
                time.sleep(0.01)
            took.append(time.monotonic() - start)
            if viewing.wait():
                return None
        return min(took[1:])

    def all(self):
        """Name: seconds and processor seconds by part."""
        cubes = {
            "starter": (starter(self.program), "camera"),
            "park": (park(self.old), "spectir"),
            "emit": (emit(), "emit"),
            "one_of_study": (study(0), "imager"),
        }
        found = {name: self.cube(*cube) for name, cube in cubes.items()}
        found["study"] = self.study(), found["one_of_study"][1]
        if (seconds := self.preview(cubes["park"][0])) is not None:
            found["preview"] = seconds, {}
        return found


def figures_of(found, old):
    keys = {}
    for name, (seconds, spent) in found.items():
        if name == "one_of_study":
            continue
        keys[f"wait_{name}_s"] = seconds
        if name in old:
            keys[f"wait_{name}_before_s"] = old[name][0]
        if spent:
            allowed = max(ALLOWANCE_OF_RENDER * spent["render"], LEAST_ALLOWANCE_S)
            keys[f"plan_processor_{name}_s"], keys[f"render_processor_{name}_s"] = spent["plan"], spent["render"]
            key = f"plan_over_allowance_{name}"
            keys.update({key: spent["plan"] / allowed, key + "_goal": 1, key + "_goal_is": "at most"})
    return keys


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", metavar="COMMIT")
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    found = Waits(ROOT / "build/raycube", options.runs).all()
    old = Waits(before.built(options.before), 1, old=True).all() if options.before else {}
    keys = figures_of(found, old)
    if options.before:
        keys["waits_before"] = options.before
    FIGURES.write_text(json.dumps(keys, indent=2) + "\n")
    for key, value in keys.items():
        if not key.endswith(("_goal", "_goal_is", "waits_before")):
            print(f"bench: {key} {value:.3g}")


if __name__ == "__main__":
    sys.exit(main())
