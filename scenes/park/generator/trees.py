"""The tree species of the park: each returns (groups for write_obj, facts) in metres, foot at the origin, z up."""

import numpy as np

from .foliage import inclined_normals, kite_leaves, on_twigs, sprays
from .skeleton import Skeleton, colonise, perpendicular, tubes


def _facts(species, bark, leaves, crown_area_m2):
    """Numbers a reader wants: triangles, height, one-sided leaf area index over the crown's projected disc."""
    v, t = leaves
    area = 0.5 * np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1)
    radius = np.percentile(np.hypot(v[:, 0], v[:, 1]), 98)
    return {
        "species": species,
        "leaf_triangles": len(t),
        "bark_triangles": len(bark[1]),
        "height_m": round(float(v[:, 2].max()), 2),
        "crown_radius_m": round(float(radius), 2),
        "leaf_area_m2": round(float(area.sum()), 1),
        "crown_lai": round(float(area.sum() / (np.pi * radius**2 if crown_area_m2 is None else crown_area_m2)), 2),
    }


def _crown_cloud(rng, count, low_m, high_m, radius_at, hollow):
    """Attraction points in a body of revolution; `hollow` pushes them to the outside, where the light is."""
    points = np.empty((0, 3))
    widest = max(radius_at(t) for t in np.linspace(0, 1, 50))
    while len(points) < count:
        p = rng.uniform(-1, 1, (4 * count, 3)) * (widest, widest, 1)
        t = 0.5 * (p[:, 2] + 1)
        r = np.hypot(p[:, 0], p[:, 1]) / np.maximum([radius_at(v) for v in t], 1e-6)
        keep = (r < 1) & (rng.uniform(0, 1, len(p)) < (1 - hollow) + hollow * np.maximum(r, np.abs(2 * t - 1)) ** 2)
        p[:, 2] = low_m + t * (high_m - low_m)
        points = np.vstack([points, p[keep]])
    return points[:count]


def _broadleaf(
    rng, species, cloud, foot_m, step_m, foot_radius_m, leaf_count, leaf_m, width_m, twig_m, angles, kill, up
):
    skeleton = colonise(rng, cloud, foot_m, step_m, influence_m=12 * step_m, kill_m=kill * step_m, up=up)
    skeleton.set_radii(0.005, foot_radius_m, 2.4)
    bark = tubes(skeleton, 0.0045)
    base, outward = on_twigs(rng, skeleton, 0.014, leaf_count, twig_m, spread=0.8)
    normal = inclined_normals(rng, leaf_count, *angles)
    outward[:, 2] -= 0.25  # blades hang a little
    leaves = kite_leaves(rng, base, outward, normal, leaf_m, width_m, fold=0.18)
    return [("bark", *bark), ("leaf", *leaves)], _facts(species, bark, leaves, None)


def maple(seed):
    """Broad round crown, 14 m high: leaves of 13 cm, planophile (mean inclination 33 deg)."""
    rng = np.random.default_rng([seed, 11])
    lobes = rng.normal(0, 0.07, 3)

    def radius(t):
        return (
            4.75
            * (np.sin(np.pi * np.clip(0.09 + 0.9 * t, 0, 1)) ** 0.62)
            * (1.04 - 0.22 * t)
            * (1 + lobes[int(3 * min(t, 0.999))])
        )

    cloud = _crown_cloud(rng, 1150, 2.6, 13.4, radius, hollow=0.75)
    return _broadleaf(rng, "maple", cloud, 2.4, 0.34, 0.23, 20000, 0.132, 0.140, 0.34, (1.9, 3.3), kill=1.6, up=0.05)


def aspen(seed):
    """Slender poplar-like crown, 16 m high: leaves of 7.5 cm that hang and tremble (mean inclination 55 deg)."""
    rng = np.random.default_rng([seed, 12])

    def radius(t):
        return 2.15 * (np.sin(np.pi * np.clip(0.05 + 0.93 * t, 0, 1)) ** 0.7) * (1.12 - 0.35 * t)

    cloud = _crown_cloud(rng, 1000, 2.8, 16.0, radius, hollow=0.55)
    return _broadleaf(rng, "aspen", cloud, 11.0, 0.30, 0.14, 17000, 0.078, 0.074, 0.26, (3.2, 2.0), kill=1.6, up=0.30)


def shrub(seed):
    """Hazel-like bush, 2.6 m high, for the forest edge."""
    rng = np.random.default_rng([seed, 13])

    def radius(t):
        return 1.55 * np.sin(np.pi * np.clip(0.18 + 0.8 * t, 0, 1)) ** 0.6

    cloud = _crown_cloud(rng, 420, 0.25, 2.5, radius, hollow=0.4)
    return _broadleaf(rng, "shrub", cloud, 0.3, 0.16, 0.03, 5200, 0.085, 0.075, 0.2, (2.0, 2.6), kill=1.5, up=0.1)


def spruce(seed):
    """Cone of drooping whorls, 17 m high: flat sprays of needles on fishbone branchlets."""
    rng = np.random.default_rng([seed, 14])
    height, lowest = 17.0, 0.9
    nodes, parents = [(0.0, 0.0, -0.4)], [0]
    for z in np.arange(0.4, height, 0.4):
        nodes.append((0.015 * np.sin(0.9 * z), 0.015 * np.cos(0.7 * z), z))
        parents.append(len(nodes) - 2)
    trunk = len(nodes)
    base, along, roll, length, width = [], [], [], [], []
    z, turn = lowest, 0.0
    while z < height - 0.55:
        t = (z - lowest) / (height - lowest)
        reach = (3.0 * (1 - t) ** 0.85 + 0.05) * (0.55 + 0.45 * min(1.0, t / 0.06 + 0.4))
        whorl = int(rng.integers(5, 9))
        turn += rng.uniform(0.3, 0.9)
        for k in range(whorl):
            azimuth = turn + 2 * np.pi * k / whorl + rng.normal(0, 0.16)
            r = reach * rng.uniform(0.78, 1.10)
            rise = np.interp(t, [0, 0.5, 1], [-0.28, 0.02, 0.75]) + rng.normal(0, 0.06)
            out = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
            steps = max(3, int(r / 0.22))
            s = np.linspace(0, 1, steps + 1)
            # branch: leaves the trunk at `rise`, sags, and turns up at the tip
            path = (
                out * (r * s)[:, None] + np.array([0, 0, 1.0]) * (r * (rise * s - 0.30 * s**2 + 0.24 * s**4))[:, None]
            )
            path += np.array([0, 0, z + rng.normal(0, 0.06)])
            first = len(nodes)
            for i in range(1, steps + 1):
                nodes.append(tuple(path[i]))
                parents.append(min(trunk - 1, max(1, int(round(z / 0.4)))) if i == 1 else first + i - 2)
            for i in range(1, steps + 1):
                axis = path[i] - path[i - 1]
                axis /= np.linalg.norm(axis)
                side = np.cross(axis, (0, 0, 1.0))
                side /= np.linalg.norm(side)
                twig = (min(0.14, 0.3 * r) + 0.42 * r * 0.33 * (1.15 - s[i])) * rng.uniform(0.8, 1.2)
                for sign in (-1.0, 1.0):
                    d = (
                        axis * 0.62
                        + sign * side * 0.78
                        + np.array([0, 0, -0.16 - 0.10 * (1 - t)])
                        + rng.normal(0, 0.07, 3)
                    )
                    d /= np.linalg.norm(d)
                    for q in range(max(1, int(np.ceil(twig / 0.13)))):
                        base.append(path[i] - axis * rng.uniform(0, 0.2) + d * (0.13 * q))
                        along.append(d + rng.normal(0, 0.12, 3))
                        roll.append(rng.normal(0, 0.55))
                        length.append(0.135 * rng.uniform(0.85, 1.15))
                        width.append(0.058 * rng.uniform(0.8, 1.25))
                # the shoot itself carries needles too
                base.append(path[i - 1])
                along.append(axis)
                roll.append(rng.normal(0, 0.8))
                length.append(float(np.linalg.norm(path[i] - path[i - 1])))
                width.append(0.055)
        z += 0.30 * rng.uniform(0.85, 1.15) * (1.0 - 0.35 * t)
    for z in np.arange(height - 1.3, height, 0.05):  # the leader
        azimuth = rng.uniform(0, 2 * np.pi)
        base.append((0.0, 0.0, z))
        along.append(np.array([0.5 * np.cos(azimuth), 0.5 * np.sin(azimuth), 0.85]))
        roll.append(rng.normal(0, 0.8))
        length.append(0.05 + 0.10 * (height - z))
        width.append(0.05)
    skeleton = Skeleton(nodes, parents)
    skeleton.set_radii(0.006, 0.19, 2.4)
    skeleton.radius[trunk:] = np.maximum(skeleton.radius[trunk:], 0.010)
    bark = tubes(skeleton, 0.006)
    along = np.array(along)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    a, b = perpendicular(along)
    a, b = np.where(b[:, 2:3] < 0, -a, a), np.where(b[:, 2:3] < 0, -b, b)
    normal = b * np.cos(roll)[:, None] + a * np.sin(roll)[:, None]
    leaves = sprays(np.array(base), along, normal, length, width)
    return [("bark", *bark), ("leaf", *leaves)], _facts("spruce", bark, leaves, None)


SPECIES = {"maple": maple, "aspen": aspen, "spruce": spruce, "shrub": shrub}
