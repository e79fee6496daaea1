// Runs of 6S and 6SV as a spectrum: each says all of one band or wavelength, and many of them make a table.
#pragma once

#include <vector>

#include "atmos_tables/import/sample_book.h"

namespace raycube::atmos::imported {

/// The files, their 6S runs of one band or wavelength put together: one run per view and sensor, mode "joined", in
/// ascending order of wavelength, with the columns that all of them have. Throws Error(input) where two runs of one
/// view are of one wavelength.
std::vector<Imported> with_bands_joined(const std::vector<Imported>& files);

/// With Tg the gas transmittances, T those of scattering, tau the optical depth of scattering between target and sensor
/// and mu the cosine of the view zenith:
///   T_view = Tg_up exp(-tau / mu),  t_dif = Tg_up T_up - T_view,  T_sun = E_dir / (E0 mu0),
///   R2 = Tg_total / (Tg_down Tg_up), path radiance, E_dif and S as printed.
/// Ground light is then R2 (T_view + t_dif) (E_dir + E_dif) r / (1 - r S) / pi, which is 6S's own Tg_total T_down T_up
/// E0 mu0 r / (1 - r S) / pi. Means of a band are taken as 6S takes them: the product of means.
void add_joined_bands(const Source& source, SampleBook& book);

/// A table by wavelength (iwave -2) has direct and diffuse light in one number: what a render lacks of it is reported,
/// or noted where a part of a table was asked for.
void add_wavelength_table(const Source& source, SampleBook& book);

}  // namespace raycube::atmos::imported
