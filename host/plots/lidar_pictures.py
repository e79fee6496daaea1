"""Pictures of a LIDAR run, drawn from its products alone: waveforms, ranges, point cloud.
Usage: lidar_pictures.py FIGURES.json (says which files to read and where to draw), or lidar_pictures.py FOLDER of a
run.
"""

import json
import pathlib
import struct
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm, Normalize

MOST_POINTS = 400_000  # drawn; more are thinned evenly
MOST_RANGES = 8_000_000  # returns behind the range image; more: the survey's beginning
LIGHT_M_NS = 0.299792458
TYPES = {1: "u1", 2: "i1", 3: "u2", 4: "i2", 5: "u4", 6: "i4", 7: "u8", 8: "i8", 9: "f4", 10: "f8"}


def limits_of(values):
    """Colour limits that a few per cent of false alarms leave alone."""
    low, high = np.nanpercentile(values, [5, 95])
    margin = 0.25 * (high - low) + 0.5
    return max(low - margin, np.nanmin(values)), min(high + margin, np.nanmax(values))


class Rows:
    """Rows of an array that lies in a file, read when they are asked for. A file that is cut meanwhile is an error; a
    mapped one would end the program."""

    AT_ONCE = 1 << 24  # bytes

    def __init__(self, path, row, start, count):
        self.path, self.row, self.start, self.count = path, row, start, count

    def __len__(self):
        return self.count

    def read(self, first, count):
        with open(self.path, "rb") as file:
            file.seek(self.start + first * self.row.itemsize)
            rows = np.fromfile(file, self.row, count)
        if len(rows) < count:
            needed = self.start + self.count * self.row.itemsize
            found = pathlib.Path(self.path).stat().st_size
            sys.exit(f"{self.path}: was cut while it was read: {needed} bytes expected (found {found})")
        return rows

    def __getitem__(self, which):
        if not isinstance(which, slice):
            return self.read(which, 1)[0]
        first, end, step = which.indices(self.count)
        out = np.empty(len(range(first, end, step)), self.row)
        block = max(1, self.AT_ONCE // (self.row.itemsize * step))
        for at in range(0, len(out), block):
            begin = first + at * step
            out[at : at + block] = self.read(begin, min(block * step, end - begin))[::step]
        return out


class Points:
    """A LAS 1.4 file of format 6 or 9; fields by name, coordinates in metres."""

    def __init__(self, path):
        raw = Rows(path, np.dtype("u1"), 0, pathlib.Path(path).stat().st_size)
        head = bytes(raw[:375])
        header_bytes, start, records, form, record_bytes = struct.unpack_from("<HIIBH", head, 94)
        self.scale, self.offset = struct.unpack_from("<3d", head, 131), struct.unpack_from("<3d", head, 155)
        self.count = struct.unpack_from("<Q", head, 247)[0]
        fields = [
            ("X", "<i4"),
            ("Y", "<i4"),
            ("Z", "<i4"),
            ("intensity", "<u2"),
            ("returns", "u1"),
            ("flags", "u1"),
            ("class", "u1"),
            ("user", "u1"),
            ("angle", "<i2"),
            ("source", "<u2"),
            ("gps", "<f8"),
        ]
        if form == 9:
            fields += [
                ("packet", "u1"),
                ("packet_offset", "<u8"),
                ("packet_bytes", "<u4"),
                ("location", "<f4"),
                ("direction", "<f4", 3),
            ]
        at = header_bytes
        for _ in range(records):
            user, number, length = struct.unpack_from("<16sHH", bytes(raw[at + 2 : at + 22]))
            if user.rstrip(b"\0") == b"LASF_Spec" and number == 4:
                extra = bytes(raw[at + 54 : at + 54 + length])
                for e in range(0, length, 192):
                    fields.append((extra[e + 4 : e + 36].split(b"\0")[0].decode(), "<" + TYPES[extra[e + 2]]))
            at += 54 + length
        assert np.dtype(fields).itemsize == record_bytes, (np.dtype(fields), record_bytes)
        self.records = Rows(path, np.dtype(fields), start, self.count)

    def xyz(self, records):
        return [records[name] * self.scale[i] + self.offset[i] for i, name in enumerate("XYZ")]


def read_header(path):
    """An ENVI header as text by key; lists are split."""
    out, rest = {}, pathlib.Path(path).read_text().split("\n", 1)[1]
    while "=" in rest:
        key, rest = rest.split("=", 1)
        if rest.lstrip().startswith("{"):
            value, rest = rest.lstrip()[1:].split("}", 1)
            value = [part.strip() for part in value.split(",")]
        else:
            value, _, rest = rest.partition("\n")
            value = value.strip()
        out[key.strip()] = value
    return out


def waveforms(figures, path):
    header = read_header(figures["cube_header"])
    lines, bins, names = int(header["lines"]), int(header["samples"]), header["band names"]
    cube = Rows(figures["cube"], np.dtype(("<f4", (len(names), bins))), 0, lines)
    metres = LIGHT_M_NS / 2 / float(header["raycube group index"])
    start, width = float(header["raycube bin start ns"]), float(header["raycube bin width ns"])
    range_m = (start + (np.arange(bins) + 0.5) * width) * metres
    efficiency = figures.get("quantum_efficiency", 1.0)
    some = np.unique(np.random.default_rng(1).integers(0, lines, min(200, 4 * lines)))
    sums = np.array([cube[line][0] for line in some], dtype=float)
    peaks = sums.max(axis=1)
    lit = np.flatnonzero(peaks > 0)
    if len(lit) == 0:
        lit = np.arange(len(some))
    by_peak = lit[np.argsort(peaks[lit], kind="stable")]
    wide = (sums > 0.1 * np.maximum(peaks, 1e-30)[:, None]).sum(axis=1)
    wanted = [
        (by_peak[-1], "strongest"),
        (lit[np.argmax(wide[lit])], "longest"),
        (by_peak[len(by_peak) // 2], "middling"),
        (by_peak[0], "weakest"),
    ]
    chosen = {}
    for index, what in wanted:
        chosen.setdefault(int(some[index]), what)
    rows = np.array([cube[line] for line in chosen])
    figure, axes = plt.subplots(1, 2, figsize=(14, 6), layout="constrained", sharex=True)
    pixels = int(header["raycube pixels"])
    peak, shown, handles = 0.0, np.zeros(bins, bool), []
    expected = [name for name in names if "recorded" not in name]
    styles = ["-", "--", ":", "-.", (0, (3, 1, 1, 1, 1, 1)), (0, (5, 1)), (0, (1, 3))]
    style = {
        name: (
            {"lw": 0.7, "alpha": 0.8, "drawstyle": "steps-mid"}
            if "recorded" in name
            else {"lw": 1.5, "ls": styles[expected.index(name) % len(styles)]}
        )
        for name in names
    }
    for n, (line, what) in enumerate(chosen.items()):
        pulse = f"{what}: {line // pixels + 1}. pulse" + (f", pixel {line % pixels}" if pixels > 1 else "")
        handles.append(plt.Line2D([], [], color=f"C{n}", lw=3, label=pulse))
        for b, name in enumerate(names):
            values = rows[n, b] * (1.0 if "recorded" in name else efficiency)
            peak = max(peak, values.max())
            if "recorded" not in name:
                shown |= values > 1e-3 * rows[n].max()
            axes[0].plot(range_m, values, color=f"C{n}", **style[name])
            axes[1].plot(range_m, np.where(values > 0, values, np.nan), color=f"C{n}", **style[name])
    handles += [
        plt.Line2D(
            [], [], color="0.3", label=name.split(" [")[0], **{k: v for k, v in style[name].items() if k != "drawstyle"}
        )
        for name in names
    ]
    if shown.any():
        first, last = np.flatnonzero(shown)[[0, -1]]
        margin = 0.08 * (last - first) + 8
        axes[0].set_xlim(range_m[max(0, int(first - margin))], range_m[min(bins - 1, int(last + margin))])
    axes[0].set(title="linear", ylabel="photo-electrons in a bin", xlabel="range, m")
    axes[1].set(
        title="logarithmic", yscale="log", xlabel="range, m", ylim=(1e-6 * peak, 2 * peak) if peak > 0 else None
    )
    for axis in axes:
        axis.grid(alpha=0.3)
        above = axis.secondary_xaxis("top", functions=(lambda r: r / metres, lambda t: t * metres))
        above.set_xlabel("delay, ns")
    axes[0].legend(handles=handles, fontsize=7, loc="best")
    figure.suptitle(
        f"{figures['title']}: waveforms, expected (thick) and recorded (thin, stepped); bins of {width:g} ns"
    )
    figure.savefig(path, dpi=110, format="png")
    plt.close(figure)


def scan_image(figures, pulses):
    """Row and column of pulses in the picture of a scan; None when the pattern has none."""
    pattern, rate = figures["pattern"], figures["scan_rate_hz"]
    if pattern == "raster":
        columns = figures["scan_columns"]
        return pulses // columns, pulses % columns, "column of the raster", "row of the raster"
    if pattern == "fixed" or rate <= 0:
        return None
    phase = ((pulses + 0.5) / figures["prf_hz"] + figures.get("first_pulse_s", 0)) * rate
    if pattern == "oscillating":  # sin(2 pi phase) rises from -1/4 to 1/4, falls from 1/4 to 3/4
        half = np.floor(2 * phase + 0.5)
        within = 2 * phase + 0.5 - half
        across = np.where(half % 2 == 0, within, 1 - within)
        per_row, row = figures["prf_hz"] / (2 * rate), half
    else:
        row = np.floor(phase)
        across, per_row = phase - row, figures["prf_hz"] / rate
    columns = max(1, int(per_row + 1e-9))  # no more than there are pulses: no holes but those without return
    return (
        (row - row.min()).astype(int),
        np.minimum((across * columns).astype(int), columns - 1),
        "pulse within the scan",
        "scan",
    )


def ranges(figures, points, path):
    records = points.records
    some = records[:MOST_RANGES]
    some = some[some["user"] == 0]  # the first laser line
    if not len(some):
        return
    # The first return that has a tenth of its record's strongest: air and false alarms before a surface are fainter.
    begin = np.flatnonzero(
        np.concatenate(
            ([True], (np.diff(some["pulse_id"].astype(np.int64)) != 0) | (np.diff(some["source"].astype(int)) != 0))
        )
    )
    strongest = np.repeat(np.maximum.reduceat(some["energy_pe"], begin), np.diff(np.append(begin, len(some))))
    place = np.where(some["energy_pe"] >= 0.1 * strongest, np.arange(len(some)), len(some))
    first = some[np.minimum.reduceat(place, begin)]
    pulses, range_m = first["pulse_id"].astype(np.int64), first["range"]
    figure = plt.figure(figsize=(12, 7), layout="constrained")
    title = f"{figures['title']}: range of the first strong return (a tenth of the record's strongest)"
    if figures["pixels"] > 1:
        columns, rows = figures["columns"], figures["rows"]
        hits = np.bincount(first["source"], minlength=columns * rows).reshape(rows, columns)
        # Medians: noise photons of Geiger detectors lie anywhere in the gate.
        order = np.lexsort((range_m, first["source"]))
        start = np.concatenate(([0], np.cumsum(hits.ravel())[:-1]))
        middle = np.minimum(start + (hits.ravel() - 1) // 2, len(order) - 1)
        median = np.where(hits > 0, range_m[order[middle]].reshape(rows, columns), np.nan)
        axes = figure.subplots(1, 2)
        shots = len(np.unique(pulses))
        pictures = [
            (median, "median range, m", "viridis_r"),
            (hits / shots, f"records with a return, per shot ({shots} shots with any)", "magma"),
        ]
        low, high = limits_of(median)
        limits = [{"vmin": low, "vmax": high}, {"vmin": 0, "vmax": max(1.0, (hits / shots).max())}]
        for axis, (values, name, colours), limit in zip(axes, pictures, limits):
            shown = axis.imshow(values, cmap=colours, interpolation="nearest", origin="upper", **limit)
            figure.colorbar(shown, ax=axis, label=name, shrink=0.8)
            axis.set(xlabel="column of the array", ylabel="row of the array")
    elif (place := scan_image(figures, pulses)) is not None and place[0].max() > 0:
        row, column, across, along = place
        step = max(1, int(np.ceil((row.max() + 1) / 3000)))
        keep = row % step == 0
        picture = np.full((row.max() // step + 1, column.max() + 1), np.nan)
        picture[row[keep] // step, column[keep]] = range_m[keep]
        axis = figure.subplots()
        low, high = limits_of(picture)
        shown = axis.imshow(
            picture,
            cmap="viridis_r",
            interpolation="nearest",
            aspect="auto",
            origin="lower",
            vmin=low,
            vmax=high,
            extent=(0, picture.shape[1], 0, picture.shape[0] * step),
        )
        figure.colorbar(shown, ax=axis, label="range, m (white: no return)", extend="both")
        axis.set(xlabel=across, ylabel=along)
    else:
        axis = figure.subplots()
        axis.plot(pulses, range_m, ".", ms=3)
        axis.set(xlabel="pulse", ylabel="range, m")
        axis.grid(alpha=0.3)
    figure.suptitle(title)
    figure.savefig(path, dpi=110, format="png")
    plt.close(figure)


def cloud(figures, points, path):
    records = points.records[:: max(1, -(-points.count // MOST_POINTS))]
    if not len(records):
        return
    x, y, z = points.xyz(records)
    # A few false alarms far off must not set the frame.
    frame = np.logical_and.reduce(
        [
            np.abs(v - np.median(v)) <= 1.3 * np.abs(np.percentile(v, [1, 99]) - np.median(v)).max() + 0.5
            for v in (x, y, z)
        ]
    )
    left_out = len(records) - int(frame.sum())
    x, y, z, records = x[frame], y[frame], z[frame], records[frame]
    middle = [0.5 * (v.min() + v.max()) for v in (x, y)]
    span = max(np.ptp(x), np.ptp(y), 1e-3)
    low, high = limits_of(z)
    height = Normalize(low, max(high, low + 0.1))
    energy = np.maximum(records["energy_pe"].astype(float), 1e-6)
    dim, bright = np.percentile(energy, [1, 99])
    strength = LogNorm(dim, bright) if bright > 20 * dim else Normalize(dim, max(bright, dim * 1.0001))
    wide = np.ptp(x) > 1.5 * np.ptp(y)
    if wide:  # one view below the other
        figure, axes = plt.subplots(2, 1, figsize=(11, 11), layout="constrained")
    else:
        figure, axes = plt.subplots(1, 2, figsize=(16, 7.5), layout="constrained", width_ratios=(1, 1.15))
    size = float(np.clip((2e5 if wide else 6e4) / len(records), 0.15, 12))
    order = np.argsort(z)
    shown = axes[0].scatter(x[order], y[order], c=z[order], s=size, lw=0, norm=height, cmap="turbo")
    figure.colorbar(shown, ax=axes[0], label="height, m", shrink=0.85, extend="both")
    geo = figures.get("georeferenced")
    axes[0].set(
        aspect="equal",
        xlabel="easting, m" if geo else "x, m",
        ylabel="northing, m" if geo else "y, m",
        title="from above",
    )
    axes[0].ticklabel_format(useOffset=False, style="plain")
    axes[0].tick_params(axis="x", labelrotation=20)
    # Oblique from the south-west at 35 degrees: right, up on the picture, and towards the viewer for who hides whom.
    turn, lift = np.radians(-30), np.radians(35)
    a, b = x - middle[0], y - middle[1]
    right, away = a * np.cos(turn) - b * np.sin(turn), a * np.sin(turn) + b * np.cos(turn)
    up = away * np.sin(lift) + (z - low) * np.cos(lift)
    order = np.argsort(-away * np.cos(lift) + (z - low) * np.sin(lift))
    if bright > 1.01 * dim:  # several energies, so that a colour says something
        shown = axes[1].scatter(right[order], up[order], c=energy[order], s=size, lw=0, norm=strength, cmap="magma")
        figure.colorbar(shown, ax=axes[1], label="energy of the return, photo-electrons", shrink=0.85, extend="both")
    else:  # single photons are all alike
        shown = axes[1].scatter(right[order], up[order], c=z[order], s=size, lw=0, norm=height, cmap="turbo")
        figure.colorbar(shown, ax=axes[1], label="height, m", shrink=0.85, extend="both")
    axes[1].set(aspect="equal", title="oblique, from the south-west, 35 degrees above", facecolor="0.75")
    axes[1].set(xlabel="across the view, m from the middle", ylabel="up the view, m")
    shown_points = f"{len(records)} of {points.count} points" + (
        f", {left_out} far from the rest left out" if left_out else ""
    )
    figure.suptitle(f"{figures['title']}: {shown_points}, {span:.4g} m across")
    figure.savefig(path, dpi=110, format="png")
    plt.close(figure)


def figures_of(folder):
    """What a run's folder offers; the scan comes from the options in its record."""
    record = json.loads((folder / "run.json").read_text())
    figures = dict(record["lidar"]["pictures"])
    for key, name in (("cube", "waveforms.img"), ("cube_header", "waveforms.hdr"), ("las", "returns.las")):
        if (folder / name).exists():
            figures[key] = str(folder / name)
    figures["pictures"] = {name: str(folder / name) for name in ("waveforms.png", "ranges.png", "points.png")}
    return figures


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    source = pathlib.Path(sys.argv[1])
    figures = figures_of(source) if source.is_dir() else json.loads(source.read_text())
    pictures = figures["pictures"]
    if "cube" in figures:
        waveforms(figures, pictures["waveforms.png"])
    if "las" in figures:
        points = Points(figures["las"])
        ranges(figures, points, pictures["ranges.png"])
        cloud(figures, points, pictures["points.png"])


if __name__ == "__main__":
    main()
