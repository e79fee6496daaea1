#!/usr/bin/env python3
"""`raycube preview`: a picture before there is a plan. Oracle: the quicklook of a render that holds a tolerance."""

import json
import math
import pathlib
import re
import struct
import sys
import tempfile

import matplotlib.image
import numpy

from driver import Program, pulse_and_receiver

program = Program(sys.argv[1])
run, check, refused = program.run, program.check, program.refused


def png(path):
    """Pixels [y][x][channel], 0 .. 255, and texts of an 8-bit PNG; reads no library of ours."""
    data, at, text = path.read_bytes(), 8, {}
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"tEXt":
            key, value = data[at + 8 : at + 8 + size].split(b"\0", 1)
            text[key.decode()] = value.decode("latin-1")
        at += 12 + size
    return numpy.round(255 * matplotlib.image.imread(path)[..., :3].astype(float)), text


def radiance(path):
    """What a picture shows, by the limits that its text names."""
    pixels, text = png(path)
    limits = [tuple(map(float, pair)) for pair in re.findall(r"linear from (\S+) to ([^\s;]+)", text["Description"])]
    check(len(limits) == 3, text)
    return numpy.stack([low + (high - low) * pixels[..., c] / 255 for c, (low, high) in enumerate(limits)], -1)


def scene(path, air, pixels=96, lines=64, more=""):
    path.write_text(f"""format = 1
material = [ {{ name = "soil", reflectance = 0.3 }}, {{ name = "roof", reflectance = 0.6 }} ]
plane = [ {{ material = "soil", size_m = [9000.0, 900.0] }} ]
box = [ {{ material = "roof", position_m = [-10.0, -8.0, 0.0], size_m = [20.0, 16.0, 12.0], yaw_deg = 20.0 }} ]
atmosphere = {air}
time = {{ sun = {{ zenith_deg = 40.0, azimuth_deg = 160.0, day_of_year = 264 }} }}
[[instrument]]
name = "camera"
kind = "framing"
pixels = {pixels}
lines = {lines}
altitude_agl_m = 1000.0
gsd_m = 1.0
bands = {{ first_nm = 430.0, step_nm = 20.0, count = 14, fwhm_nm = 20.0 }}
{more}
""")
    return path


def quicklook_agrees(folder):
    """The same light to the noise of either: rms over the picture, and no band brighter or darker."""
    file = scene(folder / "clear.toml", '{ model = "clear_sky", aod_550 = 0.1 }')
    run("render", file, "-o", folder / "out", "-q")
    want = radiance(folder / "out" / "camera" / "quicklook.png")
    errors = []
    for samples in (4, 256):
        out = folder / f"look{samples}.png"
        done = run("preview", file, "-o", out, "--samples", samples)
        check(done.stdout == f"{out}\n", done.stdout)
        found = radiance(out)
        # 8 bits of the range between the percentiles clip what lies beyond: those pixels are not compared.
        inside = ((png(out)[0] % 255 > 0) & (png(folder / "out" / "camera" / "quicklook.png")[0] % 255 > 0)).all(-1)
        check(inside.mean() > 0.8, inside.mean())
        difference = (found - want)[inside]
        errors.append(float(numpy.sqrt(numpy.mean(difference**2)) / want.mean()))
        program.within(difference.mean() / want.mean(), 0.02, "mean", samples)
    print("rms from the render's quicklook, 4 and 256 samples:", errors)
    program.between(0, errors[1], 0.02, "rms")
    program.between(0, errors[1] / errors[0], 0.6, "rms over that of 4 samples")
    return file


def main(folder):
    file = quicklook_agrees(folder)

    # The same picture every time; another seed, another.
    first, again, other = (folder / name for name in ("first.png", "again.png", "other.png"))
    run("preview", file, "-o", first, "--samples", 8, "-q")
    run("preview", file, "-o", again, "--samples", 8, "-q", "--threads", 1)
    run("preview", file, "-o", other, "--samples", 8, "-q", "--seed", 5)
    check(first.read_bytes() == again.read_bytes() != other.read_bytes())

    # Nothing is overwritten unasked; its own earlier pictures are.
    kept = first.read_bytes()
    refused("preview", file, "-o", first, status=2, says=["first.png", "--overwrite"])
    check(first.read_bytes() == kept)
    said = run("preview", file, "-o", first, "--overwrite", "--samples", 16).stderr
    check([line for line in re.findall(r"(\d+) samples each", said)] == ["4", "8", "16"], said)
    check(not [p for p in folder.iterdir() if p.name.startswith(".first")])

    # An image of more pixels than a picture is seen at every n-th line and column; the layered model is not waited for.
    # Within a group of the kernels' pixels (step 2) and past it (step 6); white is what lies beyond the 98th
    # percentile: the roof, south-west of the middle, and little else.
    for pixels, lines, step, width, height in ((2001, 400, 2, 1001, 200), (9001, 800, 6, 1501, 134)):
        wide = scene(folder / "wide.toml", '{ model = "layered" }', pixels, lines)
        done = json.loads(
            run("preview", wide, "-o", folder / "wide.png", "--samples", 4, "--json", "--overwrite").stdout
        )
        shown, _ = png(folder / "wide.png")
        check(done["step"] == step and (done["width"], done["height"]) == (width, height), done)
        check(shown.shape == (height, width, 3), shown.shape)
        white = (shown == 255).all(-1)
        x, y = pixels / 2, lines / 2
        roof = white[
            math.ceil((y + 3) / step) : int((y + 13) / step) + 1, math.ceil((x - 17) / step) : int((x - 3) / step) + 1
        ]
        check(roof.mean() > 0.5 and white[: height // 4].mean() < 0.05, step, roof.mean())

    # What cannot be shown.
    refused("preview", file, "--instrument", "none", "-o", folder / "none.png", status=2, says=["'none'", "camera"])
    lidar = scene(folder / "lidar.toml", '{ model = "none" }')
    lidar.write_text(
        lidar.read_text()[: lidar.read_text().index("[[instrument]]")]
        + '[[lidar]]\nname = "pulse"\nposition_m = [0.0, 0.0, 100.0]\nprf_khz = 10.0\npulses = 3\n'
        + pulse_and_receiver()
        + "[lidar.gate]\nstart_range_m = 90.0\nstop_range_m = 110.0\n"
    )
    refused("preview", lidar, "-o", folder / "none.png", status=2, says=["no camera to preview"])
    check(not (folder / "none.png").exists())
    print(program.checks, "checks")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        main(pathlib.Path(name))
