#!/usr/bin/env python3
"""What further formats of rasters declare of their numbers: units and scales that GDAL's drivers leave out, sources of
virtual rasters, counts of text grids, no data in maps, rows from south to north. Oracle: the same slope in another
format. usage: raster_declarations_test.py RAYCUBE"""

import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi, tiff

program = Program(sys.argv[1])
run, check = program.run, program.check

SCENE = """format = 1
sky_directions = 16
bounces = 0
time = {{ sun = {{ zenith_deg = 30.0, azimuth_deg = 120.0 }} }}
atmosphere = {{ model = "none" }}
scene = {{ origin = {{ epsg = 32632, easting_m = 500000.0, northing_m = 5400000.0 }} }}
material = [ {{ name = "m", reflectance = 0.5 }} ]
[[terrain]]
raster = "{raster}"
{surface}
[[instrument]]
name = "camera"
kind = "framing"
position_m = [0.0, 0.0, 10000.0]
ifov_mrad = 0.5
pixels = 4
lines = 4
samples = {{ grid = [1, 1] }}
exr = false
bands = {{ first_nm = 550.0, step_nm = 100.0, count = 1, fwhm_nm = 10.0 }}
"""
SIZE = 5
X = numpy.array([-20.0, -10, 0, 10, 20])
HEIGHT = 100 + 0.2 * X[None, :] + 0.1 * X[::-1, None]  # the first row is the northern one
FOOT_M = 0.3048
WEST, NORTH = 499975, 5400025
UTM = "map info = {UTM, 1, 1, 499975, 5400025, 10, 10, 32, North, WGS-84, units=Meters}\n"


def rows_of(values):
    return "".join(" ".join(f"{value:.10g}" for value in row) + "\n" for row in values)


def esri(values):
    return f"ncols {SIZE}\nnrows {SIZE}\nxllcorner {WEST}\nyllcorner {NORTH - 50}\ncellsize 10\n" + rows_of(values)


def grass(values, more=""):
    edges = f"north: {NORTH}\nsouth: {NORTH - 50}\neast: {WEST + 50}\nwest: {WEST}\n"
    return edges + f"rows: {SIZE}\ncols: {SIZE}\n{more}" + rows_of(values)


def surfer(values):
    edges = f"{WEST + 5} {WEST + 45}\n{NORTH - 45} {NORTH - 5}\n"
    return f"DSAA\n{SIZE} {SIZE}\n{edges}{values.min()} {values.max()}\n" + rows_of(values[::-1])


def saga(folder, values, unit="", factor=1):
    values[::-1].astype("<f4").tofile(folder / "s.sdat")
    (folder / "s.sgrd").write_text(
        f"NAME\t= s\nUNIT\t= {unit}\nDATAFILE_OFFSET\t= 0\nDATAFORMAT\t= FLOAT\nBYTEORDER_BIG\t= FALSE\n"
        f"POSITION_XMIN\t= {WEST + 5}\nPOSITION_YMIN\t= {NORTH - 45}\nCELLCOUNT_X\t= {SIZE}\nCELLCOUNT_Y\t= {SIZE}\n"
        f"CELLSIZE\t= 10\nZ_FACTOR\t= {factor}\nNODATA_VALUE\t= -99999\nTOPTOBOTTOM\t= FALSE\n"
    )


def raw(folder, name, values, more="", dtype=">f4", code=4):
    (folder / name).write_bytes(values.astype(dtype).tobytes())
    (folder / f"{name}.hdr").write_text(
        f"ENVI\nsamples = {SIZE}\nlines = {SIZE}\nbands = 1\ndata type = {code}\ninterleave = bsq\nbyte order = 1\n"
        + UTM
        + more
    )


def virtual(source, transform=(WEST, 10, 0, NORTH, 0, -10), kind="Float32", more=""):
    return (
        f'<VRTDataset rasterXSize="{SIZE}" rasterYSize="{SIZE}"><SRS>EPSG:32632</SRS>'
        f'<GeoTransform>{", ".join(map(str, transform))}</GeoTransform>'
        f'<VRTRasterBand dataType="{kind}" band="1">{more}<SimpleSource><SourceFilename relativeToVRT="1">{source}'
        "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"
    )


def terrain(folder, raster, surface='material = "m"'):
    file = folder / "scene.toml"
    file.write_text(SCENE.format(raster=raster, surface=surface))
    return file


def told(file, *says, status=0):
    done = run("scene", "check", file, status=status)
    for part in says:
        check(part in done.stderr + done.stdout, part, done.stderr, done.stdout)
    return done


def seen(folder, file):
    run("render", file, "-o", folder / "out", "--overwrite", "-q")
    header, truth = envi(folder / "out/camera", "truth")
    names = [name.split(" ")[0] for name in header["band names"]]
    return truth[:, :, names.index("z_m")]


def numbers(folder):
    """Units and scales, wherever the format keeps them."""
    (folder / "plain.asc").write_text(esri(HEIGHT))
    right = seen(folder, terrain(folder, "plain.asc"))

    def same(name, *says):
        file = terrain(folder, name)
        check(abs(seen(folder, file) - right).max() < 1e-3, name)
        told(file, *says)

    raw(folder, "e.dat", HEIGHT / FOOT_M, "data units = Feet\n")
    same("e.dat", "heights in 'Feet'")
    raw(folder, "e.dat", 10 * HEIGHT, "reflectance scale factor = 10\n")
    same("e.dat", "times 0.1")
    saga(folder, HEIGHT / FOOT_M, unit="ft")
    same("s.sdat", "heights in 'ft'")
    saga(folder, 100 * HEIGHT, factor=0.01)
    same("s.sdat", "times 0.01")
    (folder / "old.asc").write_text(esri(HEIGHT / FOOT_M))
    (folder / "old.prj").write_text("Projection UTM\nZone 32\nDatum WGS84\nZunits FEET\nUnits METERS\nParameters\n")
    same("old.asc", "heights in 'feet'")
    (folder / "g.asc").write_text(grass(HEIGHT))
    same("g.asc")
    (folder / "g.asc").write_text(grass(10 * HEIGHT, "multiplier: 0.1\n"))
    same("g.asc", "times 0.1")
    (folder / "g.grd").write_text(surfer(HEIGHT))
    same("g.grd")


def counts(folder):
    """Text grids hold the numbers that their headers count, also where a virtual raster is made of them."""
    for name, whole in (("g.asc", grass(HEIGHT)), ("g.grd", surfer(HEIGHT)), ("w.asc", esri(HEIGHT))):
        for text, says in (
            (whole.replace("100", "water", 1), "'water' is no number"),
            (whole.rsplit(" ", 1)[0] + "\n", f"{SIZE * SIZE - 1} numbers, its header counts {SIZE * SIZE}"),
            (whole + "7 8\n", f"{SIZE * SIZE + 2} numbers, its header counts {SIZE * SIZE}"),
        ):
            (folder / name).write_text(text)
            told(terrain(folder, name), says, status=2)
    (folder / "v.vrt").write_text(virtual("w.asc"))
    (folder / "outer.vrt").write_text(virtual("v.vrt"))
    for name in ("v.vrt", "outer.vrt"):
        told(terrain(folder, name), "its source", "w.asc: it holds", status=2)
    raw(folder, "e.dat", HEIGHT)
    (folder / "v.vrt").write_text(virtual("e.dat"))
    told(terrain(folder, "v.vrt"))
    (folder / "e.dat").write_bytes((folder / "e.dat").read_bytes()[:-10])
    told(terrain(folder, "v.vrt"), "e.dat: the file ends after 90 of 100 bytes", status=2)


def sources(folder):
    """What all sources of a virtual raster declare of their numbers is true of its own; where they differ, and what it
    leaves out besides, is told by name."""
    (folder / "plain.asc").write_text(esri(HEIGHT))
    right = seen(folder, terrain(folder, "plain.asc"))
    source = virtual("SOURCE")
    part = source[source.index("<SimpleSource>") : source.index("</VRTRasterBand>")]

    def mosaic(*names):
        (folder / "v.vrt").write_text(source.replace(part, "".join(part.replace("SOURCE", name) for name in names)))
        return terrain(folder, "v.vrt")

    for more, factor, says in (
        ("data gain values = {0.5}\ndata offset values = {30}\n", 0.5, "times 0.5 plus 30"),
        ("data units = ft\n", FOOT_M, "heights in 'ft'"),
    ):
        for name in ("e.dat", "f.dat"):
            raw(folder, name, (HEIGHT - (30 if factor == 0.5 else 0)) / factor, more)
        for names in (("e.dat",), ("e.dat", "f.dat")):
            file = mosaic(*names)
            check(abs(seen(folder, file) - right).max() < 1e-3, more, names)
            told(file, says, "1 notice")
        (folder / "outer.vrt").write_text(virtual("v.vrt"))
        file = terrain(folder, "outer.vrt")
        check(abs(seen(folder, file) - right).max() < 1e-3, more, "outer")
        told(file, says, "1 notice")
    # Feet in one and metres in the other, by any name; and none in the other.
    raw(folder, "f.dat", HEIGHT, "data units = m\n")
    told(mosaic("e.dat", "f.dat"), "2 of its sources, ", "declare a unit", "f.dat has 1 m", "e.dat has 0.3048 m")
    raw(folder, "e.dat", HEIGHT, "data units = metre\n")
    check("differ" not in told(mosaic("e.dat", "f.dat"), "0 notices").stderr)
    raw(folder, "e.dat", HEIGHT, "data gain values = {1.5}\n")
    raw(folder, "f.dat", HEIGHT)
    told(mosaic("e.dat", "f.dat"), "e.dat declares a scale", "f.dat has none", "e.dat has scale 1.5 and offset 0")
    # Numbers that it makes anew are no source's.
    (folder / "v.vrt").write_text(virtual("e.dat").replace("SimpleSource", "ComplexSource").replace(
        "<SourceBand>1</SourceBand>", "<SourceBand>1</SourceBand><ScaleOffset>5</ScaleOffset>"))
    told(terrain(folder, "v.vrt"), "e.dat declares a scale or an offset, which the virtual raster leaves out")
    raw(folder, "e.dat", HEIGHT, "data ignore value = 100\n")
    (folder / "v.vrt").write_text(virtual("e.dat"))
    told(terrain(folder, "v.vrt"), "e.dat", "declares pixels without data", "the virtual raster leaves out")
    raw(folder, "e.dat", HEIGHT, "data ignore value = -9\n")
    told(terrain(folder, "v.vrt"), "0 notices")  # no pixel has it
    tiff(folder / "t.tif", HEIGHT, 6)
    (folder / "v.vrt").write_text(virtual("t.tif"))
    told(terrain(folder, "v.vrt"), "t.tif declares an orientation")
    (folder / "t.tif").unlink()
    raw(folder, "e.dat", HEIGHT)
    (folder / "v.vrt").write_text(virtual("e.dat", kind="Int64"))
    told(terrain(folder, "v.vrt"))
    (folder / "v.vrt").write_text(virtual("e.dat", kind="CFloat32"))
    told(terrain(folder, "v.vrt"), "it holds complex numbers", status=2)
    raw(folder, "e.dat", HEIGHT, dtype=">c8", code=6)
    (folder / "v.vrt").write_text(virtual("e.dat"))
    told(terrain(folder, "v.vrt"), "e.dat: it holds complex numbers", status=2)
    # Many sources, some by many ways: each is opened once, and one sentence has their number.
    (folder / "tiles").mkdir()
    names = [f"tiles/{i}.dat" for i in range(60)]
    for name in names:
        raw(folder, name, HEIGHT, "data units = ft\n")
    raw(folder, "tiles/60.dat", HEIGHT)
    told(mosaic(*names, "tiles/60.dat"), "60 of its sources, ", "declare a unit", "60.dat has none", "1 notice")
    told(mosaic(*names), "heights in 'ft'", "1 notice")
    inner = names[0]
    for name in ("a.vrt", "b.vrt", "c.vrt"):
        (folder / name).write_text(source.replace(part, 30 * part.replace("SOURCE", inner)))
        inner = name
    told(terrain(folder, inner), "1 notice")


def integers(folder):
    """Numbers that GDAL's integers do not hold are read as they stand, or refused in a virtual raster."""
    whole = numpy.full((SIZE, SIZE), 50.0)
    text = esri(whole)
    (folder / "fifty.asc").write_text(text)
    last = text.rstrip("\n").rsplit(" ", 1)[0] + " "
    for word, says in (
        ("nan", "1 of 25"),
        ("inf", "1 of 25"),
        ("4294967346", "row 4, column 4: height is out of range (found 4294967346)"),
    ):
        (folder / "w.asc").write_text(last + word + "\n")
        told(terrain(folder, "w.asc"), says, status=2)
        (folder / "v.vrt").write_text(virtual("w.asc"))
        told(terrain(folder, "v.vrt"), f"'{word}' is read as another number (row 4, column 4", status=2)
    first = text.replace(text.split("cellsize 10\n")[1], "nan " + text.split("cellsize 10\n")[1].split(" ", 1)[1])
    (folder / "w.asc").write_text(first)
    told(terrain(folder, "w.asc"), "'nan' is taken by GDAL for a word of the header", "row 0, column 0", status=2)
    (folder / "w.asc").write_text(first.replace("nan", "-nan"))
    told(terrain(folder, "w.asc"), "row 0, column 0: terrain has posts without data (found 1 of 25)", status=2)
    (folder / "w.asc").write_text(last.replace("cellsize 10", "cellsize 10\nNODATA_value nan") + "nan\n")
    told(terrain(folder, "w.asc"), "1 of 25", status=2)
    classes = 'class_map = "c.asc"\nmaterials = { 1 = "m" }'
    ones = numpy.ones((SIZE, SIZE))
    ones[2, 2] = numpy.nan
    (folder / "c.asc").write_text(esri(ones))
    told(terrain(folder, "fifty.asc", classes), "class has no material (found nan on 1 cell)", status=2)


def signed_bytes(folder):
    """Bytes of -128 to 127, which GDAL before 3.7 hands on as 0 to 255."""
    (folder / "plain.asc").write_text(esri(numpy.round(HEIGHT) - 105))
    right = seen(folder, terrain(folder, "plain.asc"))
    (folder / "b.hdr").write_text(
        f"nrows {SIZE}\nncols {SIZE}\nnbands 1\nnbits 8\npixeltype SIGNEDINT\nbyteorder I\nlayout BIL\n"
        f"ulxmap {WEST + 5}\nulymap {NORTH - 5}\nxdim 10\nydim 10\n"
    )
    (folder / "b.bil").write_bytes((numpy.round(HEIGHT) - 105).astype("i1").tobytes())
    check(abs(seen(folder, terrain(folder, "b.bil")) - right).max() < 1e-3, right)
    (folder / "v.vrt").write_text(virtual("b.bil"))
    told(terrain(folder, "v.vrt"), "b.bil: its numbers are signed bytes", status=2)


def maps(folder):
    """Classes and fractions without data."""
    (folder / "plain.asc").write_text(esri(HEIGHT))
    (folder / "c.asc").write_text(esri(numpy.ones((SIZE, SIZE))))
    empty = "<NoDataValue>1</NoDataValue>"
    (folder / "c.vrt").write_text(virtual("c.asc", kind="Byte", more=empty))
    classes = 'class_map = "c.vrt"\nmaterials = { 1 = "m" }'
    told(terrain(folder, "plain.asc", classes), "cells lie where the class map declares no data")
    mixture = 'mixture_map = "c.vrt"\nmaterials = { 1 = "m" }'
    told(terrain(folder, "plain.asc", mixture), "fraction without data", status=2)
    (folder / "c.vrt").write_text(virtual("c.asc", kind="Byte"))
    check("no data" not in told(terrain(folder, "plain.asc", classes)).stderr)
    one = virtual("c.asc").replace(f'Size="{SIZE}"', 'Size="10000"')
    band = one[one.index("<VRTRasterBand") : one.index("</VRTDataset>")]
    bands = "".join(band.replace('band="1"', f'band="{b}"') for b in (1, 2, 3))
    (folder / "c.vrt").write_text(one.replace(band, bands))
    told(terrain(folder, "plain.asc", mixture), "at most 89478485 pixels in each of 3 bands", status=2)


def south_first(folder):
    """A texture whose map coordinates say that its first row is the southern one."""
    (folder / "family.csv").write_text("wavelength_nm,a,b\n400,0.1,0.8\n900,0.1,0.8\n")
    values = numpy.zeros((SIZE, SIZE))
    values[0] = 255
    (folder / "north.asc").write_text(esri(values))
    (folder / "south.asc").write_text(esri(values[::-1]))
    (folder / "n.vrt").write_text(virtual("north.asc", kind="Byte"))
    (folder / "s.vrt").write_text(virtual("south.asc", (WEST, 10, 0, NORTH - 50, 0, 10), kind="Byte"))
    light = {}
    for name in ("n.vrt", "s.vrt"):
        text = SCENE.format(raster="none", surface="").replace('[[terrain]]\nraster = "none"\n', "")
        file = folder / "texture.toml"
        file.write_text(
            text.replace(
                "reflectance = 0.5",
                f'family = "family.csv", texture = {{ image = "{name}", texel_m = 2.0, choose = "nearest", '
                "band_nm = [540.0, 560.0] }",
            ).replace("[[instrument]]", '[[plane]]\nmaterial = "m"\nsize_m = [10.0, 10.0]\n[[instrument]]')
            .replace("10000.0]", "100.0]").replace("0.5", "25.0")
        )
        run("render", file, "-o", folder / "out", "--overwrite", "-q")
        light[name] = envi(folder / "out/camera", "radiance")[1]
        told(file, *(["its first row is the southern one"] if name == "s.vrt" else []))
    check(light["n.vrt"].max() > 4 * light["n.vrt"].min(), light)
    check((light["n.vrt"] == light["s.vrt"]).all(), light)


for case in (numbers, counts, integers, signed_bytes, sources, maps, south_first):
    with tempfile.TemporaryDirectory() as made:
        case(pathlib.Path(made))
print(f"raster declarations: {program.checks} checks")
