#include "host/sensors/spread_kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/symmetric_modes.h"

namespace raycube::sensors {
namespace {

constexpr double kTold = 1e-4;   ///< of the largest product of weights: smaller ones are left out
constexpr double kUnseen = 0.1;  ///< of enough_cells
constexpr int kMostAcross = 9;
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
  const double qu = grid.cells[0], qv = grid.cells[1];
  const std::array<int, 2> count{4 * half[0] + 1, 4 * half[1] + 1};
  Eigen::MatrixXcd transfer(count[1], count[0]);
  for (int v = 0; v < count[1]; ++v)
    for (int u = 0; u < count[0]; ++u) {
      const double fu = qu * (u - count[0] / 2) / count[0], fv = qv * (v - count[1] / 2) / count[1];
      transfer(v, u) = wanted_transfer(optics, um, grid, fu, fv) / (sinc(fu / qu) * sinc(fv / qv));
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

/// The singular-value decomposition of w, largest products first. Its right vectors are the modes of w^T w, which hold
/// a product of kTold of the largest to 1e-16 / kTold^2 of itself; Eigen's own decomposition, good to 1e-16 of the
/// largest, takes 25 s to compile.
std::vector<SpreadKernel::Term> products_of(const Eigen::MatrixXd& w) {
  base::SymmetricModes modes;
  modes.compute(w.transpose() * w);
  std::vector<SpreadKernel::Term> out;
  double largest = 0;
  for (Eigen::Index i = w.cols(); i-- > 0;) {
    const Eigen::VectorXd across = modes.eigenvectors().col(i), along = w * across;
    largest = std::max(largest, along.norm());
    if (along.norm() <= kTold * largest) break;
    out.push_back({{across.begin(), across.end()}, {along.begin(), along.end()}});
  }
  return out;
}

}  // namespace

Complex wanted_transfer(const OpticalTransfer& optics, double um, const KernelGrid& grid, double fu, double fv) {
  return optics(um, fu, fv * grid.lines_of_pixel);
}

Complex SpreadKernel::transfer(const KernelGrid& grid, double fu, double fv) const {
  const double u = fu / grid.cells[0], v = fv / grid.cells[1];
  Complex sum = 0;
  for (const Term& term : terms) sum += transform(term.across, u) * transform(term.along, v);
  return sum * sinc(u) * sinc(v);
}

std::array<int, 2> kernel_half(const OpticalTransfer& optics, double um, const KernelGrid& grid,
                               const std::string& what) {
  const auto reach = optics.reach_px(um);
  const std::array<double, 2> far{reach[0] * grid.cells[0], reach[1] * grid.lines_of_pixel * grid.cells[1]};
  if (std::max(far[0], far[1]) > kMostHalf)
    throw base::Error(
        base::Fault::input,
        fmt::format("{}: its point spread at {:.4g} um reaches {:.0f} pixels, {:.0f} cells of a pixel's "
                    "{}; at most {} can be: narrow it, or lower oversampling",
                    what, um, std::max(reach[0], reach[1]), std::max(far[0], far[1]), grid.cells[0], kMostHalf));
  std::array<int, 2> half{};
  for (std::size_t axis = 0; axis < 2; ++axis)
    half[axis] = std::max(static_cast<int>(std::ceil(far[axis])), grid.cells[axis] / 2);
  return half;
}

SpreadKernel make_kernel(const OpticalTransfer& optics, double um, const KernelGrid& grid, const std::string& what) {
  SpreadKernel out;
  out.half = kernel_half(optics, um, grid, what);
  Eigen::MatrixXd w = weights(optics, um, grid, out.half);
  w /= w.sum();
  out.terms = products_of(w);
  out.share_of_draws = w.norm();
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

int enough_cells(const OpticalTransfer& optics, double um) {
  for (int cells = 3; cells < kMostAcross; cells += 2) {
    double worst = 0;
    for (double f = 0.5 * cells; f <= cells; f += 0.125)
      for (const auto& [u, v] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}})
        worst = std::max(
            worst, std::abs(optics(um, (cells - f) * u, (cells - f) * v) * sinc(f / cells) - optics(um, f * u, f * v)));
    if (worst <= kUnseen) return cells;
  }
  return kMostAcross;
}

}  // namespace raycube::sensors
