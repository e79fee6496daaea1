"""S45 S52: the unmixing targets of the published experiment, rendered and taken apart, and reflectance by panels
through clear and hazy air.

Targets as published: 16 x 16 ft of 1 ft cells, three of yellow felt to one of yellow cotton in each 2 x 2; a
checkerboard of 24 x 24 ft, blue felt and cotton in turns; pure ones of 12 x 12 ft, so that some pixels of 1 m lie
wholly on them. Samples are jittered: a grid of 32 x 32 meets each second 2 ft at one phase (0.6096 m are 19.507 of its
steps) and finds cotton 5 % too often. Allowed (issue): 1 point of share on radiance, 3 points on reflectance;
reflectance of what is no panel within 0.005 in all windows.
usage: analyze_targets_test.py RAYCUBE [--full]. Without --full the hazy air alone, which is the harder one,
and of that each 20 nm, a tenth of its wavelengths, whose table takes half a minute else.
"""

import pathlib
import sys
import tempfile

import numpy as np

from analysis_kit import Analysis, layers, values
from driver import FULL, Program, envi

program = Program(sys.argv[1])
analyze = Analysis(program).run
FOOT = 0.3048
AIR = "" if FULL else ", spectral_step_nm = 20.0"
NM = np.arange(350, 2501, 10.0)
#: Where the air lets too little through to tell anything of the ground.
WINDOWS = [(420, 900), (980, 1090), (1170, 1320), (1530, 1760), (2060, 2350)]
CURVES = {
    "yellow_felt": 0.05 + 0.6 / (1 + np.exp(-(NM - 520) / 12)),
    "yellow_cotton": 0.20 + 0.55 / (1 + np.exp(-(NM - 500) / 25)),
    "blue_felt": 0.06 + 0.25 * np.exp(-(((NM - 460) / 45) ** 2)) + 0.5 / (1 + np.exp(-(NM - 760) / 25)),
    "blue_cotton": 0.12 + 0.35 * np.exp(-(((NM - 450) / 60) ** 2)) + 0.4 / (1 + np.exp(-(NM - 720) / 15)),
    "asphalt": 0.08 + 0.04 * NM / 2500,
    "grass": 0.04 + 0.4 / (1 + np.exp(-(NM - 715) / 12)) * (1 - 0.4 * np.exp(-(((NM - 1450) / 120) ** 2))),
}


def plane(material, x, y, wide, high=None):
    size = f"[{wide:.4f}, {high or wide:.4f}]"
    return f'[[plane]]\nmaterial = "{material}"\nposition_m = [{x:.4f}, {y:.4f}, 0.01]\nsize_m = {size}\n'


def cells(count, x0, y0, material_of):
    """count x count cells of a foot, the lower left corner at x0, y0."""
    return "".join(
        plane(material_of(i, j), x0 + (i + 0.5) * FOOT, y0 + (j + 0.5) * FOOT, FOOT)
        for i in range(count)
        for j in range(count)
    )


def scene(folder, aod):
    for name, curve in CURVES.items():
        rows = "".join(f"{a},{b:.6f}\n" for a, b in zip(NM, curve))
        (folder / f"{name}.csv").write_text("wavelength_nm,reflectance\n" + rows)
    materials = ", ".join(f'{{ name = "{n}", file = "{n}.csv" }}' for n in CURVES)
    mixed = cells(16, -12, 2, lambda i, j: "yellow_cotton" if i % 2 and j % 2 else "yellow_felt")
    mixed += cells(24, 2, 0, lambda i, j: "blue_cotton" if (i + j) % 2 else "blue_felt")
    pure = "".join(plane(n, -12 + 8 * k, -6, 12 * FOOT) for k, n in enumerate(list(CURVES)[:4]))
    panels = plane("dark", -10, 14, 6) + plane("bright", -2, 14, 6) + plane("grass", 8, 14, 6)
    (folder / "scene.toml").write_text(
        "format = 1\ntolerance = 0.01\nsky_directions = 24\n"
        f'material = [{materials}, {{ name = "dark", reflectance = 0.1 }}, {{ name = "bright", reflectance = 0.8 }}]\n'
        f'atmosphere = {{ model = "layered", profile = "midlatitude_summer", aod_550 = {aod}{AIR} }}\n'
        "time = { sun = { zenith_deg = 35.0, azimuth_deg = 150.0, day_of_year = 264 } }\n"
        '[[plane]]\nmaterial = "asphalt"\nsize_m = [400.0, 400.0]\n' + mixed + pure + panels + "[[instrument]]\n"
        'name = "camera"\nkind = "framing"\npixels = 36\nlines = 36\naltitude_agl_m = 610.0\ngsd_m = 1.0\n'
        "samples = { jittered = [32, 32] }\n"
        "bands = { first_nm = 420.0, step_nm = 12.0, count = 160, fwhm_nm = 10.0 }\n"
    )
    program.run("render", folder / "scene.toml", "-o", folder / "out", "--overwrite", "-q", "-q")
    return folder / "out/camera/radiance.img", folder / "out/camera/truth.img"


def around(at_ft, x0, y0):
    """Pixels that a square of so many feet touches, as X0:X1,Y0:Y1: pixel x spans x - 18 to x - 17 m."""
    side = at_ft * FOOT
    left, right = int(np.floor(x0 + 18)), int(np.ceil(x0 + side + 18)) - 1
    top, bottom = int(np.floor(18 - y0 - side)), int(np.ceil(18 - y0)) - 1
    return f"{left}:{right},{top}:{bottom}"


def in_windows(nm):
    return np.any([(nm >= low) & (nm <= high) for low, high in WINDOWS], axis=0)


def hold(folder, aod):
    radiance, truth = scene(folder, aod)
    panels = ["--panel", f"d={truth}@abundance_dark>=0.9999", "--panel", f"b={truth}@abundance_bright>=0.9999"]
    numbers = analyze(folder, "reflectance", radiance, *panels, "--reflectance", "d=0.1", "--reflectance", "b=0.8")
    reflectance = folder / "reflectance/reflectance.img"
    nm = 1e3 * np.asarray(numbers["wavelength_um"])
    good, worst = in_windows(nm), 0
    program.check(good.sum() > 100, good.sum())
    names = ["grass", "asphalt", "yellow_felt", "blue_cotton"]
    regions = [x for n in names for x in ("--region", f"{n}={truth}@abundance_{n}>=0.9999")]
    for one in analyze(folder, "statistics", reflectance, *regions)["regions"]:
        fine = np.linspace(-2, 2, 81) * 10.0
        weight = np.exp(-4 * np.log(2) * np.linspace(-2, 2, 81) ** 2)
        known = np.interp(nm[:, None] + fine, NM, CURVES[one["region"]]) @ weight / weight.sum()
        off = np.abs(values(one["mean"]) - known)[good].max()
        worst = max(worst, off)
        program.check(off <= 0.005, "reflectance", aod, one["region"], off)

    yellow, blue = around(16, -12, 2), around(24, 2, 0)
    shares = {}
    for kind, cube, points in (("radiance", radiance, 0.01), ("reflectance", reflectance, 0.03)):
        for colour, region, expected in (("yellow", yellow, (0.75, 0.25)), ("blue", blue, (0.5, 0.5))):
            # The target with its edge: its pixels do not hold whole cells, all of them together do.
            names = [f"{colour}_felt", f"{colour}_cotton", "asphalt"]
            if kind == "radiance":  # from the pure targets of the image
                members = [f"{n}={truth}@abundance_{n}>=0.9999" for n in names]
            else:  # from the laboratory
                members = [f"{n}={folder / n}.csv" for n in names]
            bands = "420:900" if kind == "reflectance" else "420:2340"
            endmembers = [x for m in members for x in ("--endmember", m)]
            found = analyze(folder, "unmix", cube, "--wavelengths", bands, *endmembers, "--region", f"t={region}")
            felt, cotton, _, _ = found["regions"][0]["mean"]
            got = np.array([felt, cotton]) / (felt + cotton)
            shares[kind, colour] = got
            program.check(np.abs(got - expected).max() <= points, kind, colour, got)
            # Pixel by pixel against the truth of the same samples.
            header, known = envi(folder / "out/camera", "truth")
            at = [next(i for i, n in enumerate(header["band names"]) if n.startswith(f"abundance_{m} ")) for m in names]
            x0, x1, y0, y1 = (int(v) for part in region.split(",") for v in part.split(":"))
            apart = layers(folder, "unmix")[:3, y0 : y1 + 1, x0 : x1 + 1]
            apart = apart - np.moveaxis(known[y0 : y1 + 1, x0 : x1 + 1, at], 2, 0)
            program.check(np.abs(apart).max() <= 3 * points, kind, colour, np.abs(apart).max())
    return worst, shares


with tempfile.TemporaryDirectory() as name:
    for depth in (0.05, 0.4) if FULL else (0.4,):
        inner = pathlib.Path(name) / str(depth)
        inner.mkdir()
        off, found = hold(inner, depth)
        text = "; ".join(f"{k} {c} {100 * v[0]:.1f}/{100 * v[1]:.1f}" for (k, c), v in found.items())
        print(f"analyze targets: aod {depth}: reflectance within {off:.4f} (0.005); felt/cotton {text}")
    print(f"analyze targets: {program.checks} checks")
