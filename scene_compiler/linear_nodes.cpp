#include "scene_compiler/linear_nodes.h"

#include <algorithm>
#include <cmath>

namespace raycube::scene {
namespace {

class Between {
 public:
  Between(const std::vector<double>& x, const std::vector<std::vector<double>>& rows) : x_(x), rows_(rows) {}

  /// Sum of squares of what the rows strictly between two kept ones are off their line; the worst row of them.
  double off(std::size_t low, std::size_t high, std::size_t* worst = nullptr) const {
    double sum = 0, most = -1;
    for (std::size_t i = low + 1; i < high; ++i) {
      const double f = (x_[i] - x_[low]) / (x_[high] - x_[low]);
      double here = 0;
      for (std::size_t k = 0; k < rows_[i].size(); ++k) {
        const double apart = rows_[i][k] - (1 - f) * rows_[low][k] - f * rows_[high][k];
        here += apart * apart;
      }
      if (worst && here > most) most = here, *worst = i;
      sum += here;
    }
    return sum;
  }

 private:
  const std::vector<double>& x_;
  const std::vector<std::vector<double>>& rows_;
};

/// Adds a row where it lowers the error most: the worst row of the piece that errs most.
void add_one(std::vector<std::size_t>& kept, const Between& between) {
  double most = -1;
  std::size_t piece = 0, row = 0;
  for (std::size_t i = 0; i + 1 < kept.size(); ++i) {
    std::size_t worst = 0;
    const double here = between.off(kept[i], kept[i + 1], &worst);
    if (kept[i + 1] - kept[i] > 1 && here > most) most = here, piece = i, row = worst;
  }
  kept.insert(kept.begin() + static_cast<std::ptrdiff_t>(piece) + 1, row);
}

/// Moves each inner row to where its two pieces err least, until none moves.
void settle(std::vector<std::size_t>& kept, const Between& between) {
  constexpr int kMostRounds = 8;
  bool moved = true;
  for (int round = 0; moved && round < kMostRounds; ++round) {
    moved = false;
    for (std::size_t i = 1; i + 1 < kept.size(); ++i) {
      std::size_t best = kept[i];
      double least = between.off(kept[i - 1], best) + between.off(best, kept[i + 1]);
      for (std::size_t at = kept[i - 1] + 1; at < kept[i + 1]; ++at) {
        const double here = between.off(kept[i - 1], at) + between.off(at, kept[i + 1]);
        if (here < least) least = here, best = at;
      }
      moved |= best != kept[i];
      kept[i] = best;
    }
  }
}

}  // namespace

LinearNodes linear_nodes(const std::vector<double>& x, const std::vector<std::vector<double>>& rows, std::size_t most,
                         double enough) {
  LinearNodes out;
  out.row = {0};
  if (rows.size() < 2) return out;
  out.row.push_back(rows.size() - 1);
  const Between between(x, rows);
  double squares = 0;
  for (const auto& row : rows)
    for (const double value : row) squares += value * value;
  for (;;) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < out.row.size(); ++i) sum += between.off(out.row[i], out.row[i + 1]);
    out.error = squares > 0 ? std::sqrt(sum / squares) : 0;
    if (out.error <= enough || out.row.size() == most || out.row.size() == rows.size()) return out;
    add_one(out.row, between);
    settle(out.row, between);
  }
}

}  // namespace raycube::scene
