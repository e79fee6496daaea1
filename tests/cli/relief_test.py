"""Relief of surfaces by images of heights and of normals: bump maps and normal maps. Oracles: heights and slopes of the
triangles that the image asks for, worked out here, at the place where each pixel's ray meets them."""

import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi, float_image

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

PIXELS = 40  # seen from 500 m
GSD_M = 0.231  # pixels lie all over the texels
SIDE_M = 12.0
TEXEL_M = 0.5
GREY = 0.4
SUN = numpy.array([numpy.sin(numpy.radians(30)), 0, numpy.cos(numpy.radians(30))])  # in the east


def head(material, things):
    return (
        'format = 1\nbounces = 0\natmosphere = { model = "none" }\n'
        "time = { sun = { zenith_deg = 30.0, azimuth_deg = 90.0, day_of_year = 172 } }\n"
        f'[[material]]\nname = "grey"\nreflectance = {GREY}\n'
        f'[[material]]\nname = "rough"\nreflectance = {GREY}\n{material}'
        + things
        + '[[instrument]]\nname = "camera"\nkind = "framing"\nposition_m = [0, 0, 500.0]\n'
        f"ifov_mrad = {1e3 * GSD_M / 500}\npixels = {PIXELS}\nlines = {PIXELS}\nsamples = {{ grid = [1, 1] }}\n"
        "bands = { first_nm = 550.0, step_nm = 10.0, count = 1, fwhm_nm = 1.0 }\n"
    )


PLANE = f'[[plane]]\nmaterial = "rough"\nsize_m = [{SIDE_M}, {SIDE_M}]\n'
FLOOR = '[[plane]]\nmaterial = "grey"\nsize_m = [400.0, 400.0]\nposition_m = [0.0, 0.0, -5.0]\n'
CARD = '[[mesh]]\nname = "card"\nfile = "card.obj"\nmaterial = "rough"\n[[instance]]\nmesh = "card"\n'


def rendered(folder, text):
    """(x, y, z, radiance) of every pixel."""
    (folder / "scene.toml").write_text(text)
    run("render", folder / "scene.toml", "-o", folder / "out", "--overwrite")
    names, truth = envi(folder / "out" / "camera", "truth")
    layer = {name.split(" ")[0]: truth[..., i].astype(float) for i, name in enumerate(names["band names"])}
    radiance = envi(folder / "out" / "camera", "radiance")[1][..., 0].astype(float)
    return layer["x_m"], layer["y_m"], layer["z_m"], radiance


def height(texels, u, v, size=1.0):
    """Between the middles of texels (rows from the uppermost), which repeat; u, v in sides of `size`."""
    rows, columns = texels.shape
    x, y = u / size - 0.5, v / size - 0.5
    i, j = numpy.floor(x).astype(int), numpy.floor(y).astype(int)
    f, g = x - i, y - j
    at = lambda a, b: texels[rows - 1 - b % rows, a % columns]
    return (1 - g) * ((1 - f) * at(i, j) + f * at(i + 1, j)) + g * ((1 - f) * at(i, j + 1) + f * at(i + 1, j + 1))


def on_squares(corner_height, u, v):
    """Height, slopes and clearness from edges at a place of squares of 1, each two triangles from its lower left
    corner to its upper right one; corner_height(i, j)."""
    i, j = numpy.floor(u).astype(int), numpy.floor(v).astype(int)
    f, g = u - i, v - j
    sw, se, nw, ne = (corner_height(i + a, j + b) for a, b in ((0, 0), (1, 0), (0, 1), (1, 1)))
    east = numpy.where(f > g, se - sw, ne - nw)
    north = numpy.where(f > g, ne - se, nw - sw)
    clear = (numpy.minimum.reduce([f, 1 - f, g, 1 - g, abs(f - g)]) > 1e-3)
    return sw + f * east + g * north, east, north, clear


def agree(seen, expected, what):
    """seen: rendered(); expected(x, y): height, slopes per metre, clearness, of those pixels that count."""
    x, y, z, radiance = seen
    h, east, north, clear = expected(x, y)
    check(clear.sum() > 0.8 * clear.size, what, clear.sum())
    off = abs(z - h)[clear].max()
    check(off < 2e-4, what, "heights apart", off)  # of 500 m a float's half ulp is 3e-5 m
    normal = numpy.stack([-east, -north, numpy.ones_like(h)], -1)
    facing = normal @ SUN / numpy.linalg.norm(normal, axis=-1)
    check(facing.min() > 0.1, what, "no shadows are in the oracle")
    flat = radiance[clear] / facing[clear]
    check(flat.std() < 2e-5 * flat.mean(), what, "sun", flat.std() / flat.mean())
    check(abs(east).max() > 0.1, what, "it is rough")


def waves(rows=24, columns=24):
    """Heights in m, mean 0, of an image that repeats, without short waves; and their slopes, to the right and up."""
    column, up = numpy.meshgrid(numpy.arange(columns), numpy.arange(rows)[::-1])
    h, right, north = (numpy.zeros((rows, columns)) for _ in range(3))
    for a, b, size, phase in ((1, 2, 0.2, 0.3), (3, -1, 0.1, 1.0), (0, 4, 0.05, 2.0)):
        wx, wy = 2 * numpy.pi * a / columns, 2 * numpy.pi * b / rows
        angle = wx * (column + 0.5) + wy * (up + 0.5) + phase
        h += size * numpy.sin(angle)
        right += size * wx * numpy.cos(angle)
        north += size * wy * numpy.cos(angle)
    return h, right, north


def plane_of(texels):
    """What a plane about the origin has by texels of TEXEL_M, from its lower left corner."""

    def expected(x, y):
        u, v = (x + SIDE_M / 2) / TEXEL_M, (y + SIDE_M / 2) / TEXEL_M
        h, east, north, clear = on_squares(lambda i, j: height(texels, i.astype(float), j.astype(float)), u, v)
        return h, east / TEXEL_M, north / TEXEL_M, clear

    return expected


def bumps_on_planes(folder):
    heights, right, north = waves()
    float_image(folder / "bump.img", heights)
    low, high = heights.min(), heights.max()
    bump = f'bump = {{ image = "bump.img", height_m = [{low!r}, {high!r}], texel_m = {TEXEL_M} }}\n'
    agree(rendered(folder, head(bump, PLANE)), plane_of(heights), "bump")
    agree(rendered(folder, head(bump.replace(repr(low), "0.5").replace(repr(high), "-0.5"), PLANE)),
          plane_of(0.5 - (heights - low) / (high - low)), "turned inside out")
    # Normals of the same heights, per texel of TEXEL_M; green down is the same picture with green turned.
    normal = numpy.stack([-right / TEXEL_M, -north / TEXEL_M, numpy.ones_like(right)], -1)
    normal /= numpy.linalg.norm(normal, axis=-1, keepdims=True)
    for green in ("up", "down"):
        float_image(folder / "normals.img", normal * (1, 1 if green == "up" else -1, 1))
        text = f'normals = {{ image = "normals.img", texel_m = {TEXEL_M}, green = "{green}" }}\n'
        agree(rendered(folder, head(text, PLANE)), plane_of(heights), "normals, green " + green)


def boxes_keep_their_edges(folder):
    heights, _, _ = waves()
    text = f'bump = {{ image = "bump.img", height_m = [{heights.min()!r}, {heights.max()!r}], texel_m = {TEXEL_M} }}\n'
    side = 8.0  # its edges are in view
    box = f'[[box]]\nmaterial = "rough"\nsize_m = [{side}, {side}, 3.0]\nposition_m = [0.0, 0.0, -3.0]\n'
    x, y, z, _ = rendered(folder, head(text, box + FLOOR))
    count = round(side / TEXEL_M)

    def corner(i, j):
        inside = (i > 0) & (i < count) & (j > 0) & (j < count)
        return numpy.where(inside, height(heights, i.astype(float), j.astype(float)), 0)

    u, v = (x + side / 2) / TEXEL_M, (y + side / 2) / TEXEL_M
    h, _, _, clear = on_squares(corner, u, v)
    top = clear & (u > 0) & (u < count) & (v > 0) & (v < count) & (z > -1)  # beside it lies the floor
    check(top.sum() > 0.6 * (side / GSD_M) ** 2, "box", top.sum())
    check(abs(z - h)[top].max() < 2e-4, "box", abs(z - h)[top].max())


def meshes_by_coordinates(folder):
    """A square of SIDE_M, two images along x and one along y: texels of SIDE_M / 48 by SIDE_M / 24."""
    heights, right, north = waves()
    half = SIDE_M / 2
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    (folder / "card.obj").write_text(
        "\n".join([f"v {x} {y} 0" for x, y in corners] + ["vt 0 0", "vt 2 0", "vt 2 1", "vt 0 1"])
        + "\nf 1/1 2/2 3/3 4/4\n"
    )
    cells = 48, 24
    side = SIDE_M / cells[0], SIDE_M / cells[1]
    twist = 0.25 * abs(numpy.diff(numpy.diff(heights, axis=0), axis=1)).max()
    i, j = numpy.meshgrid(numpy.arange(24.0), numpy.arange(24.0))
    at_middle = height(heights, i + 0.5, j + 0.5)
    bent = abs(at_middle - sum(height(heights, i + a, j + b) for a in (0, 1) for b in (0, 1)) / 4).max()

    def agrees(seen, scale, what):
        x, y, z, _ = seen
        u, v = (x + half) / side[0], (y + half) / side[1]
        i, j = numpy.floor(u), numpy.floor(v)
        f, g = u - i, v - j
        at = lambda a, b: scale * height(heights, i + a, j + b)
        between = (1 - g) * ((1 - f) * at(0, 0) + f * at(1, 0)) + g * ((1 - f) * at(0, 1) + f * at(1, 1))
        # A square of four heights is two triangles, cut which way it may: apart by a quarter of its twist at most. On
        # the square's diagonal corners lie within a texel, as high as the image says there.
        off = abs(z - between)
        check(off.max() < scale * (twist + bent) + 2e-4, what, off.max(), twist, bent)
        check(numpy.median(off) < 0.3 * scale * twist + 2e-4, what, numpy.median(off), twist)
        check(z.max() - z.min() > 0.3 * scale * (heights.max() - heights.min()), what, "it is lifted")

    text = f'bump = {{ image = "bump.img", height_m = [{heights.min()!r}, {heights.max()!r}] }}\n'
    agrees(rendered(folder, head(text, CARD)), 1.0, "mesh, bump")
    # Of normals heights are in sides of a texel: the root of its area.
    normal = numpy.stack([-right, -north, numpy.ones_like(right)], -1)
    float_image(folder / "normals.img", normal / numpy.linalg.norm(normal, axis=-1, keepdims=True))
    agrees(rendered(folder, head('normals = { image = "normals.img" }\n', CARD)), (side[0] * side[1]) ** 0.5,
           "mesh, normals")


def refuses(folder):
    float_image(folder / "flat.img", numpy.ones((4, 4)))
    float_image(folder / "inwards.img", numpy.stack([numpy.zeros((4, 4))] * 2 + [-numpy.ones((4, 4))], -1))
    # A picture of two colours, numbers of a palette.
    (folder / "palette.gif").write_bytes(
        b"GIF89a\x01\x00\x01\x00\x80\x00\x00\x00\x00\x00\xff\xff\xff,\x00\x00\x00\x00\x01\x00\x01\x00\x00"
        b"\x02\x02D\x01\x00;"
    )
    bump = f'bump = {{ image = "bump.img", height_m = [0.0, 0.1], texel_m = {TEXEL_M} }}\n'
    loose = 'bump = { image = "bump.img", height_m = [0.0, 0.1] }\n'
    checker = '[[plane]]\nsize_m = [4.0, 4.0]\nchecker = { cell_m = 1.0, materials = ["grey", "rough"] }\n'
    for material, things, parts in [
        (bump + 'normals = { image = "normals.img" }\n', PLANE, ["one relief", "bump and normals"]),
        (bump.replace("height_m = [0.0, 0.1], ", ""), PLANE, ["height_m"]),
        (bump.replace("bump.img", "flat.img"), PLANE, ["one value everywhere"]),
        (bump.replace("bump.img", "palette.gif"), PLANE, ["palette"]),
        (bump.replace("bump.img", "none.img"), PLANE, ["none.img"]),
        (f'normals = {{ image = "inwards.img", texel_m = {TEXEL_M} }}\n', PLANE, ["does not point out"]),
        (loose, PLANE, ["texel_m", "rough"]),
        (bump, CARD, ["remove texel_m"]),
        (bump, checker, ["planes and faces of boxes"]),
    ]:
        (folder / "bad.toml").write_text(head(material, things))
        refused("scene", "check", folder / "bad.toml", status=2, says=parts)


with tempfile.TemporaryDirectory() as place:
    work = pathlib.Path(place)
    bumps_on_planes(work)
    boxes_keep_their_edges(work)
    meshes_by_coordinates(work)
    refuses(work)
print(f"{program.checks} checks passed")
