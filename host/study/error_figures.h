// How far a cube is from the converged one: the error that `tolerance` means, and its companions.
#pragma once

#include <cstddef>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::study {

/// Converged radiances of some pixels with how far each may still be off. [pixel][band], W m-2 sr-1 um-1.
struct Converged {
  std::size_t bands = 0;
  std::vector<double> radiance;  ///< mean of two independent halves
  /// (first half - second half) / 2: its square has the variance of the mean as its expectation.
  std::vector<double> half;
  /// By which error pixels are judged, and by how much each counts; no weights: all alike.
  scene::ErrorFigure figure = scene::ErrorFigure::rms;
  std::vector<float> weight = {};
  std::size_t pixels() const { return bands ? radiance.size() / bands : 0; }
};

/// Of a band: the reference's figure over pixels of (L - L_ref), divided by the pixels' mean L_ref in that band, or by
/// 1e-4 of the largest band's mean where that is more.
struct ErrorFigures {
  double worst = 0;      ///< of the worst band: what `tolerance` bounds
  std::size_t band = 0;  ///< the worst, from 0
  double rms = 0;        ///< over pixels and all bands, whatever the figure
  double p95 = 0;        ///< of the worst band: 95th percentile over pixels of |L - L_ref|, divided alike
  double own = 0;        ///< what the reference's own standard error is in that band, by the same figure
  /// Error bar of `worst`: the reference's variance taken off, and one standard error of the rms over these pixels
  /// either way; of a percentile those whose share is one standard error less and more; of the worst pixel the
  /// reference's own worst either way.
  double low = 0, high = 0;
};

/// radiance: [pixel][band] of the same pixels. Throws Error(bug) when the sizes differ.
ErrorFigures error_of(const Converged& reference, const std::vector<float>& radiance);

/// The reference's own standard error by the same definition, worst band.
double own_error(const Converged& reference);

}  // namespace raycube::study
