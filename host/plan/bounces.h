// Light between surfaces, planned: the wavelengths that paths carry, what lies between them, and how surfaces scatter.
#pragma once

#include <string_view>

#include "host/plan/plan.h"

namespace raycube::plan {

inline constexpr std::string_view kBetweenSurfaces = "light between surfaces: ";  ///< that notices of it begin with

/// Curves of the used materials at some wavelengths, [curve - 1][padded to 16]; of all others zero.
std::vector<float> sampled_curves(const scene::CompiledScene& scene, const std::vector<double>& at_um);

/// How paths leave every surface, as Bounces::scattering, for such curves at `count` wavelengths.
std::vector<shared::rc_float4> surface_scattering(const scene::CompiledScene& scene, const std::vector<float>& curve,
                                                  std::size_t count);

inline constexpr double kMostAmplified = 4;  ///< that the skeleton may make of noise before it is told

/// Fills plan.bounces, and plan.sky.rays by `paths` where no rays go to the sky, for `levels` surfaces after the first;
/// nothing where that is 0, or where there are no sources. The plan has its grid, its bands and its sources.
///
/// Whatever the geometry, light of one source scattered n times is S(l) F(c_1(l), ..) with F a power series in the
/// curves whose coefficients know no wavelength; so it lies close to a space of few dimensions over l, and so does that
/// of all sources over their light together, each by its share of that, at the middle of the heights. So is what matter
/// sends by itself beyond the surroundings, scattered once and more. Training rows are products of 2 (1) to levels + 1
/// of the scene's curves, 8 at most (with R + T of leaves), and of one share, all of them or 600 drawn; wavelengths are
/// picked one after the other where what is left of the rows is largest (column-pivoted QR by modified Gram-Schmidt:
/// Golub & Van Loan, Matrix Computations, 4th ed., 5.4.2), and F(l) = sum_m basis[m][l] F(l_m) by least squares over
/// the rows. As many as it takes until products that the fit has not seen err by at most `share` of what one of their
/// curves shows by itself, rms over the products that it is in, of the worst curve and band; 128 at most, and all of a
/// shorter grid.
void plan_bounces(Plan& plan, const scene::CompiledScene& scene, int levels, int paths, double share);
/// The same plan without light between surfaces. It bakes its own rows: a plate's are others with paths.
Plan without_paths(const Plan& plan);
/// After it: notices of what cameras do not see through plates, and of what thermal light says of matter.
void tell_of_matter(Plan& plan, const scene::Instrument& instrument);

}  // namespace raycube::plan
