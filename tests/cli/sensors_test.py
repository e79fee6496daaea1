"""S42: sensors kept in files apart from their flights, those that are shipped, and what focal planes refuse."""

import pathlib
import sys
import json
import tempfile

import numpy as np

from driver import Program, envi
from optics_kit import HEAD, camera, panel, plane
from optics_kit import render as render_by

program = Program(sys.argv[1])
PATTERN = panel("bright", (7, 5), (-4, 3), 25.0) + panel("grey", (3, 9), (5.3, -2.2), -10.0)


def render(folder, text, *more, name="camera"):
    return render_by(program, folder, text, *more, name=name)


def kept_apart(folder):
    """A sensor's file says what the instrument's table does not."""
    (folder / "sensor.toml").write_text("""format = 1
kind = "framing"
pixels = 30
lines = 20
ifov_mrad = 0.5
samples = { grid = [4, 4] }
bands = { first_nm = 550.0, step_nm = 100.0, count = 2, fwhm_nm = 10.0 }
""" + plane(sigma_px=0.45).replace("instrument.", "") + "[detector]\nsnr = 100\n")
    flight = '[[instrument]]\nname = "camera"\nsensor = "sensor.toml"\naltitude_agl_m = 2000.0\n'
    a, out = render(folder, HEAD + PATTERN + flight + "lines = 10\n")
    program.check((out / "measured.img").exists())
    b, _ = render(
        folder,
        HEAD
        + PATTERN
        + camera(pixels=30, lines=10, bands="first_nm = 550.0, step_nm = 100.0, count = 2", samples="{ grid = [4, 4] }")
        + plane(sigma_px=0.45),
    )
    program.check(np.array_equal(a, b), np.abs(a - b).max())
    for text, says in (
        (flight.replace("sensor.toml", "none.toml"), "none.toml"),
        (flight + "colour = 3\n", "colour"),
        (flight + "gsd_m = 2.0\n", None),  # in place of the file's ifov_mrad
        (flight + "psf = { sigma_px = 0.4 }\n", None),  # and of its focal planes
    ):
        (folder / "scene.toml").write_text(HEAD + text)
        done = program.run("scene", "check", folder / "scene.toml", status=2 if says else 0)
        program.check(not says or says in done.stderr, done.stderr)
    (folder / "sensor.toml").write_text("format = 1\nkind = 'framing'\npixels = 30\nlines = 20\nwings = 2\n")
    (folder / "scene.toml").write_text(HEAD + flight)
    done = program.run("scene", "check", folder / "scene.toml", status=2)
    program.check("sensor.toml:5" in done.stderr and "wings" in done.stderr, done.stderr)


def shipped(folder):
    """Sensors to copy: bands and scales as published."""
    for name, bands, gsd_m, pixels in (
        ("spectir", 360, 1.0, 320),
        ("wasp_visible", 3, 0.1, 4000),
        ("wasp_swir", 1, 0.6, 640),
        ("wasp_mwir", 1, 0.6, 640),
        ("wasp_lwir", 1, 0.6, 640),
    ):
        sensor = pathlib.Path(sys.argv[2]).resolve() / "sensors" / f"{name}.toml"
        flight = f'[thermal]\ndefault_temperature_K = 300.0\n[[instrument]]\nname = "camera"\nsensor = "{sensor}"\n'
        flight += "altitude_agl_m = 609.6\n"
        (folder / "scene.toml").write_text(HEAD + flight)
        half = ("--set", "instrument.camera.lines=2000") if pixels == 4000 else ()
        said = json.loads(program.run("scene", "check", folder / "scene.toml", "--json", *half).stdout)
        if half:
            whole = program.run("scene", "check", folder / "scene.toml", status=2).stderr
            program.check("12066 x 12066 cells of its pixels, more than 100000000; split the image" in whole, whole)
        program.check(len(said["instrument"]) == 1)
        image, out = render(folder, HEAD + PATTERN + flight + "pixels = 12\nlines = 8\nsamples = { grid = [1, 1] }\n")
        truth = envi(out, "truth")[1].astype("f8")
        names = envi(out, "truth")[0]["band names"]
        x = truth[..., [n.split(" ")[0] for n in names].index("x_m")]
        program.check(image.shape == (8, 12, bands) and np.isfinite(image).all(), name, image.shape)
        program.check(np.allclose(np.abs(np.diff(x, axis=1)), gsd_m, rtol=2e-3), name, np.diff(x, axis=1))
        program.check(f"pixels = {pixels}\n" in sensor.read_text(), name)


def refused(folder):
    """One line each, that says what and where."""
    (folder / "uneven.csv").write_text("x_px,y_px,psf\n0,0,1\n1,0,1\n3,0,1\n0,1,1\n1,1,1\n3,1,1\n")
    (folder / "hole.csv").write_text("wavelength_nm,sample,smile_nm,keystone_px\n500,0,1,0\n500,9,1,0\n600,0,1,0\n")
    (folder / "dark.csv").write_text("radius_px,psf\n0,0\n1,0\n")
    (folder / "far.csv").write_text("wavelength_nm,sample,smile_nm,keystone_px\n500,0,0,1e12\n")
    grid = "".join(f"600,{x},{y},1\n" for y in (-1, 0, 1) for x in (-1, 0, 1))
    (folder / "bygrid.csv").write_text("wavelength_nm,x_px,y_px,psf\n" + grid)
    (folder / "more.csv").write_text("radius_px,psf,mtf\n0,1,1\n1,0,1\n")
    (folder / "below.csv").write_text("wavelength_nm,radius_px,psf\n-5,0,1\n-5,1,1\n600,0,1\n600,1,1\n")
    (folder / "wide.csv").write_text("radius_px,psf\n0,1\n500,0.5\n1000,0\n")  # whose transfer took ten minutes
    (folder / "gain.csv").write_text("wavelength_nm,nedl,gain\n400,0.1,2\n900,0.1,2\n")
    (folder / "twice.csv").write_text("wavelength_nm,a,b,c\n400,1,1,1\n400,2,2,2\n900,1,1,1\n")
    noise = '[instrument.detector]\nnoise = "{}.csv"\n'
    two = camera(bands="first_nm = 550.0, step_nm = 100.0, count = 2")
    for text, says in (
        (camera(psf="{ sigma_px = 0.5 }") + plane(sigma_px=0.5), "psf"),
        (camera(oversampling=4) + plane(sigma_px=0.5), "odd"),
        (camera(oversampling=5), "oversampling"),
        (camera(standard_error='"worst"') + plane(sigma_px=0.5), "standard_error"),
        (two + plane(sigma_px=0.5, last_nm=600.0), "650"),
        (two + plane(sigma_px=0.5) + plane(sigma_px=0.4, first_nm=600.0), "650"),
        (camera() + plane(f_number=4.0), "pitch"),
        (camera() + plane(pitch_um=4.0), "f_number"),
        (camera() + plane(obscuration=0.3), "f_number"),
        (camera() + plane(spread='"uneven.csv"'), "regular"),
        (camera() + plane(spread='"dark.csv"'), "positive"),
        (camera() + plane(spread='"none.csv"'), "none.csv"),
        (camera() + plane(distortion='"hole.csv"'), "grid"),
        (camera() + plane(distortion='"hole.csv"', smile_nm=1.0), "exclude"),
        (camera(band_truth='["reflectance"]') + plane(smile_nm=1.0), "band_truth"),
        (camera(kind='"pushbroom"', lines=1) + plane(sigma_px=0.5), "two lines"),
        (camera(kind='"pushbroom"', motion='"moving"') + plane(sigma_px=0.5), "smear_px"),
        (two + plane(sigma_px=0.5) + plane(first_nm=900.0), "no band"),
        (camera() + plane(distortion='"far.csv"'), "too large"),
        (camera() + plane(first_nm=700.0, last_nm=600.0), "last_nm"),
    ):
        (folder / "scene.toml").write_text(HEAD + text)
        done = program.run("scene", "check", folder / "scene.toml", status=2)
        program.check(says in done.stderr and "scene.toml" in done.stderr, says, done.stderr)
    for text, says in (
        (camera() + plane(spread='"bygrid.csv"'), "unknown column (found 'wavelength_nm')"),
        (camera() + plane(spread='"more.csv"'), "unknown column (found 'mtf')"),
        (camera() + plane(spread='"below.csv"'), "must be above 0 (found -5)"),
        (camera() + plane(spread='"wide.csv"'), "at most 83 pixels (found 1000)"),
        (camera() + noise.format("gain"), "unknown column (found 'gain')"),
        (camera() + noise.format("twice"), "there twice (found 400 nm)"),
    ):
        (folder / "scene.toml").write_text(HEAD + text)
        program.refused("scene", "check", folder / "scene.toml", status=2, says=[says])
    (folder / "uneven_poses.csv").write_text("x_m,y_m,z_m\n" + "".join(f"0,{0.1 * i * i},500\n" for i in range(9)))
    uneven = camera(kind='"pushbroom"', lines=9, poses='"uneven_poses.csv"', ifov_mrad=2.0) + plane(sigma_px=0.5)
    uneven = uneven.replace("altitude_agl_m = 2000.0\n", "").replace("gsd_m = 1.0\n", "")
    for text, says in (
        (uneven, "evenly"),
        (camera(kind='"pushbroom"', line_spacing_m=9.0) + plane(sigma_px=0.5), "evenly"),
        (camera() + plane(sigma_px=90.0), "reaches"),
        (camera() + plane(f_number=1000.0, pitch_um=5.0), "reaches"),
    ):
        (folder / "scene.toml").write_text(HEAD + text)
        done = program.run("render", folder / "scene.toml", "-o", folder / "no", status=2)
        program.check(says in done.stderr, says, done.stderr)
    (folder / "scene.toml").write_text(HEAD + camera() + plane(sigma_px=0.5))
    done = program.run("explain", folder / "scene.toml", "--pixel", "1,1", status=2)
    program.check("focal planes" in done.stderr, done.stderr)


with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    refused(folder)
    kept_apart(folder)
    shipped(folder)
print(program.checks, "checks")
