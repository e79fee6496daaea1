// Standard error of a pixel's radiance from the spread of four interleaved parts of its own samples, and what it is
// held against.
//
// The parts are no independent draws. Where edges cross a pixel the error of n even points falls as n^-3/4 instead of
// n^-1/2, so that the whole is nearer to the truth than four independent parts would be; but edges along the rows of a
// regular grid meet all of its parts alike. Over independent parts the park's pixels ask for factors of 0.4 to 0.85
// with a lattice, 0.5 to 0.9 with jittered samples and 0.35 to 1.1 with a grid (docs/accuracy.md); taken are 0.7, 0.85
// and 0.85. Of jittered samples 1 would be exact where the texture is finer than the cells. The noise of the sky is in
// it, since each part sends a quarter of the rays: of that 0.84 to 1.28 is stated under leaves by 64 seeds (test
// render_sky_error), as rays of one sequence err less together than four independent parts of them would.
#pragma once

#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::render {

/// What the spread of independent draws counts for where that of samples counts as it is: paths of light between
/// surfaces.
double spread_of_draws(scene::SamplerKind sampler);

/// Standard error over the root of the sum of the four parts' squared distances from the whole.
double error_of_spread(scene::SamplerKind sampler);

/// Radiance that errors of each band are held against: its mean over the scene, at least 1e-4 of the largest band's
/// (the error of a band that `tolerance` means).
std::vector<float> error_scale(const std::vector<double>& band_means);

/// Largest error of a pixel's bands, each over its scale; NaN when one is not known.
float worst_error(const float* band_error, const std::vector<float>& scale);

}  // namespace raycube::render
