"""Charts of a render table: transmission, irradiance, path radiance, sky. Usage: atmos_plot.py FIGURES.json CHART.png"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def spectra(axis, data, rows, title, unit, log=False):
    wavelength = data["wavelength_um"]
    shown = [(data[name], label) for name, label in rows if name in data]
    for values, label in shown:
        values = np.asarray(values)
        axis.plot(wavelength, np.where(values > 0, values, np.nan) if log else values, lw=0.9, label=label)
    axis.set(title=title, xlabel="wavelength, um", ylabel=unit)
    if log:
        axis.set_yscale("log")
    if shown:
        axis.legend(fontsize=8)
    else:
        axis.text(0.5, 0.5, "not in this table", ha="center", transform=axis.transAxes)
    axis.grid(alpha=0.3)


def sky_map(figure, place, data):
    if "sky" not in data:
        axis = figure.add_subplot(place)
        axis.text(0.5, 0.5, "no sky radiance in this table", ha="center")
        axis.set_axis_off()
        return
    sky = data["sky"]
    axis = figure.add_subplot(place, projection="polar")
    axis.set_theta_zero_location("N")
    axis.set_theta_direction(-1)
    half = np.asarray(sky["radiance"])
    azimuth = np.asarray(sky["azimuth_deg"])
    angles = np.radians(np.concatenate([azimuth, 360 - azimuth[-2::-1]]))
    values = np.concatenate([half, half[:, -2::-1]], axis=1)
    axis.grid(False)
    mesh = axis.pcolormesh(angles, sky["zenith_deg"], values, shading="gouraud", cmap="viridis")
    if data["sun_zenith_deg"] < 90:
        axis.plot(0, data["sun_zenith_deg"], "o", color="white", mec="black", ms=6)
    axis.set_rticks([30, 60, 90])
    axis.set_title(f"sky radiance at {sky['wavelength_um']:g} um; zenith outwards, sun's azimuth up (deg)", fontsize=10)
    figure.colorbar(mesh, ax=axis, label="W m-2 sr-1 um-1", shrink=0.8, pad=0.1)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    figure = plt.figure(figsize=(12, 8.5), layout="constrained")
    where = f"target {data['target_height_m']:g} m, view zenith {data['view_zenith_deg']:g} deg"
    spectra(figure.add_subplot(2, 2, 1), data,
            [("sun_transmission", "top of the air to target"), ("view_transmission", "target to sensor"),
             ("two_way_transmission", "sun to target to sensor")], f"transmission; {where}", "transmission, 1")
    spectra(figure.add_subplot(2, 2, 2), data,
            [("solar_irradiance", "above the air, normal to the beam"), ("direct_irradiance", "direct, horizontal"),
             ("diffuse_irradiance", "diffuse, horizontal")], "irradiance at the target", "W m-2 um-1")
    spectra(figure.add_subplot(2, 2, 3), data, [("path_radiance", f"relative azimuth {data['relative_azimuth_deg']:g} deg")],
            f"path radiance; {where}", "W m-2 sr-1 um-1", log=True)
    sky_map(figure, 224, data)
    figure.suptitle(f"{data['title']}: sun zenith {data['sun_zenith_deg']:g} deg, sensor at {data['sensor_height_m']:g} m")
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
