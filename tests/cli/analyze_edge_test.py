"""S48: `raycube analyze edge` on edges whose transfer is known in closed form, and on one that raycube rendered.

An image of a step under a blur of transfer T(f) and pixels of a box has, along the edge's normal at an angle a to the
rows, the MTF T(f) sinc(f cos a) sinc(f sin a). Allowed: 0.02 up to Nyquist (issue's bar, S48)."""

import math
import pathlib
import sys
import tempfile

import numpy as np
from scipy.special import erf

from analysis_kit import Analysis, layers, values, write_cube
from driver import Program, seed
from optics_kit import HEAD, camera, panel, render

program = Program(sys.argv[1])
analyze = Analysis(program).run
MOST_OFF = 0.02
FINE = 12  # points across a pixel over which its box is summed: 1/12 of a pixel takes 0.0012 from the MTF at Nyquist


def airy(f, cutoff):
    """Transfer of a round aperture without obscuration, cut off at `cutoff` cycles per pixel."""
    x = np.clip(f / cutoff, 0, 1)
    return 2 / np.pi * (np.arccos(x) - x * np.sqrt(1 - x * x))


def step_of(transfer):
    """Edge spread of a blur with a transfer, of distances: 1/2 + int T(f) sin(2 pi f d) / (pi f) df."""
    at = np.linspace(-30, 30, 12001)
    f = (np.arange(6000) + 0.5) / 1000
    table = 0.5 + np.sin(2 * np.pi * np.outer(at, f)) @ (transfer(f) / (np.pi * f)) / 1000
    return lambda d: np.interp(d, at, table)


#: Name, edge spread, transfer along the normal at an angle.
BLURS = [
    ("box", lambda d: (d > 0) + 0.5 * (d == 0), lambda f, a: np.ones_like(f)),
    (
        "gaussian",
        lambda d: 0.5 * (1 + erf(d / (0.5 * math.sqrt(2)))),
        lambda f, a: np.exp(-2 * np.pi**2 * 0.5**2 * f * f),
    ),
    (
        "wide gaussian",
        lambda d: 0.5 * (1 + erf(d / (1.1 * math.sqrt(2)))),
        lambda f, a: np.exp(-2 * np.pi**2 * 1.1**2 * f * f),
    ),
    ("airy", step_of(lambda f: airy(f, 0.9)), lambda f, a: airy(f, 0.9)),
]
SMEAR_PX = 1.5  # along samples


def image_of(spread, angle, size=64, smear=0.0):
    """Pixels of an edge through the middle, at an angle to the columns; fine points averaged over pixels and smear."""
    offset = (np.arange(FINE) + 0.5) / FINE - 0.5
    if smear:  # by a table at steps h of 0.005 px: h^2 / 8 of the second derivative, 1 / sigma^2 at most, are 1e-5
        along = ((np.arange(FINE) + 0.5) / FINE - 0.5) * smear
        at = np.linspace(-60, 60, 24001)
        table = spread(at[:, None] + along * math.cos(angle)).mean(1)
        spread = lambda d: np.interp(d, at, table)
    x = y = (np.arange(size)[:, None] + offset).ravel()
    d = (x[None, :] - size / 2 - 0.21) * math.cos(angle) + (y[:, None] - size / 2) * math.sin(angle)
    return 3 + 40 * spread(d).reshape(size, FINE, size, FINE).mean((1, 3))


def off(one, frequency, expected):
    below = frequency <= 0.5
    return np.abs(values(one["mtf"]) - expected)[below].max()


def closed_forms(folder):
    """A band for each turn of each edge: across samples or lines, rising or falling."""
    worst = 0
    for degrees in (3, 5, 8, 12, 16, 20):
        a = math.radians(degrees)
        for name, spread, transfer in BLURS:
            image = image_of(spread, a)
            bands = np.stack([image, image.T, image[:, ::-1], image[::-1].T], 2)
            numbers = analyze(
                folder, "edge", write_cube(folder / "edge.img", bands, dtype="f8"), "--region", "e=0:63,0:63"
            )
            f = np.asarray(numbers["frequency_cycles_per_px"])
            expected = transfer(f, a) * np.sinc(f * math.cos(a)) * np.sinc(f * math.sin(a))
            for one in numbers["edges"]:
                worst = max(worst, off(one, f, expected))
                program.check(off(one, f, expected) <= MOST_OFF, name, degrees, one["band"], off(one, f, expected))
                program.check(abs(abs(one["angle_deg"]) - degrees) < 0.1, name, degrees, one["angle_deg"])
        moved = image_of(BLURS[1][1], a, smear=SMEAR_PX)  # along samples: across the edge, and along it
        bands = np.stack([moved, moved.T], 2)
        numbers = analyze(folder, "edge", write_cube(folder / "edge.img", bands, dtype="f8"), "--region", "e=0:63,0:63")
        expected = BLURS[1][2](f, a) * np.sinc(f * math.cos(a)) * np.sinc(f * math.sin(a))
        for one in numbers["edges"]:
            off_smear = off(one, f, expected * np.abs(np.sinc(f * SMEAR_PX * math.cos(a))))
            worst = max(worst, off_smear)
            program.check(off_smear <= MOST_OFF, "smear", degrees, off_smear)
    return worst


def iso_12233(image):
    """The standard's reader of a slanted edge (ISO 12233:2017, annex D), rows across it: centroids of the rows' slopes,
    a line through them, quarter-pixel bins along it, their slope under a Hamming window, its transform over what the
    difference of neighbouring bins takes. Cycles per pixel along the row, and MTF."""
    lines, samples = image.shape
    column = np.arange(samples) + 0.5

    def centroids(guess):
        slope = np.gradient(image, axis=1)
        out = []
        for row in range(lines):
            window = np.hamming(2 * samples)[np.clip((column - guess[row] + samples).astype(int), 0, 2 * samples - 1)]
            weight = slope[row] * window
            out.append((weight * column).sum() / weight.sum())
        return np.array(out)

    place = centroids(np.full(lines, samples / 2))
    for _ in range(2):
        fit = np.polyfit(np.arange(lines), place, 1)
        place = centroids(np.polyval(fit, np.arange(lines)))
    fit = np.polyfit(np.arange(lines), place, 1)
    whole = int(lines // (1 / abs(fit[0])) * (1 / abs(fit[0]))) if abs(fit[0]) * lines >= 1 else lines
    shift = column[None, :] - 0.5 - np.polyval(fit, np.arange(whole))[:, None]
    bins = np.floor(4 * (shift - shift.min())).astype(int)
    count = np.bincount(bins.ravel())
    esf = np.bincount(bins.ravel(), image[:whole].ravel())[count > 0] / count[count > 0]
    line_spread = np.gradient(esf)
    middle = (np.abs(line_spread) * np.arange(len(esf))).sum() / np.abs(line_spread).sum()
    reach = int(min(middle, len(esf) - 1 - middle))
    line_spread = line_spread[int(middle) - reach : int(middle) + reach + 1] * np.hamming(2 * reach + 1)
    mtf = np.abs(np.fft.rfft(line_spread))
    f = np.fft.rfftfreq(len(line_spread), 0.25)
    with np.errstate(divide="ignore", invalid="ignore"):
        taken = np.where(f == 0, 1, np.sin(2 * np.pi * f / 4) / (2 * np.pi * f / 4))  # of a central difference
    return f, mtf / mtf[0] / taken


def as_the_standard_reads(folder):
    """Where the standard's frequency is along rows, ours along the edge's normal: f cos a."""
    worst = 0
    for degrees in (4, 7, 11):
        a = math.radians(degrees)
        for name, spread, _ in BLURS:
            image = image_of(spread, a, size=96)
            numbers = analyze(
                folder, "edge", write_cube(folder / "edge.img", image[..., None], dtype="f8"), "--region", "e=0:95,0:95"
            )
            f, ours = np.asarray(numbers["frequency_cycles_per_px"]), values(numbers["edges"][0]["mtf"])
            at, theirs = iso_12233(image)
            below = (at > 0) & (at <= 0.5)
            off = np.abs(np.interp(at[below] / math.cos(a), f, ours) - theirs[below]).max()
            worst = max(worst, off)
            program.check(off <= MOST_OFF, name, degrees, off)
    return worst


def noisy(folder):
    """1 % of noise of the step: the mean over bands is that of the edge without."""
    rng, a = np.random.default_rng(seed(5)), math.radians(7)
    image = image_of(BLURS[1][1], a)
    bands = image[..., None] + rng.normal(0, 0.4, (*image.shape, 24))
    numbers = analyze(folder, "edge", write_cube(folder / "edge.img", bands, dtype="f8"), "--region", "e=0:63,0:63")
    f = np.asarray(numbers["frequency_cycles_per_px"])
    expected = BLURS[1][2](f, a) * np.sinc(f * math.cos(a)) * np.sinc(f * math.sin(a))
    mean = np.mean([values(one["mtf"]) for one in numbers["edges"]], axis=0)
    program.between(0, np.abs(mean - expected)[f <= 0.5].max(), MOST_OFF, "noisy edge")
    return np.abs(mean - expected)[f <= 0.5].max()


def rendered(folder):
    """A panel's edge under a camera with a point spread: pixel box and Gaussian."""
    bands = "first_nm = 550.0, step_nm = 100.0, count = 2"
    spread = {"samples": "{ grid = [48, 48] }", "psf": "{ sigma_px = 0.45, support_px = 5.0 }"}
    _, out = render(program, folder, HEAD + panel("bright", (200, 200), (100, 0), 6.0) + camera(bands=bands, **spread))
    numbers = analyze(folder, "edge", out / "radiance.img", "--region", "e=0:63,0:63", picture=True)
    f, a = np.asarray(numbers["frequency_cycles_per_px"]), math.radians(6)
    expected = np.exp(-2 * np.pi**2 * 0.45**2 * f * f) * np.sinc(f * math.cos(a)) * np.sinc(f * math.sin(a))
    for one in numbers["edges"]:
        program.check(off(one, f, expected) <= MOST_OFF, "rendered", off(one, f, expected))
    program.check((folder / "edge/edge.png").read_bytes()[:4] == b"\x89PNG", "picture")
    return off(numbers["edges"][0], f, expected)


def refusals(folder):
    flat = write_cube(folder / "flat.img", np.full((32, 32, 1), 7.0))
    straight = write_cube(
        folder / "straight.img", np.where(np.arange(32) > 15, 9.0, 1.0)[None, :, None] + np.zeros((32, 1, 1))
    )
    hole = np.where(np.arange(32) > 15, 9.0, 1.0)[None, :, None] + np.zeros((32, 1, 1))
    hole[3, 3] = np.nan
    for cube, region, says in (
        (flat, "e=0:31,0:31", "has no edge"),
        (straight, "e=0:31,0:31", "degrees to the pixels"),
        (straight, "e=0:5,0:31", "8 x 8 pixels or more"),
        (write_cube(folder / "hole.img", hole), "e=0:31,0:31", "line 3, sample 3 is not finite"),
    ):
        program.refused("analyze", "edge", cube, "--region", region, "-o", folder / "no", status=2, says=[says])
    for degrees, lines in (
        (math.degrees(math.atan(0.5)), 64),
        (math.degrees(math.atan(1 / 3)), 64),
        (0.6, 40),
        (3, 12),
    ):
        image = image_of(BLURS[1][1], math.radians(degrees))[:lines]
        cube = write_cube(folder / "few.img", image[..., None], dtype="f8")
        program.refused(
            "analyze",
            "edge",
            cube,
            "--region",
            f"e=0:63,0:{lines - 1}",
            "-o",
            folder / "no",
            status=2,
            says=["pixels apart along"],
        )
    program.refused("analyze", "edge", flat, "-o", folder / "no", status=2, says=["found 0"])


with tempfile.TemporaryDirectory() as name:
    top = pathlib.Path(name)
    print(f"analyze edge: worst of closed forms {closed_forms(top):.4f} (limit {MOST_OFF})")
    print(f"analyze edge: worst against the standard's reader {as_the_standard_reads(top):.4f} (limit {MOST_OFF})")
    print(f"analyze edge: mean of noisy bands {noisy(top):.4f}, rendered {rendered(top):.4f}")
    refusals(top)
    print(f"analyze edge: {program.checks} checks")
