// What a smooth facet mirrors of unpolarised light, by Fresnel's law (Born & Wolf, Principles of Optics, 7th ed., 14.2)
// for an index n + i k that changes with wavelength, as a sum of four functions of the angle, of which only the factors
// know the wavelength:
//   F(l, c) = F0(l) (1 - s) + s - b(l) c (1 - c)^8 - d(l) c (1 - c)^3,   s = (1 - c)^5, c the cosine of incidence
// F0 and grazing incidence are exact, b and d fitted by least squares over c: off by 0.006 at most of glasses, water,
// gold, copper, iron, titanium in the visible and near infrared, 0.014 of silicon, 0.023 of aluminium at 0.8 um, all
// towards the horizon (test fresnel); Schlick's term alone by 0.02 to 0.2.
#pragma once

#include <array>

namespace raycube::scene {

/// Share of light that a facet mirrors at a cosine of incidence in 0..1; n > 0, k >= 0.
double fresnel_mirrored(double n, double k, double cosine);

/// F0, 1, -b, -d of an index: what the functions of kernels/materials/gloss.h are multiplied by, in their order.
std::array<double, 4> fresnel_factors(double n, double k);

}  // namespace raycube::scene
