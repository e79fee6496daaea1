#!/usr/bin/env python3
"""A mesh that several nodes of a glTF name, under parents that turn and scale it, is the same scene to the bit as a
file in which each node's own mesh has its vertices worked out here: triangles, faces, materials by node, bounds.
Numbers are dyadic, so that both are exact. usage: mesh_nodes_test.py RAYCUBE"""

import base64
import json
import pathlib
import re
import sys
import tempfile

import numpy

from driver import Program

program = Program(sys.argv[1])
check = program.check

HEAD = """format = 1
atmosphere = { model = "none" }
time = { sun = { zenith_deg = 40.0, azimuth_deg = 150.0 } }
[[material]]
name = "m"
reflectance = 0.25
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
[[mesh]]
name = "b"
file = "FILE"
material = "m"
materials = { second = "n", roof = "n" }
[[instance]]
mesh = "b"
position_m = [0.5, 0.25, 1.0]
"""
#: a tetrahedron with a triangle of no area, and a sheet
SOLID = ([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 0, 0]],
         [[0, 2, 1], [0, 1, 3], [0, 3, 2], [0, 4, 1], [1, 2, 3]])
SHEET = ([[0, 4, 0], [4, 4, 0], [4, 4.5, 4], [0, 4, 4]], [[0, 1, 2], [0, 2, 3]])
TURN = [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 8, 0.5, -3, 1]  # column by column, as glTF has it
NODES = [
    {"name": "first", "mesh": 0},
    {"name": "group", "scale": [2, 0.5, 4], "translation": [-16, 0, 0.125], "children": [2, 3]},
    {"name": "second", "mesh": 0, "matrix": TURN},
    {"name": "third", "mesh": 1, "translation": [0.25, 8, 0], "children": [4]},
    {"name": "fourth", "mesh": 0, "scale": [-1, 1, 1]},
    {"name": "fifth", "mesh": 1, "matrix": TURN},
]


def matrix_of(node):
    """4 x 4; of the forms that glTF has, those that are used here."""
    if "matrix" in node:
        return numpy.array(node["matrix"], float).reshape(4, 4).T
    out = numpy.eye(4)
    out[:3, :3] *= node.get("scale", [1, 1, 1])
    out[:3, 3] = node.get("translation", [0, 0, 0])
    return out


def write(path, nodes, roots, meshes):
    """meshes: name, vertices and triangles of each."""
    data, views, accessors, listed = b"", [], [], []
    for name, points, triangles in meshes:
        points, triangles = numpy.array(points, "<f4"), numpy.array(triangles, "<u4")
        for array in (points, triangles):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
            data += array.tobytes()
        corner = {"min": points.min(0).tolist(), "max": points.max(0).tolist()}
        accessors.append(
            {"bufferView": len(views) - 2, "componentType": 5126, "count": len(points), "type": "VEC3", **corner}
        )
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"}
        )
        primitive = {"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1}
        listed.append({"name": name, "primitives": [primitive]})
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    path.write_text(json.dumps({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": listed,
        "buffers": [{"uri": uri, "byteLength": len(data)}],
        "bufferViews": views,
        "accessors": accessors,
    }))


def walked(number, above):
    """Name, mesh and matrix of a node that names one and of those below it, in the order of the file."""
    node = NODES[number]
    matrix = above @ matrix_of(node)
    found = [(node["name"], node["mesh"], matrix)] if "mesh" in node else []
    return found + [one for child in node.get("children", []) for one in walked(child, matrix)]


with tempfile.TemporaryDirectory() as made:
    folder = pathlib.Path(made)
    shapes = [("wall", *SOLID), ("roof", *SHEET)]
    write(folder / "named.gltf", NODES, [0, 1, 5], shapes)
    own = []
    for root in (0, 1, 5):
        for name, mesh, matrix in walked(root, numpy.eye(4)):
            points = numpy.c_[numpy.array(shapes[mesh][1], float), numpy.ones(len(shapes[mesh][1]))]
            own.append(("roof" if mesh == 1 else name, (points @ matrix.T)[:, :3], shapes[mesh][2]))
    check(len(own) == 5)
    alone = [{"name": f"node {i}", "mesh": i} for i in range(len(own))]
    write(folder / "alone.gltf", alone, list(range(len(own))), own)
    text = {}
    for file in ("named.gltf", "alone.gltf"):
        (folder / "scene.toml").write_text(HEAD.replace("FILE", file))
        done = program.run("scene", "info", folder / "scene.toml")
        notices = program.run("scene", "check", folder / "scene.toml")
        said = notices.stderr + notices.stdout
        dropped = re.findall(r"dropped \d of \d+ faces without area \(first: face \d+\)", said)
        text[file] = done.stdout, dropped
        check(len(dropped) == 1, notices.stderr)
    check(text["named.gltf"] == text["alone.gltf"], text)
    triangles = re.search(r"b +(\d+) triangles x 1", text["named.gltf"][0])
    check(triangles and int(triangles[1]) == 3 * 4 + 2 * 2, text)
print(f"mesh nodes: {program.checks} checks")
