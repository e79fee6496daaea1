"""Built things as OBJ groups: wood block, yellow felt and cotton target, car, shed, rail fence, lamp post. Metres, z
up."""

import numpy as np

from .planting import FOOT_M

_BOX = np.array(
    [
        (0, 2, 1),
        (0, 3, 2),
        (4, 5, 6),
        (4, 6, 7),
        (0, 1, 5),
        (0, 5, 4),
        (1, 2, 6),
        (1, 6, 5),
        (2, 3, 7),
        (2, 7, 6),
        (3, 0, 4),
        (3, 4, 7),
    ]
)


def box(x0, y0, z0, x1, y1, z1):
    """Vertices and outward triangles of an axis-parallel box."""
    v = np.array(
        [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0), (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)]
    )
    return v, _BOX


def joined(parts):
    """Several (vertices, triangles) as one."""
    vertices, triangles, offset = [], [], 0
    for v, t in parts:
        vertices.append(v)
        triangles.append(np.asarray(t) + offset)
        offset += len(v)
    return np.concatenate(vertices), np.concatenate(triangles)


def wood_block():
    """12 x 20 inch block, 9 cm above the ground; its foot is sunk 10 cm so that it closes with sloping grass."""
    w, h = FOOT_M, 20 * 0.0254
    return [("green_paint", *box(-w / 2, -h / 2, -0.10, w / 2, h / 2, 0.09))]


def yellow_target():
    """16 x 16 ft in 2 x 2 ft patterns of three felt squares and one cotton square (Bloechl et al. 2014, Fig. 15): 25 %
    cotton."""
    felt, cotton = [], []
    for j in range(16):
        for i in range(16):
            x, y = (i - 8) * FOOT_M, (j - 8) * FOOT_M
            square = (
                np.array([(x, y, 0), (x + FOOT_M, y, 0), (x + FOOT_M, y + FOOT_M, 0), (x, y + FOOT_M, 0)]),
                [(0, 1, 2), (0, 2, 3)],
            )
            (cotton if i % 2 == 0 and j % 2 == 0 else felt).append(square)
    return [("yellow_felt", *joined(felt)), ("yellow_cotton", *joined(cotton))]


def car(paint):
    """4.4 x 1.8 m body with a cabin and tyres; +y is the front."""
    body = [
        box(-0.88, -2.2, 0.32, 0.88, 2.2, 0.78),
        box(-0.84, -2.1, 0.78, 0.84, -1.75, 0.95),
        box(-0.80, -1.45, 1.36, 0.80, 0.35, 1.46),
        box(-0.84, 0.95, 0.78, 0.84, 2.1, 0.92),
    ]
    glass = [box(-0.78, -1.75, 0.78, 0.78, 0.95, 1.36)]
    tyres = [box(sx - 0.1, sy - 0.32, -0.05, sx + 0.1, sy + 0.32, 0.55) for sx in (-0.8, 0.8) for sy in (-1.4, 1.4)]
    return [(paint, *joined(body)), ("black_rubber", *joined(glass + tyres))]


def shed():
    """Gabled stable, 16 x 9 m, 3 m eaves, 5.4 m ridge along x; floor at z = 0, walls sunk 0.5 m."""
    walls = box(-8, -4.5, -0.5, 8, 4.5, 3.0)
    gable = (
        np.array([(-8, -4.5, 3), (-8, 4.5, 3), (-8, 0, 5.3), (8, -4.5, 3), (8, 4.5, 3), (8, 0, 5.3)], float),
        [(0, 2, 1), (3, 4, 5)],
    )
    roof = []
    for s in (-1.0, 1.0):
        v = np.array(
            [
                (-8.4, s * 5.1, 2.75),
                (8.4, s * 5.1, 2.75),
                (8.4, 0, 5.42),
                (-8.4, 0, 5.42),
                (-8.4, s * 5.1, 2.63),
                (8.4, s * 5.1, 2.63),
                (8.4, 0, 5.30),
                (-8.4, 0, 5.30),
            ]
        )
        t = np.array(
            [
                (0, 1, 2),
                (0, 2, 3),
                (4, 6, 5),
                (4, 7, 6),
                (0, 5, 1),
                (0, 4, 5),
                (1, 6, 2),
                (1, 5, 6),
                (3, 7, 4),
                (3, 4, 0),
            ]
        )
        roof.append((v, t if s < 0 else t[:, ::-1]))
    doors = [box(x - 0.7, -4.56, -0.2, x + 0.7, -4.50, 2.2) for x in (-6, -2, 2, 6)]
    return [("brick", *joined([walls, gable])), ("shingle", *joined(roof)), ("wood", *joined(doors))]


def fence():
    """One 3 m field of a rail fence, running along +y."""
    post = box(-0.06, -0.06, -0.4, 0.06, 0.06, 1.05)
    rails = [box(-0.03, -0.06, z, 0.03, 2.98, z + 0.14) for z in (0.42, 0.85)]
    return [("white_paint", *joined([post] + rails))]


def lamp_post():
    """9 m court light: mast and a head of two floodlights pointing along +y."""
    return [
        ("steel", *joined([box(-0.09, -0.09, -0.3, 0.09, 0.09, 9.0), box(-0.9, -0.06, 8.8, 0.9, 0.06, 8.95)])),
        ("white_paint", *joined([box(x - 0.3, 0.06, 8.7, x + 0.3, 0.5, 9.05) for x in (-0.55, 0.55)])),
    ]


def court_lines():
    """Painted lines of a 15 x 28 m basketball court, 7 cm wide, flat at z = 0, facing up."""
    strips = []

    def line(x0, y0, x1, y1, half=0.035):
        d = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
        n = half * np.array([-d[1], d[0]])
        corners = [(x0 - n[0], y0 - n[1]), (x0 + n[0], y0 + n[1]), (x1 + n[0], y1 + n[1]), (x1 - n[0], y1 - n[1])]
        strips.append((np.array([(x, y, 0.0) for x, y in corners]), [(0, 2, 1), (0, 3, 2)]))

    def arc(cx, cy, r, a0, a1, n):
        a = np.radians(np.linspace(a0, a1, n + 1))
        inner, outer = (np.stack([cx + q * np.cos(a), cy + q * np.sin(a), 0 * a], 1) for q in (r - 0.035, r + 0.035))
        k = np.arange(n)
        strips.append(
            (
                np.concatenate([inner, outer]),
                np.concatenate([np.stack([k, n + 1 + k, n + 2 + k], 1), np.stack([k, n + 2 + k, k + 1], 1)]),
            )
        )

    w, h, e = 7.5, 14.0, 0.035
    for s in (-1, 1):
        line(s * w, -h - e, s * w, h + e)
        line(-w + e, s * h, w - e, s * h)
        line(-2.45, s * (h - 5.8), 2.45, s * (h - 5.8))
        for x in (-2.45, 2.45):
            line(x, s * (h - e), x, s * (h - 5.8 + e))
        arc(0, s * (h - 5.8), 1.8, 180 if s > 0 else 0, 360 if s > 0 else 180, 24)
        arc(0, s * (h - 1.575), 6.75, 192 if s > 0 else 12, 348 if s > 0 else 168, 48)
    line(-w + e, 0, w - e, 0)
    arc(0, 0, 1.8, 0, 360, 48)
    return [("white_paint", *joined(strips))]
