#include "host/lidar/pulse_moments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

namespace raycube::lidar {
namespace {

constexpr int kMostCells = 16;
constexpr double kEnough = 2e-6;  ///< of the largest share
/// Shares below 0 that are still a float's rounding, of the largest: a pulse takes no light away.
constexpr double kLeast = -1e-9;
using Powers = Eigen::Matrix<double, RC_MOMENTS, RC_MOMENTS>;

/// Phases of the table that belong to a cell, both ends included, and where they lie in it.
struct Cell {
  Cell(int number, int cells, int phases) : number_(number), cells_(cells), phases_(phases) {}
  int first() const { return (number_ * phases_ + cells_ - 1) / cells_; }
  int last() const { return (number_ + 1) * phases_ / cells_; }
  double place(int phase) const { return static_cast<double>(phase) * cells_ / phases_ - number_ - 0.5; }

 private:
  int number_, cells_, phases_;
};

/// The phases nearest to Chebyshev's nodes of a cell.
std::array<int, RC_MOMENTS> nodes_of(const Cell& cell) {
  std::array<int, RC_MOMENTS> nodes{};
  for (int j = 0; j < RC_MOMENTS; ++j) {
    const double at = 0.5 - 0.5 * std::cos(M_PI * (j + 0.5) / RC_MOMENTS);
    nodes[static_cast<std::size_t>(j)] =
        cell.first() + static_cast<int>(std::lround(at * (cell.last() - cell.first())));
  }
  return nodes;
}

/// [RC_MOMENTS][taps] of a cell; none where some phase is missed.
std::optional<std::vector<float>> fit(const PulseTaps& taps, const Cell& cell, double enough) {
  const auto nodes = nodes_of(cell);
  if (std::adjacent_find(nodes.begin(), nodes.end()) != nodes.end()) return {};
  Powers powers;
  for (int j = 0; j < RC_MOMENTS; ++j)
    for (int k = 0; k < RC_MOMENTS; ++k) powers(j, k) = std::pow(cell.place(nodes[static_cast<std::size_t>(j)]), k);
  const Powers inverse = powers.inverse();
  const auto share = [&](int phase, int i) {
    return static_cast<double>(taps.share[static_cast<std::size_t>(phase) * static_cast<std::size_t>(taps.taps) +
                                          static_cast<std::size_t>(i)]);
  };
  std::vector<float> out(static_cast<std::size_t>(RC_MOMENTS * taps.taps));
  for (int i = 0; i < taps.taps; ++i) {
    Eigen::Matrix<double, RC_MOMENTS, 1> at_nodes;
    for (int j = 0; j < RC_MOMENTS; ++j) at_nodes(j) = share(nodes[static_cast<std::size_t>(j)], i);
    const Eigen::Matrix<double, RC_MOMENTS, 1> factor = inverse * at_nodes;
    for (int phase = cell.first(); phase <= cell.last(); ++phase) {
      double sum = 0;
      for (int k = RC_MOMENTS - 1; k >= 0; --k) sum = sum * cell.place(phase) + factor(k);
      if (!(std::abs(sum - share(phase, i)) <= enough && sum >= enough * (kLeast / kEnough))) return {};
    }
    for (int k = 0; k < RC_MOMENTS; ++k)
      out[static_cast<std::size_t>(k * taps.taps + i)] = static_cast<float>(factor(k));
  }
  return out;
}

}  // namespace

PulseMoments make_moments(const PulseTaps& taps) {
  const double enough = kEnough * static_cast<double>(*std::max_element(taps.share.begin(), taps.share.end()));
  for (int cells = 1; cells <= kMostCells; cells *= 2) {
    PulseMoments out;
    for (int c = 0; c < cells; ++c) {
      const auto cell = fit(taps, Cell(c, cells, taps.phases), enough);
      if (!cell) break;
      out.share.insert(out.share.end(), cell->begin(), cell->end());
      out.cells = c + 1;
    }
    if (out.cells == cells) return out;
  }
  return {};
}

}  // namespace raycube::lidar
