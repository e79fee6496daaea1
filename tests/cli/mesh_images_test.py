"""Images laid by the texture coordinates of meshes: textures, maps of reflectance and colour, masks. Oracles: the place
of every pixel in the image worked out here from the mesh's corners, areas of masks counted in texels."""

import base64
import json
import pathlib
import struct
import sys
import tempfile
import zlib

import matplotlib.image
import numpy

from driver import Program, envi, float_image

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

SIZE = 40  # pixels of 1 m of the camera's image, about the origin
BANDS_NM = numpy.arange(450, 951, 100.0)
GREY = 0.5
IN_BAND = 2e-4  # the sun's lines move the middle of a band of 1 nm
KINDS = 12


def head(materials, things, samples=1):
    return (
        'format = 1\nbounces = 0\natmosphere = { model = "none" }\n'
        "time = { sun = { zenith_deg = 30.0, azimuth_deg = 90.0, day_of_year = 172 } }\n"
        f'[[material]]\nname = "grey"\nreflectance = {GREY}\n'
        + materials
        + things
        + '[[instrument]]\nname = "camera"\nkind = "framing"\naltitude_agl_m = 500.0\ngsd_m = 1.0\n'
        f"pixels = {SIZE}\nlines = {SIZE}\nsamples = {{ grid = [{samples}, {samples}] }}\n"
        f"bands = {{ first_nm = 450.0, step_nm = 100.0, count = {len(BANDS_NM)}, fwhm_nm = 1.0 }}\n"
    )


def mesh(file="card.obj", material="paint", place="", more=""):
    return (
        f'[[mesh]]\nname = "card"\nfile = "{file}"\nmaterial = "{material}"\n{more}'
        f'[[instance]]\nmesh = "card"\n{place}'
    )


GROUND = '[[plane]]\nmaterial = "grey"\nsize_m = [400.0, 400.0]\n'


def rendered(folder, name, text, layer="radiance"):
    (folder / name).write_text(text)
    run("render", folder / name, "-o", folder / "out", "--overwrite")
    return envi(folder / "out" / "camera", layer)


def reflectance(folder, text):
    """Of each pixel and band, over level grey ground under the same sun."""
    grey = rendered(folder, "grey.toml", head("", GROUND))[1].astype(float)
    return GREY * rendered(folder, "scene.toml", text)[1] / grey


def obj(path, corners, places):
    """A polygon with texture coordinates."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners] + [f"vt {u!r} {v!r}" for u, v in places]
    numbers = range(1, len(corners) + 1)
    path.write_text("\n".join(lines + ["f " + " ".join(f"{i}/{i}" for i in numbers)]) + "\n")


def square(half=SIZE / 2, z=0.0):
    return [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]


def places_in_image(corners, places):
    """(u, v) of the middle of every pixel, of a parallelogram's corners; the first line is the northernmost."""
    a, b, d = (numpy.array(corners[i][:2]) for i in (0, 1, 3))
    x = numpy.arange(SIZE) - SIZE / 2 + 0.5
    at = numpy.stack(numpy.meshgrid(x, -x), -1) - a
    along = at @ numpy.linalg.inv(numpy.stack([b - a, d - a]))
    u0, u1, u3 = (numpy.array(places[i]) for i in (0, 1, 3))
    return u0 + along[..., :1] * (u1 - u0) + along[..., 1:] * (u3 - u0)


def texels(image, at):
    """The image's value at each place, and whether the place is clear of its texel's edges."""
    rows, columns = image.shape[:2]
    place = at * (columns, rows)
    inside = numpy.floor(place).astype(int)
    clear = (numpy.minimum(place - inside, 1 - (place - inside)) > 1e-3).all(-1)
    return image[rows - 1 - inside[..., 1] % rows, inside[..., 0] % columns], clear


def write_family(folder, spectra, nodes_nm):
    names = ",".join(f"kind {i}" for i in range(len(spectra)))
    table = numpy.column_stack([nodes_nm, spectra.T])
    numpy.savetxt(folder / "kinds.csv", table, "%.9f", ",", header="wavelength_nm," + names, comments="")


def paint(texture, name="paint"):
    return f'[[material]]\nname = "{name}"\nfamily = "kinds.csv"\ntexture = {{ {texture} }}\n'


TURNED = [(0.2, -1.1), (1.9, -0.4), (1.2, 1.3), (-0.5, 0.6)]  # turned, beyond the image on all sides


def check_places(folder, rng):
    """Every pixel shows the spectrum of the texel that its place in the image is in: the image as it is, turned and
    repeated, mirrored; grey levels that say which of KINDS spectra, the brighter the brighter."""
    level = rng.permutation(numpy.arange(36 * 30) % KINDS).reshape(30, 36)
    float_image(folder / "levels.img", level + 1e-3 * rng.random(level.shape))
    spectra = numpy.linspace(0.1, 0.9, KINDS)[:, None] * numpy.linspace(0.8, 1, len(BANDS_NM))
    nodes_nm = numpy.concatenate([[400], BANDS_NM, [1000]])
    write_family(folder, spectra[:, [0, *range(len(BANDS_NM)), -1]], nodes_nm)
    material = paint('image = "levels.img", band_nm = [450, 950]')
    straight = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    for places in (straight, TURNED, [(1 - u, v) for u, v in straight]):
        obj(folder / "card.obj", square(), places)
        shown = reflectance(folder, head(material, mesh()))
        chosen, clear = texels(level, places_in_image(square(), places))
        check(clear.mean() > 0.9, clear.mean())
        check(numpy.allclose(shown[clear], spectra[chosen[clear]], rtol=IN_BAND), places)
    return material


def check_formats(folder, material):
    """OBJ, PLY and glTF (whose images hang from their upper edge) lay one image alike."""
    obj(folder / "card.obj", square(), TURNED)
    cube = rendered(folder, "scene.toml", head(material, mesh()))[1]
    clear = texels(numpy.zeros((30, 36)), places_in_image(square(), TURNED))[1]
    rows = [f"{x} {y} {z} {u} {v}" for (x, y, z), (u, v) in zip(square(), TURNED)]
    (folder / "card.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\n"
        + "".join(f"property float {name}\n" for name in ("x", "y", "z", "s", "t"))
        + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        + "\n".join(rows + ["4 0 1 2 3"])
        + "\n"
    )
    # The first vertex may begin with a line feed's byte, here in the last digits of x.
    vertices = numpy.column_stack([square(), TURNED]).astype("<f4")
    vertices.view("u1")[0, 0] = 0x0A
    text = (folder / "card.ply").read_text().replace("ascii", "binary_little_endian")
    text = text[: text.index("end_header\n") + 11]
    numbers = struct.pack("<B4i", 4, 0, 1, 2, 3)
    (folder / "feed.ply").write_bytes(text.encode() + vertices.tobytes() + numbers)
    (folder / "feeds.ply").write_bytes(text.replace("\n", "\r\n").encode() + vertices.tobytes() + numbers)
    hanging = [(u, 1 - v) for u, v in TURNED]
    y_up = numpy.array(square(), "<f4")[:, [0, 2, 1]] * [1, 1, -1]  # as glTF has it
    blob = y_up.astype("<f4").tobytes() + numpy.array(hanging, "<f4").tobytes()
    blob += numpy.array([0, 1, 2, 0, 2, 3], "<u2").tobytes()
    views = [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in ((0, 48), (48, 32), (80, 12))]
    kinds = (("VEC3", 5126, 4), ("VEC2", 5126, 4), ("SCALAR", 5123, 6))
    accessors = [
        {"bufferView": i, "componentType": c, "count": n, "type": t} for i, (t, c, n) in enumerate(kinds)
    ]
    half = SIZE / 2
    accessors[0] |= {"min": [-half, 0, -half], "max": [half, 0, half]}
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    (folder / "card.gltf").write_text(
        json.dumps(
            {
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [primitive]}],
                "accessors": accessors,
                "bufferViews": views,
                "buffers": [
                    {
                        "byteLength": len(blob),
                        "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode(),
                    }
                ],
            }
        )
    )
    for file in ("card.ply", "feed.ply", "feeds.ply", "card.gltf"):
        other = rendered(folder, "scene.toml", head(material, mesh(file)))[1]
        check(numpy.allclose(other[clear], cube[clear], rtol=1e-5), file)


def integral(values, at):
    """Of each row, by trapezoids: numpy 1 and 2 have another name for it."""
    return (0.5 * (values[:, 1:] + values[:, :-1]) * numpy.diff(at)).sum(axis=1)


def check_maps(folder, rng):
    """The nearest spectrum: of a map of reflectances by its bands, of a picture by its colours."""
    nodes_nm = numpy.arange(400, 1001, 20.0)
    bands = [(600, 700), (500, 600), (400, 500)]
    steps = numpy.stack([(nodes_nm > low) & (nodes_nm < high) for low, high in bands]).astype(float)
    spectra = 0.05 + 0.8 * rng.random((KINDS, 3)) @ steps
    write_family(folder, spectra, nodes_nm)
    inside = [(nodes_nm >= low) & (nodes_nm <= high) for low, high in bands]
    means = numpy.stack([integral(spectra[:, i], nodes_nm[i]) / 100 for i in inside], -1)
    wanted = rng.uniform(0, 0.9, (20, 25, 3))
    obj(folder / "card.obj", square(), [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    at = places_in_image(square(), [(0, 0), (1, 0), (1, 1), (0, 1)])
    at_bands = numpy.stack([numpy.interp(BANDS_NM, nodes_nm, s) for s in spectra])
    band_nm = "choose = \"nearest\", band_nm = [600, 700, 500, 600, 400, 500]"
    float_image(folder / "map.img", 1e4 * wanted)
    nearest = ((wanted[:, :, None] - means) ** 2).sum(-1).argmin(-1)
    shown = reflectance(folder, head(paint(f'image = "map.img", white = 1e4, {band_nm}'), mesh()))
    chosen, clear = texels(nearest, at)
    check(numpy.allclose(shown[clear], at_bands[chosen[clear]], rtol=IN_BAND))
    srgb = lambda x: numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    picture = numpy.round(255 * wanted).astype("u1")
    matplotlib.image.imsave(folder / "map.png", picture)
    nearest = ((picture[:, :, None] / 255 - srgb(means)) ** 2).sum(-1).argmin(-1)
    shown = reflectance(folder, head(paint(f'image = "map.png", encoding = "srgb", {band_nm}'), mesh()))
    chosen, clear = texels(nearest, at)
    check(numpy.allclose(shown[clear], at_bands[chosen[clear]], rtol=IN_BAND))


def disc(size):
    """A picture whose opacity is a disc, 0.4 of its side in radius, and how much of it that is."""
    x = (numpy.arange(size) + 0.5) / size - 0.5
    inside = numpy.hypot(*numpy.meshgrid(x, x)) < 0.4
    picture = numpy.full((size, size, 4), 255, "u1")
    picture[..., 3] = 255 * inside
    return picture, inside.mean()


def check_mask(folder):
    """A card of 16 m, 5 m above the ground, cut out to a disc: what the camera sees of it and the shadow it throws are
    as large as the disc's texels, on the pulse's way too."""
    picture, share = disc(32)
    matplotlib.image.imsave(folder / "leaf.png", picture)
    obj(folder / "card.obj", square(8, 0.0), [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    leaf = '[[material]]\nname = "leaf"\nreflectance = 0.2\nmask = { image = "leaf.png", band = 4 }\n'
    things = mesh(material="leaf", place="position_m = [0.0, 0.0, 5.0]\n") + GROUND
    header, layers = rendered(folder, "scene.toml", head(leaf, things, samples=16), "truth")
    names = [n.split(" ")[0] for n in header["band names"]]
    covered = layers[..., names.index("abundance_leaf")].astype(float)
    nearer = (500 / 495) ** 2
    check(abs(covered.sum() / (256 * share * nearer) - 1) < 0.003, covered.sum(), 256 * share * nearer)
    check(covered.max() == 1 and covered[SIZE // 2, SIZE // 2] == 1 and covered[0, 0] == 0)
    # The sun stands 30 degrees from the zenith in the east: the shadow lies 2.9 m to the west, some of it under the
    # disc; what is seen of it is what the disc does not hide.
    lit = layers[..., names.index("sun_fraction")].astype(float)
    grid = (numpy.arange(16 * SIZE) + 0.5) / 16 - SIZE / 2
    x, y = numpy.meshgrid(grid, -grid)
    at = lambda x, y: numpy.stack([x / 16 + 0.5, y / 16 + 0.5], -1)
    on = lambda x, y: texels(picture[..., 3] > 0, at(x, y))[0] & (abs(x) < 8) & (abs(y) < 8)
    hidden = on(x * 495 / 500, y * 495 / 500)
    shadow = on(x + 5 * numpy.tan(numpy.radians(30)), y) & ~hidden
    check(abs((1 - lit).sum() / (shadow.sum() / 256) - 1) < 0.01, (1 - lit).sum(), shadow.sum() / 256)
    triangles = json.loads(run("scene", "info", folder / "scene.toml", "--json").stdout)["triangles"]
    check(triangles < 32 * 32, triangles)


def check_mask_of_family(folder, material):
    """A mask and a texture on one material, of other numbers of texels; by metres too."""
    picture, share = disc(32)
    mask = 'mask = { image = "leaf.png", band = 4 }\n'
    obj(folder / "card.obj", square(8, 0.0), [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    for texture in (material, material.replace('"levels.img"', '"levels.img", texel_m = 1.0')):
        header, layers = rendered(folder, "scene.toml", head(texture + mask, mesh(), samples=16), "truth")
        names = [n.split(" ")[0] for n in header["band names"]]
        covered = layers[..., names.index("abundance_paint")].astype(float).sum()
        check(abs(covered / (256 * share) - 1) < 0.003, covered, 256 * share)


def indexed_png(path):
    """Four texels by numbers of two colours."""
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 3, 0, 0, 0))
        + chunk(b"PLTE", bytes([0, 90, 0, 120, 60, 0]))
        + chunk(b"IDAT", zlib.compress(b"\0\0\1\0\1\0"))
        + chunk(b"IEND", b"")
    )


def check_refusals(folder, material):
    good = head(material, mesh())
    obj(folder / "card.obj", square(), [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    (folder / "odd.obj").write_text((folder / "card.obj").read_text().replace("vt 1.0 1.0", "vt nan 1.0"))
    (folder / "bare.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    obj(folder / "far.obj", square(), [(0.0, 0.0), (1e5, 0.0), (1e5, 1e5), (0.0, 1e5)])

    def says(*parts, old="", new=""):
        check(old in good, old)
        (folder / "bad.toml").write_text(good.replace(old, new))
        refused("scene", "check", folder / "bad.toml", status=2, says=parts)

    leaf = lambda more: '[[material]]\nname = "paint"\nreflectance = 0.2\nmask = { image = "leaf.png"' + more + " }\n"
    says("faces have none", "face 0 of", "texel_m", old="card.obj", new="bare.obj")
    says("faces have none that are numbers", "odd.obj", old="card.obj", new="odd.obj")
    says("faces have none", "without a mask", old=good, new=head(leaf(""), mesh("bare.obj")))
    says("more than 4e7 texels", "coarser", old="card.obj", new="far.obj")
    plane = GROUND.replace("grey", "paint")
    says("texture coordinates of a mesh, which this is not", "give its texture a texel_m", old=mesh(), new=plane)
    says("texture coordinates of a mesh, which this is not", "a mask", old=good, new=head(leaf(""), plane))
    says("no such band", "7 of 4", old=good, new=head(leaf(", band = 7"), mesh()))
    says("the mask leaves nothing", "values up to 255", old=good, new=head(leaf(", least = 256"), mesh()))
    says("'white' goes with", "nearest", old='"levels.img"', new='"levels.img", white = 1.0')
    says("one band tells", "2 bands", old="[450, 950]", new="[450, 600, 600, 950]")
    more = 'choose = "nearest", '
    two = more + "band_nm = [450, 600, 600, 950]"
    says("no such band", "2 of 1", old='"levels.img", band_nm = [450, 950]', new='"levels.img", ' + two)
    float_image(folder / "share.img", numpy.full((2, 2), 0.3))
    says("reflectance 1 is not known", "up to 0.3", old='"levels.img", ', new='"share.img", ' + more)
    indexed_png(folder / "indexed.png")
    says("numbers of a palette's colours", "-expand", old="levels.img", new="indexed.png")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rng = numpy.random.default_rng(4)
        material = check_places(folder, rng)
        check_formats(folder, material)
        check_mask(folder)
        check_mask_of_family(folder, material)
        check_refusals(folder, material)
        check_maps(folder, rng)
    print(f"mesh_images: {program.checks} checks")


main()
