#!/usr/bin/env python3
"""Files that another program cuts while the pictures of a LIDAR run are drawn: an error that names the file, where a
mapped file would end the interpreter. usage: cut_files_test.py PLOTS"""

import os
import pathlib
import sys
import tempfile

import numpy

sys.path.insert(0, sys.argv[1])
import lidar_pictures

kRows, kBytes = 1000, 12


def rows_of(path, offset):
    """Rows of three floats each, behind a head of `offset` bytes."""
    numbers = numpy.arange(3 * kRows, dtype="<f4").reshape(kRows, 3)
    path.write_bytes(b"\0" * offset + numbers.tobytes())
    return numbers, lidar_pictures.Rows(str(path), numpy.dtype(("<f4", 3)), offset, kRows)


with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "rows.bin"
    for offset in (0, 375):
        for at_once in (1, 100, 1 << 24):
            lidar_pictures.Rows.AT_ONCE = at_once
            numbers, rows = rows_of(path, offset)
            for which in (slice(None), slice(0, 800), slice(3, 900, 7), slice(0, 0), 0, kRows - 1):
                assert numpy.array_equal(rows[which], numbers[which]), (offset, at_once, which)
            left = offset + kRows * kBytes - 1
            os.truncate(path, left)
            for which in (slice(None), kRows - 1):
                try:
                    rows[which]
                    assert False, "a file that was cut is taken as whole"
                except SystemExit as end:
                    says = f"{path}: was cut while it was read: {left + 1} bytes expected (found {left})"
                    assert str(end) == says, (str(end), says)
print("cut files: rows are what lies there, or one error")
