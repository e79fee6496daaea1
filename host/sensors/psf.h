// Weight of each sample of a pixel.
#pragma once

#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::sensors {

/// One weight per sample s, in the order of rc_sample_uv, sum 1. Sensor response = detector box of one pixel convolved with
/// the optics' Gaussian of psf_sigma_px, cut to the sampled square of psf_support_px and renormalised; each weight is the
/// response's exact integral over the sample's cell (closed form). Uniform weights for the plain box (sigma 0, support 1).
/// Throws Error(input) for a point spread with the lattice (its shifted points have no cells) and for a support that
/// cuts more than 1 % of the response: need psf_support_px >= 1 + 5 sigma or so.
std::vector<float> psf_weights(const scene::Instrument& instrument);

}  // namespace raycube::sensors
