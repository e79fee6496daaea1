// Transfer function of a focal plane: what of a wave on the ground is left in its image.
//
// T(fu, fv) is the product of what each part leaves, in cycles a pixel across and along (scene::FocalPlane):
//   Gaussian       exp(-2 pi^2 (su^2 fu^2 + sv^2 fv^2)), and the same of jitter
//   diffraction    of an annular aperture (O'Neill 1956, "Transfer function for an annular aperture", J. Opt. Soc.
//                  Am. 46, 285, eq. 26) at f / fc, fc = pitch / (wavelength f_number)
//   spread         2 pi integral h(r) J0(2 pi f r) r dr over that at f = 0, h linear between rings; of a grid its
//                  Fourier sum, which is complex where the spread is not symmetric
//   detector       sinc(du fu) sinc(dv fv), sinc x = sin(pi x) / (pi x); the same of smear
// T(0, 0) = 1. Wavelengths between those of rings: linear in T.
#pragma once

#include <complex>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::sensors {

/// MTF of diffraction at f / fc of an aperture whose middle is hidden up to `obscuration` of its diameter; 0 past 1.
double diffraction_mtf(double of_cutoff, double obscuration);

/// sin(pi x) / (pi x).
double sinc(double x);

class OpticalTransfer {
 public:
  /// highest: cycles a pixel along any axis that will be asked for. Keeps a reference.
  OpticalTransfer(const scene::FocalPlane& plane, double highest);

  /// At a wavelength; frequencies in cycles a pixel.
  std::complex<double> operator()(double um, double fu, double fv) const;

  /// Farther from its middle than this, in pixels across and along, the spread has no part that counts: Gaussians end
  /// at 4.5 standard deviations (7e-6), diffraction after 20 wavelengths times the f-number over 1 - obscuration (1 %
  /// of the light).
  std::array<double, 2> reach_px(double um) const;

 private:
  double rings(double um, double f) const;
  std::complex<double> grid(double fu, double fv) const;

  const scene::FocalPlane& plane_;
  double step_ = 0;
  std::vector<std::vector<double>> rings_;  ///< [wavelength][i]: at i step_
};

}  // namespace raycube::sensors
