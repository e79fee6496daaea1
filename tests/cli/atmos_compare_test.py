"""raycube atmos compare as a user drives it. Usage: atmos_compare_test.py RAYCUBE. Oracle: optical depths add, so twice
the aerosol squares its transmission; a table compared with itself differs by nothing."""

import json
import pathlib
import sys
import tempfile

import numpy

from driver import Program

program = Program(sys.argv[1])
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)

    def build(file, *options, sun=40):
        program.run(
            "atmos", "build", "--model", "clear_sky", "--sun-zenith", sun, "--step", "20", "-o", folder / file, *options
        )
        return folder / file

    def compare(*options):
        return json.loads(program.run("atmos", "compare", *options, "--json").stdout)

    thin, thick, none = (
        build("thin.rct", "--aod", "0.2"),
        build("thick.rct", "--aod", "0.4"),
        build("none.rct", "--aod", "0"),
    )
    same = compare(thin, thin)
    program.check(same["differs"] == [] and same["only_a"] == same["only_b"] == [])
    program.check(
        {q["name"] for q in same["quantities"]}
        >= {
            "view_transmission",
            "path_radiance_solar",
            "sky_radiance_solar",
            "two_way_factor",
            "direct_irradiance",
            "diffuse_irradiance",
            "solar_irradiance",
        }
    )
    program.check(all(b["rms"] == 0 and b["worst"] == 0 for q in same["quantities"] for b in q["bands"]))
    program.check(all(q["bands"] for q in same["quantities"]))

    # -ln T: none + aerosol, so the step from none to thin is that from thin to thick. One wavelength per band.
    point = folder / "points.csv"
    point.write_text("# bands of one point\ncenter_nm,fwhm_nm\n550,0.1\n870,0.1\n")
    depths = []
    for a, b in ((none, thin), (thin, thick)):
        sun = next(q for q in compare(a, b, "--bands", point)["quantities"] if q["name"] == "sun_transmission")
        depths.append([-numpy.log(band["mean_b"] / band["mean_a"]) for band in sun["bands"]])
    program.check(numpy.allclose(depths[0], depths[1], rtol=1e-5), depths)  # float transmissions: 6e-8 of T
    program.check(depths[0][0] > 0.2)  # 0.2 at 0.55 um, slanted

    text = program.run("atmos", "compare", thin, thick, "--step", "500").stdout
    program.check(
        "sun_transmission [1]" in text and "path_radiance_solar, view zenith 45 deg, azimuth 90 deg" in text, text
    )
    program.check("0.35 - 0.85" in text and "2.35 - 2.5" in text, text)

    # Other sun, sensor and wavelengths: said first.
    other = build("other.rct", "--sensor-height", "2000", "--from", "0.5", sun=20)
    text = program.run("atmos", "compare", thin, other).stdout
    program.check(
        "differs: sun zenith: 40 and 20 deg" in text and "differs: sensor height: 610 and 2000 m" in text, text
    )
    program.check("common range 0.5 to 2.5 um" in text and text.index("differs:") < text.index("mean B-A"), text)

    chart = folder / "difference.png"
    program.run("atmos", "compare", thin, other, "-o", chart)
    program.check(chart.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and chart.with_suffix(".json").exists())
    program.refused("atmos", "compare", thin, other, "-o", chart, status=2, says=["difference"])

    program.refused("atmos", "compare", thin, folder / "nowhere.rct", status=3, says=["cannot be opened"])
    infrared = build("infrared.rct", "--from", "3", "--to", "3.5")
    program.refused(
        "atmos", "compare", thin, infrared, status=2, says=["no wavelength in common: 0.35 to 2.5 um, and 3 to 3.5 um"]
    )
    program.refused(
        "atmos", "compare", thin, other, "--bands", point, "--step", "5", status=2, says=["--bands and --step"]
    )
    point.write_text("center,width\n550,10\n")
    program.refused(
        "atmos", "compare", thin, other, "--bands", point, status=2, says=["points.csv:1", "center_nm,fwhm_nm"]
    )
    point.write_text("center_nm,fwhm_nm\n550,0\nx,10\n")
    program.refused(
        "atmos", "compare", thin, other, "--bands", point, status=2, says=["points.csv:2", "points.csv:3"], messages=2
    )
    point.write_text("center_nm,fwhm_nm\n5500,10\n")
    program.refused(
        "atmos", "compare", thin, other, "--bands", point, status=2, says=["no band lies in the common range"]
    )
print(f"atmos compare: ok, {program.checks} checks")
