"""The points of a LAS file compressed without loss. Usage: las_to_laz.py LAS LAZ

Needs laspy and lazrs (PyPI). Every field, extra byte and VLR is kept, waveform packets stay where the points say. Parts
of half a million points: memory does not grow with the file.
"""

import sys

import laspy

POINTS_AT_A_TIME = 500_000
BACKEND = laspy.LazBackend.LazrsParallel  # the same bytes for any number of threads: chunks are compressed alone

las, laz = sys.argv[1:]
with laspy.open(las) as reader, open(laz, "wb") as out:
    with laspy.open(
        out, "w", header=reader.header, do_compress=True, laz_backend=BACKEND, closefd=False
    ) as writer:
        for points in reader.chunk_iterator(POINTS_AT_A_TIME):
            writer.write_points(points)
