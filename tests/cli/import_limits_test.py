#!/usr/bin/env python3
"""What an imported table cannot know is not made up: one line of sight is not every line of sight, means over channels
are not a spectrum.
The .chn is written here with a gas band in one channel of ten. Oracle: its own columns,
    L = path + rho (A + B) (COSSUN TOA_SUN / PI) / (1 - rho S).
Tolerances: the columns' seven digits and the cube's single precision. usage: import_limits_test.py RAYCUBE"""

import math
import pathlib
import sys
import tempfile

import numpy

from driver import Program, envi, plate, record

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused
WIDTHS = (12, 3, 3, 13, 13, 8, 13, 9, 9, 9, 9) + (13,) * 10 + (10,) * 5
CENTERS, FWHM = tuple(720.0 + 10 * i for i in range(10)), 9.5  # nm
SUN, REFLECTANCE, DEEP = 60.0, 0.3, 4
# path (W m-2 sr-1 um-1), T sun to target to sensor, A, B, S, T view: a gas band in the channel at 760 nm
AIR = [(12.0 - 0.3 * i, 0.50, 0.60, 0.05, 0.10, 0.80) for i in range(10)]
AIR[DEEP] = (2.0, 0.06, 0.07, 0.01, 0.02, 0.25)
E0 = [1300.0 - 15 * i for i in range(10)]


def chn(path):
    text = (
        "\n1ST SPECTRAL  LOS CHAN\n   MOMENT     NO.  NEL\n(NANOMETERS)       NO.\n"
        + "  ".join("-" * w for w in WIDTHS)
        + "  -----------\n"
    )
    above = []
    for i, (center, e0, (light, joined, a, b, s, view)) in enumerate(zip(CENTERS, E0, AIR)):
        width = 1.0645 * FWHM
        cm2 = lambda per_um: per_um * width * 1e-3 * 1e-4  # W m-2 um-1 over the channel, in W cm-2
        e = lambda x: f"{x:.6E}"
        single, multiple = cm2(0.6 * light), cm2(0.4 * light)
        total = float(e(single)) + float(e(multiple))
        cos_over_pi = cm2(e0 * math.cos(math.radians(SUN)) / math.pi)
        above.append(float(e(cos_over_pi)) / (float(f"{width:.4f}") * 1e-3 * 1e-4))
        cells = [
            f"{center:.5f}",
            "1",
            str(i + 1),
            e(1e-9),
            e(total / width),
            "290.000",
            e(total),
            "100.0000",
            f"{width:.4f}",
            f"{center - 20:.4f}",
            f"{center + 20:.4f}",
            e(0),
            e(0),
            e(0),
            e(multiple),
            e(single),
            e(0),
            e(0),
            e(cos_over_pi),
            e(cm2(e0 * joined)),
            e(cm2(e0 * joined * 1.2)),
            f"{a:.7f}",
            f"{b:.7f}",
            f"{s:.7f}",
            f"{view:.7f}",
            "1.0000000",
        ]
        text += (
            "  ".join(cell.rjust(w) for cell, w in zip(cells, WIDTHS))
            + f"  CENTER:   {center:.2f} NM   FWHM:  {FWHM:.2f} NM\n"
        )
    pathlib.Path(path).write_text(text)
    return numpy.array(
        [light + REFLECTANCE * (a + b) * x / (1 - REFLECTANCE * s) for (light, _, a, b, s, _), x in zip(AIR, above)]
    )


def plane(folder, table, *, bands=None, pitch=0, height=0.0, agl=1000.0):
    (folder / "bands.csv").write_text(
        "center_nm,fwhm_nm\n" + "".join(f"{c},{w}\n" for c, w in bands or [(c, FWHM) for c in CENTERS])
    )
    head = f"""atmosphere = {{ tables = "{table}" }}
time = {{ sun = {{ zenith_deg = {SUN}, azimuth_deg = 150.0 }} }}"""
    return plate(folder, head, agl_m=agl, lines=4, grid=4, pitch_deg=pitch, height_m=height, reflectance=REFLECTANCE)


with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    want, out = chn(work / "a.chn"), work / "out"
    imported = [
        "atmos",
        "import",
        work / "a.chn",
        "--sun-zenith",
        SUN,
        "--sun-azimuth",
        150,
        "--even-sky",
        "--overwrite",
    ]
    done = run(*imported, "--sensor-height", 1000, "-o", work / "a.rct")
    check("one line of sight, 0 deg" in done.stderr, done.stderr)

    def render(file):
        done = run("render", file, "-o", out, "--overwrite")
        return done, envi(out / "camera", "radiance")[1].astype(float).reshape(16, -1)

    def not_rendered(file, says):
        refused("render", file, "-o", out, "--overwrite", status=2, says=says)

    # The instrument's bands are the channels: their values as they are.
    done, found = render(plane(work, work / "a.rct"))
    worst = numpy.abs(found / want - 1).max()
    print(f"the channels' own bands: {worst:.2e} of the columns")
    check(worst < 2e-6 and not record(out / "camera")["warnings"], worst, done.stderr)
    # So are some of them, in another order of digits: 2 % of the width.
    _, found = render(plane(work, work / "a.rct", bands=[(750.0, 9.6), (760.15, 9.5), (770.0, 9.4)]))
    check(numpy.abs(found / want[3:6] - 1).max() < 2e-6)
    # Of two channels with one centre the one of the band's own width: a green band beside a panchromatic one.
    wide = (
        (work / "a.chn")
        .read_text()
        .replace("FWHM:  9.50 NM", "FWHM:  30.00 NM", 7)
        .replace("FWHM:  30.00 NM", "FWHM:  9.50 NM", 6)
    )
    (work / "pan.chn").write_text(
        wide.replace("CENTER:   780.00 NM", "CENTER:   770.10 NM")
    )  # the seventh is wide, and lies about the sixth
    run("atmos", "import", work / "pan.chn", *imported[3:], "--sensor-height", 1000, "-o", work / "pan.rct")
    for width, channel in ((9.5, 5), (30.0, 6)):
        done, found = render(plane(work, work / "pan.rct", bands=[(770.1, width)]))
        check(
            numpy.abs(found[:, 0] / want[channel] - 1).max() < 2e-6 and not record(out / "camera")["warnings"],
            width,
            found[0],
            want,
            done.stderr,
        )
    # Others are said, and are what a second average makes of them.
    done, found = render(plane(work, work / "a.rct", bands=[(760.0, 14.0), (770.0, 9.5), (775.0, 9.5)]))
    check("2 of 3 bands" in run("scene", "check", work / "plane.toml").stderr)
    check(
        "2 of 3 bands" in done.stderr
        and "band 1 is 760 nm, FWHM 14 nm" in done.stderr
        and "band 3 is 775 nm" in done.stderr,
        done.stderr,
    )
    check(any("2 of 3 bands" in warning for warning in record(out / "camera")["warnings"]))
    check(abs(found[:, 1] / want[5] - 1).max() < 2e-6 and found[0, 0] > 1.3 * want[DEEP], found[0], want)
    # What is finer than a channel is not in the table.
    not_rendered(
        plane(work, work / "a.rct", bands=[(765.0, 2.0)]),
        ["means over channels", "band 1 is 765 nm, FWHM 2 nm", "FWHM 9.5 nm"],
    )

    # One line of sight: straight down it serves, aside it is said, far aside refused, with the angles.
    done, _ = render(plane(work, work / "a.rct", pitch=10))
    check(
        "one view zenith, 0 deg" in done.stderr
        and any("one view zenith" in w for w in record(out / "camera")["warnings"]),
        done.stderr,
    )

    def warnings(text):
        return sorted(line for line in text.splitlines() if "warning: " in line)

    # `scene check` says the same, in the same words, and counts it; what it refuses it refuses in the render's words.
    told = run("scene", "check", work / "plane.toml")
    check(warnings(told.stderr) == warnings(done.stderr) != [] and "sound" in told.stdout, told.stderr, done.stderr)
    check(f", {len(warnings(told.stderr))} notice" in told.stdout, told.stdout)
    aside = plane(work, work / "a.rct", pitch=40)
    says = ["instrument 'camera'", "one view zenith, 0 deg", "to 40.1", "deg off nadir", "import runs"]
    for verb in (["render", aside, "-o", out, "--overwrite"], ["scene", "check", aside]):
        refused(*verb, status=2, says=says)
    # One target height, likewise; and the sensor's as ever.
    # In parts of the whole column: 60 m are 0.75 % of it, 500 m 6 %.
    done, _ = render(plane(work, work / "a.rct", height=60.0))
    check("one target height, 0 m, 0.747 % of the column of air away" in done.stderr, done.stderr)
    not_rendered(plane(work, work / "a.rct", height=500.0), ["one target height, 0 m", "from 500 to 500 m"])
    # Ten metres under a drone are a tenth of the path and nothing of the light.
    run(*imported, "--sensor-height", 120, "-o", work / "low.rct")
    done, _ = render(plane(work, work / "low.rct", height=10.0, agl=120.0))
    check(not record(out / "camera")["warnings"], done.stderr)
    not_rendered(plane(work, work / "a.rct", agl=1500.0), ["another sensor height"])
    # Columns that a user names state that nothing varies.
    names = (
        "solar_irradiance [W m-2 um-1],sun_transmission [1],view_transmission [1],two_way_factor "
        "[1],path_radiance_solar [W m-2 sr-1 um-1],sky_radiance_solar [W m-2 sr-1 um-1]"
    )
    (work / "even.csv").write_text(f"wavelength [um],{names}\n0.6,1000,1,1,1,0,0\n0.9,1000,1,1,1,0,0\n")
    run("atmos", "import", work / "even.csv", *imported[3:], "--sensor-height", 1000, "-o", work / "even.rct")
    done, _ = render(plane(work, work / "even.rct", pitch=40))
    check(not record(out / "camera")["warnings"], done.stderr)

    # A table that ends at 3 um holds what the path emits and renders as one that ends before: surfaces owe it no
    # temperature.
    names += ",path_radiance_thermal [W m-2 sr-1 um-1]"
    for last in ("2.99", "3.0", "3.0000001"):
        (work / "to3.csv").write_text(
            f"wavelength [um],{names}\n2.0,100,0.8,0.8,1,0.1,0.5,0.001\n{last},100,0.8,0.8,1,0.1,0.5,0.001\n"
        )
        run("atmos", "import", work / "to3.csv", *imported[3:], "--sensor-height", 1000, "-o", work / "to3.rct")
        _, found = render(plane(work, work / "to3.rct", bands=[(2200.0, 20.0), (2800.0, 20.0)]))
        check(found.min() > 0.1, last, found)

    # A sky whose radiances do not sum to its flux is said, and scaled without a step between the wavelengths.
    rows = (
        "solar_irradiance [W m-2 um-1],view_transmission [1],sun_transmission [1],two_way_factor "
        "[1],path_radiance_solar [W m-2 sr-1 um-1],"
        "sky_radiance_solar [W m-2 sr-1 um-1],diffuse_irradiance [W m-2 um-1],direct_irradiance [W m-2 "
        "um-1],spherical_albedo [1],"
        "diffuse_view_transmission [1],diffuse_return [1]"
    )
    text = f"wavelength [um],{rows}\n"
    for um in numpy.linspace(0.66, 0.88, 89):
        flux = math.pi * 60 * (1.08 - 0.06 * (um - 0.66) / 0.22)  # 8 to 2 % more than the sky's sum
        text += f"{um},1000,0.9,0.3,1,1,60,{flux},{1000 * math.cos(math.radians(SUN)) * 0.3},0.1,0.05,0.1\n"
    (work / "step.csv").write_text(text)
    run(
        "atmos",
        "import",
        work / "step.csv",
        *[word for word in imported[3:] if word != "--even-sky"],
        "--sensor-height",
        1000,
        "-o",
        work / "step.rct",
    )
    done, found = render(plane(work, work / "step.rct"))
    check(
        "sums to another irradiance" in done.stderr
        and any("another irradiance" in w for w in record(out / "camera")["warnings"]),
        done.stderr,
    )
    steps = numpy.diff(found[0]) / found[0, :-1]
    check(
        numpy.ptp(steps) < 5e-4, steps
    )  # a straight line; the 5 % beyond which it was once left alone made a step of 3 %
print(f"{program.checks} checks")
