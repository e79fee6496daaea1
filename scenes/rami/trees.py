"""Trees of stands for scenes/rami/generate.py: corners of triangles, m, the stem's foot at the origin. Every tree is
made of triangles that share no corners, [triangle][3][3]."""

import numpy as np


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def frame(axis):
    """Two unit vectors across unit axes [n][3]."""
    other = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    along = unit(np.cross(axis, other))
    return along, np.cross(axis, along)


def cones(foot, tip, radius, sides):
    """Side faces of cones from feet [n][3] to tips, open below."""
    along, across = frame(unit(tip - foot))
    turn = np.arange(sides + 1) * 2 * np.pi / sides
    ring = foot[:, None] + radius[:, None, None] * (
        np.cos(turn)[:, None] * along[:, None] + np.sin(turn)[:, None] * across[:, None]
    )
    tips = np.broadcast_to(tip[:, None], (len(foot), sides, 3))
    return np.stack([ring[:, :-1], ring[:, 1:], tips], 2).reshape(-1, 3, 3)


def fans(corners):
    """Triangles of convex polygons [n][k][3]."""
    k = corners.shape[1]
    return np.stack([corners[:, [0, i, i + 1]] for i in range(1, k - 1)], 1).reshape(-1, 3, 3)


def birch(rng, hexagons, normals, angles):
    """Stem, branches and leaves of one birch: an egg of leaves of 3.5 cm radius about branches that go up."""
    height, base, wide = rng.uniform(18, 24), rng.uniform(5, 8), rng.uniform(1.9, 2.5)
    branches = 60
    level = base + (height - base) * rng.random(branches) ** 0.9 * 0.93
    turn = rng.uniform(0, 2 * np.pi, branches)
    reach = wide * np.sin(np.pi * ((level - base) / (height - base)) ** 0.6 * 0.94 + 0.1)
    foot = np.column_stack([np.zeros(branches), np.zeros(branches), level - 0.5])
    tip = np.column_stack([reach * np.cos(turn), reach * np.sin(turn), level + 0.6 * reach])
    stem = cones(np.zeros((1, 3)), np.array([[0.0, 0.0, height]]), np.array([0.011 * height / 2]), 12)
    wood = np.concatenate([stem, cones(foot, tip, 0.008 + 0.01 * reach, 5)])
    leaves = round(rng.uniform(7000, 10000))
    on = rng.integers(0, branches, leaves)
    place = foot[on] + (tip - foot)[on] * rng.uniform(0.25, 1.05, (leaves, 1))
    place += rng.normal(0, 0.3, (leaves, 3)) * [1, 1, 0.8]
    place[:, 2] -= np.abs(rng.normal(0, 0.35, leaves))  # twigs hang
    return wood, fans(hexagons(rng, place, normals(rng, angles, leaves), 0.035))


def conifer(rng):
    """Stem, branches and needles of one spruce: whorls of branches, and about each bundles of needles of 6 cm by
    6 mm, flat, as broad as twenty needles side by side."""
    height, base, wide = rng.uniform(15, 20), rng.uniform(1.5, 3.5), rng.uniform(1.5, 2.0)
    whorls, in_whorl = 28, 6
    level = np.repeat(base + (height - base) * (np.arange(whorls) / whorls) ** 0.9, in_whorl)
    turn = np.tile(np.arange(in_whorl) * 2 * np.pi / in_whorl, whorls) + np.repeat(rng.uniform(0, 6, whorls), in_whorl)
    reach = wide * (1 - (level - base) / (height - base)) ** 0.8 + 0.15
    branches = len(level)
    foot = np.column_stack([np.zeros(branches), np.zeros(branches), level])
    tip = np.column_stack([reach * np.cos(turn), reach * np.sin(turn), level - 0.25 * reach])
    stem = cones(np.zeros((1, 3)), np.array([[0.0, 0.0, height]]), np.array([0.012 * height / 2]), 12)
    wood = np.concatenate([stem, cones(foot, tip, 0.006 + 0.008 * reach, 4)])
    bundles = round(rng.uniform(50000, 70000))
    on = rng.choice(branches, bundles, p=reach / reach.sum())
    axis = unit(tip - foot)[on]
    out = rng.uniform(0.1, 1.0, (bundles, 1))
    beside = np.column_stack([-axis[:, 1], axis[:, 0], np.zeros(bundles)])
    place = foot[on] + (tip - foot)[on] * out + unit(beside) * rng.uniform(-1, 1, (bundles, 1)) * (
        0.35 * np.sqrt(reach[on])[:, None] * (1.1 - out)  # a branch with its twigs is a flat wedge
    )
    along, across = frame(axis)
    around = rng.uniform(0, 2 * np.pi, (bundles, 1))
    point = unit(0.7 * axis + np.cos(around) * along + np.sin(around) * across)
    flat, _ = frame(point)
    half, long = 0.003 * flat, 0.06 * point
    return wood, fans(np.stack([place - half, place + half, place + half + long, place - half + long], 1))
