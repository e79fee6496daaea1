"""Where things are in the park: scene metres, x east, y north, origin in the middle of a 400 m square.

A harness-racing ground after the collection site of Bloechl et al. 2014 (Proc. SPIE 9088, 90880G): a dirt oval, three
asphalt courts in the north-east, small targets on the grass north of them, a tree-lined gravel road, forest, a field.
Nothing here copies the real site's map.
"""

import numpy as np

HALF_M = 200.0  # the terrain covers [-200, 200] m in x and y
POST_M = 0.5  # DEM posts and class cells

# courts: (x centre, y centre, half width, half height), edges on class-cell borders; the third carries the targets
COURTS = [(57.0, 76.0, 12.0, 16.0), (87.0, 76.0, 12.0, 16.0), (118.0, 76.0, 13.0, 16.0)]
COURT_HEIGHT_M = 3.4  # scene z of the flat asphalt
# a second rectangle that must stay level: shed and paddock beside the track
SHED = (-6.0, 62.0, 9.0, 6.0)
PARKING = (18.0, 72.0, 17.0, 8.0)
GREEN_TARGETS = (62.0, 104.0, 30.0, 17.0)  # west, south, width, height of their rectangle on the grass, m

OVAL_CENTER = (-28.0, -48.0)
OVAL_TILT_DEG = 8.0  # counter-clockwise
OVAL_STRAIGHT_M = 62.0  # half length of the straights
OVAL_RADIUS_M = 52.0  # centre line of the turns
OVAL_HALF_WIDTH_M = 6.5

ROAD = np.array(
    [
        (141, -215),
        (128, -150),
        (119, -90),
        (116, -30),
        (122, 8),
        (112, 38),
        (80, 50),
        (30, 55),
        (-40, 78),
        (-110, 92),
        (-215, 118),
    ],
    float,
)
ROAD_HALF_WIDTH_M = 2.6
DITCH = np.array([(-118, 215), (-126, 140), (-138, 60), (-140, -30), (-128, -120), (-136, -215)], float)
FIELD = (-215.0, -215.0, -62.0, -132.0)  # x0, y0, x1, y1 of the ploughed field in the south-west


def curve(points, step_m=1.0):
    """Catmull-Rom curve through the points, resampled at about step_m."""
    p = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    out = []
    for i in range(1, len(p) - 2):
        n = max(2, int(np.hypot(*(p[i + 1] - p[i])) / step_m))
        t = np.linspace(0, 1, n, endpoint=False)[:, None]
        a, b, c, d = p[i - 1], p[i], p[i + 1], p[i + 2]
        out.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    return np.vstack(out + [points[-1:]])


def distance_to_curve(x, y, line):
    """Distance to a polyline, and where along it: segment index plus fraction. x, y of any shape."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    best = np.full(x.shape, np.inf)
    along = np.zeros(x.shape)
    for i, ((ax, ay), (bx, by)) in enumerate(zip(line[:-1], line[1:])):
        dx, dy = bx - ax, by - ay
        t = np.clip(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0, 1)
        d = np.hypot(x - ax - t * dx, y - ay - t * dy)
        closer = d < best
        best[closer], along[closer] = d[closer], i + t[closer]
    return best, along


def rectangle_distance(x, y, rectangle):
    """Distance outside a centred rectangle (x, y, half width, half height); 0 inside."""
    cx, cy, hw, hh = rectangle
    return np.hypot(np.maximum(np.abs(x - cx) - hw, 0), np.maximum(np.abs(y - cy) - hh, 0))


def oval_offset(x, y):
    """Signed distance to the oval's centre line (positive outside), m."""
    a = np.radians(OVAL_TILT_DEG)
    u = (x - OVAL_CENTER[0]) * np.cos(a) + (y - OVAL_CENTER[1]) * np.sin(a)
    v = -(x - OVAL_CENTER[0]) * np.sin(a) + (y - OVAL_CENTER[1]) * np.cos(a)
    return np.hypot(np.maximum(np.abs(u) - OVAL_STRAIGHT_M, 0), v) - OVAL_RADIUS_M


def oval_points(offset_m, step_m):
    """Points along the oval at an offset from its centre line, with the heading (clockwise from north) there."""
    r = OVAL_RADIUS_M + offset_m
    straight, turn = 2 * OVAL_STRAIGHT_M, np.pi * r
    total = 2 * (straight + turn)
    s = np.arange(int(total // step_m)) * (total / int(total // step_m))
    a = np.radians(OVAL_TILT_DEG)
    points = []
    for d in s:
        if d < straight:
            u, v, h = -OVAL_STRAIGHT_M + d, -r, 0.0
        elif d < straight + turn:
            h = (d - straight) / r
            u, v = OVAL_STRAIGHT_M + r * np.sin(h), -r * np.cos(h)
        elif d < 2 * straight + turn:
            u, v, h = OVAL_STRAIGHT_M - (d - straight - turn), r, np.pi
        else:
            h = np.pi + (d - 2 * straight - turn) / r
            u, v = -OVAL_STRAIGHT_M + r * np.sin(h), -r * np.cos(h)
        points.append(
            (
                OVAL_CENTER[0] + u * np.cos(a) - v * np.sin(a),
                OVAL_CENTER[1] + u * np.sin(a) + v * np.cos(a),
                (90.0 - np.degrees(h) - OVAL_TILT_DEG) % 360.0,
            )
        )
    return np.array(points)
