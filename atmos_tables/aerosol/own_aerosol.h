// An aerosol of the user's own: its extinction against height, and its optics against wavelength.
#pragma once

#include <memory>

#include "atmos_tables/aerosol/height_profile.h"
#include "atmos_tables/aerosol/particle_optics.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

/// Shape of the extinction against height between the ground and the top of the air, km above the sea: exp(-(z -
/// ground) / scale height) up to 30 scale heights, or the heights stated. Not yet scaled to a depth.
HeightProfile own_heights(const scene::OwnAerosolSpec& aerosol, double ground_km, double top_km);

/// As stated: extinction by Angstrom's law, (wavelength / 0.55 um)^-exponent (Angstrom 1929, Geogr. Ann. 11, 156), or
/// by a power law between the wavelengths of a table; albedo, asymmetry and moments constant, or linear between them.
/// Or by Mie's series: a sum at each wavelength of the index table and, so that it is smooth, at others between, no two
/// more than a factor of 1.1 apart, with n and k linear in wavelength; an index for all wavelengths holds from 0.2 to
/// 40 um. Throws Error(input) where wavelengths do not cover 0.55 um, where moments make a phase function that is
/// negative by more than 0.01 (its mean is 1), and for what droplet_optics.h refuses.
std::shared_ptr<const ParticleOptics> own_optics(const scene::OwnAerosolSpec& aerosol);

}  // namespace raycube::atmos
