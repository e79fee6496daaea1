#include "host/sensors/spread_kernel.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raycube::sensors {
namespace {

constexpr double kTold = 1e-4;   ///< of the largest product of weights: smaller ones are left out
constexpr double kUnseen = 0.1;  ///< of enough_cells
constexpr int kMostCells = 9;
constexpr int kLagrange = 6;

using Complex = std::complex<double>;

/// exp(-2 pi i k n / N), k from -half, n from -(N - 1) / 2.
Eigen::MatrixXcd waves(int half, int count) {
  Eigen::MatrixXcd out(2 * half + 1, count);
  for (int k = -half; k <= half; ++k)
    for (int i = 0; i < count; ++i)
      out(k + half, i) = std::polar(1.0, -2 * std::numbers::pi * k * (i - count / 2) / count);
  return out;
}

/// Weights of all cells, [along][across].
Eigen::MatrixXd weights(const OpticalTransfer& optics, double um, const KernelGrid& grid, std::array<int, 2> half) {
  const double q = grid.cells;
  const std::array<int, 2> count{4 * half[0] + 1, 4 * half[1] + 1};
  Eigen::MatrixXcd transfer(count[1], count[0]);
  for (int v = 0; v < count[1]; ++v)
    for (int u = 0; u < count[0]; ++u) {
      const double fu = q * (u - count[0] / 2) / count[0], fv = q * (v - count[1] / 2) / count[1];
      transfer(v, u) = wanted_transfer(optics, um, grid, fu, fv) / (sinc(fu / q) * sinc(fv / q));
    }
  return (waves(half[1], count[1]) * transfer * waves(half[0], count[0]).transpose()).real();
}

Complex transform(const Taps& taps, double cycles_a_cell) {
  Complex sum = 0;
  const double middle = 0.5 * static_cast<double>(taps.size() - 1);
  for (std::size_t k = 0; k < taps.size(); ++k)
    sum += std::polar(taps[k], 2 * std::numbers::pi * cycles_a_cell * (static_cast<double>(k) - middle));
  return sum;
}

double largest_error(const SpreadKernel& kernel, const OpticalTransfer& optics, double um, const KernelGrid& grid) {
  constexpr int kSteps = 16;
  double worst = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double f = 0.5 * i / kSteps, along = f / grid.lines_of_pixel;
    for (const auto& [fu, fv] : {std::pair{f, 0.0}, std::pair{0.0, along}, std::pair{f, along}})
      worst = std::max(worst, std::abs(kernel.transfer(grid, fu, fv) - wanted_transfer(optics, um, grid, fu, fv)));
  }
  return worst;
}

}  // namespace

Complex wanted_transfer(const OpticalTransfer& optics, double um, const KernelGrid& grid, double fu, double fv) {
  return optics(um, fu, fv * grid.lines_of_pixel) * (grid.moving ? sinc(fv) : 1);
}

Complex SpreadKernel::transfer(const KernelGrid& grid, double fu, double fv) const {
  const double q = grid.cells;
  Complex sum = 0;
  for (const Term& term : terms) sum += transform(term.across, fu / q) * transform(term.along, fv / q);
  return sum * sinc(fu / q) * sinc(fv / q);
}

SpreadKernel make_kernel(const OpticalTransfer& optics, double um, const KernelGrid& grid) {
  const auto reach = optics.reach_px(um);
  SpreadKernel out;
  out.half = {static_cast<int>(std::ceil(reach[0] * grid.cells)),
              static_cast<int>(std::ceil((reach[1] * grid.lines_of_pixel + (grid.moving ? 0.5 : 0)) * grid.cells))};
  Eigen::MatrixXd w = weights(optics, um, grid, out.half);
  w /= w.sum();
  const Eigen::BDCSVD<Eigen::MatrixXd> parts(w, Eigen::ComputeThinU | Eigen::ComputeThinV);
  for (Eigen::Index i = 0; i < parts.singularValues().size(); ++i) {
    const double size = parts.singularValues()[i];
    if (size <= kTold * parts.singularValues()[0]) break;
    SpreadKernel::Term term;
    for (const double value : parts.matrixU().col(i)) term.along.push_back(value * size);
    for (const double value : parts.matrixV().col(i)) term.across.push_back(value);
    out.terms.push_back(std::move(term));
  }
  out.mtf_error = largest_error(out, optics, um, grid);
  return out;
}

Taps shifted(const Taps& taps, double cells, int longer) {
  const double whole = std::floor(cells), part = cells - whole;
  std::array<double, kLagrange> share{};
  for (int i = 0; i < kLagrange; ++i) {
    share[static_cast<std::size_t>(i)] = 1;
    for (int j = 0; j < kLagrange; ++j)
      if (j != i) share[static_cast<std::size_t>(i)] *= (part - (j - 2)) / (i - j);
  }
  Taps out(taps.size() + 2 * static_cast<std::size_t>(longer), 0.0);
  for (std::size_t k = 0; k < taps.size(); ++k)
    for (int i = 0; i < kLagrange; ++i) {
      const int to = static_cast<int>(k) + longer + static_cast<int>(whole) + i - 2;
      if (share[static_cast<std::size_t>(i)] != 0)
        out.at(static_cast<std::size_t>(to)) += taps[k] * share[static_cast<std::size_t>(i)];
    }
  return out;
}

int enough_cells(const OpticalTransfer& optics, double um, double lines_of_pixel, bool moving) {
  for (int cells = 3; cells < kMostCells; cells += 2) {
    const KernelGrid grid{cells, lines_of_pixel, moving};
    double worst = 0;
    for (double f = 0.5 * cells; f <= cells; f += 0.125)
      for (const auto& [u, v] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}})
        worst = std::max(
            worst, std::abs(wanted_transfer(optics, um, grid, (cells - f) * u, (cells - f) * v) * sinc(f / cells) -
                            wanted_transfer(optics, um, grid, f * u, f * v)));
    if (worst <= kUnseen) return cells;
  }
  return kMostCells;
}

}  // namespace raycube::sensors
