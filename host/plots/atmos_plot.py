"""Charts of a render table: transmission, irradiance, path and sky radiance, light between ground and air.
Usage: atmos_plot.py FIGURES.json CHART.png"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

RADIANCE = "W m-2 sr-1 um-1"
TICKS = (0.3, 0.4, 0.5, 0.7, 1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 30)


def spectra(axis, data, rows, title, unit, log=False):
    wavelength = np.asarray(data["wavelength_um"])
    top = 0
    for name, label in rows:
        if name not in data:
            continue
        values = np.asarray(data[name], dtype=float)
        top = max(top, np.nanmax(values, initial=0))
        axis.plot(wavelength, np.where(values > 0, values, np.nan) if log else values, lw=0.9, label=label)
    axis.set_title(title, fontsize=10)
    axis.set_ylabel(unit)
    if log and top > 0:
        axis.set_yscale("log")
        axis.set_ylim(
            max(axis.get_ylim()[0], 1e-7 * top), 2 * top
        )  # light below a ten-millionth of the brightest is none
    wavelengths(axis, wavelength)
    axis.legend(fontsize=7)
    axis.grid(alpha=0.3)


def wavelengths(axis, wavelength):
    axis.set_xlabel("wavelength, um")
    if wavelength[-1] > 8 * wavelength[0]:
        axis.set_xscale("log")
        ticks = [tick for tick in TICKS if wavelength[0] <= tick <= wavelength[-1]]
        axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.minorticks_off()


def transmission(axis, data, where):
    spectra(
        axis,
        data,
        [
            ("sun_transmission", "top of the air to target"),
            ("view_transmission", "target to sensor"),
            ("two_way_transmission", "sun to target to sensor"),
        ],
        f"transmission; {where}",
        "transmission, 1",
    )
    axis.set_ylim(-0.02, 1.02)


def factors(axis, data, where):
    spectra(
        axis,
        data,
        [("two_way_factor", "sunlight"), ("two_way_factor_thermal", "reflected thermal sky")],
        f"two-way factor (sunlight: where T_sun T_view > 0.001)\n{where}",
        "factor, 1",
    )


def irradiance(axis, data, where):
    spectra(
        axis,
        data,
        [
            ("solar_irradiance", "above the air, normal to the beam"),
            ("direct_irradiance", "direct, horizontal"),
            ("diffuse_irradiance", "diffuse, horizontal"),
        ],
        "irradiance at the target",
        "W m-2 um-1",
        log=data["wavelength_um"][-1] > 3,
    )


def path(axis, data, where):
    spectra(
        axis,
        data,
        [
            ("path_radiance", f"scattered sunlight, azimuth {data['relative_azimuth_deg']:g} deg"),
            ("path_radiance_thermal", "emitted"),
        ],
        f"path radiance; {where}",
        RADIANCE,
        log=True,
    )


def sky(axis, data, where):
    up, slant = data["sky_zenith_deg"]
    side = f", azimuth {data['sky_azimuth_deg']:g} deg" if "sky_azimuth_deg" in data else ""
    spectra(
        axis,
        data,
        [
            ("sky_up", f"sunlight, zenith angle {up:g} deg{side if up else ''}"),
            ("sky_slant", f"sunlight, {slant:g} deg{side}"),
            ("thermal_sky_up", f"emitted, {up:g} deg"),
            ("thermal_sky_slant", f"emitted, {slant:g} deg"),
        ],
        "sky radiance",
        RADIANCE,
        log=True,
    )


def coupling(axis, data, where):
    up, slant = data.get("sky_zenith_deg", (0, 0))
    spectra(
        axis,
        data,
        [
            ("spherical_albedo", "S, spherical albedo"),
            ("diffuse_view_transmission", "T_dif to the sensor"),
            ("diffuse_return_up", f"t back down, {up:g} deg"),
            ("diffuse_return_slant", f"t back down, {slant:g} deg"),
        ],
        f"light between ground and air; {where}",
        "1",
    )


def sky_map(figure, place, data):
    sky = data["sky"]
    axis = figure.add_subplot(place, projection="polar")
    axis.set_theta_zero_location("N")
    axis.set_theta_direction(-1)
    half = np.asarray(sky["radiance"])
    azimuth = np.asarray(sky["azimuth_deg"])
    whole = azimuth[-1] >= 180
    angles = np.radians(np.concatenate([azimuth, 360 - azimuth[-2::-1]])) if whole else np.radians(azimuth)
    values = np.concatenate([half, half[:, -2::-1]], axis=1) if whole else half
    # The aureole is decades above the rest of the sky.
    dim = np.percentile(values[values > 0], 1) if (values > 0).any() else 0
    norm = matplotlib.colors.LogNorm(dim, values.max()) if values.max() > dim > 0 else None
    axis.grid(False)
    mesh = axis.pcolormesh(angles, sky["zenith_deg"], values, shading="gouraud", cmap="viridis", norm=norm)
    if data["sun_zenith_deg"] < 90:
        axis.plot(0, data["sun_zenith_deg"], "o", color="none", mec="black", ms=9)
    axis.set_rticks([30, 60, 90])
    axis.set_title(
        f"sky radiance, sunlight, at {sky['wavelength_um']:.5g} um\nzenith outwards, sun's azimuth up (deg)",
        fontsize=10,
    )
    figure.colorbar(mesh, ax=axis, label=RADIANCE, shrink=0.8, pad=0.12)


def aureole(axis, data, where):
    sky = data["sky"]
    radiance = np.asarray(sky["plane_radiance"])
    axis.plot(sky["plane_zenith_deg"], np.where(radiance > 0, radiance, np.nan), lw=0.9)
    if (radiance > 0).any():
        axis.set_yscale("log")
    if data["sun_zenith_deg"] < 90:
        axis.axvline(data["sun_zenith_deg"], color="gray", lw=0.8, ls=":", label="sun (its disc is not in the table)")
        axis.legend(fontsize=7)
    axis.set_title(f"sky through zenith and sun, at {sky['wavelength_um']:.5g} um", fontsize=10)
    axis.set(xlabel="zenith angle, deg; negative: behind", ylabel=RADIANCE)
    axis.grid(alpha=0.3)


def thermal_sky(axis, data, where):
    for curve in data["thermal_sky"]["curves"]:
        axis.plot(
            data["thermal_sky"]["zenith_deg"], curve["radiance"], lw=0.9, label=f"{curve['wavelength_um']:.4g} um"
        )
    axis.set_title("sky radiance, emitted", fontsize=10)
    axis.set(xlabel="zenith angle, deg", ylabel=RADIANCE)
    axis.legend(fontsize=7)
    axis.grid(alpha=0.3)


# Which figures a panel needs one of.
PANELS = [
    (transmission, ("sun_transmission", "view_transmission")),
    (factors, ("two_way_factor", "two_way_factor_thermal")),
    (irradiance, ("solar_irradiance", "direct_irradiance", "diffuse_irradiance")),
    (path, ("path_radiance", "path_radiance_thermal")),
    (sky, ("sky_up", "thermal_sky_up")),
    (coupling, ("spherical_albedo", "diffuse_view_transmission", "diffuse_return_up")),
    (sky_map, ("sky",)),
    (aureole, ("sky",)),
    (thermal_sky, ("thermal_sky",)),
]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        data = json.load(file)
    if data.get("thermal_sky") and not data["thermal_sky"]["curves"]:
        del data["thermal_sky"]
    panels = [draw for draw, needs in PANELS if any(name in data for name in needs)]
    columns = min(3, max(1, len(panels)))
    rows = max(1, -(-len(panels) // columns))
    figure = plt.figure(figsize=(5.4 * columns, 4.1 * rows + 0.5), layout="constrained")
    where = f"target {data['target_height_m']:g} m, view zenith {data['view_zenith_deg']:g} deg"
    grid = figure.add_gridspec(rows, columns)
    for index, draw in enumerate(panels):
        place = grid[index // columns, index % columns]
        if draw is sky_map:
            sky_map(figure, place, data)
        else:
            draw(figure.add_subplot(place), data, where)
    figure.suptitle(
        f"{data['title']}: sun zenith {data['sun_zenith_deg']:g} deg, sensor at {data['sensor_height_m']:g} m"
    )
    figure.savefig(sys.argv[2], dpi=100)


if __name__ == "__main__":
    main()
