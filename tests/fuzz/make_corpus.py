#!/usr/bin/env python3
"""Writes the binary files of tests/fuzz/corpus anew. All are made here, of numbers of our own, under the project's
licence; none is anybody else's. It needs Debian's python3-gdal, which no test does.
Text files of the corpora are their own source. Pictures and rasters are written by
GDAL (their bytes may differ by its version, which no test minds), compiled scenes by raycube; a scene is due anew
whenever the version of .rcs files rises. usage: make_corpus.py RAYCUBE [FOLDER, default the corpus]"""

import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy
from osgeo import gdal

raycube = pathlib.Path(sys.argv[1]).resolve()
corpus = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parent / "corpus")
gdal.UseExceptions()


def place(target, name):
    (corpus / target).mkdir(parents=True, exist_ok=True)
    return corpus / target / name


def pyramid():
    """A pyramid of 16 x 12 x 5 m without its base, as PLY of both byte orders and as STL."""
    points = [(-8, -6, 0), (8, -6, 0), (8, 6, 0), (-8, 6, 0), (3, -2, 5)]
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    for order, sign in (("little", "<"), ("big", ">")):
        head = f"ply\nformat binary_{order}_endian 1.0\nelement vertex {len(points)}\n"
        head += "".join(f"property float {axis}\n" for axis in "xyz")
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        body = b"".join(struct.pack(sign + "3f", *point) for point in points)
        body += b"".join(struct.pack(sign + "B3i", 3, *face) for face in faces)
        place("mesh_ply", f"binary_{order}_endian").write_bytes(head.encode() + body)
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(c for i in face for c in points[i]), 0) for face in faces)
    place("mesh_stl", "binary").write_bytes(b"x".ljust(80) + struct.pack("<I", len(faces)) + body)


def orientation():
    """The tag 274 = 6 (turned by a quarter) in the least that each format holds it in; no picture follows."""
    tag = struct.pack("<2sHIHHHIHHHI", b"II", 42, 8, 1, 274, 3, 1, 6, 0, 0, 0)
    place("orientation", "tiff").write_bytes(tag)
    marker = b"\xff\xd8\xff\xe1" + struct.pack(">H", 8 + len(tag)) + b"Exif\0\0"
    place("orientation", "jpeg").write_bytes(marker + tag + b"\xff\xda")
    start = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", len(tag)) + b"eXIf"
    place("orientation", "png").write_bytes(start + tag + b"crc." + struct.pack(">I", 0) + b"IENDcrc.")


def rasters():
    rgb = gdal.GetDriverByName("MEM").Create("", 5, 4, 3, gdal.GDT_Byte)
    for band in range(3):
        rgb.GetRasterBand(band + 1).WriteArray(numpy.arange(20).reshape(4, 5) * (band + 3))
    tiles = ["COMPRESS=DEFLATE", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16"]
    for driver, target, name, options in (
        ("PNG", "raster_png", "rgb", []),
        ("JPEG", "raster_jpeg", "rgb", []),
        ("GTiff", "raster_tiff", "deflate", tiles),
    ):
        gdal.GetDriverByName(driver).CreateCopy(str(place(target, name)), rgb, 0, options)
    heights = gdal.GetDriverByName("MEM").Create("", 5, 4, 1, gdal.GDT_Float32)
    heights.SetGeoTransform((0, 1, 0, 0, 0, -1))
    band = heights.GetRasterBand(1)
    band.WriteArray(numpy.arange(20.0).reshape(4, 5))
    band.SetNoDataValue(3)
    band.SetScale(0.1)
    gdal.GetDriverByName("GTiff").CreateCopy(str(place("raster_tiff", "float")), heights)
    for beside in corpus.glob("raster_*/*.aux.xml"):
        beside.unlink()


def points():
    """LAS 1.4 of two points of format 6 and nothing else: the fields of the specification's header, table 3."""
    head = bytearray(375)
    head[0:4], head[26:30] = b"LASF", b"test"
    for at, form, values in (
        (6, "<H", [16]),  # WKT is meant
        (24, "<2B", [1, 4]),
        (90, "<3H", [1, 2020, 375]),
        (96, "<2I", [375, 0]),
        (104, "<BH", [6, 30]),
        (131, "<6d", [0.01, 0.01, 0.01, 0, 0, 0]),
        (179, "<6d", [0.02, 0.01] * 3),
        (247, "<16Q", [2, 2] + [0] * 14),
    ):
        struct.pack_into(form, head, at, *values)
    each = [struct.pack("<iiiHBBBBhHd", x, x, x, 5, 0x11, 0, 2, 0, 0, 1, 0.5) for x in (1, 2)]
    place("las", "two_points").write_bytes(bytes(head) + b"".join(each))


def compiled_scene():
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.toml"
        scene.write_text(
            'format = 1\n[[material]]\nname = "m"\nreflectance = 0.3\n'
            '[[plane]]\nmaterial = "m"\nsize_m = [10.0, 10.0]\n'
        )
        out = place("compiled_scene", "version_12")
        subprocess.run([raycube, "scene", "compile", scene, "-o", out, "--overwrite"], check=True, capture_output=True)


pyramid()
orientation()
rasters()
points()
compiled_scene()
