#include <algorithm>
#include <cmath>

#include "host/reference/lidar_compare.h"

namespace raycube::reference {

namespace {

/// A member of `sums` against replicas other than itself.
struct Group {
  double own = 0, mean = 0, variance = 0, count = 0;
  bool normal() const { return mean > 0 && variance > 0 && variance < 0.04 * mean * mean; }  ///< noise below 20 %
  double t2() const { return variance > 0 ? (own - mean) * (own - mean) / (variance * (1 + 1 / count)) : 0; }
};

Group group_of(const std::vector<std::vector<double>>& sums, std::size_t member, std::size_t from, std::size_t to) {
  std::vector<double> others;
  Group g;
  for (std::size_t r = 0; r < sums.size(); ++r) {
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) sum += sums[r][i];
    if (r == member)
      g.own = sum;
    else if (r > 0)
      others.push_back(sum);
  }
  g.count = static_cast<double>(others.size());
  for (const double x : others) g.mean += x / g.count;
  for (const double x : others) g.variance += (x - g.mean) * (x - g.mean) / (g.count - 1);
  return g;
}

}  // namespace

LidarScattered compare_scattered(const std::vector<std::vector<double>>& sums, const scene::Lidar& lidar) {
  LidarScattered out;
  if (sums.size() < 8) return out;
  const std::size_t bins = static_cast<std::size_t>(lidar.gate.bins), lines = sums[0].size() / bins;
  // Neighbouring bins share a pulse's light: groups are several pulses wide, and wide enough for the noise to be
  // normal.
  const auto least = static_cast<std::size_t>(std::max(4.0, std::ceil(4 * lidar.pulse.fwhm_s / lidar.gate.bin_s)));
  std::vector<double> chi(sums.size(), 0.0);
  for (std::size_t line = 0; line < lines; ++line)
    for (std::size_t from = line * bins, to = from; to < (line + 1) * bins; from = to) {
      do to = std::min(to + least, (line + 1) * bins);
      while (to < (line + 1) * bins && !group_of(sums, 0, from, to).normal());
      if (!group_of(sums, 0, from, to).normal()) continue;
      ++out.groups;
      for (std::size_t member = 0; member < sums.size(); ++member) chi[member] += group_of(sums, member, from, to).t2();
    }
  const Group all = group_of(sums, 0, 0, lines * bins);
  out.energy_ratio = all.mean > 0 ? all.own / all.mean : 1;
  out.energy_z = all.own == all.mean ? 0 : std::copysign(std::sqrt(all.t2()), all.own - all.mean);
  if (out.groups == 0) return out;
  // Lines share draws and pulses share bins, so groups are not independent: how far the sum may go is told by the
  // replicas' own.
  double mean = 0, variance = 0;
  for (std::size_t r = 1; r < chi.size(); ++r) mean += chi[r] / all.count;
  for (std::size_t r = 1; r < chi.size(); ++r) variance += (chi[r] - mean) * (chi[r] - mean) / (all.count - 1);
  out.chi_square = chi[0] / static_cast<double>(out.groups);
  out.chi_z = variance > 0 ? (chi[0] - mean) / std::sqrt(variance * (1 + 1 / all.count)) : 0;
  return out;
}

}  // namespace raycube::reference
