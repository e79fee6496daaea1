"""S21 gloss as users meet it: a wet court before a lit wall. Oracles: `raycube check`, whose reference mirrors by code
and draws of its own (sky ray by ray, light between surfaces by paths); a pixel's budget; without gloss the same bits as
without the key."""

import json
import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused

SCENE = """format = 1
tolerance = 0.05
bounces = 4
sky_directions = 64
[[material]]
name = "wet court"
reflectance = 0.08
GLOSS
[[material]]
name = "white wall"
reflectance = 0.8
[[material]]
name = "ground"
reflectance = 0.2
[[plane]]
material = "ground"
size_m = [200.0, 200.0]
[[plane]]
material = "wet court"
position_m = [0.0, 0.0, 0.05]
size_m = [30.0, 30.0]
[[box]]
material = "white wall"
position_m = [0.0, 8.0, 0.0]
size_m = [30.0, 1.0, 12.0]
[atmosphere]
model = "clear_sky"
[time]
sun = { zenith_deg = 45.0, azimuth_deg = 180.0, day_of_year = 172 }
[[instrument]]
name = "camera"
kind = "framing"
position_m = [0.0, -60.0, 45.0]
pitch_deg = 50.0
ifov_mrad = 10.0
pixels = 32
lines = 32
samples = { grid = [4, 4] }
bands = { first_nm = 450.0, step_nm = 200.0, count = 3, fwhm_nm = 30.0 }
"""
GLOSS = "gloss = { roughness = 0.15, f0 = 0.3 }"


def write(folder, name, gloss=GLOSS, text=SCENE):
    path = folder / name
    path.write_text(text.replace("GLOSS", gloss))
    return path


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        wet, dull = write(folder, "wet.toml"), write(folder, "dull.toml", "")
        report = json.loads(run("check", wet, "--rays", 5000, "--pixels", 200, "--json", "-o", folder / "check").stdout)
        of = report["camera"]
        check(of["passed"] is True, of)
        for file in (wet, dull):
            run("render", file, "-o", folder / file.stem)
        shown, plain = (envi(folder / f / "camera", "radiance")[1] for f in ("wet", "dull"))
        header, layers = envi(folder / "wet" / "camera", "truth")
        court = next(layers[..., i] for i, n in enumerate(header["band names"]) if "wet court" in n)
        line, sample = numpy.argwhere(court == 1)[court[court == 1].size // 2]
        told = json.loads(run("explain", wet, "--pixel", f"{sample},{line}", "--json").stdout)
        check(numpy.array_equal(numpy.array(told["rendered"], "f4"), shown[line, sample]))
        mirrored = [x for x in told["light"] if x.get("gloss")]
        check("sky" in {x["kind"] for x in mirrored} and {x["material"] for x in mirrored} == {"wet court"}, mirrored)
        said = run("explain", wet, "--pixel", f"{sample},{line}").stdout
        check("by the gloss of wet court" in said, said)
        # Gloss adds; on open ground far from court and wall nothing else moves but noise of light between surfaces.
        check(numpy.all(shown[court == 1].mean(0) > 1.2 * plain[court == 1].mean(0)))
        narrow = write(folder, "narrow.toml", "gloss = { roughness = 0.05, f0 = 0.3 }")
        says = ["'wet court'", "roughness 0.05", "as wide as one of 0.1"]
        refused("render", narrow, "-o", folder / "no", status=2, says=says)
        check(not (folder / "no").exists())
        # In thermal light what a gloss mirrors it does not emit: under no air and no sky the court sends less by that.
        thermal = SCENE.replace("first_nm = 450.0, step_nm = 200.0", "first_nm = 9000.0, step_nm = 500.0")
        thermal = thermal.replace('model = "clear_sky"', 'model = "none"').replace("bounces = 4", "bounces = 0")
        thermal += "[thermal]\ndefault_temperature_K = 300.0\n"
        warm = {}
        for name, gloss in (("dull", ""), ("glossy", GLOSS)):
            run("render", write(folder, f"warm_{name}.toml", gloss, thermal), "-o", folder / f"warm_{name}")
            warm[name] = envi(folder / f"warm_{name}" / "camera", "radiance")[1]
        # A shape alone, which reaches far from Lambert's: the planner's look at the open sky takes it for that.
        rpv = "rpv = { k = 0.7, theta = -0.2, rho_c = 0.4 }"
        rough = write(folder, "warm_rpv.toml", rpv, thermal.replace("sky_directions = 64\n", ""))
        run("render", rough, "-o", folder / "warm_rpv")
        done = run("check", rough, "--rays", 2000, "--pixels", 64, "--json", "-o", folder / "rpv_check")
        told = json.loads(done.stdout)
        check(told["camera"]["passed"] is True, told)
        bright = write(folder, "bright.toml", "gloss = { roughness = 0.15, f0 = 0.1 }",
                       thermal.replace("reflectance = 0.08", "reflectance = 0.89"))
        said = run("render", bright, "-o", folder / "bright").stderr
        check("sends back" in said and "its emission is negative" in said, said)
        share = warm["glossy"][court == 1] / warm["dull"][court == 1]
        check(numpy.all(share.mean(0) < 0.99) and numpy.all(share.mean(0) > 0.5), share.mean(0))
    print(f"gloss: {program.checks} checks")


main()
