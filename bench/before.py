#!/usr/bin/env python3
"""The program as it is against the program of a named commit: bench/before.py COMMIT [--pairs N] [--limit PERCENT]
[--to-tolerance]

Builds COMMIT in a git worktree of its own (build/before/HASH, kept), then renders the park (256 x 256 pixels, 360
bands) and a LIDAR survey over it with both programs in turn: old, new, old again, new first in every other round, so
that what drifts falls on both. Seconds are those of run.json's stages. Of each stage: the median over the rounds of new
/ old, and of old / old how far it strays (half the width of its middle 80 %): what a difference must exceed to be one.
Each program's first run, which builds its air and kernels, is not counted; products must be the same bytes or it says
so. Then what each takes to 3 % as its own planner chooses (bench/time_to_tolerance.py), with keys of build/bench.json.
Status 1 when a stage's median is beyond the limit and beyond that spread, or one of the two misses 3 % on the park. The
machine should be otherwise idle.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys

import time_to_tolerance

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "build/before"
# Names as a reader of the bench knows them, and the stages of run.json they are made of.
STAGES = {
    "park": {
        "primary": ["trace_primary"],
        "sun": ["trace_sun"],
        "sky": ["trace_sky"],
        "shade": ["shade"],
        "bands": ["bake", "resolve", "collect", "integrate"],
        "whole park": None,
    },
    "survey": {"lidar_shots": ["pulses"], "whole survey": None},
}
# Of a whole run: what is built once and kept is not part of it.
LEFT_OUT = ("load", "atmosphere")
SMALL_S = 0.02  # a stage below this is not judged: the clock and the scheduler are what is seen


def shell(*command, **more):
    return subprocess.run([str(part) for part in command], check=True, **more)


def built(commit):
    """The program of a commit, from a worktree of its own."""
    revision = subprocess.run(
        ["git", "rev-parse", "--verify", commit + "^{commit}"], cwd=ROOT, capture_output=True, text=True
    )
    if revision.returncode:
        sys.exit(f"bench: no such commit: {commit}")
    revision = revision.stdout.strip()
    tree = WORK / revision[:12]
    if not tree.exists():
        shell("git", "worktree", "prune", cwd=ROOT)
        shell("git", "worktree", "add", "--quiet", "--detach", tree, revision, cwd=ROOT)
    print(f"bench: building {revision[:12]} in {tree}", flush=True)
    quiet = dict(cwd=tree, stdout=subprocess.DEVNULL)
    shell("cmake", "--preset", "release", **quiet)
    shell("cmake", "--build", "--preset", "release", "--target", "raycube", **quiet)
    return tree / "build/raycube"


def changed(path, target, changes):
    text = path.read_text()
    for old, new in changes:
        text, count = re.subn(old, new, text)
        if count == 0:
            sys.exit(f"bench: {path} has no '{old}'; is this the shipped park?")
    target.write_text(text)
    return target


def scenes():
    """The park with fewer pixels and the survey with fewer pulses, beside the files they name."""
    folder = WORK / "scene"
    if not (folder / "park.toml").exists():
        shell("/usr/bin/python3", ROOT / "bench/opaque_park.py", folder, stdout=subprocess.DEVNULL)
    park = changed(
        folder / "park.toml",
        folder / "park_before.toml",
        [
            (r"pixels = 320", "pixels = 256"),
            (r"lines = 320", "lines = 256"),
            (r"sky_directions = \d+", "sky_directions = 12"),
        ],
    )
    survey = changed(
        folder / "park_survey.toml", folder / "survey_before.toml", [(r"(?m)^pulses = \d+", "pulses = 20000")]
    )
    return {"park": [park, "--instrument", "spectir"], "survey": [survey]}


def run(program, name, job, out):
    """run.json of one render."""
    file, *more = job
    file = time_to_tolerance.once_scattered(program, file)
    shell(program, "render", file, *more, "-o", out / name, "--overwrite", "-q", "-q", stdout=subprocess.DEVNULL)
    found = list((out / name).glob("*/run.json"))
    return json.loads(found[0].read_text())


def seconds(record, stages):
    parts = record["stage_s"]
    return (
        sum(value for stage, value in parts.items() if stage not in LEFT_OUT)
        if stages is None
        else sum(parts.get(stage, 0) for stage in stages)
    )


def measured(old, new, jobs, pairs):
    """Of each name: ratios new / old and old / old, and the old program's median seconds."""
    figures = {}
    for job_name, job in jobs.items():
        digests = {}
        for side, program in (("old", old), ("new", new)):  # not counted: air, kernels, pages of files
            digests[side] = run(program, job_name, job, WORK / "out" / side)["digest"]
        print(
            f"bench: {job_name}: "
            + (
                "the same bytes"
                if digests["old"] == digests["new"]
                else "NOT the same bytes: radiance or waveforms have moved"
            ),
            flush=True,
        )
        for pair in range(pairs):
            order = ["old", "new", "again"] if pair % 2 == 0 else ["new", "old", "again"]
            records = {side: run(new if side == "new" else old, job_name, job, WORK / "out" / side) for side in order}
            for name, stages in STAGES[job_name].items():
                here = figures.setdefault(name, {"ratio": [], "itself": [], "old_s": []})
                took = {side: seconds(record, stages) for side, record in records.items()}
                if took["old"] <= 0:
                    sys.exit(f"bench: run.json of the old program has none of the stages {stages}")
                here["ratio"].append(took["new"] / took["old"])
                here["itself"].append(took["again"] / took["old"])
                here["old_s"].append(took["old"])
            print(f"bench: {job_name}: pair {pair + 1} of {pairs}", flush=True)
    return figures


def spread(ratios):
    """Half the width of the middle 80 %."""
    if len(ratios) < 2:
        return float("inf")
    low, *_, high = statistics.quantiles(ratios, n=10, method="inclusive")
    return 0.5 * (high - low)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("commit")
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--limit", type=float, default=3.0, help="percent")
    parser.add_argument("--to-tolerance", action="store_true", help="only what each takes to 3 %%")
    options = parser.parse_args()
    if options.pairs < 1:
        sys.exit("bench: --pairs takes a number from 1")
    WORK.mkdir(parents=True, exist_ok=True)
    old, new = built(options.commit), ROOT / "build/raycube"
    jobs = scenes()
    figures = {} if options.to_tolerance else measured(old, new, jobs, options.pairs)
    print(
        f"\n| stage | old, s | new / old, median of {options.pairs} | old / old | strays by | |\n"
        f"|---|---|---|---|---|---|"
    )
    beyond = []
    for name, figure in figures.items():
        took, ratio, itself = (statistics.median(figure[key]) for key in ("old_s", "ratio", "itself"))
        figure["spread"] = spread(figure["itself"])
        judged = took >= SMALL_S
        within = abs(ratio - 1) <= max(options.limit / 100, figure["spread"])
        if judged and not within:
            beyond.append(name)
        verdict = "within" if within else "BEYOND" if judged else "too short to judge"
        print(f"| {name} | {took:.3g} | {ratio:.3f} | {itself:.3f} | {100 * figure['spread']:.1f} % | {verdict} |")
    keys = time_to_tolerance.measured(
        {"old": old, "new": new}, WORK / "scene/park_before.toml", WORK, min(options.pairs, 9)
    )
    stored = ROOT / "build/bench.json"
    earlier = json.loads(stored.read_text()) if stored.exists() else {}
    stored.write_text(json.dumps({**earlier, **keys}, indent=2) + "\n")
    beyond += [
        f"the park's error of the {side} program"
        for side in ("old", "new")
        if keys[f"park_achieved_{side}"] > time_to_tolerance.TOLERANCE
    ]
    report = WORK / "before.json"
    report.write_text(
        json.dumps(
            {
                "commit": options.commit,
                "pairs": options.pairs,
                "limit_percent": options.limit,
                "figures": figures,
                **keys,
            },
            indent=1,
        )
        + "\n"
    )
    print(f"bench: {report.relative_to(ROOT)}, load {os.getloadavg()[0]:.1f}")
    if beyond:
        sys.exit(f"bench: beyond {options.limit:g} % and beyond the old program's own spread: {', '.join(beyond)}")


if __name__ == "__main__":
    main()
