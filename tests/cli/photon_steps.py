"""Steps of photons in a turbid medium, a layer of leaves so small that it has none: for tests of canopies."""

import numpy


def leaf_normals(way, rng):
    """Of leaves of all orientations those that light on each way meets: as often as they face it."""
    normal, left = numpy.empty_like(way), numpy.arange(len(way))
    while len(left):
        drawn = rng.normal(size=(len(left), 3))
        drawn /= numpy.linalg.norm(drawn, axis=1, keepdims=True)
        taken = rng.random(len(left)) < numpy.abs((drawn * way[left]).sum(1))
        normal[left[taken]] = drawn[taken]
        left = left[~taken]
    return normal


def turned_by_cosine(axis, rng):
    """Ways by the cosine about unit axes."""
    u, v = rng.random((2, len(axis)))
    beside = numpy.cross(axis, numpy.where(numpy.abs(axis[:, 2:]) < 0.9, [[0.0, 0, 1]], [[1.0, 0, 0]]))
    beside /= numpy.linalg.norm(beside, axis=1, keepdims=True)
    r, turn = numpy.sqrt(u)[:, None], 2 * numpy.pi * v[:, None]
    across = numpy.cross(axis, beside)
    return r * (numpy.cos(turn) * beside + numpy.sin(turn) * across) + numpy.sqrt(1 - u)[:, None] * axis
