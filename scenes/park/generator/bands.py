"""Band lists of the instruments.

SpecTIR ProSpecTIR-VS as far as published: Bloechl et al. 2014 (Proc. SPIE 9088, 90880G) name 360 bands over 400-2450 nm
and bands 19 = 482, 25 = 509, 26 = 514, 35 = 555, 55 = 648 nm, which 394.8 + 4.6 n reproduces to 1 nm. That runs to band
125 at 969.8 nm; the other 235 follow in steps of 6.3 nm and end at 2450.3 nm. Widths are nominal: one centre distance.
"""

import numpy as np


def spectir_360():
    """Rows (center_nm, fwhm_nm), ascending, 360 of them."""
    vnir = 394.8 + 4.6 * np.arange(1, 126)
    swir = vnir[-1] + 6.3 * np.arange(1, 236)
    return [(round(float(c), 3), 4.6) for c in vnir] + [(round(float(c), 3), 6.3) for c in swir]


def wasp_rgb():
    """(wavelength_nm, blue, green, red) every 5 nm, nominal: no measured response of the WASP colour camera is
    published.
    Smooth curves like those of silicon Bayer cameras: skewed Gaussians with the small overlaps such dyes have, cut by a
    400-700 nm blocking filter."""
    wavelength = np.arange(385.0, 715.1, 5.0)

    def skewed(peak, left, right):
        sigma = np.where(wavelength < peak, left, right) / 2.355
        return np.exp(-0.5 * ((wavelength - peak) / sigma) ** 2)

    edge = 1 / (1 + np.exp(-(wavelength - 412) / 4.5)) / (1 + np.exp((wavelength - 688) / 5.0))
    blue = (skewed(455, 80, 95) + 0.05 * skewed(540, 90, 90)) * edge
    green = (skewed(532, 88, 96) + 0.04 * skewed(660, 80, 80)) * edge
    red = (skewed(602, 56, 125) + 0.06 * skewed(520, 90, 70) + 0.03 * skewed(420, 40, 40)) * edge
    rows = np.stack([wavelength, blue / blue.max(), green / green.max(), red / red.max()], axis=1)
    return np.where(rows < 5e-5, 0.0, rows)


def lwir_45():
    """Rows (center_nm, fwhm_nm) of a nominal thermal imaging spectrometer: 8.05 to 12.45 um in steps of its widths."""
    return [(round(8050.0 + 100.0 * i, 1), 100.0) for i in range(45)]
