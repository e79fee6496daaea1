"""Branching skeletons: space colonisation for broad-leaved crowns, and tubes around any skeleton.

Space colonisation after Runions, Lane, Prusinkiewicz, "Modeling Trees with a Space Colonization Algorithm" (2007);
radii after the pipe model, r_parent^p = sum r_child^p (Murray/da Vinci family, p between 2 and 3).
"""

import numpy as np


class Skeleton:
    """Nodes with parents (parent[0] = 0 is the foot) and radii, metres."""

    def __init__(self, position, parent):
        self.position, self.parent = np.asarray(position, float), np.asarray(parent, int)
        self.radius = np.zeros(len(self.parent))

    def set_radii(self, tip_m, foot_m, power):
        """Pipe model from tips to foot, then stretched so that the foot has foot_m and the tips keep tip_m."""
        load = np.zeros(len(self.parent))
        for i in range(len(self.parent) - 1, 0, -1):  # children come after their parents
            if load[i] == 0:
                load[i] = 1.0
            load[self.parent[i]] += load[i]
        exponent = np.log(foot_m / tip_m) / np.log(max(load[0], 2.0))
        self.radius = tip_m * np.maximum(load, 1.0) ** min(exponent, 1.0 / power * 1.25)
        self.radius[0] = self.radius[1:].max()

    def heading(self):
        """Unit direction from each node's parent to the node."""
        d = self.position - self.position[self.parent]
        d[0] = (0, 0, 1)
        return d / np.linalg.norm(d, axis=1, keepdims=True)


def colonise(rng, attractors, foot_height_m, step_m, influence_m, kill_m, up=0.15, limit=4000):
    """Grows a skeleton from a straight trunk into a cloud of attraction points."""
    count = int(foot_height_m / step_m) + 1
    sway = np.cumsum(np.cumsum(rng.normal(0, 0.006, (count, 2)), axis=0), axis=0) * step_m  # a gently bent stem
    sway -= np.linspace(0, 1, count)[:, None] * sway[-1] * 0.7
    trunk = np.array([(sway[i, 0], sway[i, 1], i * step_m) for i in range(count)])
    trunk[0, :2] = 0
    trunk[0, 2] = -0.4  # rooted below the ground, so that slopes show no gap
    nodes, parents = list(trunk), [0] + list(range(count - 1))
    alive = np.ones(len(attractors), bool)
    nearest = np.zeros(len(attractors), int)
    distance = np.full(len(attractors), np.inf)
    fresh = list(range(count))
    while fresh and len(nodes) < limit:
        for start in range(0, len(fresh), 256):
            part = fresh[start : start + 256]
            d = np.linalg.norm(attractors[:, None, :] - np.array([nodes[i] for i in part])[None], axis=2)
            j = d.argmin(1)
            closer = d[np.arange(len(j)), j] < distance
            distance[closer], nearest[closer] = d[np.arange(len(j)), j][closer], np.array(part)[j[closer]]
        alive &= distance > kill_m
        reach = alive & (distance < influence_m)
        if not reach.any() and alive.any():  # the cloud is out of reach: let the closest point pull
            reach = alive & (distance <= distance[alive].min() + 1e-9)
        pull = {}
        for a in np.nonzero(reach)[0]:
            i = nearest[a]
            v = attractors[a] - nodes[i]
            pull[i] = pull.get(i, 0) + v / np.linalg.norm(v)
        fresh = []
        for i, v in pull.items():
            v = v / (np.linalg.norm(v) + 1e-9) + (0, 0, up) + rng.normal(0, 0.12, 3)
            nodes.append(nodes[i] + step_m * v / np.linalg.norm(v))
            parents.append(i)
            fresh.append(len(nodes) - 1)
    return Skeleton(nodes, parents)


def perpendicular(direction):
    """Two unit vectors that make a right-handed frame (a, b, direction)."""
    helper = np.where(np.abs(direction[:, 2:3]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    a = np.cross(helper, direction)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    return a, np.cross(direction, a)


def tubes(skeleton, thinnest_m):
    """Prisms around every segment thicker than thinnest_m: 9, 5 or 3 sides by radius. Outward counter-clockwise."""
    parent, radius = skeleton.parent, skeleton.radius
    # the thickest child continues its parent's tube, the others start with their own radius
    order = np.argsort(radius, kind="stable")
    main = np.zeros(len(parent), int)
    main[parent[order]] = order
    start_radius = np.where(main[parent] == np.arange(len(parent)), radius[parent], radius)
    vertices, triangles, offset = [], [], 0
    segment = np.arange(1, len(parent))
    segment = segment[radius[segment] > thinnest_m]
    for sides, low, high in ((9, 0.06, 9.0), (5, 0.018, 0.06), (3, 0.0, 0.018)):
        s = segment[(radius[segment] > low) & (radius[segment] <= high)]
        if not len(s):
            continue
        p0, p1 = skeleton.position[parent[s]], skeleton.position[s]
        axis = p1 - p0
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        a, b = perpendicular(axis)
        angle = np.arange(sides) * 2 * np.pi / sides
        ring = a[:, None] * np.cos(angle)[None, :, None] + b[:, None] * np.sin(angle)[None, :, None]
        low_ring = p0[:, None] + ring * np.minimum(start_radius[s], 1.6 * radius[s])[:, None, None]
        high_ring = p1[:, None] + ring * radius[s][:, None, None]
        vertices.append(np.concatenate([low_ring, high_ring], axis=1).reshape(-1, 3))
        k, n = np.arange(sides), (np.arange(sides) + 1) % sides
        pattern = np.concatenate([np.stack([k, n, sides + n], 1), np.stack([k, sides + n, sides + k], 1)])
        triangles.append((offset + np.arange(len(s))[:, None, None] * 2 * sides + pattern[None]).reshape(-1, 3))
        offset += len(s) * 2 * sides
    return np.concatenate(vertices), np.concatenate(triangles)
