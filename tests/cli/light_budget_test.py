"""[[budget]] of `raycube measure` (LIGHT 5). Oracles: closed forms of a leaf spread over the ground and of a pile of
leaves, Lambert's law, the albedo that another estimator finds with seeds of its own, Beer's law under the sun and under
a uniform sky, and for a layer of leaves a turbid medium's Monte Carlo written here: no geometry, own draws.
usage: light_budget_test.py RAYCUBE SCENES [--full]; canopies with --full alone."""

import json
import math
import os
import pathlib
import sys
import tempfile

import numpy
import patience
from driver import Program, seed
from photon_steps import leaf_normals, turned_by_cosine

program = Program(sys.argv[1])
RAMI = pathlib.Path(sys.argv[2]) / "rami/generate.py"
run, check, refused = program.run, program.check, program.refused


class Budget:
    """One budget's shares, {(quantity, of): [(mean, error) of each band]}."""

    def __init__(self, told):
        self.told = told
        self.share = {
            (one["quantity"], one.get("of", "")): list(zip(one["mean"], one["error"])) for one in told["shares"]
        }

    def of(self, quantity, name="", band=0):
        return self.share[quantity, name][band]

    def is_near(self, wanted, quantity, name="", band=0, floor=1e-6):
        mean, error = self.of(quantity, name, band)
        program.within(mean - wanted, 4.5 * error + floor, quantity, name, band, mean, error, wanted)


def budgets(file, *more, folder="out"):
    done = run("measure", file, "-o", file.parent / folder, "--overwrite", "--json", *more)
    return {one["budget"]: Budget(one) for one in json.loads(done.stdout) if "budget" in one}


CAMERA = """[[instrument]]
name = "camera"
kind = "framing"
altitude_agl_m = 50.0
gsd_m = 0.1
pixels = 8
lines = 8
bands = { first_nm = 500.0, step_nm = 300.0, count = 2, fwhm_nm = 10.0 }
"""

PILE = f"""format = 1
SEED
scene = {{ periodic = {{ x_m = 4.0, y_m = 3.0, copies = 60 }} }}
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 215.0 }} }}
[[material]]
name = "leaf"
file = "leaf.csv"
[[material]]
name = "soil"
reflectance = 0.4
[[plane]]
material = "leaf"
name = "upper"
position_m = [0.0, 0.0, 2.0]
size_m = [4.0, 3.0]
[[plane]]
material = "soil"
size_m = [4.0, 3.0]
{CAMERA}[[budget]]
name = "sun"
ground = ["soil"]
levels_m = [0.0, 1.0, 2.0, 2.6, 3.3, 50.0]
PHOTONS
[[budget]]
name = "even"
light = "isotropic"
ground = ["soil"]
PHOTONS
"""
LEAF = "wavelength_nm,reflectance,transmittance\n400,0.1,0.05\n600,0.1,0.05\n700,0.5,0.4\n900,0.5,0.4\n"


def check_pile(folder):
    """A leaf over the ground, without edges: what goes between the two is a geometric series in each band."""
    file = folder / "pile.toml"
    (folder / "leaf.csv").write_text(LEAF)
    file.write_text(PILE.replace("SEED", "").replace("PHOTONS", ""))
    for name, found in budgets(file).items():
        for band, (r, t) in enumerate(((0.1, 0.05), (0.5, 0.4))):
            down = t / (1 - 0.4 * r)  # onto the ground
            absorbed = (1 - r - t) * (1 + 0.4 * down)
            found.is_near(r + 0.4 * t * down, "reflected", band=band)
            found.is_near(absorbed, "absorbed", "leaf", band)
            found.is_near(absorbed, "canopy", band=band)
            found.is_near(0.6 * down, "absorbed", "soil", band)
            found.is_near(down, "transmitted", band=band)
            found.is_near(0, "transmitted_uncollided", band=band, floor=0)
            found.is_near(1 + 0.4 * down, "arrived", "leaf", band)
            found.is_near(0, "unfinished", band=band, floor=0)
            check(found.of("lost", band=band)[0] < 1e-4, found.told)  # nearly level light, past the copies
            if name == "sun":
                found.is_near(down, "down", "1", band)
                found.is_near(0.4 * down, "up", "1", band)
                found.is_near(down, "down", "0", band)  # on a surface: just above it
                found.is_near(0.4 * down, "up", "0", band)
                for level in ("2", "2.6", "3.3", "50"):
                    found.is_near(1, "down", level, band, floor=1e-12)
                    found.is_near(r + 0.4 * t * down, "up", level, band)
            check(found.of("absorbed", "leaf", band)[1] < 0.002, found.told)
    rows = (folder / "out/sun/budget.csv").read_text().splitlines()
    check(rows[1] == "quantity,of,band,wavelength_um,share,error,w_m2_um", rows[1])
    # Sunlight on level ground, as the row of all light has it.
    light = [float(row.split(",")[-1]) for row in rows if row.startswith("down,50,")]
    check(abs(light[0] / (1940 * math.cos(math.radians(40))) - 1) < 0.05, light)  # ASTM E-490, 500 nm: 1.9 kW/m2/um


def check_closing(folder):
    """Albedo, what plants absorb and what soil absorbs of all light that reaches it sum to 1 within 1e-4, each by
    photons of other seeds, and the albedo by rays from the viewer."""
    file = folder / "closing.toml"
    # R and T go alike with wavelength, so that what a photon carries varies little.
    (folder / "leaf.csv").write_text(LEAF.replace("0.5,0.4", "0.5,0.25"))
    parts = []
    for own in (11, 12, 13):
        file.write_text(PILE.replace("SEED", "").replace("PHOTONS", "photons = 2400000"))
        parts.append(budgets(file, "--name", "sun", "--seed", own)["sun"])
    parts = [parts[0].of("reflected"), parts[1].of("absorbed", "leaf"), parts[2].of("transmitted")]
    total = parts[0][0] + parts[1][0] + 0.6 * parts[2][0]
    error = math.sqrt(parts[0][1] ** 2 + parts[1][1] ** 2 + (0.6 * parts[2][1]) ** 2)
    print(f"closing: {total:.6f} +- {error:.6f}")
    program.within(total - 1, 1e-4, "closing")
    check(error < 5e-5, error)
    text = PILE.replace("SEED", "seed = 14").replace("PHOTONS", "photons = 160")
    file.write_text(text + '[[measure]]\nname = "albedo"\nviews = "hemisphere"\nsize_m = [4.0, 3.0]\nheight_m = 2.0\n'
                    "directions = 24\n")
    told = json.loads(run("measure", file, "--name", "albedo", "-o", folder / "out", "--overwrite", "--json").stdout)
    albedo = told[0]["albedo"]
    noise = math.hypot(albedo["error"][0], parts[0][1])
    program.within(albedo["mean"][0] - parts[0][0], 4.5 * noise + 2e-4, "albedo", albedo, parts)


FLAT = f"""format = 1
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 215.0 }} }}
[[material]]
name = "ground"
reflectance = 0.3
oren_nayar = {{ sigma_deg = 40.0 }}
[[plane]]
material = "ground"
size_m = [50.0, 50.0]
{CAMERA}[[budget]]
name = "patch"
size_m = [10.0, 20.0]
center_m = [3.0, -4.0]
photons = 640000
"""


def check_rough(folder):
    """Rough ground keeps 1 less its directional albedo: Fujii's form (2012) integrated over the hemisphere."""
    file = folder / "rough.toml"
    file.write_text(FLAT)
    found = budgets(file)["patch"]
    s2 = math.radians(40.0) ** 2
    b = 0.45 * s2 / (s2 + 0.09) / (1 - 0.5 * s2 / (s2 + 0.33))
    a = 1 / (1 + (0.5 - 2 / (3 * math.pi)) * b)
    sun = math.radians(40.0)
    cosine = numpy.sqrt((numpy.arange(400) + 0.5) / 400)[:, None]
    azimuth = (numpy.arange(800) + 0.5) / 800 * 2 * numpy.pi
    s = math.sin(sun) * numpy.sqrt(1 - cosine**2) * numpy.cos(azimuth)
    t = numpy.where(s > 0, numpy.maximum(math.cos(sun), cosine), 1.0)
    albedo = 0.3 * (a * (1 + b * s / t)).mean()
    found.is_near(1 - albedo, "absorbed", "ground", floor=1e-4)
    found.is_near(albedo, "reflected", floor=1e-4)
    found.is_near(1, "transmitted", floor=1e-12)
    check(found.of("canopy") == (0, 0) and found.of("lost") == (0, 0), found.told)
    check(found.of("reflected")[1] < 1e-3, found.told)


def check_glossy(folder):
    """A pane over glossy ground: what comes through and back is a series (R and T are spread evenly but for the gloss),
    and all that comes is reflected, absorbed by one of the two, or past the edge."""
    pane = """[[material]]
name = "pane"
reflectance = 0.1
transmittance = 0.6
transmission = "plate"
[[plane]]
material = "pane"
position_m = [0.0, 0.0, 0.01]
size_m = [50.0, 50.0]
[[plane]]
"""
    file = folder / "glossy.toml"
    text = FLAT.replace("oren_nayar = { sigma_deg = 40.0 }", "GLOSS").replace("[[plane]]\n", pane, 1)
    text = text.replace('name = "patch"\n', 'name = "patch"\nground = ["ground"]\n')
    file.write_text(text.replace("GLOSS", ""))
    found = budgets(file)["patch"]
    down = 0.6 / (1 - 0.3 * 0.1)
    found.is_near(down, "transmitted", floor=1e-4)
    found.is_near(0.1 + 0.6 * 0.3 * down, "reflected", floor=1e-4)
    found.is_near(0.3 * (1 + 0.3 * down), "absorbed", "pane", floor=1e-4)
    file.write_text(text.replace("GLOSS", "gloss = { roughness = 0.2, f0 = 0.3 }"))
    glossy = budgets(file)["patch"]
    parts = [("reflected", ""), ("absorbed", "pane"), ("absorbed", "ground"), ("lost", ""), ("unfinished", "")]
    whole, error = (f(glossy.of(*part)[k] for part in parts) for k, f in ((0, sum), (1, lambda e: sum(e))))
    program.within(whole - 1, 4.5 * error + 1e-4, "all light")
    check(error < 4e-3, error)
    check(glossy.of("reflected")[0] > found.of("reflected")[0] + 0.08, glossy.told)
    check(glossy.of("absorbed", "ground")[0] < 0.7 * found.of("absorbed", "ground")[0], glossy.told)


def check_edges(folder):
    """Three quarters of an area lie beside the scene: that light goes down past all levels and is lost, with a word."""
    file = folder / "edges.toml"
    text = FLAT.replace("oren_nayar = { sigma_deg = 40.0 }", "").replace('"ground"', '"ground, dry"')
    text = text.replace("size_m = [10.0, 20.0]\ncenter_m = [3.0, -4.0]", "size_m = [100.0, 100.0]\nlevels_m = [1.0]")
    file.write_text(text.replace("photons = 640000", "photons = 160000"))
    done = run("measure", file, "-o", folder / "out", "--overwrite", "--json")
    check("% of the light of budget 'patch' goes past the scene's edge" in done.stderr, done.stderr)
    found = Budget(json.loads(done.stdout)[0])
    found.is_near(0.75, "lost", floor=1e-3)
    found.is_near(1, "down", "1", floor=1e-12)
    found.is_near(0.25 * 0.3, "up", "1", floor=1e-3)
    check('absorbed,"ground, dry",500nm,' in (folder / "out/patch/budget.csv").read_text())
    (folder / "out/patch/facets_of_before.ply").write_text("of an earlier run")
    run("measure", file, "-o", folder / "out", "--overwrite", "-q")
    check(not (folder / "out/patch/facets_of_before.ply").exists(), "an earlier run's facets")


def check_far_mesh(folder):
    """Ground far from its mesh's own origin, put back by its placement: on its level all light comes down."""
    file = folder / "far.toml"
    corners = "".join(f"v {1000 + x} {1000 + y} 1000\n" for x, y in ((-50, -50), (50, -50), (50, 50), (-50, 50)))
    (folder / "far.obj").write_text(corners + "f 1 2 3\nf 1 3 4\n")
    mesh = """[[mesh]]
name = "far"
file = "far.obj"
material = "ground"
[[instance]]
mesh = "far"
position_m = [-1000.0, -1000.0, -1000.0]
[[instrument]]"""
    text = FLAT.replace("oren_nayar = { sigma_deg = 40.0 }", "").replace("[[instrument]]", mesh)
    text = text.replace('[[plane]]\nmaterial = "ground"\nsize_m = [50.0, 50.0]\n', "")
    file.write_text(text.replace("photons = 640000", 'photons = 16000\nlevels_m = [0.0]\nground = ["ground"]'))
    found = budgets(file)["patch"]
    for wanted, quantity, of in ((1, "transmitted", ""), (1, "down", "0"), (0.3, "up", "0")):
        found.is_near(wanted, quantity, of, floor=1e-12)


def check_par(folder):
    """Photons of 0.4 to 0.7 um, by a step from white to black at 0.55 um: the sun as a black body of 5772 K sends
    0.454 of them below it, the extraterrestrial sun is within 0.02 of that."""
    file = folder / "par.toml"
    (folder / "step.csv").write_text("wavelength_nm,reflectance\n300,1\n549.9,1\n550.1,0\n900,0\n")
    text = FLAT.replace("reflectance = 0.3\noren_nayar = { sigma_deg = 40.0 }", 'file = "step.csv"')
    file.write_text(text.replace("photons = 640000", "photons = 1600\npar = true"))
    found = budgets(file)["patch"]
    check(found.told["band"] == ["500nm", "800nm", "par"], found.told["band"])
    check(found.told["light_w_m2_um"][2] is None, found.told)
    um = numpy.linspace(0.4, 0.7, 3001)
    photons = um**-4 / numpy.expm1(14387.77 / (um * 5772))
    below = photons[um < 0.55].sum() / photons.sum()
    print(f"photons below 0.55 um: {found.of('reflected', band=2)[0]:.4f}, of a black body {below:.4f}")
    check(abs(found.of("reflected", band=2)[0] - below) < 0.02, found.told, below)
    check(abs(found.of("absorbed", "ground", 2)[0] + found.of("reflected", band=2)[0] - 1) < 1e-9, found.told)


def read_ply(path):
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    count = int([row for row in head.split(b"\n") if row.startswith(b"element vertex")][0].split()[2])
    names = [row.split()[2].decode() for row in head.split(b"\n") if row.startswith(b"property float")]
    points = numpy.frombuffer(body, "<f4", count * len(names)).reshape(count, len(names))
    faces = numpy.frombuffer(body[points.nbytes :], [("n", "u1"), ("v", "<i4", 3)])
    return names, points, faces


def check_facets(folder):
    """Facets of leaves: their areas times what they absorb sum to the leaves' share; of a mesh placed twice, once
    larger and turned, too."""
    file = folder / "facets.toml"
    (folder / "leaf.csv").write_text(LEAF)
    (folder / "tilted.obj").write_text(
        "v -0.5 -0.5 0\nv 0.5 -0.5 0.4\nv 0.5 0.5 0.4\nv -0.5 0.5 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 3 4 5\n"
    )
    # A plane of the mesh's name is another thing.
    more = """[[plane]]
name = "tilted"
material = "soil"
position_m = [0.0, 0.0, -1.0]
size_m = [1.0, 1.0]
[[mesh]]
name = "tilted"
file = "tilted.obj"
material = "leaf"
[[instance]]
mesh = "tilted"
position_m = [0.5, 0.2, 0.5]
[[instance]]
mesh = "tilted"
position_m = [-1.0, 0.0, 0.6]
scale = 1.3
yaw_deg = 70.0
[[instrument]]"""
    upper = PILE[PILE.index('[[plane]]\nmaterial = "leaf"') : PILE.index('[[plane]]\nmaterial = "soil"')]
    text = PILE.replace(upper, "").replace("[[instrument]]", more).replace("SEED", "")
    file.write_text(text.replace("PHOTONS", 'facets = ["tilted"]'))
    found = budgets(file)
    for name in ("sun", "even"):
        names, points, faces = read_ply(folder / f"out/{name}/facets_tilted.ply")
        check(names == "x y z absorbed_500nm error_500nm absorbed_800nm error_800nm".split(), names)
        check((faces["n"] == 3).all() and (faces["v"].ravel() == numpy.arange(9)).all(), faces)
        corners = points[:, :3].reshape(3, 3, 3)
        areas = numpy.linalg.norm(numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        for band, column in ((0, 3), (1, 5)):
            total = (areas * points[::3, column]).sum() * (1 + 1.3**2) / 12
            mean, error = found[name].of("absorbed", "leaf", band)
            check(abs(total / mean - 1) < 1e-5, name, band, total, mean)
            check((points[:, column] > 0).all() and (points[:, column + 1] < 0.1 * points[:, column]).all(), points)


def canopy(folder, budget, *arguments):
    patience.run([sys.executable, RAMI, folder, *map(str, arguments)], check=True, capture_output=True)
    file = folder / "canopy.toml"
    file.write_text(file.read_text().split("[[measure]]\n")[0] + budget)
    return file


def turbid(lai, leaf, soil, way, rng):
    """Shares reflected, absorbed by leaves, on the ground and coming down half way, of photons that fall in these ways
    onto a layer of tiny leaves of all orientations; in each step a photon leaves what the leaf absorbs."""
    count = len(way)
    depth, weight, sums = numpy.zeros(count), numpy.ones(count), numpy.zeros(4)
    while len(weight):
        before = depth
        # Leaf area above: half of it in the way of any direction, over its cosine.
        depth = depth - numpy.log(rng.random(len(weight))) * 2 * -way[:, 2]
        sums[3] += weight[(before < lai / 2) & (depth >= lai / 2)].sum()
        out, ground = depth < 0, depth >= lai
        sums[0] += weight[out].sum()
        sums[2] += weight[ground].sum()
        sums[1] += weight[~out & ~ground].sum() * (1 - sum(leaf))
        keep = ~out
        depth, weight, way, ground = numpy.minimum(depth[keep], lai), weight[keep], way[keep], ground[keep]
        normal = leaf_normals(way, rng)
        normal[ground] = (0, 0, 1)
        normal *= -numpy.sign((normal * way).sum(1))[:, None]
        back, through = numpy.where(ground, soil, leaf[0]), numpy.where(ground, 0.0, leaf[1])
        turned = rng.random(len(weight)) * (back + through) < back
        weight = weight * (back + through)
        way = turned_by_cosine(numpy.where(turned[:, None], normal, -normal), rng)
        alive = rng.random(len(weight)) < 0.9  # the others end, these stand for them
        depth, weight, way = depth[alive], weight[alive] / 0.9, way[alive]
    return sums / count


def check_turbid(folder):
    """A layer of leaves of a hundredth of its depth against one of none, under sun and even sky, within 0.005 (a cell
    of 13 000 leaves' areas has chance gaps) and the noise of both; light that met nothing by Beer's law."""
    budget = "".join(
        f'[[budget]]\nname = "{name}"\nlight = "{light}"\nground = ["soil"]\nlevels_m = [1.0]\nphotons = 800000\n'
        for name, light in (("direct", "sun"), ("even", "isotropic"))
    )
    leaves = ("--lai", 2, "--radius", 0.02, "--height", 2.0, "--cell", 4.0, "--sun-zenith", 30.0)
    found = budgets(canopy(folder / "layer", budget, *leaves))
    rng = numpy.random.default_rng(seed(5))
    sun = math.radians(30.0)
    cosine = (numpy.arange(20000) + 0.5) / 20000
    beer = {"direct": math.exp(-1 / math.cos(sun)), "even": (2 * cosine * numpy.exp(-1 / cosine)).mean()}
    for name, of in found.items():
        for band, (leaf, soil) in enumerate((((0.0546, 0.0149), 0.127), ((0.4957, 0.4409), 0.159))):
            ways = numpy.tile([math.sin(sun), 0, -math.cos(sun)], (400000, 1))
            if name == "even":
                ways = turned_by_cosine(numpy.tile([0.0, 0, -1], (400000, 1)), rng)
            wanted = turbid(2.0, leaf, soil, ways, rng)
            asked = (("reflected", ""), ("canopy", ""), ("transmitted", ""), ("down", "1"))
            ours = [of.of(*q, band) for q in asked]
            for (mean, error), other in zip(ours, wanted):
                check(error < 0.002, name, band, error)
                program.within(mean - other, 4.5 * error + 0.005, "turbid", name, band)
            print(f"{name}, band {band}: " + ", ".join(f"{m:.4f} turbid {w:.4f}" for (m, _), w in zip(ours, wanted)))
            whole = [of.of(q, n, band)[0] for q, n in
                     (("reflected", ""), ("absorbed", "leaf"), ("absorbed", "soil"), ("lost", ""))]
            check(abs(sum(whole) - 1) < 0.002 and of.of("unfinished", band=band) == (0, 0), whole)
        mean, error = of.of("transmitted_uncollided")
        program.within(mean - beer[name], 4.5 * error + 0.005, "Beer", name)


def check_one_thread(folder):
    """The same bits on one processor."""
    budget = '[[budget]]\nname = "b"\nphotons = 50000\nfacets = ["leaves"]\n'
    file = canopy(folder / "bits", budget, "--lai", 1, "--radius", 0.1, "--height", 2.0, "--cell", 4.0)
    files = {}
    for name, cores in (("all", os.sched_getaffinity(0)), ("one", {min(os.sched_getaffinity(0))})):
        before = os.sched_getaffinity(0)
        os.sched_setaffinity(0, cores)
        budgets(file, folder=name)
        os.sched_setaffinity(0, before)
        files[name] = [(file.parent / name / "b" / one).read_bytes() for one in ("budget.csv", "facets_leaves.ply")]
    check(files["all"] == files["one"])


def check_refusals(folder):
    file = folder / "bad.toml"

    def says(*parts, old="", new=""):
        check(old in FLAT, old)
        file.write_text(FLAT.replace(old, new, 1))
        refused("measure", file, "-o", folder / "bad", status=2, says=parts)
        check(not (folder / "bad").exists())

    patch = 'name = "patch"\n'
    says("a budget needs an area", old="size_m = [10.0, 20.0]\n")
    cell = "format = 1\nscene = { periodic = { x_m = 50.0, y_m = 50.0 } }\n"
    for key, other in (("size_m", "center_m = [3.0, -4.0]\n"), ("center_m", "size_m = [10.0, 20.0]\n")):
        file.write_text(FLAT.replace("format = 1\n", cell).replace(other, ""))
        refused("measure", file, "-o", folder / "bad", status=2, says=("the area is the cell", f"remove {key}"))
    says("no material of that name", "'soil'", "the file has: ground", old=patch, new=patch + 'ground = ["soil"]\n')
    says("no mesh of that name", "the file has none", old=patch, new=patch + 'facets = ["tree"]\n')
    says("sun above the horizon", old="zenith_deg = 40.0", new="zenith_deg = 95.0")
    says("'patch' is of sunlight", old="first_nm = 500.0", new="first_nm = 9000.0")
    says("names another measure or budget", old="[[budget]]",
         new='[[measure]]\nname = "patch"\nsize_m = [1.0, 1.0]\n[[budget]]')
    says("'levels_m' has one twice", "1.5", old=patch, new=patch + "levels_m = [1.5, 3.0, 1.5]\n")
    # Of photosynthesis a budget needs curves where no band of its instrument looks.
    (folder / "short.csv").write_text("wavelength_nm,reflectance\n500,0.1\n3000,0.2\n")
    file.write_text(FLAT.replace("reflectance = 0.3", 'file = "short.csv"').replace(patch, patch + "par = true\n"))
    refused("measure", file, "-o", folder / "bad", status=2, says=("covers 500 to 3000 nm", "'par' 400 to 700 nm"))
    check(not (folder / "bad").exists())
    tree = '[[mesh]]\nname = "a/b"\nfile = "tree.obj"\nmaterial = "ground"\n[[budget]]'
    (folder / "tree.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    says("the name of a file", "'a/b'", old="[[budget]]", new=tree + '\nfacets = ["a/b"]')
    night = FLAT.replace("zenith_deg = 40.0", "zenith_deg = 95.0")
    file.write_text(night.replace(patch, patch + 'light = "isotropic"\n'))
    budgets(file, "--name", "patch")["patch"].is_near(1, "transmitted", floor=1e-12)  # an even sky needs no sun
    file.write_text(FLAT)
    refused("measure", file, "--name", "up", "-o", folder / "bad", status=2, says=("there are: patch",))


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_pile(folder)
        check_rough(folder)
        check_glossy(folder)
        check_edges(folder)
        check_far_mesh(folder)
        check_par(folder)
        check_facets(folder)
        check_refusals(folder)
        check_one_thread(folder)
        if "--full" in sys.argv:
            check_closing(folder)
            check_turbid(folder)
    print(f"light_budget: {program.checks} checks")


main()
