"""`raycube measure` (LIGHT 5). Oracles: Lambert's law and Fujii's form of Oren and Nayar's, albedo 1 of canopies that
absorb nothing, reciprocity, and for a layer of leaves a turbid medium's Monte Carlo written here: no geometry, own
draws. usage: measure_test.py RAYCUBE SCENES [--full]
Without --full: the sparser canopy that absorbs nothing alone, which takes a quarter of the denser one's minute, the
turbid medium in one plane at three angles; fewer directions over level ground, where each is a check of its own and
each sample gives the same; and half as many paths where sun and viewer change places, which are held to standard
errors."""

import json
import math
import pathlib
import re
import sys
import tempfile

import numpy

import patience
from driver import FULL, Program, seed
from photon_steps import leaf_normals, turned_by_cosine

program = Program(sys.argv[1])
RAMI = pathlib.Path(sys.argv[2]) / "rami/generate.py"
run, check, refused = program.run, program.check, program.refused


def measured(file, *more):
    folder = file.parent / "out"
    done = run("measure", file, "-o", folder, "--overwrite", "--json", *more)
    return {one["measure"]: one for one in json.loads(done.stdout)}


PLANE = """format = 1
atmosphere = { model = "clear_sky" }
time = { sun = { zenith_deg = 40.0, azimuth_deg = 215.0 } }
[[material]]
name = "ground"
reflectance = 0.3
MORE
[[plane]]
material = "ground"
size_m = [500.0, 500.0]
[[instrument]]
name = "camera"
kind = "framing"
altitude_agl_m = 500.0
gsd_m = 1.0
pixels = 8
lines = 8
bands = { first_nm = 500.0, step_nm = 300.0, count = 2, fwhm_nm = 10.0 }
[[measure]]
name = "pp"
size_m = [20.0, 10.0]
zenith_deg = [-75, 75, 25]
[[measure]]
name = "op"
views = "orthogonal"
size_m = [20.0, 10.0]
zenith_deg = [-60, 60, 30]
center_m = [30.0, -40.0]
[[measure]]
name = "all"
views = "hemisphere"
directions = 60
size_m = [20.0, 10.0]
"""


def with_fewer(text, directions=12, samples="pixels = 3\nsamples = 4\npaths = 4\n"):
    """So many directions and samples of each; by default few."""
    text = text.replace("directions = 60", f"directions = {directions}")
    return text.replace("[[measure]]\n", "[[measure]]\n" + samples)


def direction(zenith_deg, azimuth_deg):
    zenith, azimuth = math.radians(zenith_deg), math.radians(azimuth_deg)
    return numpy.array(
        [math.sin(zenith) * math.sin(azimuth), math.sin(zenith) * math.cos(azimuth), math.cos(zenith)]
    )


def fujii(to_sun, to_viewer, sigma_deg):
    """pi f of rough matter (Fujii 2012), over its reflectance."""
    s2 = math.radians(sigma_deg) ** 2
    a = 1 / (1 + (0.5 - 2 / (3 * math.pi)) * (b := 0.45 * s2 / (s2 + 0.09) / (1 - 0.5 * s2 / (s2 + 0.33))))
    s = to_sun @ to_viewer - to_sun[2] * to_viewer[2]
    t = max(to_sun[2], to_viewer[2]) if s > 0 else 1.0
    return a * (1 + b * s / t)


def check_planes(folder):
    """Level ground: its reflectance in every direction; rough ground: brighter on the sun's side."""
    file = folder / "plane.toml"
    level = PLANE if FULL else with_fewer(PLANE)
    file.write_text(level.replace("MORE", ""))
    found = measured(file)
    for name in ("pp", "op", "all"):
        for view in found[name]["views"]:
            check(numpy.allclose(view["brf"]["mean"], 0.3, rtol=2e-6), name, view)
            check(max(view["brf"]["multiple"]) == 0)
    check(numpy.allclose(found["all"]["albedo"]["mean"], 0.3, rtol=2e-6), found["all"]["albedo"])
    pp = found["pp"]["views"]
    check([v["zenith_deg"] for v in pp] == [-75, -50, -25, 0, 25, 50, 75], pp)
    check([v["azimuth_deg"] for v in pp] == [35, 35, 35, 215, 215, 215, 215], pp)
    check([v["relative_azimuth_deg"] for v in pp] == [180, 180, 180, 0, 0, 0, 0], pp)
    check([v["azimuth_deg"] for v in found["op"]["views"]] == [305, 305, 125, 125, 125], found["op"])
    check({v["relative_azimuth_deg"] for v in found["op"]["views"]} == {90}, found["op"])
    # As the exercise's own files have it: the first rows of the orthogonal plane at -pi / 2.
    lines = (folder / "out/op/brfop_raycube-op_band1_500nm.mes").read_text().splitlines()
    check([row.split()[2] for row in lines[1:]] == 2 * ["-1.570796"] + 3 * ["1.570796"], lines)
    lines = (folder / "out/pp/brfpp_raycube-pp_band2_800nm.mes").read_text().splitlines()
    check(lines[0] == "   7    5 1.000000" and lines[1].startswith("0.698132 1.308997 "), lines)
    check(abs(float(lines[1].split()[2])) - math.pi < 1e-5 and lines[1].split()[3:] == ["0.300000", "0.000000"], lines)
    rows = (folder / "out/op/measure.csv").read_text().splitlines()
    check(len(rows) == 2 + 5 * 2 and rows[1].startswith("view_zenith_deg,"), rows)
    file.write_text(level.replace("MORE", "oren_nayar = { sigma_deg = 30.0 }"))
    found = measured(file)
    sun = direction(40.0, 215.0)
    for view in found["pp"]["views"] + found["op"]["views"] + found["all"]["views"]:
        wanted = 0.3 * fujii(sun, direction(abs(view["zenith_deg"]), view["azimuth_deg"]), 30.0)
        # The area is seen at angles that differ by 1 / 2000 over it.
        check(numpy.allclose(view["brf"]["mean"], wanted, rtol=1e-4), view, wanted)


def canopy(folder, *arguments, edit=lambda text: text):
    patience.run([sys.executable, RAMI, folder, *map(str, arguments)], check=True, capture_output=True)
    file = folder / "canopy.toml"
    file.write_text(edit(file.read_text().split("[[budget]]")[0]))
    return file


def curves(folder, leaf, soil):
    """One reflectance, transmittance and soil at all wavelengths."""
    row = lambda *values: ",".join(map(str, values))
    (folder / "leaf.csv").write_text(
        "wavelength_nm,reflectance,transmittance\n" + "\n".join(row(nm, *leaf) for nm in (600, 900)) + "\n"
    )
    (folder / "soil.csv").write_text(
        "wavelength_nm,reflectance\n" + "\n".join(row(nm, soil) for nm in (600, 900)) + "\n"
    )


def only(*names):
    """Leaves the other measures out of a canopy's file."""

    def edit(text):
        head, *measures = text.split("[[measure]]\n")
        kept = [m for m in measures if re.match(r'name = "(\w+)"', m)[1] in names]
        return head + "".join("[[measure]]\n" + m for m in kept)

    return edit


SMALL = ("--radius", 0.02, "--height", 2.0, "--cell", 4.0)


def check_energy(folder):
    """Leaves that absorb nothing over white ground give all back; over ground that absorbs, what the ground leaves."""
    for lai in (1, 3):
        edit = lambda text: only("albedo")(text).replace('"hemisphere"', '"hemisphere"\ndirections = 24')
        file = canopy(folder / f"white{lai}", "--lai", lai, *SMALL, edit=edit)
        curves(file.parent, (0.5, 0.5), 1.0)
        albedo = measured(file)["albedo"]["albedo"]
        check(all(e < 0.003 for e in albedo["error"]), albedo)
        for mean, error in zip(albedo["mean"], albedo["error"]):
            program.within(mean - 1, 4.5 * error + 1e-3, "white canopy", lai, albedo)


def turbid(lai, leaf, soil, sun_zenith_deg, views, photons, rng):
    """Reflectance factors and standard errors towards views (unit vectors) of a layer of tiny leaves of all
    orientations over Lambertian ground: photons by chance, their light told to every view at each collision."""
    groups = []
    for _ in range(20):
        count = photons // 20
        way = numpy.tile(-direction(sun_zenith_deg, 180.0), (count, 1))
        depth, weight, seen = numpy.zeros(count), numpy.ones(count), numpy.zeros(len(views))
        while len(weight):
            # Leaf area above: half of it in the way of any direction, over its cosine.
            depth = depth - numpy.log(rng.random(len(weight))) * 2 * -way[:, 2]
            out, ground = depth < 0, depth >= lai
            keep = ~out
            depth, weight, way, ground = depth[keep], weight[keep], way[keep], ground[keep]
            depth = numpy.minimum(depth, lai)
            normal = leaf_normals(way, rng)
            normal[ground] = (0, 0, 1)
            normal *= -numpy.sign((normal * way).sum(1))[:, None]  # to where the light came from
            back = numpy.where(ground, soil, leaf[0])
            through = numpy.where(ground, 0.0, leaf[1])
            for i, view in enumerate(views):
                facing = normal @ view
                sent = numpy.where(facing > 0, back, through) * numpy.abs(facing)
                seen[i] += (weight * sent * numpy.exp(-0.5 * depth / view[2])).sum() / view[2] / count
            weight = weight * (back + through)
            turned = rng.random(len(weight)) * (back + through) < back
            axis = numpy.where(turned[:, None], normal, -normal)
            way = turned_by_cosine(axis, rng)
            alive = rng.random(len(weight)) < 0.9  # the others end, these stand for them
            depth, weight, way = depth[alive], weight[alive] / 0.9, way[alive]
        groups.append(seen)
    groups = numpy.array(groups)
    return groups.mean(0), groups.std(0, ddof=1) / math.sqrt(len(groups))


def check_turbid(folder):
    """A layer of leaves of a hundredth of its depth against one of none: outside the hot spot within 1.5 % (a cell of
    13 000 leaves' areas shows the ground through chance gaps, 1 % of its light) and 4.5 standard errors."""
    leaf, soil, sun = (0.4957, 0.4409), 0.159, 30.0
    planes = "principal", "orthogonal"
    edit = lambda text: only(*planes)(text).replace(
        "height_m = 2.0", "height_m = 2.0\nzenith_deg = [-60, 60, 30]\nsamples = 256\npaths = 128"
    )
    file = canopy(folder / "layer", "--lai", 2, *SMALL, "--sun-zenith", sun, edit=edit)
    found = measured(file)
    views = [v for name in planes for v in found[name]["views"] if v["zenith_deg"] != 30 or
             name == "orthogonal"]
    ways = [direction(abs(v["zenith_deg"]), v["azimuth_deg"]) for v in views]
    rng = numpy.random.default_rng(seed(3))
    for band, matter in ((0, ((0.0546, 0.0149), 0.127)), (1, (leaf, soil))):
        wanted, error = turbid(2.0, *matter, sun, ways, 400000, rng)
        for view, mean, sigma in zip(views, wanted, error):
            ours, own = view["brf"]["mean"][band], view["brf"]["error"][band]
            print(
                f"band {band}, view {view['zenith_deg']:4.0f} {view['relative_azimuth_deg']:5.0f}: {ours:.5f} +- "
                f"{own:.5f}, turbid {mean:.5f} +- {sigma:.5f}"
            )
            check(own < 0.005 * ours, view)
            program.within(ours - mean, 4.5 * math.hypot(own, sigma) + 0.015 * mean, "turbid", view, mean, sigma)


def check_reciprocity(folder):
    """Sun and viewer change places, over the same leaves."""
    found, paths = {}, 256 if FULL else 128
    for sun, view, azimuth in ((20, 60, 180), (60, 20, 0)):
        edit = lambda text: only("principal")(text).replace(
            "height_m = 2.0", f"height_m = 2.0\nzenith_deg = [{-view}, {-view}, 1]\nsamples = 256\npaths = {paths}"
        ).replace("azimuth_deg = 180.0", f"azimuth_deg = {azimuth}.0")
        leaves = ("--lai", 3, *SMALL, "--angles", "planophile")
        file = canopy(folder / f"sun{sun}", *leaves, "--sun-zenith", sun, edit=edit)
        found[sun] = measured(file)["principal"]["views"][0]["brf"]
    for band in range(2):
        (a, da), (b, db) = ((found[s]["mean"][band], found[s]["error"][band]) for s in (20, 60))
        program.within(a - b, 4.5 * math.hypot(da, db) + 1e-5, "reciprocity", band, a, da, b, db)


def check_area(folder):
    """An area's own colour and nothing of the ground beside it, from every view: its first side lies across the plane
    of sight, the other along it, however slantingly one looks."""
    file = folder / "area.toml"
    plate = '[[plane]]\nmaterial = "plate"\nposition_m = [3.0, -7.0, 0.0]\nsize_m = [20.04, 10.04]\n'
    text = PLANE.replace("MORE", '[[material]]\nname = "plate"\nreflectance = 0.9').replace("215.0", "180.0")
    text = text.replace("[[plane]]", plate + "[[plane]]\nposition_m = [0.0, 0.0, -0.001]", 1)
    file.write_text(text.replace('name = "pp"', 'name = "pp"\ncenter_m = [3.0, -7.0]\nheight_m = 0.0'))
    for view in measured(file, "--name", "pp")["pp"]["views"]:
        check(numpy.allclose(view["brf"]["mean"], 0.9, rtol=2e-6), view)


def check_cell(folder):
    """A cell of two colours, seen from all sides: its area turns with the view, and still the cell's mean comes out. A
    corner that is another colour weighs as much as its share of the cell, 1 / 16."""
    file = folder / "cell.toml"
    corner = '[[plane]]\nmaterial = "corner"\nposition_m = [3.0, 3.0, 0.001]\nsize_m = [2.0, 2.0]\n'
    text = PLANE.replace("MORE", '[[material]]\nname = "corner"\nreflectance = 0.9').replace("500.0, 500.0", "8.0, 8.0")
    text = text.replace("[[plane]]", corner + "[[plane]]", 1).replace("20.0, 10.0", "8.0, 8.0")
    text = text.replace("format = 1", "format = 1\nscene = { periodic = { x_m = 8.0, y_m = 8.0, copies = 8 } }")
    file.write_text(text if FULL else with_fewer(text, 24, ""))
    wanted = 0.3 + (0.9 - 0.3) / 16
    found = measured(file)
    for view in found["all"]["views"] + found["pp"]["views"]:
        for mean, error in zip(view["brf"]["mean"], view["brf"]["error"]):
            check(error < 0.02, view)
            program.within(mean - wanted, 5 * error + 1e-4, "cell", view, wanted)
    albedo = found["all"]["albedo"]
    check(albedo["error"][0] < 0.001, albedo)
    program.within(albedo["mean"][0] - wanted, 4.5 * albedo["error"][0] + 1e-4, "albedo", albedo)


def check_refusals(folder):
    file = folder / "bad.toml"
    good = PLANE.replace("MORE", "")

    def says(*parts, old, new, messages=1):
        check(old in good, old)
        file.write_text(good.replace(old, new))
        refused("measure", file, "-o", folder / "bad", status=2, says=parts, messages=messages)
        check(not (folder / "bad").exists())

    says("zenith angles go up", "75, -75", old="[-75, 75, 25]", new="[75, -75, 25]")
    says("'directions' means nothing", "principal", old='name = "pp"', new='name = "pp"\ndirections = 20')
    says("no instrument of that name", "the file has: camera", old='name = "pp"', new='name = "pp"\nbands_of = "cam"')
    says("is defined twice", "pp", old='name = "op"', new='name = "pp"')
    says("sun above the horizon", "95", old="zenith_deg = 40.0", new="zenith_deg = 95.0", messages=3)
    says("measure 'pp' is of sunlight", "3", old="first_nm = 500.0", new="first_nm = 9000.0", messages=3)
    says("a measure's name is a folder's", "p/p", old='name = "pp"', new='name = "p/p"')
    edges = {"old": "20.0, 10.0]\nzenith", "new": "480.0, 240.0]\nzenith", "messages": 2}
    says("measure 'pp' looks past the scene's edge", "x from -268", "measure 'op' looks past", **edges)
    # A night is no matter for a render: `scene check` alone says what cannot be measured.
    file.write_text(good.replace("zenith_deg = 40.0", "zenith_deg = 95.0"))
    refused("scene", "check", file, status=2, says=["measure 'all' wants a sun above the horizon"], messages=3)
    run("plan", file)
    (folder / "short.csv").write_text("wavelength_nm,reflectance\n600,0.1\n900,0.2\n")
    says("covers 600 to 900 nm", "short.csv", old="reflectance = 0.3", new='file = "short.csv"')
    says("more than 10000 views", "150001", old="[-75, 75, 25]", new="[-75, 75, 0.001]")
    things = good[good.index("[[plane]]") : good.index("[[instrument]]")]
    says("nothing to look at", "an empty scene", old=things, new="", messages=3)
    says("no [[measure]]", "add one", old=good[good.index("[[measure]]") :], new="")
    file.write_text(good)
    refused("measure", file, "--name", "up", "-o", folder / "bad", status=2, says=("there are: pp, op, all",))
    file.write_text(with_fewer(good))
    run("measure", file, "--name", "pp", "-o", folder / "bad")
    file.write_text(good)
    refused("measure", file, "--name", "pp", "-o", folder / "bad", status=2, says=("is there already", "--overwrite"))
    # Another plane under the same name: nothing of the first stays beside it.
    for views, left in (('views = "orthogonal"', {"brfop", "measure"}), ('views = "hemisphere"', {"measure"})):
        quick = "pixels = 1\nsamples = 1\npaths = 1\n" + ("directions = 6\n" if "hemisphere" in views else "")
        text = good.replace('name = "pp"\n', f'name = "pp"\n{views}\n{quick}')
        file.write_text(text.replace("zenith_deg = [-75, 75, 25]\n", "") if "hemisphere" in views else text)
        run("measure", file, "--name", "pp", "-o", folder / "bad", "--overwrite")
        found = {path.name.replace(".", "_").partition("_")[0] for path in (folder / "bad" / "pp").iterdir()}
        check(found == left, views, found)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_planes(folder)
        check_area(folder)
        check_cell(folder)
        check_refusals(folder)
        check_reciprocity(folder)
        if FULL:  # a minute each; what becomes of all light is light_budget's as well
            check_energy(folder)
            check_turbid(folder)
    print(f"measure: {program.checks} checks")


main()
