"""Relief and ground cover of the park on one 0.5 m grid.

A cell's cover is a mixture of at most four materials by area. Grass grades from lawn over meadow to dry grass; edges of
paths and forest floor are averaged from 0.25 m, so that they are neither stairs nor blurred.
"""

import numpy as np

from . import layout
from .noise import NoiseField, smoothstep

# class codes of classes.png; the materials they name are in park.toml
LAWN, MEADOW, DRY_GRASS, TRACK, GRAVEL, ASPHALT, LITTER, LOAM, SAND, CONCRETE = range(1, 11)
PALETTE = [
    (0, 0, 0),
    (84, 132, 52),
    (126, 146, 72),
    (176, 164, 108),
    (168, 138, 104),
    (172, 168, 160),
    (72, 72, 76),
    (96, 74, 50),
    (74, 58, 46),
    (206, 192, 158),
    (196, 194, 188),
]
NAMES = [
    "none",
    "lawn",
    "meadow",
    "dry grass",
    "dirt track",
    "gravel",
    "asphalt",
    "leaf litter",
    "loam",
    "sand",
    "concrete",
]


STEPS = 16  # fractions are multiples of 1/16: few different mixtures, sums exact in float32


def quantise(fractions):
    """The four largest fractions of each cell, as multiples of 1/STEPS that sum to 1 exactly (largest remainder)."""
    shape = fractions.shape
    f = fractions.reshape(-1, shape[-1])
    f = np.where(f >= np.sort(f, axis=1)[:, -4:-3], f, 0)
    f = f / f.sum(1, keepdims=True) * STEPS
    whole = np.floor(f)
    rest = f - whole
    rank = np.argsort(np.argsort(-rest, axis=1, kind="stable"), axis=1)
    whole += rank < np.round(STEPS - whole.sum(1))[:, None]
    return (whole / STEPS).astype(np.float32).reshape(shape)


class Park:
    """Heights at posts (801 x 801, line 0 in the north), cover at cells (800 x 800), and lookups for the planting.
    fractions[line, sample, class - 1] sum to 1; classes is the largest of them."""

    def __init__(self, seed):
        extent = 2.56 * layout.HALF_M  # a little wider than the terrain, so that periodic noise does not repeat inside
        self.rolling = NoiseField([seed, 1], extent, 260, 40)
        self.bumps = NoiseField([seed, 2], extent, 24, 5, slope=2.5)
        self.turf = NoiseField([seed, 3], extent, 4, 1.0, slope=1.5)
        self.edge = NoiseField([seed, 4], extent, 40, 1.5, slope=2.0)
        self.patch = NoiseField([seed, 5], extent, 60, 3, slope=2.2)
        self.grain = NoiseField([seed, 6], extent, 6, 1.0, slope=0.8)
        self.wood = NoiseField([seed, 7], extent, 110, 12, slope=2.6)
        self.road = layout.curve(layout.ROAD)
        self.ditch = layout.curve(layout.DITCH, 4.0)
        n = int(2 * layout.HALF_M / layout.POST_M)
        post = np.linspace(-layout.HALF_M, layout.HALF_M, n + 1)
        self.px, self.py = np.meshgrid(post, post[::-1])
        self.heights = self._heights(self.px, self.py).astype(np.float32)
        self.fractions = quantise(self._cell_fractions(n))
        self.classes = (self.fractions.argmax(2) + 1).astype(np.uint8)

    # relief -----------------------------------------------------------------------------------------------------------
    def _ground(self, x, y):
        """Rolling ground before anything was built: 1 % fall to the south-west, 4 m of relief."""
        return 3.2 + 0.010 * x + 0.008 * y + 1.35 * self.rolling(x, y)

    def _heights(self, x, y):
        z = self._ground(x, y)
        # drainage: a grassy swale that deepens southwards
        to_ditch, _ = self._coarse_distance(x, y, self.ditch)
        depth = np.interp(y, [-200, 200], [1.9, 0.9])
        z -= depth * np.exp(-((to_ditch / 4.5) ** 2))
        z += 0.11 * self.bumps(x, y)
        # the race track: smooth surface, banked in the turns, raised berm along the outer edge
        offset = layout.oval_offset(x, y)
        on_track = 1 - smoothstep(layout.OVAL_HALF_WIDTH_M, layout.OVAL_HALF_WIDTH_M + 9.0, np.abs(offset))
        level = 2.2 + 0.010 * (x * 0.75) + 0.05 * np.clip(offset, -layout.OVAL_HALF_WIDTH_M, layout.OVAL_HALF_WIDTH_M)
        z += on_track * (level - z)
        z += 1.15 * np.exp(-(((offset - layout.OVAL_HALF_WIDTH_M - 2.4) / 1.5) ** 2))
        # the gravel road lies on its own gentle profile: cuts and fills with ditches of 25 cm on both sides
        to_road, along = self._coarse_distance(x, y, self.road)
        profile = self._ground(self.road[:, 0], self.road[:, 1])
        kernel = np.hanning(61) / np.hanning(61).sum()
        profile = np.convolve(np.pad(profile, 30, mode="edge"), kernel, mode="valid")
        blend = 1 - smoothstep(layout.ROAD_HALF_WIDTH_M + 0.8, layout.ROAD_HALF_WIDTH_M + 6.0, to_road)
        z += blend * (
            np.interp(along, np.arange(len(profile)), profile)
            + 0.06 * np.maximum(0, 1 - to_road / layout.ROAD_HALF_WIDTH_M)
            - z
        )
        z -= 0.25 * np.exp(-(((to_road - layout.ROAD_HALF_WIDTH_M - 1.5) / 0.6) ** 2))
        # turf, not on built ground
        built = np.maximum.reduce([on_track, blend])
        z += 0.018 * self.turf(x, y) * (1 - 0.8 * built)
        # level pads: courts share one, shed and parking have theirs
        pad = np.min([layout.rectangle_distance(x, y, c) for c in layout.COURTS], axis=0)
        blend = 1 - smoothstep(0.75, 9.0, pad)
        z += blend * (layout.COURT_HEIGHT_M - z)
        for rectangle in (layout.SHED, layout.PARKING):
            height = float(self._ground(np.array(rectangle[0]), np.array(rectangle[1])))
            blend = 1 - smoothstep(0.5, 7.0, layout.rectangle_distance(x, y, rectangle))
            z += blend * (height - z)
        return z

    def _coarse_distance(self, x, y, line):
        """Distance and place along the line for a full grid, only where a part of the line comes within 15 m (else
        far)."""
        distance, along = np.full(x.shape, 1e3), np.zeros(x.shape)
        for start in range(0, len(line) - 1, 16):
            part = line[start : start + 17]
            x0, y0 = part.min(0) - 15
            x1, y1 = part.max(0) + 15
            near = (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
            if near.any():
                d, a = layout.distance_to_curve(x[near], y[near], part)
                closer = d < distance[near]
                where = tuple(axis[closer] for axis in np.nonzero(near)) if near.ndim else near
                distance[where], along[where] = d[closer], a[closer] + start
        return distance, along

    def height_at(self, x, y):
        """Bilinear height, m above scene z = 0."""
        u = (np.asarray(x) + layout.HALF_M) / layout.POST_M
        v = (layout.HALF_M - np.asarray(y)) / layout.POST_M
        n = self.heights.shape[0] - 2
        i, j = np.clip(u.astype(int), 0, n), np.clip(v.astype(int), 0, n)
        fu, fv, h = u - i, v - j, self.heights
        return (1 - fv) * ((1 - fu) * h[j, i] + fu * h[j, i + 1]) + fv * ((1 - fu) * h[j + 1, i] + fu * h[j + 1, i + 1])

    # cover ------------------------------------------------------------------------------------------------------------
    def forest_density(self, x, y):
        """0 in the open, 1 in closed forest: bands in the north, west and east with an irregular edge."""
        edge = 9.0 * self.wood(x, y) + 2.5 * self.edge(x, y)
        north = smoothstep(-5, 7, y - 137 + edge - 12 * np.exp(-(((x + 90) / 45) ** 2)))
        west = smoothstep(-5, 7, -x - 126 + edge) * smoothstep(-8, 8, y + 120 + edge)
        east = smoothstep(-5, 7, x - 153 + edge)
        spinney = smoothstep(-4, 4, 15 + 0.6 * edge - np.hypot(x - 62, y + 122))
        wood = np.maximum.reduce([north, west, east, spinney])
        return (
            wood
            * smoothstep(9, 14, layout.oval_offset(x, y))
            * smoothstep(7, 12, layout.rectangle_distance(x, y, layout.COURTS[2]))
        )

    def is_clear(self, x, y, margin_m):
        """True where a tree may stand: `margin_m` away from courts, track, road, targets, shed, parking and field."""
        far = (
            np.min([layout.rectangle_distance(x, y, c) for c in layout.COURTS + [layout.SHED, layout.PARKING]], axis=0)
            > margin_m
        )
        far &= np.abs(layout.oval_offset(x, y)) > layout.OVAL_HALF_WIDTH_M + margin_m
        west, south, width, height = layout.GREEN_TARGETS
        far &= layout.rectangle_distance(x, y, (west + width / 2, south + height / 2, width / 2, height / 2)) > margin_m
        to_road, _ = self._coarse_distance(x, y, self.road)
        far &= to_road > layout.ROAD_HALF_WIDTH_M + min(margin_m, 2.2)
        x0, y0, x1, y1 = layout.FIELD
        return far & ~((x > x0) & (x < x1) & (y > y0) & (y < y1))

    def _cell_fractions(self, cells):
        """Cover of all cells: means over 2 x 2 points of each, in strips of 100 lines."""
        step = layout.POST_M / 2
        point = -layout.HALF_M + step * (np.arange(2 * cells) + 0.5)
        strips = []
        for first in range(0, 2 * cells, 200):
            x, y = np.meshgrid(point, point[::-1][first : first + 200])
            f = self._cover(x, y)
            strips.append(f.reshape(100, 2, cells, 2, -1).mean(axis=(1, 3)))
        return np.concatenate(strips)

    def _cover(self, x, y):
        """Area fractions [..., class - 1] at points."""
        edge, patch, grain = self.edge(x, y), self.patch(x, y), self.grain(x, y)
        to_road, _ = self._coarse_distance(x, y, self.road)
        to_ditch, _ = self._coarse_distance(x, y, self.ditch)
        offset = layout.oval_offset(x, y)
        court = np.min([layout.rectangle_distance(x, y, c) for c in layout.COURTS], axis=0)
        cover = np.zeros(x.shape + (len(NAMES) - 1,), np.float32)

        def lay(where, **parts):
            """Puts a layer of named materials where `where` is 1 (0..1: partly)."""
            nonlocal cover
            where = np.asarray(where, np.float32)
            cover *= (1 - where)[..., None]
            total = sum(parts.values())
            for name, part in parts.items():
                cover[..., globals()[name] - 1] += where * (part / total)

        # grass: mown near the courts and in the infield, rougher away from them; patches dry out; swale stays green
        mown = np.maximum(1 - smoothstep(35, 70, court + 8 * edge), 1 - smoothstep(-12, -6, offset + 2 * edge))
        dryness = 0.75 * patch + 0.55 * grain + 0.3 * edge + 0.35 * (1 - mown) - 0.55 * mown
        dryness += 1.4 * np.exp(
            -(((np.abs(offset) - layout.OVAL_HALF_WIDTH_M - 1.5) / 1.6) ** 2)
        )  # worn verge of the track
        dryness += 0.22 * mown * np.tanh(4 * np.sin(2 * np.pi * (x * 0.97 + y * 0.24) / 5.0))  # mowing lanes
        dryness -= 1.2 * np.exp(-(((to_ditch + edge) / 3.0) ** 2))
        meadow = np.interp(dryness, [-0.6, 1.7, 2.8], [0.04, 0.85, 0.25])
        dry = np.interp(dryness, [0.9, 2.8], [0.0, 0.75])
        bare = 0.5 * smoothstep(1.9, 3.2, -patch - 0.6 * grain) * (1 - mown) + 0.03 * smoothstep(0.5, 2.0, grain)
        lay(np.ones_like(x), LAWN=np.maximum(1 - meadow - dry, 0.0), MEADOW=meadow, DRY_GRASS=dry, LOAM=bare)
        # ploughed field with rows of stubble
        x0, y0, x1, y1 = layout.FIELD
        inside = (x > x0) & (x < x1 + 1.5 * edge) & (y > y0) & (y < y1 + 1.5 * edge)
        row = np.sin(2 * np.pi * (x * np.sin(0.35) + y * np.cos(0.35)) / 3.0) + 0.45 * grain + 0.35 * patch
        stubble = 0.05 + 0.8 * smoothstep(0.0, 1.1, row)
        lay(inside, LOAM=1 - stubble, DRY_GRASS=stubble)
        # forest floor, thinning out over the edge
        floor = smoothstep(0.40, 0.72, self.forest_density(x, y) + 0.10 * grain)
        green = 0.25 * smoothstep(0.3, 2.2, patch + 0.5 * grain)
        lay(floor, LITTER=1 - green, LOAM=0.12 + 0.10 * np.tanh(grain), LAWN=green)
        # sand beside the courts, gravel of parking and shed, road with wheel tracks and a grassy crown, the dirt track
        lay(layout.rectangle_distance(x, y, (37.0, 88.0, 2.0, 2.0)) + 0.5 * edge < 3.2, SAND=np.ones_like(x))
        dust = np.clip(0.25 + 0.16 * grain + 0.12 * patch, 0.02, 0.7)
        park = layout.rectangle_distance(x, y, layout.PARKING)
        pad = (park + 0.4 * edge + 0.1 * grain < 1.2) | (
            layout.rectangle_distance(x, y, layout.SHED) + 0.6 * edge < 0.5
        )
        fines = 0.22 + 0.05 * grain  # damp dark fines between the stones
        lay(pad, GRAVEL=1 - dust, TRACK=dust, LOAM=np.maximum(fines, 0.05))
        width = layout.ROAD_HALF_WIDTH_M + 0.35 * edge
        tufts = 0.75 * smoothstep(0.1, 1.6, patch + 0.6 * grain) * np.exp(-((to_road / 0.45) ** 2))
        dust = np.clip(dust - 0.2 * np.exp(-(((to_road - 0.95) / 0.4) ** 2)), 0.02, 0.7)
        lay(
            to_road + 0.18 * grain < width,
            GRAVEL=(1 - dust) * (1 - tufts),
            TRACK=dust * (1 - tufts),
            MEADOW=tufts,
            LOAM=np.maximum(fines, 0.05),
        )
        width = layout.OVAL_HALF_WIDTH_M + 0.5 * edge + 0.25 * grain
        wet = 0.30 + 0.05 * grain + 0.45 * smoothstep(1.2, 3.2, -0.35 * grain - 0.9 * patch + 0.18 * np.abs(offset))
        worn = 0.45 * smoothstep(0.4, 2.6, 0.3 * grain + 0.8 * patch + 0.5 * np.cos(offset / 1.1))
        lay(np.abs(offset) < width, TRACK=np.maximum(1 - wet - worn, 0.1), LOAM=np.maximum(wet, 0.05), SAND=worn)
        # courts with worn and patched stretches, and the concrete apron that joins them
        apron = (np.abs(x - 87.5) < 44.5) & (np.abs(y - 76.0) < 16.0)
        lay(apron & (court > 0) & (court < 1.0), CONCRETE=np.ones_like(x))
        wear = np.clip(0.07 + 0.05 * patch + 0.04 * grain, 0.0, 0.35)
        lay(court == 0, ASPHALT=1 - wear, CONCRETE=wear)
        return cover
