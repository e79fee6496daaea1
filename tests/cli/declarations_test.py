#!/usr/bin/env python3
"""What files declare of their numbers is applied, refused by name, or told: scale, offset, unit, mask, alpha, nodata
and reference system of rasters, bits of pictures, axis and unit of meshes, percent of spectra. Oracles: the same thing
told in another way, whose truth and radiance are known in closed form. usage: declarations_test.py RAYCUBE"""

import base64
import pathlib
import sys
import tempfile
import zipfile

import numpy

from analysis_kit import write_cube
from driver import Program, envi, tiff

program = Program(sys.argv[1])
run, check = program.run, program.check

HEAD = """format = 1
sky_directions = 16
bounces = 0
time = {{ sun = {{ zenith_deg = 30.0, azimuth_deg = 120.0 }} }}
atmosphere = {{ model = "none" }}
scene = {{ origin = {{ {origin} }} }}
"""
UTM = "epsg = 32632, easting_m = 500000.0, northing_m = 5400000.0"
CAMERA = """[[instrument]]
name = "camera"
kind = "framing"
position_m = [0.0, 0.0, 10000.0]
ifov_mrad = 0.5
pixels = 4
lines = 4
samples = { grid = [1, 1] }
exr = false
bands = { first_nm = 550.0, step_nm = 100.0, count = 1, fwhm_nm = 10.0 }
"""
GREY = '[[material]]\nname = "m"\nreflectance = 0.5\n'
FOOT_M, SURVEY_FOOT_M = 0.3048, 1200 / 3937
SIZE = 5  # posts, 10 m apart about the origin
X = numpy.array([-20.0, -10, 0, 10, 20])
HEIGHT = 100 + 0.2 * X[None, :] + 0.1 * X[::-1, None]  # the first row is the northern one


def grid_text(values, corner=(499975, 5399975), cell=10, no_data=None):
    rows = "\n".join(" ".join(f"{value:.10g}" for value in row) for row in values)
    more = f"NODATA_value {no_data}\n" if no_data is not None else ""
    return f"ncols {SIZE}\nnrows {SIZE}\nxllcorner {corner[0]}\nyllcorner {corner[1]}\ncellsize {cell}\n{more}{rows}\n"


def virtual(source, declared="", bands="", kind="Float64", system="EPSG:32632"):
    return (
        f'<VRTDataset rasterXSize="{SIZE}" rasterYSize="{SIZE}"><SRS>{system}</SRS>'
        "<GeoTransform>499975, 10, 0, 5400025, 0, -10</GeoTransform>"
        f'<VRTRasterBand dataType="{kind}" band="1">{declared}<SimpleSource><SourceFilename relativeToVRT="1">{source}'
        f"</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>{bands}</VRTDataset>"
    )


def mask_band(source):
    return (
        '<MaskBand><VRTRasterBand dataType="Byte"><SimpleSource><SourceFilename relativeToVRT="1">'
        f"{source}</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></MaskBand>"
    )


def terrain(folder, raster, origin=UTM, more=""):
    file = folder / "scene.toml"
    relief = f'[[terrain]]\nraster = "{raster}"\nmaterial = "m"\n{more}'
    file.write_text(HEAD.format(origin=origin) + GREY + relief + CAMERA)
    return file


def rendered(folder, file):
    run("render", file, "-o", folder / "out", "--overwrite")
    header, truth = envi(folder / "out/camera", "truth")
    names = [name.split(" ")[0] for name in header["band names"]]
    return truth[:, :, names.index("z_m")], envi(folder / "out/camera", "radiance")[1]


def told(file, *says, status=0, without=()):
    """What `scene check` says on stderr; each of `says` in it."""
    done = run("scene", "check", file, status=status)
    for part in says:
        check(part in done.stderr, part, done.stderr, done.stdout)
    for part in without:
        check(part not in done.stderr, part, done.stderr)
    return done


def heights(folder):
    """One slope in many files: the same heights and the same light."""
    (folder / "plain.asc").write_text(grid_text(HEIGHT))
    (folder / "plain.vrt").write_text(virtual("plain.asc"))
    right_z, right_l = rendered(folder, terrain(folder, "plain.vrt"))
    check(abs(right_z.min() - 98.5) < 0.8 and abs(right_z.max() - 101.5) < 0.8, right_z)

    def same(name, *says, tolerance=1e-4, **more):
        z, light = rendered(folder, terrain(folder, name, **more))
        check(abs(z - right_z).max() < tolerance * 100, name, z, right_z)
        check(abs(light / right_l - 1).max() < tolerance, name, light, right_l)
        told(folder / "scene.toml", *says)

    (folder / "decimetres.asc").write_text(grid_text(10 * HEIGHT - 500))
    scale = "<Scale>0.1</Scale><Offset>50</Offset>"
    (folder / "scale.vrt").write_text(virtual("decimetres.asc", scale))
    same("scale.vrt", "scale.vrt", "times 0.1 plus 50")
    for unit, metres in (("ft", FOOT_M), ("US survey foot", SURVEY_FOOT_M), ("metre", 1), ("cm", 0.01)):
        (folder / "unit.asc").write_text(grid_text(HEIGHT / metres))
        (folder / "unit.vrt").write_text(virtual("unit.asc", f"<UnitType>{unit}</UnitType>"))
        same("unit.vrt", *([] if metres == 1 else [f"heights in '{unit}'"]))
    compound = "EPSG:32632+6360"  # NAVD88 in US survey feet
    (folder / "unit.asc").write_text(grid_text(HEIGHT / SURVEY_FOOT_M))
    (folder / "unit.vrt").write_text(virtual("unit.asc", system=compound))
    same("unit.vrt", "NAVD88")
    (folder / "unit.vrt").write_text(virtual("plain.asc", "<UnitType>fathom</UnitType>"))
    told(terrain(folder, "unit.vrt"), "unit is not known", "fathom", status=2)


def voids(folder):
    """What has no height, by every way to say so, is refused, or filled where that is asked for."""
    hole = HEIGHT.copy()
    hole[2, 3] = -700
    covered = numpy.full((SIZE, SIZE), 255.0)
    covered[2, 3] = 0
    (folder / "hole.asc").write_text(grid_text(hole))
    (folder / "covered.asc").write_text(grid_text(covered))
    (folder / "declared.vrt").write_text(virtual("hole.asc", "<NoDataValue>-700</NoDataValue>"))
    (folder / "masked.vrt").write_text(virtual("hole.asc", bands=mask_band("covered.asc")))
    alpha = (
        '<VRTRasterBand dataType="Byte" band="2"><ColorInterp>Alpha</ColorInterp><SimpleSource><SourceFilename '
        'relativeToVRT="1">covered.asc</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>'
    )
    (folder / "alpha.vrt").write_text(virtual("hole.asc", bands=alpha))
    for name in ("declared.vrt", "masked.vrt", "alpha.vrt"):
        told(terrain(folder, name), "posts without data", "1 of 25", status=2)
        z, _ = rendered(folder, terrain(folder, name, more='nodata = "interpolate"\n'))
        check(z.min() > 97, name, z)
    told(terrain(folder, "hole.asc"), "1 post of height -700", "row 2, column 3", "-a_nodata")
    for value, status in ((-99, 0), (-999, 2), (-9999, 2), (-32768, 2), (65535, 2)):
        hole[1, 1] = hole[2, 3] = value
        (folder / "void.asc").write_text(grid_text(hole))
        told(terrain(folder, "void.asc"), str(value), "row 1, column 1", "-a_nodata", status=status)
    cliff = numpy.where(X[None, :] > 0, HEIGHT + 400, HEIGHT)  # a wall of 400 m is no void
    (folder / "cliff.asc").write_text(grid_text(cliff))
    told(terrain(folder, "cliff.asc"), without=("-a_nodata",))
    for text, says in (
        (grid_text(HEIGHT).replace("100", "water", 1), "'water' is no number"),
        (grid_text(HEIGHT).replace("100", "******", 1), "'******' is no number"),
        (grid_text(HEIGHT).rsplit(" ", 1)[0] + "\n", "24 numbers, its header counts 25"),
    ):
        (folder / "words.asc").write_text(text)
        told(terrain(folder, "words.asc"), says, status=2)


def systems(folder):
    """Systems are compared as systems."""
    (folder / "plain.asc").write_text(grid_text(HEIGHT))
    laea = (
        'PROJCS["own",GEOGCS["GCS_GRS80",DATUM["D_GRS80",SPHEROID["GRS_1980",6378137,298.257222101]],'
        'PRIMEM["Greenwich",0],UNIT["Degree",0.0174532925199433]],PROJECTION["Lambert_Azimuthal_Equal_Area"],'
        'PARAMETER["latitude_of_origin",50],PARAMETER["central_meridian",10],PARAMETER["false_easting",500000],'
        'PARAMETER["false_northing",5400000],UNIT["Meter",1]]'
    )
    utm_by_hand = (
        'PROJCS["mine",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137,298.257223563]],'
        'PRIMEM["Greenwich",0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
        'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],'
        'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["Meter",1]]'
    )
    for name, wkt, status, says in (
        ("laea", laea, 2, ["different systems", "no EPSG code", "gdalwarp"]),
        ("feet", utm_by_hand.replace('"Meter",1', '"Foot",0.3048'), 2, ["different systems"]),
        ("same", utm_by_hand, 0, []),
    ):
        (folder / f"{name}.asc").write_text(grid_text(HEIGHT))
        (folder / f"{name}.prj").write_text(wkt)
        told(terrain(folder, f"{name}.asc"), *says, status=status)
    (folder / "compound.vrt").write_text(virtual("plain.asc", system="EPSG:32632+5773"))
    told(terrain(folder, "compound.vrt"), "EGM96")
    (folder / "other.vrt").write_text(virtual("plain.asc", system="EPSG:32633+5773"))
    told(terrain(folder, "other.vrt"), "EPSG:32633 and EPSG:32632", status=2)
    plain = terrain(folder, "plain.asc")
    for origin, says in (
        ("epsg = 3857, easting_m = 1000000.0, northing_m = 8400000.0", ["not metres on the ground", "EPSG:32632"]),
        ("epsg = 2263, easting_m = 1000000.0, northing_m = 200000.0", ["metres", "foot"]),
        (UTM + ", latitude_deg = -45.0, longitude_deg = 100.0", ["two places"]),
    ):
        told(terrain(folder, "plain.asc", origin=origin), *says, status=2)
        for verb in ("plan", "render"):
            done = run(verb, plain, *(["-o", folder / "none"] if verb == "render" else []), status=2)
            check(all(part in done.stderr for part in says) and not (folder / "none").exists(), verb, done.stderr)
    told(terrain(folder, "plain.asc", origin=UTM + ", latitude_deg = 48.75, longitude_deg = 9.0"))


def pictures(folder):
    """Of sixteen bits white is 65535."""
    (folder / "family.csv").write_text("wavelength_nm,a,b,c\n400,0.1,0.4,0.8\n900,0.1,0.4,0.8\n")
    (folder / "sixteen.asc").write_text(
        "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n6554 26214\n26214 52428\n"
    )
    source = "<SimpleSource><SourceFilename relativeToVRT='1'>{}</SourceFilename><SourceBand>1</SourceBand>"
    source += "</SimpleSource>"
    seen = {}
    for name, kind, values in (("sixteen", "UInt16", None), ("eight", "Byte", "26 102\n102 204\n")):
        if values:
            (folder / f"{name}.asc").write_text(f"ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n{values}")
        (folder / f"{name}.vrt").write_text(
            f'<VRTDataset rasterXSize="2" rasterYSize="2"><VRTRasterBand dataType="{kind}" band="1">'
            + source.format(f"{name}.asc")
            + "</VRTRasterBand></VRTDataset>"
        )
        file = folder / "texture.toml"
        file.write_text(
            HEAD.format(origin="height_m = 0.0")
            + f'[[material]]\nname = "m"\nfamily = "family.csv"\ntexture = {{ image = "{name}.vrt", texel_m = 1.0, '
            'choose = "nearest", band_nm = [540.0, 560.0] }\n[[plane]]\nmaterial = "m"\nsize_m = [2.0, 2.0]\n'
            + CAMERA.replace("10000.0", "100.0").replace("0.5", "10.0").replace("= 4", "= 2")
        )
        seen[name] = rendered(folder, file)[1][:, :, 0]
    check((abs(seen["sixteen"] / seen["eight"] - 1) < 1e-6).all(), seen)
    check(abs(seen["eight"].max() / seen["eight"].min() - 8) < 1e-4, seen)  # 0.8 beside 0.1


def orientations(folder):
    """A picture is seen as its tag says, not as its rows stand; what lies on a map stays there, and that is told."""
    (folder / "family.csv").write_text("wavelength_nm,a,b,c\n400,0.1,0.4,0.8\n900,0.1,0.4,0.8\n")
    seen = numpy.array([[26, 102, 204], [204, 204, 26]])  # as it is to be looked at
    stored = {1: seen, 2: seen[:, ::-1], 3: seen[::-1, ::-1], 6: numpy.rot90(seen), 8: numpy.rot90(seen, -1)}
    light = {}
    for orientation, values in stored.items():
        tiff(folder / "picture.tif", values, orientation)
        file = folder / "texture.toml"
        file.write_text(
            HEAD.format(origin="height_m = 0.0")
            + '[[material]]\nname = "m"\nfamily = "family.csv"\ntexture = { image = "picture.tif", texel_m = 1.0, '
            'choose = "nearest", band_nm = [540.0, 560.0] }\n[[plane]]\nmaterial = "m"\nsize_m = [6.0, 6.0]\n'
            + CAMERA.replace("10000.0", "100.0").replace("0.5", "10.0").replace("= 4", "= 6")
        )
        light[orientation] = rendered(folder, file)[1][:, :, 0]
        check((light[orientation] == light[1]).all(), orientation, light)
        told(file, *(["picture.tif", f"(orientation {orientation}), as the file declares"] if orientation > 1 else []))
    check(abs(light[1].max() / light[1].min() - 8) < 1e-4, light[1])
    ramp = numpy.arange(SIZE * SIZE).reshape(SIZE, SIZE)
    heights = {}
    for orientation in (1, 3):
        tiff(folder / "dem.tif", ramp, orientation, (499975, 5400025, 10))
        file = terrain(folder, "dem.tif")
        heights[orientation] = rendered(folder, file)[0]
        told(file, *(["dem.tif", "(orientation 3), is not applied"] if orientation > 1 else []))
    check((heights[1] == heights[3]).all(), heights)


def pyramid(up, unit):
    """Collada; base of 16 x 12 m at z = 0, apex 5 m above (3, -2), once turned to z up and scaled."""
    turn = {"Z_UP": lambda x, y, z: (x, y, z), "Y_UP": lambda x, y, z: (x, z, -y), "X_UP": lambda x, y, z: (z, -x, -y)}
    corners = [(-8, -6, 0), (8, -6, 0), (8, 6, 0), (-8, 6, 0), (3, -2, 5)]
    numbers = " ".join(f"{value / unit:.9g}" for corner in corners for value in turn[up](*corner))
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified><unit name="u" meter="{unit}"/>
<up_axis>{up}</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="15">{numbers}</float_array>
<technique_common><accessor source="#pa" count="5" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 4 1 2 4 2 3 4 3 0 4</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s">
<node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def three_mf(unit, metres, model="3D/3dmodel.model"):
    """The same pyramid as the files of a 3MF's package, which names its model."""
    corners = [(-8, -6, 0), (8, -6, 0), (8, 6, 0), (-8, 6, 0), (3, -2, 5)]
    vertices = "".join("<vertex x='{}' y='{}' z='{}'/>".format(*(value / metres for value in p)) for p in corners)
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    triangles = "".join("<triangle v1='{}' v2='{}' v3='{}'/>".format(*face) for face in faces)
    schema = "http://schemas.openxmlformats.org/package/2006/relationships"
    return {
        "_rels/.rels": f'<?xml version="1.0"?><Relationships xmlns="{schema}"><Relationship Target="/{model}" '
        'Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>',
        model: f'<?xml version="1.0"?><model{unit} '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">'
        f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>',
    }


def mesh_scene(folder, name, more="", place=""):
    file = folder / "mesh.toml"
    file.write_text(
        HEAD.format(origin="height_m = 0.0")
        + GREY
        + '[[plane]]\nmaterial = "m"\nsize_m = [60.0, 60.0]\nposition_m = [0.0, 0.0, -1.0]\n'
        f'[[mesh]]\nname = "o"\nfile = "{name}"\nmaterial = "m"\n{more}[[instance]]\nmesh = "o"\n{place}'
        + CAMERA.replace("10000.0", "100.0").replace("0.5", "10.0").replace("= 4", "= 24")
    )
    return file


def packages(folder, same):
    """3MF: its package says where the model lies, that its unit; a unit that is none is refused."""
    for unit, metres, model in (
        (' unit="inch"', 0.0254, "3D/3dmodel.model"),
        (' unit="centimeter"', 0.01, "3D/3dmodel.model"),
        ("", 0.001, "3D/3dmodel.model"),
        (' unit="inch"', 0.0254, "Parts/shape.model"),
        (' unit="cubit"', 0.4572, "3D/3dmodel.model"),
    ):
        with zipfile.ZipFile(folder / "m.3mf", "w", zipfile.ZIP_DEFLATED) as package:
            for name, text in three_mf(unit, metres, model).items():
                package.writestr(name, text)
        if "cubit" in unit:
            done = run("scene", "check", mesh_scene(folder, "m.3mf"), status=2)
            check("the file's unit of lengths is not known (found unit = 'cubit')" in done.stderr, done.stderr)
            continue
        same("m.3mf")
        check("0 notices" in run("scene", "check", mesh_scene(folder, "m.3mf")).stdout)


def meshes(folder):
    """Axis and unit as the format says; the same pyramid in every way."""
    (folder / "plain.obj").write_text(
        "v -8 -6 0\nv 8 -6 0\nv 8 6 0\nv -8 6 0\nv 3 -2 5\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    )
    right, _ = rendered(folder, mesh_scene(folder, "plain.obj"))
    check(right.max() > 4 and (right > -0.5).sum() == 16 * 12, right.max(), (right > -0.5).sum())

    def same(name, more="", says=(), place=""):
        file = mesh_scene(folder, name, more, place)
        check(abs(rendered(folder, file)[0] - right).max() < 1e-4, name, more)
        told(file, *says)

    for up, unit in (("Z_UP", 1), ("Y_UP", 1), ("X_UP", 1), ("Z_UP", 0.0254)):
        (folder / "m.dae").write_text(pyramid(up, unit))
        same("m.dae")
    packages(folder, same)
    same("m.dae", 'up = "y"\n', ["'up' is not used"])
    same("m.dae", "unit_m = 0.0254\n", ["'unit_m' is not used"])
    same("plain.obj", 'up = "z"\nunit_m = 1.0\n')
    obj = (folder / "plain.obj").read_text()
    for name, text in (
        ("mark", "\ufeff" + obj),
        ("indented", "".join("  " + line + "\n" for line in obj.splitlines())),
        ("comments", obj.replace("\n", " # a place, or a face\n")),
        ("latin", obj.replace("f 1", "usemtl gr\xfcn\nf 1")),
    ):
        (folder / f"{name}.obj").write_bytes(text.encode("latin-1" if name == "latin" else "utf-8"))
        same(f"{name}.obj")
    points = [(-8, -6, 0), (8, -6, 0), (8, 6, 0), (-8, 6, 0), (3, -2, 5)]
    vertices = "element vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in points)
    faces = "element face 4\nproperty list uchar int vertex_indices\n"
    face_rows = "3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n"
    strips = "element tristrips 1\nproperty list int int vertex_indices\n"
    strip_rows = "11 0 1 4 -1 2 4 1 -1 2 4 3\n"
    cameras = "element camera 2\nproperty float view\nproperty list uchar float list\n"
    camera_rows = "0.5 2 1 1\n0.5 0\n"

    # At map coordinates a float steps by half a metre; the same pyramid comes back all the same.
    east, north = 500000.25, 5400000.125
    back = f"position_m = [{-east}, {-north}, 0.0]\n"
    far = "".join(f"{x + east} {y + north} {z}\n" for x, y, z in points)
    (folder / "far.obj").write_text(
        "".join(f"v {row}\n" for row in far.splitlines()) + "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nl 1 2\n"
    )
    same("far.obj", place=back, says=["1 face of fewer than three corners"])
    (folder / "far.ply").write_text(f"ply\nformat ascii 1.0\n{vertices}{faces}end_header\n{far}{face_rows}")
    same("far.ply", place=back)
    corners = base64.b64encode(numpy.array([0, 0, 0, 1, 0, 0, 0, 1, 0], dtype="<f4").tobytes()).decode()
    gltf = (
        '{"asset":{"version":"2.0"},"EXTENSIONS":["NAME"],"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],'
        '"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,'
        '"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],'
        '"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,CORNERS"}]}'
    )
    for name, key, status in (
        ("EXT_mesh_gpu_instancing", "extensionsRequired", 2),
        ("KHR_mesh_quantization", "extensionsRequired", 2),
        ("EXT_mesh_gpu_instancing", "extensionsUsed", 0),
        ("KHR_materials_unlit", "extensionsRequired", 0),
    ):
        (folder / "m.gltf").write_text(
            gltf.replace("EXTENSIONS", key).replace("NAME", name).replace("CORNERS", corners)
        )
        says = [] if "materials" in name else [name]
        told(mesh_scene(folder, "m.gltf"), *says, status=status)

    def ply(name, head, body):
        (folder / name).write_text(f"ply\nformat ascii 1.0\n{head}end_header\n{body}")

    ply("faces.ply", vertices + faces, rows + face_rows)
    same("faces.ply")
    ply("first.ply", cameras + faces + vertices, camera_rows + face_rows + rows)
    same("first.ply")
    ply("strips.ply", vertices + strips + faces.replace("4", "1"), rows + strip_rows + "3 3 0 4\n")
    same("strips.ply")
    for name, body, says in (
        ("cut", rows + face_rows[:-5], "ends before"),
        ("more", rows + face_rows + "3 0 1 2\n", "goes on behind"),
        ("row", rows.replace("8 6 0", "8 6 0 7", 1) + face_rows, "more values than its element has"),
        ("word", rows.replace("8 6 0", "8 6 x", 1) + face_rows, "no number"),
    ):
        ply(f"{name}.ply", vertices + faces, body)
        told(mesh_scene(folder, f"{name}.ply"), says, status=2)


def spectra(folder):
    """Percent is percent, decimal commas are read and told."""
    rows = [(400, 0.8), (500, 0.8), (700, 0.4), (900, 0.2)]
    scene = folder / "spectrum.toml"

    def light(name, text):
        (folder / name).write_text(text)
        scene.write_text(
            HEAD.format(origin="height_m = 0.0")
            + f'[[material]]\nname = "m"\nfile = "{name}"\n[[plane]]\nmaterial = "m"\nsize_m = [60.0, 60.0]\n'
            + CAMERA.replace("10000.0", "100.0")
        )
        return rendered(folder, scene)[1].mean()

    right = light("plain.csv", "wavelength_nm,reflectance\n" + "".join(f"{w},{0.01 * r:.6g}\n" for w, r in rows))
    commas = "".join(f"{w};{0.01 * r:.6g}\n".replace(".", ",") for w, r in rows)
    for name, text in (
        ("tab.txt", "Wavelength\tReflectance (%)\n" + "".join(f"{w}\t{r}\n" for w, r in rows)),
        ("word.txt", "Wavelength\tPercent reflectance\n" + "".join(f"{w}\t{r}\n" for w, r in rows)),
        ("semi.csv", "wavelength_nm;reflectance\n" + commas),
    ):
        check(abs(light(name, text) / right - 1) < 1e-6, name)
    told(scene, "decimal commas")
    (folder / "semi.csv").write_text("wavelength_nm,reflectance\n" + "".join(f"{w},0,{r}\n" for w, r in rows * 50))
    done = run("scene", "check", scene, status=2)
    check("decimal commas" in done.stderr and len(done.stderr.splitlines()) < 30, done.stderr)
    (folder / "semi.csv").write_text("wavelength_nm,reflectance,reflectance\n400,0.1,0.2\n900,0.1,0.2\n")
    told(scene, "two columns have one name", status=2)


def cubes(folder):
    """What analyses leave out of a header is told; what moves a file's numbers and is not read is refused."""
    light = numpy.random.default_rng(1).random((4, 5, 3))
    for header, says, status in (
        ({"bbl": "{1, 0}"}, '"bbl" has 2 values, not 3; it is ignored', 0),
        ({"data_gain_values": "{1, 2}"}, '"data gain values" has 2 values, not 3; it is ignored', 0),
        ({"wavelength": "{400, 500, 600}"}, "has no 'wavelength units'; they are not used", 0),
        ({"wavelength": "{4, 5, 6}", "wavelength_units": "Index"}, "in no unit of them ('Index')", 0),
        ({"file_compression": 1}, '"file compression" is not read', 2),
        ({"major_frame_offsets": "{8, 8}"}, '"major frame offsets" is not read', 2),
    ):
        cube = write_cube(folder / "cube.img", light, **header)
        done = run("analyze", "statistics", cube, "-o", folder / "out", "--overwrite", "--no-picture", status=status)
        check(says in done.stderr, says, done.stderr)
    cube = write_cube(folder / "cube.img", light, wavelength="{400, 500, 600}", wavelength_units="Unknown")
    done = run("analyze", "statistics", cube, "--wavelengths", "400:500", "-o", folder / "out", status=2)
    check("in no unit of them ('Unknown')" in done.stderr, done.stderr)
    ours = write_cube(folder / "ours.img", light, data_units="W m-2 sr-1 um-1")
    for unit, status in (("mW/(m^2 sr nm)", 0), ("uW cm-2 sr-1 nm-1", 2), ("reflectance", 2)):
        cube = write_cube(folder / "cube.img", light, data_units=unit)
        where = ("-o", folder / "out", "--overwrite", "--no-picture")
        done = run("analyze", "scorecard", ours, "--other", cube, *where, status=status)
        check((unit in done.stderr) == (status == 2), unit, done.stderr)
    mask = numpy.ones((4, 5))
    tiff(folder / "mask.tif", mask, 3)
    done = run("analyze", "statistics", cube, "--region", f"r={folder / 'mask.tif'}", "-o", folder / "out", status=2)
    check("(orientation 3)" in done.stderr, done.stderr)
    source = '<SimpleSource><SourceFilename relativeToVRT="1">mask.tif</SourceFilename></SimpleSource>'
    for kind, says in (("Byte", "declares an orientation, which the virtual raster"), ("CFloat32", "complex")):
        (folder / "mask.vrt").write_text(
            f'<VRTDataset rasterXSize="5" rasterYSize="4"><VRTRasterBand dataType="{kind}" band="1">{source}'
            "</VRTRasterBand></VRTDataset>"
        )
        region = f"r={folder / 'mask.vrt'}"
        done = run("analyze", "statistics", cube, "--region", region, "-o", folder / "out", status=2)
        check(says in done.stderr, done.stderr)


for case in (heights, voids, systems, pictures, orientations, meshes, spectra, cubes):
    with tempfile.TemporaryDirectory() as made:
        case(pathlib.Path(made))
print(f"declarations: {program.checks} checks")
