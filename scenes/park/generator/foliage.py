"""Leaves as two triangles each, with leaf angles from measured-like distributions."""

import numpy as np


def inclined_normals(rng, count, alpha, beta):
    """Upward leaf normals with inclination theta = 90 deg * Beta(alpha, beta) (Goel & Strebel 1984: two-parameter beta
    distribution of leaf angles), azimuth uniform. Planophile: mean below 45 deg; erectophile: above."""
    theta = 0.5 * np.pi * rng.beta(alpha, beta, count)
    phi = rng.uniform(0, 2 * np.pi, count)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def kite_leaves(rng, base, outward, normal, length_m, width_m, fold):
    """Kites folded along the midrib: base, right, tip, left. `outward` is the direction the midrib should point to; it
    is laid into the leaf plane. Arrays of n; fold is the rise of the margins over half the width."""
    midrib = outward - normal * np.sum(outward * normal, axis=1, keepdims=True)
    midrib += 1e-6
    midrib /= np.linalg.norm(midrib, axis=1, keepdims=True)
    side = np.cross(midrib, normal)
    size = rng.lognormal(0, 0.16, len(base))[:, None]
    half, rise = 0.5 * width_m * size, 0.5 * width_m * fold * size
    middle = base + midrib * (0.42 * length_m * size) + normal * rise
    tip = base + midrib * (length_m * size)
    vertices = np.stack([base, middle + side * half, tip, middle - side * half], axis=1).reshape(-1, 3)
    k = 4 * np.arange(len(base))[:, None]
    return vertices, np.concatenate([k + [0, 1, 2], k + [0, 2, 3]], axis=1).reshape(-1, 3)


def sprays(base, along, normal, length_m, width_m):
    """Flat rectangles of needles from base along a shoot: n of them, two triangles each."""
    side = np.cross(along, normal)
    side *= 0.5 * np.asarray(width_m)[:, None] / np.linalg.norm(side, axis=1, keepdims=True)
    tip = base + along * np.asarray(length_m)[:, None]
    vertices = np.stack([base - 0.6 * side, base + 0.6 * side, tip + side, tip - side], axis=1).reshape(-1, 3)
    k = 4 * np.arange(len(base))[:, None]
    return vertices, np.concatenate([k + [0, 1, 2], k + [0, 2, 3]], axis=1).reshape(-1, 3)


def on_twigs(rng, skeleton, thickest_m, count, twig_m, spread):
    """Leaf bases around the young wood: every leaf sits on a short twig that leaves its node sideways and outwards.
    Returns base points and the outward directions of the leaves."""
    young = np.nonzero((skeleton.radius > 0) & (skeleton.radius <= thickest_m))[0]
    young = young[young > 0]
    heading = skeleton.heading()
    twigs = np.repeat(young, max(1, int(round(count / 7.0 / len(young)))))
    direction = heading[twigs] + spread * rng.normal(0, 1, (len(twigs), 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    start = skeleton.position[twigs] - heading[twigs] * rng.uniform(0, 0.3, (len(twigs), 1))
    pick = np.sort(rng.integers(0, len(twigs), count))
    along = twig_m * rng.uniform(0.15, 1.0, (count, 1))
    sideways = rng.normal(0, 1, (count, 3))
    outward = 0.7 * direction[pick] + 0.7 * sideways / np.linalg.norm(sideways, axis=1, keepdims=True)
    base = start[pick] + direction[pick] * along + 0.03 * outward
    base[:, 2] -= 0.15 * along[:, 0] ** 2 / twig_m  # twigs bend under their leaves
    return base, outward
