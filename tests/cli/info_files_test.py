"""`raycube info` of what is no ENVI: pictures (OpenEXR, PNG, TIFF) against the cube they are of and against what was
written into them; meshes by the names that a scene may use; spectra. usage: info_files_test.py RAYCUBE"""

import base64
import json
import pathlib
import struct
import sys
import tempfile
import zlib

import numpy

from driver import Program, envi, scene

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused


def told(file, *more):
    return json.loads(run("info", "--json", file, *more).stdout)


def same(found, values, what):
    """Statistics against numpy's; of single precision, summed in double."""
    finite = values[numpy.isfinite(values)].astype(float)
    check(found["count"] == finite.size and found["not_finite"] == values.size - finite.size, what, found)
    if finite.size == 0:
        return
    check(found["min"] == finite.min() and found["max"] == finite.max(), what, found)
    check(abs(found["mean"] - finite.mean()) <= 1e-12 * max(1, abs(finite).max()), what, found, finite.mean())


def exr(folder):
    """Channels of a render's preview.exr are its cube's shown bands and its truth."""
    run("render", scene(folder, "strips.toml"), "-o", folder / "out", "-q")
    out = folder / "out/camera"
    picture = told(out / "preview.exr")
    check((picture["kind"], picture["format"]) == ("picture", "OpenEXR"), picture)
    parts = {part["name"]: part for part in picture["parts"]}
    check(all((part["width"], part["height"]) == (24, 12) for part in parts.values()), parts)
    header, truth = envi(out, "truth")
    cube = envi(out, "radiance")[1]
    channels = [channel for part in parts.values() for channel in part["channels"]]
    check({channel["type"] for channel in channels} == {"float"}, channels)
    found = 0
    layers = [cube[..., b] for b in range(cube.shape[2])] + [truth[..., b] for b in range(truth.shape[2])]
    sums = [(numpy.isfinite(layer).sum(), numpy.nanmin(layer), numpy.nanmax(layer)) for layer in layers
            if numpy.isfinite(layer).any()]
    for channel in channels:
        at = channel["statistics"]
        if at["count"]:
            check((at["count"], at["min"], at["max"]) in sums, channel)
            found += 1
    check(found >= 5 and len(parts) == 2, parts)
    text = run("info", out / "preview.exr").stdout
    check("OpenEXR" in text and "24 x 12 pixels" in text and all(name in text for name in parts), text)
    bare = told(out / "preview.exr", "--header")
    check("statistics" not in bare["parts"][0]["channels"][0], bare)

    # The quicklook: each of 24 x 12 pixels as 21 x 21, so that it is seen; its text says what it shows.
    look = told(out / "quicklook.png")
    part = look["parts"][0]
    check(look["format"].startswith("Portable Network Graphics"), look)
    check((part["width"], part["height"]) == (504, 252) and len(part["channels"]) == 3, part)
    check([channel["name"] for channel in part["channels"]] == ["Red", "Green", "Blue"], part)
    check("each pixel as 21 x 21" in part["texts"]["Description"], part)
    check(part["channels"][0]["statistics"]["count"] == 504 * 252, part)

    (folder / "text.exr").write_text("no picture\n")
    refused("info", folder / "text.exr", status=2, says=["text.exr", "cannot read it"])
    # Cut short: one error, and no statistics of what is not there.
    for name in ("preview.exr", "quicklook.png"):
        whole = (out / name).read_bytes()
        (folder / name).write_bytes(whole[: len(whole) // 2])
        refused("info", folder / name, status=2, says=[name, "cannot read it"])


def png(folder):
    """16-bit grey with a text, written by hand."""
    values = (numpy.arange(12).reshape(3, 4) * 5000).astype(">u2")

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in values)
    file = folder / "grey.picture"  # known by what it holds, not by its name
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 3, 16, 0, 0, 0, 0))
        + chunk(b"tEXt", b"Author\0nobody") + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    )
    part = told(file)["parts"][0]
    check((part["width"], part["height"], part["texts"]["Author"]) == (4, 3, "nobody"), part)
    check([channel["type"] for channel in part["channels"]] == ["UInt16"], part)
    same(part["channels"][0]["statistics"], values, part)
    text = run("info", file).stdout
    check("4 x 3 pixels, 1 channel, UInt16" in text and "55000" in text and "nobody" in text, text)


OBJ = """o house
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
g walls north
usemtl brick
f 1 2 3
g roof
usemtl tile
f 1 3 4
f 2 3 4
"""


def gltf(path):
    """One triangle, y up as the format is, hung twice: from a node Trunk below Tree, and from Crown."""
    data = struct.pack("<9f3H", 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 1, 2)
    path.write_text(json.dumps({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 2]}],
        "nodes": [
            {"name": "Tree", "children": [1]},
            {"name": "Trunk", "mesh": 0},
            {"name": "Crown", "mesh": 0, "translation": [0, 2, 0]},
        ],
        "meshes": [{"name": "cone", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(data),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
                        {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, -1], "max": [1, 0, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
    }))


def meshes(folder):
    (folder / "house.obj").write_text(OBJ)
    gltf(folder / "tree.gltf")
    house = told(folder / "house.obj")
    check((house["kind"], house["triangles"], house["low"], house["high"]) == ("mesh", 3, [0, 0, 0], [1, 1, 0]), house)
    names = {tuple(part["names"]): part["triangles"] for part in house["parts"] if part["triangles"]}
    check(sorted(names.values()) == [1, 2], house)
    walls = next(part for part in names if "brick" in part)
    check(names[walls] == 1 and {"walls north", "walls", "north"} <= set(walls), house)
    check(any({"tile", "roof"} <= set(part) and names[part] == 2 for part in names), house)
    tree = told(folder / "tree.gltf")
    by_names = [set(part["names"]) for part in tree["parts"]]
    check(any({"cone", "Trunk", "Tree"} <= part for part in by_names), tree)
    check(any({"cone", "Crown"} <= part and "Tree" not in part for part in by_names), tree)
    check("Trunk" in run("info", folder / "tree.gltf").stdout)

    def materials(file, of):
        path = folder / "named.toml"
        path.write_text(
            'format = 1\nmaterial = [{ name = "dark", reflectance = 0.1 }, { name = "light", reflectance = 0.8 }]\n'
            f'mesh = [{{ name = "m", file = "{file}", materials = {of} }}]\n'
            'instance = [{ mesh = "m", position_m = [0.0, 0.0, 0.0], scale = 40.0 }]\natmosphere = { model = "none" }\n'
            "time = { sun = { zenith_deg = 20.0, azimuth_deg = 150.0 } }\n"
            '[[instrument]]\nname = "camera"\nkind = "framing"\naltitude_agl_m = 500.0\ngsd_m = 4.0\npixels = 16\n'
            "lines = 16\nsamples = { grid = [2, 2] }\n"
            "bands = { first_nm = 500.0, step_nm = 100.0, count = 1, fwhm_nm = 20.0 }\n"
        )
        return path

    def shares(file, of):
        """Pixels that each of dark and light covers."""
        run("render", materials(file, of), "-o", folder / "named", "-q", "--overwrite")
        header, truth = envi(folder / "named/camera", "truth")
        layer = {name.split(" ")[0]: b for b, name in enumerate(header["band names"])}
        return [truth[..., layer[f"abundance_{name}"]].sum() for name in ("dark", "light")]

    # A node's own name goes before that of the node it hangs from; a group may be named by one of its names.
    dark, light = shares("tree.gltf", '{ Crown = "light", Tree = "dark" }')
    check(light > 0 and abs(dark) < 1e-6, dark, light)  # the crown hides the trunk from above
    dark, light = shares("tree.gltf", '{ Crown = "dark", Tree = "light", Trunk = "dark" }')
    check(dark > 0 and abs(light) < 1e-6, dark, light)
    dark, light = shares("house.obj", '{ north = "dark", roof = "light" }')
    check(dark > 0 and light > 0, dark, light)
    refused("scene", "check", materials("tree.gltf", '{ Crown = "light", Branch = "dark" }'), status=2, messages=2,
            says=["no material, group or node of that name", "'Branch'", "Crown", "Tree", "Trunk", "cone"])
    (folder / "empty.obj").write_text("")
    refused("info", folder / "empty.obj", status=2, says=["empty.obj", "empty"])


def spectra(folder):
    """Every spectrum of a file that a material may name, in vacuum um; the keys of the format as data."""
    (folder / "two.csv").write_text("wavelength_nm,grass,soil\n400,0.1,0.2\n700,0.15,0.3\n1000,0.5,0.4\n")
    both = told(folder / "two.csv")["spectra"]
    check([len(one["reflectance"]["value"]) for one in both] == [3, 3] and "grass" in both[0]["source"], both)
    same(both[1]["reflectance"]["statistics"], numpy.array([0.2, 0.3, 0.4]), both)
    check(numpy.allclose(both[0]["reflectance"]["wavelength_um"], [0.4, 0.7, 1.0], rtol=0, atol=1e-12), both)
    (folder / "leaf.csv").write_text("wavelength_um,reflectance,transmittance\n0.4,0.1,0.2\n0.9,0.5,0.4\n")
    leaf = told(folder / "leaf.csv")["spectra"]
    check(len(leaf) == 1 and leaf[0]["transmittance"]["value"] == [0.2, 0.4], leaf)
    check("transmittance" in run("info", folder / "leaf.csv").stdout)
    (folder / "bad.csv").write_text("wavelength_um,reflectance\n0.4,0.1\n0.3,1.2\n")
    refused("info", folder / "bad.csv", status=2, messages=2, says=["not ascending", "outside 0 .. 1"])

    tables = {table["table"]: table["keys"] for table in json.loads(run("scene", "keys", "--json").stdout)["tables"]}
    keys = {key["key"]: key for key in tables[""]}
    check(keys["tolerance"]["default"] == 0.01 and keys["tolerance_of"]["range"] == "rms, p99, worst", keys)
    text = run("scene", "keys").stdout
    check(all(f"| `{key['key']}` |" in text for keys in tables.values() for key in keys), "keys that the pages lack")


with tempfile.TemporaryDirectory() as temporary:
    exr(pathlib.Path(temporary))
    png(pathlib.Path(temporary))
    meshes(pathlib.Path(temporary))
    spectra(pathlib.Path(temporary))
print(f"info_files: {program.checks} checks")
