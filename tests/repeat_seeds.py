#!/usr/bin/env python3
"""Repeats tests of chance with other seeds, and tells how many standard deviations their limits stand away.

Tests draw from fixed seeds: each passes always or fails always, and a limit that is too near shows only when draws
change. Here each repetition sets RAYCUBE_TEST_SEED to 1, 2, .. (from --first on), from which tests/support/seeds.h and
tests/cli/driver.py make other seeds, and RAYCUBE_TEST_FIGURES to a file that takes a line for each check of a figure
that chance moves. A row for each such check: of its cases (passes of a loop) the one whose limit is nearest, its
figure's mean and standard deviation over the repetitions, its limits on average, the mean of what is left to the limit
over the standard deviation of that, and the median of this over all cases. Fifty repetitions know a distance of 4 to
0.4. "still" figures are those that no seed moves.

usage: tests/repeat_seeds.py [--build FOLDER] [--count N] [--first N] NAME[:CASES] ..
NAME is a test as ctest lists it, CASES a pattern of doctest's: those of its test cases alone."""

import argparse
import collections
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time


def commands_of(build):
    """{name: (command, environment, working folder)} of all tests."""
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True)
    out = {}
    for test in json.loads(listed.stdout)["tests"]:
        of = {one["name"]: one["value"] for one in test.get("properties", [])}
        environment = dict(pair.split("=", 1) for pair in of.get("ENVIRONMENT", []))
        environment.pop("RAYCUBE_PROGRAM_LOG", None)  # of an ordinary run's test `programs`
        out[test["name"]] = (test.get("command"), environment, of["WORKING_DIRECTORY"])
    return out


def figures_of(file):
    """{(place, what, number of the case): (figure, low, high)} of one repetition."""
    seen, out = collections.Counter(), {}
    for line in file.read_text().splitlines() if file.exists() else ():
        place, what, *numbers = line.split("\t")
        place = pathlib.Path(place).name
        out[place, what, seen[place, what]] = tuple(map(float, numbers))
        seen[place, what] += 1
    return out


def distance(samples):
    """Standard deviations between a figure and its nearer limit, whatever of the two chance moves."""
    least = math.inf
    for left in ([high - figure for figure, _, high in samples], [figure - low for figure, low, _ in samples]):
        spread = statistics.stdev(left) if math.isfinite(sum(left)) else 0
        if spread > 1e-12 * max(abs(figure) for figure, _, _ in samples):
            least = min(least, statistics.mean(left) / spread)
    return least


def rows_of(repetitions):
    """(place, what, cases, nearest distance, its samples, median distance) of each check, by place."""
    cases = collections.defaultdict(list)
    for key in {key: None for one in repetitions for key in one}:
        samples = [one[key] for one in repetitions if key in one]
        if len(samples) > 1:
            cases[key[:2]].append((distance(samples), samples))
    for (place, what), found in cases.items():
        nearest, samples = min(found, key=lambda one: one[0])
        yield place, what, len(found), nearest, samples, statistics.median(one[0] for one in found)


def in_words(distance):
    return "still" if math.isinf(distance) else format(distance, ".1f")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="the build's folder")
    parser.add_argument("--count", type=int, default=50, help="repetitions of each test")
    parser.add_argument("--first", type=int, default=1, help="RAYCUBE_TEST_SEED of the first")
    parser.add_argument("names", nargs="+", metavar="NAME[:CASES]")
    given = parser.parse_args()
    commands, failed = commands_of(given.build), False
    for name in given.names:
        test, _, cases = name.partition(":")
        if test not in commands or not commands[test][0]:
            sys.exit(f"no test '{test}' in {given.build}")
        command, environment, folder = commands[test]
        command = [*command, f"--test-case={cases}"] if cases else command
        repetitions, bad, begun = [], [], time.monotonic()
        for number in range(given.first, given.first + given.count):
            with tempfile.TemporaryDirectory() as scratch:
                figures = pathlib.Path(scratch) / "figures"
                own = {"RAYCUBE_TEST_SEED": str(number), "RAYCUBE_TEST_FIGURES": str(figures), "LC_ALL": "C.UTF-8"}
                done = subprocess.run(
                    command, env={**os.environ, **environment, **own}, cwd=folder, capture_output=True, text=True
                )
                repetitions.append(figures_of(figures))
            if done.returncode != 0:
                bad.append(number)
                said = (done.stdout + done.stderr)[-3000:]
                print(f"{name}, repetition {number}:\n{said}", file=sys.stderr, flush=True)
        seconds, failed = (time.monotonic() - begun) / given.count, failed or bad
        told = f"; failed: {bad}" if bad else ""
        print(f"{name}: {given.count - len(bad)} of {given.count} passed, {seconds:.1f} s each{told}")
        for place, what, count, nearest, samples, median in rows_of(repetitions):
            figure, low, high = zip(*samples)
            print(
                f"| {place} | {what} | {count} | {statistics.mean(figure):.4g} | {statistics.stdev(figure):.2g} | "
                f"{statistics.mean(low):.4g} to {statistics.mean(high):.4g} | "
                f"{in_words(nearest)} | {in_words(median)} |",
                flush=True,
            )
    return 1 if failed else 0


sys.exit(main())
