// The Voigt profile: a Gaussian of thermal motion folded with a Lorentzian of collisions.
#pragma once

#include <array>
#include <cstddef>

namespace raycube::atmos {

/// Re w(x + iy) for y >= 0, w the complex error function (Faddeeva's); relative error below 5e-11 for y >= 1e-12 (and
/// 3e-14 for |x + iy| < 8). Near the origin the midpoint or trapezoidal rule of step h = sqrt(pi / 12), with the
/// residue of the nearby poles (Matta & Reichel 1971, Math. Comp. 25, 339; Al Azah & Chandler-Wilde 2021, SIAM J.
/// Numer. Anal. 59, 2346); further out Gauss- Hermite rules of 8, 6, 4, 2 nodes. Every term of every rule is positive,
/// so weak wings keep their digits.
double faddeeva_real(double x, double y);

/// Profile of one line, cm, whose integral over wavenumber (cm-1) is 1.
class VoigtProfile {
 public:
  /// Half widths at half maximum, cm-1: doppler > 0, lorentz >= 0.
  VoigtProfile(double doppler_per_cm, double lorentz_per_cm);
  double operator()(double offset_per_cm) const { return factor_ * faddeeva_real(offset_per_cm * scale_, y_); }

 private:
  double scale_, y_, factor_;
};

/// v0 3.5812e-7 sqrt(T / M): sqrt(2 k ln 2 / m) / c.
double doppler_half_width_per_cm(double wavenumber_per_cm, double temperature_K, double molar_mass_g);

}  // namespace raycube::atmos
