"""S45 S54 S55: `raycube analyze roc` against scikit-learn and counts by hand; regions of all kinds;
maps as GDAL reads them; and a whole way from a rendered scene to its curve."""

import json
import pathlib
import sys
import tempfile

import numpy as np
import sklearn.metrics

import patience
from analysis_kit import Analysis, layers, values, write_cube
from driver import Program, seed

program = Program(sys.argv[1])
analysis = Analysis(program)
analyze, close = analysis.run, analysis.close
RNG = np.random.default_rng(seed(55))


def field():
    """Scores and shares of 7 targets, each of 1 to 4 pixels."""
    share = np.zeros((60, 70))
    for y, x, parts in (
        (5, 5, [(0, 0, 0.8)]),
        (5, 20, [(0, 0, 0.3), (0, 1, 0.5)]),
        (20, 10, [(0, 0, 0.2), (1, 1, 0.1)]),
        (30, 30, [(0, 0, 0.05), (0, 1, 0.1), (1, 0, 0.2), (1, 1, 0.4)]),
        (40, 12, [(0, 0, 0.15)]),
        (44, 40, [(0, 0, 0.6), (1, 0, 0.02)]),
        (8, 48, [(0, 0, 0.33)]),
    ):
        for dy, dx, part in parts:
            share[y + dy, x + dx] = part
    score = np.round(RNG.normal(0, 1, share.shape) + 5 * share, 2)  # rounded: some are alike
    return score, share


def neighbourhood(mask, buffer):
    out = np.zeros_like(mask)
    for y, x in np.argwhere(mask):
        out[max(0, y - buffer) : y + buffer + 1, max(0, x - buffer) : x + buffer + 1] = True
    return out


def curves(folder):
    score, share = field()
    cube = write_cube(folder / "score.img", np.stack([-score, score], 2), "bsq", "f8", band_names="{low, high}")
    truth = write_cube(folder / "truth.img", share[..., None], dtype="f8")
    target = ["--layer", "high", "--truth", truth]
    for rule, options in (("exact", []), ("outside_area", ["--false-alarms", "outside_area"])):
        if rule == "exact":
            negative = ~neighbourhood(share > 0, 1)
        else:
            y, x = np.nonzero(share)
            negative = np.ones_like(share, bool)
            negative[y.min() - 1 : y.max() + 2, x.min() - 1 : x.max() + 2] = False
        for least in (0, 0.1, 0.3):
            positive = (share > 0) & (share >= least)
            numbers = analyze(folder, "roc", cube, *target, *options, "--least-share", least)["curves"][0]
            program.check(numbers["positives"] == positive.sum() and numbers["negatives"] == negative.sum(), numbers)
            program.check(numbers["targets"] == 7, numbers["targets"])
            both = np.concatenate([score[positive], score[negative]])
            is_target = np.concatenate([np.ones(positive.sum()), np.zeros(negative.sum())])
            close(numbers["area"], sklearn.metrics.roc_auc_score(is_target, both), what="area")
            found = np.mean(score[positive] > score[negative].max())
            close(numbers["before_first_false_alarm"], found, what=(rule, least))
            table = np.genfromtxt(folder / "roc/roc.csv", delimiter=",", names=True)
            false, true, threshold = sklearn.metrics.roc_curve(is_target, both, drop_intermediate=False)
            close(table["false_alarm_rate"][1:], false[1:], what="false alarms")
            close(table["detection_rate"][1:], true[1:], what="detections")
            close(table["threshold"][1:], threshold[1:], what="thresholds")
    # A target without a score is not found; a pixel whose truth is not known takes no part; shares are parts of 1.
    holes, unknown = score.copy(), share.copy()
    holes[5, 5] = np.nan
    unknown[50, 50:60] = np.nan
    some = write_cube(folder / "holes.img", holes[..., None], dtype="f8")
    known = write_cube(folder / "unknown.img", unknown[..., None], dtype="f8")
    one = analyze(folder, "roc", some, "--truth", known)["curves"][0]
    program.check(one["not_scored"] == 1 and one["positives"] == (share > 0).sum(), one["not_scored"])
    program.check(one["negatives"] == (~neighbourhood(share > 0, 1)).sum() - 10, one["negatives"])
    program.check(one["points"][-1][1] == 1 and one["points"][-2][1] < 1, "found with everything else, at last")
    percent = write_cube(folder / "percent.img", 100 * share[..., None], dtype="f8")
    program.refused("analyze", "roc", some, "--truth", percent, "-o", folder / "no", status=2, says=["at most 1"])
    scaled = write_cube(
        folder / "scaled.img", np.round(1e4 * share)[..., None], dtype="u2", reflectance_scale_factor=10000
    )
    two = analyze(folder, "roc", cube.with_suffix(".hdr"), "--layer", "high", "--truth", scaled, "--least-share", 0.3)
    program.check(two["curves"][0]["positives"] == (share >= 0.3).sum(), two["curves"][0]["positives"])
    lower = analyze(folder, "roc", cube, "--layer", "low", "--lower", "--truth", truth)["curves"][0]
    higher = analyze(folder, "roc", cube, *target)["curves"][0]
    program.check(lower["area"] == higher["area"], "the same the other way round")
    return cube, truth, score, share


def of_targets(folder, cube, truth, score, share):
    """Per target, and shares of the target instead of the pixel."""
    best = [0.8, 0.5, 0.2, 0.4, 0.15, 0.6, 0.33]
    numbers = analyze(folder, "roc", cube, "--layer", "high", "--truth", truth, "--per-target", "--least-share", 0.18)
    program.check(numbers["curves"][0]["positives"] == sum(b >= 0.18 for b in best), numbers["curves"][0]["positives"])
    numbers = analyze(
        folder, "roc", cube, "--layer", "high", "--truth", truth, "--share-of", "target", "--least-share", 0.5
    )
    # 0.8 and 0.15 and 0.33 are whole; 0.5 of 0.8; 0.2 of 0.3; 0.4 of 0.75; 0.6 of 0.62
    program.check(numbers["curves"][0]["positives"] == 7, numbers["curves"][0]["positives"])
    numbers = analyze(
        folder, "roc", cube, "--layer", "high", "--truth", truth, "--share-of", "target", "--least-share", 0.6
    )
    program.check(numbers["curves"][0]["positives"] == 6, numbers["curves"][0]["positives"])


def interval(folder):
    """Of many targets of one pixel each, the bootstrap's interval is the binomial's."""
    share = np.zeros((200, 200))
    share[2:198:7, 2:198:7] = 0.5
    score = RNG.normal(0, 1, share.shape)
    score[share > 0] += 3
    cube = write_cube(folder / "many.img", score[..., None], dtype="f8")
    truth = write_cube(folder / "many_truth.img", share[..., None], dtype="f8")
    one = analyze(folder, "roc", cube, "--truth", truth, "--bootstrap", 4000)["curves"][0]
    n, p = one["positives"], one["before_first_false_alarm"]
    wide = 2 * 1.96 * np.sqrt(p * (1 - p) / n)
    low, high = one["interval_95"]
    program.check(low < p < high, low, p, high)
    program.within((high - low) / wide - 1, 0.1, "interval")
    again = analyze(folder, "roc", cube, "--truth", truth, "--bootstrap", 4000)["curves"][0]
    program.check(again == one, "the same seed, the same interval")
    seeds = [
        analyze(folder, "roc", cube, "--truth", truth, "--bootstrap", 40, "--seed", s)["curves"][0] for s in range(4)
    ]
    program.check(len({tuple(one["interval_95"]) for one in seeds}) > 1, "other seeds, other draws")


def regions(folder):
    """Outlines, masks, layers, classes: the same pixels as by hand."""
    value = RNG.uniform(1, 2, (20, 30, 3))
    plain = write_cube(folder / "plain.img", value, dtype="f8")
    triangle = [[4, 2], [24, 2], [4, 17], [4, 2]]
    y, x = np.mgrid[0:20, 0:30] + 0.5
    inside = (x > 4) & (y > 2) & ((x - 4) / 20 + (y - 2) / 15 < 1)
    features = [
        {"type": "Feature", "properties": {"name": name}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for name, ring in (("lawn", triangle), ("other", [[26, 1], [29, 1], [29, 4], [26, 4], [26, 1]]))
    ]
    outlines = folder / "outlines.geojson"
    outlines.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    found = analyze(folder, "statistics", plain, "--region", f"t={outlines}@name=lawn")["regions"][0]
    program.check(found["pixels"] == inside.sum(), found["pixels"], inside.sum())
    close(found["mean"], value[inside].mean(0), what="outline")
    both = analyze(folder, "statistics", plain, "--region", f"t={outlines}")["regions"][0]
    program.check(both["pixels"] == inside.sum() + 9, both["pixels"])
    mask = write_cube(
        folder / "mask.img", np.stack([inside, inside * 7 + 1], 2), "bsq", "u1", band_names="{in, kind (class)}"
    )
    for what in (f"m={mask}", f"m={mask}@kind=8", f"m={mask}@kind>1", f"m={mask}@2>=8", f"m={mask}@1"):
        found = analyze(folder, "statistics", plain, "--region", what)["regions"][0]
        program.check(found["pixels"] == inside.sum(), what, found["pixels"])
    kinds = write_cube(
        folder / "kinds.img",
        (inside + 1)[..., None],
        dtype="u1",
        file_type="ENVI Classification",
        classes=3,
        class_names="{none, field, lawn}",
    )
    found = analyze(folder, "statistics", plain, "--classes", kinds)["regions"]
    program.check(
        [(r["region"], r["pixels"]) for r in found] == [("field", 600 - inside.sum()), ("lawn", inside.sum())], found
    )
    return value, triangle, inside


def on_the_map(folder, value, triangle, inside):
    """Outlines in the cube's own coordinates, and in degrees; maps keep the cube's place."""
    system = patience.run(
        ["gdalsrsinfo", "-o", "wkt1_esri", "--single-line", "EPSG:32632"], capture_output=True, text=True, check=True
    )
    placed = write_cube(
        folder / "placed.img",
        value,
        dtype="f8",
        map_info="{UTM, 1, 1, 477000, 5472000, 2, 2, 32, North, WGS-84, units=Meters}",
        coordinate_system_string="{" + system.stdout.strip() + "}",
    )
    ring = [[477000 + 2 * a, 5472000 - 2 * b] for a, b in triangle]
    on_map = folder / "map.csv"
    on_map.write_text('name,WKT\nlawn,"POLYGON((' + ",".join(f"{a} {b}" for a, b in ring) + '))"\n')
    patience.run(
        [
            "ogr2ogr",
            "-f",
            "GPKG",
            "-a_srs",
            "EPSG:32632",
            folder / "map.gpkg",
            on_map,
            "-oo",
            "GEOM_POSSIBLE_NAMES=WKT",
        ],
        check=True,
    )
    patience.run(
        ["ogr2ogr", "-f", "GeoJSON", "-t_srs", "EPSG:4326", folder / "degrees.geojson", folder / "map.gpkg"], check=True
    )
    for file in ("map.gpkg", "degrees.geojson"):
        found = analyze(folder, "statistics", placed, "--region", f"t={folder / file}")["regions"][0]
        program.check(
            abs(found["pixels"] - inside.sum()) <= 2, file, found["pixels"], inside.sum()
        )  # corners of pixels
    analyze(folder, "kmeans", placed, "--count", 2, picture=True)
    analyze(folder, "detect", placed, "--detector", "rx", "--detector", "mf", "--target", "t=0:0,0:0")
    for verb, name in (("kmeans", "kmeans"), ("detect", "detect")):
        info = json.loads(
            patience.run(
                ["gdalinfo", "-json", folder / verb / f"{name}.tif"], capture_output=True, text=True, check=True
            ).stdout
        )
        program.check(info["geoTransform"] == [477000, 2, 0, 5472000, 0, -2], info["geoTransform"])
        program.check(
            '"EPSG",32632' in info["coordinateSystem"]["wkt"] or "UTM" in info["coordinateSystem"]["wkt"], info
        )
        patience.run(
            [
                "gdal_translate",
                "-q",
                "-of",
                "ENVI",
                "-ot",
                "Float64",
                folder / verb / f"{name}.tif",
                folder / "again.img",
            ],
            check=True,
        )
        again = np.fromfile(folder / "again.img").reshape(layers(folder, verb).shape)
        program.check(np.array_equal(again, layers(folder, verb)), verb)
    header = (folder / "kmeans/kmeans.hdr").read_text()
    program.check("ENVI Classification" in header and "class names = {none, class 1, class 2}" in header, header)


def over_bands(nm, curve, center, fwhm):
    """Averages over Gaussian responses."""
    fine = np.linspace(nm[0], nm[-1], 50001)
    sigma = fwhm / np.sqrt(8 * np.log(2))
    weight = np.exp(-0.5 * ((fine - center[:, None]) / sigma) ** 2) * (np.abs(fine - center[:, None]) <= 2 * fwhm)
    return (weight * np.interp(fine, nm, curve)).sum(1) / weight.sum(1)


def spectra(folder):
    """Curves of files on a cube's bands: CSV, a column of it, an ENVI library; averaged over each band."""
    nm = np.arange(400, 901, 5.0)
    curve = 0.3 + 0.2 * np.sin(nm / 40)
    (folder / "curve.csv").write_text(
        "# source: a sine\nwavelength_nm,reflectance,other\n"
        + "".join(f"{a},{b:.9f},{b / 2:.9f}\n" for a, b in zip(nm, curve))
    )
    center, fwhm = np.arange(450, 851, 40.0), 30.0
    cube = RNG.uniform(0, 1, (8, 9, len(center)))
    path = write_cube(
        folder / "bands.img",
        cube,
        dtype="f8",
        wavelength="{" + ", ".join(map(str, center)) + "}",
        fwhm="{" + ", ".join([str(fwhm)] * len(center)) + "}",
        wavelength_units="Nanometers",
    )
    expected = over_bands(nm, curve, center, fwhm)
    numbers = analyze(
        folder,
        "detect",
        path,
        "--detector",
        "sam",
        "--target",
        f"a={folder / 'curve.csv'}",
        "--target",
        f"b={folder / 'curve.csv'}@other",
    )
    close(numbers["targets"][0]["spectrum"], expected, 2e-4, "over bands")  # a sum of 81 points against 50001
    close(numbers["targets"][1]["spectrum"], expected / 2, 2e-4, "a column")
    program.refused(
        "analyze",
        "detect",
        write_cube(
            folder / "far.img",
            cube,
            dtype="f8",
            wavelength_units="Nanometers",
            wavelength="{" + ", ".join(map(str, center + 100)) + "}",
        ),
        "--detector",
        "sam",
        "--target",
        f"a={folder / 'curve.csv'}",
        "-o",
        folder / "no",
        status=2,
        says=["reaches from 400 to 900 nm"],
    )


def rendered(folder):
    """A scene of small green targets on grass: reflectance by panels, detection, curve."""
    rng, targets = np.random.default_rng(9), ""
    for k, (x, y) in enumerate(np.stack(np.meshgrid(np.arange(-12, 13, 6), np.arange(-12, 13, 6)), -1).reshape(-1, 2)):
        x, y = x + rng.uniform(-0.5, 0.5), y + rng.uniform(-0.5, 0.5)
        targets += f'[[plane]]\nname = "block {k}"\nmaterial = "green"\nsize_m = [0.5, 0.3]\n'
        targets += f"position_m = [{x:.3f}, {y:.3f}, 0.02]\n"
    nm = np.arange(350, 1001, 10.0)
    curves = {
        "grass": 0.05 + 0.4 / (1 + np.exp(-(nm - 715) / 12)),
        "green": 0.08 + 0.25 * np.exp(-(((nm - 530) / 40) ** 2)),
    }
    for name, curve in curves.items():
        (folder / f"{name}.csv").write_text(
            "wavelength_nm,reflectance\n" + "".join(f"{a},{b:.6f}\n" for a, b in zip(nm, curve))
        )
    (folder / "scene.toml").write_text(
        'format = 1\nsky_directions = 16\nmaterial = [{ name = "grass", file = "grass.csv" }, '
        '{ name = "green", file = "green.csv" }, '
        '{ name = "dark", reflectance = 0.1 }, { name = "bright", reflectance = 0.8 }]\n'
        'atmosphere = { model = "clear_sky", aod_550 = 0.15 }\n'
        "time = { sun = { zenith_deg = 35.0, azimuth_deg = 150.0, day_of_year = 264 } }\n"
        '[[plane]]\nmaterial = "grass"\nsize_m = [300.0, 300.0]\n'
        + targets
        + '[[plane]]\nmaterial = "dark"\nposition_m = [-17.0, 17.0, 0.02]\nsize_m = [8.0, 8.0]\n'
        '[[plane]]\nmaterial = "bright"\nposition_m = [-8.0, 17.0, 0.02]\nsize_m = [8.0, 8.0]\n'
        '[[instrument]]\nname = "camera"\nkind = "framing"\npixels = 48\nlines = 48\n'
        "altitude_agl_m = 800.0\ngsd_m = 1.0\n"
        "samples = { grid = [16, 16] }\n"
        "bands = { first_nm = 420.0, step_nm = 20.0, count = 25, fwhm_nm = 20.0 }\n"
    )
    program.run("render", folder / "scene.toml", "-o", folder / "out", "-q", "-q")
    radiance, truth = folder / "out/camera/radiance.img", folder / "out/camera/truth.img"
    # Panels are what is wholly dark and bright.
    numbers = analyze(
        folder,
        "reflectance",
        radiance,
        "--panel",
        f"d={truth}@abundance_dark>=0.9999",
        "--panel",
        f"b={truth}@abundance_bright>=0.9999",
        "--reflectance",
        "d=0.1",
        "--reflectance",
        "b=0.8",
    )
    program.check(np.isfinite(values(numbers["gain"])).all(), "every band tells")
    cube = folder / "reflectance/reflectance.img"
    grass = analyze(folder, "statistics", cube, "--region", f"g={truth}@abundance_grass>=0.9999")["regions"][0]
    known = over_bands(nm, curves["grass"], 1e3 * np.asarray(numbers["wavelength_um"]), 20.0)
    program.check(np.abs(np.array(grass["mean"]) - known).max() < 0.005, np.abs(np.array(grass["mean"]) - known).max())
    noisy = np.fromfile(cube, "f4").reshape(-1, 25).astype("f8")
    noisy = noisy + rng.normal(0, 0.004, noisy.shape)  # a background without spread has no covariance
    path = write_cube(
        folder / "noisy.img",
        noisy.reshape(48, 48, 25),
        dtype="f8",
        wavelength_units="Micrometers",
        wavelength="{" + ", ".join(map(str, numbers["wavelength_um"])) + "}",
    )
    analyze(
        folder,
        "detect",
        path,
        "--target",
        f"green={folder / 'green.csv'}",
        "--background",
        f"g={truth}@abundance_grass>=0.5",
        picture=True,
    )
    roc = analyze(
        folder, "roc", folder / "detect/detect.img", "--truth", f"{truth}@abundance_green", "--per-target", picture=True
    )
    one = roc["curves"][0]
    program.check(one["targets"] == 25 and one["before_first_false_alarm"] > 0.9, one)


with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
    top = pathlib.Path(name)
    of_targets(top, *curves(top))
    interval(top)
    on_the_map(top, *regions(top))
    spectra(top)
    rendered(top)
    print(f"analyze roc: {program.checks} checks")
