#!/usr/bin/env python3
"""Bad input through the program (REQUIREMENTS section 4, Numbers in, Spectral, Geometry): one clear error that says
what, where, the value found and the way out; status 2; nothing written. Odd but right input renders. The library's own
tests of the same faults go deeper (scene_bad_input); here the whole way from the file to the exit status is shown.
usage: bad_input_test.py RAYCUBE"""

import pathlib
import struct
import sys
import tempfile

import numpy
from driver import Program, envi, scene

program = Program(sys.argv[1])
check = program.check

kDark = '{ name = "dark", reflectance = 0.10 }'
kDarkFile = (kDark, '{ name = "dark", file = "dark.csv" }')
kMesh = (
    "plane = [",
    'mesh = [{ name = "m", file = "m.obj", material = "dark" }]\ninstance = [{ mesh = "m" }]\nplane = [',
)
kRaster = ("plane = [", 'terrain = [{ raster = "dem.img", material = "dark" }]\nplane = [')
kAir = ('{ model = "none" }', "{ aod_550 = 0.1, spectral_step_nm = 20.0 }")
kSun = "sun = { zenith_deg = 40.0, azimuth_deg = 150.0 }"
kSquare = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def spectrum(rows):
    return {"dark.csv": "wavelength_nm,reflectance\n" + rows}


def header(samples, order=0):
    return (
        f"ENVI\nsamples = {samples}\nlines = {samples}\nbands = 1\ndata type = 4\ninterleave = bsq\n"
        f"byte order = {order}\n"
        "map info = {UTM, 1, 1, 276000, 4753000, 1, 1, 18, North, WGS-84}\n"
    )


# name: edits of the small scene, further files, what the message says (each part; file:line first)
kFaults = {
    "NaN": (
        [("500.0", "nan")],
        {},
        ["scene.toml:18:18: 'altitude_agl_m' is not a finite number (found nan); give a number > 0"],
    ),
    "infinity": (
        [("500.0", "inf")],
        {},
        ["scene.toml:18:18: 'altitude_agl_m' is not a finite number (found inf); give"],
    ),
    "negative": (
        [("gsd_m = 1.0", "gsd_m = -1.0")],
        {},
        ["scene.toml:19:9: 'gsd_m' is out of range (found -1); give a number > 0"],
    ),
    "wrong unit in a key": (
        [("gsd_m = 1.0", "gsd_cm = 100.0")],
        {},
        ["scene.toml:19:1: unknown key in [instrument] (found 'gsd_cm'); did you mean 'gsd_m'?"],
    ),
    "key without a word": (
        [("altitude_agl_m", "altitude_m")],
        {},
        ["scene.toml:18:1: unknown key in [instrument] (found 'altitude_m'); did you mean 'altitude_agl_m'?"],
    ),
    "wrong unit in a file": (
        [kDarkFile],
        spectrum("0.3,0.1\n2.5,0.2\n"),
        [
            "dark.csv:2: wavelength outside 0.05 .. 1000 um (found 3e-04 um, and at 1 more point); check the unit in "
            "the column's name"
        ],
    ),
    "nothing but NaN in a spectrum": (
        [kDarkFile],
        spectrum("300,nan\n500,nan\n2500,0.2\n"),
        ["dark.csv: a spectrum needs at least two points (found 1)"],
    ),
    "****** of Fortran": (
        [kDarkFile],
        spectrum("300,0.1\n500,******\n2500,0.2\n"),
        ["dark.csv:3: column 'reflectance': not a number (found '******'); give a number"],
    ),
    "reflectance above 1": (
        [kDarkFile],
        spectrum("300,0.1\n500,35\n2500,0.2\n"),
        ["dark.csv:3: reflectance outside 0 .. 1 (found 35); give scale = 0.01 if the file is in percent"],
    ),
    "unsorted": (
        [kDarkFile],
        spectrum("300,0.1\n200,0.1\n2500,0.2\n"),
        ["dark.csv:3: wavelengths are not ascending (found 0.2 um after 0.3 um); sort the file"],
    ),
    "0-byte spectrum": (
        [kDarkFile],
        {"dark.csv": ""},
        ["dark.csv: file is empty (found 0 bytes); restore it; ", "scene.toml:4:20 names it"],
    ),
    "missing spectrum": ([kDarkFile], {}, ["scene.toml:4:20: cannot read file (found ", "dark.csv); check the path"]),
    "spectrum that ends inside a band": (
        [kDarkFile],
        spectrum("300,0.1\n905,0.2\n"),
        [
            "'camera': the curve of material 'dark' covers 300 to 905 nm, a band needs more: it ends too early (found "
            "band 10 850 to 950 nm); take these bands out or give a wider curve"
        ],
    ),
    "0-byte simulation": (
        None,
        {"scene.toml": ""},
        ["scene.toml:1:1: file is empty (found 0 bytes); a simulation file begins with"],
    ),
    "UTF-16": (
        None,
        {"scene.toml": "format = 1\n".encode("utf-16")},
        ["scene.toml:1:1: TOML syntax: ", "see https://toml.io"],
    ),
    "syntax": ([("pixels = 24", "pixels = = 24")], {}, ["scene.toml:20:10: TOML syntax: "]),
    "cyclic include": (
        [("material = [", 'scene = { include = ["a.toml"] }\nmaterial = [')],
        {"a.toml": 'format = 1\nscene = { include = ["scene.toml"] }\n'},
        ["a.toml:2:22: include runs in a circle (found scene.toml -> a.toml -> scene.toml); remove one"],
    ),
    "NaN vertex": (
        [kMesh],
        {"m.obj": "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n"},
        ["m.obj:3: vertex is not finite (found nan); correct the line"],
    ),
    "face index": (
        [kMesh],
        {"m.obj": kSquare + "f 1 2 7\n"},
        ["m.obj:4: face index out of range (found '7' with 3 vertices); indices run from 1"],
    ),
    "zero-area face": (
        [kMesh, ("material = [", "scene = { strict = true }\nmaterial = [")],
        {"m.obj": "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"},
        ["m.obj: face 0: face has no area (found 3 corners); remove it, or set scene.strict = false"],
    ),
    "10 GB in a small header": (
        [kRaster],
        {"dem.img": b"x" * 100, "dem.hdr": header(50000)},
        ["dem.img: GDAL cannot read the raster (found Image file is too small); ", "scene.toml:8:14 names it"],
    ),
    "truncated file": (
        [("plane = [", 'terrain = [{ raster = "d.asc", material = "dark" }]\nplane = [')],
        {"d.asc": "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4\n"},
        ["d.asc: GDAL cannot read the raster (found it holds 4 numbers, its header counts 16)"],
    ),
    "wrong endianness": (
        [(kDark, '{ name = "dark", file = "l.sli", spectrum = "a" }')],
        {
            "l.sli": struct.pack(">2f", 0.1, 0.2),
            "l.sli.hdr": "ENVI\nsamples = 2\nlines = 1\nbands = 1\nfile type = ENVI Spectral Library\ndata type = 4\n"
            "interleave = bsq\nbyte order = 0\nwavelength units = Nanometers\nwavelength = {300, 2500}\n"
            "spectra names = {a}\n",
        },
        [
            "l.sli: spectrum 'a', sample 1: reflectance outside 0 .. 1 (found -429492128, and at 1 more point); "
            "correct it"
        ],
    ),
    "negative width": (
        [('bands = { first_nm = 450.0, step_nm = 50.0, count = 10, fwhm_nm = 20.0 }', 'bands = "b.csv"')],
        {"b.csv": "center_nm,fwhm_nm\n500,10\n500,10\n600,-5\n"},
        ["b.csv:4: column 'fwhm_nm': band width must be above 0 (found -5); give the band's FWHM"],
    ),
    "band outside the table": (
        [("first_nm = 450.0", "first_nm = 31000.0"), kAir],
        {},
        ["the layered model covers 0.3 to 30 um and ends there (found 30.95", "import a table"],
    ),
    "no table": (
        [('{ model = "none" }', '{ tables = "a.rct" }')],
        {"a.rct": "garbage"},
        ["a.rct: is no render table: shorter than its 64-byte head (found 7 bytes); build or import the table again"],
    ),
    "time without a place": (
        [(kSun, 'utc = "2012-09-20T15:30:00Z"')],
        {},
        ["scene.toml:14:10: the sun at a time needs a place on earth (found no epsg"],
    ),
    "no such time": (
        [
            (kSun, 'utc = "2012-13-20T15:30:00Z"'),
            ("material = [", "scene = { origin = { latitude_deg = 43.0, longitude_deg = -77.0 } }\nmaterial = ["),
        ],
        {},
        ["scene.toml:15:10: ", "2012-13-20T15:30:00Z", 'write it as "2012-09-20T15:30:00Z"'],
    ),
    "earth-centred coordinates": (
        [("material = [", "scene = { origin = { epsg = 4978, easting_m = 6.4e6 } }\nmaterial = [")],
        {},
        ["scene.toml:3:22: not a projected system", "use a projected system in metres, like EPSG:32618"],
    ),
    "view at the horizon": (
        [
            ("altitude_agl_m = 500.0", "position_m = [0.0, 0.0, 5.0]\npitch_deg = 90.0"),
            ("gsd_m = 1.0", "ifov_mrad = 1.0"),
        ],
        {},
        ["'camera': line 0, sample 0 looks up or level", "reduce roll, pitch or the field of view"],
    ),
    "target above the sensor": (
        [("altitude_agl_m = 500.0", "position_m = [0.0, 0.0, -5.0]"), ("gsd_m = 1.0", "ifov_mrad = 1.0"), kAir],
        {},
        ["no target may lie above the sensor (-5.0 m)", "raise the sensor"],
    ),
    "folder as a name": (
        [('name = "camera"', 'name = "../x"')],
        {},
        ["scene.toml:16:1: an instrument's name is a folder's (found '../x'); use letters, digits"],
    ),
}

def written(folder, edits, files):
    path = scene(folder, "scene.toml")
    text = path.read_text()
    for before, after in edits or []:
        assert before in text, before
        text = text.replace(before, after, 1)
    path.write_text(text)
    for name, content in files.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


for name, (edits, files, says) in kFaults.items():
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        path = written(work, edits, files)
        before = sorted(work.iterdir())
        program.refused("render", path, "-o", work / "out", status=2, says=says)
        check(sorted(work.iterdir()) == before, name)

# A terrain that cannot be read is one problem, not one more for everything that stands on it.
with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    path = written(work, [kRaster, ("size_m = [10.0, 40.0] }", "size_m = [10.0, 40.0], on_terrain = true }")], {})
    program.refused(
        "render", path, "-o", work / "out", status=2, says=["scene.toml:8:14: cannot read file (found ", "dem.img"]
    )

# Every problem of a file in one run, in one go
with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    path = written(
        work,
        [("gsd_m = 1.0", "gsd_m = -1.0"), kDarkFile, kMesh, ("pixels = 24", "pixels = 0")],
        {**spectrum("300,-0.1\n2500,0.2\n"), "m.obj": kSquare + "f 1 2 7\n"},
    )
    program.refused(
        "render",
        path,
        "-o",
        work / "out",
        status=2,
        messages=4,
        says=[
            "'gsd_m' is out of range",
            "dark.csv:2: reflectance outside",
            "m.obj:4: face index",
            "'pixels' is out of range",
        ],
    )


def rendered(edits, files=None):
    """Radiance and the truth layers by name."""
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        program.run("render", written(work, edits, files or {}), "-o", work / "out")
        names, truth = envi(work / "out" / "camera", "truth")
        return envi(work / "out" / "camera", "radiance")[1], {
            text.split()[0]: truth[:, :, i] for i, text in enumerate(names["band names"])
        }


# Odd but right: an empty scene shows the air alone (below the open panels' radiance everywhere) and nothing without
# air; one triangle covers its area: 18 m2, of 1 m pixels sampled 3 x 3, so to within half a sample row along its 21 m
# outline.
planes = scene(tempfile.gettempdir(), "raycube-bad-input.toml")
text = planes.read_text()
planes.unlink()
strips = text[text.index("plane = [") : text.index("]\natmosphere") + 2]
radiance, truth = rendered([(strips, "")])
check((radiance == 0).all() and (truth["hit_fraction"] == 0).all() and numpy.isnan(truth["x_m"]).all())
air, truth = rendered([(strips, ""), kAir])
full, _ = rendered([kAir])
check((air > 0).all() and (air < full).all() and (truth["hit_fraction"] == 0).all())
triangle = (strips, 'mesh = [{ name = "m", file = "m.obj", material = "light" }]\ninstance = [{ mesh = "m" }]\n')
radiance, truth = rendered([triangle], {"m.obj": "v -3 -3 0\nv 3 -3 0\nv 0 3 0\nf 1 2 3\n"})
check(abs(truth["abundance_light"].sum() - 18) < 21 / 6 and (radiance[truth["hit_fraction"] == 0] == 0).all())

# A sensor inside a closed box sees its floor, dark: without air exactly, and the roof above the sensor is no target.
box = (strips, 'box = [{ material = "light", position_m = [0, 0, 0], size_m = [100, 100, 600] }]\n')
radiance, truth = rendered([box])
check((radiance == 0).all() and (truth["hit_fraction"] == 1).all() and numpy.abs(truth["z_m"]).max() < 1e-3)
radiance, truth = rendered([box, kAir])
check((truth["sun_fraction"] == 0).all() and (truth["hit_fraction"] == 1).all() and numpy.isfinite(radiance).all())

# Sun on and below the horizon without air: night. A grazing sun of 89.9 degrees: cos(89.9) of what the zenith sun
# gives.
for zenith in (90.0, 95.0):
    radiance, truth = rendered([("zenith_deg = 40.0", f"zenith_deg = {zenith}")])
    check((radiance == 0).all() and (truth["sun_fraction"] == 0).all() and (truth["hit_fraction"] == 1).all())
low, truth = rendered([("zenith_deg = 40.0", "zenith_deg = 89.9")])
high, _ = rendered([("zenith_deg = 40.0", "zenith_deg = 0.0")])
# 1e-4: the cosine is that of a unit vector in floats, whose z of 0.001745 steps by 1e-10 but whose length is off by
# 6e-8.
check((truth["sun_fraction"] == 1).all() and numpy.abs(low / high / numpy.cos(numpy.radians(89.9)) - 1).max() < 1e-4)
print(f"bad input: {len(kFaults)} faults, {program.checks} checks")
