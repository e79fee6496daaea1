#include "host/experiment/sobol.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "host/base/error.h"
#include "scene_compiler/counter_random.h"

namespace raycube::experiment {
namespace {

constexpr int kBits = 32;
constexpr int kResamples = 400;
constexpr double kRounding = 1e-28;  ///< of the mean's square: a variance below it is that of sums

/// A primitive polynomial and its first directions (Joe and Kuo's new-joe-kuo-6): degree, coefficients, m.
struct Direction {
  int degree;
  std::uint32_t coefficients;
  std::array<std::uint32_t, 7> m;
};
constexpr std::array<Direction, kMostDimensions> kDirections = {{{0, 0, {}},
                                                                 {1, 0, {1}},
                                                                 {2, 1, {1, 3}},
                                                                 {3, 1, {1, 3, 1}},
                                                                 {3, 2, {1, 1, 1}},
                                                                 {4, 1, {1, 1, 3, 3}},
                                                                 {4, 4, {1, 3, 5, 13}},
                                                                 {5, 2, {1, 1, 5, 5, 17}},
                                                                 {5, 4, {1, 1, 5, 5, 5}},
                                                                 {5, 7, {1, 1, 7, 11, 19}},
                                                                 {5, 11, {1, 1, 5, 1, 1}},
                                                                 {5, 13, {1, 1, 1, 3, 11}},
                                                                 {5, 14, {1, 3, 5, 5, 31}},
                                                                 {6, 1, {1, 3, 3, 9, 7, 49}},
                                                                 {6, 13, {1, 1, 1, 15, 21, 21}},
                                                                 {6, 16, {1, 3, 1, 13, 27, 49}},
                                                                 {6, 19, {1, 1, 1, 15, 7, 5}},
                                                                 {6, 22, {1, 3, 1, 15, 13, 25}},
                                                                 {6, 25, {1, 1, 5, 5, 19, 61}},
                                                                 {7, 1, {1, 3, 7, 11, 23, 15, 103}}}};

std::array<std::uint32_t, kBits> directions_of(int dimension) {
  std::array<std::uint32_t, kBits> v{};
  const Direction& d = kDirections[static_cast<std::size_t>(dimension)];
  for (int i = 0; i < kBits; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (d.degree == 0) {
      v[at] = 1u << (kBits - 1 - i);
    } else if (i < d.degree) {
      v[at] = d.m[at] << (kBits - 1 - i);
    } else {
      const std::uint32_t back = v[static_cast<std::size_t>(i - d.degree)];
      v[at] = back ^ (back >> d.degree);
      for (int k = 1; k < d.degree; ++k)
        if (d.coefficients >> (d.degree - 1 - k) & 1u) v[at] ^= v[static_cast<std::size_t>(i - k)];
    }
  }
  return v;
}

/// First and total index of one parameter from base points as they are drawn.
std::pair<double, double> shares(const std::vector<double>& f, std::uint32_t n, int i,
                                 const std::vector<std::uint32_t>& drawn) {
  const auto at = [&](std::size_t block, std::uint32_t j) { return f[block * n + j]; };
  double mean = 0, square = 0;
  for (const std::uint32_t j : drawn) mean += at(0, j) + at(1, j);
  mean /= 2.0 * static_cast<double>(drawn.size());
  for (const std::uint32_t j : drawn) square += std::pow(at(0, j) - mean, 2) + std::pow(at(1, j) - mean, 2);
  const double variance = square / (2.0 * static_cast<double>(drawn.size()));
  double first = 0, total = 0;
  for (const std::uint32_t j : drawn) {
    const double a = at(0, j), b = at(1, j), ab = at(static_cast<std::size_t>(2 + i), j);
    first += (b - mean) * (ab - a), total += (a - ab) * (a - ab);
  }
  const double count = variance > kRounding * mean * mean ? static_cast<double>(drawn.size()) * variance : 0;
  return {first / count, 0.5 * total / count};
}

}  // namespace

double sobol_coordinate(std::uint32_t point, int dimension) {
  const auto v = directions_of(dimension);
  const std::uint32_t gray = point ^ (point >> 1);
  std::uint32_t x = 0;
  for (int i = 0; i < kBits; ++i)
    if (gray >> i & 1u) x ^= v[static_cast<std::size_t>(i)];
  return x * 0x1p-32;
}

std::vector<std::vector<double>> sobol_rows(std::uint32_t base_points, int parameters) {
  if (2 * parameters > kMostDimensions) throw base::Error(base::Fault::bug, "too many parameters for Sobol's sequence");
  const auto k = static_cast<std::size_t>(parameters);
  std::vector<std::vector<double>> a(base_points, std::vector<double>(k)), b = a, out;
  for (std::uint32_t j = 0; j < base_points; ++j)
    for (int i = 0; i < parameters; ++i) {
      a[j][static_cast<std::size_t>(i)] = sobol_coordinate(j + 1, i);
      b[j][static_cast<std::size_t>(i)] = sobol_coordinate(j + 1, parameters + i);
    }
  out.insert(out.end(), a.begin(), a.end());
  out.insert(out.end(), b.begin(), b.end());
  for (std::size_t i = 0; i < k; ++i)
    for (std::uint32_t j = 0; j < base_points; ++j) {
      out.push_back(a[j]);
      out.back()[i] = b[j][i];
    }
  return out;
}

std::vector<SobolIndex> sobol_indices(const std::vector<double>& value, std::uint32_t base_points, int parameters) {
  std::vector<SobolIndex> out;
  std::vector<std::uint32_t> all(base_points);
  for (std::uint32_t j = 0; j < base_points; ++j) all[j] = j;
  for (int i = 0; i < parameters; ++i) {
    SobolIndex one;
    std::tie(one.first, one.total) = shares(value, base_points, i, all);
    std::vector<double> first, total;
    std::vector<std::uint32_t> drawn(base_points);
    for (int r = 0; r < kResamples; ++r) {
      for (std::uint32_t j = 0; j < base_points; ++j)
        drawn[j] = static_cast<std::uint32_t>(scene::counter_uniform(0, static_cast<std::uint64_t>(r), j, 0) *
                                              static_cast<double>(base_points));
      const auto [s, t] = shares(value, base_points, i, drawn);
      if (std::isfinite(s) && std::isfinite(t)) first.push_back(s), total.push_back(t);  // else none of it varies
    }
    std::sort(first.begin(), first.end()), std::sort(total.begin(), total.end());
    const std::size_t count = first.size(), low = count / 40, high = count == 0 ? 0 : count - 1 - low;
    const bool known = count >= kResamples / 2;
    if (known) {
      one.first_low = first[low], one.first_high = first[high];
      one.total_low = total[low], one.total_high = total[high];
    } else {
      one.first_low = one.first_high = one.total_low = one.total_high = std::numeric_limits<double>::quiet_NaN();
    }
    if (!std::isfinite(one.first)) {
      const double none = std::numeric_limits<double>::quiet_NaN();
      one = {none, none, none, none, none, none};
    }
    out.push_back(one);
  }
  return out;
}

}  // namespace raycube::experiment
