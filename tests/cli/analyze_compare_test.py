"""S46 S59: `raycube analyze register` on images shifted by known parts of a pixel, `scorecard` against scipy."""

import pathlib
import sys
import tempfile

import numpy as np
import scipy.linalg
import scipy.stats

from analysis_kit import Analysis, layers, values, write_cube
from driver import Program, seed
from optics_kit import HEAD, camera, with_origin

program = Program(sys.argv[1])
analysis = Analysis(program)
analyze, close = analysis.run, analysis.close
RNG = np.random.default_rng(seed(46))
MOST_OFF_PX = 0.02  # of pixels of another size, whose averages are other waves
MOST_OFF_ALIKE_PX = 5e-4  # six points between pixels of waves of 6 pixels and longer err by 1e-4


def waves(count=60, shortest=6.0):
    """A sum of plane waves no shorter than so many pixels: known everywhere, so that it can be shifted exactly."""
    length, way = RNG.uniform(shortest, 40, count), RNG.uniform(0, 2 * np.pi, count)
    k = 2 * np.pi / length * np.array([np.cos(way), np.sin(way)])
    size, phase = RNG.normal(0, 1, count), RNG.uniform(0, 2 * np.pi, count)
    return lambda x, y: (size * np.cos(k[0] * x[..., None] + k[1] * y[..., None] + phase)).sum(-1)


def pixels(field, samples, lines, dx=0.0, dy=0.0):
    y, x = np.mgrid[0:lines, 0:samples].astype(float)
    return field(x - dx, y - dy)


def shifts(folder):
    field = waves()
    first = write_cube(folder / "first.img", (40 + pixels(field, 150, 130))[..., None], dtype="f8")
    for dx, dy in ((0, 0), (0.3, -0.45), (2.71, 1.13), (-5.5, 7.25)):
        moved = 3 + 1.7 * pixels(field, 150, 130, dx, dy)  # another gain and offset
        second = write_cube(folder / "second.img", moved[..., None], dtype="f8")
        found = analyze(folder, "register", first, "--other", second)["whole"]
        for axis, wanted in (("samples", dx), ("lines", dy)):
            off, told = abs(found[axis] - wanted), found[axis + "_error"]
            # A clean pair is off by its interpolation alone, which the error knows; 1e-5: where steps end.
            program.check(off < MOST_OFF_ALIKE_PX and off < 3 * told + 1e-5 and told < 1e-3, axis, wanted, found)
        program.check(found["correlation"] > 0.999, found)
    # Shorter waves are interpolated worse, and the error says so.
    shorter = waves(shortest=4.0)
    alike = write_cube(folder / "alike.img", pixels(shorter, 150, 130)[..., None], dtype="f8")
    for dx, dy in ((0.3, -0.45), (0.13, 0.25), (2.71, 1.13)):
        second = write_cube(folder / "second.img", pixels(shorter, 150, 130, dx, dy)[..., None], dtype="f8")
        found = analyze(folder, "register", alike, "--other", second)["whole"]
        for axis, wanted in (("samples", dx), ("lines", dy)):
            off, told = abs(found[axis] - wanted), found[axis + "_error"]
            program.check(off < 3 * told and off < 5e-3 and told < 5e-3, axis, wanted, found)
    # Noise: errors as they are told, in the mean. 60 draws: their spread is known to 9 %, and over ten fields errors
    # are told 10 to 20 % too large.
    moved, off, told = pixels(field, 150, 130, 0.3, 0.2), [], []
    for _ in range(60):
        noisy = moved + RNG.normal(0, 2, moved.shape)
        second = write_cube(folder / "second.img", noisy[..., None], dtype="f8")
        found = analyze(folder, "register", first, "--other", second)["whole"]
        off.append((found["samples"], found["lines"]))
        told.append((found["samples_error"], found["lines_error"]))
    ratio = np.mean(told, axis=0) / np.std(off, axis=0, ddof=1)
    for axis, key in enumerate(("samples_error", "lines_error")):
        program.between(0.7, ratio[axis], 1.65, key)
    return field, first


def of_other_sizes(folder, field, first):
    """Pixels of a fifth, averaged; a scale of 1 % shows in the blocks, though the whole is not shifted."""
    fine = field(*np.meshgrid((np.arange(750) + 0.5) / 5 - 0.5 - 0.62, (np.arange(650) + 0.5) / 5 - 0.5 + 0.3))
    second = write_cube(folder / "fine.img", fine[..., None], dtype="f8")
    found = analyze(folder, "register", first, "--other", second, "--other-factor", 5)["whole"]
    program.check(abs(found["samples"] - 0.62) < MOST_OFF_PX and abs(found["lines"] + 0.3) < MOST_OFF_PX, found)
    y, x = np.mgrid[0:130, 0:150].astype(float)
    scaled = field(74.5 + (x - 74.5) / 1.01, 64.5 + (y - 64.5) / 1.01)
    second = write_cube(folder / "scaled.img", scaled[..., None], dtype="f8")
    found = analyze(folder, "register", first, "--other", second, "--block", 40, picture=True)
    for block in found["blocks"]:
        for axis, of_block, middle in (("samples", "sample", 74.5), ("lines", "line", 64.5)):
            off = abs(block[axis] - 0.01 * (block[of_block] - middle))
            program.check(off < max(0.06, 4 * block[axis + "_error"]), block)
    program.check(len(found["blocks"]) == 9, len(found["blocks"]))
    noise = write_cube(folder / "noise.img", RNG.normal(0, 1, (130, 150, 1)), dtype="f8")
    program.refused(
        "analyze", "register", first, "--other", noise, "-o", folder / "no", status=2, says=["no shift within"]
    )


def scores(folder):
    mix = RNG.normal(0, 1, (8, 8))
    one = 30 + RNG.normal(0, 1, (60, 50, 8)) @ mix
    two = 31 + 1.2 * RNG.normal(0, 1, (44, 70, 8)) @ mix @ np.linalg.qr(np.eye(8) + 0.1 * RNG.normal(0, 1, (8, 8)))[0]
    a, b = write_cube(folder / "a.img", one, "bil", "f8"), write_cube(folder / "b.img", two, "bsq", "f8")
    got = {s["metric"]: s["value"] for s in analyze(folder, "scorecard", a, "--other", b, picture=True)["scores"]}
    x, y = one.reshape(-1, 8), two.reshape(-1, 8)
    means = x.mean(0), y.mean(0)
    close(
        got["difference of the bands' means, rms over the first's mean"],
        100 * np.sqrt(np.mean((means[1] - means[0]) ** 2)) / means[0].mean(),
        what="means",
    )
    cosine = means[0] @ means[1] / np.linalg.norm(means[0]) / np.linalg.norm(means[1])
    close(got["angle between the mean spectra"], np.degrees(np.arccos(cosine)), 1e-6, "angle")
    close(
        got["ratio of the bands' standard deviations, mean"],
        np.mean(y.std(0, ddof=1) / x.std(0, ddof=1)),
        what="spread",
    )
    distances = [scipy.stats.ks_2samp(x[:, k], y[:, k]).statistic for k in range(8)]
    close(got["distance of the distributions, mean over bands"], np.mean(distances), what="distributions")
    close(got["distance of the distributions, worst band"], np.max(distances), what="distributions")
    vectors = [np.linalg.eigh(np.cov(v, rowvar=False))[1][:, ::-1] for v in (x, y)]
    for k in range(1, 5):
        expected = np.degrees(scipy.linalg.subspace_angles(vectors[0][:, :k], vectors[1][:, :k])).max()
        close(got[f"largest angle between the first {k} eigenvectors"], expected, 1e-6, "angles")
    same = analyze(folder, "scorecard", a, "--other", a)["scores"]
    program.check(all(abs(s["value"] - s["where_alike"]) < 2e-6 for s in same), same)
    # Units in other words are the same unit; others are refused, by a way out that helps.
    unit = write_cube(folder / "unit.img", one, dtype="f8", data_units="uW cm-2 sr-1 nm-1")
    worded = write_cube(folder / "worded.img", one, dtype="f8", data_units="Radiance (uW cm-2 sr-1 nm-1)")
    analyze(folder, "scorecard", unit, "--other", worded)
    other = write_cube(folder / "other.img", one, dtype="f8", data_units="W m-2 sr-1 um-1")
    program.refused(
        *("analyze", "scorecard", unit, "--other", other, "-o", folder / "no"), status=2, says=["correct 'data units'"]
    )
    # A name of a spectrum makes no library of a cube: its lists go by bands.
    stray = write_cube(
        folder / "stray.img", one[:3, :3, :5], dtype="f8", spectra_names="{a}", data_gain_values="{1, 2, 3}",
        wavelength_units="nm", wavelength="{400, 500, 600}",
    )
    found = analyze(folder, "statistics", stray)
    close(found["regions"][0]["mean"], one[:3, :3, :5].mean((0, 1)), what="stray")
    few = write_cube(folder / "few.img", one[..., :5], dtype="f8")
    program.refused("analyze", "scorecard", a, "--other", few, "-o", folder / "no", status=2, says=["must be the same"])


BOX = """[[box]]
material = "grey"
size_m = [6.0, 6.0, 12.0]
position_m = [4.0, -3.0, 0.0]
"""


def located(folder):
    """Two cameras of other scales, places and headings over level ground: the plane's own map from one to the other.
    Where a box stands, one sees its far side's ground and the other does not."""
    one = camera("a", 60, 50, altitude_agl_m=500.0)
    two = camera("b", 240, 200, altitude_agl_m=500.0, center_m="[7.0, -4.0]", heading_deg=30.0, gsd_m=0.3)
    (folder / "two.toml").write_text(with_origin(HEAD) + BOX + one + two)
    program.run("render", folder / "two.toml", "-o", folder / "two", "--overwrite", "-q", "-q")
    for file in ("truth.img", "location.img"):
        numbers = analyze(folder, "locate", folder / f"two/a/{file}", "--other", folder / f"two/b/{file}", picture=True)
        sample, line = layers(folder, "locate")
        y, x = np.mgrid[0:50, 0:60].astype(float)
        east, north = x - 29.5, 24.5 - y
        turn = np.radians(30)
        right = (east - 7) * np.cos(turn) - (north + 4) * np.sin(turn)
        up = (east - 7) * np.sin(turn) + (north + 4) * np.cos(turn)
        s, l = right / 0.3 + 119.5, 99.5 - up / 0.3
        inside = (s > 0) & (s < 239) & (l > 0) & (l < 199)
        box = (np.abs(east - 4) < 6) & (np.abs(north + 3) < 6)
        program.check(np.isfinite(sample[inside & ~box]).all() and np.isnan(sample[(s < -1) | (s > 240)]).all())
        off = np.hypot(sample - s, line - l)[inside & ~box].max()
        program.check(off < 0.02, file, off)  # means of 64 hits in floats
        program.check(numbers["found"] == np.isfinite(sample).sum(), numbers["found"])
        close(numbers["sample"]["per_sample"], np.cos(turn) / 0.3, 1e-3, "per sample")
    program.refused(
        "analyze",
        "locate",
        folder / "two/a/truth.img",
        "--other",
        folder / "two/b/location.img",
        "-o",
        folder / "no",
        status=2,
        says=["truth.img of both"],
    )
    program.refused(
        "analyze",
        "locate",
        folder / "two/a/radiance.img",
        "--other",
        folder / "two/b/truth.img",
        "-o",
        folder / "no",
        status=2,
        says=["no layers"],
    )


def places(folder, name, x, y, z):
    """A truth cube of these places, [line][sample]."""
    cube = np.stack([x, y, z], 2)
    return write_cube(folder / f"{name}.img", cube, dtype="f8", band_names="{x_m [m], y_m [m], z_m [m]}")


def sparse_and_hidden(folder):
    """Of an image that mostly sees no ground what it sees is found; of oblong pixels too. Ground behind a block's roof
    is not found, whatever the way is from roof to ground."""
    y, x = np.mgrid[0:40, 0:60].astype(float)
    first = places(folder, "first", x, y, 0 * x)
    wide_y, wide_x = np.mgrid[-200:240, -200:260].astype(float)
    outside = (wide_x < -1) | (wide_x > 60) | (wide_y < -1) | (wide_y > 40)
    for hole in (np.where(outside, np.nan, wide_x), wide_x):
        second = places(folder, "second", hole, np.where(np.isnan(hole), np.nan, wide_y), 0 * hole)
        found = analyze(folder, "locate", first, "--other", second, picture=True)
        sample, line = layers(folder, "locate")
        program.check(found["found"] == x.size and np.allclose(sample, x + 200) and np.allclose(line, y + 200), found)
    long_y, long_x = np.mgrid[-1:3, -5:65].astype(float)
    second = places(folder, "second", long_x, 20 * long_y, 0 * long_x)
    analyze(folder, "locate", first, "--other", second, picture=True)
    sample, line = layers(folder, "locate")
    program.check(np.allclose(sample, x + 5) and np.allclose(line, y / 20 + 1))
    lines, samples = np.mgrid[0:40, 0:100].astype(float)
    roof = (samples >= 50) & (samples < 70)
    second = places(folder, "second", samples + 10 * (samples >= 70), lines, 30.0 * roof)
    y, x = np.mgrid[0:40, 0:105].astype(float)
    analyze(folder, "locate", places(folder, "first", x, y, 0 * x), "--other", second, picture=True)
    sample, _ = layers(folder, "locate")
    hidden = (x >= 52) & (x <= 78)
    program.check(np.isnan(sample[hidden]).all(), np.argwhere(np.isfinite(sample) & hidden)[:4])
    program.check(np.allclose(sample[x < 50], x[x < 50]) and np.allclose(sample[x > 80], x[x > 80] - 10))


with tempfile.TemporaryDirectory() as name:
    top = pathlib.Path(name)
    of_other_sizes(top, *shifts(top))
    scores(top)
    located(top)
    sparse_and_hidden(top)
    print(f"analyze compare: {program.checks} checks")
