"""Where every instance stands: trees, shrubs, fence, targets. Rows are (x_m, y_m, yaw_deg, scale)."""

import numpy as np

from . import layout

FOOT_M = 0.3048


class _Spacing:
    """Keeps accepted points apart, each by its own distance; a hash of 2 m cells keeps the search short."""

    def __init__(self):
        self.cells = {}

    def accept(self, x, y, distance):
        i, j = int(x // 2), int(y // 2)
        reach = int(distance // 2) + 2
        for a in range(i - reach, i + reach + 1):
            for b in range(j - reach, j + reach + 1):
                for px, py, pd in self.cells.get((a, b), ()):
                    if (px - x) ** 2 + (py - y) ** 2 < (0.5 * (distance + pd)) ** 2:
                        return False
        self.cells.setdefault((i, j), []).append((x, y, distance))
        return True


def plant(park, seed):
    """All trees and shrubs: {species: rows}. An alley first, then solitary trees, the forest, and shrubs along its
    edge."""
    rng = np.random.default_rng([seed, 21])
    spacing = _Spacing()
    rows = {"maple": [], "aspen": [], "spruce": [], "shrub": []}

    def add(species, x, y, scale):
        rows[species].append((x, y, rng.uniform(0, 360), scale))

    # the alley: maples on both sides of the gravel road, with a few gaps
    road = park.road
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(road, axis=0).T))])
    for side in (-1, 1):
        for s in np.arange(4.0 + 2.5 * (side > 0), along[-1], 10.5):
            i = min(int(np.searchsorted(along, s)), len(road) - 2)
            t = road[i + 1] - road[i]
            t /= np.hypot(*t)
            x, y = road[i] + side * 5.6 * np.array([-t[1], t[0]]) + rng.normal(0, 0.35, 2)
            clear = park.is_clear(np.array([x]), np.array([y]), 2.6)[0]
            if (
                -130 < x
                and max(abs(x), abs(y)) < 195
                and clear
                and rng.random() < 0.86
                and not (0 < x < 112 and y > 36)
            ):
                if spacing.accept(x, y, 6.5):
                    add("maple", x, y, rng.uniform(0.72, 0.98))

    # solitary trees and small groups on the grass
    for cx, cy, species, count in (
        (-75, 118, "aspen", 7),
        (8, 100, "maple", 3),
        (-92, 55, "maple", 4),
        (28, 118, "spruce", 4),
        (-62, -40, "maple", 1),
        (10, -52, "spruce", 2),
        (95, -20, "aspen", 3),
        (20, -140, "maple", 4),
        (100, -150, "spruce", 5),
        (-30, 35, "aspen", 3),
        (40, 30, "maple", 2),
        (146, 60, "spruce", 4),
    ):
        for _ in range(count):
            for _ in range(20):
                x, y = cx + rng.normal(0, 6.0), cy + rng.normal(0, 6.0)
                if park.is_clear(np.array([x]), np.array([y]), 4.5)[0] and spacing.accept(
                    x, y, 4.2 if species != "maple" else 6.5
                ):
                    add(species, x, y, rng.uniform(0.7, 1.12))
                    break

    # forest: spruces on the heights of one noise field, maples and aspens elsewhere; younger and lower at the edge
    points = rng.uniform(-layout.HALF_M + 4, layout.HALF_M - 4, (60000, 2))
    density = park.forest_density(points[:, 0], points[:, 1])
    clear = park.is_clear(points[:, 0], points[:, 1], 4.0)
    mix = park.wood(points[:, 1], -points[:, 0])
    draws = rng.random((len(points), 2))
    for (x, y), d, ok, m, (u, v) in zip(points, density, clear, mix, draws):
        if not ok or d < 0.3 or v > d:
            continue
        species = "spruce" if m + 1.2 * u > 1.35 else ("aspen" if m - 1.0 * u < -0.85 else "maple")
        distance = {"maple": 6.3, "aspen": 3.7, "spruce": 4.5}[species]
        size = (0.62 + 0.38 * d) * rng.lognormal(0, 0.13)
        size = min(max(size, 0.5), 1.35)
        if spacing.accept(x, y, distance * size):
            add(species, x, y, size)

    # shrubs where the forest thins out, and a hedge by the parking
    points = rng.uniform(-layout.HALF_M + 4, layout.HALF_M - 4, (12000, 2))
    density = park.forest_density(points[:, 0], points[:, 1])
    clear = park.is_clear(points[:, 0], points[:, 1], 3.0)
    for (x, y), d, ok, draw in zip(points, density, clear, rng.random(len(points))):
        undergrowth = 0.6 if 0.15 < d < 0.8 else 0.06  # thick along the edge, sparse inside
        if ok and d > 0.15 and draw < undergrowth and spacing.accept(x, y, 2.3):
            add("shrub", x, y, rng.uniform(0.45, 1.15))
    for x in np.arange(2.0, 34.0, 1.7):
        add("shrub", x, 83.5 + rng.normal(0, 0.15), rng.uniform(0.5, 0.68))
    return rows


def fence():
    """3 m fields of the white rail along the outer edge of the track; yaw turns the field's +y axis along the track."""
    points = layout.oval_points(layout.OVAL_HALF_WIDTH_M + 0.9, 3.0)
    return [(x, y, heading, 1.0) for x, y, heading in points]


def green_targets(seed):
    """24 wood blocks on the grass in a loose 6 x 4 raster of about 5.4 m, each at its own phase of the 1 m pixels."""
    rng = np.random.default_rng([seed, 22])
    west, south, width, height = layout.GREEN_TARGETS
    rows = []
    for j in range(4):
        for i in range(6):
            x = west + (i + 0.5) * width / 6 + rng.uniform(-0.6, 0.6)
            y = south + (j + 0.5) * height / 4 + rng.uniform(-0.6, 0.6)
            rows.append((x, y, rng.uniform(-12, 12) % 360, 1.0))
    return rows


def cars(seed):
    """Two rows on the gravel parking, one car on the road: {colour: rows}."""
    rng = np.random.default_rng([seed, 23])
    cx, cy, hw, hh = layout.PARKING
    rows = {"white": [], "grey": [], "red": []}
    for y, yaw in ((cy - 4.2, 0.0), (cy + 4.2, 180.0)):
        for x in np.arange(cx - hw + 2.5, cx + hw - 1, 2.9):
            if rng.random() < 0.6:
                colour = ("white", "grey", "grey", "red")[rng.integers(0, 4)]
                rows[colour].append(
                    (x + rng.normal(0, 0.12), y + rng.normal(0, 0.2), (yaw + rng.normal(0, 2.5)) % 360, 1.0)
                )
    rows["white"].append((116.9, -44.0, 3.0, 1.0))
    return rows
