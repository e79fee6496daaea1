#!/usr/bin/python3
"""The kernels under oclgrind, a simulator of an OpenCL device that checks every access: reads and writes out of bounds,
data races between work-items and wrong calls of the API are faults. A cube of 4 x 2 pixels and a survey of 2 LIDAR
pulses, whose results are also those of the first OpenCL device. What is never written is found otherwise: with memory
filled with two patterns before each use, the device's results are the same bytes (oclgrind 21.10 reports vectors
written lane by lane as uninitialised, so its own check shows nothing). usage: oclgrind_test.py RAYCUBE"""

import csv
import pathlib
import shutil
import sys
import tempfile

import numpy
import patience
from driver import Program, envi, gate, pulse_and_receiver, record, scene

program = Program(sys.argv[1])
check = program.check
CHECKED = ["oclgrind", "--data-races", "--check-api", "--build-options", "-DRC_NO_PREFETCH"]
SURVEY = """format = 1
material = [ { name = "soil", reflectance = 0.30 }, { name = "leaf", reflectance = 0.45 } ]
plane = [
  { material = "soil", size_m = [40.0, 40.0] },
  { material = "leaf", position_m = [0.05, 0.0, 3.0], size_m = [0.1, 40.0] },
]
atmosphere = { model = "none" }
[[lidar]]
name = "survey"
position_m = [0.0, 0.0, 500.0]
prf_khz = 10.0
pulses = 2
""" + pulse_and_receiver("20e-6", divergence_mrad=0.5, fov_mrad=1.0) + gate(490.0, 510.0, subrays=64)

if not shutil.which("oclgrind"):
    print("oclgrind: SKIPPED: there is no oclgrind (ci/setup --full installs it)")
    sys.exit(77)


def checked(work, file):
    log = work / "log"
    done = patience.run(
        [*CHECKED, "--log", log, program.path, "render", file, "-o", work / "checked", "-q", "--overwrite"],
        capture_output=True,
        text=True,
    )
    faults = [line for line in log.read_text().splitlines() if line and not line.startswith("\t")]
    check(done.returncode == 0, done.stderr[:2000])
    check(not faults, log.read_text()[:3000])
    return work / "checked"


def results(folder):
    """Radiance of a cube; photons in the gate of each pulse, which are expected ones: the counts are drawn from
    them."""
    if (folder / "pulses.csv").exists():
        with open(folder / "pulses.csv", newline="") as file:
            return numpy.array([float(row["photons_in_gate"]) for row in csv.DictReader(file)])
    return envi(folder, "radiance")[1].astype(float)


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    cube = scene(work, "cube.toml", pixels=4, lines=2, grid=2, air='{ aod_550 = 0.1, model = "clear_sky" }')
    survey = work / "survey.toml"
    survey.write_text(SURVEY)
    for file, out in ((cube, "camera"), (survey, "survey")):
        digests = set()
        for fill in ("0", "85", "255"):  # what malloc hands out, the buffers of a CPU device included
            program.run("render", file, "-o", work / "plain", "-q", "--overwrite", env={"MALLOC_PERTURB_": fill})
            digests.add(record(work / "plain" / out)["digest"])
        check(len(digests) == 1, digests)
        here, there = results(work / "plain" / out), results(checked(work, file) / out)
        # oclgrind's fma rounds twice: 1e-5 of the largest value covers sums of 16 terms.
        check(
            here.shape == there.shape and numpy.abs(here - there).max() <= 1e-5 * numpy.abs(here).max(),
            numpy.abs(here - there).max(),
            numpy.abs(here).max(),
        )
print(f"oclgrind: {program.checks} checks")
