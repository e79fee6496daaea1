"""S45 S47 S49 S50 S51 S52 S53: `raycube analyze` against numpy, `spectral`, scikit-learn and scipy, which owe it
nothing, on cubes of every interleave and on real ones where they are there."""

import os
import pathlib
import sys
import tempfile

import numpy as np
import scipy.optimize
import sklearn.cluster
import sklearn.metrics
import spectral

from analysis_kit import Analysis, layers, values, write_cube
from driver import Program, envi, seed

program = Program(sys.argv[1])
analysis = Analysis(program)
analyze, close = analysis.run, analysis.close
RNG = np.random.default_rng(seed(20261128))


def scene(lines, samples, bands, classes=4, far=60):
    """Pixels of a few mixed materials with correlated spread: a covariance that can be inverted, and truth."""
    mean = RNG.uniform(far - 2 if far < 60 else 5, far, (classes, bands))
    label = RNG.integers(0, classes, (lines, samples))
    mix = RNG.normal(0, 1, (bands, bands)) / np.sqrt(bands)
    wide = np.array([0.4, 0.8, 1.3, 2.0])[label % 4, None]  # each class its own spread
    cube = mean[label] + wide * (RNG.normal(0, 1, (lines, samples, bands)) @ mix)
    cube += wide * RNG.normal(0, 0.3, (lines, samples, bands))
    return cube.astype("f4"), label, mean


def statistics(folder, path, cube):
    region = ["--region", "a=2:9,3:12", "--region", "b=15:19,0:4"]
    numbers = analyze(folder, "statistics", path, *region)
    for one, part in zip(numbers["regions"], (cube[3:13, 2:10], cube[0:5, 15:20])):
        pixels = part.reshape(-1, cube.shape[2]).astype(float)
        program.check(one["pixels"] == len(pixels), one["pixels"])
        close(one["mean"], pixels.mean(0), what="mean")
        close(one["standard_deviation"], pixels.std(0, ddof=1), what="deviation")
        close(one["minimum"], pixels.min(0), 0, "least")
        close(one["maximum"], pixels.max(0), 0, "most")


def eigen(folder, path, cube):
    pixels = cube.reshape(-1, cube.shape[2]).astype(float)
    value, vector = np.linalg.eigh(np.cov(pixels, rowvar=False))
    value, vector = value[::-1], vector[:, ::-1]
    numbers = analyze(folder, "eigen", path, "--count", 3)["structures"][0]
    close(numbers["eigenvalues"], value, what="eigenvalues")
    program.check(np.abs(np.array(numbers["eigenvalues"]) / value - 1).max() < 1e-8, "small ones too")
    for k in range(3):
        found, other = np.array(numbers["eigenvectors"][k]), vector[:, k]
        program.check(abs(found).max() == found.max(), "sign")
        close(found, other * np.sign(other[np.argmax(abs(other))]), 1e-7, "eigenvector")
    principal = spectral.principal_components(cube.astype("f8"))
    close(numbers["eigenvalues"], principal.eigenvalues, what="eigenvalues, spectral")


def wide(folder):
    """Lines longer than the pixels that are summed at once, far from zero: no digit is lost, none counted twice."""
    cube = 1e6 + RNG.normal(0, 1, (3, 700, 7)) @ RNG.normal(0, 1, (7, 7))
    path = write_cube(folder / "wide.img", cube, "bil", "f8")
    numbers = analyze(folder, "eigen", path, "--count", 2)["structures"][0]
    pixels = cube.reshape(-1, 7) - 1e6
    value = np.linalg.eigvalsh(np.cov(pixels, rowvar=False))[::-1]
    program.check(np.abs(np.array(numbers["eigenvalues"]) / value - 1).max() < 1e-8, "far from zero")
    analyze(folder, "detect", path, "--detector", "rx")
    y = pixels - pixels.mean(0)
    rx = np.einsum("pb,bc,pc->p", y, np.linalg.inv(np.cov(pixels, rowvar=False)), y)
    close(layers(folder, "detect")[0].ravel(), rx, 1e-7, "rx far from zero")


def angles(folder, path, cube):
    """Two cubes: scipy's own angles."""
    other = cube @ np.linalg.qr(RNG.normal(0, 0.02, (cube.shape[2],) * 2) + np.eye(cube.shape[2]))[0]
    second = write_cube(folder / "other.img", other.astype("f4"))
    numbers = analyze(folder, "eigen", path, "--other", second, "--count", 3)
    both = [np.array(s["eigenvectors"]).T for s in numbers["structures"]]
    for pair, of in zip(both, (cube, other.astype("f4"))):
        known = np.linalg.eigh(np.cov(of.reshape(-1, of.shape[2]).astype("f8"), rowvar=False))[1][:, ::-1][:, :3]
        close(np.abs((pair * known).sum(0)), np.ones(3), 1e-9, "each cube's own")
    close(numbers["alignment"], np.abs((both[0] * both[1]).sum(0)), what="alignment")
    for k in (1, 2, 3):
        expected = np.degrees(scipy.linalg.subspace_angles(both[0][:, :k], both[1][:, :k]))[::-1]
        close(numbers["principal_angles_deg"][k - 1], expected, 1e-7, "angles")
    same = analyze(folder, "eigen", path, "--other", path, "--count", 3)
    program.check(max(same["principal_angles_deg"][2]) < 1e-6, same["principal_angles_deg"])


def detectors(folder, path, cube):
    pixels = cube.reshape(-1, cube.shape[2]).astype(float)
    target = cube[3:5, 6:9].reshape(-1, cube.shape[2]).astype(float).mean(0)
    names = ["mf", "ace", "ace_signed", "cem", "sam", "rx"]
    numbers = analyze(folder, "detect", path, "--target", "t=6:8,3:4", *(x for n in names for x in ("--detector", n)))
    found = dict(zip(names, layers(folder, "detect")))
    least = numbers["layers"][names.index("sam")]
    program.check(least["lowest"] == found["sam"].min(), "of angles the lowest is told", least)
    program.check([layer["layer"] for layer in numbers["layers"]] == [f"{n} t" for n in names[:-1]] + ["rx"], numbers)
    cube = cube.astype("f8")  # which `spectral` would keep as floats
    background = spectral.calc_stats(cube)
    close(found["mf"], spectral.matched_filter(cube, target, background), what="mf, spectral")
    close(found["ace"], spectral.ace(cube, target, background=background), what="ace, spectral")
    close(found["rx"], spectral.rx(cube, background=background), what="rx, spectral")
    close(found["sam"], spectral.spectral_angles(cube, target[None])[..., 0], 1e-7, "sam, spectral")
    close(np.abs(found["ace_signed"]), found["ace"], 0, "ace, signed")
    program.check(np.array_equal(found["ace_signed"] < 0, found["mf"] < 0), "the sign is the matched filter's")
    inverse = np.linalg.inv(pixels.T @ pixels / len(pixels))
    cem = (pixels @ inverse @ target / (target @ inverse @ target)).reshape(cube.shape[:2])
    close(found["cem"], cem, what="cem")
    # Laws: a pixel of target, the background's mean, and scale.
    scaled = write_cube(folder / "scaled.img", 7.25 * cube.astype("f8"), dtype="f8")
    analyze(folder, "detect", scaled, "--target", "t=6:8,3:4", "--detector", "ace", "--detector", "mf")
    close(layers(folder, "detect")[0], found["ace"], what="ace does not know scale")
    close(layers(folder, "detect")[1], found["mf"], what="nor does mf, target and all")
    flat = cube.copy()
    flat[0, 0], flat[1, 1] = 2 * target - 3, 0
    one = write_cube(folder / "one.img", flat.astype("f8"), dtype="f8")
    analyze(
        folder, "detect", one, "--target", "t=0:0,0:0", "--detector", "mf", "--detector", "cem", "--detector", "sam"
    )
    program.check(np.allclose(layers(folder, "detect")[:, 0, 0], [1, 1, 0], atol=1e-7), "a pixel of target itself")
    program.check(np.isnan(layers(folder, "detect")[2, 1, 1]), "no angle of nothing")


def background(folder, path, cube):
    """--background, --without and --shrink."""
    inside = np.zeros(cube.shape[:2], bool)
    inside[0:15] = True
    inside[3:5, 6:9] = False
    analyze(
        folder,
        "detect",
        path,
        "--detector",
        "rx",
        "--background",
        "b=0:19,0:14",
        "--without",
        "t=6:8,3:4",
        "--shrink",
        0.1,
    )
    pixels, all_pixels = cube[inside].astype(float), cube.astype(float)
    covariance = np.cov(pixels, rowvar=False)
    covariance = 0.9 * covariance + 0.1 * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
    y = all_pixels - pixels.mean(0)
    close(layers(folder, "detect")[0], np.einsum("lsb,bc,lsc->ls", y, np.linalg.inv(covariance), y), what="shrunk rx")


def brute(endmembers, pixel):
    """Least squares with shares of sum 1, none below 0: the best of every set of endmembers."""
    best, count = (np.inf, None), endmembers.shape[1]
    for bits in range(1, 2**count):
        member = [e for e in range(count) if bits >> e & 1]
        e = endmembers[:, member]
        system = np.block([[e.T @ e, np.ones((len(member), 1))], [np.ones((1, len(member))), np.zeros((1, 1))]])
        share = np.linalg.solve(system, np.append(e.T @ pixel, 1))[:-1]
        if share.min() >= -1e-12:
            rest = np.sum((pixel - e @ share) ** 2)
            if rest < best[0]:
                full = np.zeros(count)
                full[member] = share
                best = rest, full
    return best[1]


def unmixing(folder, path, cube):
    endmembers = {"p": (0, 0), "q": (5, 5), "r": (9, 2), "s": (14, 11)}
    spectra = np.array([cube[y, x].astype(float) for x, y in endmembers.values()]).T
    options = [x for n, (a, b) in endmembers.items() for x in ("--endmember", f"{n}={a}:{a},{b}:{b}")]
    numbers = analyze(folder, "unmix", path, *options, "--region", "part=0:3,0:3")
    found = layers(folder, "unmix")
    program.check(np.allclose(found[:4].sum(0), 1, atol=1e-12) and found[:4].min() >= 0, "shares")
    pixels = cube.reshape(-1, cube.shape[2]).astype(float)
    chosen = RNG.choice(len(pixels), 150, replace=False)
    flat = found.reshape(5, -1)
    close(flat[:4, chosen].T, [brute(spectra, pixels[p]) for p in chosen], what="full, by every set")
    heavy = 1e5 * np.abs(spectra).max()  # a sum of 1 as one more, heavy band: scipy's own active sets, to that weight
    for p in chosen[:20]:
        share, _ = scipy.optimize.nnls(np.vstack([spectra, np.full(4, heavy)]), np.append(pixels[p], heavy))
        program.check(np.abs(share - flat[:4, p]).max() < 1e-6, "full, scipy", share, flat[:4, p])
    rest = np.sqrt(np.mean((pixels.T - spectra @ flat[:4]) ** 2, axis=0))
    close(flat[4], rest, what="what is left")
    part = found[:, :4, :4].reshape(5, -1)
    close(numbers["regions"][0]["mean"], part.mean(1), what="region")
    analyze(folder, "unmix", path, *options, "--constraint", "none")
    free = np.linalg.lstsq(spectra, pixels.T, rcond=None)[0]
    close(layers(folder, "unmix")[:4].reshape(4, -1), free, what="none, numpy")
    analyze(folder, "unmix", path, *options, "--constraint", "sum")
    apart = spectra[:, 1:] - spectra[:, :1]
    summed = np.linalg.lstsq(apart, pixels.T - spectra[:, :1], rcond=None)[0]
    close(layers(folder, "unmix")[1:4].reshape(3, -1), summed, what="sum")


def close_endmembers(folder):
    """Exact shares of endmembers that are a millionth apart."""
    base, way = RNG.uniform(20, 60, 12), RNG.normal(0, 1, 12)
    other = base * (1 + 1e-6 * way)
    shares = np.array([1, 0.9, 0.5, 0.1, 0.01, 0.0])
    pixels = np.concatenate([[base, other], shares[:, None] * base + (1 - shares[:, None]) * other])
    path = write_cube(folder / "near.img", pixels[None], dtype="f8")
    analyze(folder, "unmix", path, "--endmember", "a=0:0,0:0", "--endmember", "b=1:1,0:0")
    off = np.abs(layers(folder, "unmix")[0, 0, 2:] - shares).max()
    program.check(off < 1e-7, off)  # rounding of the pixels themselves over what they are apart


def clusters(folder):
    # Brighter and darker pixels, so that no centre along the mean stays empty (`scikit-learn` would move it), and far
    # more bands than a pixel is known by in short.
    bright = RNG.choice([0.8, 0.93, 1.06, 1.2], (30, 20, 1)) * RNG.uniform(20, 60, 40)
    cube = (bright + RNG.normal(0, 12, (30, 20, 40))).astype("f4")
    path = write_cube(folder / "brighter.img", cube, "bil")
    pixels = cube.reshape(-1, cube.shape[2]).astype(float)
    numbers = analyze(folder, "kmeans", path, "--count", 4)
    spread = pixels.std(0, ddof=1)
    start = np.array([pixels.mean(0) + spread * (2 * k / 3 - 1) for k in range(4)])
    other = sklearn.cluster.KMeans(4, init=start, n_init=1, max_iter=1000, tol=0, algorithm="lloyd").fit(pixels)
    close([c["center"] for c in numbers["classes"]], other.cluster_centers_, what="centres, scikit-learn")
    found = layers(folder, "kmeans")[0]
    program.check(np.array_equal(found.ravel(), other.labels_ + 1), "classes, scikit-learn")
    close(numbers["rms_apart"], np.sqrt(other.inertia_ / len(pixels)), what="inertia")
    labels, centers = spectral.kmeans(cube.astype("f8"), 4, 1000, start_clusters=start)
    close([c["center"] for c in numbers["classes"]], centers, 1e-6, "centres, spectral")  # which sums in float
    lying = write_cube(folder / "lying.img", cube, "bip")  # which is not read anew each round
    low = analyze(folder, "kmeans", lying, "--count", 4, "--threads", 1)
    program.check(low["classes"] == numbers["classes"], "where it lies: the same bits")
    drawn = [analyze(folder, "kmeans", path, "--start", "plusplus", "--seed", 3, "--threads", t) for t in (1, 2)]
    program.check(drawn[0]["classes"] == drawn[1]["classes"], "the same bits whatever the threads")


def maximum_likelihood(folder):
    cube, label, _ = scene(40, 36, 6, far=22)  # classes that overlap, so that how wide each is decides
    path = write_cube(folder / "overlap.img", cube)
    truth = write_cube(folder / "classes.img", (label + 1)[..., None], dtype="u1")
    training = np.where(np.arange(label.shape[0])[:, None] % 2 == 0, label + 1, 0)
    taught = write_cube(folder / "taught.img", training[..., None], dtype="u1")
    numbers = analyze(folder, "classify", path, "--classes", taught, "--truth-classes", truth)
    other = spectral.GaussianClassifier(spectral.create_training_classes(cube.astype("f8"), training, calc_stats=True))
    for one in other.classes:
        one.class_prob = 0.25  # ours: all alike
    expected = other.classify_image(cube.astype("f8"))
    found = layers(folder, "classify")[0]
    program.check(np.array_equal(found, expected), "classes, spectral", np.mean(found != expected))
    matrix = sklearn.metrics.confusion_matrix(label.ravel() + 1, found.ravel())
    program.check(np.array_equal(np.array(numbers["confusion"]["count"])[:, :4], matrix), "confusion")
    kappa = sklearn.metrics.cohen_kappa_score(label.ravel() + 1, found.ravel())
    close(numbers["confusion"]["kappa"], kappa, what="kappa")
    close(numbers["confusion"]["accuracy"], np.mean(found == label + 1), what="accuracy")
    few = ["--region", "a=0:2,0:0", "--region", "b=3:12,0:12"]
    program.refused("analyze", "classify", path, *few, "-o", folder / "no", status=2, says=['class "a" of 3 pixels'])
    analyze(folder, "classify", path, *few, "--shrink", 0.5)  # the named way out


def empirical_line(folder):
    """S45: panels come back as what they are, and so does all that light reaches alike."""
    bands = 20
    gain, offset = RNG.uniform(20, 90, bands), RNG.uniform(2, 9, bands)
    rho = RNG.uniform(0, 1, (24, 24, bands))
    rho[0:4, 0:4], rho[0:4, 8:12] = 0.1, 0.8
    gain[7] = 0  # a band that sees nothing of the ground
    path = write_cube(folder / "radiance.img", gain * rho + offset, "bil", "f8")
    panels = ["--panel", "dark=0:3,0:3", "--panel", "bright=8:11,0:3"]
    known = ["--reflectance", "dark=0.1", "--reflectance", "bright=0.8"]
    numbers = analyze(folder, "reflectance", path, *panels, *known)
    found = envi(folder / "reflectance", "reflectance")[1]
    good = np.arange(bands) != 7
    program.check(np.abs(found[..., good] - rho[..., good]).max() < 1e-6, "float's rounding")
    close(values(numbers["gain"])[good], 1 / gain[good], what="gain")
    program.check(np.isnan(values(numbers["gain"])[7]) and np.all(found[..., 7] == 0), "a band that tells nothing")
    program.check("bbl = " in (folder / "reflectance/reflectance.hdr").read_text(), "bad band")
    program.refused(
        "analyze",
        "reflectance",
        path,
        *panels,
        known[0],
        known[1],
        "-o",
        folder / "no",
        status=2,
        says=['panel "bright" has no reflectance'],
    )


def ignored(folder):
    """Values that are not finite or the header's ignore value, gains, scale factors, band choices, bad bands."""
    cube, _, _ = scene(15, 13, 6)
    integers = np.round(cube * 100).astype("i4")
    integers[2, 3], integers[0, 0] = -9999, -9999
    path = write_cube(
        folder / "scaled.img",
        integers,
        "bsq",
        ">i2",
        data_ignore_value=-9999,
        reflectance_scale_factor=100,
        bbl="{1, 1, 0, 1, 1, 1}",
        wavelength="{400, 450, 500, 550, 600, 650}",
        wavelength_units="Nanometers",
    )
    numbers = analyze(folder, "statistics", path)
    kept = np.ones(cube.shape[:2], bool)
    kept[2, 3] = kept[0, 0] = False
    program.check(numbers["bands"] == [1, 2, 4, 5, 6] and numbers["regions"][0]["left_out"] == 2, numbers["bands"])
    close(numbers["regions"][0]["mean"], integers[kept][:, [0, 1, 3, 4, 5]].mean(0) / 100, what="scaled")
    program.check(analyze(folder, "statistics", path, "--bands", "2:3,5")["bands"] == [2, 3, 5], "--bands")
    program.check(analyze(folder, "statistics", path, "--wavelengths", "440:560")["bands"] == [2, 4], "--wavelengths")
    for typed in ("0.4:0.7", "440:560,0.4:0.7"):
        says = ["is in nm, and 0.4:0.7 looks like micrometres; give 400:700"]
        folder_of = ("-o", folder / "micrometres")
        program.refused("analyze", "statistics", path, "--wavelengths", typed, *folder_of, status=2, says=says)
    cube[4, 5, 2] = np.nan
    for text, value in (
        ("-1e+34", np.float32(-1e34)),
        ("-3.40282e+38", -np.finfo("f4").max),
        ("-1.23e34", np.float32(-1.23e34)),
    ):
        kept = cube[..., :2].copy()
        kept[1, 1, 0] = value
        one = write_cube(folder / "ignored.img", np.where(np.isnan(kept), 1, kept), data_ignore_value=text)
        program.check(analyze(folder, "statistics", one)["regions"][0]["left_out"] == 1, text)
    broken = write_cube(folder / "nan.img", cube)
    analyze(folder, "detect", broken, "--detector", "rx")
    found = layers(folder, "detect")[0]
    program.check(np.isnan(found[4, 5]) and np.isnan(found).sum() == 1, "one pixel takes no part")
    whole = analyze(folder, "unmix", broken, "--endmember", "a=0:0,0:0", "--endmember", "b=3:3,3:3")["regions"][0]
    program.check(whole["pixels"] == 15 * 13 - 1 and np.isfinite(whole["mean"]).all(), whole)


def write_table(folder):
    (folder / "table.csv").write_text("name,number\na,1\n")
    return folder / "table.csv"


def refusals(folder, path, cube):
    """One clear error each, and nothing written."""
    wrong = [
        (["statistics", path, "--region", "a=0:99,0:3"], "has samples 0 to 19 and lines 0 to 29"),
        (["statistics", path, "--region", "a"], "give NAME=WHAT"),
        (["statistics", path, "--region", "a=nothing.img"], "no such file is there"),
        (["statistics", path, "--region", "a=0:3,0:3", "--region", "a=0:3,0:3"], 'two regions are called "a"'),
        (["statistics", path, "--bands", "0:3"], "has bands 1 to 12"),
        (["statistics", path, "--wavelengths", "400:500"], "no wavelengths"),
        (["detect", path], "needs one; give --target"),
        (["detect", path, "--detector", "magic"], 'no detector is called "magic"'),
        (["detect", path, "--target", "t=0:0,0:0", "--background", "b=0:3,0:1"], "cannot be inverted"),
        (["unmix", path, "--endmember", "a=0:0,0:0"], "takes 2 to 12 endmembers (found 1)"),
        (["unmix", path, "--endmember", "a=0:0,0:0", "--endmember", "b=0:0,0:0"], "is a mixture of the others"),
        (["unmix", path, "--endmember", "a=0:0,0:0", "--endmember", "b=x.csv"], "no wavelengths"),
        (["classify", path, "--region", "a=0:9,0:9"], "two regions or more"),
        (
            ["classify", path, "--region", "a=0:9,0:9", "--region", "b=0:9,10:19", "--prior", "a=inf"],
            "give CLASS=SHARE",
        ),
        (
            ["unmix", path, "--endmember", "a=0:0,0:0", "--endmember", "b=1:1,1:1", "--region", "image=0:1,0:1"],
            "the whole",
        ),
        (["statistics", path, "--region", f"a={write_table(folder)}"], "has no outlines"),
        (
            ["eigen", path, "--other", write_cube(folder / "bad.img", cube, bbl="{0" + ", 1" * 11 + "}")],
            "must be the same",
        ),
        (["kmeans", write_cube(folder / "flat.img", np.full((9, 9, 3), 2.0))], "all pixels are alike"),
        (["eigen", write_cube(folder / "flat.img", np.full((9, 9, 3), 2.0))], "all pixels are alike"),
        (["kmeans", write_cube(folder / "two.img", cube[:1, :2]), "--count", "5"], "2 pixels cannot be 5 classes"),
        (["roc", path, "--truth", path.parent / "other.img@99"], 'has no layer "99"'),
    ]
    for arguments, says in wrong:
        program.refused("analyze", *arguments, "-o", folder / "no", status=2, says=[says])
        program.check(not (folder / "no").exists() or not list((folder / "no").glob("[!.]*")), arguments)
    for verb, more in (("statistics", []), ("detect", ["--detector", "rx"])):
        analyze(folder, verb, path, *more)
        before = {file.name: file.read_bytes() for file in (folder / verb).iterdir()}
        program.refused("analyze", verb, path, *more, "-o", folder / verb, status=2, says=["--overwrite"])
        program.check(before == {file.name: file.read_bytes() for file in (folder / verb).iterdir()}, verb)


def real(folder):
    shared = pathlib.Path(os.environ.get("RAYCUBE_SHARED", ""))
    cube_file = shared / "data/envi/enmap_potsdam_32x32x224_bil.dat"
    if not os.environ.get("RAYCUBE_SHARED") or not cube_file.exists():
        print("analyze: RAYCUBE_SHARED is not set: the real cubes were not looked at", file=sys.stderr)
        return
    for interleave in ("bil", "bsq"):
        file = shared / f"data/envi/enmap_potsdam_32x32x224_{interleave}.dat"
        image = spectral.open_image(str(file.with_suffix(".hdr")))
        bands = [b for b in range(5, 45)]
        cube = np.asarray(image.load())[:, :, bands].astype("f8")
        choice = ["--bands", f"{bands[0] + 1}:{bands[-1] + 1}"]
        analyze(folder, "detect", file, *choice, "--detector", "ace", "--detector", "rx", "--target", "t=3:4,5:6")
        target = cube[5:7, 3:5].reshape(-1, len(bands)).mean(0)
        statistics_ = spectral.calc_stats(cube)
        close(layers(folder, "detect")[0], spectral.ace(cube, target, background=statistics_), 1e-8, "real ace")
        close(layers(folder, "detect")[1], spectral.rx(cube, background=statistics_), 1e-8, "real rx")


with tempfile.TemporaryDirectory() as name:
    top = pathlib.Path(name)
    data, _, _ = scene(30, 20, 12)
    for number, kind in enumerate((("bip", "f4"), ("bil", "f8"), ("bsq", "f4"))):
        inner = top / str(number)
        inner.mkdir()
        cube_path = write_cube(inner / "cube.img", data, *kind)
        statistics(inner, cube_path, data)
        eigen(inner, cube_path, data)
        detectors(inner, cube_path, data)
        unmixing(inner, cube_path, data)
    wide(inner)
    angles(inner, cube_path, data)
    background(inner, cube_path, data)
    close_endmembers(inner)
    clusters(inner)
    maximum_likelihood(inner)
    empirical_line(top)
    ignored(top)
    refusals(inner, cube_path, data)
    real(top)
    print(f"analyze: {program.checks} checks")
