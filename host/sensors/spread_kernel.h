// The point spread of one band on a grid of cells, as a short sum of products of a row's and a column's weights.
//
// A cell is the mean of its samples, so that the grid shows the ground times sinc(fu / q) sinc(fv / q), q cells a
// pixel. Weights w whose transform is T over that, for frequencies below q / 2 cycles a pixel, make of it an image with
// the transfer T, exactly where the ground holds nothing finer; a pixel's box comes out as q equal weights. What is
// finer than q / 2 is seen as T(q - f) sinc(f / q) instead of T(f). Weights end at the spread's reach and are made to
// sum to 1: what that costs is in `mtf_error`. A singular-value decomposition writes the square of weights as few
// products: one for Gaussians, boxes and smear, four to eight for diffraction.
#pragma once

#include <array>
#include <complex>
#include <string>
#include <vector>

#include "host/sensors/optical_transfer.h"

namespace raycube::sensors {

/// What a kernel is made for.
struct KernelGrid {
  std::array<int, 2> cells{3, 3};  ///< of a pixel across, of a line along; odd
  double lines_of_pixel = 1;       ///< along: a pixel's length over the lines' distance
};

/// Weights of one axis, from -half on.
using Taps = std::vector<double>;

struct SpreadKernel {
  struct Term {
    Taps across, along;
  };
  std::vector<Term> terms;
  std::array<int, 2> half{};  ///< cells on either side of the middle, across and along
  double share_of_draws = 0;  ///< what independent errors of the cells leave in a pixel: root of the sum of the squares
  double mtf_error = 0;       ///< largest |transfer - T| up to half a cycle a pixel, across, along and aslant

  /// What the weights and the cells make of a wave; cycles a pixel across, a line along.
  std::complex<double> transfer(const KernelGrid& grid, double fu, double fv) const;
};

/// T as the grid has it: cycles a pixel across, a line along.
std::complex<double> wanted_transfer(const OpticalTransfer& optics, double um, const KernelGrid& grid, double fu,
                                     double fv);

/// Cells on either side of a kernel's middle, across and along. Throws Error(input), which begins with `what`, where
/// the spread reaches farther than kMostHalf cells.
std::array<int, 2> kernel_half(const OpticalTransfer& optics, double um, const KernelGrid& grid,
                               const std::string& what);
/// Refuses what kernel_half does.
SpreadKernel make_kernel(const OpticalTransfer& optics, double um, const KernelGrid& grid, const std::string& what);
inline constexpr int kMostHalf = 250;

/// Weights that look `cells` farther on: each neighbour's by Lagrange's polynomial through six, at most 0.5 % off a
/// wave of six cells (half a cycle a pixel at q = 3), 1e-4 off one of twelve. kShiftReach longer on either side, and by
/// the whole cells.
Taps shifted(const Taps& taps, double cells, int longer);
inline constexpr int kShiftReach = 3;

/// The fewest odd cells a pixel, 3 to 9, at which what is finer than they see counts as 0.1 at most instead of T.
int enough_cells(const OpticalTransfer& optics, double um);

}  // namespace raycube::sensors
