"""What the tests of `raycube analyze` share: cubes written by hand, the verbs' numbers and maps, closeness."""

import json

import numpy as np

from driver import envi

CODES = {"u1": 1, "i2": 2, "i4": 3, "f4": 4, "f8": 5, "u2": 12, ">f4": 4, ">i2": 2}


def write_cube(path, cube, interleave="bip", dtype="f4", **header):
    """ENVI pair of [line][sample][band]."""
    axes = {"bip": (0, 1, 2), "bil": (0, 2, 1), "bsq": (2, 0, 1)}[interleave]
    np.ascontiguousarray(cube.transpose(axes)).astype(dtype).tofile(path)
    lines, samples, bands = cube.shape
    text = f"ENVI\nsamples = {samples}\nlines = {lines}\nbands = {bands}\ndata type = {CODES[dtype]}\n"
    text += f"interleave = {interleave}\nbyte order = {int(dtype.startswith('>'))}\n"
    for key, value in header.items():
        text += f"{key.replace('_', ' ')} = {value}\n"
    path.with_suffix(".hdr").write_text(text)
    return path


class Analysis:
    """The verbs of one program."""

    def __init__(self, program):
        self.program = program

    def close(self, a, b, relative=1e-9, what=""):
        """To `relative` of the largest; where all are zero, zero; not a number in the same places."""
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        self.program.check(a.shape == b.shape, what, a.shape, b.shape)
        off = np.nanmax(np.abs(a - b)) / (np.nanmax(np.abs(b)) or 1)
        self.program.check(off <= relative and np.array_equal(np.isnan(a), np.isnan(b)), what, off)

    def run(self, folder, verb, cube, *more, picture=False):
        """The verb's numbers; its maps lie in folder/verb."""
        quiet = [] if picture else ["--no-picture"]
        done = self.program.run("analyze", verb, cube, "-o", folder / verb, "--overwrite", "--json", *quiet, *more)
        return json.loads(done.stdout)


def layers(folder, verb):
    """[layer][line][sample] of a map, as doubles."""
    return np.moveaxis(envi(folder / verb, verb)[1].astype("f8"), 2, 0)


def values(numbers):
    """What JSON calls null is not a number."""
    return np.array([np.nan if v is None else v for v in numbers], dtype=float)
