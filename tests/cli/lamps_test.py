"""Lamps (S6): light of points, spots, rectangles, discs and photometric files. Oracles: the inverse square of the
distance times the cosine, at the samples' own places; the flux that a lamp sends all falls onto a floor that is wide
enough; closed forms of discs and rectangles; sums of scenes with one lamp each. usage: lamps_test.py RAYCUBE"""

import json
import math
import pathlib
import tempfile

import numpy

from driver import envi
from lamp_scenes import FLAT, GRID, POINT, RED, REFLECTANCE, SIZE, check, program, render, run, world, write_files


def places(size=SIZE, gsd=0.25, grid=GRID):
    """Ground coordinates of every sample, [line][pixel][sample]: north is up."""
    cell = (numpy.arange(size * grid) + 0.5) / grid * gsd - size * gsd / 2
    x, y = numpy.meshgrid(cell, -cell)
    blocks = [a.reshape(size, grid, size, grid).transpose(0, 2, 1, 3).reshape(size, size, -1) for a in (x, y)]
    return numpy.stack(blocks, -1)


def irradiance(at, intensity):
    """Of a point with intensity(cosine to straight down) W sr-1 on level ground, the pixels' means."""
    d = places() - numpy.array(at[:2])
    d2 = (d**2).sum(-1) + at[2] ** 2
    cosine = at[2] / numpy.sqrt(d2)
    return (intensity(cosine) * cosine / d2).mean(-1)


def expected(e):
    return REFLECTANCE / math.pi * FLAT * e


def close(found, wanted, tolerance, *what):
    worst = (numpy.abs(found - wanted) / numpy.abs(wanted).max()).max()
    check(worst < tolerance, *what, worst)


def check_points(work):
    at = (0.7, -0.4, 2.5)
    lamp = POINT.format(name="a", at="0.7, -0.4, 2.5", power=30.0)
    image, truth = render(work, "point", lamps=lamp)
    close(truth["x_m"], places()[..., 0].mean(-1), 1e-4, "the test's places are the image's")
    close(truth["y_m"], places()[..., 1].mean(-1), 1e-4, "the test's places are the image's")
    wanted = expected(irradiance(at, lambda c: 30 / (4 * math.pi) + 0 * c))
    close(image[..., 0], wanted, 1e-5, "inverse square of the distance, cosine")
    check(numpy.array_equal(image[..., 0], image[..., 1]), "a flat spectrum has no colour")
    spot = (
        f'{{ name = "s", shape = "spot", position_m = [0.7, -0.4, 2.5], cone_deg = [20, 40], '
        "temperature_K = 3000, flux_lm = 800.0 }"
    )
    image, _ = render(work, "spot", lamps=spot)
    inner, outer = math.cos(math.radians(20)), math.cos(math.radians(40))
    shape = irradiance(at, lambda c: numpy.clip((c - outer) / (inner - outer), 0, 1) ** 2)
    close(image[..., 0] / image[..., 0].max(), shape / shape.max(), 2e-5, "cones of a spot")
    return lamp, spot


def check_flux(work, lamp, spot):
    """All of a lamp's flux falls onto the floor, and the mean of its irradiance times the floor's area is it."""
    area = (SIZE * 0.5) ** 2
    files = dict(cosine='ies = "cosine.ies", power_W = 12.0', street='ies = "street.ies", power_W = 12.0')
    for name, keys in files.items():
        text = f'{{ name = "i", position_m = [0.3, 0.2, 1.0], spectrum = "flat.csv", {keys} }}'
        image, _ = render(work, "flux_" + name, lamps=text, gsd=0.5, instrument="samples = { grid = [12, 12] }")
        found = image[..., 0].mean() * area * math.pi / REFLECTANCE / FLAT
        reach = 12.0 if name == "street" else 12.0 * share_of_cosine(image.shape[0] * 0.5, (0.3, 0.2, 1.0))
        check(abs(found / reach - 1) < 2e-3, "flux of", name, found, reach)
    text = (
        '{ name = "s", shape = "spot", position_m = [0.3, 0.2, 2.0], cone_deg = [30, 50], spectrum = "flat.csv", '
        "power_W = 12.0 }"
    )
    image, _ = render(work, "flux_spot", lamps=text, gsd=0.5, instrument="samples = { grid = [12, 12] }")
    found = image[..., 0].mean() * area * math.pi / REFLECTANCE / FLAT
    check(abs(found / 12 - 1) < 1e-3, "flux of a spot", found)


def share_of_cosine(side, at):
    """Of the flux of a lamp I0 cos that hangs over a square floor, what falls onto it: I0 cos^2 / d^2, in closed form
    the configuration factor of a rectangle (Howell C-3), summed over the four corners."""
    total = 0.0
    for x in (side / 2 - at[0], side / 2 + at[0]):
        for y in (side / 2 - at[1], side / 2 + at[1]):
            a, b = x / at[2], y / at[2]
            total += (
                a / math.hypot(1, a) * math.atan(b / math.hypot(1, a))
                + b / math.hypot(1, b) * math.atan(a / math.hypot(1, b))
            ) / (2 * math.pi)
    return total


def check_units(work):
    """683 lm at 555 nm are 1 W; candelas of a file as they are; a black body sends sigma T^4 / pi in all."""
    bands = "samples = { grid = [4, 4] }"
    lamp = '{{ name = "a", position_m = [0.7, -0.4, 2.5], {light} }}'
    watt, _ = render(
        work,
        "watt",
        lamps=lamp.format(light='spectrum = "line.csv", power_W = 1.0'),
        head="bounces = 0",
        instrument=bands,
    )
    check(not watt.any(), "bands that see nothing of a lamp", watt.max())
    wide = "bands = { first_nm = 555.0"
    text = world(work, "lumen", lamps=lamp.format(light='spectrum = "line.csv", flux_lm = 683.0')).read_text()
    for name, light in dict(lumen="flux_lm = 683.0", one="power_W = 1.0", ies='ies = "cosine.ies"').items():
        (work / f"{name}.toml").write_text(
            text.replace("flux_lm = 683.0", light).replace("bands = { first_nm = 500.0", wide)
        )
        run("render", work / f"{name}.toml", "-o", work / name, "-q")
    lumen, one, ies = (
        envi(work / name / "camera", "radiance")[1].astype(float)[..., 0] for name in ("lumen", "one", "ies")
    )
    close(lumen, one, 1e-4, "683 lm are 1 W at 555 nm")
    at = (0.7, -0.4, 2.5)
    ratio = irradiance(at, lambda c: 200 / 683 * c) / irradiance(at, lambda c: 1 / (4 * math.pi) + 0 * c)
    close(ies / one, ratio, 1e-3, "candelas over 683 are W sr-1 at 555 nm, the file's multiplier counts")


def folded(c, kind):
    """Of an angle C in degrees, where a file of a kind of symmetry has it."""
    c = numpy.mod(c, 360.0)
    if kind == 90:
        c = numpy.mod(c, 180.0)
        return numpy.where(c > 90, 180 - c, c)
    if kind == 180:
        return numpy.where(c > 180, 360 - c, c)
    if kind == 270:
        return numpy.where((c >= 90) & (c <= 270), c, numpy.mod(180 - c, 360.0))
    return c


def check_directions(work):
    """Photometric files of every symmetry, turned: C0 lies at turn_deg clockwise from north, C grows the other way."""
    kinds = {
        90: ([0, 30, 60, 90], [1, 0.5, 0.2, 0.8]),
        180: ([0, 60, 180], [1, 0.3, 0.7]),
        270: ([90, 180, 270], [0.3, 1, 0.6]),
        360: ([0, 90, 180, 270, 360], [1, 0.2, 0.6, 0.4, 1]),
    }
    at = numpy.array([0.4, -0.3, 2.5])
    d = places() - at[:2]
    bearing = numpy.degrees(numpy.arctan2(d[..., 0], d[..., 1]))
    d2 = (d**2).sum(-1) + at[2] ** 2
    for kind, (angles, values) in kinds.items():
        rows = "\n".join(f"{100 * v} {100 * v} {50 * v}" for v in values)  # by the vertical angle 0, 45 and 90
        (work / f"kind{kind}.ies").write_text(
            f"IESNA91\nTILT=INCLUDE\n1\n2\n0 90\n1 1\n1 1000 2.0 3 {len(angles)} 1 1 0 0 0 0.5 1.0 50\n0 45 90\n"
            + " ".join(map(str, angles))
            + "\n"
            + rows
            + "\n"
        )
        for turn in (0.0, 40.0):
            lamp = (
                f'{{ name = "k", position_m = [0.4, -0.3, 2.5], ies = "kind{kind}.ies", turn_deg = {turn}, '
                'spectrum = "flat.csv", power_W = 30.0 }'
            )
            image, _ = render(work, f"kind{kind}_{turn}", lamps=lamp)
            gamma = numpy.degrees(numpy.arccos(at[2] / numpy.sqrt(d2)))
            shape = numpy.interp(folded(turn - bearing, kind), angles, values) * numpy.interp(
                gamma, [0, 45, 90], [1, 1, 0.5]
            )
            wanted = (shape * at[2] / d2**1.5).mean(-1)
            close(image[..., 0] / image[..., 0].sum(), wanted / wanted.sum(), 2e-4, "directions of a file", kind, turn)
    # 2019's file type is no factor; of older files it is one.
    text = (work / "kind360.ies").read_text()
    for name, head in (("new", "IESNA:LM-63-2019"), ("old", "IESNA:LM-63-1995")):
        (work / f"{name}.ies").write_text(text.replace("IESNA91", head).replace("0.5 1.0 50", "0.5 1.1 50"))
    lamp = '{{ name = "k", position_m = [0.4, -0.3, 2.5], ies = "{file}.ies", spectrum = "flat.csv" }}'
    means = [render(work, "type_" + file, lamps=lamp.format(file=file))[0].mean() for file in ("kind360", "new", "old")]
    check(abs(means[1] / means[0] - 1) < 1e-6 and abs(means[2] / means[0] - 1.1) < 1e-6, means)


def check_lines(work):
    """A spectrum that ends in a jump: bands side by side sum to the flux, whatever the air's grid."""
    lamp = '{ name = "a", position_m = [0.7, -0.4, 2.5], spectrum = "line.csv", power_W = 30.0 }'
    edges = "\n".join(
        f"{b},{nm},{1 if lo <= nm < hi else 0}"
        for b, (lo, hi) in enumerate(((550, 555), (555, 560)))
        for nm in (549, 549.99, 550, 554.99, 555, 559.99, 560, 561)
    )
    (work / "boxes.csv").write_text("band,wavelength_nm,response\n" + edges + "\n")
    text = world(work, "line", lamps=lamp).read_text()
    (work / "line.toml").write_text(
        text.replace(
            "bands = { first_nm = 500.0, step_nm = 200.0, count = 2, fwhm_nm = 20.0 }",
            'bands = { file = "boxes.csv" }',
        )
    )
    run("render", work / "line.toml", "-o", work / "line", "-q")
    image = envi(work / "line" / "camera", "radiance")[1].astype(float).sum(-1)  # bands of 5 nm: means over them
    wanted = REFLECTANCE / math.pi * irradiance((0.7, -0.4, 2.5), lambda c: 30 / (4 * math.pi) + 0 * c) / 0.005
    close(image, wanted, 5e-3, "a line's flux in bands side by side")  # responses have flanks of 10 pm


def check_errors(work):
    """What a wide lamp's standard errors say, over what eight seeds scatter by: 576 pixels, half in half shadow. The
    sun's shadow of the same roof has 0.84 with 16 samples, 1.42 with 64."""
    wide = (
        '{ name = "wide", shape = "rectangle", size_m = [3.0, 2.0], position_m = [0, 0, 3.0], spectrum = "flat.csv", '
        "power_W = 50.0 }"
    )
    roof = '{ material = "dark", size_m = [1.5, 4.0], position_m = [1.0, 0, 1.2] }'
    for samples in (16, 64):
        images, told = [], []
        for seed in range(8):
            name = f"seed{samples}_{seed}"
            file = world(
                work,
                name,
                lamps=wide,
                planes=roof,
                instrument=f'samples = {{ lattice = {samples} }}\nstandard_error = "bands"',
            )
            run("render", file, "-o", work / name, "-q", "--seed", seed + 1)
            images.append(envi(work / name / "camera", "radiance")[1][..., 0].astype(float))
            told.append(envi(work / name / "camera", "standard_error")[1][..., 0].astype(float))
        scatter = numpy.sqrt(numpy.var(images, axis=0, ddof=1).mean())
        stated = numpy.sqrt((numpy.array(told) ** 2).mean())
        least = {16: 0.7, 64: 0.8}[samples]
        program.between(least, stated / scatter, 1.6, "standard errors under a wide lamp", samples)


def check_surfaces(work):
    """A disc on its axis: E = flux / (pi (r^2 + h^2)); a rectangle above its corner: Howell's factor C-3."""
    disc = (
        '{ name = "d", shape = "disc", diameter_m = 3.0, position_m = [0, 0, 2.001], spectrum = "flat.csv", '
        "power_W = 50.0 }"
    )
    image, _ = render(work, "disc", lamps=disc, pixels=1, gsd=0.02, instrument="samples = { grid = [200, 200] }")
    wanted = expected(50 / (math.pi * (1.5**2 + 2.0**2)))
    check(abs(image[0, 0, 0] / wanted - 1) < 2e-3, "a disc on its axis", image[0, 0, 0], wanted)
    panel = (
        '{ name = "r", shape = "rectangle", size_m = [3.0, 2.0], turn_deg = 90.0, position_m = [1.5, 1.0, 2.001], '
        'spectrum = "flat.csv", power_W = 50.0 }'
    )
    image, _ = render(work, "panel", lamps=panel, pixels=1, gsd=0.02, instrument="samples = { grid = [200, 200] }")
    a, b = 1.5, 1.0
    factor = (
        a / math.hypot(1, a) * math.atan(b / math.hypot(1, a)) + b / math.hypot(1, b) * math.atan(a / math.hypot(1, b))
    ) / (2 * math.pi)
    wanted = expected(50 / 6 * factor)
    check(abs(image[0, 0, 0] / wanted - 1) < 2e-3, "a rectangle over its corner", image[0, 0, 0], wanted)


def check_sums(work, lamp, spot):
    """Lamps and the sun add up; truth per band says what is whose; a shade is dark; light comes through leaves."""
    roof = '{ material = "dark", size_m = [1.0, 1.0], position_m = [0.7, -0.4, 1.5] }'
    truth = 'samples = { grid = [4, 4] }\nband_truth = ["parts", "irradiance"]'
    both, _ = render(work, "both", lamps=f"{lamp}, {spot}", planes=roof, sun=40.0, instrument=truth)
    lit, _ = render(work, "lit", planes=roof, sun=40.0)
    first, _ = render(work, "first", lamps=lamp, planes=roof)
    second, _ = render(work, "second", lamps=spot, planes=roof)
    part = envi(work / "both" / "camera", "radiance_lamps")[1].astype(float)
    sun = envi(work / "both" / "camera", "radiance_sun")[1].astype(float)
    close(both, lit + first + second, 4e-3, "sources add up, but for which lamp is drawn")
    close(part + sun, both, 1e-6, "parts sum to the radiance")
    close(sun, lit, 1e-6, "the sun's part")
    # Under the roof (1 m at 1.5 m below a lamp at 2.5 m: 2.5 m wide on the floor) nothing but its own top is lit.
    d = places() - numpy.array([0.7, -0.4])
    under = (numpy.abs(d).max(-1) < 1.24).all(-1) & (numpy.abs(d).max(-1) > 0.52).all(-1)
    check(under.sum() > 20 and not first[under].any(), "the roof's shade", first[under].max())
    falls = envi(work / "both" / "camera", "irradiance")[1].astype(float)
    floor = (numpy.abs(d).max(-1) > 0.52).all(-1)
    close(falls[floor] * REFLECTANCE / math.pi, both[floor], 1e-5, "radiance is reflectance x irradiance / pi")
    sheet = '{ material = "leaf", size_m = [30.0, 30.0], position_m = [0, 0, 3.0] }'
    image, _ = render(work, "through", lamps=lamp, planes=sheet)
    at = (0.7, -0.4, 0.5)  # 0.5 m below the sheet, as far as it would be above
    wanted = 0.25 / math.pi * FLAT * irradiance_of_sheet(at)
    close(image[..., 0], wanted, 1e-5, "light through a leaf")


def irradiance_of_sheet(at):
    scale = (300 - 3) / 300  # the camera sees the sheet nearer
    d = places() * scale - numpy.array(at[:2])
    d2 = (d**2).sum(-1) + at[2] ** 2
    return (30 / (4 * math.pi) * at[2] / d2**1.5).mean(-1)


def check_forms(work, lamp, spot):
    """Every form of rendering has lamps; none depends on threads or memory."""
    many = ", ".join(
        POINT.format(name=f"p{i}", at=f"{i % 4 * 1.5 - 2}, {i // 4 * 1.5 - 2}, 2.0", power=5 + i) for i in range(16)
    )
    box = '{ material = "dark", size_m = [1.0, 1.0], position_m = [0.7, -0.4, 1.5] }'
    for name, values in dict(
        lattice=dict(lamps=f"{many}, {spot}", planes=box, instrument="samples = { lattice = 64 }"),
        adaptive=dict(lamps=many, planes=box, instrument="samples = { lattice = 64, first = 8 }"),
        chunks=dict(lamps=many, planes=box, instrument="samples = { jittered = [40, 40] }", pixels=8),
        spread=dict(
            lamps=many,
            planes=box,
            instrument="samples = { grid = [6, 6] }\npsf = { sigma_px = 0.5, support_px = 4.0 }",
        ),
        chosen=dict(
            lamps=many, planes=box, head="bounces = 0\ntolerance = 0.02", instrument='standard_error = "bands"'
        ),
        day=dict(lamps=many, planes=box, sun=30.0),
    ).items():
        once, _ = render(work, name, **values)
        again, _ = render(work, name, "--overwrite", "--threads", 1, "--memory", "30M", **values)
        check(numpy.array_equal(once, again), name, "the same bits on one thread and in 30 MB")
        check(once.mean() > 0, name)


def check_bounces(work):
    """A spot between floor and a wide leaf shines down: of its flux the leaf's underside gets
    U = rho flux / (1 - rho R), and what the camera sees of the leaf is T U / pi, summed over the image; 3 m high on
    100 m it loses 0.4 % past its edges. A red lamp beside a white one: bands that the one lacks have the other's light.
    4.4 and 4 %: four and six times what ten seeds scatter by."""
    spot = (
        '{{ name = "{name}", shape = "spot", position_m = [{at}, 2.5], cone_deg = [50, 60], spectrum = "{file}", '
        "power_W = 40.0 }}"
    )
    leaf = '{ material = "leaf", size_m = [100.0, 100.0], position_m = [0, 0, 3.0] }'
    white, red = spot.format(name="w", at="0.3, 0.2", file="flat.csv"), spot.format(
        name="r", at="-2, 1", file="red.csv"
    )
    wanted = 0.25 * 0.4 / (1 - 0.4 * 0.3) * 40 * FLAT / math.pi
    area = 96.0**2 * ((300 - 3.0) / 300) ** 2  # the camera sees the leaf nearer than the floor
    views = dict(
        planes=leaf,
        head="bounces = 16\nsky_directions = 4096",
        pixels=48,
        gsd=2.0,
        instrument="samples = { lattice = 256 }",
    )
    alone, _ = render(work, "under_leaf", lamps=white, **views)
    pair, _ = render(work, "pair_under_leaf", lamps=f"{white}, {red}", **views)
    for image, what in ((alone, "alone"), (pair, "beside another")):
        found = image[..., 0].mean() * area / wanted
        program.within(found - 1, 0.044, "flux through a leaf by several surfaces", what)
    red_alone = (pair[..., 1].mean() - pair[..., 0].mean()) * area / (wanted / FLAT)
    program.within(red_alone / RED - 1, 0.04, "the red lamp's share at 700 nm")


def check_reference(work, lamp, spot):
    """`raycube check`: the same draws in double, and all lamps at once, by day and by night; light between surfaces."""
    rough = '{ name = "rough", reflectance = 0.4, oren_nayar = { sigma_deg = 30.0 } },'
    box = (
        '{ material = "dark", size_m = [1.0, 1.0], position_m = [0.7, -0.4, 1.5] }, '
        '{ material = "leaf", size_m = [1.5, 1.0], position_m = [-1.2, 0.9, 0.8], tilt_deg = 30.0 }'
    )
    wide = (
        '{ name = "wide", shape = "rectangle", size_m = [1.0, 0.4], position_m = [0, 0, 2.5], '
        'spectrum = "red.csv", power_W = 20.0 }'
    )
    street = '{ name = "street", position_m = [-1, 1, 2.2], ies = "street.ies", spectrum = "flat.csv" }'
    for name, values in dict(
        night=dict(), day=dict(sun=30.0), bounced=dict(head="bounces = 6\ntolerance = 0.05")
    ).items():
        file = world(
            work,
            "checked_" + name,
            lamps=f"{lamp}, {spot}, {wide}, {street}",
            planes=box,
            materials=rough,
            floor="rough",
            **{"instrument": "samples = { lattice = 64 }", "head": "bounces = 0\ntolerance = 0.05", **values},
        )
        done = run("check", file, "-o", work / f"report_{name}", "--json")
        report = json.loads(done.stdout)
        report = report["camera"]
        check(report["passed"], name, report["failures"])
        check(report["lamp_rays"] > 1000 and report["lamp_unexplained"] == 0, name, report)


def main(work):
    write_files(work)
    lamp, spot = check_points(work)
    check_flux(work, lamp, spot)
    check_units(work)
    check_directions(work)
    check_lines(work)
    check_surfaces(work)
    check_errors(work)
    check_sums(work, lamp, spot)
    check_forms(work, lamp, spot)
    check_bounces(work)
    check_reference(work, lamp, spot)


with tempfile.TemporaryDirectory() as folder:
    main(pathlib.Path(folder))
print(f"lamps: {program.checks} checks")
