#!/usr/bin/env python3
"""Scenes of which each part is within its limit and that together need more memory than there is: refused in little
memory and before they are built, with what they need and what there is. usage: memory_sum_test.py RAYCUBE"""

import base64
import json
import os
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy

from driver import Program

program = Program(sys.argv[1])
check = program.check
kProgram_MiB = 150  #: resident, of the program without a scene: 60, and room
kSpace_bytes = 700 << 20  #: address space of each run; the program itself takes 150 MiB of it

HEAD = """format = 1
atmosphere = { model = "none" }
time = { sun = { zenith_deg = 40.0, azimuth_deg = 150.0 } }
[[material]]
name = "m"
reflectance = 0.3
[[material]]
name = "n"
reflectance = 0.5
[[instrument]]
name = "camera"
kind = "framing"
pixels = 8
lines = 8
position_m = [0, 0, 500]
ifov_mrad = 2
samples = { grid = [2, 2] }
bands = { first_nm = 550, step_nm = 10, count = 1, fwhm_nm = 10 }
[[plane]]
material = "m"
size_m = [100.0, 100.0]
"""
MESH = '[[mesh]]\nname = "b"\nfile = "{}"\nmaterial = "m"\n'
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def gltf(path, nodes, side=40):
    """One sheet of (side - 1)^2 squares, which many nodes name."""
    points = numpy.array([[i, j, 0] for i in range(side) for j in range(side)], "<f4")
    first = numpy.array([i * side + j for i in range(side - 1) for j in range(side - 1)])
    corners = numpy.stack([first, first + 1, first + side, first + 1, first + side + 1, first + side], 1).astype("<u2")
    data = points.tobytes() + corners.tobytes()
    view = {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes}
    path.write_text(json.dumps({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": list(range(nodes))}],
        "nodes": [{"mesh": 0, "translation": [50 * k, 0, 0]} for k in range(nodes)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{
            "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            "byteLength": len(data),
        }],
        "bufferViews": [view, {**view, "byteOffset": points.nbytes, "byteLength": corners.nbytes}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(points),
                "type": "VEC3",
                "min": points.min(0).tolist(),
                "max": points.max(0).tolist(),
            },
            {"bufferView": 1, "componentType": 5123, "count": corners.size, "type": "SCALAR"},
        ],
    }))


def png(path, width, height, bands=1):
    """A grey picture of one value, or of normals that point upwards, in some hundred kilobytes."""

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    packed = zlib.compressobj(6)
    row = b"\0" + (b"\x80" if bands == 1 else b"\x80\x80\xff") * width
    data = b"".join(packed.compress(row) for _ in range(height)) + packed.flush()
    head = struct.pack(">IIBBBBB", width, height, 8, 0 if bands == 1 else 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def limited(folder, text, says, space_bytes=kSpace_bytes):
    (folder / "scene.toml").write_text(text)
    done = program.refused(
        "scene",
        "check",
        folder / "scene.toml",
        status=2,
        says=says,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (space_bytes, space_bytes)),
    )
    return done.stderr


def peak_MiB(*arguments):
    """Resident, of the program or of the children that read for it, whichever took more."""
    with subprocess.Popen([program.path, *arguments], stdout=subprocess.DEVNULL) as run:
        _, status, used = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
    check(run.returncode == 0, run.returncode)
    return used.ru_maxrss / 1024


with tempfile.TemporaryDirectory() as made:
    folder = pathlib.Path(made)
    (folder / "t.obj").write_text(TRIANGLE)
    (folder / "dem.asc").write_text(
        "ncols 200\nnrows 200\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + ("1 " * 200 + "\n") * 200
    )
    (folder / "places.csv").write_text("x_m,y_m\n" + "1,2\n" * 1500000)
    gltf(folder / "few.gltf", 2)
    gltf(folder / "many.gltf", 1600)
    png(folder / "vast.png", 16384, 16384)
    memory = ["more memory than there is", "about ", " MiB left by ulimit -v"]
    tree = HEAD + MESH.format("t.obj")
    drawn = '[[scatter]]\nmesh = "b"\nrectangle_m = [-50.0, -50.0, 50.0, 50.0]\non_terrain = false\n'
    drawn += "density_per_m2 = {}\n"
    checker = '[[plane]]\nsize_m = [10.0, 10.0]\nchecker = {{ materials = ["m", "n"], cell_m = {} }}\n'
    terrain = '[[terrain]]\nmaterial = "m"\nraster = "dem.asc"\nrefine = {}\n'
    instance = '[[instance]]\nmesh = "b"\n'
    for text, says in (
        (tree + drawn.format(5000.0), ["50000000 placements", *memory]),
        (tree + drawn.format(80.0) * 2, ["beside", *memory]),
        (tree + '[[scatter]]\nmesh = "b"\npositions = "places.csv"\n', ["placements", *memory]),
        (HEAD + checker.format(0.01) * 3, ["squares", *memory]),
        (HEAD + terrain.format(16), ["cells of terrain", *memory]),
        (
            (tree + drawn.format(0.005)).replace(
                "format = 1\n", "format = 1\nscene = { periodic = { x_m = 100.0, y_m = 100.0, copies = 100 } }\n"
            ),
            ["placements", *memory],
        ),
        (HEAD + MESH.format("many.gltf") + instance, ["many.gltf", "4867200 faces", *memory[:2]]),
        (
            HEAD.replace("reflectance = 0.3", 'reflectance = 0.3\nmask = { image = "vast.png" }'),
            ["vast.png", "16384 x 16384 pixels", "at most 2^26"],
        ),
        (HEAD + terrain.format(1).replace("dem.asc", "vast.png") + "cell_m = 1.0\n", ["vast.png", *memory]),
    ):
        said = limited(folder, text, says)
        check(said.count("raycube: error: ") == 1, said)
    # Of a class what is placed counts; texels of a mesh's images are counted as they cut it.
    (folder / "class.asc").write_text(
        "ncols 200\nnrows 200\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + ("1 " * 200 + "\n") * 200
    )
    classes = '[[terrain]]\nraster = "dem.asc"\nclass_map = "class.asc"\nmaterials = {{ 1 = "m" }}\n'
    by_class = '[[scatter]]\nmesh = "b"\nclass = 1\ndensity_per_m2 = {}\n'
    few = tree + classes.format() + 20 * by_class.format(0.0001)
    (folder / "scene.toml").write_text(few)
    program.run(
        "scene",
        "check",
        folder / "scene.toml",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (kSpace_bytes, kSpace_bytes)),
    )
    limited(folder, tree + classes.format() + by_class.format(100.0), ["placements", *memory])
    png(folder / "texels.png", 400, 400)
    (folder / "family.csv").write_text("wavelength_nm,a,b\n400,0.1,0.4\n900,0.1,0.4\n")
    (folder / "sheet.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 9 0\nvt 0 9\nf 1/1 2/2 3/3\n"
    )
    cut = HEAD.replace(
        'name = "m"\nreflectance = 0.3',
        'name = "m"\nreflectance = 0.3\n[[material]]\nname = "t"\nfamily = "family.csv"\ntexture = { '
        'image = "texels.png", choose = "nearest", band_nm = [540.0, 560.0] }',
    )
    cut += MESH.format("sheet.obj").replace('"m"', '"t"') + instance
    limited(folder, cut, ["triangles along the texels of its images", *memory], 350 << 20)
    # What fits is taken: no sum is larger than what it stands for.
    for text in (tree + drawn.format(1.0), HEAD + checker.format(0.1), HEAD + terrain.format(2)):
        (folder / "scene.toml").write_text(text)
        program.run("scene", "check", folder / "scene.toml")
    (folder / "scene.toml").write_text(HEAD + MESH.format("few.gltf") + instance)
    program.run("scene", "check", folder / "scene.toml")
    # A mesh that many nodes name is handed over once; a tree is built without what its triangles came from: 80 bytes a
    # triangle at most.
    gltf(folder / "sheets.gltf", 300, 88)
    (folder / "scene.toml").write_text(HEAD + MESH.format("sheets.gltf") + instance)
    most_MiB, found_MiB = kProgram_MiB + 300 * 2 * 87**2 * 80 / 2**20, peak_MiB("scene", "check", folder / "scene.toml")
    check(found_MiB < most_MiB, f"{found_MiB:.0f} MiB of {most_MiB:.0f}: sheets.gltf")
    # Pictures are held in the bytes of their file until members of 2 bytes a texel are made of them, by rank
    # with places of 4 bytes; heights of 8 are made of normals by two spectra of 8 each.
    png(folder / "large.png", 8192, 8192)
    png(folder / "colour.png", 4096, 4096, 3)
    family = 'name = "m"\nfamily = "family.csv"\ntexture = {{ image = "{}", texel_m = 1.0, choose = "{}", {} }}'
    one, three = "band_nm = [540, 560]", "band_nm = [440, 460, 540, 560, 640, 660]"
    grey = 'name = "m"\nreflectance = 0.3'
    for material, side, texel_bytes in (
        (family.format("large.png", "rank", one), 8192, 7),
        (family.format("large.png", "deviations", one), 8192, 3),
        (family.format("colour.png", "nearest", three), 4096, 6),
        (grey + '\nnormals = { image = "colour.png", texel_m = 1.0 }', 4096, 19),
    ):
        (folder / "scene.toml").write_text(HEAD.replace(grey, material))
        most_MiB = texel_bytes * side**2 / 2**20 + kProgram_MiB
        found_MiB = peak_MiB("scene", "check", folder / "scene.toml")
        check(found_MiB < most_MiB, f"{found_MiB:.0f} MiB of {most_MiB:.0f}: {material}")
    ranked = HEAD.replace(grey, family.format("large.png", "rank", one))
    limited(folder, ranked, ["large.png", *memory], 550 << 20)
print(f"memory sum: {program.checks} checks")
