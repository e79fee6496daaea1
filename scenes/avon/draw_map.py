#!/usr/bin/python3
"""Picture of a map that `raycube analyze` made. Usage: draw_map.py MAP.hdr LAYER PICTURE.png

LAYER from 0. Maps of classes (the header has `class names`) get a colour for each class and a key, others a scale.
"""

import re
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

TYPES = {1: "u1", 2: "<i2", 4: "<f4", 5: "<f8", 12: "<u2"}


def read(header):
    """[layer][line][sample] and what the header says."""
    text = open(header, encoding="utf-8").read()
    said = {
        k.strip().lower(): " ".join(v.strip("{} \n").split())
        for k, v in re.findall(r"(?m)^([^=\n]+?)\s*=\s*(\{[^}]*\}|[^\n]*)", text)
    }
    lines, samples, bands = (int(said[k]) for k in ("lines", "samples", "bands"))
    data = np.fromfile(re.sub(r"\.hdr$", ".img", header), TYPES[int(said["data type"])])
    shape, axes = {
        "bsq": ((bands, lines, samples), (0, 1, 2)),
        "bil": ((lines, bands, samples), (1, 0, 2)),
        "bip": ((lines, samples, bands), (2, 0, 1)),
    }[said["interleave"].lower()]
    return data.reshape(shape).transpose(axes), said


def main(header, layer, picture):
    maps, said = read(header)
    shown = maps[int(layer)]
    figure, axes = plt.subplots(figsize=(6.4, 6.4 * shown.shape[0] / shown.shape[1] + 0.5), layout="constrained")
    axes.set_axis_off()
    if "class names" in said:
        names = [name.strip() for name in said["class names"].split(",")]
        colours = np.array(said["class lookup"].split(","), dtype=float).reshape(-1, 3) / 255
        axes.imshow(shown, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(names) - 0.5, interpolation="nearest")
        keys = [Patch(color=c, label=n) for i, (c, n) in enumerate(zip(colours, names)) if (shown == i).any()]
        axes.legend(
            handles=keys, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=min(len(keys), 5), frameon=False
        )
    else:
        low, high = np.nanpercentile(shown, (2, 99.9))
        image = axes.imshow(shown, cmap="viridis", vmin=low, vmax=high, interpolation="nearest")
        names = said.get("band names", "").split(",")
        figure.colorbar(image, ax=axes, shrink=0.8, label=names[int(layer)].strip())
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:4])
