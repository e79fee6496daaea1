"""S26 `raycube explain`: what a pixel is the sum of. Oracles: the cube that render writes, to the bit; light is linear
in a reflectance, and nothing else moves with it; no sun in a shadow; light between surfaces is positive in every order,
and to fewer surfaces what a file of fewer shows."""

import json
import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

ROUNDING = 1e-5  # sums of some hundred floats, rows of the skeleton among them that cancel, against the same in double
SKELETON = 0.1 * 0.02  # what light between its wavelengths may err, of what is seen: a tenth of the file's tolerance


def explain(file, pixel):
    told = json.loads(run("explain", file, "--pixel", f"{pixel[1]},{pixel[0]}", "--json").stdout)
    for light in told["light"]:
        light["radiance"] = numpy.array(light["radiance"])
    check(numpy.allclose(sum(light["radiance"] for light in told["light"]), told["sum"], rtol=1e-12, atol=0))
    check(numpy.allclose(told["sum"], told["rendered"], rtol=ROUNDING, atol=0), told["worst_difference"])
    return told


def of(told, kind, material=None):
    """A kind's light, of one material or of all."""
    found = [x["radiance"] for x in told["light"] if x["kind"] == kind and material in (None, x.get("material"))]
    return sum(found) if found else numpy.zeros(len(told["sum"]))


def check_cube(told, cube):
    check(numpy.array_equal(numpy.array(told["rendered"], "f4"), cube[told["line"], told["sample"]]), told["line"])


def check_once(file, folder):
    """A cube of light scattered once and its pixels; returns one that lies in the shade."""
    run("render", file, "-o", folder)
    (_, cube), (header, layers) = envi(folder / "camera", "radiance"), envi(folder / "camera", "truth")
    sun = next(layers[..., i] for i, name in enumerate(header["band names"]) if name.startswith("sun_fraction"))
    lit, dark = numpy.argwhere(sun == 1), numpy.argwhere(sun == 0)
    check(len(lit) > 0 and len(dark) > 0)
    told = explain(file, lit[len(lit) // 2])
    check_cube(told, cube)
    check({x["kind"] for x in told["light"]} <= {"path", "ground_around", "sun", "sky"}, told["light"])
    check(numpy.all(of(told, "sun") > of(told, "sky")))
    shaded = explain(file, dark[len(dark) // 2])
    check_cube(shaded, cube)
    check(not numpy.any(of(shaded, "sun")) and numpy.all(of(shaded, "sky") > 0))
    check_cube(explain(file, (63, 63)), cube)
    said = run("explain", file, "--pixel", f"{told['sample']},{told['line']}", "--band", 10).stdout
    check("band 10 (620.0 nm)" in said and "path: air before the scene" in said and said.count("%") >= 3, said)
    check(f"{told['rendered'][9]:.6g}" in said, said)
    return dark[len(dark) // 2]


def check_linear(folder, text):
    """Half a reflectance is half its light, in a pixel that holds another material too; other light stays as it is, but
    for what a plan makes of another mean scene: the sky's components and nodes."""
    text = text.replace('model = "clear_sky"', 'model = "clear_sky", adjacency = "off"')
    text = text.replace("position_m = [-4.0, 3.0, 0.02]", "position_m = [-3.75, 3.0, 0.02]")  # half a pixel aside
    (folder / "whole.toml").write_text(text)
    (folder / "half.toml").write_text(text.replace("reflectance = 0.50", "reflectance = 0.25"))
    run("render", folder / "whole.toml", "-o", folder / "whole")
    header, layers = envi(folder / "whole" / "camera", "truth")
    share = next(layers[..., i] for i, name in enumerate(header["band names"]) if "light grey" in name)
    panel = numpy.argwhere((share > 0.2) & (share < 0.8))[0]
    whole, half = (explain(folder / name, panel) for name in ("whole.toml", "half.toml"))
    for kind, rtol in (("sun", 1e-5), ("sky", 2e-3)):
        grey = of(whole, kind, "light grey")
        check(numpy.all(grey > 0) and numpy.allclose(of(half, kind, "light grey"), 0.5 * grey, rtol=rtol), kind)
        check(numpy.allclose(of(half, kind) + 0.5 * grey, of(whole, kind), rtol=rtol), kind)
    check(numpy.allclose(of(half, "path"), of(whole, "path"), rtol=2e-3))
    check(not numpy.any(of(whole, "ground_around")))


def check_orders(folder, text, pixel):
    """Light between surfaces, order by order, of a hundred paths."""
    text = text.replace("sky_directions = 100", "sky_directions = 200")
    told = {}
    for levels in (1, 3):
        file = folder / f"bounces{levels}.toml"
        file.write_text(text.replace("format = 1", f"format = 1\nbounces = {levels}"))
        told[levels] = explain(file, pixel)
    lights = [x for x in told[3]["light"] if x["kind"] == "between_surfaces"]
    orders = [x["radiance"] for x in lights]
    check([x["number"] for x in lights] == [1, 2, 3])
    seen = numpy.array(told[1]["sum"])
    check(all(order.sum() > 0 and numpy.all(order > -SKELETON * seen) for order in orders), orders)
    check(orders[2].sum() < orders[0].sum() + orders[1].sum(), [order.sum() for order in orders])
    # the same paths by two skeletons: rms over the bands
    apart = (orders[0] - of(told[1], "between_surfaces")) / seen
    check(numpy.sqrt(numpy.mean(apart**2)) < SKELETON, apart)
    for kind in ("sun", "sky", "path", "ground_around"):
        check(numpy.allclose(of(told[1], kind), of(told[3], kind), rtol=1e-5, atol=1e-12), kind)


def check_default(file, pixel):
    """Of a file that says nothing of bounces eight orders are told apart, and what is left is one more."""
    lights = [x for x in explain(file, pixel)["light"] if x["kind"] == "between_surfaces"]
    check([x["number"] for x in lights] == list(range(1, 10)), [x["number"] for x in lights])
    check([x.get("and_more", False) for x in lights] == [False] * 8 + [True])
    check(lights[0]["radiance"].sum() > lights[-1]["radiance"].sum() >= 0)


def check_replicates(folder, text):
    """A pixel that is the mean of several renders."""
    file = folder / "asked.toml"
    for line in ("samples = { lattice = 34 }", "sky_directions = 100"):
        text = text.replace(line, "")
    file.write_text(text)
    run("render", file, "-o", folder / "asked")
    check('"replicates"' in (folder / "asked" / "camera" / "run.json").read_text(), "not a mean of several")
    check_cube(explain(file, (20, 30)), envi(folder / "asked" / "camera", "radiance")[1])


def check_refusals(file):
    refused("explain", file, "--pixel", "64,0", status=2, says=["samples to 63", "64,0"])
    refused("explain", file, "--pixel", "here", status=2, says=["SAMPLE,LINE", "here"])
    refused("explain", file, "--pixel", "1,1", "--band", 99, status=2, says=["bands 1 to 98", "99"])
    refused("explain", file, "--pixel", "1,1", "--instrument", "wasp", status=2, says=["wasp", "camera"])


def main(folder):
    run("new", folder / "first")
    file = folder / "first" / "first.toml"
    once = file.with_name("once.toml")
    once.write_text(file.read_text().replace("format = 1", "format = 1\nbounces = 0"))
    dark = check_once(once, folder / "once")
    check_linear(file.parent, once.read_text())
    check_default(file, dark)
    check_orders(file.parent, file.read_text(), dark)
    check_replicates(file.parent, file.read_text())
    check_refusals(file)
    print(f"explain: {program.checks} checks")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        main(pathlib.Path(name))
