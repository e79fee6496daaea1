"""S22 textures: an image says which spectrum of a family lies where. Oracles: the choice made anew here from [A] 1.1.8,
texel by texel; mean, variance, band covariance and contrast rank of a flat plate against the family's own."""

import json
import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

COLUMNS, ROWS, MEMBERS = 48, 40, 30
BANDS_NM = numpy.arange(455, 955, 50.0)  # between nodes, so that a band's mean is the middle's value
NODES_NM = numpy.arange(400, 1001, 10.0)
GREY = 0.5
IN_BAND = 2e-4  # the sun's lines move the middle of a band of 1 nm by hundredths; members differ by much more


def family():
    """Spectra of which the visible and the near infrared move apart: [member][node]."""
    rng = numpy.random.default_rng(22)
    x = (NODES_NM - 400) / 600
    shapes = numpy.stack([numpy.exp(-(((x - c) / 0.2) ** 2)) for c in (0.2, 0.55, 0.9)])
    return 0.25 + 0.2 * x + rng.normal(0, 0.04, (MEMBERS, 3)) @ shapes


def image(path, values):
    """A raster of one float band, as ENVI: any reader of GDAL's takes it."""
    values.astype("<f4").tofile(path)
    pathlib.Path(str(path) + ".hdr").write_text(
        f"ENVI\nsamples = {values.shape[1]}\nlines = {values.shape[0]}\nbands = 1\nheader offset = 0\n"
        "file type = ENVI Standard\ndata type = 4\ninterleave = bsq\nbyte order = 0\n"
    )


def integral(values, at):
    """Of each row, by trapezoids: numpy 1 and 2 have another name for it."""
    return (0.5 * (values[:, 1:] + values[:, :-1]) * numpy.diff(at)).sum(axis=1)


def brightness(spectra, band_nm=(400, 700)):
    inside = (NODES_NM >= band_nm[0]) & (NODES_NM <= band_nm[1])
    return integral(spectra[:, inside], NODES_NM[inside]) / (band_nm[1] - band_nm[0])


def by_rank(values, spectra):
    """Member of each texel, all values different."""
    rank = numpy.empty(values.size, int)
    rank[numpy.argsort(values, axis=None)] = numpy.arange(values.size)
    return numpy.argsort(brightness(spectra))[rank * MEMBERS // values.size].reshape(values.shape)


def by_deviations(values, spectra):
    """[A] 1.1.8 as it stands."""
    bright = brightness(spectra)
    z = (values - values.mean()) / values.std()
    return numpy.abs(bright[None, None] - (bright.mean() + z * bright.std())[..., None]).argmin(-1)


MATERIAL = """[[material]]
name = "turf"
family = "turf.csv"
texture = { image = "grain.img", texel_m = 1.0 MORE }
[[material]]
name = "grey"
reflectance = 0.5
"""
PLATE = f'[[plane]]\nmaterial = "turf"\nsize_m = [{COLUMNS}.0, {ROWS}.0]\n'


def write(folder, name, things, more="", head="bounces = 0", samples=1, bands=len(BANDS_NM), air='{ model = "none" }'):
    path = folder / name
    path.write_text(
        f"format = 1\n{head}\natmosphere = {air}\n"
        "time = { sun = { zenith_deg = 40.0, azimuth_deg = 150.0, day_of_year = 172 } }\n"
        + MATERIAL.replace("MORE", more)
        + things
        + '[[instrument]]\nname = "camera"\nkind = "framing"\naltitude_agl_m = 500.0\ngsd_m = 1.0\n'
        + f"pixels = {COLUMNS}\n"
        f"lines = {ROWS}\nsamples = {{ grid = [{samples}, {samples}] }}\n"
        f"bands = {{ first_nm = 455.0, step_nm = 50.0, count = {bands}, fwhm_nm = 1.0 }}\n"
    )
    return path


def reflectance(folder, file):
    """Of each pixel and band: over a grey plate in its place."""
    grey = file.with_name("grey.toml")
    grey.write_text(file.read_text().replace('material = "turf"', 'material = "grey"'))
    cubes = []
    for path in (file, grey):
        run("render", path, "-o", folder / "out", "--overwrite")
        cubes.append(envi(folder / "out" / "camera", "radiance")[1].astype(float))
    return GREY * cubes[0] / cubes[1]


def check_choice(folder, spectra, values):
    """The member of every texel, its place included; none is seen half at samples in their middles."""
    at_bands = numpy.stack([numpy.interp(BANDS_NM, NODES_NM, s) for s in spectra])
    for more, chosen in (("", by_rank(values, spectra)), (', choose = "deviations"', by_deviations(values, spectra))):
        shown = reflectance(folder, write(folder, "plate.toml", PLATE, more))
        check(numpy.allclose(shown, at_bands[chosen], rtol=IN_BAND), more, numpy.abs(shown - at_bands[chosen]).max())
    header, layers = envi(folder / "out" / "camera", "truth")
    check([n.split(" ")[0] for n in header["band names"][-2:]] == ["abundance_turf", "abundance_grey"], header)
    box = PLATE.replace("[[plane]]", "[[box]]").replace(f"{ROWS}.0]", f"{ROWS}.0, 1.0]")
    chosen = by_rank(values, spectra)
    file = write(folder, "box.toml", box + "position_m = [0.0, 0.0, -1.0]\n")
    check(numpy.allclose(reflectance(folder, file), at_bands[chosen], rtol=IN_BAND))
    return at_bands


def check_moments(folder, spectra, at_bands):
    """S22's gate, by an image of eight bits whose histogram is far from a Gaussian's: mean within 1 %, covariance
    within 5 % (Frobenius), and a brighter texel is never darker."""
    rng = numpy.random.default_rng(7)
    values = numpy.floor(255 * rng.beta(0.4, 3.0, (ROWS, COLUMNS)))
    image(folder / "grain.img", values)
    shown = reflectance(folder, write(folder, "plate.toml", PLATE)).reshape(-1, len(BANDS_NM))
    mean, covariance = at_bands.mean(0), numpy.cov(at_bands.T, bias=True)
    check(numpy.all(numpy.abs(shown.mean(0) / mean - 1) < 0.01), shown.mean(0), mean)
    apart = numpy.linalg.norm(numpy.cov(shown.T, bias=True) - covariance) / numpy.linalg.norm(covariance)
    check(apart < 0.05, apart)
    member = numpy.abs(shown[:, None, :] - at_bands[None]).sum(-1).argmin(1)
    order, bright = numpy.argsort(values, axis=None, kind="stable"), brightness(spectra)[member]
    levels = values.reshape(-1)[order]
    darkest, brightest = {}, {}
    for level, b in zip(levels, bright[order]):
        darkest[level], brightest[level] = min(darkest.get(level, 9), b), max(brightest.get(level, 0), b)
    steps = sorted(darkest)
    check(all(brightest[a] <= darkest[b] for a, b in zip(steps, steps[1:])))


def check_terrain(folder, spectra, values, at_bands):
    """Cells of 4 m cut into texels of 1 m over relief; in x and y of the scene from the origin, the image repeats."""
    z = numpy.random.default_rng(3).uniform(0, 0.02, (ROWS // 4 + 3, COLUMNS // 4 + 3))
    image(folder / "height.img", z)
    terrain = '[[terrain]]\nraster = "height.img"\ncell_m = 4.0\nmaterial = "turf"\n'
    done = run("scene", "check", write(folder, "coarse.toml", terrain))
    check("refine = 4 shows them all" in done.stderr, done.stderr)
    file = write(folder, "terrain.toml", terrain + "refine = 4\n")
    shown = reflectance(folder, file)
    # Pixel (0, 0) is the north-west one, 24 m west and 20 m north of the origin, where the image's lower left is.
    chosen = numpy.roll(by_rank(values, spectra), (ROWS // 2, COLUMNS // 2), (0, 1))
    close = numpy.isclose(shown, at_bands[chosen], rtol=1e-4).all(-1)
    check(close.mean() > 0.995, close.mean())  # relief of 2 cm at 500 m: pixels' middles stay in their texels
    flat = json.loads(run("scene", "info", folder / "coarse.toml", "--json").stdout)
    cut = json.loads(run("scene", "info", file, "--json").stdout)
    check(cut["triangles"] == 16 * flat["triangles"] and cut["lo_m"] == flat["lo_m"] and cut["hi_m"] == flat["hi_m"])


def check_mesh(folder):
    """A triangle takes the texel at its middle, on a wall in the wall's two axes."""
    image(folder / "grain.img", numpy.array([[3.0, 4.0], [1.0, 2.0]]))
    (folder / "turf.csv").write_text(
        "wavelength_nm,a,b,c,d\n" + "".join(f"{nm},0.1,0.2,0.3,0.4\n" for nm in (400, 1000))
    )
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "v 1 0 1", "v 1 1 0", "v 2 0 0", "v 2 1 0"]
    faces = ["f 1 2 3", "f 6 3 2", "f 2 7 8"]
    (folder / "tiles.obj").write_text("\n".join(lines + faces) + "\n")
    mesh = '[[mesh]]\nname = "tiles"\nfile = "tiles.obj"\nmaterial = "turf"\n[[instance]]\nmesh = "tiles"\n'
    file = write(folder, "mesh.toml", mesh, samples=3)
    shown = reflectance(folder, file)
    seen = {round(float(v), 5) for v in shown[..., 0][numpy.isfinite(shown[..., 0])]}
    check(seen == {0.1, 0.2}, seen)  # the square at x 0 .. 1 has the lower left texel, the next the one beside it


def check_light_between(folder):
    """Light between surfaces of many spectra, and a pixel's budget, in which they are one material."""
    rng = numpy.random.default_rng(5)
    many = 100
    spectra = 0.3 + 0.1 * rng.uniform(-1, 1, (many, 1)) * (NODES_NM - 400) / 600
    table = numpy.column_stack([NODES_NM, spectra.T])
    names = ",".join(f"m{i}" for i in range(many))
    numpy.savetxt(folder / "turf.csv", table, "%.6f", ",", header="wavelength_nm," + names, comments="")
    image(folder / "grain.img", rng.normal(0, 1, (16, 16)))
    wall = '[[box]]\nmaterial = "turf"\nposition_m = [0.0, 4.0, 0.0]\nsize_m = [30.0, 1.0, 6.0]\n'
    head = "tolerance = 0.05\nbounces = 4\nsky_directions = 64"
    file = write(folder, "walls.toml", PLATE + wall, head=head, samples=5, air='{ model = "clear_sky" }')
    run("render", file, "-o", folder / "walls")
    told = json.loads(run("explain", file, "--pixel", "24,18", "--json").stdout)
    kinds = [(x["kind"], x.get("material"), x.get("through"), x.get("number")) for x in told["light"]]
    check(len(kinds) == len(set(kinds)) and ("turf" in {k[1] for k in kinds}), kinds)
    check(numpy.allclose(told["sum"], told["rendered"], rtol=1e-5), told["worst_difference"])
    cube = envi(folder / "walls" / "camera", "radiance")[1]
    check(numpy.array_equal(numpy.array(told["rendered"], "f4"), cube[18, 24]))


def check_refusals(folder):
    plate = write(folder, "plate.toml", PLATE)
    good = plate.read_text()

    def says(*parts, old="", new=""):
        (folder / "bad.toml").write_text(good.replace(old, new))
        refused("scene", "check", folder / "bad.toml", status=2, says=parts)

    texture, family = 'texture = { image = "grain.img", texel_m = 1.0  }', 'family = "turf.csv"'
    says("a family and a texture go together", "only family", old=texture, new="")
    says("exactly one of file, family, reflectance and leaf", old=family, new=family + "\nreflectance = 0.3")
    says("band reaches beyond", "400 .. 2000 nm", old="texel_m = 1.0", new="texel_m = 1.0, band_nm = [400, 2000]")
    says("shorter to a longer", old="texel_m = 1.0", new="texel_m = 1.0, band_nm = [700, 400]")
    says("grain.png", old="grain.img", new="grain.png")
    says("more than 1e7 squares", old="texel_m = 1.0", new="texel_m = 0.01")
    says("'transmittance' goes with", "opaque", old=family, new=family + "\ntransmittance = 0.1")
    (folder / "through.csv").write_text("wavelength_nm,a,transmittance\n400,0.1,0.1\n1000,0.2,0.1\n")
    says("column 'transmittance'", old="turf.csv", new="through.csv")
    (folder / "water.csv").write_text("# medium: water\nwavelength_nm,a,b\n400,0.1,0.1\n1000,0.2,0.1\n")
    says("unknown medium", old="turf.csv", new="water.csv")
    terrain = '[[terrain]]\nraster = "height.img"\ncell_m = 4.0\nmaterial = "turf"\nrefine = 64\n'
    image(folder / "height.img", numpy.zeros((300, 300)))
    says("more than 1e8 cells", "refine = 33 fits", old=PLATE, new=terrain)
    (folder / "one.csv").write_text("wavelength_nm,a\n400,0.1\n1000,0.2\n")
    says("2 to 4096 spectra", "1 in", old="turf.csv", new="one.csv")
    (folder / "bright.csv").write_text("wavelength_nm,a,b\n400,0.1,0.2\n1000,0.2,1.2\n")
    says("reflectance outside 0 .. 1", old="turf.csv", new="bright.csv")


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        spectra = family()
        table = numpy.column_stack([NODES_NM, spectra.T])
        names = ",".join(f"member {i}" for i in range(MEMBERS))
        numpy.savetxt(folder / "turf.csv", table, "%.9f", ",", header="wavelength_nm," + names, comments="")
        values = numpy.random.default_rng(1).normal(100, 20, (ROWS, COLUMNS)).astype("f4")
        image(folder / "grain.img", values)
        at_bands = check_choice(folder, spectra, values)
        check_terrain(folder, spectra, values, at_bands)
        info = run("scene", "info", folder / "plate.toml").stdout
        check(f"family of {MEMBERS}" in info and info.count("turf") == 2, info)
        compiled = json.loads(run("scene", "info", folder / "plate.toml", "--json").stdout)
        check([m["spectra"] for m in compiled["materials"]] == [MEMBERS, 1], compiled["materials"])
        check_moments(folder, spectra, at_bands)
        check_refusals(folder)
        check_mesh(folder)
        check_light_between(folder)
    print(f"texture: {program.checks} checks")


main()
