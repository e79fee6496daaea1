"""Writers for the few formats the park needs, with numpy and the standard library only: ENVI raster, PNG, OBJ, CSV."""

import struct
import zlib
from pathlib import Path

import numpy as np

EPSG = 32618  # WGS 84 / UTM zone 18N
ORIGIN_EASTING_M = 276000.0
ORIGIN_NORTHING_M = 4753000.0
ORIGIN_HEIGHT_M = 180.0  # m above sea level at scene z = 0
WKT = (
    'PROJCS["WGS 84 / UTM zone 18N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",-75],PARAMETER["scale_factor",0.9996],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","32618"]]'
)


def write_envi(path, values, west_m, north_m, post_m, description, names=("height",)):
    """float32 ENVI raster with map info. values[line, sample] or [line, sample, band], line 0 in the north; west_m and
    north_m are the outer corner of the first pixel in scene metres; pixel centres carry the values."""
    path = Path(path)
    np.ascontiguousarray(values, dtype="<f4").tofile(path)
    lines, samples = values.shape[:2]
    path.with_suffix(".hdr").write_text(
        "ENVI\n"
        f"description = {{{description}}}\n"
        f"samples = {samples}\nlines = {lines}\nbands = {len(names)}\nheader offset = 0\nfile type = ENVI Standard\n"
        "data type = 4\ninterleave = bip\nbyte order = 0\n"
        f"band names = {{{', '.join(names)}}}\n"
        f"map info = {{UTM, 1, 1, {ORIGIN_EASTING_M + west_m!r}, {ORIGIN_NORTHING_M + north_m!r}, {post_m!r}, "
        f"{post_m!r}, "
        "18, North, WGS-84, units=Meters}\n"
        f"coordinate system string = {{{WKT}}}\n"
    )


def write_png(path, values, palette=None):
    """8-bit PNG. values[line, sample] with a palette (list of (r, g, b)), or values[line, sample, 3]."""
    values = np.ascontiguousarray(values, dtype=np.uint8)
    lines, samples = values.shape[:2]
    colour_type = 2 if values.ndim == 3 else (3 if palette else 0)

    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))

    rows = np.concatenate([np.zeros((lines, 1), np.uint8), values.reshape(lines, -1)], axis=1)  # filter type 0 per line
    out = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", samples, lines, 8, colour_type, 0, 0, 0))
    if palette:
        out += chunk(b"PLTE", bytes(v for rgb in palette for v in rgb))
    out += chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")
    Path(path).write_bytes(out)


def write_world_file(path, west_m, north_m, post_m):
    """ESRI world file: pixel size and the centre of the first pixel, UTM metres."""
    Path(path).write_text(
        f"{post_m!r}\n0.0\n0.0\n{-post_m!r}\n"
        f"{ORIGIN_EASTING_M + west_m + post_m / 2!r}\n{ORIGIN_NORTHING_M + north_m - post_m / 2!r}\n"
    )


def write_obj(path, groups, comment):
    """groups: list of (material, vertices[n, 3] in metres, triangles[m, 3]). One `usemtl` per group, 0.1 mm steps."""
    out = [f"# {line}" for line in comment]
    offset = 1
    for material, vertices, triangles in groups:
        out.append(f"usemtl {material}")
        out.append("\n".join("v %.4f %.4f %.4f" % (x, y, z) for x, y, z in np.asarray(vertices).tolist()))
        out.append("\n".join("f %d %d %d" % (a, b, c) for a, b, c in (np.asarray(triangles) + offset).tolist()))
        offset += len(vertices)
    Path(path).write_text("\n".join(out) + "\n")


def write_placements(path, rows, comment):
    """Rows of (x_m, y_m, yaw_deg, scale) in scene metres; yaw clockwise from north."""
    text = [f"# {line}" for line in comment] + ["x_m,y_m,yaw_deg,scale"]
    text += ["%.3f,%.3f,%.2f,%.4f" % tuple(row) for row in rows]
    Path(path).write_text("\n".join(text) + "\n")
