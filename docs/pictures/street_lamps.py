#!/usr/bin/python3
"""Draws docs/pictures/street_lamps.png: a street at night under sodium and LED lamps, a shop window and a billboard, in
the colours of a camera's red, green and blue bands and in the near infrared; of its light what came by several
surfaces, and what the lamps' spectra are. Usage: street_lamps.py RAYCUBE PICTURE"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

SCENE = """format = 1
seed = 3
tolerance = 0.02
sky_directions = 192
bounces = 16
material = [
  { name = "asphalt", reflectance = 0.09 },
  { name = "pavement", reflectance = 0.28 },
  { name = "lawn", file = "leaf.csv" },
  { name = "brick", file = "brick.csv" },
  { name = "plaster", reflectance = 0.6 },
  { name = "roof", reflectance = 0.12 },
  { name = "leaf", file = "leaf.csv", transmission = "leaf" },
  { name = "car", reflectance = 0.05, gloss = { roughness = 0.15, f0 = 0.06 } },
]
plane = [
  { material = "lawn", size_m = [400.0, 400.0] },
  { material = "asphalt", size_m = [400.0, 8.0], position_m = [0, 0, 0.02] },
  { material = "pavement", size_m = [400.0, 3.0], position_m = [0, 5.5, 0.1] },
  { material = "pavement", size_m = [400.0, 3.0], position_m = [0, -5.5, 0.1] },
]
BOXES
mesh = [{ name = "crown", file = "crown.obj", materials = { leaf = "leaf" } }]
TREES
time = { sun = { zenith_deg = 130.0 } }
atmosphere = { model = "layered", aerosol = "rural", visibility_km = 30.0 }
LAMPS
[[instrument]]
name = "camera"
kind = "framing"
pixels = 480
lines = 300
position_m = [4.0, -86.0, 62.0]
pitch_deg = 57.0
ifov_mrad = 1.45
samples = { lattice = 48 }
band_truth = ["between_surfaces"]
bands = { first_nm = 465.0, step_nm = 72.0, count = 6, fwhm_nm = 60.0 }
"""


def crown(path, rng):
    """600 leaves at random in a ball of 2 m that stands on 2.5 m."""
    lines, faces = [], ["usemtl leaf"]
    for i in range(600):
        middle = rng.normal(size=3)
        middle *= 2.0 * rng.uniform() ** (1 / 3) / np.linalg.norm(middle)
        a, b = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2] * 0.22
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            lines.append("v {:.4f} {:.4f} {:.4f}".format(*(middle + (0, 0, 4.5) + x * a + y * b)))
        faces.append("f {} {} {} {}".format(*range(4 * i + 1, 4 * i + 5)))
    path.write_text("\n".join(lines + faces) + "\n")


def table(path, columns, rows):
    path.write_text(columns + "\n" + "\n".join(",".join(f"{v:g}" for v in row) for row in rows) + "\n")


def light(nm, peaks):
    return sum(height * np.exp(-0.5 * ((nm - at) / width) ** 2) for at, width, height in peaks)


SODIUM = ((568, 4, 0.25), (589, 6, 1.0), (598, 12, 0.5), (615, 4, 0.2), (819, 5, 0.6), (498, 3, 0.06))
LED = ((450, 10, 1.0), (555, 45, 0.75), (610, 45, 0.35))


def street(folder):
    rng = np.random.default_rng(4)
    nm = np.arange(250, 1101, 2.0)
    for name, peaks in dict(sodium=SODIUM, led=LED).items():
        table(folder / f"{name}.csv", "wavelength_nm,flux", zip(nm, light(nm, peaks)))
    red_edge = 1 / (1 + np.exp(-(nm - 715) / 12))
    green = np.exp(-0.5 * ((nm - 550) / 35) ** 2)
    table(
        folder / "leaf.csv",
        "wavelength_nm,reflectance,transmittance",
        zip(nm, 0.05 + 0.07 * green + 0.4 * red_edge, 0.02 + 0.06 * green + 0.4 * red_edge),
    )
    table(folder / "brick.csv", "wavelength_nm,reflectance", zip(nm, 0.08 + 0.3 / (1 + np.exp(-(nm - 600) / 35))))
    crown(folder / "crown.obj", rng)
    cosine = 90.0
    angles = np.arange(0, 91, 2.5)
    wing = np.clip(0.55 + 0.75 * np.sin(np.radians(angles)) ** 2, 0, None) * (angles < 72)  # a street luminaire's
    planes = [wing * (0.6 + 0.4 * abs(np.cos(np.radians(h)))) * 300 for h in (0, 30, 60, 90)]
    (folder / "street.ies").write_text(
        f"IESNA:LM-63-2002\nTILT=NONE\n1 8000 1.0 {len(angles)} 4 1 2 0 0 0 1 1 {cosine}\n"
        + " ".join(map(str, angles))
        + "\n0 30 60 90\n"
        + "\n".join(" ".join(f"{v:.2f}" for v in plane) for plane in planes)
        + "\n"
    )
    boxes, x = [], -95.0
    while x < 90:
        width, height = rng.uniform(11, 19), rng.uniform(7, 15)
        for side in (1, -1):
            if side < 0 and -20 < x < 25:
                continue
            boxes.append(
                f'{{ material = "{rng.choice(["brick", "plaster"])}", position_m = [{x + width / 2:.2f}, '
                f"{side * 14.5}, 0], size_m = [{width:.2f}, 12.0, {height:.2f}] }}"
            )
        x += width + rng.uniform(0.5, 5)
    lamps = []
    for i, at in enumerate(np.arange(-84, 90, 24.0)):
        for side, kind in ((1, "sodium"), (-1, "led")):
            lx = at + (0 if side > 0 else 12)
            boxes.append(f'{{ material = "roof", position_m = [{lx}, {side * 4.6}, 0], size_m = [0.2, 0.2, 8.2] }}')
            lamps.append(
                f'{{ name = "{kind}{i}", position_m = [{lx}, {side * 3.9}, 8.0], ies = "street.ies", '
                f'turn_deg = 90.0, spectrum = "{kind}.csv", flux_lm = 9000.0 }}'
            )
    for lx in (-33.0, -14.0, 9.0, 31.0):
        boxes.append(
            f'{{ material = "car", position_m = [{lx}, {2.9 if lx < 0 else -2.9}, 0.3], size_m = [4.4, 1.8, 1.2] }}'
        )
    lamps.append(
        '{ name = "window", shape = "rectangle", position_m = [8.0, 8.45, 1.8], size_m = [7.0, 2.4], '
        "direction = [0, -1, 0], temperature_K = 3000, flux_lm = 12000.0 }"
    )
    lamps.append(
        '{ name = "flood", shape = "spot", position_m = [-22.0, -3.0, 0.6], direction = [0, 1, 0.75], '
        'cone_deg = [12.0, 26.0], spectrum = "led.csv", flux_lm = 9000.0 }'
    )
    trees = [
        f'{{ mesh = "crown", position_m = [{tx}, {ty}, 0], yaw_deg = {rng.uniform(0, 360):.0f}, scale = '
        f"{rng.uniform(0.9, 1.4):.2f} }}"
        for tx, ty in zip(np.arange(-18, 26, 7.0), rng.uniform(-13, -8.5, 7))
    ]
    trees += [f'{{ mesh = "crown", position_m = [{tx}, 7.6, 0], scale = 0.8 }}' for tx in (-44, -28, 26, 47)]
    join = ",\n  ".join
    text = SCENE.replace("BOXES", f"box = [\n  {join(boxes)}\n]").replace("TREES", f"instance = [\n  {join(trees)}\n]")
    (folder / "street.toml").write_text(text.replace("LAMPS", f"lamp = [\n  {join(lamps)}\n]"))


def cube(folder, name):
    header = dict(line.split(" = ", 1) for line in (folder / f"{name}.hdr").read_text().splitlines() if " = " in line)
    shape = tuple(int(header[key]) for key in ("lines", "samples", "bands"))
    return np.fromfile(folder / f"{name}.img", "<f4").reshape(shape)


def shown(values, white):
    return np.clip(values / white, 0, 1) ** (1 / 2.2)


def main(raycube, picture):
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        street(folder)
        subprocess.run([raycube, "render", folder / "street.toml", "-o", folder / "out", "-q"], check=True)
        whole, between = (cube(folder / "out" / "camera", name) for name in ("radiance", "radiance_between_surfaces"))
    figure, axes = plt.subplots(2, 2, figsize=(10, 6.6), layout="constrained")
    colour, white = [2, 1, 0], np.percentile(whole[..., :3].max(-1), 98.5)
    axes[0, 0].imshow(shown(whole[..., colour], white))
    axes[0, 0].set_title("609, 537 and 465 nm", fontsize=10)
    axes[0, 1].imshow(shown(whole[..., 5], np.percentile(whole[..., 5], 98.5)), cmap="gray")
    axes[0, 1].set_title("825 nm: sodium's line at 819 nm, leaves bright", fontsize=10)
    axes[1, 0].imshow(shown(between[..., colour], white))
    axes[1, 0].set_title("of the first: by several surfaces, as bright as it is there", fontsize=10)
    for axis in (axes[0, 0], axes[0, 1], axes[1, 0]):
        axis.axis("off")
    nm = np.arange(250, 1101, 2.0)
    for name, peaks, line in (("sodium", SODIUM, "tab:orange"), ("LED", LED, "tab:blue")):
        axes[1, 1].plot(nm, light(nm, peaks) / light(nm, peaks).max(), line, label=name)
    axes[1, 1].set_xlabel("wavelength, nm")
    axes[1, 1].set_ylabel("spectral flux, of the largest")
    axes[1, 1].set_xlim(380, 1000)
    axes[1, 1].legend()
    figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    main(*sys.argv[1:3])
