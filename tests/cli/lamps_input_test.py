"""What a file may say wrong of lamps: one clear error each, nothing written. usage: lamps_input_test.py RAYCUBE"""

import pathlib
import tempfile

from lamp_scenes import check, program, refused, run, world, write_files


def check_refusals(work):
    good = dict(name='"a"', position_m="[0, 0, 2]", spectrum='"flat.csv"', power_W="5.0")

    def refuse(says, lamps=None, **changes):
        keys = {**good, **changes}
        text = lamps or "{ " + ", ".join(f"{k} = {v}" for k, v in keys.items() if v is not None) + " }"
        refused("render", world(work, "refused", lamps=text), "-o", work / "refused", status=2, says=says)
        check(not (work / "refused" / "camera").exists(), says)

    refuse(["exactly one of position_m and positions", "neither"], position_m=None)
    refuse(["exactly one of spectrum and temperature_K", "both"], temperature_K="3000")
    refuse(["nothing says how much light"], power_W=None)
    refuse(["exclude each other", "flux_lm"], flux_lm="100")
    refuse(["a spot needs 'cone_deg'"], shape='"spot"')
    refuse(["'size_m' is of a rectangle"], size_m="[1, 1]")
    refuse(["the inner cone must not be wider"], shape='"spot"', cone_deg="[40, 20]")
    refuse(["must shine somewhere"], direction="[0, 0, 0]", shape='"disc"', diameter_m="1.0")
    refuse(["'direction' is nothing to a point"], direction="[0, 1, 0]")
    refuse(["'turn_deg' turns nothing"], turn_deg="10")
    refuse(["0.5 deg wide at least"], shape='"spot"', cone_deg="[0.01, 0.1]")
    refuse(["shape", "point, spot, rectangle, disc"], shape='"sphere"')
    refuse(
        ["names another lamp"],
        lamps=", ".join(["{ name = 'a', position_m = [0, 0, 2], spectrum = 'flat.csv', power_W = 1 }"] * 2),
    )
    five = ", ".join(
        f"{{ name = 'l{i}', position_m = [0, 0, 2], temperature_K = {3000 + i}, power_W = 1 }}" for i in range(5)
    )
    refuse(["more than 4 different spectra", "'l4'"], lamps=five)
    (work / "heat.csv").write_text("wavelength_um,flux\n1.0,1\n2.0,1\n")
    refuse(["lm/W", "give power_W"], spectrum='"heat.csv"', power_W=None, flux_lm="100")
    for text, says in {
        "wavelength_um,a,b\n0.4,1,1\n": "has two columns",
        "wavelength_um,flux\n0.4,1\n0.4,1\n": "must ascend",
        "wavelength_um,flux\n0.4,1\n0.5,-1\n": "must not be negative",
        "wavelength_um,flux\n0.4,0\n0.5,0\n": "holds no light",
    }.items():
        (work / "bad.csv").write_text(text)
        refuse(["bad.csv", says], spectrum='"bad.csv"')
    (work / "far.csv").write_text("wavelength_um,flux\n400,1\n500,1\n")
    file = world(
        work, "far", lamps="{ " + ", ".join(f"{k} = {v}" for k, v in {**good, "spectrum": '"far.csv"'}.items()) + " }"
    )
    done = run("render", file, "-o", work / "far")
    check("no band sees the light of lamp 'a', whose spectrum lies at 400 to 500 um" in done.stderr, done.stderr)
    (work / "places.csv").write_text("x_m,y_m\n1,2\n")
    refuse(["places.csv", "x_m, y_m and z_m"], position_m=None, positions='"places.csv"')
    street = (work / "street.ies").read_text()
    for old, new, says in [
        ("TILT=NONE", "TILT=lamp.tlt", "names another file"),
        ("TILT=NONE", "", "no line TILT="),
        ("5 1 2 0", "5 2 2 0", "must be C"),
        ("0 45 90 135 180", "0 45 90 135 170", "horizontal angles"),
        ("0 1 2 3", "0 2 1 3", "ascend"),
        ("1 1000 1.0", "1 1000 0.0", "sends no light"),
    ]:
        (work / "bad.ies").write_text(street.replace(old, new, 1))
        refuse(["bad.ies", says], ies='"bad.ies"', power_W=None)
    (work / "bad.ies").write_bytes(b"TILT=NONE\n\xff\x00\x01 1 2")
    refuse(["bad.ies", r"(found '\xff\x00\x01'); give a file of IES LM-63"], ies='"bad.ies"', power_W=None)
    (work / "bad.ies").write_text(street[:-60])
    refuse(["bad.ies", "the file ends before candelas"], ies='"bad.ies"', power_W=None)


with tempfile.TemporaryDirectory() as folder:
    write_files(pathlib.Path(folder))
    check_refusals(pathlib.Path(folder))
print(f"lamps_input: {program.checks} checks")
