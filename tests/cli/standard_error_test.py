#!/usr/bin/python3
"""The standard error that a file asks for: standard_error.img per band, the worst band and the mask of what did not
converge as truth.

Strips of 0.10, 0.45 and 0.80 whose edges halve two columns of pixels, 6 x 6 samples: of the four interleaved parts two
see 2/3 of one strip and two 1/3, each D / 6 from the whole where D is the strips' difference, so that the error is
sqrt(4 (D / 6)^2) / sqrt(4 x 3) = D / (6 sqrt 3) if the parts were independent. Of grids 0.85 of that is stated
(docs/accuracy.md); elsewhere it is 0. usage: standard_error_test.py RAYCUBE"""

import pathlib
import sys
import tempfile

import numpy
from driver import Program, envi, header_of, record, scene

program = Program(sys.argv[1])
check = program.check
STATED = 0.85  # of independent parts' error
EDGES = (6, 16)  # columns of 23 that lie 5 m from the middle


def rendered(work, choice, head=""):
    file = scene(
        work,
        f"{choice}.toml",
        head=head,
        pixels=23,
        grid=6,
        instrument=f'standard_error = "{choice}"' if choice != "off" else "",
    )
    program.run("render", file, "-o", work / "out", "-q", "--overwrite")
    return work / "out/camera"


def layers(folder):
    header, truth = envi(folder, "truth")
    return {name.partition(" [")[0]: truth[..., i] for i, name in enumerate(header["band names"])}


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    folder = rendered(work, "bands")
    radiance, (header, error) = envi(folder, "radiance")[1].astype(float), envi(folder, "standard_error")
    check(error.shape == radiance.shape, error.shape)
    check(header["wavelength"] == header_of(folder / "radiance.hdr")["wavelength"], header)
    expected = numpy.zeros_like(radiance)
    for column in EDGES:
        step = numpy.abs(radiance[:, column + 1] - radiance[:, column - 1])
        expected[:, column] = STATED * step / (6 * numpy.sqrt(3))
    check((expected[:, EDGES[0]] > 0).all(), "no edge where one should be")
    # fp32 sums of four parts: some roundings of the pixel's radiance.
    off = numpy.abs(error - expected).max() / radiance.max()
    check(off < 1e-6, off)

    truth = layers(folder)
    worst = (expected / radiance.mean((0, 1))).max(-1)
    check(
        numpy.allclose(truth["standard_error"], worst, rtol=0, atol=1e-5),
        numpy.abs(truth["standard_error"] - worst).max(),
    )
    check(
        (truth["not_converged"] == (worst > 0.01)).all() and truth["not_converged"].sum() == 2 * radiance.shape[0],
        truth["not_converged"].sum(),
    )
    files = [file["path"] if isinstance(file, dict) else file for file in record(folder)["files"]]
    check(any("standard_error.img" in str(file) for file in files), files)

    converged = layers(rendered(work, "worst", head="tolerance = 0.2"))
    left = sorted(path.name for path in (work / "out/camera").glob("standard_error*"))
    check(not left, "of the replaced run", left)
    check((converged["standard_error"] == truth["standard_error"]).all(), "the tolerance changes the error")
    check(worst.max() < 0.2 and (converged["not_converged"] == 0).all(), worst.max())
    check("standard_error" not in layers(rendered(work, "off")), "layers that nobody asked for")

print(f"{program.checks} checks hold")
