"""S44: a camera's detector: variance against signal, photon transfer, digital numbers, fixed pattern, tables of noise.

Allowed: 1 % of a variance (issue's bar). A sample variance of 4e5 values is known to sqrt(2/N) = 0.22 %, so that 1 % is
4.5 standard errors."""

import math
import os
import pathlib
import sys
import tempfile

import numpy as np

from analysis_kit import write_cube
from driver import Program, envi, header_of

program = Program(sys.argv[1])
PLANCK, LIGHT, BOLTZMANN = 6.62607015e-34, 299792458.0, 1.380649e-23
LEVELS = np.array([0.0, 2.0, 10.0, 40.0, 150.0])  # W m-2 sr-1 um-1
LINES, SAMPLES = 1000, 400
BANDS = np.array([500.0, 900.0, 1300.0])
FWHM = 12.0
OPTICS = """aperture_diameter_mm = 30.0
integration_time_ms = 0.8
at_nm = [500.0, 1300.0]
transmission = [0.5, 0.3]
quantum_efficiency = [0.8, 0.35]
"""
IFOV = 1e-3


def simulation(folder, detector, kind="framing", lines=LINES, samples=SAMPLES, bands=None, grid=1):
    """A flat scene whose camera has the detector."""
    bands = (
        bands or f"{{ first_nm = {BANDS[0]}, step_nm = {BANDS[1] - BANDS[0]}, count = {len(BANDS)}, fwhm_nm = {FWHM} }}"
    )
    path = folder / "scene.toml"
    path.write_text(f"""format = 1
seed = 11
sky_directions = 2
[atmosphere]
model = "none"
[time.sun]
zenith_deg = 30.0
azimuth_deg = 90.0
day_of_year = 180
[[material]]
name = "ground"
reflectance = 0.3
[[plane]]
material = "ground"
size_m = [4000.0, 4000.0]
[[instrument]]
name = "camera"
kind = "{kind}"
pixels = {samples}
lines = {lines}
altitude_agl_m = 1000.0
ifov_mrad = {1e3 * IFOV}
samples = {{ grid = [{grid}, {grid}] }}
bands = {bands}
[instrument.detector]
{detector}
""")
    return path


def levels_cube(folder):
    """The levels side by side: a fifth of the samples each."""
    light = np.repeat(LEVELS, SAMPLES // len(LEVELS))[None, :, None] * np.ones((LINES * 5, 1, len(BANDS)))
    return write_cube(
        folder / "light.img", light, wavelength_units="Nanometers", wavelength="{500, 900, 1300}", fwhm="{12, 12, 12}"
    )


def measured(folder, cube, file, *more):
    """[line][sample][band] as stored, header, table of the bands."""
    program.run("noise", cube, file, "-o", folder / "noisy", "--overwrite", *more)
    header, values = envi(folder / "noisy", "measured")
    return values, header, np.genfromtxt(folder / "noisy/detector.csv", delimiter=",", names=True)


def levels_of(values):
    """[level] of [pixel][band]."""
    part = SAMPLES // len(LEVELS)
    return [values[:, k * part : (k + 1) * part].reshape(-1, len(BANDS)).astype("f8") for k in range(len(LEVELS))]


def electrons(um, fwhm_um):
    """Per W m-2 sr-1 um-1."""
    area, solid = math.pi / 4 * 0.030**2, IFOV**2
    part = np.clip((um - 0.5) / 0.8, 0, 1)
    efficiency = (0.5 - 0.2 * part) * (0.8 - 0.45 * part)
    width = fwhm_um * math.sqrt(math.pi / (4 * math.log(2)))
    return area * solid * 0.8e-3 * efficiency * width * um * 1e-6 / (PLANCK * LIGHT)


def near(found, expected, part, *what):
    program.within(found / expected - 1, part, *what, found, expected)


def photons(folder, cube):
    """Shot noise, dark current and reading, from the optics; radiance, then digital numbers."""
    k = electrons(BANDS / 1e3, FWHM / 1e3)
    dark, read = 25000 * 0.8e-3, 25.0
    noise = "dark_e_s = 25000.0\nread_noise_e = 25.0\n"
    file = simulation(folder, OPTICS + noise, lines=5 * LINES)
    values, header, table = measured(folder, cube, file)
    program.check(header["data type"] == "4", header)
    for b in range(len(BANDS)):
        near(table["electrons_per_radiance"][b], k[b], 1e-9, "electrons")
    for level, pixels in zip(LEVELS, levels_of(values)):
        for b in range(len(BANDS)):
            variance = (k[b] * level + dark + read**2) / k[b] ** 2
            near(pixels[:, b].var(ddof=1), variance, 0.01, "variance", level, b)
            error = math.sqrt(variance / len(pixels))
            program.within(pixels[:, b].mean() - level, 5 * error + 1e-6 * level, "mean", level, b)

    # Photon transfer: variance against mean in digital numbers is a line of slope 1 / gain.
    file = simulation(folder, OPTICS + noise + "bits = 14\ngain_e_dn = 30.0\noffset_dn = 100.0\n", lines=5 * LINES)
    values, header, table = measured(folder, cube, file)
    program.check(header["data type"] == "12" and values.max() <= 2**14 - 1, header)
    mean, variance = [], []
    for level, pixels in zip(LEVELS, levels_of(values)):
        for b in range(len(BANDS)):
            e = k[b] * level + dark
            if e > 30 * (2**14 - 100) * 0.98:
                continue
            mean.append(pixels[:, b].mean()), variance.append(pixels[:, b].var(ddof=1))
            near(variance[-1], (e + read**2) / 30**2 + 1 / 12, 0.01, "variance, DN", level, b)
    slope, start = np.polyfit(mean, variance, 1, w=1 / np.array(variance))
    near(1 / slope, 30.0, 0.01, "gain by photon transfer")
    gain = np.array([float(g) for g in header["data gain values"]])
    offset = np.array([float(o) for o in header["data offset values"]])
    for b in range(len(BANDS)):
        near(gain[b], 30 / k[b], 1e-6, "calibration")
        near(table["gain"][b], gain[b], 1e-6, "table of it")
    back = values.astype("f8") * gain + offset
    for level, pixels in zip(LEVELS[:3], levels_of(back)):
        for b in range(len(BANDS)):
            error = pixels[:, b].std() / math.sqrt(len(pixels))
            program.within(pixels[:, b].mean() - level, 5 * error + 0.02 * gain[b], "read back", level, b)
    return values


def invariance(folder, cube, values):
    file = folder / "scene.toml"
    for threads in (1, 2):
        again, _, _ = measured(folder, cube, file, "--threads", threads)
        program.check(np.array_equal(again, values), "threads", threads)
    other, _, _ = measured(folder, cube, file, "--seed", 12)
    program.check(not np.array_equal(other, values), "another seed")
    near(other[:, -1, 0].mean(), values[:, -1, 0].mean(), 0.01, "the same statistics")


def tables(folder, cube):
    """Ratios at two radiances come back at both, and as the line of the variance says between; nedl is nedl."""
    (folder / "noise.csv").write_text("wavelength_nm,radiance,snr\n400,2,30\n400,150,500\n1500,2,20\n1500,150,300\n")
    values, _, table = measured(folder, cube, simulation(folder, 'noise = "noise.csv"', lines=5 * LINES))
    noise = [[(2 / 30) ** 2, (150 / 500) ** 2], [(2 / 20) ** 2, (150 / 300) ** 2]]
    slope = [(high - low) / 148 for low, high in noise]
    dark = [math.sqrt(low - 2 * step) for (low, _), step in zip(noise, slope)]
    for level, pixels in zip(LEVELS, levels_of(values)):
        for b in range(len(BANDS)):
            variance = np.interp(BANDS[b], [400, 1500], dark) ** 2 + np.interp(BANDS[b], [400, 1500], slope) * level
            near(pixels[:, b].var(ddof=1), variance, 0.01, "table", level, b)
    (folder / "nedl.csv").write_text("wavelength_nm,nedl\n400,0.05\n1500,0.2\n")
    values, _, table = measured(folder, cube, simulation(folder, 'noise = "nedl.csv"', lines=5 * LINES))
    for pixels in levels_of(values):
        for b in range(len(BANDS)):
            near(pixels[:, b].std(ddof=1), np.interp(BANDS[b], [400, 1500], [0.05, 0.2]), 0.005, "nedl", b)
    # ISOFIT's coefficients, in uW cm-2 sr-1 nm-1: one of them is 10 W m-2 sr-1 um-1.
    (folder / "abc.csv").write_text("wavelength_nm,a,b,c,rmse\n400,0.01,2.5,-0.002,0\n1500,0.004,3,0.001,0\n")
    values, _, _ = measured(folder, cube, simulation(folder, 'noise = "abc.csv"', lines=5 * LINES))
    for level, pixels in zip(LEVELS, levels_of(values)):
        for b in range(len(BANDS)):
            a0, b0, c0 = (np.interp(BANDS[b], [400, 1500], of) for of in ([0.01, 0.004], [2.5, 3], [-0.002, 0.001]))
            near(pixels[:, b].std(ddof=1), 10 * abs(a0 * math.sqrt(b0 + level / 10) + c0), 0.005, "abc", level, b)
    shared = os.environ.get("RAYCUBE_SHARED")
    for instrument in ("aviris_classic", "emit") if shared else ():
        file = pathlib.Path(shared) / f"data/sensors/{instrument}_noise_coefficients.csv"
        measured(folder, cube, simulation(folder, f'noise = "{file}"', lines=5 * LINES))
    if not shared:
        print("noise: RAYCUBE_SHARED is not set: coefficients of real instruments were not read", file=sys.stderr)
    values, _, _ = measured(folder, cube, simulation(folder, "snr = 100.0", lines=5 * LINES))
    for pixels in levels_of(values):
        for b in range(len(BANDS)):
            near(pixels[:, b].std(ddof=1), LEVELS.mean() / 100, 0.005, "snr", b)


def nothing_known(folder):
    """Pixels without light: not finite, or the header's ignore value. Gains and scale factors. Two cameras."""
    light = np.full((40, 50, 1), 5000.0)
    light[3, 4], light[20:] = np.nan, -9999
    cube = write_cube(folder / "some.img", light, reflectance_scale_factor=100, data_ignore_value=-9999)
    one = "{ first_nm = 500.0, step_nm = 1.0, count = 1, fwhm_nm = 12.0 }"
    values, header, _ = measured(folder, cube, simulation(folder, "snr = 50.0", "framing", 40, 50, one))
    program.check("data ignore value" not in header and "reflectance scale factor" not in header, header)
    known = np.ones((40, 50), bool)
    known[3, 4], known[20:] = False, False
    program.check(np.array_equal(np.isfinite(values[..., 0]), known), "unknown stays unknown")
    near(values[..., 0][known].std(), 1.0, 0.1, "noise of 50 / 50, by what is known")
    near(values[..., 0][known].mean(), 50.0, 0.01, "scaled")
    digital = simulation(folder, OPTICS + "full_well_e = 1e6\nbits = 12\n", "framing", 40, 50, one)
    program.refused("noise", cube, digital, "-o", folder / "no", status=2, says=["which digital numbers cannot hold"])
    (folder / "short.csv").write_text("wavelength_nm,nedl\n1000,0.05\n1500,0.2\n")
    short = simulation(folder, 'noise = "short.csv"', "framing", 40, 50, one)
    program.refused("noise", cube, short, "-o", folder / "no", status=2, says=["reaches from 1000 to 1500 nm"])
    text = simulation(folder, "snr = 50.0", "framing", 40, 50, one).read_text()
    (folder / "other.toml").write_text(text.replace('"camera"', '"second"'))
    other, _, _ = measured(folder, cube, folder / "other.toml")
    program.check(not np.array_equal(other[known], values[known]), "each camera has noise of its own")


def units(folder):
    """The same light in other units is measured the same: its numbers are converted by hand here."""
    light = np.tile(LEVELS, 8)[None, :, None] * np.ones((20, 1, 1))
    one = "{ first_nm = 500.0, step_nm = 1.0, count = 1, fwhm_nm = 12.0 }"
    file = simulation(folder, OPTICS + "dark_e_s = 100.0\nread_noise_e = 30.0\n", "framing", 20, 40, one)
    right, header, _ = measured(folder, write_cube(folder / "w.img", light, data_units="W m-2 sr-1 um-1"), file)
    program.check(header["data units"] == "W m-2 sr-1 um-1", header)
    for unit, ours in (
        ("uW cm-2 sr-1 nm-1", 10),
        ("microwatts per square centimeter per nanometer per steradian", 10),
        ("mW m-2 sr-1 nm-1", 1),
        ("W/(m^2 sr nm)", 1000),
        ("uW/m^2/sr/nm", 1e-3),
    ):
        cube = write_cube(folder / "other.img", light / ours, dtype="f8", data_units=unit)
        values, header, _ = measured(folder, cube, file)
        program.check(header["data units"] == "W m-2 sr-1 um-1", unit, header)
        program.check(np.abs(values - right).max() < 1e-4, unit, np.abs(values - right).max())
    done = program.run("noise", write_cube(folder / "other.img", light), file, "-o", folder / "noisy", "--overwrite")
    program.check("names no data units" in done.stderr, done.stderr)
    for unit in ("W m-2 sr-1", "reflectance"):
        cube = write_cube(folder / "other.img", light, data_units=unit)
        program.refused("noise", cube, file, "-o", folder / "no", status=2, says=[f"found '{unit}'"])


def fixed_pattern(folder):
    """What stays: columns of a pushbroom, pixels of a framing camera."""
    light = write_cube(
        folder / "even.img", np.full((400, 2000, 1), 50.0), wavelength="{500}", wavelength_units="Nanometers"
    )
    bands = "{ first_nm = 500.0, step_nm = 1.0, count = 1, fwhm_nm = 12.0 }"
    detector = OPTICS + "prnu_percent = 2.0\ndsnu_e = 3000.0\n"
    k = electrons(np.array([0.5]), FWHM / 1e3)[0]
    signal = k * 50
    for kind in ("pushbroom", "framing"):
        values, _, _ = measured(folder, light, simulation(folder, detector, kind, 400, 2000, bands))
        column = values[..., 0].astype("f8").mean(0) - 50
        expected = math.hypot(0.02 * signal, 3000) / k
        if kind == "pushbroom":  # 2000 elements: their spread is known to 1.6 %
            near(column.std(ddof=1), expected, 0.06, kind)
            near(values[..., 0].astype("f8").std(0).mean(), math.sqrt(signal) / k, 0.01, "the rest is shot noise")
        else:
            near(column.std(ddof=1), math.hypot(expected, math.sqrt(signal) / k) / 20, 0.06, kind)
            near((values[..., 0].astype("f8") - 50).std(), math.hypot(expected, math.sqrt(signal) / k), 0.01, kind)
    well = "bad_pixels_percent = 1.0\nfull_well_e = 600000.0\nbits = 12\n"
    values, header, _ = measured(folder, light, simulation(folder, OPTICS + well, "pushbroom", 400, 2000, bands))
    rows = [line.split(",") for line in (folder / "noisy/bad_elements.csv").read_text().splitlines()[1:]]
    program.between(8, len(rows), 36, "bad elements")  # 20 expected: a binomial's 4 standard deviations
    for band, line, sample, says in rows:
        program.check(line == "all" and np.all(values[:, int(sample)] == (0 if says == "0" else 4095)), sample, says)
    good = np.ones(2000, bool)
    good[[int(row[2]) for row in rows]] = False
    program.check(signal < 600000 and np.all((values[:, good] > 0) & (values[:, good] < 4095)), "the others")
    bright = write_cube(
        folder / "bright.img", np.full((50, 2000, 1), 1e4), wavelength="{500}", wavelength_units="Nanometers"
    )
    done = program.run(
        "noise",
        bright,
        simulation(folder, OPTICS + "full_well_e = 600000.0\nbits = 12\n", "pushbroom", 50, 2000, bands),
        "-o",
        folder / "noisy",
        "--overwrite",
    )
    program.check("saturated in 100000 of 100000 values" in done.stderr, done.stderr)


def temperatures(folder):
    """NEdT of a thermal band: sigma over the slope of Planck's law at 300 K."""
    light = write_cube(
        folder / "warm.img", np.full((10, 10, 1), 9.0), wavelength="{10000}", wavelength_units="Nanometers"
    )
    (folder / "nedl.csv").write_text("wavelength_nm,nedl\n10000,0.03\n")
    bands = "{ first_nm = 10000.0, step_nm = 1.0, count = 1, fwhm_nm = 500.0 }"
    _, _, table = measured(folder, light, simulation(folder, 'noise = "nedl.csv"', "framing", 10, 10, bands))
    um, kelvin = 10e-6, 300.0

    def planck(t):
        return 2 * PLANCK * LIGHT**2 / um**5 / math.expm1(PLANCK * LIGHT / (um * BOLTZMANN * t)) * 1e-6

    near(float(table["nedt_300K_K"]), 0.03 / ((planck(kelvin + 0.5) - planck(kelvin - 0.5))), 1e-5, "NEdT")


def rendered(folder):
    """A render leaves what `noise` makes of its radiance, to the bit, whatever tiles it was made of."""
    detector = OPTICS + "dark_e_s = 100.0\nread_noise_e = 30.0\nprnu_percent = 0.5\nfull_well_e = 1e6\nbits = 12\n"
    file = simulation(folder, detector, "pushbroom", 70, 90, grid=2)
    for memory in ("64M", "2G"):
        program.run("render", file, "-o", folder / "out", "--overwrite", "-q", "-q", "--memory", memory)
        stored = (folder / "out/camera/measured.img").read_bytes()
        program.run("noise", folder / "out/camera/radiance.img", file, "-o", folder / "noisy", "--overwrite")
        program.check(stored == (folder / "noisy/measured.img").read_bytes(), "render and stored cube", memory)
        program.check(
            (folder / "out/camera/detector.csv").read_bytes() == (folder / "noisy/detector.csv").read_bytes(), "table"
        )
    header = header_of(folder / "out/camera/measured.hdr")
    radiance, dn = envi(folder / "out/camera", "radiance")[1], envi(folder / "out/camera", "measured")[1]
    gain, offset = (np.array([float(v) for v in header[key]]) for key in ("data gain values", "data offset values"))
    program.check(np.abs((dn * gain + offset) / radiance - 1).max() < 0.3, "the light")
    program.run("info", folder / "out/camera/measured.img")


def refusals(folder, cube):
    for detector, says in (
        ("", "exactly one of snr, noise, aperture_diameter_mm"),
        ("snr = 100.0\nbits = 12", "'bits' means nothing with snr"),
        ("aperture_diameter_mm = 30.0", "goes with integration_time_ms"),
        (OPTICS + "bits = 12", "need gain_e_dn, or full_well_e"),
        (OPTICS + "gain_e_dn = 12.0", "means nothing with no bits"),
        (OPTICS.replace("[0.8, 0.35]", "[0.8, 0.35, 0.2]"), "one for each of at_nm"),
        (OPTICS + "quantum_efficency = 0.5", "quantum_efficiency"),
        ('noise = "none.csv"', "none.csv"),
    ):
        program.refused("scene", "check", simulation(folder, detector), status=2, says=[says], messages=1)
    (folder / "falls.csv").write_text("wavelength_nm,radiance,snr\n500,2,1\n500,150,1e6\n")
    program.refused(
        "noise",
        cube,
        simulation(folder, 'noise = "falls.csv"', lines=5 * LINES),
        "-o",
        folder / "no",
        status=2,
        says=["no reading and shot noise"],
    )
    program.refused(
        "noise", cube, simulation(folder, "snr = 9.0"), "-o", folder / "no", status=2, says=["must be the same"]
    )


with tempfile.TemporaryDirectory() as name:
    top = pathlib.Path(name)
    light_cube = levels_cube(top)
    invariance(top, light_cube, photons(top, light_cube))
    tables(top, light_cube)
    nothing_known(top)
    units(top)
    fixed_pattern(top)
    temperatures(top)
    rendered(top)
    refusals(top, light_cube)
    print(f"noise: {program.checks} checks")
