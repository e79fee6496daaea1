"""Band list of the nominal thermal instrument; those of the published ones are files of scenes/sensors."""


def lwir_45():
    """Rows (center_nm, fwhm_nm) of a nominal thermal imaging spectrometer: 8.05 to 12.45 um in steps of its widths."""
    return [(round(8050.0 + 100.0 * i, 1), 100.0) for i in range(45)]
