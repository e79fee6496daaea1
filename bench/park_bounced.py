#!/usr/bin/env python3
"""What light between surfaces costs: the shipped park's 360 bands with as many surfaces as the plan chooses, against
light scattered once (bounces = 0), both at 3 % achieved: bench/park_bounced.py [--pairs N]

Both sides are planned and rendered at tolerances around 3 %. Achieved error of each: rms over 2048 pixels, picked by
their own hash, of the difference from a converged render of the same light (two seeds, 576 samples and rays a pixel),
over the band's mean, of the worst band; the reference's own error is taken off. Time: run.json's stages and writing
(no load, air or plan), the median of the pairs, at 3 % achieved by a straight line in the logarithms of both. At equal
samples: both with the samples and rays into the sky that the bounced side's plan chose at 3 %.
Writes build/bench/park_bounced.json and .md. `ci/bench park_bounced`; 30 minutes.
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import time_to_tolerance as peers  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build/bench/park_bounced"
PROGRAM = ROOT / "build/raycube"
SIDES = {"once": "bounces = 0\n", "bounced": 'bounces = "auto"\n'}
TOLERANCES = (0.03, 0.045, 0.06)
AIM = 0.03


def written(name, light, tolerance, samples="", directions=""):
    """The park with other light, tolerance, samples and rays into the sky; the planner's where none are given."""
    text = (WORK / "scene/park.toml").read_text()
    text = re.sub(r"(?m)^tolerance = .*$", f"tolerance = {tolerance}\n{light}{directions}", text)
    head, rest = text.split('name = "spectir"\n', 1)
    out = WORK / "scene" / f"{name}.toml"
    out.write_text(f'{head}name = "spectir"\n{samples}{rest}')
    return out


def render(file, *more):
    """run.json and the cube, [pixel][band]."""
    subprocess.run(
        [PROGRAM, "render", file, "--instrument", "spectir", "-o", WORK / "out", "--overwrite", "-q", "-q", *more],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    record = json.loads((WORK / "out/spectir/run.json").read_text())
    return record, np.memmap(WORK / "out/spectir/radiance.img", "<f4", "r").reshape(-1, record["image"]["bands"])


def converged(side, light):
    """Pixels, their radiance, and what is left in it by band; kept from run to run."""
    kept = WORK / f"converged_{side}.npz"
    if kept.exists():
        return tuple(np.load(kept)[name] for name in ("chosen", "mean", "own"))
    samples, directions = peers.REFERENCE
    file = written("converged", light, peers.REFERENCE_TOLERANCE, samples + "\n", f"sky_directions = {directions}\n")
    cubes, chosen = [], None
    for seed in peers.SEEDS:
        _, cube = render(file, "--seed", str(seed))
        if chosen is None:
            chosen = np.sort(np.random.default_rng(18).permutation(len(cube))[: peers.PIXELS])
        cubes.append(np.array(cube[chosen], float))
    mean, own = 0.5 * (cubes[0] + cubes[1]), np.sqrt(np.mean((0.5 * (cubes[0] - cubes[1])) ** 2, 0))
    np.savez(kept, chosen=chosen, mean=mean, own=own)
    return chosen, mean, own


def seconds_at_aim(points):
    """Straight in the logarithms between the points on both sides of the aim, or past the nearest two."""
    points = sorted(points, key=lambda p: p["achieved"])
    errors, times = (np.log([p[name] for p in points]) for name in ("achieved", "seconds"))
    first = int(np.clip(np.searchsorted(errors, np.log(AIM)) - 1, 0, len(errors) - 2))
    slope = (times[first + 1] - times[first]) / (errors[first + 1] - errors[first])
    return float(np.exp(times[first] + slope * (np.log(AIM) - errors[first])))


def chosen_by(record):
    """What the plan of a run chose."""
    plan = record["plan"]
    cost = {name: round(plan["planner"]["cost"][name]) for name in ("samples", "sky_rays")}
    cost["paths"] = plan["sky"]["paths"]
    return {**cost, "levels": plan["bounces"]["levels"] if "bounces" in plan else 0}


def measure(pairs):
    if not (WORK / "scene/park.toml").exists():
        subprocess.run(["/usr/bin/python3", ROOT / "scenes/park/generate.py", WORK / "scene"], check=True)
    truth = {side: converged(side, light) for side, light in SIDES.items()}
    points, equal = {side: [] for side in SIDES}, {side: [] for side in SIDES}
    levels = None
    for tolerance in TOLERANCES:
        files = {side: written(side, light, tolerance) for side, light in SIDES.items()}
        errors, took, plans = {}, {side: [] for side in SIDES}, {}
        for side, file in files.items():  # not counted: kernels, pages of files
            record, cube = render(file)
            errors[side], plans[side] = peers.achieved(cube, *truth[side]), chosen_by(record)
        for pair in range(pairs):
            for side in sorted(files, reverse=pair % 2 == 0):
                took[side].append(peers.seconds(render(files[side])[0]))
        for side in SIDES:
            point = {"tolerance": tolerance, "achieved": errors[side], "seconds": statistics.median(took[side])}
            points[side].append({**point, "samples": plans[side]["samples"], "sky": plans[side]["sky_rays"],
                                 "paths": plans[side]["paths"]})
            print(side, points[side][-1], flush=True)
        if tolerance == AIM:
            levels = plans["bounced"]["levels"]
    chosen = next(p for p in points["bounced"] if p["tolerance"] == AIM)
    files = {
        side: written(f"{side}_equal", light, AIM, f"samples = {{ lattice = {chosen['samples']} }}\n",
                      f"sky_directions = {chosen['sky']}\n")
        for side, light in SIDES.items()
    }
    for pair in range(pairs + 1):
        for side in sorted(files, reverse=pair % 2 == 0):
            took = peers.seconds(render(files[side])[0])
            if pair:
                equal[side].append(took)
    ratios = [b / o for b, o in zip(equal["bounced"], equal["once"])]
    times = {side: seconds_at_aim(points[side]) for side in SIDES}
    known = {side: float(np.max(truth[side][2] / truth[side][1].mean(0))) for side in SIDES}
    keys = {
        "park_bounced_vs_direct_time": times["bounced"] / times["once"],
        "park_bounced_vs_direct_time_goal": 3.0,
        "park_bounced_vs_direct_time_goal_is": "at most",
        "park_bounced_vs_direct_time_equal_samples": statistics.median(ratios),
        "park_bounced_levels": levels,
        "park_bounced_s": times["bounced"],
        "park_direct_s": times["once"],
    }
    return {"keys": keys, "points": points, "known": known, "equal_range": [min(ratios), max(ratios)], "pairs": pairs}


def markdown(data):
    keys = data["keys"]
    lines = [
        "| light | tolerance asked | samples, rays into the sky, paths | achieved, worst band | seconds |",
        "|---|---|---|---|---|",
    ]
    names = {"once": "scattered once", "bounced": f"by {keys['park_bounced_levels']} surfaces more"}
    for side, points in data["points"].items():
        for p in points:
            lines.append(
                f"| {names[side]} | {p['tolerance']:.1%} | {p['samples']}, {p['sky']}, {p['paths']} | "
                f"{p['achieved']:.2%} | {p['seconds']:.2f} |"
            )
    low, high = data["equal_range"]
    lines += [
        "",
        f"`park_bounced_vs_direct_time` = {keys['park_bounced_vs_direct_time']:.2f} (at most 3): "
        f"{keys['park_bounced_s']:.2f} s over {keys['park_direct_s']:.2f} s at 3 % achieved. At equal samples "
        f"{keys['park_bounced_vs_direct_time_equal_samples']:.2f} [{low:.2f} .. {high:.2f}], "
        f"{data['pairs']} pair{'s' * (data['pairs'] > 1)}. "
        f"The references err by {max(data['known'].values()):.2%} themselves, which is taken off.",
        "",
    ]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=9)
    data = measure(parser.parse_args().pairs)
    (ROOT / "build/bench/park_bounced.json").write_text(json.dumps(data, indent=1) + "\n")
    (ROOT / "build/bench/park_bounced.md").write_text(markdown(data))
    print(markdown(data))


if __name__ == "__main__":
    main()
